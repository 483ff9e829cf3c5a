//! Targets of URScript moves: joint values, poses with their TCP, or why neither can be told.

use super::arguments::arguments;
use super::lex::Kind;
use super::read::{Item, Span};
use super::steps::{Builder, Literal, Owner};
use super::value;
use crate::error::Result;
use crate::script::{At, Goal, PoseGoal, Solution, Target};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

fn isometry([x, y, z, rx, ry, rz]: [f64; 6]) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_scaled_axis(Vector3::new(rx, ry, rz)))
}

impl Builder<'_> {
    /// First token of the `set_tcp` from which on the robot file's tool is the active one; why poses cannot be solved.
    pub fn find_tool(&self) -> std::result::Result<usize, String> {
        let (p, robot) = (self.p, self.robot);
        let mut first = None;
        let mut left = p.words.iter().filter(|w| *w == "set_tcp").count();
        for item in &p.items {
            for i in item.span.clone().filter(|&i| p.words[i] == "set_tcp") {
                let args = arguments(p, i + 2, p.tokens.len()).map(|a| a.0).unwrap_or_default();
                let Some(pose) = args.first().and_then(|a| self.pose(&a.span, item)) else {
                    return Err("a TCP that is computed".into());
                };
                let other = isometry(pose).inverse() * robot.tool;
                // 0.01 mm and 0.001 rad: what robot files and TCPs are rounded to
                if other.translation.vector.norm() > 1e-5 || other.rotation.angle() > 1e-3 {
                    return Err("a TCP that is not the tool of the robot file".into());
                }
                first.get_or_insert(i);
                left = left.saturating_sub(1);
            }
        }
        // one that stands in no statement is not understood
        if left > 0 {
            return Err("a TCP that is computed".into());
        }
        first.ok_or_else(|| "the TCP of the installation: no set_tcp says which".into())
    }

    /// The pose that an expression is: `p[..]`, or a name that is assigned one.
    fn pose(&self, span: &Span, item: &Item) -> Option<[f64; 6]> {
        let read = |s: &Span| value::pose(self.text, &self.p.tokens, &self.p.words, s);
        read(span).or_else(|| read(&self.assigned(span, item).ok()?.0))
    }

    fn pose_goal(&self, pose: [f64; 6], token: usize) -> Goal {
        // poses are in the base of the robot
        let world = self.robot.base * isometry(pose);
        let foreign_frame = match &self.tool {
            Ok(first) if *first < token => None,
            Ok(_) => Some("the TCP of the installation: set_tcp comes later".into()),
            Err(why) => Some(why.clone()),
        };
        Goal::Pose(PoseGoal {
            position_m: world.translation.vector,
            rotation: Some(world.rotation),
            foreign_frame,
            solution: Solution::Same,
        })
    }

    pub fn pose_or_opaque(&self, span: &Span, item: &Item) -> Goal {
        match self.pose(span, item) {
            Some(pose) => self.pose_goal(pose, span.start),
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

    pub fn goal(&mut self, span: &Span, item: &Item) -> Result<Goal> {
        let (p, text, robot) = (self.p, self.text, self.robot);
        if let Some(pose) = self.pose(span, item) {
            return Ok(self.pose_goal(pose, span.start));
        }
        // the list behind qnear only chooses the solution: the pose is where the robot goes
        if p.words[span.start] == "get_inverse_kin" && span.len() > 3 {
            let args = arguments(p, span.start + 2, span.end).map(|a| a.0).unwrap_or_default();
            let pose = args.first().filter(|_| args.len() <= 2).and_then(|a| self.pose(&a.span, item));
            let Some(pose) = pose else { return Ok(Goal::Opaque("get_inverse_kin computes the target".into())) };
            let mut goal = self.pose_goal(pose, span.start);
            if let (Some(near), Goal::Pose(goal)) = (args.get(1), &mut goal) {
                match self.near(&near.span, item) {
                    Some(solution) => goal.solution = solution,
                    None => return Ok(Goal::Opaque("qnear of get_inverse_kin is computed".into())),
                }
            }
            return Ok(goal);
        }
        let at = At { file: 0, line: self.line(span.start) };
        let bytes = |s: &Span| p.tokens[s.start].start..p.tokens[s.end - 1].end;
        if p.tokens[span.start].kind == Kind::Mark(b'[') {
            return Ok(match value::joints(text, &p.tokens, &p.words, span, robot)? {
                Ok((values, units)) => {
                    self.targets.push(Target { name: None, at, values });
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
        self.targets.push(Target { name: Some(name), at: At { file: 0, line: self.line(value.start) }, values });
        self.literals.push(Literal { bytes: bytes(&value), units, owner: Some(owner) });
        let t = self.targets.len() - 1;
        self.known.insert(key, t);
        Ok(Goal::Joints(t))
    }
}
