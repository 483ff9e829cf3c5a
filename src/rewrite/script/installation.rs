//! Where the robot stands in the world of its controller and how far its axes go, as the controller's files say (KUKA `$machine.dat`).
//!
//! Frames are given in the world of the controller, and the robot stands there at `$ROBROOT`. The robot file has its own world, in
//! which the robot stands at `base`. Both are places of one foot, so a frame `F` of the controller is `base * root^-1 * F` in the robot
//! file's world, whatever that is. Without a `$ROBROOT` both worlds are taken to be the same.

use crate::error::{Error, Place, Result};
use crate::program::script::{At, Goal, Note, Script};
use crate::robot::Robot;
use crate::robot::frames::Frames;
use nalgebra::Isometry3;

/// Places that differ by less are the same: numbers have six digits, m and rad.
const SAME: f64 = 1e-6;

fn same(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    (a.translation.vector - b.translation.vector).norm() < SAME && a.rotation.angle_to(&b.rotation) < SAME
}

/// The place of the robot in the controller's world; `None`: no file says it, or nothing depends on it.
///
/// # Errors
/// Its numbers cannot be read, or two files differ.
pub(super) fn root(script: &Script, frames: &Frames) -> Result<Option<Isometry3<f64>>> {
    if !script.moves().any(|(_, m)| matches!(m.goal, Goal::Pose(_)) || m.tool.is_some()) {
        return Ok(None);
    }
    let given =
        frames.machine.as_ref().and_then(|m| m.root).map(|(line, root)| (Place::line("$machine.dat", line), root));
    let own = script.installed.iter().filter_map(|i| Some((script.place(i.at), i.root?)));
    let mut found: Option<Isometry3<f64>> = None;
    for (place, root) in given.into_iter().chain(own) {
        let Some(root) = root else {
            return Err(Error::bad(place, "a `$ROBROOT` that cannot be read", "X, Y, Z, A, B and C as numbers"));
        };
        if found.as_ref().is_some_and(|known| !same(known, &root)) {
            let expected = "one place of the robot: a `$machine.dat` of the same robot";
            return Err(Error::bad(place, "another `$ROBROOT` than in the file before it", expected));
        }
        found = Some(root);
    }
    Ok(found)
}

/// The controller's world in that of the robot file.
pub(super) fn world(robot: &Robot, root: Option<&Isometry3<f64>>) -> Isometry3<f64> {
    // numbers that are read twice must not turn a frame by their rounding
    let other = root.filter(|root| !same(&robot.base, root));
    other.map_or_else(Isometry3::identity, |root| robot.base * root.inverse())
}

/// Says in which world frames are taken.
pub(super) fn note(robot: &Robot, root: Option<&Isometry3<f64>>) -> Option<Note> {
    let root = root.filter(|root| !same(&robot.base, root))?;
    let at = root.translation.vector * 1e3;
    let (c, b, a) = root.rotation.euler_angles();
    let [a, b, c] = [a, b, c].map(f64::to_degrees);
    let text = format!(
        "frames are taken in the world of the controller, in which the robot stands at $ROBROOT {{X {:.3},Y {:.3},Z {:.3},A {a:.3},B {b:.3},C {c:.3}}} ($machine.dat); `base` of the robot file is another world",
        at.x, at.y, at.z
    );
    Some(Note { place: At { file: 0, line: 1 }, text })
}

/// The robot with the bases that the user's lists put on other machines; `None`: there are none.
pub(super) fn with_bases(robot: &Robot, frames: &Frames) -> Option<Robot> {
    let mut held = (!frames.carried.is_empty()).then(|| robot.clone())?;
    held.hold_bases(&frames.carried);
    Some(held)
}

/// The robot with limits no wider than those of the controller's files, and which axes have narrower ones now; `None`: none has.
pub(super) fn limited(script: &Script, frames: &Frames, robot: &Robot) -> Option<(Robot, Note)> {
    let given = frames.machine.as_ref().map(|m| m.limits(robot.axes()));
    let all: Vec<&Vec<Option<[f64; 2]>>> = given.iter().chain(script.installed.iter().map(|i| &i.limits)).collect();
    let mut joints = robot.joints.clone();
    let mut narrower = Vec::new();
    for axis in 0..robot.dof() {
        let Some(joint) = joints.get_mut(robot.axis_index(axis)) else { continue };
        let before = joint.limits;
        for ends in all.iter().filter_map(|l| l.get(axis).copied().flatten()) {
            let [low, high] = joint.limits.unwrap_or(ends);
            joint.limits = Some([low.max(ends[0]), high.min(ends[1])]);
        }
        if let Some([low, high]) = joint.limits.filter(|_| joint.limits != before) {
            let unit = joint.kind.unit();
            let [low, high] = [low, high].map(|v| joint.kind.to_user_unit(v));
            narrower.push(format!("{} {low:.3} to {high:.3} {unit}", joint.name));
        }
    }
    if narrower.is_empty() {
        return None;
    }
    let text = format!(
        "the software limits of $machine.dat are narrower than those of the robot file and hold here: {}",
        narrower.join(", ")
    );
    Some((robot.with_geometry(joints, robot.tool), Note { place: At { file: 0, line: 1 }, text }))
}
