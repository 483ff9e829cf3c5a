//! What a joint does to its command: friction in the servo, play, wind-up; with derivatives by every parameter.
//!
//! In this order, `d` the direction of movement:
//!
//! ```text
//! z   builds up over travel      dz = (d - z) |dx| / presliding                       (Dahl 1968)
//! m = x - sum over k of gain_k h_k,   h_k' = z' - h_k / tau_k                       the servo's integral action works it off
//! y = play(m, b(x))                                                                  b a natural spline over position
//! out = y - sum over m of windup_m z_m                     z_m: the law of z over the travel of y, presliding times [`OVER`]
//! ```
//!
//! The time constants `tau_k` are given ([`TAUS_S`]); a sum of a few follows any monotone decay between them. Everything but the
//! presliding enters linearly, up to which side of the play is touched; its derivative is a difference quotient.
//! A negative half gap is allowed in the fit (the joint would lead), so that a joint without a gap is estimated without bias.

use super::spline::Spline;
use crate::machine::turns::between_rows;
use crate::numerics::reversal::{Movement, ReversalDetector};

/// Movement back that is a reversal and no rounding, rad or m.
const TURN: f64 = 1e-8;
/// Time constants of the servo's response, s: half a decade apart over what integral actions take.
pub const TAUS_S: [f64; 3] = [0.4, 1.2, 3.6];
/// Preslidings of the wind-up, as multiples of that of the servo: half a decade apart.
pub const OVER: [f64; 3] = [1.0 / 3.0, 1.0, 3.0];
/// Number of parts of the wind-up.
pub const WINDUPS: usize = OVER.len();
/// Parameters of friction: spikes, wind-ups, logarithm of the presliding.
pub const FRICTION: usize = SPIKES + WINDUPS + 1;
/// Number of time constants.
pub const SPIKES: usize = TAUS_S.len();
/// Relative step of the difference quotient by the logarithm of the presliding.
const LOG_STEP: f64 = 0.03;
/// Turning points nearer to a row than this (rad or m) are that row.
const RESOLUTION: f64 = 1e-8;
/// Share of a step by which a row may miss a ramp that it lies on.
const STRAIGHT: f64 = 0.02;
/// Movements below this (rad or m) are number noise.
const STILL: f64 = 1e-10;

/// Parameters of a joint; rad or m.
#[derive(Debug, Clone, PartialEq)]
pub struct JointLaw {
    /// Half gap at the knots of the joint's spline.
    pub gap: Vec<f64>,
    /// Half the change of the servo's error when friction turns over, per time constant.
    pub spikes: [f64; SPIKES],
    pub windups: [f64; WINDUPS],
    pub presliding: f64,
}

impl JointLaw {
    /// Number of parameters: knots, spikes, wind-up, logarithm of the presliding.
    pub fn parameters(&self) -> usize {
        self.gap.len() + FRICTION
    }

    /// As a vector.
    pub fn to_vec(&self) -> Vec<f64> {
        let mut v = self.gap.clone();
        v.extend(self.spikes);
        v.extend(self.windups);
        v.push(self.presliding.ln());
        v
    }

    /// Half the change of the whole wind-up.
    pub fn windup(&self) -> f64 {
        self.windups.iter().sum()
    }

    /// From a vector.
    pub fn from_slice(v: &[f64]) -> Self {
        let n = v.len() - FRICTION;
        let mut spikes = [0.0; SPIKES];
        spikes.copy_from_slice(&v[n..n + SPIKES]);
        let mut windups = [0.0; WINDUPS];
        windups.copy_from_slice(&v[n + SPIKES..n + SPIKES + WINDUPS]);
        Self { gap: v[..n].to_vec(), spikes, windups, presliding: v[n + SPIKES + WINDUPS].exp() }
    }
}

/// A joint's command in a log: rows, and what of the law does not change from trial to trial. The law runs over the rows and
/// over turning points between them: a play forgets nothing, and a row beside a turning point may miss it by more than a gap.
#[derive(Debug, Clone)]
pub struct JointRows {
    pub t_s: Vec<f64>,
    pub x: Vec<f64>,
    /// Rows and turning points in order, and the row of each, where it is one.
    nodes: Vec<(f64, f64, Option<usize>)>,
    /// What is left of each decay since the node before, and its mean over that time.
    decays: Vec<[[f64; 2]; SPIKES]>,
    /// Weights of the gap's knots, row by row.
    weights: Vec<f64>,
    knots: usize,
}

/// Result of a law over rows: the joint's error and its derivatives, one column of rows each.
#[derive(Debug, Clone, Default)]
pub struct Response {
    pub error: Vec<f64>,
    pub by: Vec<Vec<f64>>,
    /// First row from which the play has been closed and friction has turned over.
    pub settled: Option<usize>,
}

impl JointRows {
    pub fn new(t_s: &[f64], x: &[f64], spline: &Spline) -> Self {
        let knots = spline.knots();
        let mut between = turning_points(t_s, x).into_iter().peekable();
        let mut nodes = Vec::with_capacity(x.len());
        for i in 0..x.len() {
            nodes.push((t_s[i], x[i], Some(i)));
            while let Some((_, t, p)) = between.next_if(|b| b.0 == i) {
                nodes.push((t, p, None));
            }
        }
        let mut weights = vec![0.0; knots * nodes.len()];
        for (w, node) in weights.chunks_exact_mut(knots).zip(&nodes) {
            spline.weights(node.1, w);
        }
        let decays = (0..nodes.len())
            .map(|k| {
                let dt = if k > 0 { nodes[k].0 - nodes[k - 1].0 } else { 0.0 };
                TAUS_S.map(|tau| {
                    let keep = (-dt / tau).exp();
                    [keep, if dt > 0.0 { tau / dt * (1.0 - keep) } else { 1.0 }]
                })
            })
            .collect();
        Self { t_s: t_s.to_vec(), x: x.to_vec(), nodes, decays, weights, knots }
    }

    /// Joint error over the rows; derivatives where asked for.
    pub fn respond(&self, law: &JointLaw, derivatives: bool) -> Response {
        let mut out = self.run(law, derivatives);
        if derivatives {
            let stiffer = JointLaw { presliding: law.presliding * LOG_STEP.exp(), ..law.clone() };
            let softer = JointLaw { presliding: law.presliding * (-LOG_STEP).exp(), ..law.clone() };
            let (a, b) = (self.run(&stiffer, false).error, self.run(&softer, false).error);
            out.by.push(a.iter().zip(&b).map(|(a, b)| (a - b) / (2.0 * LOG_STEP)).collect());
        }
        out
    }

    fn run(&self, law: &JointLaw, derivatives: bool) -> Response {
        let (n, knots) = (self.x.len(), self.knots);
        let mut out = Response { error: vec![0.0; n], by: Vec::new(), settled: None };
        if derivatives {
            out.by = vec![vec![0.0; n]; knots + SPIKES + WINDUPS];
        }
        let mut dir = 0.0;
        let (mut z, mut h) = (0.0, [0.0; SPIKES]);
        let (mut y, mut zy) = (self.x.first().copied().unwrap_or(0.0), [0.0; WINDUPS]);
        let mut carried = vec![0.0; knots + SPIKES];
        let (mut travel, mut closed) = (0.0, false);
        for (k, &(_, x, row)) in self.nodes.iter().enumerate() {
            let w = &self.weights[k * knots..(k + 1) * knots];
            let gap: f64 = w.iter().zip(&law.gap).map(|(a, b)| a * b).sum();
            if k > 0 {
                let dx = x - self.nodes[k - 1].1;
                let before = z;
                if dx.abs() > STILL {
                    dir = dx.signum();
                    z = dir + (z - dir) * (-dx.abs() / law.presliding).exp();
                    travel += dx.abs();
                }
                for (h, [keep, mean]) in h.iter_mut().zip(&self.decays[k]) {
                    // the change of z is spread evenly over the time between rows
                    *h = *h * keep + (z - before) * mean;
                }
            }
            let m = x - h.iter().zip(&law.spikes).map(|(h, a)| h * a).sum::<f64>();
            let side = pushed_side(gap, dir, y, m);
            if side != 0.0 {
                let to = m - side * gap;
                wind(&mut zy, to - y, law.presliding);
                y = to;
                closed = true;
                if derivatives {
                    for (c, w) in carried.iter_mut().zip(w) {
                        *c = -side * w;
                    }
                    for (c, h) in carried[knots..].iter_mut().zip(&h) {
                        *c = -h;
                    }
                }
            }
            let Some(i) = row else { continue };
            if out.settled.is_none() && closed && travel > 4.0 * law.presliding + 2.0 * gap.abs() {
                out.settled = Some(i);
            }
            out.error[i] = y - zy.iter().zip(&law.windups).map(|(z, w)| z * w).sum::<f64>() - x;
            if derivatives {
                for (column, c) in out.by.iter_mut().zip(&carried) {
                    column[i] = *c;
                }
                for (column, z) in out.by[knots + SPIKES..].iter_mut().zip(&zy) {
                    column[i] = -z;
                }
            }
        }
        out
    }
}

/// Turning points between rows, as `(row before, time, position)`: where two ramps meet, their crossing; else the extreme of the
/// curve through the neighbours.
fn turning_points(t_s: &[f64], x: &[f64]) -> Vec<(usize, f64, f64)> {
    let mut out: Vec<(usize, f64, f64)> = Vec::new();
    let smooth = between_rows(t_s, x, RESOLUTION);
    let mut smooth = smooth.into_iter().peekable();
    for k in turns(x) {
        let curved = loop {
            match smooth.peek() {
                Some(s) if s.0 + 1 < k => {
                    smooth.next();
                }
                Some(s) if s.0 <= k => break smooth.next(),
                _ => break None,
            }
        };
        out.extend(corner(t_s, x, k).or(curved));
    }
    out.retain(|(row, t, _)| row + 1 < t_s.len() && *t > t_s[*row] && *t < t_s[row + 1]);
    out
}

/// Crossing of the ramps on either side of row `k`, of which that row lies on one.
fn corner(t_s: &[f64], x: &[f64], k: usize) -> Option<(usize, f64, f64)> {
    if k < 2 || k + 2 >= x.len() {
        return None;
    }
    let slope = |a: usize, b: usize| (x[b] - x[a]) / (t_s[b] - t_s[a]);
    let (up, down) = (slope(k - 2, k - 1), slope(k + 1, k + 2));
    if up * down >= 0.0 {
        return None;
    }
    let (before, after) = (x[k - 1] + up * (t_s[k] - t_s[k - 1]), x[k + 1] - down * (t_s[k + 1] - t_s[k]));
    let step = (up * (t_s[k] - t_s[k - 1])).abs();
    if (x[k] - before).abs().min((x[k] - after).abs()) > STRAIGHT * step {
        return None;
    }
    // x[k-1] + up (t - t[k-1]) = x[k+1] + down (t - t[k+1])
    let t = (x[k + 1] - x[k - 1] + up * t_s[k - 1] - down * t_s[k + 1]) / (up - down);
    let value = x[k - 1] + up * (t - t_s[k - 1]);
    if !(t > t_s[k - 1] && t < t_s[k + 1]) || (value - x[k]) * up.signum() <= RESOLUTION {
        return None;
    }
    Some((if t < t_s[k] { k - 1 } else { k }, t, value))
}

/// The flank that pushes the output at `y` when the motor stands at `m` and went last to `dir`: 1 or -1, 0 within the gap. A joint that
/// leads by its gap (below zero) is on a flank always.
fn pushed_side(gap: f64, dir: f64, y: f64, m: f64) -> f64 {
    if gap < 0.0 {
        if dir == 0.0 { 0.0 } else { dir }
    } else if y < m - gap {
        1.0
    } else if y > m + gap {
        -1.0
    } else {
        0.0
    }
}

/// Wind-ups after a movement of `by`: of presliding times [`OVER`], each three times the one before, so one exponential gives all.
fn wind(z: &mut [f64; WINDUPS], by: f64, presliding: f64) {
    let d = by.signum();
    let mut keep = (-by.abs() / (presliding * OVER[WINDUPS - 1])).exp();
    for z in z.iter_mut().rev() {
        *z = d + (*z - d) * keep;
        keep = keep * keep * keep;
    }
}

/// Rows at which a joint turns.
pub fn turns(x: &[f64]) -> Vec<usize> {
    let mut detector = ReversalDetector::new(TURN, 0);
    let at = |(i, &position): (usize, &f64)| match detector.take(i, position) {
        Movement::Reversed { at, .. } => Some(at),
        _ => None,
    };
    x.iter().enumerate().filter_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn winds_up_by_the_exponential_of_each_presliding() {
        let (presliding, by) = (3e-5, -2e-5);
        let mut z = [0.5, -0.2, 0.9];
        let want: Vec<f64> =
            z.iter().zip(OVER).map(|(z, over)| -1.0 + (z + 1.0) * (by / (presliding * over)).exp()).collect();
        wind(&mut z, by, presliding);
        for (is, want) in z.iter().zip(want) {
            assert!((is - want).abs() < 1e-12, "{is} for {want}");
        }
    }

    #[test]
    fn derivatives_are_those_of_the_error() {
        let t: Vec<f64> = (0..400).map(|i| 0.05 * f64::from(i)).collect();
        let x: Vec<f64> = t.iter().map(|t| 0.1 * (0.7 * t).sin()).collect();
        let rows = JointRows::new(&t, &x, &Spline::new(-0.1, 0.1, 3));
        let law = JointLaw {
            gap: vec![4e-5, 5e-5, 6e-5],
            spikes: [1e-5, 2e-5, 0.5e-5],
            windups: [1e-5, 1e-5, 2e-5],
            presliding: 3e-5,
        };
        let (base, values) = (rows.respond(&law, true), law.to_vec());
        for k in 0..values.len() - 1 {
            // small enough that no row changes the side of the play that it touches
            let step = 1e-10;
            let mut moved = values.clone();
            moved[k] += step;
            let other = rows.respond(&JointLaw::from_slice(&moved), false);
            let off = (0..t.len()).map(|i| ((other.error[i] - base.error[i]) / step - base.by[k][i]).abs());
            // a wind-up that follows a play whose edge moves has a derivative of second order that is left out
            let worst = off.fold(0.0, f64::max);
            assert!(worst < 0.6, "parameter {k}: {worst}");
            let mean =
                (0..t.len()).map(|i| ((other.error[i] - base.error[i]) / step - base.by[k][i]).abs()).sum::<f64>()
                    / t.len() as f64;
            assert!(mean < 0.03, "parameter {k}: {mean}");
        }
    }
}
