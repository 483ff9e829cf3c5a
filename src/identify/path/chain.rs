//! The error of one joint along a log, and its derivatives by half gap, spike and decay.
//!
//! It is the catalogue's chain (stiction, then play; [`crate::effects`]) in continuous time, evaluated at the bins of a log. A
//! run is the movement between two reversals. In run `r` with turning point `(t0, p0)` and direction `d`
//!
//! `lag = min(d (p - p0), spike exp(-(t - t0)/tau))` (none in run 0) and the signal `p - d lag` pushes the output as soon as that is
//! more than the half gap `b(p)` after it. At the instant of a reversal the lag is gone, so the play sees `p0` in the old
//! direction once more. Derivatives are exact: while the joint is pushed they are those of `p - d (lag + b)`; while it stands in
//! its gap they are carried from the last pushed point. O(1) per bin.
//!
//! Assumes that a bin is short against gap and decay where they act, which [`super::bins`] sees to.

use crate::effects::{GapCurve, Track};
use std::ops::Range;

/// Movement between two reversals.
#[derive(Debug, Clone)]
pub struct Run {
    /// Where and when it begins (rad or m, s).
    pub t_s: f64,
    pub p: f64,
    /// +1 or -1.
    pub dir: f64,
    /// Sample of the log at which the command still stands on the turning point.
    pub index: usize,
    /// Bins of the run.
    pub bins: Range<usize>,
}

/// Runs of a command: the first movement, then one per reversal. `bins` are still empty.
pub fn runs(track: &Track) -> Vec<Run> {
    let Some(first) = track.dir.iter().position(|&d| d != 0) else { return Vec::new() };
    let start = first.saturating_sub(1);
    let mut out = vec![Run {
        t_s: track.t_s[start],
        p: track.p[start],
        dir: f64::from(track.dir[first]),
        index: start,
        bins: 0..0,
    }];
    out.extend(track.turns.iter().map(|t| Run {
        t_s: t.t_s,
        p: t.p,
        dir: f64::from(t.dir),
        index: t.index,
        bins: 0..0,
    }));
    out
}

/// Half gap of a joint in the fit: `sum c_k x^k` with `x = (p - center)/half`, or a curve that is held.
#[derive(Debug, Clone)]
pub struct GapLaw<'a> {
    pub center: f64,
    pub half: f64,
    pub c: &'a [f64],
    pub held: Option<&'a GapCurve>,
}

impl GapLaw<'_> {
    /// Half gap at position `p`.
    #[inline]
    pub fn at(&self, p: f64) -> f64 {
        match self.held {
            Some(curve) => curve.at(p),
            None if self.c.len() == 1 => self.c[0],
            None => {
                let x = (p - self.center) / self.half;
                self.c.iter().rev().fold(0.0, |s, c| s * x + c)
            }
        }
    }

    /// Number of coefficients that are fitted.
    pub fn fitted(&self) -> usize {
        if self.held.is_some() { 0 } else { self.c.len() }
    }

    /// `scale * d b / d c_k` into `out`.
    #[inline]
    fn gradient(&self, p: f64, scale: f64, out: &mut [f64]) {
        let x = (p - self.center) / self.half;
        let mut power = scale;
        for o in out.iter_mut().take(self.fitted()) {
            *o = power;
            power *= x;
        }
    }
}

/// Lost motion of a joint: gap, spike (rad or m) and decay (s).
#[derive(Debug, Clone)]
pub struct Law<'a> {
    pub gap: GapLaw<'a>,
    pub spike: f64,
    pub tau_s: f64,
}

/// What an evaluation writes: `error` per bin; where asked, the derivatives (per bin: coefficients, spike, tau) and whether the
/// joint is pushed.
pub struct Out<'a> {
    pub error: &'a mut [f64],
    pub derivatives: Option<&'a mut [f64]>,
    pub pushed: Option<&'a mut [bool]>,
}

/// Error `output - command` at the bins with mean time `t` and mean command `p`.
pub fn evaluate(runs: &[Run], t: &[f64], p: &[f64], law: &Law, out: &mut Out) {
    let Some(first) = runs.first() else {
        out.error.fill(0.0);
        return;
    };
    let mut output = Output::new(law, first.p);
    for i in 0..first.bins.start {
        output.record(i, p[i], false, out);
    }
    for (r, run) in runs.iter().enumerate() {
        if r > 0 {
            output.reverse(run);
        }
        for i in run.bins.clone() {
            let pushed = output.push((r > 0).then_some(run), run.dir, t[i], p[i], out.derivatives.is_some());
            output.record(i, p[i], pushed, out);
        }
        // the end of the run carries the state on; it is no measurement
        if let Some(next) = runs.get(r + 1) {
            output.push((r > 0).then_some(run), run.dir, next.t_s, next.p, out.derivatives.is_some());
        }
    }
}

/// The joint's output between the walls of its gap, and its derivatives by the parameters of the law.
struct Output<'a> {
    law: &'a Law<'a>,
    place: f64,
    /// By each fitted value of the gap, the spike and its time constant.
    carried: Vec<f64>,
}

/// How far the drive's signal lags after a reversal.
struct Lag {
    size: f64,
    /// Part of the spike that is left.
    left: f64,
    /// The spike is larger than the travel since the reversal.
    stuck: bool,
}

impl<'a> Output<'a> {
    fn new(law: &'a Law<'a>, place: f64) -> Self {
        Self { law, place, carried: vec![0.0; law.gap.fitted() + 2] }
    }

    /// Writes bin `i`.
    fn record(&self, i: usize, p: f64, pushed: bool, out: &mut Out) {
        out.error[i] = self.place - p;
        let width = self.carried.len();
        if let Some(d) = &mut out.derivatives {
            d[i * width..(i + 1) * width].copy_from_slice(&self.carried);
        }
        if let Some(f) = &mut out.pushed {
            f[i] = pushed;
        }
    }

    /// At the start of `run` the drive turns: a gap that shrank there has moved the output.
    fn reverse(&mut self, run: &Run) {
        let to = run.p + run.dir * self.law.gap.at(run.p);
        if -run.dir * (to - self.place) > 0.0 {
            self.place = to;
            self.law.gap.gradient(run.p, run.dir, &mut self.carried);
            let fitted = self.law.gap.fitted();
            self.carried[fitted..].fill(0.0);
        }
    }

    fn lag(&self, run: Option<&Run>, t_s: f64, p: f64, derivatives: bool) -> Lag {
        let Some(run) = run else { return Lag { size: 0.0, left: 0.0, stuck: true } };
        let left = || (-(t_s - run.t_s) / self.law.tau_s).exp();
        if self.law.spike > 0.0 {
            let left = left();
            let size = self.law.spike * left;
            let travel = (run.dir * (p - run.p)).max(0.0);
            Lag { size: if travel < size { travel } else { size }, left, stuck: travel < size }
        } else if derivatives {
            Lag { size: 0.0, left: left(), stuck: false }
        } else {
            Lag { size: 0.0, left: 0.0, stuck: true }
        }
    }

    /// The drive stands at `p`, moving `dir`, at `t_s`; `reversed` is its run since the last reversal, if there was one.
    fn push(&mut self, reversed: Option<&Run>, dir: f64, t_s: f64, p: f64, derivatives: bool) -> bool {
        let law = self.law;
        let lag = self.lag(reversed, t_s, p, derivatives);
        let gap = law.gap.at(p);
        let signal = dir * p - lag.size;
        // the wall on the far side pushes; the wall in front only where the gap shrinks faster than the signal moves
        let wall = if signal - gap > dir * self.place {
            -1.0
        } else if signal + gap < dir * self.place {
            1.0
        } else {
            return false;
        };
        self.place = dir * (signal + wall * gap);
        if derivatives {
            law.gap.gradient(p, wall * dir, &mut self.carried);
            let since_s = t_s - reversed.map_or(t_s, |r| r.t_s);
            let (by_spike, by_tau) = if lag.stuck {
                (0.0, 0.0)
            } else {
                (-dir * lag.left, -dir * law.spike * lag.left * since_s / (law.tau_s * law.tau_s))
            };
            let fitted = law.gap.fitted();
            self.carried[fitted] = by_spike;
            self.carried[fitted + 1] = by_tau;
        }
        true
    }
}

/// Derivative of a bin's error by the gap and the spike *of one run*: the run that pushed the joint last.
#[derive(Debug, Clone, Copy, Default)]
pub struct ByRun {
    pub run: Option<usize>,
    pub gap: f64,
    pub spike: f64,
}

/// The derivatives of [`evaluate`] separated by run.
pub fn by_run(runs: &[Run], t: &[f64], p: &[f64], law: &Law) -> Vec<ByRun> {
    let mut out = vec![ByRun::default(); t.len()];
    let Some(first) = runs.first() else { return out };
    let mut place = first.p;
    let mut carried = ByRun::default();
    for (r, run) in runs.iter().enumerate() {
        let d = run.dir;
        if r > 0 {
            let to = run.p + d * law.gap.at(run.p);
            if -d * (to - place) > 0.0 {
                place = to;
                carried = ByRun { run: Some(r - 1), gap: d, spike: 0.0 };
            }
        }
        let end = runs.get(r + 1).map(|n| (n.t_s, n.p));
        let points = run.bins.clone().map(|i| (Some(i), (t[i], p[i]))).chain(end.map(|e| (None, e)));
        for (bin, (ti, pi)) in points {
            let left = if r > 0 { (-(ti - run.t_s) / law.tau_s).exp() } else { 0.0 };
            let travel = (d * (pi - run.p)).max(0.0);
            let stuck = travel < law.spike * left;
            let lag = if stuck { travel } else { law.spike * left };
            let gap = law.gap.at(pi);
            let signal = d * pi - lag;
            if signal - gap > d * place || signal + gap < d * place {
                let wall = if signal - gap > d * place { -1.0 } else { 1.0 };
                place = d * (signal + wall * gap);
                carried = ByRun { run: Some(r), gap: wall * d, spike: if stuck { 0.0 } else { -d * left } };
            }
            if let Some(i) = bin {
                out[i] = carried;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{BacklashPosition, Decay, Effect, Stiction, curve::Pchip, joint_output};

    /// A command that turns at many places, sampled so finely that the first sample after a turn is still stuck.
    fn wave() -> (Vec<f64>, Vec<f64>) {
        let n = 60_000;
        let t: Vec<f64> = (0..n).map(|i| i as f64 * 1e-3).collect();
        let p = t
            .iter()
            .map(|&t| if t < 1.0 { 0.0 } else { 1e-3 * ((t - 1.0) * 0.4).sin() + 2e-4 * ((t - 1.0) * 1.7).sin() });
        let p = p.collect();
        (t, p)
    }

    fn binned(track: &Track) -> Vec<Run> {
        let mut all = runs(track);
        for r in 0..all.len() {
            let end = all.get(r + 1).map_or(track.len(), |n| n.index + 1);
            all[r].bins = all[r].index + 1..end;
        }
        all
    }

    #[test]
    fn agrees_with_the_effect_catalogue_at_every_sample() {
        let (t, p) = wave();
        let track = Track::new(&t, &p, 0.0);
        let runs = binned(&track);
        assert!(runs.len() > 10, "{} runs", runs.len());
        let curve = GapCurve::Pchip(Pchip::new(&[[-1e-3, 3e-5], [0.0, 6e-5], [1e-3, 2e-5]]).unwrap());
        for (held, b, spike) in [(None, 5e-5, 6e-5), (None, 5e-5, 0.0), (Some(&curve), 0.0, 4e-5), (None, 0.0, 3e-5)] {
            let half_gap = held.cloned().unwrap_or(GapCurve::Constant(b));
            let effects =
                [Effect::new(Stiction { spike, decay: Decay::Time(1.3) }), BacklashPosition::or_constant(half_gap)];
            let want = joint_output(&track, &effects);
            let c = [b];
            let law = Law { gap: GapLaw { center: 0.0, half: 1e-3, c: &c, held }, spike, tau_s: 1.3 };
            let mut error = vec![0.0; t.len()];
            evaluate(&runs, &t, &p, &law, &mut Out { error: &mut error, derivatives: None, pushed: None });
            // a gap that varies is looked up at the turning point here, one sample later there: slope 0.04 x one sample
            let allowed = if held.is_some() { 1e-10 } else { 1e-12 };
            let worst = (0..t.len()).map(|i| (error[i] + p[i] - want[i]).abs()).fold(0.0, f64::max);
            assert!(worst < allowed, "worst {worst:e} for gap {b} spike {spike}");
        }
    }

    #[test]
    fn derivatives_agree_with_differences_of_the_values() {
        let (t, p) = wave();
        let track = Track::new(&t, &p, 0.0);
        let runs = binned(&track);
        let value = |v: &[f64; 5]| {
            let law =
                Law { gap: GapLaw { center: 1e-4, half: 1.1e-3, c: &v[..3], held: None }, spike: v[3], tau_s: v[4] };
            let mut error = vec![0.0; t.len()];
            let mut der = vec![0.0; t.len() * 5];
            evaluate(&runs, &t, &p, &law, &mut Out { error: &mut error, derivatives: Some(&mut der), pushed: None });
            (error, der)
        };
        let at = [5e-5, 4e-6, -3e-6, 6e-5, 1.3];
        let (_, der) = value(&at);
        for k in 0..5 {
            let h = if k == 4 { 1e-5 } else { 1e-10 };
            let (mut up, mut down) = (at, at);
            up[k] += h;
            down[k] -= h;
            let (a, b) = (value(&up).0, value(&down).0);
            let scale = (0..t.len()).map(|i| der[i * 5 + k].abs()).fold(0.0, f64::max);
            // where the joint is just pushed or released within the step, the value has a kink
            let off =
                (0..t.len()).filter(|&i| ((a[i] - b[i]) / (2.0 * h) - der[i * 5 + k]).abs() > 1e-3 * scale).count();
            assert!(off < t.len() / 500, "parameter {k}: {off} of {} samples", t.len());
        }
    }

    #[test]
    fn derivatives_by_run_add_up_to_those_of_the_whole() {
        let (t, p) = wave();
        let track = Track::new(&t, &p, 0.0);
        let runs = binned(&track);
        let law = Law { gap: GapLaw { center: 0.0, half: 1e-3, c: &[5e-5], held: None }, spike: 6e-5, tau_s: 1.3 };
        let mut error = vec![0.0; t.len()];
        let mut der = vec![0.0; t.len() * 3];
        evaluate(&runs, &t, &p, &law, &mut Out { error: &mut error, derivatives: Some(&mut der), pushed: None });
        for (i, r) in by_run(&runs, &t, &p, &law).iter().enumerate() {
            assert!((r.gap - der[3 * i]).abs() < 1e-15 && (r.spike - der[3 * i + 1]).abs() < 1e-15, "sample {i}");
        }
    }
}
