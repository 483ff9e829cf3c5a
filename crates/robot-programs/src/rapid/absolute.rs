//! Goals that cannot be determined, but are whole places of their own: data of RAPID hold a whole pose, or all joint values, whatever they
//! are, and so do sums of them. What a routine of the program gives may be made of where the robot stands.

use super::lex::Kind;
use super::read::{Item, Span};
use super::steps::Builder;
use super::value::Node;
use super::words::{Leads, Motion};
use crate::script::{Goal, PathKind};

/// Functions whose value is made of their arguments alone.
const OF_ARGUMENTS: [&str; 30] = [
    "abs",
    "acos",
    "asin",
    "atan",
    "atan2",
    "cos",
    "crossprod",
    "defframe",
    "dim",
    "distance",
    "dnumtonum",
    "dotprod",
    "eulerzyx",
    "exp",
    "max",
    "min",
    "mirpos",
    "norient",
    "numtodnum",
    "offs",
    "orientzyx",
    "poseinv",
    "posemult",
    "posevect",
    "pow",
    "reltool",
    "round",
    "sin",
    "sqrt",
    "trunc",
];

impl Builder<'_> {
    /// Whether the goal of a motion is such a one.
    ///
    /// `goal = expression of data, numbers and functions of these`
    pub(super) fn is_absolute(&mut self, motion: &Motion, goal: &Goal, span: &Span, item: &Item) -> bool {
        let places = self.robot.places();
        // an external axis at 9E9 stays where it is
        let alone = places.certain && places.external.is_empty();
        // in a list of joints an axis may be left where it is
        let listed = motion.leads == Leads::Joints && self.f.word(span.start).is_empty();
        let leads = matches!(motion.leads, Leads::Joints | Leads::Pose) && motion.path != PathKind::Curve;
        alone
            && leads
            && !listed
            && matches!(goal, Goal::Opaque(_))
            && self.is_of_data(span)
            && !self.leaves_axes(span, item)
    }

    /// The words of an expression are data, and functions of these; `not` and the like are no calls.
    fn is_of_data(&self, span: &Span) -> bool {
        let tokens = &self.f.p.tokens;
        let called = |i: usize| tokens.get(i + 1).is_some_and(|t| t.kind == Kind::Mark(b'('));
        let own = |name: &str| self.f.p.routines.iter().any(|r| r.name == name);
        span.clone().all(|i| match tokens.get(i).map(|t| t.kind) {
            Some(Kind::Word) if called(i) => {
                let name = self.f.word(i);
                OF_ARGUMENTS.contains(&name) && !own(name)
            }
            Some(Kind::Mark(b'%')) | None => false,
            Some(_) => true,
        })
    }

    /// A declared joint target that leaves an axis where it is (9E9).
    fn leaves_axes(&mut self, span: &Span, item: &Item) -> bool {
        let name = self.f.word(span.start);
        let declared = self.f.resolve(name, Some(item.routine), item.module);
        let joints = declared.filter(|d| self.f.p.decls[*d].ty == "jointtarget");
        joints.and_then(|d| self.declared(d)).is_some_and(|node| has_unused(&node))
    }
}

/// Whether a list of joints, in an array or not, holds one that is not used.
fn has_unused(node: &Node) -> bool {
    let Some(items) = node.list() else { return false };
    let of_arm = |list: &[Node]| list.len() == 6 && list.iter().any(|n| n.number().is_some_and(|v| v.abs() >= 8.9e9));
    match items {
        // [robax, extax]
        [Node::List(robax, _), Node::List(extax, _)] if robax.len() == 6 && extax.len() == 6 => of_arm(robax),
        _ => items.iter().any(has_unused),
    }
}
