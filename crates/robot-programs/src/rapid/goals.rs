//! Targets of RAPID moves that are joint values or have a name, or why they cannot be determined.

use super::built::{Literal, Owner};
use super::lex::Kind;
use super::read::{Item, Span, Storage};
use super::reason::Reason;
use super::rules::{External, own_external};
use super::steps::Builder;
use super::value::{self, Node};
use crate::error::{Result, one_line};
use crate::script::cursor::integer;
use crate::script::{self, Goal, PoseForm, Target, Value};
use std::sync::Arc;

impl Builder<'_> {
    pub(super) fn opaque(&self, span: &Span) -> script::Reason {
        let p = self.f.p;
        let bytes = p.tokens[span.start].start()..p.tokens[span.end - 1].end();
        let text = one_line(&String::from_utf8_lossy(self.f.text.slice(bytes))).into();
        let word = self.f.word(span.start);
        match p.tokens.get(span.start + 1).filter(|_| span.len() > 1).map(|t| t.kind) {
            Some(Kind::Mark(b'(')) if !word.is_empty() => Reason::Function(text).into(),
            _ => script::Reason::Expression(text),
        }
    }

    /// The points that a move names keep their values if no target is written for the move itself: it leads where it did.
    pub(super) fn keep_points_of(&mut self, goal: &Goal, span: &Span, item: &Item) {
        if goal.target().is_none() {
            let named = |k: usize| self.f.resolve(self.f.word(k), Some(item.routine), item.module);
            let named: Vec<usize> = span.clone().filter_map(named).collect();
            self.kept_points.extend(named);
        }
    }

    /// Marks the declarations of these points: their values are not edited in place.
    pub(super) fn keep_points(&mut self) {
        for t in self.known.iter().filter(|((d, _), _)| self.kept_points.contains(d)).map(|known| *known.1) {
            let owner = self.literals.get_mut(t).and_then(|literal| literal.owner.as_mut());
            owner.into_iter().for_each(|owner| owner.keep = true);
        }
    }

    /// A declared target: declaration and indices (from 1).
    ///
    /// `target = name ["{" index {"," index} "}"]`
    pub(super) fn name_of(&self, span: &Span, item: &Item) -> std::result::Result<(usize, Vec<usize>), script::Reason> {
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
                let index = integer::<usize>(self.f.text.slice(t.start()..t.end()));
                match (n % 2, t.kind, index) {
                    (0, Kind::Number, Some(k)) if k > 0 => indices.push(k),
                    (1, Kind::Mark(b','), _) => {}
                    _ => return Err(Reason::IndexComputed(name.into()).into()),
                }
            }
        }
        if name.is_empty() {
            return Err(self.opaque(span));
        }
        let d = self.f.resolve(name, Some(item.routine), item.module);
        let shown = self.shown(span.start);
        let d = d.ok_or_else(|| Reason::NotDeclared(shown.into()))?;
        let d = if indices.is_empty() { self.f.passed(d).unwrap_or(d) } else { d };
        self.f.certain(d)?;
        Ok((d, indices))
    }

    /// Node of a declared target, at its indices.
    pub(super) fn element(&mut self, d: usize, indices: &[usize]) -> Option<Node> {
        let mut node = self.declared(d)?;
        for k in indices {
            node = match node {
                Node::List(mut items, _) if *k <= items.len() => items.swap_remove(k - 1),
                _ => return None,
            };
        }
        Some(node)
    }

    /// The joint target of a move: written in it, or declared.
    ///
    /// `goal = aggregate | name ["{" index {"," index} "}"]`
    pub fn joint_goal(&mut self, span: &Span, item: &Item) -> Result<Goal> {
        let (p, text) = (self.f.p, self.f.text);
        if p.tokens[span.start].kind == Kind::Mark(b'[') {
            let Some(node) = value::aggregate(text, &p.tokens, span.clone()) else {
                return Ok(Goal::Opaque(self.opaque(span)));
            };
            return Ok(match value::joints(text, &node, self.robot)? {
                Ok(values) => {
                    let at = self.at(span.start);
                    self.targets.push(Target { name: None, at, values, pose: None });
                    self.external_axes(External::of(text, node.get(1)));
                    self.literals.push(Literal { bytes: node.bytes().into(), owner: None, foreign: None });
                    let t = self.targets.len() - 1;
                    self.keep_numbers(t, &node);
                    Goal::Joints(t)
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
            return Ok(Goal::opaque(Reason::NoJointTarget(shown.into())));
        }
        if let Some(&t) = self.known.get(&(d, indices.clone())) {
            return Ok(Goal::Joints(t));
        }
        let Some(node) = self.element(d, &indices) else {
            return Ok(Goal::opaque(Reason::NoNumbers(shown.into())));
        };
        match value::joints(text, &node, self.robot)? {
            Ok(values) => {
                let t = self.declared_target(d, indices, &node, values, None);
                self.keep_numbers(t, &node);
                Ok(Goal::Joints(t))
            }
            Err(why) => Ok(Goal::Opaque(why.of_declared(&shown))),
        }
    }

    /// Keeps the numbers of a joint target for which the robot file has no joint.
    fn keep_numbers(&mut self, target: usize, node: &Node) {
        if let Some(without) = &mut self.without_joint {
            without.keep(target, value::of_arm(node));
        }
    }

    /// A target of a declaration, with what is needed to write it.
    pub(super) fn declared_target(
        &mut self,
        d: usize,
        indices: Vec<usize>,
        node: &Node,
        values: Vec<Option<Value>>,
        pose: Option<PoseForm>,
    ) -> usize {
        let (p, text) = (self.f.p, self.f.text);
        let shown = self.f.shown(d);
        let decl = &p.decls[d];
        let (first, last) = (p.tokens[decl.first].start(), p.tokens[decl.end].end());
        let head: Vec<_> = (decl.first..decl.at)
            .map(|i| String::from_utf8_lossy(text.slice(p.tokens[i].start()..p.tokens[i].end())))
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
        let at = self.at(decl.at);
        self.targets.push(Target { name: Some(name.clone()), at, values, pose });
        let external = if pose.is_some() { 3 } else { 1 };
        self.external_axes(External::of(text, node.get(external)));
        let elsewhere = first >= self.project.own_end();
        if elsewhere {
            self.note(decl.at, format!("`{shown}` is taken from this file, and written into the moves to it"));
        }
        let keep = self.f.states[d].read || self.f.reaches_out(d) || elsewhere;
        let shared = decl.routine.is_none() && !decl.local;
        let owner = Owner { bytes: first..last, head: head.join(" "), name, keep, shared };
        let foreign = elsewhere.then(|| text.slice(node.bytes()).into());
        self.literals.push(Literal { bytes: node.bytes().into(), owner: Some(Box::new(owner)), foreign });
        let t = self.targets.len() - 1;
        self.known.insert((d, indices), t);
        t
    }

    /// External axes in the memory of those of the target before, where they are the same: most are.
    pub(super) fn like_before(&self, axes: External) -> Arc<External> {
        let before = self.externals.last().or(self.external.as_ref()).filter(|before| ***before == axes);
        before.map_or_else(|| Arc::new(axes), Arc::clone)
    }

    /// Those of the target that was read last.
    fn external_axes(&mut self, axes: External) {
        let axes = self.like_before(axes);
        self.externals.push(axes);
    }

    /// Whether the external axes that the robot file does not have move from the goal before to this one.
    pub fn external_axes_move(&mut self, goal: &Goal, of_pose: Arc<External>) -> bool {
        let axes = match goal {
            Goal::Joints(t) => self.externals.get(*t).cloned().unwrap_or_default(),
            _ => of_pose,
        };
        let own = own_external(self.robot);
        let before = self.external.replace(Arc::clone(&axes));
        self.enter_with_axes(axes.used_beside(own));
        before.is_some_and(|before| before.moves_to(&axes, own))
    }
}
