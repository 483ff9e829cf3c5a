//! A rewritten program is read again before it is put anywhere: every step must be the one that was meant.

mod before;

use crate::error::{Error, Place, Result};
use crate::program::script::{
    At, Break, Document, Edits, Format, Goal, Move, PathKind, Quantity, Script, StepKind, Text,
};
use crate::robot::Robot;
pub use before::Before;
use before::{Kind, Own};
use nalgebra::Vector3;
use std::mem::discriminant;

/// Largest rounding of a written value, in digits.
const ROUNDED: f64 = 0.501;
/// Largest rounding of a point on the way of an arc, m: half a seventh digit of some metres.
const VIA_M: f64 = 0.6e-6;
/// A point on the way that was left as it stands, m.
const SAME_VIA_M: f64 = 1e-9;
/// A number that was left as it stands gives the very same value, but for the arithmetic of the wish, rad or m.
const SAME: f64 = 1e-12;

/// What reading again shows.
#[derive(Debug, Clone, Default)]
pub struct Written {
    /// Largest distance between what was wanted and what is written, per axis, rad or m; `None`: nothing written.
    pub lost: Vec<Option<f64>>,
    /// Weight of the coarsest last digit of a number that was written anew, per axis, rad or m.
    pub digit: Vec<f64>,
    /// Largest distance between what was wanted and what is written of poses: lengths, m, and angles, rad.
    pub pose_lost: [f64; 2],
    /// Straight TCP moves with new points at which the robot stops, or nearly: no corner fits, or the format has none so small.
    pub stops: Vec<Stops>,
    /// Every new exact stop: at new points, and at goals whose corner became none.
    pub halts: Vec<Halt>,
    /// Numbers that rounding took beyond a limit of their joint.
    pub beyond: Vec<Beyond>,
}

/// New exact stops of one move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Halt {
    pub step: usize,
    pub at: At,
    pub stops: u64,
}

/// A number that is written beyond a limit although what was wanted is not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beyond {
    pub step: usize,
    /// Which of the new points before the step; `None`: its goal.
    pub point: Option<usize>,
    pub axis: usize,
    /// The nearest number of the format within the limit, rad or m.
    pub inside: f64,
}

/// New points of one move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stops {
    /// Where the move stands in the program as it was.
    pub at: At,
    pub points: u64,
}

impl Written {
    /// Of a program of so many axes into which nothing was written.
    pub fn nothing(axes: usize) -> Self {
        Self { lost: vec![None; axes], digit: vec![0.0; axes], ..Self::default() }
    }
}

fn fault(place: Option<(&str, At)>, what: &str) -> Error {
    let place = place.map(|(name, at)| Place::line(name, at.line).to_string()).unwrap_or_default();
    let source =
        format!("{place}: the result, read again, differs from the intended one ({what}); nothing was written");
    Error::internal("rewrite this program", source)
}

/// Reads `texts` again and compares.
///
/// # Errors
/// Internal, with the line, where a step is not what it must be: that is a fault of ours, and nothing is written.
pub fn read_again(
    format: &dyn Format,
    before: &Before,
    edits: &Edits,
    texts: Vec<Text>,
    robot: &Robot,
) -> Result<Written> {
    let document: Box<dyn Document> =
        format.parse(texts, robot.axes()).map_err(|e| before.fault(0, &format!("it does not parse: {e}")))?;
    let after = document.script();
    let fault_after = |k: usize, what: &str| {
        let name = |at: At| after.texts.get(at.file).map_or("", |t| t.name.as_str());
        fault(after.steps.get(k).map(|s| (name(s.at), s.at)), what)
    };
    let mut written = Written::nothing(robot.dof());
    let mut k = 0;
    for (i, step) in before.steps.iter().enumerate() {
        let edit = edits.steps.get(i);
        let own = match &step.kind {
            Kind::Move(own) => before.values(own),
            Kind::Other(_) | Kind::LostAxes => &[],
        };
        let mut stops = 0;
        if matches!(step.kind, Kind::LostAxes) {
            k += usize::from(loses_axes(after, k));
            continue;
        }
        for (n, point) in edit.iter().flat_map(|e| e.before).enumerate() {
            k += usize::from(loses_axes(after, k));
            let m = moved(after, k).ok_or_else(|| before.fault(i, "a new point is missing"))?;
            // a quadrant that is already a part of the way may stay inside its arc
            compare(after, m, &point.q, own, edits, &mut written).map_err(|what| fault_after(k, &what.to_string()))?;
            beyond(robot, after, m, &point.q, (i, Some(n)), &mut written);
            piece(m, edit.and_then(|e| e.piece(n))).map_err(|what| fault_after(k, &what.to_string()))?;
            stops += u64::from(m.blend_m == Some(0.0) && !document.passes_points());
            k += 1;
            if point.waits {
                let waits = matches!(after.steps.get(k).map(|s| &s.kind), Some(StepKind::Dwell(_)));
                if !waits {
                    return Err(fault_after(k, "the program does not wait at a new point"));
                }
                (k, stops) = (k + 1, stops + 1);
            }
        }
        let of_tcp = |m: &Own| m.path == PathKind::Linear || edit.is_some_and(|e| !e.vias.is_empty());
        if stops > 0 && matches!(&step.kind, Kind::Move(m) if of_tcp(m)) {
            written.stops.push(Stops { at: step.at(), points: stops });
        }
        k += usize::from(loses_axes(after, k));
        let Some(here) = after.steps.get(k) else { return Err(before.fault(i, "a step is missing")) };
        if let (Kind::Move(a), StepKind::Move(m)) = (&step.kind, &here.kind) {
            stops += u64::from(a.blend_m != 0.0 && m.blend_m == Some(0.0));
        }
        if stops > 0 {
            written.halts.push(Halt { step: i, at: step.at(), stops });
        }
        if let (Kind::Move(a), StepKind::Move(m)) = (&step.kind, &here.kind) {
            let last = edit.and_then(|e| e.piece(e.before.len()));
            piece(m, last).map_err(|what| fault_after(k, &what.to_string()))?;
            let apart = |(a, b): (Vector3<f64>, Vector3<f64>)| (a - b).amax() > SAME_VIA_M;
            if last.is_none() && (a.via_m().is_some() != via(m).is_some() || a.via_m().zip(via(m)).is_some_and(apart)) {
                return Err(fault_after(k, "another point on the way of an arc"));
            }
        }
        match (&step.kind, &here.kind) {
            (Kind::Move(a), StepKind::Move(m)) if edit.is_some_and(|e| e.goal.is_some()) => {
                let goal = edit.and_then(|e| e.goal).unwrap_or_default();
                compare(after, m, goal, own, edits, &mut written).map_err(|what| fault_after(k, &what.to_string()))?;
                beyond(robot, after, m, goal, (i, None), &mut written);
                if m.path != a.path && !edit.is_some_and(|e| e.as_joint_moves) {
                    return Err(fault_after(k, "another kind of path"));
                }
            }
            (Kind::Move(a), StepKind::Move(b)) => {
                if !a.alike(own, after, b) {
                    return Err(fault_after(k, "a move changed that should not"));
                }
            }
            (Kind::Other(a), b) if *a == discriminant(b) => {}
            _ => return Err(fault_after(k, "another kind of step")),
        }
        k += 1;
    }
    if k != after.steps.len() {
        return Err(fault_after(k, "a step too many"));
    }
    Ok(written)
}

/// The point on the way of a move, in the frame of its goal, m.
fn via(m: &Move) -> Option<Vector3<f64>> {
    match &m.goal {
        Goal::Pose(goal) => goal.via_m,
        _ => None,
    }
}

/// What a move that is read again has instead of what was written. The words stand in a message about a fault of ours.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
enum Difference {
    #[error("a point on the way of an arc is {off_m} m off")]
    Via { off_m: f64 },
    #[error("another kind of piece of an arc")]
    Piece,
    #[error("a target without numbers")]
    NoNumbers,
    #[error("a target that is not there")]
    NoTarget,
    /// Numbers count from 1; their values in SI.
    #[error("number {number} is {is} and not {wanted}")]
    Number { number: usize, is: f64, wanted: f64 },
}

/// A piece of a split arc goes over the place that was meant.
fn piece(m: &Move, want: Option<&[f64]>) -> std::result::Result<(), Difference> {
    match (want, via(m), m.path) {
        (None, ..) => Ok(()),
        (Some([x, y, z]), Some(at), PathKind::Curve) => {
            let off = (at - Vector3::new(*x, *y, *z)).amax();
            if off <= VIA_M { Ok(()) } else { Err(Difference::Via { off_m: off }) }
        }
        _ => Err(Difference::Piece),
    }
}

/// The step says of some axes that it is not known any more where they are.
fn loses_axes(script: &Script, k: usize) -> bool {
    matches!(script.steps.get(k).map(|s| &s.kind), Some(StepKind::Break(Break::Axes(_))))
}

fn moved(script: &Script, k: usize) -> Option<&Move> {
    match &script.steps.get(k)?.kind {
        StepKind::Move(m) => Some(m),
        _ => None,
    }
}

/// The target of `m` is `want` within half a digit, on the axes that it commands. Numbers that still are those of `own`, the
/// target that was changed or copied, are not written anew.
fn compare(
    script: &Script,
    m: &Move,
    want: &[f64],
    own: &[f64],
    edits: &Edits,
    written: &mut Written,
) -> std::result::Result<(), Difference> {
    let Some(t) = m.goal.target() else { return Err(Difference::NoNumbers) };
    let target = script.targets.get(t).ok_or(Difference::NoTarget)?;
    for (axis, (value, &want)) in target.values.iter().zip(want).enumerate() {
        let Some(v) = value else { continue };
        let lost = (v.si - want).abs();
        let stays = own.get(axis).is_some_and(|own| *own == v.si);
        // a number may stand there with more digits than are written: then a change below these leaves it
        let wish = || Some(edits.digit_of(&target, axis)).filter(|wish| !wish.is_nan()).unwrap_or(0.0);
        let digit = if stays { v.digit.max(v.finest).max(wish()) } else { v.digit };
        if lost > ROUNDED * digit + 1e-12 {
            return Err(Difference::Number { number: axis + 1, is: v.si, wanted: want });
        }
        if stays && lost <= SAME {
            continue;
        }
        if let Some(quantity) = target.quantity(axis) {
            let slot = usize::from(quantity != Quantity::Length);
            written.pose_lost[slot] = written.pose_lost[slot].max(lost);
            continue;
        }
        written.lost[axis] = Some(written.lost[axis].unwrap_or(0.0).max(lost));
        written.digit[axis] = written.digit[axis].max(v.digit);
    }
    Ok(())
}

/// Notes numbers of the target of `m` that stand beyond a limit that `want` keeps.
fn beyond(
    robot: &Robot,
    script: &Script,
    m: &Move,
    want: &[f64],
    place: (usize, Option<usize>),
    written: &mut Written,
) {
    let Goal::Joints(t) = m.goal else { return };
    let Some(target) = script.targets.get(t) else { return };
    for (axis, ((value, &want), joint)) in target.values.iter().zip(want).zip(robot.axis_joints()).enumerate() {
        let (Some(v), Some([lo, hi])) = (value, joint.limits) else { continue };
        let by = if v.si > hi + SAME && want <= hi + SAME {
            -v.digit.abs()
        } else if v.si < lo - SAME && want >= lo - SAME {
            v.digit.abs()
        } else {
            continue;
        };
        let (step, point) = place;
        written.beyond.push(Beyond { step, point, axis, inside: v.si + by });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::krl::Krl;
    use crate::program::rapid::Rapid;
    use crate::program::script::pose::Frame;
    use crate::program::script::{Edit, Few, How, PoseGoal, Reason, Solution};
    use nalgebra::UnitQuaternion;

    fn pose(turn: f64) -> Goal {
        let rotation = Some(UnitQuaternion::from_euler_angles(0.0, 0.0, turn));
        Goal::pose(PoseGoal {
            target: None,
            position_m: Vector3::new(1.0, 0.5, 0.2),
            rotation,
            frame: Frame::Null,
            tool: Frame::Null,
            solution: Solution::Same,
            binding: false,
            ..PoseGoal::default()
        })
    }

    fn to(goal: Goal, path: PathKind) -> Move {
        Move::new(How { path, ..How::default() }, goal, Few::new())
    }

    fn joints(script: &Script, m: &Move) -> Vec<f64> {
        let target = &script.targets.get(m.goal.target().unwrap()).unwrap();
        target.values.iter().map(|v| v.unwrap().si).collect()
    }

    #[test]
    fn a_pose_that_turned_and_a_path_of_another_kind_are_other_moves() {
        let script = Script::default();
        let alike = |a: &Move, b: &Move| Before::default().own(&script, a, false).alike(&[], &script, b);
        let line = to(pose(0.1), PathKind::Linear);
        assert!(alike(&line, &to(pose(0.1), PathKind::Linear)));
        assert!(!alike(&line, &to(pose(0.2), PathKind::Linear)));
        assert!(!alike(&line, &to(pose(0.1), PathKind::Joint)));
        assert!(!alike(&line, &to(Goal::Opaque(Reason::NoGoal), PathKind::Linear)));
    }

    #[test]
    fn a_change_below_what_is_written_may_leave_a_number_of_more_digits() {
        let robot = Robot::parse("robot", include_str!("../../../configs/abb-irb1600-6-145.yaml")).unwrap();
        let text = "MODULE m\nPROC main()\nMoveAbsJ [[1.267E-05,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;\nENDPROC\nENDMODULE\n";
        let texts = || vec![Text::new("m.mod", text.as_bytes().to_vec())];
        let before = Rapid.parse(texts(), robot.axes()).unwrap();
        let (k, m) = before.script().moves().next().unwrap();
        let mut goal = joints(before.script(), m);
        // 1e-7 deg, as a solver's last digits are; RAPID's numbers are single
        goal[0] += 1e-7_f64.to_radians();
        let edit = |goal: &[f64]| Edit { goal: Some(goal.to_vec()), ..Edit::default() };
        let edits = Edits { steps: [(k, edit(&goal))].into(), digit: vec![1e-7; 6], ..Edits::default() };
        assert!(before.patches(&edits).unwrap().is_empty());
        assert!(read_again(&Rapid, &Before::of(before.script(), &edits), &edits, texts(), &robot).is_ok());
        goal[0] += 1e-4_f64.to_radians();
        let edits = Edits { steps: [(k, edit(&goal))].into(), digit: vec![1e-7; 6], ..Edits::default() };
        assert!(read_again(&Rapid, &Before::of(before.script(), &edits), &edits, texts(), &robot).is_err());
    }

    #[test]
    fn numbers_that_stay_say_nothing_of_the_steps_in_which_others_are_written() {
        let robot = Robot::parse("robot", include_str!("../../../configs/kuka-kr120-r2500-pro.yaml")).unwrap();
        let program = |a1: &str| {
            let text = format!("DEF a( )\nPTP {{A1 {a1},A2 -90,A3 90,A4 0,A5 10.5,A6 0}}\nEND\n");
            vec![Text::new("a.src", text.into_bytes())]
        };
        let before = Krl.parse(program("5"), robot.axes()).unwrap();
        let (k, m) = before.script().moves().next().unwrap();
        let mut goal = joints(before.script(), m);
        goal[0] = 5.0028_f64.to_radians();
        let edit = Edit { goal: Some(goal), ..Edit::default() };
        let edits = Edits { steps: [(k, edit)].into(), digit: vec![1e-6; 6], ..Edits::default() };
        let written =
            read_again(&Krl, &Before::of(before.script(), &edits), &edits, program("5.0028"), &robot).unwrap();
        assert!((written.digit[0].to_degrees() - 1e-4).abs() < 1e-12, "{written:?}");
        assert!(
            written.lost[0].is_some_and(|l| l < 1e-12) && written.lost[1..].iter().all(Option::is_none),
            "{written:?}"
        );
        assert_eq!(&written.digit[1..], [0.0; 5]);
        // the same goal, and what was written is another one
        assert!(read_again(&Krl, &Before::of(before.script(), &edits), &edits, program("5.0029"), &robot).is_err());
    }
}
