//! Where the gap is: over time, on the path, joint by joint in both directions.

use super::super::milli;
use super::scale::GapScale;
use crate::diagnose::Outcome;
use crate::diagnose::result::document::{Diagnosis, Round};
use crate::diagnose::result::traces::{LogTrace, Traces, Way};
use crate::report::{
    HeatPath, HeatPathView, JointWays, Lane, Page, PathMark, StripLog, StripsView, TraceMark, WayView, WaysPanel,
    WaysView,
};
use crate::robot::Robot;

/// Colours reach to this many standard deviations of the noise at least, so that noise is dark.
const QUIET: f64 = 6.0;

pub(super) fn strips(page: &mut Page, robot: &Robot, outcome: &Outcome, d: &Diagnosis, t: &Traces, scale: &GapScale) {
    let axis_of = |r: &Round| r.place.joint.clone().filter(|j| robot.axis_named(j).is_some());
    let scaled = |v: &[f64]| v.iter().map(|v| v * scale.si).collect::<Vec<f64>>();
    let lanes = |l: &LogTrace| {
        if d.rounds.is_empty() {
            return vec![Lane { name: "gap".into(), values: scaled(&l.after), marks: Vec::new() }];
        }
        let mut lanes = vec![Lane { name: "before".into(), values: scaled(&l.before), marks: Vec::new() }];
        lanes.extend(l.effects.iter().zip(&d.rounds).map(|(e, r)| Lane {
            name: format!("{} {}", r.effect, r.target),
            values: scaled(&e.moves),
            marks: axis_of(r).map_or(Vec::new(), |joint| {
                e.turns.iter().map(|&(x, sense)| TraceMark { joint: joint.clone(), x, sense }).collect()
            }),
        }));
        lanes.push(Lane { name: "after".into(), values: scaled(&l.after), marks: Vec::new() });
        lanes
    };
    let logs = t.logs.iter().filter(|l| !l.at.is_empty()).map(|l| StripLog {
        name: if t.logs.len() > 1 { l.name.clone() } else { String::new() },
        x_title: if l.poses { "pose".into() } else { "time, s".into() },
        x: l.at.clone(),
        lanes: lanes(l),
    });
    let noise = outcome.whitening.noise.first().map_or(0.0, |n| n.sigma);
    page.section(
        "The gap along the path",
        if d.rounds.is_empty() {
            "Distance from the predicted to the measured position, as a colour.".to_string()
        } else {
            "Distance from the predicted to the measured position, as a colour: before with the frame alone, after with all effects found; between them the movement by each found effect, with the reversals of its joint if it acts after reversals."
                .to_string()
        },
        StripsView {
            quantity: scale.quantity.into(),
            unit: scale.unit.into(),
            at_least: QUIET * noise * scale.si,
            logs: logs.collect(),
        },
    );
}

pub(super) fn path(page: &mut Page, d: &Diagnosis, t: &Traces, scale: &GapScale) {
    if !t.points {
        return;
    }
    let noise_um = d.noise.sigma_um;
    let mut panels = Vec::new();
    for l in t.logs.iter().filter(|l| !l.points_m.is_empty()) {
        let at_mm: Vec<[f64; 3]> = l.points_m.iter().map(|p| (p * 1e3).into()).collect();
        let of = if t.logs.len() > 1 { format!(", {}", l.name) } else { String::new() };
        let marks = l.effects.iter().zip(&d.rounds).flat_map(|(e, r)| {
            let joint = r.place.joint.clone();
            e.turns.iter().filter_map(move |&(at, sense)| Some((joint.clone()?, at, sense)))
        });
        let marks: Vec<PathMark> = marks
            .filter_map(|(joint, at, sense)| {
                let k = l.at.partition_point(|x| *x < at).min(l.at.len().saturating_sub(1));
                Some(PathMark { joint, at_mm: *at_mm.get(k)?, sense })
            })
            .collect();
        let panel = |title: String, values: &[f64], marks: Vec<PathMark>| HeatPath {
            title,
            at_mm: at_mm.clone(),
            values: values.iter().map(|v| v * scale.si).collect(),
            dots: l.poses,
            marks,
        };
        if !d.rounds.is_empty() {
            panels.push(panel(format!("before{of}"), &l.before, marks));
            panels.push(panel(format!("after{of}"), &l.after, Vec::new()));
        } else {
            panels.push(panel(format!("gap{of}"), &l.after, marks));
        }
    }
    let words = match (panels.iter().any(|p| !p.marks.is_empty()), panels.len()) {
        (true, _) => " All drawings have one scale. Marks: reversals after which a found effect acts.",
        (false, 2..) => " All drawings have one scale.",
        _ => "",
    };
    page.section(
        "Gap along the path in space",
        format!(
            "Path of the TCP in the base frame, in isometric view, coloured by the distance from the predicted to the measured point.{words}"
        ),
        HeatPathView { quantity: "gap at the TCP".into(), unit: "µm".into(), at_least: QUIET * noise_um, panels },
    );
}

pub(super) fn ways(page: &mut Page, robot: &Robot, t: &Traces) {
    let joints: Vec<JointWays> = t
        .joints
        .iter()
        .map(|j| {
            let kind = robot.axis(j.axis).kind;
            let view = |w: &Way, quartiles: &[[f64; 3]]| WayView {
                at_deg_mm: w.position.iter().map(|p| kind.to_user_unit(*p)).collect(),
                quartiles_milli: quartiles.iter().map(|q| q.map(|v| milli(robot, j.axis, v))).collect(),
            };
            let [up, down] = &j.ways;
            let panel = |title: &str, of: fn(&Way) -> &Vec<[f64; 3]>| WaysPanel {
                title: title.into(),
                up: view(up, of(up)),
                down: view(down, of(down)),
            };
            let panels = if j.own {
                vec![panel("without the effects found on it", |w| &w.before), panel("after", |w| &w.after)]
            } else {
                vec![panel("after; nothing was found on it", |w| &w.after)]
            };
            JointWays { joint: robot.axis(j.axis).name.clone(), panels }
        })
        .collect();
    if joints.is_empty() {
        return;
    }
    let how = if t.joints.iter().all(|j| j.measured) {
        "Measured minus predicted joint position over the command."
    } else {
        "The part of the TCP's gap along the lever of the joint, as an angle: e·J / |J|², over the command of the joint. Three coordinates do not determine all joints, so the remaining errors of the other joints also appear here."
    };
    let caption = format!(
        "{how} Effects found elsewhere are removed in all drawings. Medians over bins of position. If both directions agree, the cause is geometry, compliance or the gear; if they differ, it is lost motion or lag."
    );
    page.section("Each joint alone, in both directions", caption, WaysView { joints });
}
