//! Motions that the lexer passed over, as they differ from the one before them in their joint values alone
//! ([`alike`](crate::script::alike)).
//!
//! They are read with the last of the two that have tokens, if both were found to go in the same way to joint values in them, with the same
//! external axes, and to leave nothing behind: no step beside them, no note.

use super::Builder;
use crate::rapid::built::{Literal, SharedSite, Site, Written};
use crate::rapid::read::{Item, ItemKind};
use crate::rapid::value::axis_value;
use crate::script::alike::{Anchors, Moves, Passed};
use crate::script::{At, Goal, StepKind, Value};
use std::sync::Arc;

/// A value of a target: a number of the form, or one that is the same in all lines.
enum Place {
    Number(usize),
    Same(Value),
    None,
}

impl Site {
    /// That of a line of the same form.
    pub(in crate::rapid) fn moved(&self, by: Moves) -> Self {
        let written = |w: &Written| Written {
            bytes: by.span(w.bytes),
            switches: w.switches.iter().map(|(name, bytes)| (name.clone(), by.span(*bytes))).collect(),
        };
        Self {
            bytes: by.span(self.bytes),
            word: by.span(self.word),
            point: by.span(self.point),
            args: self.args.iter().map(written).collect(),
            goal: self.goal,
            zone: self.zone,
            ..Self::default()
        }
    }

    /// Whether it is known where all of it stands in another line.
    fn is_told(&self, at: &Anchors) -> bool {
        let told = |w: &Written| at.tell_span(w.bytes) && w.switches.iter().all(|s| at.tell_span(s.1));
        let plain = self.time.is_none() && self.external.is_none() && self.via.is_none();
        plain && [self.bytes, self.word, self.point].iter().all(|s| at.tell_span(*s)) && self.args.iter().all(told)
    }
}

impl Builder<'_> {
    /// Adds the lines after the item that was read last; `None`: they may be more than its numbers.
    pub(super) fn again(&mut self, item: &Item, lines: &Passed) -> Option<()> {
        // numbers without a joint are in no list of values
        let ItemKind::Call { alone: false } = item.kind else { return None };
        if self.without_joint.is_some() {
            return None;
        }
        let (text, bytes) = (self.f.text, self.f.text.bytes.as_slice());
        let mut numbers = Vec::new();
        let [before, model] = lines.anchors(bytes, &mut numbers)?;
        let last = self.steps.next().checked_sub(1)?;
        let (a, b) = (self.steps.joint_move(last.checked_sub(1)?)?, self.steps.joint_move(last)?);
        let site = self.steps.last_place()?.shown();
        let same = a.0.shares_how(b.0) && a.1 + 1 == b.1 && b.1 + 1 == self.targets.len();
        let both = self.steps.place_before_last()?.shown().moved(before.to(model)) == site && site.is_told(&model);
        let literal = self.literals.last().filter(|l| l.owner.is_none() && l.foreign.is_none())?.bytes;
        let [.., external_before, external] = self.externals.as_slice() else { return None };
        let external = Arc::clone(external);
        let stays = *external_before == external && self.external.as_deref() == Some(&*external);
        let first = self.f.p.tokens.get(item.span.start)?.start();
        let here = first >= model.start && text.line_of(first) == text.line_of(model.start);
        if !(same && both && stays && here && model.tell_span(literal)) {
            return None;
        }
        let target = self.targets.get(b.1)?;
        let place = |value: Option<Value>| match value {
            None => Some(Place::None),
            Some(v) => match numbers.iter().position(|n| n.start == v.start && n.end == v.end) {
                Some(n) => Some(Place::Number(n)),
                None => (v.start >= model.last).then_some(Place::Same(v)),
            },
        };
        let places = target.values.iter().map(place).collect::<Option<Vec<Place>>>()?;
        let kinds: Vec<_> = self.robot.axis_joints().map(|j| j.kind).collect();
        let (file, line) = (target.at.file, target.at.line);
        let motion = b.0.clone();
        let of_model = Arc::new((site, model));
        for (k, start) in lines.lines.iter().enumerate() {
            lines.form.read(bytes, *start as usize, &mut numbers)?;
            let anchors = Anchors::of(*start as usize, &numbers)?;
            let by = model.to(anchors);
            let at = At { file, line: line + 1 + k as u64 };
            let value = |(place, kind): (&Place, &_)| match place {
                Place::Number(n) => numbers.get(*n).map(|n| axis_value(*kind, n.value, n.style, n.start..n.end)),
                Place::Same(v) => Some(Value { start: by.byte(v.start), end: by.byte(v.end), ..*v }),
                Place::None => None,
            };
            let goal = Goal::Joints(self.targets.len());
            self.targets.push_numbers(None, None, at, places.iter().zip(&kinds).map(value));
            self.externals.push(Arc::clone(&external));
            self.literals.push(Literal { bytes: by.span(literal), owner: None, foreign: None });
            let step = self.steps.push(at, StepKind::Move(motion.alike(goal)));
            self.steps.place(step, SharedSite::new(&of_model, anchors));
        }
        Some(())
    }
}
