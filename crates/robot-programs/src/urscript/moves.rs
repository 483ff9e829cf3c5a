//! Calls that move: where they stand, where they lead, how fast, and why no point may come before them.

use super::arguments::{Arg, argument, goal};
use super::read::{Item, Span};
use super::reason::Reason;
use super::steps::{Builder, Site};
use super::value;
use super::words::{self, Motion, MotionKind};
use crate::error::Result;
use crate::script::{self, Break, Few, Goal, How, Move, PathKind, PoseGoal, Speed, StepKind, number};
use std::ops::Range;

/// Shortest time between two set points that controllers of every generation keep, s (8 ms cycle of the CB series).
pub const CYCLE_S: f64 = 0.008;

impl Builder<'_> {
    /// A call that moves, of the tokens `span`.
    ///
    /// `call = motion "(" argument {"," argument} ")"`, `argument = [parameter "="] expression`
    pub fn motion(&mut self, item: &Item, motion: &Motion, args: &[Arg], span: Span) -> Result<()> {
        let token = span.start;
        let moves = |name: &&str| words::motion(name).is_none() && self.may_move(name);
        let called: Vec<String> = self.p.called(item).filter(moves).map(str::to_string).collect();
        let calls = !called.is_empty();
        self.name_calls(item);
        if calls {
            called.into_iter().for_each(|name| self.steps.called_otherwise(name));
            self.push(token, StepKind::Break(Break::Call));
        }
        let bytes = self.bytes(&span);
        let Some(target) = goal(motion, args).or(args.first()).map(|a| a.span.clone()) else {
            let found = format!("`{}` without a target", self.p.words.at(token));
            return Err(self.text.bad(bytes.start, found, "a list of joint values or a pose"));
        };
        let point = self.bytes(&target);
        let mut site = Site { bytes: bytes.into(), point: point.clone().into(), goal: point.into(), ..Site::default() };
        let mut closed = match self.closed(motion, args) {
            None if calls => Some(script::Reason::CallInArguments),
            None if !self.stands_alone(item, &span) => Some(Reason::SharedLine.into()),
            closed => closed.map(Into::into),
        };
        let t = argument(motion, args, "t").map(|a| value::plain(self.text, &self.p.tokens, &a.span));
        let seconds = duration(t, motion.kind, &mut site, &mut closed);
        let (speed, blend_m) = self.speed_and_blend(item, motion, args, seconds);
        site.blend = argument(motion, args, "r").map(|a| self.bytes(&a.span).into());
        let via = argument(motion, args, "pose_via").map(|a| a.span.clone());
        let goal = self.goal_of_motion(item, (motion, args), &target, via.as_ref(), &mut site)?;
        if motion.kind == MotionKind::Arc {
            let known = matches!(&goal, Goal::Pose(pose) if pose.via_m.is_some() && pose.target.is_some());
            site.via = via.filter(|_| known).map(|v| self.bytes(&v).into());
            if !known {
                closed.get_or_insert_with(|| Reason::ArcComputed.into());
            }
        }
        let straight = motion.path == PathKind::Linear && matches!(goal, Goal::Joints(_));
        let tool = straight.then(|| Box::new(self.tcp()));
        let how = How { path: motion.path, closed, speed, blend_m, tool, ..How::default() };
        let k = self.push(token, StepKind::Move(Move::new(how, goal, Few::new())));
        self.steps.place(k, site);
        Ok(())
    }

    /// Why no point may come before a motion of its kind.
    fn closed(&self, motion: &Motion, args: &[Arg]) -> Option<Reason> {
        let splittable = argument(motion, args, "pose_via").is_some() && self.interpolates(motion, args);
        match motion.kind {
            MotionKind::Arc if !splittable => Some(Reason::ArcOrProcess),
            MotionKind::Velocity => Some(Reason::Velocity),
            _ => None,
        }
    }

    /// Whether nothing else stands on the lines of a call.
    fn stands_alone(&self, item: &Item, span: &Span) -> bool {
        let line = self.text.line_span(self.line(span.start) as usize - 1);
        let before = self.text.slice(line.start..self.bytes(span).start);
        before.iter().all(u8::is_ascii_whitespace) && span.end == item.span.end
    }

    /// Whether an arc interpolates the orientation from its start to its end (`mode=0`, the default): the other mode turns it with
    /// the tangent, whatever its end says.
    fn interpolates(&self, motion: &Motion, args: &[Arg]) -> bool {
        let mode = |a: &Arg| value::plain(self.text, &self.p.tokens, &a.span).map(|m| m.0);
        motion.parameters.contains(&"mode") && argument(motion, args, "mode").is_none_or(|a| mode(a) == Some(0.0))
    }

    /// Speed and blend radius; `seconds`: the time that is written.
    fn speed_and_blend(
        &self,
        item: &Item,
        motion: &Motion,
        args: &[Arg],
        seconds: Option<f64>,
    ) -> (Speed, Option<f64>) {
        let v = argument(motion, args, "v").map_or(motion.v, |a| self.number(&a.span, item));
        let speed = match (seconds, v, motion.kind) {
            (Some(s), ..) => Speed::Seconds(s),
            (None, Some(v), MotionKind::Optimised) => Speed::Share(v),
            (None, Some(v), MotionKind::Move) if motion.path == PathKind::Joint => Speed::Joint(v),
            (None, Some(v), MotionKind::Move | MotionKind::Arc) => Speed::Tcp(v),
            _ => Speed::Unknown,
        };
        let blend_m = match argument(motion, args, "r") {
            Some(a) => self.number(&a.span, item),
            None => motion.parameters.contains(&"r").then_some(0.0),
        };
        (speed, blend_m)
    }

    /// Whether the orientation at the end of an arc may be another one than that of its pose: of a mode other than 0.
    fn keeps_to_tangent(&self, motion: &Motion, args: &[Arg]) -> bool {
        motion.parameters.contains(&"mode") && !self.interpolates(motion, args)
    }

    /// Where a motion leads; the place of its point goes into `site`.
    fn goal_of_motion(
        &mut self,
        item: &Item,
        (motion, args): (&Motion, &[Arg]),
        target: &Span,
        via: Option<&Span>,
        site: &mut Site,
    ) -> Result<Goal> {
        self.inner = None;
        let goal = match motion.kind {
            _ if self.led.is_some() => Goal::opaque(Reason::Led(self.led.unwrap_or_default())),
            MotionKind::Velocity => Goal::opaque(Reason::VelocityEnds),
            MotionKind::Arc if self.keeps_to_tangent(motion, args) => Goal::opaque(Reason::Tangent),
            MotionKind::Arc => self.pose_or_opaque(target, item),
            _ => self.goal(target, item)?,
        };
        if let Some(inner) = self.inner.take() {
            site.point = self.bytes(&inner).into();
        }
        Ok(match (goal, via) {
            (Goal::Pose(pose), Some(via)) => Goal::pose(PoseGoal { via_m: self.via(via, item), ..*pose }),
            (goal, _) => goal,
        })
    }
}

/// The time of a motion, s, where it is written; closes the motion where a time cannot be shared out.
fn duration(
    t: Option<Option<(f64, number::Style, Range<usize>)>>,
    kind: MotionKind,
    site: &mut Site,
    closed: &mut Option<script::Reason>,
) -> Option<f64> {
    match t {
        Some(Some((s, style, bytes))) if s > 0.0 => {
            if s < 2.0 * CYCLE_S {
                closed.get_or_insert_with(|| Reason::TimeTooShort.into());
            }
            site.time = Some(Box::new((bytes, s, style)));
            return Some(s);
        }
        Some(Some((s, ..))) if s == 0.0 && kind == MotionKind::Move => {}
        None if kind != MotionKind::Servo => {}
        Some(_) => drop(closed.get_or_insert_with(|| Reason::TimeComputed.into())),
        None => drop(closed.get_or_insert_with(|| Reason::NoTime.into())),
    }
    None
}
