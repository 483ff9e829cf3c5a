//! Edits to patches.
//!
//! The text is gone through once with two positions: where the axes stood and where they will stand. A block is written
//! again where it is edited, or where what it leads to would change: relative words take up what was changed before them, and
//! an arc between ends that moved differently gets a centre that fits both. So the place after every block is the wanted one, and
//! rounding never adds up.

use super::reason::Reason;
use super::statements::{Places, Program, Statement, canonical, most};
use crate::axes::JointKind;
use crate::decimal::POW10;
use crate::error::{Error, Result};
use crate::script::number::{self, Own, Style};
use crate::script::{self, AxisSet, Break, EditRef, Edits, Goal, Move, Patches, StepKind};
use std::ops::Range;

/// Two places are one, mm or deg.
pub(super) const SAME: f64 = 1e-9;
/// An axis that a block does not name moves with it only by less than this, mm or deg: it is an offset.
const OFFSET: f64 = 5.0;
/// Axes of nearly every machine.
const MOST_AXES: usize = 8;
/// Most decimals with which a place that shall stay is written.
const FULL: u8 = 12;

/// An edit that the words of a block cannot say.
#[derive(Debug)]
pub(super) struct Unwritable {
    pub(super) step: usize,
    pub(super) why: script::Reason,
}

pub(super) type Written<T = ()> = std::result::Result<T, Unwritable>;

pub(super) fn patches(program: &Program, edits: &Edits) -> Result<Patches> {
    written(program, edits, None).map_err(|u| {
        let place = program.script.steps.get(u.step).map(|s| program.script.place(s.at).to_string());
        Error::Refused(format!("{}: {}; nothing was written", place.unwrap_or_default(), u.why))
    })
}

/// Edited moves that cannot be written, and why; a block that is not edited itself stands for the edit before it.
/// Where there are none, the patches.
pub(super) fn written_or_not(program: &Program, edits: &Edits) -> (Vec<(usize, script::Reason)>, Option<Patches>) {
    let mut found = Vec::new();
    let patches = match written(program, edits, Some(&mut found)) {
        Ok(patches) => Some(patches).filter(|_| found.is_empty()),
        Err(u) => {
            found.push(u);
            None
        }
    };
    let edited = |u: &Unwritable| edits.steps.last_until(u.step);
    (found.into_iter().filter_map(|u| Some((edited(&u)?, u.why))).collect(), patches)
}

/// One pass over the text. With `left`, blocks that cannot be written are collected there and stay as they are.
fn written(program: &Program, edits: &Edits, mut left: Option<&mut Vec<Unwritable>>) -> Written<Patches> {
    if edits.steps.is_empty() {
        return Ok(Patches::default());
    }
    let dof = program.letters.len();
    let Some(text) = program.script.texts.first() else { return Ok(Patches::default()) };
    let mut writer = Writer {
        program,
        edits,
        patches: Patches::with_capacity(edits.steps.likely_patches()),
        now: vec![None; dof],
        decimals: vec![0; dof],
        relative: None,
        room: Vec::new(),
    };
    for (step, one) in program.script.steps.iter().enumerate() {
        let edit = edits.steps.get(step);
        if writer.plain(step, edit) {
            continue;
        }
        let statement = || program.statements.get(step, text, &program.letters);
        let is_move = matches!(one.kind, StepKind::Move(_));
        let done = match (&one.kind, is_move.then(statement).flatten()) {
            (StepKind::Move(_), Some(statement)) => writer.block(step, &statement, edit),
            (StepKind::Move(_), None) if edit.is_some_and(|e| e.goal.is_some() || !e.before.is_empty()) => {
                Err(writer.refused(step, Reason::NoTarget))
            }
            (StepKind::Move(m), None) => writer.forget(m.moves_alone),
            (StepKind::Break(Break::Axes(axes)), _) => writer.forget(Some(*axes)),
            (StepKind::Break(_), _) => writer.forget(None),
            _ if edit.is_some() => Err(writer.refused(step, Reason::NoMove)),
            _ => Ok(()),
        };
        match (done, &mut left) {
            (Ok(()), _) => {}
            (Err(u), None) => return Err(u),
            (Err(u), Some(left)) => {
                left.push(u);
                writer.start_anew();
            }
        }
    }
    writer.forget(None)?;
    Ok(writer.patches)
}

/// Digits after the point, at least `decimals`, with which a word of this value leads to its place within [`SAME`].
pub(super) fn without_loss(value: f64, unit: f64, mut decimals: u8) -> u8 {
    let off = |d: u8| {
        let power = POW10[usize::from(d)]; // at most FULL
        (value - (value * power).round() / power).abs()
    };
    while decimals < FULL && off(decimals) * unit > SAME {
        decimals += 1;
    }
    decimals
}

pub(super) struct Writer<'a> {
    pub(super) program: &'a Program,
    pub(super) edits: &'a Edits,
    pub(super) patches: Patches,
    /// By axis: where it will stand, mm or deg; `None`: not known.
    pub(super) now: Vec<Option<f64>>,
    /// By axis: most decimals used since its last absolute word, in mm or deg.
    pub(super) decimals: Vec<u8>,
    /// The last block, if it is relative, and how far the axes stand from where they stood after it.
    pub(super) relative: Option<(usize, f64)>,
    /// Where a number is put together.
    pub(super) room: Vec<u8>,
}

impl Writer<'_> {
    pub(super) fn refused(&self, step: usize, why: impl Into<script::Reason>) -> Unwritable {
        Unwritable { step, why: why.into() }
    }

    /// After a block that was not written all axes stand where they always did.
    fn start_anew(&mut self) {
        self.relative = None;
        self.now.fill(None);
        self.decimals.fill(0);
    }

    /// The position of some axes (`None`: of all) is lost: after relative words nothing may be left over.
    pub(super) fn forget(&mut self, axes: Option<AxisSet>) -> Written {
        if let Some((step, left)) = self.relative.take()
            && left > SAME
        {
            return Err(self.refused(step, Reason::RelativeLeft));
        }
        for a in (0..self.now.len()).filter(|a| axes.is_none_or(|axes| axes.has(*a))) {
            (self.now[a], self.decimals[a]) = (None, 0);
        }
        Ok(())
    }

    /// Refuses an edit that the move does not take.
    fn refuse_edit(&self, step: usize, m: &Move, edit: EditRef) -> Written {
        if edit.as_joint_moves {
            return Err(self.refused(step, Reason::JointMove));
        }
        if let (Some(why), true) = (&m.fixed, edit.goal.is_some()) {
            return Err(self.refused(step, why.clone()));
        }
        if let (Some(why), false) = (&m.closed, edit.before.is_empty()) {
            return Err(self.refused(step, Reason::Closed(Box::new(why.clone()))));
        }
        Ok(())
    }

    /// Goes through a block whose words need not be read again: one that stays, or a straight move in absolute words that names every axis
    /// whose place is known and gets another goal. `false`: it is no such block, and [`Self::block`] goes through it.
    fn plain(&mut self, step: usize, edit: Option<EditRef>) -> bool {
        let program = self.program;
        let Some(StepKind::Move(m)) = program.script.steps.get(step).map(|s| &s.kind) else { return false };
        let Some(s) = program.statements.places_of(step, self.now.len()) else { return false };
        let Some(edit) = edit else {
            let stands = |(now, start): (&Option<f64>, &f64)| now.is_none_or(|now| (now - start).abs() <= SAME);
            if self.relative.is_some_and(|(_, left)| left > SAME) || !self.now.iter().zip(s.start).all(stands) {
                return false;
            }
            for (now, place) in self.now.iter_mut().zip(s.goal.iter().zip(s.start)) {
                let known = |v: &f64| Some(*v).filter(|v| !v.is_nan());
                *now = known(place.0).or(*now).or(known(place.1));
            }
            self.relative = (!s.absolute).then_some((step, 0.0));
            return true;
        };
        let (Goal::Joints(t), Some(asked)) = (&m.goal, edit.goal) else { return false };
        let (Some(target), Some(text)) = (program.script.targets.get(*t), program.script.texts.first()) else {
            return false;
        };
        let simple = s.absolute && s.plain && edit.before.is_empty() && !edit.as_joint_moves && m.fixed.is_none();
        let mut words = [None; MOST_AXES];
        if !simple || asked.len() != self.now.len() || asked.len() > MOST_AXES {
            return false;
        }
        for (a, word) in words.iter_mut().enumerate().take(asked.len()).filter(|(a, _)| !s.goal[*a].is_nan()) {
            let want = asked[a] / program.si[a];
            let value = target.values.get(a).filter(|_| want.is_finite() && want.abs() <= 1e7);
            let read = value.and_then(|v| Some((v, number::read(text.slice(v.span()))?)));
            let Some((value, (before, style))) = read else { return false };
            *word = Some((want, value, before, style));
        }
        for (now, start) in self.now.iter_mut().zip(s.start) {
            *now = now.or(Some(*start).filter(|v| !v.is_nan()));
        }
        for (a, word) in words.iter().enumerate() {
            if let Some((want, value, before, style)) = *word {
                let own = Own { text: text.slice(value.span()), value: before, style: Style { plus: false, ..style } };
                self.number(a, want, own, value.span(), &s);
            }
        }
        self.relative = None;
        true
    }

    /// Writes the number of an axis in an absolute word where it stands, so that the axis comes to `want`.
    fn number(&mut self, a: usize, want: f64, own: Own, span: Range<usize>, s: &Places) {
        let (unit, base) = (s.unit[a], s.shift[a]);
        let Own { value: before, style, .. } = own;
        let value = (want - base) / unit;
        let stays = (s.goal[a] - want).abs() <= SAME;
        let decimals = self.digits(a, unit, style, value, stays);
        let mut room = std::mem::take(&mut self.room);
        room.clear();
        number::append_moved(&mut room, own, value, style, decimals);
        let written = number::read(&room).map_or(value, |n| n.0);
        let kept = written == before && !(stays && (base + before * unit - want).abs() > SAME);
        if !kept {
            self.patches.put(0, span, &room);
        }
        self.room = room;
        self.decimals[a] = if kept { 0 } else { decimals };
        self.now[a] = Some(canonical(base + written * unit));
    }

    /// Digits after the point of a word with the value `value`; `stays`: no edit moves the axis, and it loses no digit.
    fn digits(&self, a: usize, unit: f64, style: Style, value: f64, stays: bool) -> u8 {
        let most = most(self.kind(a), unit).max(style.decimals);
        let digit = self.edits.digit.get(a).copied().unwrap_or(0.0) / self.program.si[a] / unit;
        let decimals = number::decimals_for(style, digit, most);
        if stays { without_loss(value, unit, decimals) } else { decimals }
    }

    pub(super) fn block(&mut self, step: usize, s: &Statement, edit: Option<EditRef>) -> Written {
        let StepKind::Move(m) = &self.program.script.steps[step].kind else { return Ok(()) };
        let dof = s.goal.len();
        for a in 0..dof {
            if self.now[a].is_none() {
                self.now[a] = s.start[a];
            }
        }
        if let Some(edit) = edit {
            self.refuse_edit(step, m, edit)?;
        }
        // nothing has changed so far, and nothing shall: the block stays
        let stands = |a: usize| match (self.now[a], s.start[a]) {
            (Some(x), Some(y)) => (x - y).abs() <= SAME,
            (x, y) => x.is_none() && y.is_none(),
        };
        if edit.is_none() && self.relative.is_none_or(|(_, left)| left <= SAME) && (0..dof).all(stands) {
            for (now, goal) in self.now.iter_mut().zip(&s.goal) {
                *now = goal.or(*now);
            }
            self.relative = (!s.absolute).then_some((step, 0.0));
            return Ok(());
        }
        if (s.arc.is_some() || !s.absolute) && self.program.marker == Some(s.line) {
            return Err(self.refused(step, Reason::Mixed));
        }
        let commanded = |a: usize| match m.goal {
            Goal::Joints(t) => self.program.script.targets.get(t).is_some_and(|t| t.values.get(a).is_some()),
            _ => false,
        };
        let asked = edit.and_then(|e| e.goal);
        let goal: Vec<Option<f64>> = (0..dof)
            .map(|a| {
                let own = s.goal[a]?;
                let asked = asked.and_then(|q| q.get(a)).map(|q| q / self.program.si[a]);
                if commanded(a) {
                    return Some(asked.unwrap_or(own));
                }
                // an axis that the block does not name stays where it is, or takes up an offset
                asked.filter(|v| (v - own).abs() < OFFSET)
            })
            .collect();
        if goal.iter().flatten().any(|v| !v.is_finite() || v.abs() > 1e7) {
            return Err(self.refused(step, Reason::TooFar));
        }
        match &s.arc {
            None => self.line(step, s, edit, &goal)?,
            Some((arc, centre)) => self.arc(step, s, edit, &goal, arc, *centre)?,
        }
        let left = self
            .now
            .iter()
            .zip(&s.goal)
            .filter_map(|(n, g)| Some((n.as_ref()? - g.as_ref()?).abs()))
            .fold(0.0, f64::max);
        self.relative = (!s.absolute).then_some((step, left));
        Ok(())
    }

    pub(super) fn line(&mut self, step: usize, s: &Statement, edit: Option<EditRef>, goal: &[Option<f64>]) -> Written {
        for point in edit.iter().flat_map(|e| e.before) {
            let want = self.wanted(step, s, &point.q)?;
            let leg = self.leg(s, &want, false);
            self.insert(s, &leg, s.motion, None);
            if point.waits {
                self.wait(step, s);
            }
            self.now = leg.to;
        }
        let leg = self.leg(s, goal, true);
        self.replace(s, leg.words);
        self.now = leg.to;
        Ok(())
    }

    /// Places that a new point asks for, mm or deg, on the axes that are known.
    pub(super) fn wanted(&self, step: usize, s: &Statement, q: &[f64]) -> Written<Vec<Option<f64>>> {
        let want: Vec<Option<f64>> = (0..s.goal.len())
            .map(|a| {
                let v = q.get(a)? / self.program.si[a];
                // an axis that was never named is not known to anyone
                s.goal[a].map(|_| v)
            })
            .collect();
        if want.iter().flatten().any(|v| !v.is_finite() || v.abs() > 1e7) {
            return Err(self.refused(step, Reason::PointTooFar));
        }
        Ok(want)
    }

    pub(super) fn style(&self, s: &Statement, axis: usize) -> Style {
        let own = |a: usize| s.axis_word(a)?.value.map(|v| v.1);
        let any = || (0..s.axis_words.len()).find_map(own);
        own(axis).or_else(any).map_or(Style::default(), |st| Style { plus: false, ..st })
    }

    pub(super) fn kind(&self, axis: usize) -> JointKind {
        if self.program.si[axis] == JointKind::Revolute.si_per_user_unit() {
            JointKind::Revolute
        } else {
            JointKind::Prismatic
        }
    }
}
