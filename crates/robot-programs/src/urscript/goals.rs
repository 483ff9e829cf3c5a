//! Targets of URScript moves: joint values, poses with their TCP, or why neither can be told.

use super::arguments::arguments;
use super::lex::Kind;
use super::read::{Item, Span};
use super::steps::{Builder, Literal, Owner};
use super::value;
use crate::error::Result;
use crate::script::pose::Frame;
use crate::script::{At, Goal, PoseForm, PoseGoal, Solution, Target};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

fn isometry([x, y, z, rx, ry, rz]: [f64; 6]) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_scaled_axis(Vector3::new(rx, ry, rz)))
}

/// The list of a pose, and the item that assigns it to a name.
type PosePlace = (Span, Option<usize>);

/// 0.001 mm and 0.0001 rad: what TCPs are rounded to.
fn alike(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    (a.translation.vector - b.translation.vector).norm() < 1e-6 && a.rotation.angle_to(&b.rotation) < 1e-4
}

impl Builder<'_> {
    /// Token of the first `set_tcp`, and the TCP that all of them set; why that cannot be told.
    pub fn find_tool(&self) -> std::result::Result<Option<(usize, Isometry3<f64>)>, String> {
        let p = self.p;
        let mut found: Option<(usize, Isometry3<f64>)> = None;
        let mut left = p.words.iter().filter(|w| *w == "set_tcp").count();
        for item in &p.items {
            for i in item.span.clone().filter(|&i| p.words[i] == "set_tcp") {
                let args = arguments(p, i + 2, p.tokens.len()).map(|a| a.0).unwrap_or_default();
                let Some(pose) = args.first().and_then(|a| self.pose(&a.span, item)).map(|(pose, _)| isometry(pose))
                else {
                    return Err("a TCP that is computed".into());
                };
                match &found {
                    Some((_, first)) if !alike(first, &pose) => {
                        return Err("several TCPs, and which is set is not certain".into());
                    }
                    Some(_) => {}
                    None => found = Some((i, pose)),
                }
                left = left.saturating_sub(1);
            }
        }
        // one that stands in no statement is not understood
        if left > 0 { Err("a TCP that is computed".into()) } else { Ok(found) }
    }

    /// The pose that an expression is: `p[..]`, or a name that is assigned one; where its list stands, and the item that assigns it.
    fn pose(&self, span: &Span, item: &Item) -> Option<([f64; 6], PosePlace)> {
        let read = |s: &Span| value::pose(self.text, &self.p.tokens, &self.p.words, s);
        if let Some(pose) = read(span) {
            return Some((pose, (span.clone(), None)));
        }
        let (value, n) = self.assigned(span, item).ok()?;
        Some((read(&value)?, (value, Some(n))))
    }

    /// The TCP in force at a token. What no line sets has the controller's name: the TCP of the installation.
    fn tcp(&self, token: usize) -> Frame {
        match &self.tool {
            Err(why) => Frame::Unknown(why.clone()),
            Ok(Some((first, tcp))) if *first < token => Frame::Given(*tcp),
            Ok(_) => Frame::Named("tcp".into()),
        }
    }

    fn pose_goal(&mut self, (pose, place): ([f64; 6], PosePlace), span: &Span, item: &Item, whole: bool) -> Goal {
        let tool = self.tcp(span.start);
        let target = if whole || place.1.is_none() { self.pose_target(place, span, item) } else { None };
        let at = isometry(pose);
        Goal::Pose(PoseGoal {
            target,
            position_m: at.translation.vector,
            rotation: Some(at.rotation),
            frame: Frame::Base,
            tool,
            solution: Solution::Same,
            binding: false,
        })
    }

    /// Index of the target of a pose that is written in numbers.
    fn pose_target(&mut self, (list, assigned): PosePlace, span: &Span, item: &Item) -> Option<usize> {
        let (p, text) = (self.p, self.text);
        let name = p.words[span.start].clone();
        let key = assigned.and_then(|_| p.key(item.def, &name));
        if let Some(&t) = key.as_ref().and_then(|key| self.known.get(key)) {
            return Some(t);
        }
        let values = value::pose_values(text, &p.tokens, &p.words, &list)?;
        let bytes = |s: &Span| p.tokens[s.start].start..p.tokens[s.end - 1].end;
        let owner = match (assigned, &key) {
            (Some(n), Some(key)) => {
                let statement = p.items[n].span.clone();
                let word = &p.words[statement.start];
                let qualifier =
                    if matches!(word.as_str(), "global" | "local") { format!("{word} ") } else { String::new() };
                let keep = p.variables[key].read;
                Some(Owner { bytes: bytes(&statement), qualifier, name: name.clone(), keep })
            }
            (Some(_), None) => return None,
            (None, _) => None,
        };
        let at = At { file: 0, line: self.line(list.start) };
        let name = owner.as_ref().map(|o| o.name.clone());
        self.targets.push(Target { name, at, values, pose: Some(PoseForm::RotationVector) });
        self.literals.push(Literal { bytes: bytes(&list), units: vec![1.0; 6], owner });
        let t = self.targets.len() - 1;
        if let Some(key) = key {
            self.known.insert(key, t);
        }
        Some(t)
    }

    pub fn pose_or_opaque(&mut self, span: &Span, item: &Item) -> Goal {
        match self.pose(span, item) {
            Some(found) => self.pose_goal(found, span, item, true),
            None => Goal::Opaque(
                self.assigned(span, item).err().unwrap_or_else(|| "its target is no pose of plain numbers".into()),
            ),
        }
    }

    /// The solution that `qnear` chooses; `None`: it cannot be told.
    fn near(&self, span: &Span, item: &Item) -> Option<Solution> {
        let (p, text) = (self.p, self.text);
        // where the robot stands
        if matches!(p.words[span.start].as_str(), "get_actual_joint_positions" | "get_target_joint_positions") {
            return Some(Solution::Same);
        }
        let value = match self.assigned(span, item) {
            _ if p.tokens[span.start].kind == Kind::Mark(b'[') => span.clone(),
            Ok((value, _)) if !value.is_empty() => value,
            _ => return None,
        };
        // a list of other length is one that cannot be told
        let found = value::joints(text, &p.tokens, &p.words, &value, self.robot).ok().and_then(std::result::Result::ok);
        let near = found.and_then(|(values, _)| values.into_iter().map(|v| v.map(|v| v.si)).collect());
        near.map(Solution::Near)
    }

    /// `get_inverse_kin(pose, qnear)`: the list of qnear only chooses the solution; the pose is where the robot goes.
    fn inverse_goal(&mut self, span: &Span, item: &Item) -> Goal {
        let args = arguments(self.p, span.start + 2, span.end).map(|a| a.0).unwrap_or_default();
        let first = args.first().filter(|_| args.len() <= 2).map(|a| a.span.clone());
        let pose = first.as_ref().and_then(|s| self.pose(s, item));
        let (Some(pose), Some(first)) = (pose, first) else {
            return Goal::Opaque("get_inverse_kin computes the target".into());
        };
        // a pose by name would be cloned in the place of the whole call
        let mut goal = self.pose_goal(pose, &first, item, false);
        if let (Some(near), Goal::Pose(goal)) = (args.get(1), &mut goal) {
            match self.near(&near.span, item) {
                Some(solution) => goal.solution = solution,
                None => return Goal::Opaque("qnear of get_inverse_kin is computed".into()),
            }
        }
        goal
    }

    pub fn goal(&mut self, span: &Span, item: &Item) -> Result<Goal> {
        let (p, text, robot) = (self.p, self.text, self.robot);
        if let Some(found) = self.pose(span, item) {
            return Ok(self.pose_goal(found, span, item, true));
        }
        if p.words[span.start] == "get_inverse_kin" && span.len() > 3 {
            return Ok(self.inverse_goal(span, item));
        }
        let at = At { file: 0, line: self.line(span.start) };
        let bytes = |s: &Span| p.tokens[s.start].start..p.tokens[s.end - 1].end;
        if p.tokens[span.start].kind == Kind::Mark(b'[') {
            return Ok(match value::joints(text, &p.tokens, &p.words, span, robot)? {
                Ok((values, units)) => {
                    self.targets.push(Target { name: None, at, values, pose: None });
                    self.literals.push(Literal { bytes: bytes(span), units, owner: None });
                    Goal::Joints(self.targets.len() - 1)
                }
                Err(why) => Goal::Opaque(why),
            });
        }
        let (value, n) = match self.assigned(span, item) {
            Ok(found) => found,
            Err(why) => return Ok(Goal::Opaque(why)),
        };
        let name = p.words[span.start].clone();
        let Some(key) = p.key(item.def, &name) else { return Ok(Goal::Opaque(format!("`{name}` is not assigned"))) };
        if let Some(&t) = self.known.get(&key) {
            return Ok(Goal::Joints(t));
        }
        if value.is_empty() {
            return Ok(Goal::Opaque(format!("`{name}` is assigned nothing")));
        }
        let (values, units) = match value::joints(text, &p.tokens, &p.words, &value, robot)? {
            Ok(found) => found,
            Err(why) => return Ok(Goal::Opaque(format!("`{name}`: {why}"))),
        };
        let statement = p.items[n].span.clone();
        let qualifier = &p.words[statement.start];
        let qualifier =
            if matches!(qualifier.as_str(), "global" | "local") { format!("{qualifier} ") } else { String::new() };
        let owner = Owner { bytes: bytes(&statement), qualifier, name: name.clone(), keep: p.variables[&key].read };
        let line = self.line(value.start);
        self.targets.push(Target { name: Some(name), at: At { file: 0, line }, values, pose: None });
        self.literals.push(Literal { bytes: bytes(&value), units, owner: Some(owner) });
        let t = self.targets.len() - 1;
        self.known.insert(key, t);
        Ok(Goal::Joints(t))
    }
}
