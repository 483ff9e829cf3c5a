//! Edits into texts: what the format cannot say is taken out, and no rounding passes a limit.

use super::cause::Cause;
use super::task::Task;
use super::verify;
use crate::error::{Error, Result};
use crate::program::script::{Document, Edits, Format, Patches, Text, text};
use crate::rewrite::Refusal;
use crate::rewrite::stats::RewriteStats;
use std::collections::BTreeMap;

/// The texts with the edits, read again. A number that rounding would take beyond a limit is written one digit further inside.
/// The program as it was read is given up before its result is read, so that never two of them are held. `known`: the patches of
/// these edits, where they are made already.
pub fn write(
    format: &dyn Format,
    document: Box<dyn Document>,
    edits: &mut Edits,
    mut known: Option<Patches>,
    task: &Task,
) -> Result<(Vec<Text>, verify::Written)> {
    const TRIES: usize = 3;
    let originals = document.script().texts.clone();
    let mut document = Some(document);
    let mut before = None;
    for _ in 0..TRIES {
        let read = match document.take() {
            Some(read) => read,
            None => format.parse(originals.clone(), task.robot.axes())?,
        };
        let patches = match known.take() {
            Some(known) => known,
            None if edits.steps.is_empty() => Patches::default(),
            None => read.patches(edits)?,
        };
        if patches.is_empty() {
            return Ok((originals, verify::Written::nothing(task.robot.dof())));
        }
        // what is only looked up stands after what is written
        let (own, context) = originals.split_at(originals.iter().take_while(|t| !t.context).count());
        if patches.iter().any(|p| p.file >= own.len()) {
            let source = "an edit of a file that is only read; nothing was written".to_string();
            return Err(Error::internal("rewrite this program", source));
        }
        let bytes = text::apply(own, &patches)?;
        // of patches, program and what is left of it no more is held than the next step needs
        drop(patches);
        let before = before.get_or_insert_with(|| verify::Before::of(read.script(), edits));
        drop(read);
        let written = own.iter().zip(bytes).map(|(t, b)| t.with(b));
        let texts: Vec<Text> = written.chain(context.iter().cloned()).collect();
        let written = verify::read_again(format, before, edits, texts.clone(), task.robot)?;
        if written.beyond.is_empty() {
            return Ok((texts, written));
        }
        for b in &written.beyond {
            edits.steps.change(b.step, |edit| {
                let q = match b.point {
                    Some(n) => edit.before.get_mut(n).map(|p| &mut p.q),
                    None => edit.goal.as_mut(),
                };
                if let Some(v) = q.and_then(|q| q.get_mut(b.axis)) {
                    *v = b.inside;
                }
            });
        }
    }
    let name = originals.first().map(|t| t.name.clone()).unwrap_or_default();
    Err(Refusal::AtLimit { name }.into())
}

/// Takes out edits that the format cannot say; these moves stay as they are. Why, by step, and the patches of the others where the
/// format has made them on the way.
pub fn leave_unwritable(
    document: &dyn Document,
    edits: &mut Edits,
    stats: &mut RewriteStats,
) -> (BTreeMap<usize, Cause>, Option<Patches>) {
    let mut left = BTreeMap::new();
    loop {
        let before = left.len();
        let (unwritable, patches) = document.written_or_not(edits);
        for (step, why) in unwritable {
            if let Some(edit) = edits.steps.remove(step) {
                stats.inserted = stats.inserted.saturating_sub(edit.before.len() as u64);
                left.insert(step, Cause::Program(why));
            }
        }
        if left.len() == before {
            return (left, patches);
        }
    }
}
