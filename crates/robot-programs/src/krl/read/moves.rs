//! Motions: where they go, as far as the text tells, and why no point may come before them.

use super::{Fold, Reader};
use crate::error::Result;
use crate::krl::going::Turning;
use crate::krl::lex::{Kind, Token, upper};
use crate::krl::motion::{self, Motion, Word};
use crate::krl::reason::{MovesBase, Reason};
use crate::krl::relative::Stands;
use crate::krl::target::{STAY, Site};
use crate::script::{self, Few, Goal, How, Move, OtherWay, PathKind, PoseGoal, Span, Speed, StepKind};
use std::ops::Range;

impl Reader<'_> {
    /// The goal of an arc, with the point on its way; the angle CA moves its end.
    fn end_of_arc(&self, pose: PoseGoal, line: &[Token]) -> Goal {
        if line.iter().any(|t| upper(self.text, t) == "CA") {
            return Goal::opaque(Reason::AngleOfArc);
        }
        Goal::pose(PoseGoal { via_m: self.via(line), ..pose })
    }

    /// `motion = keyword [via ","] goal ["," "CA" angle] {"C_..."} ["WITH" ...]`
    pub(super) fn motion(&mut self, k: usize, line: &[Token], word: Word) -> Result<()> {
        // where the robot stands: the controller stops, reads the joints and goes nowhere
        if !word.relative && !word.arc && !self.spline && motion::stands(self.text, line) {
            self.trigger = false;
            self.push(k, StepKind::Dwell(None));
            return Ok(());
        }
        let at = if word.arc { motion::second(line).unwrap_or(line.len()) } else { 1 };
        self.with = self.with_of(k, line);
        let (goal, end, others) = self.goal(k, line, at, word)?;
        let relative = word.relative && !matches!(goal, Goal::Opaque(_));
        let whole = end.is_some_and(|e| motion::ends(self.text, line, e)) && !word.relative;
        let goal = match goal {
            goal @ Goal::Opaque(_) => goal,
            goal if relative => goal,
            _ if !whole => Goal::opaque(Reason::Computed),
            Goal::Pose(pose) if word.arc => self.end_of_arc(*pose, line),
            goal => goal,
        };
        let tail = &line[end.unwrap_or(at).min(line.len())..];
        let turning = self.going.of_motion(self.set.turning_now(), self.text, tail);
        let absolute = self.is_absolute(&goal, line, at, word);
        let goal = self.as_the_robot_goes(k, goal, word, tail, turning);
        let via = self.via_of_splittable(line, at, word, &goal);
        // what `WITH` sets holds for one motion, and a copy of a plain motion would go without it
        let own = !word.spline && tail.iter().any(|t| upper(self.text, t) == "WITH");
        let copied = (word.arc || whole || !has_more_after(line, at)) && !own;
        let partial = matches!(&goal, Goal::Pose(pose) if pose.rotation.is_none());
        let closed = self.closed(word, turning, via.is_some(), copied);
        let closed = closed.or_else(|| partial.then(|| Reason::Partial.into()));
        let (speed, blend_m) = self.speed_and_blend(word, tail);
        let motion = end.filter(|_| whole).map(|e| self.written(k, line, at..e, word, via));
        let stay = self.leaves_others(line, at, word);
        // of most motions they are those of the one before
        if !stay && self.others.last() != Some(&others) {
            self.others.push(others);
        }
        let others = if stay { STAY } else { self.others.len() as u32 - 1 };
        self.steps.place(self.steps.next(), Site { motion, others });
        let stood = self.stands.take().filter(|_| word.relative);
        self.stands = match &goal {
            Goal::Pose(pose) if blend_m == Some(0.0) && !self.spline => Stands::of(pose),
            Goal::Joints(t) if blend_m == Some(0.0) && !self.spline => {
                if word.relative {
                    Stands::turned_to(stood.as_ref(), *t, &self.targets)
                } else {
                    Some(Stands::Target(*t))
                }
            }
            _ => None,
        };
        let path = if self.spline { PathKind::Curve } else { word.path };
        let fixed = std::mem::take(&mut self.fixed).or_else(|| relative.then(|| Reason::Relative.into()));
        let wrist = turning == Turning::Wrist && word.path != PathKind::Joint;
        let other_way = wrist.then_some(OtherWay::Wrist);
        let absolute = absolute && !self.is_led(k, word, tail, turning);
        let relative = word.relative;
        let how = How { path, fixed, closed, speed, blend_m, relative, absolute, other_way, ..How::default() };
        self.push(k, StepKind::Move(Move::new(how, goal, Few::new())));
        Ok(())
    }

    /// The goal, or why it is not known where it is as the robot goes: led by a sensor, turned otherwise, holding the part.
    fn as_the_robot_goes(&self, k: usize, goal: Goal, word: Word, tail: &[Token], turning: Turning) -> Goal {
        match (goal, self.led.by(k)) {
            (goal @ Goal::Opaque(_), _) => goal,
            (_, Some(by)) => Goal::opaque(by),
            _ if word.path != PathKind::Joint && turning == Turning::Otherwise => Goal::opaque(Reason::TurnsOtherwise),
            _ if word.path != PathKind::Joint && self.going.holds_part(self.text, tail) => {
                Goal::opaque(Reason::MovesBase(MovesBase::HoldsPart))
            }
            (goal, None) => goal,
        }
    }

    /// Whether something leads the robot elsewhere than to the goal of a motion.
    fn is_led(&self, k: usize, word: Word, tail: &[Token], turning: Turning) -> bool {
        let turned = turning == Turning::Otherwise || self.going.holds_part(self.text, tail);
        self.led.by(k).is_some() || word.path != PathKind::Joint && turned
    }

    /// Why no point may come before a motion; `has_via`: the point on the way of an arc is known; `copied`: its statement can be.
    fn closed(&mut self, word: Word, turning: Turning, has_via: bool, copied: bool) -> Option<script::Reason> {
        let fold = self.inline_fold();
        let in_fold = fold.is_some_and(|f| f.more || f.steps != self.steps.next());
        let trigger = std::mem::take(&mut self.trigger);
        let own = match () {
            () if word.arc && !has_via => return Some(script::Reason::ThreePoints),
            () if turning == Turning::Wrist && word.path == PathKind::Linear => Reason::WristByAxis,
            () if word.relative => Reason::Relative,
            () if self.spline => Reason::InSpline,
            () if trigger => Reason::Trigger,
            () if !copied => return Some(script::Reason::NoCopy),
            () if in_fold => Reason::FormDoesMore,
            () => return None,
        };
        Some(own.into())
    }

    pub(super) fn inline_fold(&self) -> Option<&Fold> {
        self.folds.last().filter(|f| f.inline)
    }

    /// Where a motion stands in the text whose goal, `goal` of the tokens, is written out.
    fn written(
        &mut self,
        k: usize,
        line: &[Token],
        goal: Range<usize>,
        word: Word,
        via: Option<Range<usize>>,
    ) -> Motion {
        let goal = line[goal.start].start..line[goal.end - 1].end;
        let last = line.last().map_or(goal.end, |t| t.end);
        let (keyword, tail) = (line[0].span(), goal.end..last);
        let fold = self.inline_fold().map(|f| f.line as u32);
        let point = std::mem::take(&mut self.point).unwrap_or_else(|| goal.clone());
        Motion {
            line: k as u32,
            keyword: keyword.into(),
            goal: goal.into(),
            point: point.into(),
            via: via.map(Span::from),
            tail: tail.into(),
            spline: word.spline,
            fold,
        }
    }

    /// Speed and approximation of a motion, by the settings in force and the words after its goal.
    fn speed_and_blend(&self, word: Word, tail: &[Token]) -> (Speed, Option<f64>) {
        let tail: Vec<String> = tail.iter().map(|t| upper(self.text, t)).collect();
        let has = |w: &str| tail.iter().any(|t| t == w);
        let blend_m = if !tail.iter().any(|t| t.starts_with("C_")) {
            Some(0.0)
        } else if word.path != PathKind::Joint && has("C_DIS") {
            self.set.apo_m
        } else {
            None
        };
        let speed = match word.path {
            _ if has("WITH") => Speed::Unknown,
            PathKind::Joint => self.set.share().map_or(Speed::Unknown, |v| Speed::Share(v / 100.0)),
            _ => self.set.vel_cp.map_or(Speed::Unknown, Speed::Tcp),
        };
        (speed, blend_m)
    }

    /// The bytes of the point on the way of an arc that several arcs may replace: a separate CIRC, whose orientation
    /// nothing in the program steers. An inline form couples its point on the way, and a spline its neighbours.
    fn via_of_splittable(&self, line: &[Token], at: usize, word: Word, goal: &Goal) -> Option<Range<usize>> {
        let Goal::Pose(pose) = goal else { return None };
        let plain = word.arc && !word.spline && !self.spline && self.folds.is_empty() && !self.steers_arcs;
        let (first, last) = (line.get(1)?, line.get(at.checked_sub(2)?)?);
        (plain && pose.via_m.is_some() && pose.target.is_some() && pose.rotation.is_some())
            .then_some(first.start..last.end)
    }
}

/// Whether a list goes on after the token `at`.
fn has_more_after(line: &[Token], at: usize) -> bool {
    line.iter().any(|t| t.kind == Kind::Mark(b',') && t.start > line[at.min(line.len() - 1)].end)
}
