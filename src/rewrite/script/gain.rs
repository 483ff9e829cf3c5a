//! What the new points of a move gain: those that gain too little stay away (`--min-gain`).
//!
//! Without points, the offset of a move goes over from that at its start to that of its goal along the whole move. The points put it where
//! it belongs. Their gain is the largest distance of the TCP between both, at the places of the points: after a reversal it is
//! about the lost motion of the joints that turn, as the tool sees it.

use super::out::Out;
use super::run::{Run, Vertex};
use crate::robot::Robot;

/// Whether the new points among `span` on the way to a goal gain `least_m` or more; those of an approach always do. `before`: what comes
/// out before them, `end`: at the goal.
pub(super) fn is_enough(
    robot: &Robot,
    run: &Run,
    vertex: &Vertex,
    (before, span, end): (Option<Out>, &[Out], &Out),
    least_m: f64,
) -> bool {
    let mut on_way = span.iter().filter(|o| o.is_on_way(run, vertex.step));
    if least_m <= 0.0 || on_way.clone().any(|o| o.is_approach(run)) {
        return true;
    }
    let start = before.map(|o| offset(run, &o).0);
    let goal = offset(run, end).0;
    on_way.any(|o| {
        let (own, nominal) = offset(run, o);
        let share = o.share(run);
        let spread = |k: usize| {
            let from = start.as_ref().map_or(0.0, |s| s[k]);
            from + share * (goal[k] - from)
        };
        let without: Vec<f64> = nominal.iter().enumerate().map(|(k, q)| q + spread(k)).collect();
        let with: Vec<f64> = nominal.iter().zip(&own).map(|(q, by)| q + by).collect();
        (robot.tcp_m(&with) - robot.tcp_m(&without)).norm() >= least_m
    })
}

/// Offset of a point, and its place without it, rad or m.
fn offset(run: &Run, o: &Out) -> (Vec<f64>, Vec<f64>) {
    let own = &run.vertices[o.vertex].q;
    let nominal: Vec<f64> = match (o.fraction, run.vertices.get(o.vertex + 1)) {
        (Some(f), Some(to)) => own.iter().zip(&to.q).map(|(a, b)| a + f * (b - a)).collect(),
        _ => own.to_vec(),
    };
    (o.q.iter().zip(&nominal).map(|(q, n)| q - n).collect(), nominal)
}
