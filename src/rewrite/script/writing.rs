//! Edits into texts: what the format cannot say is taken out, and no rounding passes a limit.

use super::{Task, verify};
use crate::error::Result;
use crate::program::script::{Document, Edits, Format, Text, text};
use crate::rewrite::Refusal;
use crate::rewrite::stats::RewriteStats;
use std::collections::BTreeMap;

/// The texts with the edits, read again. A number that rounding would take beyond a limit is written one digit further inside.
pub fn write(
    format: &dyn Format,
    document: &dyn Document,
    names: &[String],
    edits: &mut Edits,
    task: &Task,
) -> Result<(Vec<Vec<u8>>, verify::Written)> {
    const TRIES: usize = 3;
    let script = document.script();
    for _ in 0..TRIES {
        let patches = if edits.steps.is_empty() { Vec::new() } else { document.patches(edits)? };
        let texts = text::apply(&script.texts, &patches)?;
        if patches.is_empty() {
            return Ok((texts, verify::Written::nothing(task.robot.dof())));
        }
        let again: Vec<Text> = script.texts.iter().zip(&texts).map(|(t, b)| t.with(b.clone())).collect();
        let written = verify::read_again(format, script, edits, again, task.robot)?;
        if written.beyond.is_empty() {
            return Ok((texts, written));
        }
        for b in &written.beyond {
            let Some(edit) = edits.steps.get_mut(&b.step) else { continue };
            let q = match b.point {
                Some(n) => edit.before.get_mut(n).map(|p| &mut p.q),
                None => edit.goal.as_mut(),
            };
            if let Some(v) = q.and_then(|q| q.get_mut(b.axis)) {
                *v = b.inside;
            }
        }
    }
    let name = names.first().cloned().unwrap_or_default();
    Err(Refusal::AtLimit { name }.into())
}

/// Takes out edits that the format cannot say; these moves stay as they are. Why, by step.
pub fn leave_unwritable(
    document: &dyn Document,
    edits: &mut Edits,
    account: &mut RewriteStats,
) -> BTreeMap<usize, String> {
    let mut left = BTreeMap::new();
    loop {
        let before = left.len();
        for (step, why) in document.unwritable(edits) {
            if let Some(edit) = edits.steps.remove(&step) {
                account.inserted = account.inserted.saturating_sub(edit.before.len() as u64);
                left.insert(step, why);
            }
        }
        if left.len() == before {
            return left;
        }
    }
}
