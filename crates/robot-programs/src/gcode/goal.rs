//! Where a block leads: frames, arcs, and why it cannot be determined.

use super::arc::{Arc, Centre, NoArc};
use super::codes::{AXES, SPLINES};
use super::lex::{Block, Word};
use super::read::Reader;
use super::reason::{Elsewhere, Reason};
use super::statements::{Statement, axis_words, canonical, most, motion_word};
use crate::axes::JointKind;
use crate::error::Result;
use crate::script::number::last_digit;
use crate::script::{At, Goal, How, Move, Note, PathKind, Speed, StepKind, Target, Value, Way};
use std::sync::Arc as Shared;

/// Last digits between a quadrant and an end of its arc, at least.
const NEAR_DIGITS: f64 = 10.0;
/// A number with coarser digits is meant as it is written, mm.
const COARSE_MM: f64 = 1e-3;

impl Reader<'_> {
    /// By axis of the robot: the block's words, mm or deg; `Err`: an axis word that is no literal.
    pub(super) fn axis_values(&self, block: &Block) -> std::result::Result<Vec<Option<f64>>, ()> {
        let mut values = vec![None; self.letters.len()];
        for w in block.words.iter().filter(|w| AXES.contains(&w.letter)) {
            let (Some((v, style)), Some(inch)) = (w.value, self.inch) else { return Err(()) };
            if !style.point && v != 0.0 && self.survey.may_count() {
                return Err(());
            }
            if let Some(a) = self.letters.iter().position(|&l| l == w.letter) {
                if self.across.is_none() && self.is_across(a) {
                    return Err(());
                }
                values[a] = Some(v * self.unit(a, inch));
            }
        }
        Ok(values)
    }

    /// mm or deg of one unit of a word.
    pub(super) fn unit(&self, axis: usize, inch: bool) -> f64 {
        let unit = if inch && self.robot.axis(axis).kind == JointKind::Prismatic { 25.4 } else { 1.0 };
        unit * self.across_factor(axis)
    }

    /// Why a block's goal cannot be determined.
    pub(super) fn unclear(&self, block: &Block) -> Option<Reason> {
        if let Some(doubt) = self.strange.or(self.modal_macro).or(self.compensation) {
            return Some(doubt.into());
        }
        match self.motion {
            Some(0 | 10 | 20 | 30) => {}
            Some(c) if SPLINES.contains(&c) => return Some(Reason::Spline(c)),
            Some(c) if c < 700 => return Some(Reason::Probe(c)),
            Some(c) => return Some(Reason::Canned(c)),
            None => return Some(Reason::NoMotion),
        }
        let Some(absolute) = self.absolute else { return Some(Reason::NoDistance) };
        if self.inch.is_none() {
            return Some(Reason::NoUnit);
        }
        if self.frame_to_name {
            return Some(Reason::NoFrame);
        }
        // without the comma, as lathes write it: the way ends beside the place that is written, and goes on from there
        let cuts = |w: &&Word| b"IJKR".contains(&w.letter) && w.value.is_none_or(|v| v.0 != 0.0);
        if let (Some(0 | 10), Some(w)) = (self.motion, block.words.iter().find(cuts)) {
            return Some(Reason::CornerWord(w.letter as char));
        }
        let mut seen = 0u64;
        for w in &block.words {
            let axis = self.letters.iter().position(|&l| l == w.letter);
            let geometry = AXES.contains(&w.letter) || b"IJKR".contains(&w.letter);
            let name = w.letter as char;
            // letters are bytes 65 to 90
            let bit = 1 << (w.letter & 63);
            if geometry && seen & bit != 0 {
                return Some(Reason::Twice(name));
            }
            seen |= if geometry { bit } else { 0 };
            if AXES.contains(&w.letter) && axis.is_none() {
                return Some(Reason::NoAxis(name));
            }
            let Some((v, style)) = w.value else {
                if geometry {
                    return Some(Reason::Expression);
                }
                continue;
            };
            if geometry && !style.point && v != 0.0 && self.survey.may_count() {
                return Some(if self.survey.points { Reason::NoPoint } else { Reason::WholeNumbers });
            }
            let Some(axis) = axis else { continue };
            if !absolute && self.position[axis].is_none() {
                return Some(Reason::RelativeToUnknown);
            }
        }
        None
    }

    /// The first motion says in which frame the axes are counted.
    fn refer(&mut self, block: &Block) {
        self.reference = self.reference.or(self.frame).or(Some(540));
        self.frame = self.frame.or(Some(540));
        if self.letters.contains(&b'Z') && block.words.iter().any(|w| w.letter == b'Z') {
            self.length_reference.get_or_insert_with(|| self.length.clone());
        }
    }

    pub(super) fn movement(
        &mut self,
        k: usize,
        block: Block,
        codes: &[Option<u32>],
        unclear: Option<Reason>,
        exact: bool,
    ) -> Result<()> {
        self.refer(&block);
        self.keep_before_relative(&block);
        self.keep_before_half_turn(&block);
        let unclear = unclear.or_else(|| self.unclear(&block));
        if unclear.is_none() && self.leaves_across(k, &block) {
            return Ok(());
        }
        let elsewhere = match unclear {
            Some(Reason::NoPoint) => Some(Elsewhere::NoPoint),
            Some(Reason::BothDistances) => Some(Elsewhere::BothDistances),
            Some(Reason::Expression) => Some(Elsewhere::Expression),
            _ => None,
        };
        if elsewhere.is_some_and(|why| self.leaves_named(k, &block, why)) {
            return Ok(());
        }
        if let Some(Reason::Canned(c)) = unclear
            && let Some(hole) = self.hole(&block, codes, c)
        {
            return self.drills(k, block, codes, exact, hole);
        }
        let Some((motion, inch)) = self.motion.zip(self.inch).filter(|_| unclear.is_none()) else {
            return self.leaves(k, &block, unclear.unwrap_or(Reason::NoMotion));
        };
        self.rolls_over(k, &block);
        let absolute = self.absolute == Some(true);
        let start = self.position.clone();
        let (unit, shift) = self.units_and_shifts(inch);
        let goal = self.named_goal(&block, &start, &unit, &shift, absolute)?;
        let arc = match motion {
            20 | 30 => match self.arc(&block, &start, &goal, &shift, inch, motion == 30) {
                Ok(arc) => Some(arc),
                Err(why) => return self.leaves(k, &block, why.into()),
            },
            _ => None,
        };
        if goal.iter().all(Option::is_none) {
            // an extruder alone
            return Ok(());
        }
        let statement = Statement {
            line: k,
            motion: (motion / 10) as u8,
            motion_word: motion_word(&block.words, motion),
            folded: block.folded,
            absolute,
            axis_words: axis_words(&block.words, self.letters),
            unit,
            shift,
            start,
            goal,
            arc,
            words: block.words,
        };
        self.place(k, statement, codes, exact);
        Ok(())
    }

    /// The units of the axes and how far their numbers are shifted, in the memory of those of the block before.
    pub(super) fn units_and_shifts(&mut self, inch: bool) -> (Shared<[f64]>, Shared<[f64]>) {
        let dof = self.letters.len();
        let unit = shared(&self.units, dof, |a| self.unit(a, inch));
        self.units = Shared::clone(&unit);
        let shift = shared(&self.shifts, dof, |a| self.shift(a));
        self.shifts = Shared::clone(&shift);
        (unit, shift)
    }

    /// Where the words of a block lead, by axis.
    pub(super) fn named_goal(
        &mut self,
        block: &Block,
        start: &[Option<f64>],
        unit: &[f64],
        shift: &[f64],
        absolute: bool,
    ) -> Result<Vec<Option<f64>>> {
        let mut goal = start.to_vec();
        for w in &block.words {
            let (Some(a), Some((v, style))) = (self.letters.iter().position(|&l| l == w.letter), w.value) else {
                continue;
            };
            let from = if absolute { shift[a] } else { start[a].unwrap_or(0.0) };
            let at = canonical(from + v * unit[a]);
            if at.is_nan() || at.abs() >= 1e7 {
                let found = String::from_utf8_lossy(self.text.slice(w.span())).into_owned();
                return Err(self.text.bad(w.span().start, found, "a place within 10 km, or 10,000,000 degrees"));
            }
            goal[a] = Some(at);
            self.digit[a] = self.weight(a, unit[a], style.decimals);
        }
        Ok(goal)
    }

    /// The step of a motion, and the position after it.
    fn place(&mut self, k: usize, statement: Statement, codes: &[Option<u32>], exact: bool) {
        let m = self.describe(&statement, codes, exact);
        let step = self.put(k, &statement, m);
        let mut alike = std::mem::take(&mut self.alike);
        alike.learn(self, &statement, step);
        self.alike = alike;
        self.statements.push(step, statement);
    }

    /// The same as far as nothing is learned of its block; its statement is still to be kept.
    pub(super) fn put(&mut self, k: usize, statement: &Statement, mut m: Move) -> usize {
        if self.survey.marker() == Some(k) {
            // its numbers say how those without a point are to be read: one must not go
            m.fixed = Some(Reason::Mixed.into());
        }
        self.target(statement);
        self.position.clear();
        self.position.extend_from_slice(&statement.goal);
        self.relative |= !statement.absolute;
        self.note(k);
        let step = self.script.steps.len();
        (self.last, self.settled) = (Some(step), false);
        self.step(k, StepKind::Move(m), None);
        step
    }

    pub(super) fn note(&mut self, k: usize) {
        if !self.has_noted {
            self.has_noted = true;
            let text = "positions are taken as those of the axes: work offsets and tool lengths are not in the program";
            self.script.notes.push(Note { place: At::of_line(k), text: text.into() });
        }
    }

    /// Weight of a word's last digit, rad or m.
    pub(super) fn weight(&self, axis: usize, unit: f64, decimals: u8) -> f64 {
        self.robot.axis(axis).kind.si_per_user_unit() * unit * last_digit(decimals)
    }

    pub(super) fn arc(
        &self,
        block: &Block,
        start: &[Option<f64>],
        goal: &[Option<f64>],
        shift: &[f64],
        inch: bool,
        ccw: bool,
    ) -> std::result::Result<(Arc, Centre), NoArc> {
        let Some(plane) = self.plane_of_lathe().or(self.plane) else { return Err(NoArc::NoPlane) };
        let axis = |l: u8| {
            let a = self.letters.iter().position(|&x| x == l)?;
            (self.robot.axis(a).kind == JointKind::Prismatic).then_some(a)
        };
        let (Some(u), Some(v)) = (axis(plane[0]), axis(plane[1])) else {
            return Err(NoArc::ForeignPlane);
        };
        let at = |p: &[Option<f64>]| p[u].zip(p[v]).map(|(a, b)| [a, b]);
        let (Some(from), Some(to)) = (at(start), at(goal)) else {
            return Err(NoArc::NoStart);
        };
        if Self::number(block, b'P').is_some_and(|p| p != 1.0) {
            return Err(NoArc::SeveralTurns);
        }
        let mm = if inch { 25.4 } else { 1.0 };
        let letter = |axis: u8| b'I' + (axis - b'X');
        let word = |axis: u8| Self::number(block, letter(axis)).map(|v| v * mm);
        let centre = [word(plane[0]), word(plane[1])];
        if word(plane[2]).is_some() {
            return Err(NoArc::OutsidePlane);
        }
        match (Self::number(block, b'R'), centre) {
            (Some(r), [None, None]) => Ok((Arc::of_radius([u, v], from, to, r * mm, ccw)?, Centre::Radius)),
            (None, [a, b]) if a.is_some() || b.is_some() => {
                let about = |p: [f64; 2]| Arc::about([u, v], from, to, p, ccw);
                if self.centre_absolute {
                    // a diameter on some controls
                    if [u, v].iter().any(|a| self.across_factor(*a) != 1.0) {
                        return Err(NoArc::CentreAcross);
                    }
                    let [Some(a), Some(b)] = [a, b] else {
                        return Err(NoArc::HalfCentre);
                    };
                    Ok((about([a + shift[u], b + shift[v]])?, Centre::Absolute))
                } else {
                    Ok((about([from[0] + a.unwrap_or(0.0), from[1] + b.unwrap_or(0.0)])?, Centre::Relative))
                }
            }
            _ => Err(NoArc::NoCentre),
        }
    }

    pub(super) fn describe(&self, s: &Statement, codes: &[Option<u32>], exact: bool) -> Move {
        let turning = (0..s.axis_words.len())
            .any(|a| s.axis_words[a].is_some() && self.robot.axis(a).kind == JointKind::Revolute);
        let mm = if self.inch == Some(true) { 25.4 } else { 1.0 };
        let speed = match (self.feed, self.feed_mode) {
            (Some(f), 93) if f > 0.0 => Speed::Seconds(60.0 / f),
            (Some(f), 94) if f > 0.0 && s.motion > 0 && !turning => Speed::Tcp(f * mm * 1e-3 / 60.0),
            _ => Speed::Unknown,
        };
        let other = s.words.iter().find(|w| !b"NGFIJKR".contains(&w.letter) && !self.letters.contains(&w.letter));
        let before = self.script.steps.last().filter(|b| b.at.line == s.line as u64 + 1);
        let closed = if before.is_some_and(|b| !matches!(b.kind, StepKind::Dwell(_) | StepKind::Process(_))) {
            Some(if self.is_after_rollover() { Reason::RollsOver } else { Reason::SharedLine })
        } else if self.feed_mode == 93 && s.motion > 0 {
            Some(Reason::InverseTime)
        } else if s.words.iter().any(|w| w.letter == b'F' && w.value.is_none()) {
            Some(Reason::FeedComputed)
        } else if codes.iter().flatten().any(|c| [93, 301, 281].contains(c)) {
            Some(Reason::OtherGWord)
        } else {
            other.map(|w| Reason::ActsOnce(w.letter as char))
        };
        let way = s.arc.as_ref().map(|(arc, _)| self.way(s, arc)).unwrap_or_default();
        let path = if s.arc.is_some() { PathKind::Curve } else { PathKind::Joint };
        let axes = || 0..self.letters.len();
        let how = How {
            path,
            closed: closed.map(Into::into),
            speed,
            blend_m: exact.then_some(0.0),
            turns_known: true,
            unplaced: axes().filter(|a| self.is_unplaced(*a)).collect(),
            displaced: axes().filter(|a| self.is_displaced(*a)).collect(),
            ..How::default()
        };
        Move::new(how, Goal::Joints(self.script.targets.len()), way)
    }

    pub(super) fn way(&self, s: &Statement, arc: &Arc) -> Vec<Way> {
        let least_mm = 1e-5;
        // an end may stand that far from where it was meant: a turn within its last digits is rounding, and no arc is written there
        let digit = |a: usize| self.digit[a] / self.robot.axis(a).kind.si_per_user_unit();
        let apart_mm = NEAR_DIGITS * digit(arc.u).max(digit(arc.v)).min(COARSE_MM);
        let point = |share: f64| {
            let si = |(a, v): (usize, f64)| v * self.robot.axis(a).kind.si_per_user_unit();
            Way { share, q: s.on_arc(arc, share).into_iter().enumerate().map(si).collect() }
        };
        arc.quadrants(least_mm, apart_mm).into_iter().map(point).collect()
    }

    pub(super) fn target(&mut self, s: &Statement) {
        let value = |a: usize| {
            let in_arc = s.arc.as_ref().is_some_and(|(arc, _)| arc.u == a || arc.v == a);
            let kind = self.robot.axis(a).kind;
            let si = s.goal[a]? * kind.si_per_user_unit();
            let most = most(kind, s.unit[a]);
            match s.axis_word(a) {
                Some(w) => {
                    let style = w.value?.1;
                    let finest = self.weight(a, s.unit[a], style.decimals.max(most));
                    Some(Value {
                        si,
                        start: w.number().start,
                        end: w.number().end,
                        style,
                        digit: self.digit[a],
                        finest,
                    })
                }
                // an arc commands both axes of its plane, whether their words are there or not
                None if in_arc => {
                    let at = s.words.last()?.span().end;
                    let finest = self.weight(a, s.unit[a], most).min(self.digit[a]);
                    Some(Value { si, start: at, end: at, style: Default::default(), digit: self.digit[a], finest })
                }
                None => None,
            }
        };
        let values = (0..s.goal.len()).map(value).collect();
        self.script.targets.push(Target { at: At::of_line(s.line), values, ..Target::default() });
    }
}

/// The numbers in the memory of the `last` ones, if they are the same: most blocks have those of the block before.
fn shared(last: &Shared<[f64]>, count: usize, new: impl Fn(usize) -> f64) -> Shared<[f64]> {
    let same = last.len() == count && last.iter().enumerate().all(|(k, v)| v.to_bits() == new(k).to_bits());
    if same { Shared::clone(last) } else { (0..count).map(new).collect() }
}
