//! Page of `track`: the path, and what the joints do along it.

use crate::error::counted;
use crate::numerics::robust::range;
use crate::report::{Method, Page, PathRun, PathView, Role, Run, TableView, Tile, Tone};
use crate::robot::Robot;
use crate::track::{Kinematics, Origin, Path, Tracked};

/// Where the method is from.
const PAPER: &str = "Model Learning with Backlash Compensation for a Tendon-Driven Surgical Robot";

pub fn of_tracked(robot: &Robot, kinematics: &Kinematics, path: &Path, tracked: &Tracked, origin: &Origin) -> Page {
    let mut page = super::start("track", "A joint program for a path", robot);
    if let Some(file) = &origin.file {
        page.file("kinematics", file.name.clone(), file.sha256.clone());
    }
    page.file("path", path.name.clone(), path.sha256.clone());
    let (mean, most) = (tracked.mean_error_m() * 1e3, tracked.largest_error_m() * 1e3);
    page.verdict(
        Tone::Plain,
        format!(
            "{}, {}: {most:.4} mm from the path at most, with these kinematics.",
            counted(path.len(), "point"),
            origin.by
        ),
    );
    page.tile(Tile::number("mean distance", mean, 4, "mm"));
    page.tile(Tile::number("half way between points, at most", tracked.between_m * 1e3, 4, "mm"));
    let rows = robot.axis_joints().enumerate().map(|(a, j)| {
        let edge = |v: f64| format!("{:.3}", j.kind.to_user_unit(v));
        let [lo, hi] = range(tracked.q.iter().map(|q| q[a]));
        let limit = |l: Option<f64>| l.map_or("–".into(), edge);
        vec![
            format!("{}, {}", j.name, j.kind.unit()),
            edge(lo),
            edge(hi),
            limit(j.limits.map(|l| l[0])),
            limit(j.limits.map(|l| l[1])),
            edge(tracked.speed[a]),
            limit(j.max_speed),
        ]
    });
    let columns =
        ["joint", "from", "to", "lower limit", "upper limit", "highest speed, per s", "limit of the speed, per s"];
    page.section(
        "The path",
        "The desired path, and the path of the program according to the kinematics.",
        in_space(kinematics, path, tracked),
    );
    page.section(
        "What the joints do",
        "Positions in the unit beside the joint's name, speeds in the same unit per second.",
        TableView::numbers_after(1, &columns, rows),
    );
    let text = "At each step, the smallest movement of the joints that takes the TCP to the next point, within the joint limits, the joint speeds and the range in which the kinematics are valid (a bounded quadratic program).";
    page.section("", "", vec![Method::new("Tracking", text, format!("{PAPER}, equation 1"))]);
    page
}

/// The path and what the program misses of it; free coordinates are drawn at zero.
fn in_space(kinematics: &Kinematics, path: &Path, tracked: &Tracked) -> PathView {
    let space = |values: &[f64]| {
        let mut p = [0.0; 3];
        path.coordinates.iter().zip(values).for_each(|(&c, v)| p[c] = v * 1e3);
        p
    };
    let wanted: Vec<[f64; 3]> = path.points_m.iter().map(|p| space(p)).collect();
    let error = |(q, p): (&Vec<f64>, &Vec<f64>)| {
        let reached = kinematics.position_m(q);
        let miss: Vec<f64> = reached.iter().zip(p).map(|(r, p)| r - p).collect();
        space(&miss).map(|v| v * 1e3)
    };
    PathView {
        exaggeration: 1.0,
        nominal_mm: wanted.clone(),
        runs: vec![PathRun {
            run: Run::new("by the kinematics", Role::After),
            reference_mm: wanted,
            error_um: tracked.q.iter().zip(&path.points_m).map(error).collect(),
        }],
        marks: Vec::new(),
        is_arm: false,
    }
}
