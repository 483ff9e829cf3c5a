//! Targets of RAPID moves: joint values, poses with their frame and tool, or why neither can be told.

use super::arguments::{Arg, Switch};
use super::lex::Kind;
use super::read::{Item, Span, Storage};
use super::rules::External;
use super::steps::{Builder, Literal, Owner, Site};
use super::value::{self, Node};
use crate::axes::{Axes, JointKind};
use crate::error::Result;
use crate::script::{At, Goal, PathKind, PoseGoal, Solution, Target};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::FRAC_PI_2;

impl Builder<'_> {
    fn opaque(&self, span: &Span) -> String {
        let p = self.f.p;
        let bytes = p.tokens[span.start].start..p.tokens[span.end - 1].end;
        let text = String::from_utf8_lossy(self.f.text.slice(bytes)).into_owned();
        let word = self.f.word(span.start);
        match p.tokens.get(span.start + 1).filter(|_| span.len() > 1).map(|t| t.kind) {
            Some(Kind::Mark(b'(')) if !word.is_empty() => {
                format!("`{}` computes the target", crate::error::one_line(&text))
            }
            _ => format!("the target `{}` is an expression", crate::error::one_line(&text)),
        }
    }

    /// A declared target: declaration and indices (from 1).
    fn name_of(&self, span: &Span, item: &Item) -> std::result::Result<(usize, Vec<usize>), String> {
        let p = self.f.p;
        let name = self.f.word(span.start);
        let mut indices = Vec::new();
        if span.len() > 1 {
            let inner = span.start + 2..span.end - 1;
            let marks =
                p.tokens[span.start + 1].kind == Kind::Mark(b'{') && p.tokens[span.end - 1].kind == Kind::Mark(b'}');
            if name.is_empty() || !marks || inner.is_empty() {
                return Err(self.opaque(span));
            }
            for (n, i) in inner.enumerate() {
                let t = p.tokens[i];
                let index =
                    std::str::from_utf8(self.f.text.slice(t.start..t.end)).ok().and_then(|s| s.parse::<usize>().ok());
                match (n % 2, t.kind, index) {
                    (0, Kind::Number, Some(k)) if k > 0 => indices.push(k),
                    (1, Kind::Mark(b','), _) => {}
                    _ => return Err(format!("the index of `{name}` is computed")),
                }
            }
        }
        if name.is_empty() {
            return Err(self.opaque(span));
        }
        let d = self.f.resolve(name, Some(item.routine), item.module);
        let shown = self.shown(span.start);
        let d = d.ok_or_else(|| format!("`{shown}` is declared in another module"))?;
        self.f.certain(d)?;
        Ok((d, indices))
    }

    /// Node of a declared target, at its indices.
    fn element(&mut self, d: usize, indices: &[usize]) -> Option<Node> {
        let mut node = self.declared(d)?;
        for k in indices {
            node = match node {
                Node::List(mut items, _) if *k <= items.len() => items.swap_remove(k - 1),
                _ => return None,
            };
        }
        Some(node)
    }

    pub fn joint_goal(&mut self, span: &Span, item: &Item) -> Result<Goal> {
        let (p, text) = (self.f.p, self.f.text);
        if p.tokens[span.start].kind == Kind::Mark(b'[') {
            let Some(node) = value::aggregate(text, &p.tokens, span.clone()) else {
                return Ok(Goal::Opaque(self.opaque(span)));
            };
            return Ok(match value::joints(text, &node, self.robot)? {
                Ok(values) => {
                    let at = At { file: 0, line: self.f.line(span.start) };
                    self.targets.push(Target { name: None, at, values });
                    self.externals.push(External::of(text, node.get(1)));
                    self.literals.push(Literal { bytes: node.bytes(), owner: None });
                    Goal::Joints(self.targets.len() - 1)
                }
                Err(why) => Goal::Opaque(why),
            });
        }
        let (d, indices) = match self.name_of(span, item) {
            Ok(found) => found,
            Err(why) => return Ok(Goal::Opaque(why)),
        };
        let shown = self.f.shown(d);
        if p.decls[d].ty != "jointtarget" {
            return Ok(Goal::Opaque(format!("`{shown}` is no jointtarget")));
        }
        if let Some(&t) = self.known.get(&(d, indices.clone())) {
            return Ok(Goal::Joints(t));
        }
        let Some(node) = self.element(d, &indices) else {
            return Ok(Goal::Opaque(format!("`{shown}` is not declared with numbers")));
        };
        let values = match value::joints(text, &node, self.robot)? {
            Ok(values) => values,
            Err(why) => return Ok(Goal::Opaque(format!("`{shown}`: {why}"))),
        };
        let decl = &p.decls[d];
        let (first, last) = (p.tokens[decl.first].start, p.tokens[decl.end].end);
        let head: Vec<_> = (decl.first..decl.at)
            .map(|i| String::from_utf8_lossy(text.slice(p.tokens[i].start..p.tokens[i].end)))
            .collect();
        let name = if indices.is_empty() {
            shown.clone()
        } else {
            let list: Vec<String> = indices.iter().map(usize::to_string).collect();
            format!("{shown}{{{}}}", list.join(","))
        };
        if decl.storage != Storage::Const && decl.routine.is_none() && !decl.local {
            let kind = if decl.storage == Storage::Pers { "PERS" } else { "VAR" };
            let text =
                format!("`{shown}` is a global {kind}: taken as it is declared; no other module or task may set it");
            self.note(decl.at, text);
        }
        let at = At { file: 0, line: self.f.line(decl.at) };
        self.targets.push(Target { name: Some(name.clone()), at, values });
        self.externals.push(External::of(text, node.get(1)));
        let keep = self.f.states[d].read || self.f.reaches_out(d);
        let owner = Owner { bytes: first..last, head: head.join(" "), name, keep };
        self.literals.push(Literal { bytes: node.bytes(), owner: Some(owner) });
        let t = self.targets.len() - 1;
        self.known.insert((d, indices), t);
        Ok(Goal::Joints(t))
    }

    pub fn pose_goal(
        &mut self,
        span: &Span,
        tool: Option<Arg>,
        wobj: Option<Switch>,
        item: &Item,
        path: PathKind,
        site: &mut Site,
    ) -> Goal {
        let p = self.f.p;
        let node = if p.tokens[span.start].kind == Kind::Mark(b'[') {
            value::aggregate(self.f.text, &p.tokens, span.clone())
        } else {
            match self.name_of(span, item) {
                Ok((d, indices)) => self.element(d, &indices),
                Err(why) => return Goal::Opaque(why),
            }
        };
        let parts = node.as_ref().and_then(|n| Some((n.get(0)?.numbers::<3>()?, n.get(1)?.numbers::<4>()?, n.get(3)?)));
        let Some((xyz, [w, x, y, z], external)) = parts else {
            return Goal::Opaque(self.opaque(span));
        };
        let Some(rotation) = unit(w, x, y, z) else {
            return Goal::Opaque("its orientation is no quaternion".into());
        };
        site.external_axes = External::of(self.f.text, Some(external));
        if matches!(site.external_axes, External::Numbers(_)) {
            site.external = Some(String::from_utf8_lossy(self.f.text.slice(external.bytes())).into_owned());
        }
        // a track carries the base, a positioner may carry the work object
        let carried = site.external_axes.used_from(0);
        let carried = carried.then(|| "external axes, which may carry the robot or the work object".to_string());
        let frame = self.frame(wobj, item).or_else(|| self.tool(tool, item)).or(carried);
        let checked = if path == PathKind::Joint { self.configured.joint } else { self.configured.linear };
        let conf = node.as_ref().and_then(|n| n.get(2)?.numbers::<4>()).filter(|_| checked);
        let solution = conf.map_or(Solution::Same, |conf| quarters(conf, self.robot));
        let position_m = Vector3::from(xyz) * 1e-3;
        Goal::Pose(PoseGoal { position_m, rotation: Some(rotation), foreign_frame: frame, solution })
    }

    /// Whether the external axes that the robot file does not have move from the goal before to this one.
    pub fn external_axes_move(&mut self, goal: &Goal, site: &Site) -> bool {
        let axes = match goal {
            Goal::Joints(t) => self.externals.get(*t).cloned().unwrap_or_default(),
            _ => site.external_axes.clone(),
        };
        // the first of them that the robot file does not have
        let first = self.robot.dof().saturating_sub(6).min(6);
        let before = self.external.replace(axes.clone());
        before.is_some_and(|before| before.moves_to(&axes, first))
    }

    /// Why a robtarget is not in the world frame.
    fn frame(&mut self, wobj: Option<Switch>, item: &Item) -> Option<String> {
        if self.displaced {
            return Some("a program displacement (PDispOn, PDispSet)".into());
        }
        let value = wobj?.value?;
        if self.predefined(&value, item) == Some("wobj0") {
            return None;
        }
        Some(format!("work object `{}`", self.shown(value.start)))
    }

    /// Why the tool is not the robot file's.
    fn tool(&mut self, tool: Option<Arg>, item: &Item) -> Option<String> {
        let Some(arg) = tool else { return Some("a tool that the robot file need not have".into()) };
        let name = self.shown(arg.span.start);
        let frame = if self.predefined(&arg.span, item) == Some("tool0") {
            Some(Isometry3::identity())
        } else {
            // [robhold, [[x,y,z],[q1..q4]], load]
            self.node(&arg.span, item).and_then(|node| {
                let Node::Other(held) = node.get(0)? else { return None };
                let held = self.f.text.slice(held.clone()).eq_ignore_ascii_case(b"true");
                let xyz = node.get(1)?.get(0)?.numbers::<3>()?;
                let [w, x, y, z] = node.get(1)?.get(1)?.numbers::<4>()?;
                let rotation = unit(w, x, y, z).filter(|_| held)?;
                Some(Isometry3::from_parts(Translation3::from(Vector3::from(xyz) * 1e-3), rotation))
            })
        };
        let Some(frame) = frame else { return Some(format!("tool `{name}`, whose frame is not in the text")) };
        let other = frame.inverse() * self.robot.tool;
        // 0.01 mm and 0.001 rad: what robot files and tooldata are rounded to
        let same = other.translation.vector.norm() < 1e-5 && other.rotation.angle() < 1e-3;
        (!same).then(|| format!("tool `{name}`, which is not the tool of the robot file"))
    }
}

/// Quarters of a turn in which a configuration has axes 1, 4 and 6.
fn quarters([cf1, cf4, cf6, _]: [f64; 4], robot: &Axes) -> Solution {
    if robot.dof() != 6 || robot.axis_joints().any(|j| j.kind != JointKind::Revolute) {
        return Solution::Same;
    }
    let bounds = [(0, cf1), (3, cf4), (5, cf6)].map(|(axis, q)| (axis, q * FRAC_PI_2, (q + 1.0) * FRAC_PI_2));
    Solution::Within(bounds.into())
}

fn unit(w: f64, x: f64, y: f64, z: f64) -> Option<UnitQuaternion<f64>> {
    UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.1).filter(|q| q.coords.iter().all(|c| c.is_finite()))
}
