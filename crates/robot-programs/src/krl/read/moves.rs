//! Motions: where they go, as far as the text tells, and why no point may come before them.

use super::{Fold, Reader, Site};
use crate::error::Result;
use crate::krl::aggregate::Aggregate;
use crate::krl::going::Turning;
use crate::krl::lex::{Kind, Token, upper};
use crate::krl::motion::{self, Motion, Word};
use crate::krl::name::Holds;
use crate::krl::product;
use crate::krl::program::Source;
use crate::krl::relative::{self, Stands};
use crate::krl::settings;
use crate::krl::target::{Others, target};
use crate::script::pose::Frame;
use crate::script::{
    At, Few, Goal, How, Move, Note, PathKind, PoseForm, PoseGoal, Shift, Span, Speed, StepKind, Target,
};
use nalgebra::Vector3;
use std::ops::Range;
use std::sync::Arc;

impl Reader<'_> {
    /// The goal of an arc, with the point on its way; the angle CA moves its end.
    fn end_of_arc(&self, pose: PoseGoal, line: &[Token]) -> Goal {
        if line.iter().any(|t| upper(self.text, t) == "CA") {
            return Goal::Opaque("an angle CA tells where the arc ends".into());
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
        let mut others: Others = None;
        let mut end = None;
        self.with = settings::with(&self.set, self.text, line, self.data, self.routine);
        let goal = self.goal(k, line, at, word, &mut end, &mut others)?;
        let relative = word.relative && matches!(goal, Goal::Pose(_));
        let whole = end.is_some_and(|e| motion::ends(self.text, line, e)) && !word.relative;
        let goal = match goal {
            goal @ Goal::Opaque(_) => goal,
            goal if relative => goal,
            _ if !whole => Goal::Opaque("the goal is computed".into()),
            Goal::Pose(pose) if word.arc => self.end_of_arc(*pose, line),
            goal => goal,
        };
        let tail = &line[end.unwrap_or(at).min(line.len())..];
        let turning = self.going.of_motion(self.set.turning_now(), self.text, tail);
        let goal = self.as_the_robot_goes(k, goal, word, tail, turning);
        let via = self.via_of_splittable(line, at, word, &goal);
        // what `WITH` sets holds for one motion, and a copy of a plain motion would go without it
        let own = !word.spline && tail.iter().any(|t| upper(self.text, t) == "WITH");
        let copied = (word.arc || whole || !has_more_after(line, at)) && !own;
        let closed = self.closed(word, turning, via.is_some(), copied);
        let (speed, blend_m) = self.speed_and_blend(word, tail);
        let motion = end.filter(|_| whole).map(|e| self.written(k, line, at..e, word, via));
        // of most motions they are those of the one before
        let others = match self.steps.last_place() {
            Some(last) if last.others == others => last.others.clone(),
            _ => others,
        };
        self.steps.place(self.steps.next(), Site { motion, others });
        self.stands = match &goal {
            Goal::Pose(pose) if blend_m == Some(0.0) && !self.spline => Stands::of(pose),
            _ => None,
        };
        let path = if self.spline { PathKind::Curve } else { word.path };
        let fixed = relative.then(|| relative::ITSELF.to_string());
        let how = How {
            path,
            fixed,
            closed,
            speed,
            blend_m,
            tool: None,
            turns_known: false,
            relative: word.relative,
            circle: None,
        };
        self.push(k, StepKind::Move(Move::new(how, goal, Few::new())));
        Ok(())
    }

    /// The goal, or why it is not known where it is as the robot goes: led by a sensor, turned otherwise, holding the part.
    fn as_the_robot_goes(&self, k: usize, goal: Goal, word: Word, tail: &[Token], turning: Turning) -> Goal {
        match (goal, self.led.by(k)) {
            (goal @ Goal::Opaque(_), _) => goal,
            (_, Some(by)) => Goal::Opaque(format!("{by} leads the robot away from its points")),
            _ if word.path != PathKind::Joint && turning == Turning::Otherwise => {
                Goal::Opaque("$ORI_TYPE: the tool does not turn to the orientation of the point".into())
            }
            _ if word.path != PathKind::Joint && self.going.holds_part(self.text, tail) => {
                Goal::Opaque("the robot holds the part (IPO_FRAME #TCP)".into())
            }
            (goal, None) => goal,
        }
    }

    /// Why no point may come before a motion; `has_via`: the point on the way of an arc is known; `copied`: its statement can be.
    fn closed(&mut self, word: Word, turning: Turning, has_via: bool, copied: bool) -> Option<String> {
        let fold = self.inline_fold();
        let in_fold = fold.is_some_and(|f| f.more || f.steps != self.steps.next());
        let reasons = [
            (word.arc && !has_via, "an arc is given by three points"),
            (
                turning == Turning::Wrist && word.path == PathKind::Linear,
                "$ORI_TYPE #JOINT: the wrist turns axis by axis on its way",
            ),
            (word.relative, relative::ITSELF),
            (self.spline, "it stands in a spline block, whose curve a further point would change"),
            (std::mem::take(&mut self.trigger), "a TRIGGER before it belongs to this very motion"),
            (!copied, "its statement cannot be copied"),
            (in_fold, "its inline form does more than this motion"),
        ];
        reasons.into_iter().find(|r| r.0).map(|r| r.1.to_string())
    }

    fn inline_fold(&self) -> Option<&Fold> {
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

    /// The goal of a relative motion.
    ///
    /// `relative = aggregate {"C_..."} ["#BASE" | "#TOOL"]`
    fn relative(&self, line: &[Token], at: usize, word: Word, end: &mut Option<usize>) -> Goal {
        let given = line.get(at).filter(|t| t.is(b'{'));
        let given = given.and_then(|_| crate::krl::aggregate::aggregate(self.text, 0, line, at).ok());
        let goal = given.zip(self.stands.as_ref()).and_then(|((a, next), stands)| {
            *end = Some(next);
            stands.moved(self.text, word, &a, &line[next..], self.frames())
        });
        goal.map_or_else(|| Goal::Opaque(relative::UNKNOWN.into()), Goal::pose)
    }

    /// The goal of a motion at token `at`; `end`: the token after it, `others`: its external axes.
    ///
    /// `goal = product | aggregate | name [index]`
    fn goal(
        &mut self,
        k: usize,
        line: &[Token],
        at: usize,
        word: Word,
        end: &mut Option<usize>,
        others: &mut Others,
    ) -> Result<Goal> {
        Ok(match line.get(at) {
            _ if word.relative => self.relative(line, at, word, end),
            None => Goal::Opaque("the motion has no goal".into()),
            Some(_) if !word.arc && product::is(self.text, line, at) => self.product(k, line, at, word, end, others)?,
            Some(t) if t.is(b'{') => {
                let (a, next) = crate::krl::aggregate::aggregate(self.text, 0, line, at)?;
                *end = Some(next);
                *others = Some(a.others(&self.names, self.text).into());
                self.aggregate(k, a, word)?
            }
            Some(t) if t.kind == Kind::Word => {
                let (name, next) = product::name(self.text, line, at);
                *end = Some(next);
                match self.data.find(self.routine, &name) {
                    // a call, an element of an array by a computed index, a sum of frames
                    _ if !motion::ends(self.text, line, next) => Goal::Opaque("the goal is computed".into()),
                    None if name.starts_with('$') => Goal::Opaque(format!("{name} is known on the controller only")),
                    None => Goal::Opaque(format!("{name} is not declared in the files given")),
                    Some(n) => {
                        if let Ok(a) = self.data.names[n].value() {
                            *others = Some(a.others(&self.names, &self.texts[a.file]).into());
                        }
                        self.named(n, word)?
                    }
                }
            }
            Some(_) => Goal::Opaque("the goal is computed".into()),
        })
    }

    /// `P1:{X 0,Y 4,...}`, `$NULLFRAME:P[2]:F`: the numbers of one factor are edited, the others displace it.
    fn product(
        &mut self,
        k: usize,
        line: &[Token],
        at: usize,
        word: Word,
        end: &mut Option<usize>,
        others: &mut Others,
    ) -> Result<Goal> {
        let (factors, next) = match product::factors(self.text, line, at, self.data, self.routine)? {
            Ok(found) => found,
            Err(why) => return Ok(Goal::Opaque(why)),
        };
        if !motion::ends(self.text, line, next) {
            return Ok(Goal::Opaque("the goal is computed".into()));
        }
        *end = Some(next);
        *others = Some(Arc::default());
        // numbers in the motion itself belong to it alone
        let chosen = factors.iter().position(|f| f.inline).or_else(|| factors.iter().position(|f| f.name.is_some()));
        let Some(chosen) = chosen else { return Ok(Goal::Opaque("the goal is computed".into())) };
        let factor = &factors[chosen];
        let goal = match factor.name {
            Some(n) => self.named(n, word)?,
            None => self.aggregate(k, factor.value.clone(), word)?,
        };
        let Goal::Pose(mut pose) = goal else { return Ok(Goal::Opaque("the goal is computed".into())) };
        let of = |list: &[product::Factor]| {
            list.iter().try_fold(nalgebra::Isometry3::identity(), |all, f| Some(all * f.value.isometry()?))
        };
        let (Some(before), Some(after)) = (of(&factors[..chosen]), of(&factors[chosen + 1..])) else {
            return Ok(Goal::Opaque("a part of its position is not given".into()));
        };
        // status and turn are those of the right operand, and a FRAME has none
        let (frame, tool) = self.frames();
        let last = factors.last().and_then(|f| f.value.pose(&frame, &tool, word.path, None));
        pose.solution = last.map(|p| p.solution).unwrap_or_default();
        self.point = Some(line[factor.tokens.start].start..line[factor.tokens.end - 1].end);
        Ok(Goal::pose(pose.shifted(Shift { before, after })))
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

    /// Frame and tool in force. What no line sets has the controller's name: the frame in which the program starts.
    fn frames(&self) -> (Frame, Frame) {
        let or = |k: usize, set: &Option<Frame>, name: &str| {
            let own = self.with[k].as_ref().or(self.of_block[k].as_ref()).or(set.as_ref());
            own.cloned().unwrap_or_else(|| Frame::Named(name.into()))
        };
        let base = match self.set.carried.as_ref().or(self.set.moved.as_ref()) {
            Some(why) => Frame::Unknown(why.clone()),
            None => or(0, &self.set.base, "$BASE"),
        };
        (base, or(1, &self.set.tool, "$TOOL"))
    }

    /// A Cartesian goal, with a target for its numbers.
    fn pose(&mut self, a: &Aggregate, word: Word, name: Option<String>, at: At, source: Source) -> Option<PoseGoal> {
        let (frame, tool) = self.frames();
        let target = a.coordinates().map(|values| {
            self.targets.push(Target { pose: Some(PoseForm::EulerZyx), name, at, values });
            self.sources.push(source);
            self.targets.len() - 1
        });
        a.pose(&frame, &tool, word.path, target)
    }

    /// The goal that a motion gives in line.
    fn aggregate(&mut self, k: usize, a: Aggregate, word: Word) -> Result<Goal> {
        if a.has_axes() {
            return Ok(match target(self.axes, self.text, &a, None, At { file: 0, line: k as u64 + 1 }, word)? {
                Err(why) => Goal::Opaque(why),
                Ok(target) => {
                    self.targets.push(target);
                    self.sources.push(Source::Inline(a.file as u16, a.span.into()));
                    Goal::Joints(self.targets.len() - 1)
                }
            });
        }
        let at = At { file: 0, line: k as u64 + 1 };
        let pose = self.pose(&a, word, None, at, Source::Inline(a.file as u16, a.span.clone().into()));
        Ok(pose.map_or_else(|| Goal::Opaque("a part of its position is not given".into()), Goal::pose))
    }

    /// Position of the point on the way of an arc, m.
    ///
    /// `via = (aggregate | name [index]) ","`
    fn via(&self, line: &[Token]) -> Option<Vector3<f64>> {
        let t = line.get(1)?;
        let of = |a: &Aggregate| {
            let at = |name: &str| a.component(name).and_then(|c| c.value.as_ref()).map(|v| v.1 * 1e-3);
            Some(Vector3::new(at("X")?, at("Y")?, at("Z")?))
        };
        if t.is(b'{') {
            let (point, next) = crate::krl::aggregate::aggregate(self.text, 0, line, 1).ok()?;
            // a product of frames goes on after the aggregate
            return line.get(next).filter(|t| t.is(b',')).and_then(|_| of(&point));
        }
        let (name, next) = product::name(self.text, line, 1);
        let comma = t.kind == Kind::Word && line.get(next).is_some_and(|t| t.is(b','));
        let n = self.data.find(self.routine, &name).filter(|_| comma)?;
        of(self.data.names[n].value().ok()?)
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

    /// Says where the values of a point of another module come from.
    fn elsewhere(&mut self, n: usize) {
        let name = &self.data.names[n];
        if name.context {
            let file = self.texts.get(name.file).map_or("", |t| t.name.as_str());
            let text = format!("the values of {} are those of another module ({file}:{})", name.text, name.line + 1);
            self.notes.push(Note { place: At { file: name.file, line: name.line as u64 + 1 }, text });
        }
    }

    /// The goal that a name gives.
    fn named(&mut self, n: usize, word: Word) -> Result<Goal> {
        let name = &self.data.names[n];
        let a = match name.value() {
            Ok(a) => a,
            Err(why) => return Ok(Goal::Opaque(why)),
        };
        if name.holds == Holds::Pose {
            let (a, text) = (a.clone(), name.text.clone());
            let (frame, tool) = self.frames();
            let pose = match self.of_name.get(&n).copied() {
                Some(t) => a.pose(&frame, &tool, word.path, Some(t)),
                None => {
                    let line = name
                        .given
                        .as_ref()
                        .map_or_else(|| name.assigned.first().map_or(name.line, |a| a.line), |_| name.line);
                    let at = At { file: a.file, line: line as u64 + 1 };
                    let pose = self.pose(&a, word, Some(text.clone()), at, Source::Name(n as u32));
                    if let Some(t) = pose.as_ref().and_then(|p| p.target) {
                        self.of_name.insert(n, t);
                        self.elsewhere(n);
                    }
                    pose
                }
            };
            return Ok(pose.map_or_else(|| Goal::Opaque(format!("a part of {text} is not given")), Goal::pose));
        }
        if let (Some(&t), true) = (self.of_name.get(&n), word.path == PathKind::Joint) {
            return Ok(Goal::Joints(t));
        }
        let line = if name.given.is_some() { name.line } else { name.assigned.first().map_or(name.line, |a| a.line) };
        let at = At { file: a.file, line: line as u64 + 1 };
        Ok(match target(self.axes, &self.texts[a.file], a, Some(name.text.clone()), at, word)? {
            Err(why) => Goal::Opaque(why),
            Ok(target) => {
                self.targets.push(target);
                self.sources.push(Source::Name(n as u32));
                self.of_name.insert(n, self.targets.len() - 1);
                self.elsewhere(n);
                Goal::Joints(self.targets.len() - 1)
            }
        })
    }
}

/// Whether a list goes on after the token `at`.
fn has_more_after(line: &[Token], at: usize) -> bool {
    line.iter().any(|t| t.kind == Kind::Mark(b',') && t.start > line[at.min(line.len() - 1)].end)
}
