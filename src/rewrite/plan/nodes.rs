//! Nodes of a stroke on the legs of the path: where the command has its own value.

use super::turn::Stroke;
use super::{COARSE, Clock, FINE, GENTLE, MOST_FOR_TRAVEL, MOST_NODES_PER_LEG, NEAREST, Place, Plan, Work};
use crate::compensator::{FrictionOffset, FrictionShape};
use crate::effects::Decay;
use crate::rewrite::path::Path;
use nalgebra::Vector3;

/// Share of friction that builds up or fades below which it asks for no nodes.
const FADED: f64 = 1e-3;
/// Times that are nearer to each other may be written as one, s.
const ONE_TIME_S: f64 = 2e-6;
/// Share of a leg within which a point is its vertex.
const AT_VERTEX: f64 = 1e-6;

/// A leg of the path after a turn: position on the path and of the axis at both ends, TCP vector, duration.
struct Leg {
    u: [f64; 2],
    p: [f64; 2],
    tcp_m: Vector3<f64>,
    duration_s: f64,
}

impl Plan<'_> {
    /// Lays the nodes of a stroke; node 0 is the turn. Returns the index of the step point. `jump_m` is what the step moves
    /// the TCP.
    pub(super) fn lay_nodes(
        &self,
        stroke: &Stroke,
        path: &Path,
        clock: Clock,
        legs: &[(Vector3<f64>, f64)],
        jump_m: Vector3<f64>,
        work: &mut Work,
    ) -> usize {
        let (nodes, shares) = (&mut work.nodes, &mut work.shares);
        let (axis, k, step_s) = (stroke.axis, stroke.k, stroke.step_s);
        nodes.clear();
        let u0 = path.u(k);
        nodes.push(Place { vertex: k, share: 0.0, p: stroke.p_turn, since_s: 0.0, u: u0 });
        let mut first = None;
        let mut elapsed = 0.0;
        for (n, &(tcp_m, duration_s)) in legs.iter().enumerate() {
            let i = k + n;
            let leg =
                Leg { u: [path.u(i), path.u(i + 1)], p: [path.q(i)[axis], path.q(i + 1)[axis]], tcp_m, duration_s };
            let ([ua, ub], [pa, pb]) = (leg.u, leg.p);
            let step_here =
                if first.is_none() { self.step_share(stroke, &leg, clock, u0, elapsed, jump_m) } else { None };
            self.shares(stroke, &leg, step_here, first.is_some(), elapsed, shares);
            // the step takes additional time at constant speed
            let mut extra = 0.0;
            if let (Some(s), Clock::Speed(v)) = (step_here, clock) {
                let to_step = leg.tcp_m * s;
                extra = (((to_step + jump_m).norm() - to_step.norm()) / v).max(0.0);
            }
            for &s in shares.iter() {
                if step_here == Some(s) && first.is_none() {
                    first = Some(nodes.len());
                }
                let since_s = elapsed + s * duration_s + extra;
                nodes.push(Place { vertex: i, share: s, p: pa + s * (pb - pa), since_s, u: ua + s * (ub - ua) });
            }
            elapsed += duration_s + extra;
            if first.is_none() && n + 1 < legs.len() {
                // the step may end on a vertex
                let here =
                    (ub - u0 - self.step_fraction).abs() < AT_VERTEX && (clock == Clock::None || elapsed >= step_s);
                if here {
                    first = Some(nodes.len());
                }
            }
            nodes.push(Place { vertex: i + 1, share: 0.0, p: pb, since_s: elapsed, u: ub });
        }
        first.unwrap_or(nodes.len() - 1)
    }

    /// The step point on this leg: a fraction of a program segment after the turn, and not before the joint can.
    fn step_share(
        &self,
        stroke: &Stroke,
        leg: &Leg,
        clock: Clock,
        u0: f64,
        elapsed: f64,
        jump_m: Vector3<f64>,
    ) -> Option<f64> {
        let ([ua, ub], [pa, pb], duration) = (leg.u, leg.p, leg.duration_s);
        let by_u = if ub > ua { (u0 + self.step_fraction - ua) / (ub - ua) } else { 1.0 };
        let by_t = if clock != Clock::None && duration > 0.0 { (stroke.step_s - elapsed) / duration } else { 0.0 };
        // nearer, where the joint would lag by more than the tolerance until then
        let lag = (stroke.lever.norm() * (pb - pa)).abs();
        // on a long leg not steeper than the joint moves anyway, or a controller would have to stop for it
        let nearest = NEAREST.min(GENTLE * jump_m.norm() / lag.max(f64::MIN_POSITIVE));
        let near = if self.step_exact || lag <= 0.0 { by_u } else { by_u.min((self.shape_m / lag).max(nearest)) };
        let share = near.max(by_t);
        // no nearer to a row than times are written
        let timed = clock != Clock::None && duration > 0.0;
        let apart = if timed { (ONE_TIME_S / duration).clamp(AT_VERTEX, 0.25) } else { AT_VERTEX };
        (share <= 1.0 - apart).then(|| share.max(apart))
    }

    /// Where nodes stand inside a leg: the step point, then what resolves the friction's decay, and the end of a ramp.
    fn shares(
        &self,
        stroke: &Stroke,
        leg: &Leg,
        step_here: Option<f64>,
        stepped: bool,
        elapsed: f64,
        shares: &mut Vec<f64>,
    ) {
        let ([ua, ub], [pa, pb], d) = (leg.u, leg.p, stroke.d);
        shares.clear();
        if let Some(f) = &stroke.friction {
            let parts = subdivisions(f, [elapsed, leg.duration_s], [(pa - stroke.p_turn) * d, (pb - pa) * d], ub - ua);
            let from = step_here.unwrap_or(0.0);
            if stepped || step_here.is_some() {
                shares.extend((1..parts).map(|m| from + (1.0 - from) * m as f64 / parts as f64));
            }
        }
        if let Some(s) = step_here {
            shares.insert(0, s);
        }
        // the end of a ramp bends the command
        let ramp = stroke.ramp;
        let ramp_end = stroke.p_turn + d * ramp;
        if ramp > 0.0 && d * (ramp_end - pa) > 0.0 && d * (pb - ramp_end) > 0.0 {
            let s = (ramp_end - pa) / (pb - pa);
            let i = shares.partition_point(|x| *x < s);
            if stepped || step_here.is_some_and(|h| h < s) {
                shares.insert(i, s);
            }
        }
    }
}

/// Parts of a leg that resolve the friction's decay there: time and travel before the leg and on it, poses on it.
fn subdivisions(
    f: &FrictionOffset,
    [elapsed_s, duration_s]: [f64; 2],
    [travelled, travel]: [f64; 2],
    poses: f64,
) -> usize {
    let parts = match f.shape {
        FrictionShape::Decay(Decay::Time(tau)) => {
            if elapsed_s > -tau * FADED.ln() {
                1.0
            } else {
                // the command may fall where the joint is slower than the friction fades
                let falls = travel * tau < f.gain * (-elapsed_s / tau).exp() * duration_s;
                duration_s / tau * if falls { FINE } else { COARSE }
            }
        }
        FrictionShape::Decay(Decay::Travel(lambda)) => travel.abs() / lambda * COARSE,
        FrictionShape::Poses { .. } => poses * COARSE,
        FrictionShape::Response(r) => {
            let early = r.spikes.iter().filter(|s| s.gain != 0.0 && elapsed_s <= -s.decay_s * FADED.ln());
            let in_time = early.map(|s| duration_s / s.decay_s).fold(0.0, f64::max);
            let builds_up = travelled <= -r.longest_presliding() * FADED.ln();
            let over_travel = if builds_up { travel.abs() / r.presliding * COARSE } else { 0.0 };
            (in_time * COARSE).max(over_travel.min(MOST_FOR_TRAVEL))
        }
    };
    if parts.is_nan() { 1 } else { (parts.ceil() as usize).clamp(1, MOST_NODES_PER_LEG) }
}
