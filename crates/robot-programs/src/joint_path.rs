//! A vendor program as a list of joint targets, for jobs that need no text (`simulate`): what the robot would pass if the
//! steps were done once, in the order of the text.
//!
//! Assumes joint targets alone: a Cartesian target, or one that is computed at run time, is refused with its line. Turning
//! points that a format knows itself (quadrants of an arc) are points, too. An axis that a target does not command stays where
//! it is. Branches, loops, calls and interrupts are passed once and noted: the text does not say how often they run.

use super::script::PathKind;
use super::script::{At, Break, Document, Goal, Move, Note, Script, Speed, StepKind, Way};
use crate::axes::Axes;
use crate::error::{Error, Result};
use std::collections::BTreeMap;

/// The points of a script.
#[derive(Debug, Clone, Default)]
pub struct JointPath {
    /// As messages show it.
    pub name: String,
    /// `q[axis][point]`, rad or m.
    pub q: Vec<Vec<f64>>,
    /// s from the first point; only where every move says how long it takes.
    pub t_s: Option<Vec<f64>>,
    /// Place of each point.
    pub places: Vec<At>,
    /// Points that are goals of moves, not places on the way to one or at which the robot waits.
    pub goals: Vec<usize>,
    /// Where the order of the text is not certainly that of the robot.
    pub notes: Vec<Note>,
}

impl JointPath {
    /// Goes to `q` in `seconds`, over the points on the way there; no times any more where it is not known how long.
    fn moves(
        &mut self,
        way: &[Way],
        q: &[f64],
        mut times: Option<Vec<f64>>,
        at: At,
        seconds: Option<f64>,
    ) -> Option<Vec<f64>> {
        self.goals.push(self.places.len() + way.len());
        let way = way.iter().map(|w| (w.share, w.q.as_slice())).chain([(1.0, q)]);
        let start_s = times.as_ref().and_then(|t| t.last().copied());
        for (share, point) in way {
            let t_s = match (start_s, seconds) {
                // how long the way to the first point takes does not matter: time runs from there
                (None, _) => Some(0.0),
                (Some(t), Some(s)) => Some(t + share * s),
                _ => None,
            };
            times = times.zip(t_s).map(|(mut times, t)| {
                times.push(t);
                times
            });
            for (axis, column) in self.q.iter_mut().enumerate() {
                column.push(point.get(axis).copied().unwrap_or_default());
            }
            self.places.push(at);
        }
        times
    }

    /// Stands still for some seconds; no times any more where it is not known how long.
    fn dwell(&mut self, seconds: Option<f64>, mut times: Vec<f64>, q: &[f64], at: At) -> Option<Vec<f64>> {
        let (seconds, from) = (seconds?, times.last().copied());
        if let Some(from) = from.filter(|_| seconds > 0.0) {
            times.push(from + seconds);
            self.places.push(at);
            for (column, v) in self.q.iter_mut().zip(q) {
                column.push(*v);
            }
        }
        Some(times)
    }
}

/// The joint targets of a script in the order of its text.
///
/// # Errors
/// With the line where a move has no joint target, where an axis is not known, and where nothing moves.
pub fn joints(script: &Script, robot: &Axes) -> Result<JointPath> {
    walk(script, robot, None, &BTreeMap::new())
}

/// Seconds of a move from joints to joints (rad or m); `None`: not known.
pub type Duration<'a> = &'a dyn Fn(&Move, &[f64], &[f64]) -> Option<f64>;

/// The same with the times that `duration` gives; waits of unknown length, and the ways from one program to the next, take none.
///
/// # Errors
/// As for [`joints`].
pub fn timed(script: &Script, robot: &Axes, duration: Duration) -> Result<JointPath> {
    walk(script, robot, Some(duration), &BTreeMap::new())
}

/// The same of a program that has been read, on the splines that its points stand for ([`Document::passed`]); `duration`: as for
/// [`timed`].
///
/// # Errors
/// As for [`joints`].
pub fn of_document(document: &dyn Document, robot: &Axes, duration: Option<Duration>) -> Result<JointPath> {
    walk(document.script(), robot, duration, &document.passed())
}

fn walk(
    script: &Script,
    robot: &Axes,
    duration: Option<Duration>,
    passed: &BTreeMap<usize, Vec<Way>>,
) -> Result<JointPath> {
    let name = script.texts.first().map_or(String::new(), |t| t.name.clone());
    let mut path = JointPath { name, q: vec![Vec::new(); robot.dof()], ..JointPath::default() };
    let mut times = Some(Vec::new());
    let mut last: Option<Vec<f64>> = None;
    for (k, step) in script.steps.iter().enumerate() {
        match &step.kind {
            StepKind::Move(m) => {
                let q = target(script, m, step.at, last.as_deref(), robot)?;
                let seconds = match (m.speed, duration, &last) {
                    (Speed::Seconds(s), ..) => Some(s),
                    (_, Some(duration), Some(from)) => duration(m, from, &q),
                    _ => None,
                };
                let way = passed.get(&k).map_or(&m.way[..], Vec::as_slice);
                times = path.moves(way, &q, times, step.at, seconds);
                if m.path != PathKind::Joint {
                    note(&mut path, step.at, NOT_STRAIGHT);
                }
                last = Some(q);
            }
            StepKind::Break(Break::Start) => {
                // another program: its times begin anew
                if last.is_some() && duration.is_none() {
                    times = None;
                }
            }
            StepKind::Break(Break::Jump | Break::Loop | Break::Call | Break::Interrupt) => {
                note(&mut path, step.at, PASSED_ONCE);
            }
            StepKind::Dwell(seconds) => {
                if let Some(q) = &last {
                    let seconds = seconds.or(duration.map(|_| 0.0));
                    times = times.and_then(|t| path.dwell(seconds, t, q, step.at));
                }
            }
            StepKind::Break(Break::Frame | Break::Axes(_))
            | StepKind::Sets(_)
            | StepKind::Process(_)
            | StepKind::Pragma(_) => {}
        }
    }
    if last.is_none() {
        let expected = "a program with joint targets";
        return Err(Error::bad(script.place(At { file: 0, line: 1 }), "a program without a move", expected));
    }
    path.t_s = times.filter(|t| t.len() == path.places.len() && t.len() > 1);
    Ok(path)
}

/// Notes of a path.
const NOT_STRAIGHT: &str = "between its points the robot moves on a Cartesian path, not straight in the joints";
const PASSED_ONCE: &str = "branches, loops, calls and interrupts are passed once, in the order of the text";

/// Every sentence once, at its first place.
fn note(path: &mut JointPath, place: At, text: &str) {
    if !path.notes.iter().any(|n| n.text == text) {
        path.notes.push(Note { place, text: text.into() });
    }
}

/// Joint values of a move's goal; axes that it does not command come from the point before.
fn target(script: &Script, m: &Move, at: At, last: Option<&[f64]>, robot: &Axes) -> Result<Vec<f64>> {
    let expected = "joint targets alone: only they can be simulated without the controller";
    let bad = |found: String| Error::bad(script.place(at), found, expected);
    let values = match &m.goal {
        Goal::Joints(t) => script.targets.get(*t).map(|t| t.values).ok_or_else(|| bad("no target".into()))?,
        Goal::Pose(_) => return Err(bad("a Cartesian target".into())),
        Goal::Opaque(why) => return Err(bad(format!("a target that cannot be read: {why}"))),
    };
    (0..robot.dof())
        .map(|axis| {
            let own = values.get(axis).map(|v| v.si);
            let before = || last.and_then(|q| q.get(axis).copied());
            own.or_else(before).ok_or_else(|| {
                Error::bad(
                    script.place(at),
                    format!("no value for joint {}", robot.axis(axis).name),
                    "a first target that gives every joint of the robot",
                )
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axes::{Axis, JointKind};
    use crate::script::number::Style;
    use crate::script::{How, Step, Target, Text, Value};

    fn robot() -> Axes {
        Axes::new("a", vec![Axis::new("J1", JointKind::Revolute), Axis::new("X", JointKind::Prismatic)])
    }

    fn step(line: u64, kind: StepKind) -> Step {
        Step { at: At { file: 0, line }, kind }
    }

    fn to(goal: Goal, speed: Speed, way: Vec<Way>) -> StepKind {
        StepKind::Move(Move::new(How { speed, ..How::default() }, goal, way))
    }

    fn script(steps: Vec<Step>, targets: &[[Option<f64>; 2]]) -> Script {
        let value = |si: f64| Value { si, start: 0, end: 0, style: Style::default(), digit: 1.0, finest: 1.0 };
        let targets = targets
            .iter()
            .map(|t| Target { values: t.iter().map(|v| v.map(value)).collect(), ..Target::default() })
            .collect();
        Script { texts: vec![Text::new("p.src", Vec::new())], steps, targets, ..Script::default() }
    }

    #[test]
    fn targets_follow_in_the_order_of_the_text_with_their_turning_points() {
        let way = vec![Way { share: 0.25, q: vec![5.0, 6.0] }];
        let s = script(
            vec![
                step(1, StepKind::Break(Break::Start)),
                step(2, to(Goal::Joints(0), Speed::Unknown, Vec::new())),
                step(3, to(Goal::Joints(1), Speed::Seconds(2.0), way)),
                step(4, StepKind::Dwell(Some(1.0))),
                step(5, to(Goal::Joints(0), Speed::Seconds(4.0), Vec::new())),
            ],
            &[[Some(1.0), Some(2.0)], [Some(3.0), None]],
        );
        let p = joints(&s, &robot()).unwrap();
        assert_eq!(p.q, [[1.0, 5.0, 3.0, 3.0, 1.0], [2.0, 6.0, 2.0, 2.0, 2.0]]);
        assert_eq!(p.t_s, Some(vec![0.0, 0.5, 2.0, 3.0, 7.0]));
        assert_eq!(p.goals, [0, 2, 4]);
        assert_eq!(p.places.iter().map(|a| a.line).collect::<Vec<_>>(), [2, 3, 3, 4, 5]);
        assert!(p.notes.is_empty());
    }

    #[test]
    fn times_are_given_only_where_all_are_known_and_a_loop_is_noted_once() {
        let s = script(
            vec![
                step(1, to(Goal::Joints(0), Speed::Seconds(1.0), Vec::new())),
                step(2, StepKind::Break(Break::Loop)),
                step(3, to(Goal::Joints(0), Speed::Share(0.5), Vec::new())),
                step(4, StepKind::Dwell(Some(1.0))),
                step(5, to(Goal::Joints(0), Speed::Seconds(1.0), Vec::new())),
                step(6, StepKind::Break(Break::Loop)),
            ],
            &[[Some(1.0), Some(2.0)]],
        );
        let p = joints(&s, &robot()).unwrap();
        assert_eq!((p.t_s, p.q[0].len(), p.notes.len(), p.notes[0].place.line), (None, 3, 1, 2));
    }

    #[test]
    fn what_cannot_be_played_is_refused_with_its_line() {
        let one = |goal| script(vec![step(7, to(goal, Speed::Unknown, Vec::new()))], &[[Some(1.0), None]]);
        for (s, words) in [
            (
                one(Goal::opaque(crate::fanuc::Reason::NotTaught(3))),
                "p.src:7: found a target that cannot be read: P[3] is not taught",
            ),
            (one(Goal::Joints(0)), "p.src:7: found no value for joint X"),
            (script(Vec::new(), &[]), "p.src:1: found a program without a move"),
        ] {
            let e = joints(&s, &robot()).unwrap_err();
            assert!(e.to_string().starts_with(words), "{e}");
        }
    }
}
