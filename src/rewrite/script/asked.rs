//! Calls of which nobody says that they move nothing, and the moves that wait for that.

use super::cause::Cause;
use crate::program::script::{Break, Script, StepKind};
use std::collections::{BTreeMap, BTreeSet};

/// Names of programs, macros and routines that are not among the files, with the number of moves that stay as they are because these
/// may move the robot before them. `left`: why moves stay as they are, by step.
pub(super) fn calls(script: &Script, left: &BTreeMap<usize, Cause>) -> BTreeMap<String, u64> {
    let mut found: BTreeMap<String, u64> = BTreeMap::new();
    if script.unknown_calls.is_empty() {
        return found;
    }
    let waits =
        |why: &Cause| matches!(why, Cause::SideUnknown | Cause::NoStart | Cause::SeveralArms | Cause::EndOfCurve);
    for (step, _) in left.iter().filter(|(_, why)| waits(why)) {
        // what stands between it and the move before it in the text
        let before = script.steps.get(..*step).unwrap_or_default().iter().rev();
        let before = before.take_while(|s| !matches!(s.kind, StepKind::Move(_)));
        let breaks: Vec<_> = before.filter(|s| matches!(s.kind, StepKind::Break(_))).collect();
        // another call between them may move, whatever is declared of these
        let known = |at| script.unknown_calls.contains_key(at);
        if breaks.iter().any(|s| matches!(s.kind, StepKind::Break(Break::Call)) && !known(&s.at)) {
            continue;
        }
        let names: BTreeSet<&String> =
            breaks.iter().filter_map(|s| script.unknown_calls.get(&s.at)).flatten().collect();
        for name in names {
            *found.entry(name.clone()).or_default() += 1;
        }
    }
    found
}
