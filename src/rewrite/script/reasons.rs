//! Why steps of a program stay as they are.

use super::cause::Cause;
use super::coverage::Coverage;
use super::task::Choices;
use crate::program::script::{Edits, Goal, Script, StepKind, processes};
use std::collections::BTreeMap;

/// Why steps stay as they are.
pub(super) struct Reasons {
    /// Where the engine or a pose cannot be written, by step.
    pub(super) left: BTreeMap<usize, Cause>,
    /// Steps with an axis whose position is not known yet, ascending.
    pub(super) partial: Vec<usize>,
    /// By the format, by step.
    pub(super) unwritable: BTreeMap<usize, Cause>,
}

impl Reasons {
    /// How much is edited; `left_out`: by step, why it is left on request.
    pub(super) fn coverage(
        &self,
        script: &Script,
        choices: &Choices,
        left_out: &[Option<Cause>],
        edits: &Edits,
    ) -> Coverage {
        let posed = |k: usize| match self.left.get(&k) {
            Some(why) => Err(why.clone()),
            None if choices.leave_poses => Err(Cause::Cartesian),
            None => Ok(()),
        };
        let solved = |k: usize| edits.steps.get(k).is_some_and(|e| e.as_joint_moves);
        let unknown = |k: usize| self.partial.binary_search(&k).is_ok().then_some(Cause::NotYetKnown);
        let kept = |k: usize| {
            let asked = left_out.get(k).cloned().flatten().or_else(|| unknown(k));
            let joints = || matches!(&script.steps[k].kind, StepKind::Move(m) if matches!(m.goal, Goal::Joints(_)));
            asked
                .or_else(|| self.unwritable.get(&k).cloned())
                .or_else(|| self.left.get(&k).filter(|_| joints()).cloned())
        };
        Coverage::of(script, &kept, &solved, &posed)
    }
}

/// Why each step is left out on request, up to the last one that is.
pub(super) fn left_out(script: &Script, choices: &Choices) -> Vec<Option<Cause>> {
    let mut off = false;
    let mut all = Vec::new();
    let processes = if choices.exclude_process { processes::before_each(script) } else { Vec::new() };
    for (k, step) in script.steps.iter().enumerate() {
        if let StepKind::Pragma(on) = step.kind {
            off = !on;
        }
        let why = match (off, processes.get(k).copied().unwrap_or(false)) {
            (true, _) => Cause::SwitchedOff,
            (_, true) => Cause::ProcessOn,
            _ => continue,
        };
        all.resize(k, None);
        all.push(Some(why));
    }
    all
}
