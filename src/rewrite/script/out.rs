//! A point that comes out of the engine, and where it stands in its run.

use super::run::{Role, Run};

/// A point that came out, with its place among the vertices.
pub(super) struct Out<'a> {
    pub(super) q: &'a [f64],
    pub(super) t_s: Option<f64>,
    /// Vertex itself, or the vertex before it and the share of the leg after that.
    pub(super) vertex: usize,
    pub(super) fraction: Option<f64>,
}

impl Out<'_> {
    /// Whether it stands on the way to a step's goal, and is not one at which the robot waits before it.
    pub(super) fn is_on_way(&self, run: &Run, step: usize) -> bool {
        match self.fraction {
            None => {
                let on_way = |r: Role| matches!(r, Role::Way | Role::Approach | Role::Crossing);
                run.vertices.get(self.vertex).is_some_and(|v| v.step == step && on_way(v.role))
            }
            Some(_) => run.vertices.get(self.vertex + 1).is_some_and(|v| v.step == step && v.role != Role::Before),
        }
    }

    /// Whether it is a point of approach.
    pub(super) fn is_approach(&self, run: &Run) -> bool {
        run.vertices.get(self.vertex).is_some_and(|v| v.role == Role::Approach)
    }

    /// Its share of the way to the goal of its step.
    pub(super) fn share(&self, run: &Run) -> f64 {
        let own = &run.vertices[self.vertex];
        match (self.fraction, run.vertices.get(self.vertex + 1)) {
            (Some(f), Some(to)) => {
                // the leg starts where the step before ended, unless a point of this way stands there
                let of_way = own.step == to.step && matches!(own.role, Role::Way | Role::Crossing);
                let from = if of_way { own.share } else { 0.0 };
                from + f * (to.share - from)
            }
            _ => own.share,
        }
    }
}
