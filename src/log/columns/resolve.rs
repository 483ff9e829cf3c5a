//! The header of a log and its column map, joined: what each column of the file holds, in which unit.

use super::*;
use crate::error::{Error, Place, Result};
use crate::robot::{JointKind, Robot};

/// A column that is used.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::log) struct Column {
    /// Field number from 0.
    pub index: usize,
    pub meaning: Meaning,
    /// SI per unit as written; 1 for numbers without a unit.
    pub factor: f64,
    /// Unit of the contract per unit as written (1 without a map).
    pub edge: f64,
    /// Cells are dates or times of day, not numbers.
    pub stamp: Option<Stamp>,
    /// Cells that count as empty.
    pub missing: Vec<Missing>,
}

/// The columns that are used, in the order of the file.
pub(in crate::log) fn resolve(
    header: &[String],
    robot: &Robot,
    map: Option<&ColumnMap>,
    at: &Place,
) -> Result<Vec<Column>> {
    let mut used: Vec<Column> = Vec::new();
    let mut mapped = vec![false; map.map_or(0, |m| m.entries.len())];
    for (index, theirs) in header.iter().enumerate() {
        let theirs = theirs.trim();
        let place = || Place { column: Some(index as u64 + 1), ..at.clone() };
        let entry = map.and_then(|m| m.entries.get_full(theirs));
        let (meaning, factor, edge) = match entry {
            Some((k, _, entry)) => {
                mapped[k] = true;
                let Some(ours) = &entry.to else { continue };
                let Some(ours) = of_axis(ours, robot) else { continue };
                from_map(theirs, &ours, entry, robot, map.map_or("", |m| &m.name))?
            }
            None => {
                let m = meaning(theirs, robot);
                if m == Meaning::Other {
                    refuse_unknown_joint(theirs, robot, place)?;
                }
                let si = m.unit(robot).and_then(unit_named).map_or(1.0, |u| u.1);
                (m, si, 1.0)
            }
        };
        if matches!(meaning, Meaning::Other | Meaning::Index) {
            continue;
        }
        let (meaning, per_radian) = meaning.of_joint(robot);
        let factor = factor * per_radian;
        if let Some(before) = used.iter().find(|c| c.meaning == meaning) {
            return Err(Error::bad(
                place(),
                format!("a second column for `{}` (the first is column {})", meaning.name(robot), before.index + 1),
                "one column of each name",
            ));
        }
        let entry = entry.map(|(_, _, e)| e);
        used.push(Column {
            index,
            meaning,
            factor,
            edge,
            stamp: entry.and_then(|e| Stamp::named(e.unit.as_deref()?)),
            missing: entry.map_or_else(Vec::new, |e| e.missing.clone()),
        });
    }
    if let Some(map) = map {
        all_mapped(map, &mapped, header, at)?;
    }
    Ok(used)
}

/// Refuses a header that lacks what the map names: one column of a partial map at least, else all.
fn all_mapped(map: &ColumnMap, mapped: &[bool], header: &[String], at: &Place) -> Result<()> {
    if map.partial && !mapped.contains(&true) {
        let names: Vec<String> = map.entries.keys().cloned().collect();
        let found = format!("none of the columns that {} names among {}", map.name, listed(header));
        return Err(Error::bad(at.clone(), found, listed(&names)));
    }
    if !map.partial
        && let Some(k) = mapped.iter().position(|m| !m)
        && let Some((theirs, _)) = map.entries.get_index(k)
    {
        let found = format!("no column `{theirs}`, which {} names", map.name);
        return Err(Error::bad(at.clone(), found, format!("a column of that name among {}", listed(header))));
    }
    Ok(())
}

/// Our name for a column of a joint by its number: `cmd_#1` is `cmd_A1_deg` of a robot whose first axis is A1. `None`: the robot has
/// fewer axes.
fn of_axis<'a>(ours: &'a str, robot: &Robot) -> Option<std::borrow::Cow<'a, str>> {
    let Some((what, number)) = ours.split_once("_#") else { return Some(ours.into()) };
    let axis = number.parse::<usize>().ok()?.checked_sub(1)?;
    let joint = robot.axis_joints().nth(axis)?;
    Some(crate::log::write::joint_column(what, joint).into())
}

fn from_map(theirs: &str, ours: &str, entry: &Entry, robot: &Robot, map: &str) -> Result<(Meaning, f64, f64)> {
    let m = meaning(ours, robot);
    let place = Place::file(map);
    if m == Meaning::Other {
        let names: Vec<String> = (0..robot.dof()).map(|a| Meaning::Command(a).name(robot)).collect();
        return Err(Error::bad(
            place,
            format!("`{theirs}` to `{ours}`"),
            format!("a name of the log format: t_s, {}, x_mm, y_mm, z_mm, ...", names.join(", ")),
        ));
    }
    let own = m.unit(robot);
    let (si, own_si) = match (entry.unit.as_deref(), own) {
        (None, Some(own)) => (unit_named(own), unit_named(own)),
        (None, None) => (Some((' ', 1.0)), Some((' ', 1.0))),
        (Some(theirs), Some(own)) => (unit_named(theirs), unit_named(own)),
        (Some(_), None) => (None, None),
    };
    match (si, own_si) {
        (Some((dimension, si)), Some((same, own_si))) if dimension == same => {
            Ok((m, si * entry.factor, (si * entry.factor / own_si).abs()))
        }
        _ => Err(Error::bad(
            place,
            format!("unit `{}` for `{ours}`", entry.unit.as_deref().unwrap_or("")),
            match own {
                Some(u) => format!("a unit that converts to {u}"),
                None => "no unit for this column".into(),
            },
        )),
    }
}

/// `cmd_B1_deg` where the robot has no B1, `cmd_A1_rad` where it has an A1.
fn refuse_unknown_joint(theirs: &str, robot: &Robot, place: impl Fn() -> Place) -> Result<()> {
    let name = theirs.to_ascii_lowercase();
    let Some(rest) = ["cmd_", "enc_", "screw_", "meas_"].iter().find_map(|p| name.strip_prefix(p)) else {
        return Ok(());
    };
    let Some((joint, unit)) = rest.rsplit_once('_') else { return Ok(()) };
    if !matches!(unit, "deg" | "mm" | "rad" | "m") || joint.is_empty() {
        return Ok(());
    }
    match robot.joints.iter().find(|j| j.name.eq_ignore_ascii_case(joint)) {
        Some(j) if j.follows.is_some() => Ok(()),
        Some(j) => Err(Error::bad(place(), format!("column `{theirs}`: {} in {unit}", j.name), {
            let what = &theirs[..theirs.len() - rest.len() - 1];
            let angle = matches!(name.as_bytes()[0], b'e' | b's') && j.kind == JointKind::Prismatic;
            let lead =
                if angle && unit == "deg" { ", or `lead_mm_per_rev` of the joint in the robot file" } else { "" };
            format!("`{what}_{}_{}`, or a column map with `unit: {unit}`{lead}", j.name, j.kind.unit())
        })),
        None => Err(Error::bad(
            place(),
            format!("column `{theirs}`: the robot has no joint `{joint}`"),
            format!("one of {}", robot.axis_names().join(", ")),
        )),
    }
}
