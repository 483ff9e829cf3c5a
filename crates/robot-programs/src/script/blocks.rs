//! Steps of a language with blocks, as a reader collects them: a block in which nothing moves leaves no break.

use super::{At, Break, Script, Step, StepKind, Text, pragma};
use std::collections::BTreeMap;

/// Steps, and the places `S` of their moves.
pub struct Steps<S> {
    /// `None`: a break of a block that holds nothing which moves.
    steps: Vec<Option<Step>>,
    sites: BTreeMap<usize, S>,
    open: Vec<Block>,
    /// Next comment to look at.
    comment: usize,
    /// The start with which the program starts, where that is known.
    pub entry: Option<usize>,
}

/// A block that is open: its own breaks, and whether anything in it moves.
#[derive(Default)]
struct Block {
    breaks: Vec<usize>,
    busy: bool,
}

impl<S> Default for Steps<S> {
    fn default() -> Self {
        Self { steps: Vec::new(), sites: BTreeMap::new(), open: Vec::new(), comment: 0, entry: None }
    }
}

impl<S> Steps<S> {
    /// The step that comes next.
    pub fn next(&self) -> usize {
        self.steps.len()
    }

    fn add(&mut self, at: At, kind: StepKind) -> usize {
        self.steps.push(Some(Step { at, kind }));
        self.steps.len() - 1
    }

    fn busy(&mut self) {
        if let Some(block) = self.open.last_mut() {
            block.busy = true;
        }
    }

    /// A step; all but a dwell are something that moves.
    pub fn push(&mut self, at: At, kind: StepKind) -> usize {
        if !matches!(kind, StepKind::Dwell(_)) {
            self.busy();
        }
        self.add(at, kind)
    }

    /// Where the move of a step stands.
    pub fn place(&mut self, step: usize, site: S) {
        self.sites.insert(step, site);
    }

    /// Comments for the tool among `comments` that stand before a byte.
    pub fn pragmas(&mut self, text: &Text, comments: &[(usize, usize)], before: usize) {
        while let Some(&(start, end)) = comments.get(self.comment).filter(|c| c.0 < before) {
            self.comment += 1;
            if let Some(on) = pragma(text.slice(start..end)) {
                self.busy();
                self.add(At { file: 0, line: text.line_of(start) }, StepKind::Pragma(on));
            }
        }
    }

    /// A routine starts: no block is open.
    pub fn start(&mut self) {
        self.open.clear();
    }

    /// A block opens, with a break.
    pub fn open(&mut self, at: At, kind: Break) {
        self.open.push(Block::default());
        self.middle(at, kind);
    }

    /// A break that belongs to the innermost block.
    pub fn middle(&mut self, at: At, kind: Break) {
        let k = self.add(at, StepKind::Break(kind));
        if let Some(block) = self.open.last_mut() {
            block.breaks.push(k);
        }
    }

    /// The innermost block closes, with a break (`true`) unless nothing in it moves: then its own breaks go.
    pub fn close(&mut self, at: At, kind: Break) -> bool {
        match self.open.pop() {
            Some(block) if !block.busy => {
                for k in block.breaks {
                    self.steps[k] = None;
                }
                false
            }
            _ => {
                self.push(at, StepKind::Break(kind));
                true
            }
        }
    }

    /// Gives the steps that stay to the script; the places of its moves, by step.
    pub fn finish(self, script: &mut Script) -> BTreeMap<usize, S> {
        // places from the first break that goes on move up
        let gone: Vec<usize> = (0..self.steps.len()).filter(|&k| self.steps[k].is_none()).collect();
        let moved = |k: usize| k - gone.partition_point(|g| *g < k);
        let stays = |k: &usize| self.steps.get(*k).is_some_and(Option::is_some);
        if let Some(k) = self.entry.filter(stays) {
            script.entry = Some(moved(k));
        }
        // in the memory in which they stand
        script.steps = self.steps.into_iter().flatten().collect();
        if gone.is_empty() { self.sites } else { self.sites.into_iter().map(|(k, site)| (moved(k), site)).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_that_moves_nothing_leaves_no_break_and_one_around_a_busy_one_stays() {
        let at = At { file: 0, line: 1 };
        let mut steps = Steps::default();
        steps.push(at, StepKind::Break(Break::Start));
        steps.open(at, Break::Jump);
        steps.push(at, StepKind::Dwell(None));
        steps.middle(at, Break::Jump);
        assert!(!steps.close(at, Break::Jump));
        steps.open(at, Break::Loop);
        steps.open(at, Break::Jump);
        steps.entry = Some(steps.next());
        let k = steps.push(at, StepKind::Break(Break::Start));
        steps.place(k, "here");
        assert!(steps.close(at, Break::Jump) && steps.close(at, Break::Loop));
        let mut script = Script::default();
        let sites = steps.finish(&mut script);
        let breaks: Vec<Option<Break>> = script
            .steps
            .iter()
            .map(|s| match s.kind {
                StepKind::Break(kind) => Some(kind),
                _ => None,
            })
            .collect();
        let [start, jump, round] = [Break::Start, Break::Jump, Break::Loop].map(Some);
        assert_eq!(breaks, [start, None, round, jump, start, jump, round]);
        assert_eq!((script.entry, sites.get(&4)), (Some(4), Some(&"here")));
    }
}
