//! The size of one deadzone: where the branch on which the tip leaves meets the place at which it rested.
//!
//! Model, with `w` the travel of the motor after its turn and `v` its travel before it:
//! `P = P0 + A(v)` while the tip arrives, `P0` while it is stationary, `P0 + D(w - delta)` for `w > delta`; `A` and `D` are vector
//! polynomials without a constant, of the least degree that suits. For a given `delta` that is linear in all else; `delta`
//! minimises the sum of squares (grid, then golden section). Its variance is that of the linearised model,
//! `sigma^2 / sum |(I - H) D'|^2`, `H` projecting on the other terms. No kinematics enter: robot file and machine may differ, the
//! tracker's frame is not needed, coupled joints bend the path as they like. A size may come out negative, as it must
//! where there is no gap: an estimate that cannot would pretend one.
//!
//! Window: as much of a branch as a polynomial can follow, by the derivatives of the nominal path, to a share of the standard
//! error of the branch's end, `sigma (degree + 1) / sqrt(rows)`; of the degrees 1 to 3 the one for which that is least. Where the
//! fit still leaves more than the noise does, the window shrinks. Rows beyond six standard deviations are left out.
//!
//! A gap that varies bends the branches in the motor's travel, though not in the joint's. So sizes are found twice: with
//! the motor's travel, then with the joint's by the map of the first round ([`Warp`]).
//!
//! Assumptions: commands and tracker share one clock; the noise is the same in all directions and rows.

use super::motion::{Stretch, Turning};
use super::rest::Rest;
use crate::effects::GapCurve;
use nalgebra::{DMatrix, Vector3};

/// Part of its end's standard error that a polynomial may miss a branch by.
const SHARE: f64 = 0.2;
/// Highest degree of a branch.
const DEGREE: usize = 3;
/// Rows beyond a branch's own number of parameters that it needs.
const SPARE: usize = 1;
/// Distance of an outlier, in standard deviations of one coordinate.
const OUTLIER: f64 = 6.0;
/// Standard errors by which the residuals may exceed the noise before the window shrinks.
const LACK: f64 = 4.0;
const SHRINK: f64 = 0.6;
const SHRINKS: usize = 6;
/// The edge is sought so many times as far before the last row within the rest radius as the nominal joint needs to leave it.
const BACK: f64 = 3.0;
/// Trial sizes between the ends of the search.
const GRID: usize = 48;
const GOLDEN: usize = 40;
/// Steps of the iteration from joint to motor: gaps change by far less than 1 per unit of travel.
const ROUNDS: usize = 30;

/// One deadzone; rad or m.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// Size: travel of the motor between the turn and where the tip moved again.
    pub size: f64,
    /// Standard error for the noise with which the fit was made.
    pub sigma: f64,
    /// Sum of squares of the residuals over all coordinates, m^2, and its degrees of freedom.
    pub sse_m2: f64,
    pub dof: f64,
    pub rows: usize,
    pub outliers: usize,
    /// Where the tip rested, m.
    pub rest_m: Vector3<f64>,
}

/// Sizes of the derivatives (orders 1 to 4) of the nominal tip path by the joint, m per rad^k (or m^k).
pub type Bends = [f64; DEGREE + 1];

/// Derivatives of a path at a position, by differences with step `h`.
pub fn bends(path: impl Fn(f64) -> Vector3<f64>, at: f64, h: f64) -> Bends {
    let p: Vec<Vector3<f64>> = (-2..=2).map(|k| path(at + f64::from(k) * h)).collect();
    let first = (p[3] - p[1]) / (2.0 * h);
    let second = (p[1] - 2.0 * p[2] + p[3]) / (h * h);
    let third = (p[4] - 2.0 * p[3] + 2.0 * p[1] - p[0]) / (2.0 * h.powi(3));
    let fourth = (p[0] - 4.0 * p[1] + 6.0 * p[2] - 4.0 * p[3] + p[4]) / h.powi(4);
    [first.norm(), second.norm(), third.norm(), fourth.norm()]
}

/// How far a polynomial of `degree` misses a path over `span` (Chebyshev's bound of the next term), m.
fn miss(bends: &Bends, degree: usize, span: f64) -> f64 {
    let factorial: f64 = (1..=degree + 1).map(|k| k as f64).product();
    2.0 * bends[degree] / factorial * (0.25 * span).powi(degree as i32 + 1)
}

/// The gap as far as it is known: with it, travels are those of the joint instead of the motor's, and a gap that varies
/// does not bend the branches.
#[derive(Debug, Clone, Default)]
pub struct Warp {
    pub gap: Option<GapCurve>,
}

impl Warp {
    /// Travel of the joint, engaged in direction `dir`, from a turn to the motor position `p`; times the direction in which
    /// the joint leaves the turn.
    fn travel(&self, dir: f64, turn: Turning, p: f64) -> f64 {
        let slack = self.gap.as_ref().map_or(0.0, |b| b.at(p) - b.at(turn.p));
        turn.dir * (p - turn.p - dir * slack)
    }

    /// The other way round: travel of the motor for one of the joint, and how fast the latter grows with the former.
    fn motor(&self, turn: Turning, joint: f64) -> (f64, f64) {
        let of = |w: f64| self.travel(turn.dir, turn, turn.p + turn.dir * w);
        let mut w = joint;
        for _ in 0..ROUNDS {
            w += joint - of(w);
        }
        let h = 1e-4_f64.max(1e-3 * w.abs());
        (w, ((of(w + h) - of(w - h)) / (2.0 * h)).max(0.1))
    }
}

/// A row of the fit: travel before the turn (arriving) or after it, and the tip.
#[derive(Clone, Copy)]
struct Row {
    /// Below 0 arriving; after the turn the travel.
    w: f64,
    tip: Vector3<f64>,
}

/// Rows and degrees of one trial.
struct Window {
    rows: Vec<Row>,
    arriving: usize,
    leaving: usize,
    scale: f64,
    /// Travels between which the edge must lie: the tip leaves its rest radius some way after it.
    edge: [f64; 2],
}

/// Sizes a deadzone; `None` where too few rows show its branch.
///
/// `noise_m` is the standard deviation of one coordinate, `radius_m` the rest radius with which the deadzone was found.
pub fn size(s: &Stretch, rest: &Rest, bends: &Bends, warp: &Warp, noise_m: f64, radius_m: f64) -> Option<Edge> {
    let mut shrink = 1.0;
    let mut best = None;
    for _ in 0..SHRINKS {
        let Some(mut window) = window(s, rest, bends, warp, noise_m, shrink) else { break };
        window.edge[0] -= BACK * radius_m.max(super::rest::RADIUS * noise_m) / bends[0].max(1e-6);
        let Some(mut edge) = fit(window, noise_m) else { break };
        let (motor, slope) = warp.motor(s.turns[rest.turn], edge.size);
        (edge.size, edge.sigma) = (motor, edge.sigma / slope);
        let lack = edge.sse_m2 / edge.dof > noise_m * noise_m * (1.0 + LACK * (2.0 / edge.dof).sqrt());
        best = Some(edge);
        if !lack || noise_m == 0.0 {
            break;
        }
        shrink *= SHRINK;
    }
    best
}

/// Degree and travel of a branch with rows at `travels` (rising): the polynomial may miss the path by a share of the
/// uncertainty with which its rows fix the end of the branch.
fn branch(travels: &[f64], bends: &Bends, noise_m: f64, shrink: f64) -> Option<(usize, f64)> {
    let choices = (1..=DEGREE).filter_map(|degree| {
        let fixed = |n: usize| (degree + 1) as f64 / (n as f64).sqrt();
        let follows = |n: &usize| miss(bends, degree, travels[n - 1]) <= SHARE * noise_m * fixed(*n);
        let n = (degree + SPARE..=travels.len()).take_while(follows).last()?;
        let span = travels[n - 1] * shrink;
        let n = travels[..n].iter().filter(|w| **w <= span).count();
        (n >= degree + SPARE).then(|| (fixed(n), degree, span))
    });
    choices.min_by(|a, b| a.0.total_cmp(&b.0)).map(|c| (c.1, c.2))
}

fn window(s: &Stretch, rest: &Rest, bends: &Bends, warp: &Warp, noise_m: f64, shrink: f64) -> Option<Window> {
    let turn = s.turns[rest.turn];
    let [leaves_s, ends_s] = s.stroke_s(rest.stroke);
    let noise_m = noise_m.max(1e-9);
    let [inner, outer] = rest.travel.map(|w| warp.travel(turn.dir, turn, turn.p + turn.dir * w));
    let leaving: Vec<Row> = s
        .rows(leaves_s, ends_s)
        .filter(|&i| s.t_s[i] > turn.t_s)
        .filter_map(|i| s.tip[i].map(|tip| Row { w: warp.travel(turn.dir, turn, s.p[i]), tip }))
        .collect();
    let beyond: Vec<f64> = leaving.iter().map(|r| r.w - outer).filter(|w| *w >= 0.0).collect();
    let (degree, span) = branch(&beyond, bends, noise_m, shrink)?;
    let mut rows: Vec<Row> = leaving.into_iter().filter(|r| r.w <= outer + span).collect();
    // strokes inside the gap between the turn and the one that leaves: the tip is stationary in all of them
    let between = s.rows(turn.t_s, leaves_s).filter(|&i| s.t_s[i] < leaves_s);
    rows.extend(between.filter_map(|i| s.tip[i].map(|tip| Row { w: 0.0, tip })));
    // rows before the turn, nearest first; those of a pause on the turn do not move
    let arriving: Vec<Row> = (rest.engaged_from..s.t_s.partition_point(|t| *t <= turn.t_s))
        .rev()
        .filter_map(|i| s.tip[i].map(|tip| Row { w: -warp.travel(-turn.dir, turn, s.p[i]).abs(), tip }))
        .collect();
    let before: Vec<f64> = arriving.iter().map(|r| -r.w).filter(|v| *v > 0.0).collect();
    let arrival = branch(&before, bends, noise_m, shrink);
    let reach = arrival.map_or(0.0, |a| a.1);
    rows.extend(arriving.into_iter().filter(|r| -r.w <= reach));
    Some(Window {
        rows,
        arriving: arrival.map_or(0, |a| a.0),
        leaving: degree,
        scale: (outer + span).max(reach),
        edge: [inner, outer],
    })
}

/// Everything but the size, for one trial of it.
struct Trial {
    sse_m2: f64,
    design: DMatrix<f64>,
    q: DMatrix<f64>,
    solution: DMatrix<f64>,
    residual: DMatrix<f64>,
}

fn trial(w: &Window, delta: f64) -> Option<Trial> {
    let (n, p) = (w.rows.len(), 1 + w.arriving + w.leaving);
    if n < p {
        return None;
    }
    let design = DMatrix::from_fn(n, p, |i, k| {
        let at = w.rows[i].w;
        match k {
            0 => 1.0,
            k if k <= w.arriving => (at.min(0.0) / w.scale).powi(k as i32),
            // after the turn only: with a negative size the branch begins at once
            k if at > 0.0 => ((at - delta).max(0.0) / w.scale).powi((k - w.arriving) as i32),
            _ => 0.0,
        }
    });
    let tips = DMatrix::from_fn(n, 3, |i, c| w.rows[i].tip[c]);
    let qr = design.clone().qr();
    let q = qr.q();
    let solution = qr.r().solve_upper_triangular(&(q.transpose() * &tips))?;
    let residual = tips - &design * &solution;
    Some(Trial { sse_m2: residual.norm_squared(), design, q, solution, residual })
}

fn fit(mut w: Window, noise_m: f64) -> Option<Edge> {
    // numbers near zero, or squares of a far frame drown the residuals
    let origin = w.rows.first()?.tip;
    w.rows.iter_mut().for_each(|r| r.tip -= origin);
    let mut outliers = 0;
    loop {
        let delta = search(&w)?;
        let t = trial(&w, delta)?;
        let far: Vec<bool> =
            t.residual.row_iter().map(|r| noise_m > 0.0 && r.norm() > OUTLIER * noise_m * 3f64.sqrt()).collect();
        let count = far.iter().filter(|f| **f).count();
        // more than a tenth is no glitch of the tracker but a model that does not fit
        if count > 0 && outliers == 0 && count * 10 <= w.rows.len() {
            outliers = count;
            let mut keep = far.iter();
            w.rows.retain(|_| !keep.next().copied().unwrap_or(false));
            continue;
        }
        let slope = DMatrix::from_fn(w.rows.len(), 3, |i, c| {
            let at = w.rows[i].w;
            if at <= 0.0 || at <= delta {
                return 0.0;
            }
            let x = (at - delta) / w.scale;
            let part = |k: usize| k as f64 * x.powi(k as i32 - 1) * t.solution[(w.arriving + k, c)];
            -(1..=w.leaving).map(part).sum::<f64>() / w.scale
        });
        let free = &slope - &t.q * (t.q.transpose() * &slope);
        let information = free.norm_squared();
        let dof = (3 * (w.rows.len() - t.design.ncols())) as f64 - 1.0;
        if information <= 0.0 || dof < 1.0 {
            return None;
        }
        let rest_m = origin + Vector3::from_fn(|c, _| t.solution[(0, c)]);
        let sigma = noise_m / information.sqrt();
        return Some(Edge { size: delta, sigma, sse_m2: t.sse_m2, dof, rows: w.rows.len(), outliers, rest_m });
    }
}

/// The size that leaves the least sum of squares.
fn search(w: &Window) -> Option<f64> {
    let [lo, hi] = w.edge;
    let left = |delta: f64| trial(w, delta).map_or(f64::INFINITY, |t| t.sse_m2);
    let step = (hi - lo) / GRID as f64;
    let (mut best, mut least) = (0, f64::INFINITY);
    for k in 0..=GRID {
        let sse = left(lo + step * k as f64);
        if sse < least {
            (best, least) = (k, sse);
        }
    }
    if !least.is_finite() {
        return None;
    }
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (lo + step * (best as f64 - 1.0), lo + step * (best as f64 + 1.0));
    let (mut c, mut d) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut at_c, mut at_d) = (left(c), left(d));
    for _ in 0..GOLDEN {
        if at_c < at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - ratio * (b - a);
            at_c = left(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + ratio * (b - a);
            at_d = left(d);
        }
    }
    Some(0.5 * (a + b))
}
