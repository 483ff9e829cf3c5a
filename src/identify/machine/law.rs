//! What a joint does to its command: friction in the servo, play, wind-up; with derivatives by every parameter.
//!
//! In this order, `d` the direction of movement:
//!
//! ```text
//! F = 1 + excess exp(-(v / speed)^2)                                                 friction at low speed (Stribeck), or 1
//! z   builds up over travel      dz = (d F - z) |dx| / presliding                     (Dahl 1968)
//! m = x - sum over k of gain_k h_k,   h_k' = z' - h_k / tau_k                       the servo's integral action works it off
//! y = play(m, b(x))                                                                  b a natural spline over position
//! out = y - sum over m of windup_m z_m                     z_m: the law of z over the travel of y, presliding times [`OVER`]
//! ```
//!
//! The time constants `tau_k` are given ([`TAUS_S`]); a sum of a few follows any monotone decay between them. Everything but the
//! presliding and the speed enters linearly, up to which side of the play is touched; the derivative by the presliding is a difference
//! quotient. `v` is the speed of the command between two nodes.
//! A negative half gap is allowed in the fit (the joint would lead), so that a joint without a gap is estimated without bias.

use super::spline::Spline;
use crate::effects::stribeck::Stribeck;
use crate::machine::turns::between_rows;
use crate::numerics::reversal::{Movement, ReversalDetector};

/// Movement back that is a reversal and no rounding, rad or m.
const TURN: f64 = 1e-8;
/// Time constants of the servo's response, s: half a decade apart over what integral actions take, up to 5 s. Where the longest is shorter
/// than that of a machine, the rest of the spike is taken for lost motion that stays.
pub const TAUS_S: [f64; 3] = [0.4, 1.4, 5.0];
/// Preslidings of the wind-up, as multiples of that of the servo: half a decade apart.
pub const OVER: [f64; 3] = [1.0 / 3.0, 1.0, 3.0];
/// Number of parts of the wind-up.
pub const WINDUPS: usize = OVER.len();
/// Parameters of friction at low speed: excess, logarithm of the speed.
pub const SLOW: usize = 2;
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
    /// Friction at low speed; `None`: the same at all speeds.
    pub stribeck: Option<Stribeck>,
}

impl JointLaw {
    /// Number of parameters: knots, those of friction, those at low speed where there are any.
    pub fn parameters(&self) -> usize {
        self.gap.len() + FRICTION + self.stribeck.map_or(0, |_| SLOW)
    }

    /// As a vector.
    pub fn to_vec(&self) -> Vec<f64> {
        let mut v = self.gap.clone();
        v.extend(self.spikes);
        v.extend(self.windups);
        v.push(self.presliding.ln());
        v.extend(self.stribeck.iter().flat_map(|s| [s.excess, s.speed.ln()]));
        v
    }

    /// Half the change of the whole wind-up.
    pub fn windup(&self) -> f64 {
        self.windups.iter().sum()
    }

    /// A law of this form with the values of a vector.
    pub fn with(&self, v: &[f64]) -> Self {
        let (gap, friction) = v.split_at(self.gap.len());
        let (friction, slow) = friction.split_at(FRICTION);
        let mut law = Self { gap: gap.to_vec(), ..self.clone() };
        law.spikes.copy_from_slice(&friction[..SPIKES]);
        law.windups.copy_from_slice(&friction[SPIKES..SPIKES + WINDUPS]);
        law.presliding = friction[FRICTION - 1].exp();
        law.stribeck = self.stribeck.map(|_| Stribeck { excess: slow[0], speed: slow[1].exp() });
        law
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
    /// Speed of the command since the node before, rad/s or m/s.
    speeds: Vec<f64>,
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
        let speed = |w: &[(f64, f64, Option<usize>)]| Stribeck::speed_of(w[1].1 - w[0].1, w[1].0 - w[0].0);
        let speeds = std::iter::once(0.0).chain(nodes.windows(2).map(speed)).take(nodes.len()).collect();
        Self { t_s: t_s.to_vec(), x: x.to_vec(), nodes, decays, speeds, weights, knots }
    }

    /// Joint error over the rows; derivatives where asked for.
    pub fn respond(&self, law: &JointLaw, derivatives: bool) -> Response {
        let mut out = self.run(law, derivatives);
        if derivatives {
            let stiffer = JointLaw { presliding: law.presliding * LOG_STEP.exp(), ..law.clone() };
            let softer = JointLaw { presliding: law.presliding * (-LOG_STEP).exp(), ..law.clone() };
            let (a, b) = (self.run(&stiffer, false).error, self.run(&softer, false).error);
            let by = a.iter().zip(&b).map(|(a, b)| (a - b) / (2.0 * LOG_STEP)).collect();
            out.by.insert(self.knots + FRICTION - 1, by);
        }
        out
    }

    /// Derivative of the joint error by an excess of friction that fades at `speed`, at no excess.
    pub fn by_excess(&self, law: &JointLaw, speed: f64) -> Vec<f64> {
        let law = JointLaw { stribeck: Some(Stribeck { excess: 0.0, speed }), ..law.clone() };
        self.run(&law, true).by.swap_remove(self.knots + SPIKES + WINDUPS)
    }

    fn run(&self, law: &JointLaw, derivatives: bool) -> Response {
        let (n, knots) = (self.x.len(), self.knots);
        let mut out = Response { error: vec![0.0; n], by: Vec::new(), settled: None };
        if derivatives {
            out.by = vec![vec![0.0; n]; law.parameters() - 1];
        }
        let slow = law.stribeck.is_some() && derivatives;
        let mut dir = 0.0;
        let mut state = State::default();
        // derivatives of the state by the parameters of friction at low speed
        let mut by_slow = [State::default(); SLOW];
        let mut y = self.x.first().copied().unwrap_or(0.0);
        let mut carried = vec![0.0; knots + SPIKES];
        let mut carried_slow = [0.0; SLOW];
        let (mut travel, mut closed) = (0.0, false);
        for (k, &(_, x, row)) in self.nodes.iter().enumerate() {
            let w = &self.weights[k * knots..(k + 1) * knots];
            let gap: f64 = w.iter().zip(&law.gap).map(|(a, b)| a * b).sum();
            let level = law.stribeck.map_or(Level::ALIKE, |s| Level::at(&s, self.speeds[k]));
            if k > 0 {
                let dx = x - self.nodes[k - 1].1;
                if dx.abs() > STILL {
                    dir = dx.signum();
                    travel += dx.abs();
                }
                let keep = if dx.abs() > STILL { (-dx.abs() / law.presliding).exp() } else { 1.0 };
                state.slide(dir * level.value, keep, &self.decays[k]);
                if slow {
                    let by = by_slow.iter_mut().zip(level.by);
                    by.for_each(|(state, by)| state.slide(dir * by, keep, &self.decays[k]));
                }
            }
            let m = x - state.servo(law);
            let side = side(y, m, gap, dir);
            if side != 0.0 {
                let to = m - side * gap;
                let (d, keeps) = ((to - y).signum(), keeps((to - y).abs(), law.presliding));
                state.wind(d * level.value, &keeps);
                y = to;
                closed = true;
                if derivatives {
                    for (c, w) in carried.iter_mut().zip(w) {
                        *c = -side * w;
                    }
                    for (c, h) in carried[knots..].iter_mut().zip(&state.h) {
                        *c = -h;
                    }
                }
                if slow {
                    for ((state, by), c) in by_slow.iter_mut().zip(level.by).zip(&mut carried_slow) {
                        state.wind(d * by, &keeps);
                        *c = -state.servo(law);
                    }
                }
            }
            let Some(i) = row else { continue };
            if out.settled.is_none() && closed && travel > 4.0 * law.presliding + 2.0 * gap.abs() {
                out.settled = Some(i);
            }
            out.error[i] = y - state.wound(law) - x;
            if derivatives {
                for (column, c) in out.by.iter_mut().zip(&carried) {
                    column[i] = *c;
                }
                for (column, z) in out.by[knots + SPIKES..].iter_mut().zip(&state.zy) {
                    column[i] = -z;
                }
                for ((column, c), by) in out.by[knots + SPIKES + WINDUPS..].iter_mut().zip(&carried_slow).zip(&by_slow)
                {
                    column[i] = c - by.wound(law);
                }
            }
        }
        out
    }
}

/// Where friction stands, or the derivative of that: in the servo, what the servo has not yet worked off, in gear and link.
#[derive(Debug, Clone, Copy, Default)]
struct State {
    z: f64,
    h: [f64; SPIKES],
    zy: [f64; WINDUPS],
}

impl State {
    /// The command moves on; friction goes to `goal`, of its distance to which `keep` is left.
    fn slide(&mut self, goal: f64, keep: f64, decays: &[[f64; 2]; SPIKES]) {
        let before = self.z;
        if keep < 1.0 {
            self.z = goal + (self.z - goal) * keep;
        }
        for (h, [keep, mean]) in self.h.iter_mut().zip(decays) {
            // the change of z is spread evenly over the time between rows
            *h = *h * keep + (self.z - before) * mean;
        }
    }

    /// The joint moves on.
    fn wind(&mut self, goal: f64, keeps: &[f64; WINDUPS]) {
        for (z, keep) in self.zy.iter_mut().zip(keeps) {
            *z = goal + (*z - goal) * keep;
        }
    }

    fn servo(&self, law: &JointLaw) -> f64 {
        self.h.iter().zip(&law.spikes).map(|(h, a)| h * a).sum()
    }

    fn wound(&self, law: &JointLaw) -> f64 {
        self.zy.iter().zip(&law.windups).map(|(z, w)| z * w).sum()
    }
}

/// Friction at a speed as a multiple of that at high speed, and its derivatives by excess and logarithm of the speed.
struct Level {
    value: f64,
    by: [f64; SLOW],
}

impl Level {
    /// The same at all speeds.
    const ALIKE: Self = Self { value: 1.0, by: [0.0; SLOW] };

    fn at(stribeck: &Stribeck, speed: f64) -> Self {
        let share = stribeck.share(speed);
        let rising = 2.0 * (speed / stribeck.speed).powi(2);
        Self { value: 1.0 + stribeck.excess * share, by: [share, stribeck.excess * share * rising] }
    }
}

/// Side of the play that is touched: +1 below the motor, -1 above, 0 none.
fn side(y: f64, m: f64, gap: f64, dir: f64) -> f64 {
    if gap < 0.0 {
        dir
    } else if y < m - gap {
        1.0
    } else if y > m + gap {
        -1.0
    } else {
        0.0
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

/// What is left of each wind-up's distance to its goal after a movement of `by`, 0 or more: of presliding times [`OVER`], each three times
/// the one before, so one exponential gives all.
fn keeps(by: f64, presliding: f64) -> [f64; WINDUPS] {
    let mut keep = (-by / (presliding * OVER[WINDUPS - 1])).exp();
    let mut keeps = [0.0; WINDUPS];
    for k in keeps.iter_mut().rev() {
        *k = keep;
        keep = keep * keep * keep;
    }
    keeps
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
        let mut state = State { zy: [0.5, -0.2, 0.9], ..State::default() };
        let want: Vec<f64> =
            state.zy.iter().zip(OVER).map(|(z, over)| -1.0 + (z + 1.0) * (by / (presliding * over)).exp()).collect();
        state.wind(-1.0, &keeps(-by, presliding));
        for (is, want) in state.zy.iter().zip(want) {
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
            stribeck: Some(Stribeck { excess: 0.3, speed: 0.03 }),
        };
        let (base, values) = (rows.respond(&law, true), law.to_vec());
        // what is left out below grows with the friction
        let most = 0.6 * (1.0 + law.stribeck.map_or(0.0, |s| s.excess));
        for k in (0..values.len()).filter(|k| *k != 3 + FRICTION - 1) {
            // small enough that no row changes the side of the play that it touches; the same in shares of friction
            let unit = if k < 3 + FRICTION { 1.0 } else { 4e-5 };
            let step = 1e-10 / unit;
            let mut moved = values.clone();
            moved[k] += step;
            let other = rows.respond(&law.with(&moved), false);
            let off = (0..t.len()).map(|i| ((other.error[i] - base.error[i]) / step - base.by[k][i]).abs() / unit);
            // a wind-up that follows a play whose edge moves has a derivative of second order that is left out
            let worst = off.fold(0.0, f64::max);
            assert!(worst < most, "parameter {k}: {worst}");
            let mean = (0..t.len())
                .map(|i| ((other.error[i] - base.error[i]) / step - base.by[k][i]).abs() / unit)
                .sum::<f64>()
                / t.len() as f64;
            assert!(mean < 0.03, "parameter {k}: {mean}");
        }
    }
}
