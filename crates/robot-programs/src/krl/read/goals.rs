//! Where motions lead: values in line, names, products of frames, increments.

use super::Reader;
use crate::error::Result;
use crate::krl::aggregate::{Aggregate, aggregate};
use crate::krl::lex::{Kind, Token};
use crate::krl::made::Made;
use crate::krl::motion::{self, Word};
use crate::krl::name::Holds;
use crate::krl::product;
use crate::krl::program::Source;
use crate::krl::reason::Reason;
use crate::krl::target::{Others, target};
use crate::script::pose::Frame;
use crate::script::{self, At, Goal, Note, PathKind, PoseForm, PoseGoal, Shift, Target, Text};
use nalgebra::{Isometry3, Vector3};
use std::sync::Arc;

/// A goal, the token after it, and its external axes.
type Found = (Goal, Option<usize>, Others);

/// A goal that is not known, as nothing is of where it ends.
fn unknown(why: impl Into<script::Reason>) -> Found {
    (Goal::opaque(why), None, None)
}

impl Reader<'_> {
    /// The goal of a relative motion.
    ///
    /// `relative = aggregate {"C_..."} ["#BASE" | "#TOOL"]`
    fn relative(&mut self, k: usize, line: &[Token], at: usize, word: Word) -> Found {
        let given = line.get(at).filter(|t| t.is(b'{'));
        let Some((a, next)) = given.and_then(|_| aggregate(self.text, 0, line, at).ok()) else {
            return unknown(Reason::RelativeToUnknown);
        };
        let stands = self.stands.as_ref();
        let (end, tail) = (stands.map(|_| next), line.get(next..).unwrap_or_default());
        let turned = stands.and_then(|s| s.turned(self.text, word, &a, tail, self.axes, &self.targets));
        let moved = stands.and_then(|s| s.moved(self.text, word, &a, tail, self.frames()));
        let goal = match (moved, turned) {
            (Some(pose), _) => Goal::pose(pose),
            (None, Some(made)) => self.made_axes(k, made, word),
            (None, None) => Goal::opaque(Reason::RelativeToUnknown),
        };
        (goal, end, None)
    }

    /// Whether a relative motion names no axis but the robot's: the others stay where they are.
    pub(super) fn leaves_others(&self, line: &[Token], at: usize, word: Word) -> bool {
        let given = line.get(at).filter(|t| word.relative && t.is(b'{'));
        let given = given.and_then(|_| aggregate(self.text, 0, line, at).ok());
        given.is_some_and(|(a, _)| a.others(&self.names, self.text).is_empty())
    }

    /// What an aggregate says of axes that are none of the robot's: mostly what the one before it does.
    fn others(&self, a: &Aggregate, text: &Text) -> Arc<[(String, Vec<u8>)]> {
        match self.others.last() {
            Some(Some(last)) if a.has_others(&self.names, text, last) => Arc::clone(last),
            _ => a.others(&self.names, text).into(),
        }
    }

    /// The goal of a motion at token `at`.
    ///
    /// `goal = product | aggregate | name [index]`
    pub(super) fn goal(&mut self, k: usize, line: &[Token], at: usize, word: Word) -> Result<Found> {
        Ok(match line.get(at) {
            _ if word.relative => self.relative(k, line, at, word),
            None => unknown(script::Reason::NoGoal),
            Some(_) if !word.arc && product::is(self.text, line, at) => self.product(k, line, at, word)?,
            Some(t) if t.is(b'{') => {
                let (a, next) = aggregate(self.text, 0, line, at)?;
                let others = Some(self.others(&a, self.text));
                (self.aggregate(k, a, word)?, Some(next), others)
            }
            Some(t) if t.kind == Kind::Word => {
                let (name, next) = product::name(self.text, line, at);
                let mut others = None;
                let goal = match self.data.find(self.routine, &name) {
                    // a call, an element of an array by a computed index, a sum of frames
                    _ if !motion::ends(self.text, line, next) => Goal::opaque(Reason::Computed),
                    None if name.starts_with('$') => Goal::opaque(Reason::OnController(name.into())),
                    None => Goal::opaque(Reason::NotDeclared(name.into())),
                    Some(n) => {
                        let (goal, of_goal) = self.by_name(k, n, word)?;
                        others = of_goal;
                        goal
                    }
                };
                (goal, Some(next), others)
            }
            Some(_) => unknown(Reason::Computed),
        })
    }

    /// The goal that a name is at a motion, and its external axes.
    fn by_name(&mut self, k: usize, n: usize, word: Word) -> Result<(Goal, Others)> {
        if let Some(made) = self.computed.point(self.data, n, k) {
            let others = self.others(&made.value, &made.text);
            return Ok((self.made(k, n, made, word), Some(others)));
        }
        let value = self.data.names[n].value().ok();
        let others = value.map(|a| self.others(a, &self.texts[a.file]));
        Ok((self.named(n, word)?, others))
    }

    /// `P1:{X 0,Y 4,...}`, `$NULLFRAME:P[2]:F`: the numbers of one factor are edited, the others displace it.
    fn product(&mut self, k: usize, line: &[Token], at: usize, word: Word) -> Result<Found> {
        let (factors, next) = match product::factors(self.text, line, at, self.data, self.routine)? {
            Ok(found) => found,
            Err(why) => return Ok(unknown(why)),
        };
        if !motion::ends(self.text, line, next) {
            return Ok(unknown(Reason::Computed));
        }
        let found = |goal| Ok((goal, Some(next), Some(Arc::default())));
        // numbers in the motion itself belong to it alone
        let chosen = factors.iter().position(|f| f.inline).or_else(|| factors.iter().position(|f| f.name.is_some()));
        let Some(chosen) = chosen else { return found(Goal::opaque(Reason::Computed)) };
        let factor = &factors[chosen];
        let goal = match factor.name {
            Some(n) => self.named(n, word)?,
            None => self.aggregate(k, factor.value.clone(), word)?,
        };
        let Goal::Pose(mut pose) = goal else { return found(Goal::opaque(Reason::Computed)) };
        let of = |list: &[product::Factor]| {
            list.iter().try_fold(Isometry3::identity(), |all, f| Some(all * f.value.isometry()?))
        };
        let (Some(before), Some(after)) = (of(&factors[..chosen]), of(&factors[chosen + 1..])) else {
            return found(Goal::opaque(Reason::PartMissing(None)));
        };
        // status and turn are those of the right operand, and a FRAME has none
        let (frame, tool) = self.frames();
        let last = factors.last().and_then(|f| f.value.pose(&frame, &tool, word.path, None, self.axes));
        pose.solution = last.map(|p| p.solution).unwrap_or_default();
        self.point = Some(line[factor.tokens.start].start..line[factor.tokens.end - 1].end);
        found(Goal::pose(pose.shifted(Shift { before, after })))
    }

    /// Frame and tool in force. What no line sets has the controller's name: the frame in which the program starts.
    fn frames(&self) -> (Frame, Frame) {
        let or = |k: usize, set: &Option<Frame>, name: &str| {
            let own = self.with[k].as_ref().or(self.of_block[k].as_ref()).or(set.as_ref());
            own.cloned().unwrap_or_else(|| Frame::Named(name.into()))
        };
        let base = match self.set.carried.or(self.set.moved) {
            Some(by) => Frame::unclear(Reason::MovesBase(by)),
            None => or(0, &self.set.base, "$BASE"),
        };
        (base, or(1, &self.set.tool, "$TOOL"))
    }

    /// A Cartesian goal, with a target for its numbers.
    fn pose(&mut self, a: &Aggregate, word: Word, name: Option<String>, at: At, source: Source) -> Option<PoseGoal> {
        let (frame, tool) = self.frames();
        let target = a.numbers(self.axes).map(|values| {
            self.targets.push(Target { pose: Some(PoseForm::EulerZyx), name, at, values });
            self.sources.push(source);
            self.targets.len() - 1
        });
        a.pose(&frame, &tool, word.path, target, self.axes)
    }

    /// The goal that the program has computed. In an inline form no numbers can take the place of the name.
    fn made(&mut self, k: usize, n: usize, made: Made, word: Word) -> Goal {
        let a = made.value.clone();
        self.fixed = self.inline_fold().map(|_| Reason::ComputedInForm(self.data.names[n].text.as_str().into()).into());
        if !a.has_axes() {
            let pose = self.pose(&a, word, None, At::of_line(k), Source::Made(Box::new(made)));
            return pose.map_or_else(|| Goal::opaque(a.incomplete(Some(&self.data.names[n].text))), Goal::pose);
        }
        self.made_axes(k, made, word)
    }

    /// The goal of axis values that stand nowhere as they are.
    fn made_axes(&mut self, k: usize, made: Made, word: Word) -> Goal {
        match target(self.axes, &made.text, &made.value, None, At::of_line(k), word) {
            Ok(Ok(target)) => {
                self.targets.push(target);
                self.sources.push(Source::Made(Box::new(made)));
                Goal::Joints(self.targets.len() - 1)
            }
            Ok(Err(why)) => Goal::opaque(why),
            Err(_) => Goal::opaque(Reason::Computed),
        }
    }

    /// The goal that a motion gives in line.
    fn aggregate(&mut self, k: usize, a: Aggregate, word: Word) -> Result<Goal> {
        if a.has_axes() {
            return Ok(match target(self.axes, self.text, &a, None, At::of_line(k), word)? {
                Err(why) => Goal::opaque(why),
                Ok(target) => {
                    self.targets.push(target);
                    self.sources.push(Source::Inline(a.file as u16, a.span));
                    Goal::Joints(self.targets.len() - 1)
                }
            });
        }
        let at = At::of_line(k);
        let pose = self.pose(&a, word, None, at, Source::Inline(a.file as u16, a.span));
        Ok(pose.map_or_else(|| Goal::opaque(a.incomplete(None)), Goal::pose))
    }

    /// Position of the point on the way of an arc, m.
    ///
    /// `via = (aggregate | name [index]) ","`
    pub(super) fn via(&self, line: &[Token]) -> Option<Vector3<f64>> {
        let t = line.get(1)?;
        let of = |a: &Aggregate| {
            let at = |name: &str| a.component(name).and_then(|c| c.value).map(|v| v.1 * 1e-3);
            Some(Vector3::new(at("X")?, at("Y")?, at("Z")?))
        };
        if t.is(b'{') {
            let (point, next) = aggregate(self.text, 0, line, 1).ok()?;
            // a product of frames goes on after the aggregate
            return line.get(next).filter(|t| t.is(b',')).and_then(|_| of(&point));
        }
        let (name, next) = product::name(self.text, line, 1);
        let comma = t.kind == Kind::Word && line.get(next).is_some_and(|t| t.is(b','));
        let n = self.data.find(self.routine, &name).filter(|_| comma)?;
        of(self.data.names[n].value().ok()?)
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
            Err(why) => return Ok(Goal::opaque(why)),
        };
        let line = if name.given.is_some() { name.line } else { name.assigned.first().map_or(name.line, |a| a.line) };
        let at = At { file: a.file, line: line as u64 + 1 };
        if name.holds == Holds::Pose {
            let (a, text) = (a.clone(), name.text.clone());
            let (frame, tool) = self.frames();
            let pose = match self.of_name.get(n).copied().flatten().map(|t| t as usize) {
                Some(t) => a.pose(&frame, &tool, word.path, Some(t), self.axes),
                None => {
                    let pose = self.pose(&a, word, Some(text.clone()), at, Source::Name(n as u32));
                    if let Some(t) = pose.as_ref().and_then(|p| p.target) {
                        self.of_name[n] = Some(t as u32);
                        self.elsewhere(n);
                    }
                    pose
                }
            };
            return Ok(pose.map_or_else(|| Goal::opaque(a.incomplete(Some(&text))), Goal::pose));
        }
        if let (Some(Some(t)), true) = (self.of_name.get(n), word.path == PathKind::Joint) {
            return Ok(Goal::Joints(*t as usize));
        }
        Ok(match target(self.axes, &self.texts[a.file], a, Some(name.text.clone()), at, word)? {
            Err(why) => Goal::opaque(why),
            Ok(target) => {
                self.targets.push(target);
                self.sources.push(Source::Name(n as u32));
                self.of_name[n] = Some(self.targets.len() as u32 - 1);
                self.elsewhere(n);
                Goal::Joints(self.targets.len() - 1)
            }
        })
    }
}
