//! Motions that the lexer passed over, as they differ from the one before them in their joint values alone
//! ([`alike`](crate::script::alike)).
//!
//! They are read with the last of the two that have tokens, if both were found to go in the same way to joint values in them, and to leave
//! no step beside them.

use super::{Builder, Literal, Site};
use crate::script::alike::{Anchors, Moves, Passed};
use crate::script::{At, Goal, StepKind};
use crate::urscript::read::{Item, ItemKind};
use crate::urscript::value::plain_axis_value;
use std::sync::Arc;

impl Site {
    /// That of a line of the same form.
    fn moved(&self, by: Moves) -> Self {
        Self {
            bytes: by.span(self.bytes),
            goal: by.span(self.goal),
            point: by.span(self.point),
            blend: self.blend.map(|bytes| by.span(bytes)),
            ..Self::default()
        }
    }

    /// Whether it is known where all of it stands in another line.
    fn is_told(&self, at: &Anchors) -> bool {
        let plain = self.time.is_none() && self.via.is_none() && self.blend.is_none_or(|bytes| at.tell_span(bytes));
        plain && [self.bytes, self.goal, self.point].iter().all(|s| at.tell_span(*s))
    }
}

impl Builder<'_> {
    /// Adds the lines after the item that was read last; `None`: they may be more than its numbers.
    pub(super) fn again(&mut self, item: &Item, lines: &Passed) -> Option<()> {
        // numbers without a joint are in no list of values
        if self.without_joint.is_some() {
            return None;
        }
        let (text, bytes) = (self.text, self.text.bytes.as_slice());
        let mut numbers = Vec::new();
        let [before, model] = lines.anchors(bytes, &mut numbers)?;
        let last = self.steps.next().checked_sub(1)?;
        let (a, b) = (self.steps.joint_move(last.checked_sub(1)?)?, self.steps.joint_move(last)?);
        let site = self.steps.last_place()?.clone();
        let same = a.0.shares_how(b.0) && a.1 + 1 == b.1 && b.1 + 1 == self.targets.len();
        let both = self.steps.place_before_last()?.moved(before.to(model)) == site && site.is_told(&model);
        let literal = self.literals.last().filter(|l| l.owner.is_none() && l.units.iter().all(|u| *u == 1.0))?.clone();
        let first = self.p.tokens.get(item.span.start)?.start();
        let line = text.line_of(model.start);
        let here = item.kind == ItemKind::Other && first >= model.start && text.line_of(first) == line;
        let target = self.targets.get(b.1)?;
        // each number is that of its axis
        let in_order = target.values.len() <= numbers.len()
            && target.values.iter().zip(&numbers).all(|(v, n)| v.is_some_and(|v| v.span() == (n.start..n.end)));
        if !(same && both && here && in_order && model.tell_span(literal.bytes) && target.at.line == line) {
            return None;
        }
        let (axes, motion) = (target.values.len(), b.0.clone());
        for (k, start) in lines.lines.iter().enumerate() {
            lines.form.read(bytes, *start as usize, &mut numbers)?;
            let by = model.to(Anchors::of(*start as usize, &numbers)?);
            let at = At { file: 0, line: line + 1 + k as u64 };
            let goal = Goal::Joints(self.targets.len());
            let values = numbers.iter().take(axes).map(|n| Some(plain_axis_value(n.value, n.style, n.start..n.end)));
            self.targets.push_numbers(None, None, at, values);
            let units = Arc::clone(&literal.units);
            self.literals.push(Literal { bytes: by.span(literal.bytes), units, owner: None, folded: None });
            let step = self.steps.push(at, StepKind::Move(motion.alike(goal)));
            self.steps.place(step, site.moved(by));
        }
        Some(())
    }
}
