//! How much of a program can be edited, said before anything else: moves, those with joint targets that may change, and
//! why the others may not, with their lines.

use super::cause::Cause;
use crate::program::script::{At, Goal, Script, StepKind};
use serde::Serialize;

/// Lines that are listed for one reason.
const LISTED: usize = 20;

/// Coverage of a program.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Coverage {
    pub moves: u64,
    pub editable: u64,
    /// Of them those whose joint values are written, and those whose Cartesian target is written as one.
    pub as_joints: u64,
    pub as_poses: u64,
    /// Editable moves on whose way no point may be put: a step there is spread over the whole move.
    pub closed: u64,
    pub reasons: Vec<Reason>,
}

/// Why moves are not edited.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Reason {
    #[schemars(with = "String")]
    pub why: Cause,
    pub moves: u64,
    /// The first of their lines.
    pub lines: Vec<u64>,
    #[serde(skip)]
    pub file: usize,
}

impl Coverage {
    /// Coverage of a script; `excluded` says which steps are left out on request, and why, `solved` which Cartesian moves are
    /// written as joint moves, `posed` which are written as poses, or why not.
    pub fn of(
        script: &Script,
        excluded: &dyn Fn(usize) -> Option<Cause>,
        solved: &dyn Fn(usize) -> bool,
        posed: &dyn Fn(usize) -> Result<(), Cause>,
    ) -> Self {
        let mut coverage = Self::default();
        for (k, step) in script.steps.iter().enumerate() {
            let StepKind::Move(m) = &step.kind else { continue };
            coverage.moves += 1;
            let pose = matches!(m.goal, Goal::Pose(_)) && !solved(k);
            let why = match pose {
                true => posed(k).err(),
                false => Cause::of(m).filter(|_| !solved(k)),
            };
            match excluded(k).or(why) {
                Some(why) => coverage.add(why, step.at),
                None => {
                    coverage.editable += 1;
                    *(if pose { &mut coverage.as_poses } else { &mut coverage.as_joints }) += 1;
                    coverage.closed += u64::from(m.closed.is_some());
                }
            }
        }
        coverage
    }

    /// One more move that stays, for this reason.
    fn add(&mut self, why: Cause, at: At) {
        let found = self.reasons.iter_mut().find(|r| r.why == why && r.file == at.file);
        let reason = match found {
            Some(r) => r,
            None => {
                self.reasons.push(Reason { why, moves: 0, lines: Vec::new(), file: at.file });
                let last = self.reasons.len() - 1;
                &mut self.reasons[last]
            }
        };
        reason.moves += 1;
        if reason.lines.len() < LISTED {
            reason.lines.push(at.line);
        }
    }

    /// Editable moves in percent; 100 of a program without moves, as none stays as it is.
    pub fn percent(&self) -> f64 {
        if self.moves == 0 { 100.0 } else { 100.0 * self.editable as f64 / self.moves as f64 }
    }
}

impl Reason {
    /// `lines 3, 7, 12 and 5 more`.
    pub fn lines_text(&self) -> String {
        let shown: Vec<String> = self.lines.iter().map(u64::to_string).collect();
        let more = self.moves.saturating_sub(self.lines.len() as u64);
        let word = if self.moves == 1 { "line" } else { "lines" };
        match more {
            0 => format!("{word} {}", shown.join(", ")),
            _ => format!("{word} {} and {more} more", shown.join(", ")),
        }
    }
}
