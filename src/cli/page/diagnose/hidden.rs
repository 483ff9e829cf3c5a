//! What the log could not have shown: the smallest size of each effect that would have been seen.

use super::scale::GapScale;
use crate::diagnose::result::document::of_motion;
use crate::diagnose::result::traces::{Hidden, Traces};
use crate::diagnose::result::words;
use crate::effects::{ActsOn, DhParameter, EffectInfo, catalogue};
use crate::report::{MapBlock, MapCell, MapView, Page};
use crate::robot::Robot;

/// Columns of the map for joints: effect (and DH parameter), heading.
fn on_joints() -> Vec<(String, String)> {
    let columns = |info: &&EffectInfo| -> Vec<(String, String)> {
        match info.acts_on {
            ActsOn::Joint => vec![(info.name.into(), info.heading.into())],
            ActsOn::DhParameter(all) => {
                let one =
                    |p: &DhParameter| (format!("{}.{}", info.name, p.text()), format!("{} {}", info.heading, p.text()));
                all.iter().map(one).collect()
            }
            _ => Vec::new(),
        }
    };
    catalogue::ALL.iter().flat_map(columns).collect()
}

pub(super) fn blind(page: &mut Page, robot: &Robot, t: &Traces, scale: &GapScale) {
    if t.hidden.is_empty() {
        return;
    }
    let joints: Vec<&str> = robot.joints.iter().map(|j| j.name.as_str()).collect();
    let mut blocks = vec![joint_block(&joints, t, scale)];
    blocks.extend(coupling_blocks(&joints, t, scale));
    blocks.extend(machine_block(t, scale));
    let none = t.hidden.iter().filter(|h| !h.found && h.moves.is_none()).count();
    let title = match none {
        0 => "What this log cannot show".to_string(),
        1 => "One effect cannot be detected in this log at any size".to_string(),
        n => format!("{n} effects cannot be detected in this log at any size"),
    };
    page.section(
        title,
        format!(
            "The smallest size that would have been detected (false alarm rate 0.001, power 0.8), in the unit of its column. The colour shows the {} that this size causes, rms: the brighter the cell, the larger the error that this log cannot show.",
            scale.unit
        ),
        MapView {
            quantity: "undetected error, rms".into(),
            unit: scale.unit.into(),
            hatched: "not visible at any size".into(),
            by_decades: true,
            blocks,
        },
    );
}

/// An effect on a target; one that was found comes first.
fn find<'a>(t: &'a Traces, effect: &str, target: &str) -> Option<&'a Hidden> {
    let both = || t.hidden.iter().filter(|h| h.effect == effect && h.target == target);
    both().find(|h| h.found).or_else(|| both().next())
}

/// Effects of single joints: a row per joint, a column per effect.
fn joint_block(joints: &[&str], t: &Traces, scale: &GapScale) -> MapBlock {
    let on_joint = |effect: &str, joint: &str| match effect.split_once('.') {
        Some((effect, parameter)) => find(t, effect, &format!("{joint}.{parameter}")),
        None => find(t, effect, joint),
    };
    let on_joints = on_joints();
    let kept: Vec<&(String, String)> =
        on_joints.iter().filter(|(e, _)| joints.iter().any(|j| on_joint(e, j).is_some())).collect();
    let row = |j: &&str| {
        let cells = kept.iter().map(|(e, _)| on_joint(e, j).map_or(MapCell::Absent, |h| cell(h, scale)));
        (j.to_string(), cells.collect())
    };
    MapBlock {
        corner: "joint".into(),
        columns: kept
            .iter()
            .map(|(e, heading)| (heading.to_string(), unit_of(joints.iter().filter_map(|j| on_joint(e, j)))))
            .collect(),
        rows: joints.iter().map(row).collect(),
    }
}

/// Couplings: they show only where both joints move. Effects of several units on pairs of joints have a map for each unit.
fn coupling_blocks(joints: &[&str], t: &Traces, scale: &GapScale) -> Vec<MapBlock> {
    let of_motion = of_motion();
    let rests = |joint: &str| {
        let mut seen = of_motion.iter().filter_map(|e| find(t, e, joint)).peekable();
        seen.peek().is_some() && seen.all(|h| !h.found && h.moves.is_none())
    };
    let of_unit = |h: &Hidden, unit: &str| h.sizes.first().is_none_or(|(k, _)| shown(k).1 == unit);
    let coupled = |to: &str, from: &str, unit: &str| {
        let target = format!("{to}<-{from}");
        t.hidden.iter().filter(|h| h.target == target && of_unit(h, unit)).max_by_key(|h| h.found)
    };
    let block = |unit: &str| {
        let row = |to: &&str| {
            let cells = joints.iter().map(|from| match coupled(to, from, unit) {
                Some(h) => cell(h, scale),
                None if to != from && (rests(to) || rests(from)) => MapCell::Hatched,
                None => MapCell::Absent,
            });
            (to.to_string(), cells.collect())
        };
        MapBlock {
            corner: "coupling of".into(),
            columns: joints.iter().map(|from| (format!("to {from}"), unit.to_string())).collect(),
            rows: joints.iter().map(row).collect(),
        }
    };
    let all: Vec<&Hidden> = t.hidden.iter().filter(|h| h.target.contains("<-")).collect();
    let units = units_of(all.iter().copied());
    if units.is_empty() && !all.is_empty() { vec![block("")] } else { units.into_iter().map(block).collect() }
}

/// Effects of tool, TCP and log.
fn machine_block(t: &Traces, scale: &GapScale) -> Option<MapBlock> {
    let whole: Vec<&Hidden> = t.hidden.iter().filter(|h| matches!(h.target.as_str(), "tool" | "tcp" | "log")).collect();
    if whole.is_empty() {
        return None;
    }
    Some(MapBlock {
        corner: "whole machine".into(),
        columns: whole.iter().map(|h| (h.effect.replace('_', " "), unit_of(std::iter::once(*h)))).collect(),
        rows: vec![(String::new(), whole.iter().map(|h| cell(h, scale)).collect())],
    })
}

/// Unit in which a size is shown, and the factor from its key's.
fn shown(key: &str) -> (f64, &'static str) {
    match words::key(key, "deg").1 {
        "deg" => (1e3, "mdeg"),
        "mm" => (1e3, "µm"),
        "s" => (1e3, "ms"),
        "deg/Nm" => (1e6, "µdeg/Nm"),
        "mm/N" => (1e6, "nm/N"),
        "" => (1e6, "10⁻⁶"),
        "um" => (1.0, "µm"),
        other => (1.0, other),
    }
}

fn unit_of<'a>(all: impl Iterator<Item = &'a Hidden>) -> String {
    units_of(all).join(" or ")
}

/// Units of some effects, each once, in the order in which they first occur.
fn units_of<'a>(all: impl Iterator<Item = &'a Hidden>) -> Vec<&'static str> {
    let mut units: Vec<&str> = Vec::new();
    for unit in all.filter_map(|h| h.sizes.first()).map(|(k, _)| shown(k).1) {
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    units
}

fn cell(h: &Hidden, scale: &GapScale) -> MapCell {
    match (h.sizes.first(), h.moves) {
        _ if h.found => MapCell::Word("found".into()),
        (Some((key, v)), Some(moves)) => {
            let coordinate = |key: &str| matches!(key, "x_mm" | "y_mm" | "z_mm");
            // of a vector the coordinate that is seen worst
            let size = if coordinate(key) {
                h.sizes.iter().filter(|s| coordinate(&s.0)).map(|s| s.1).fold(0.0, f64::max)
            } else {
                *v
            };
            MapCell::Size { text: words::rough(size * shown(key).0), colour: moves * scale.si }
        }
        _ => MapCell::Hatched,
    }
}
