//! From the selected fit to the document's entries: one half gap and one stiction per joint, with intervals.

use super::interval::{self, Covariance};
use super::problem::{Name, Problem};
use super::reversal::Alike;
use super::select::Selected;
use super::{JointDetail, MISTRUST, Options, solve};
use crate::effects::{Decay, GapCurve};
use crate::gaps::note::path::Note;
use crate::gaps::{JointGap, StictionFound};
use crate::numerics::{chi_squared, student};
use crate::robot::Robot;

/// Half intervals that a gap must have to be significant where the residuals are correlated strongly.
const MISTRUST_MARGIN: f64 = 3.0;
/// Standard error over spike from which the log does not separate spike and decay.
const SEPARABLE: f64 = 0.5;
/// A gap that is not significant is not told from a lag where the lag makes its standard error this many times as large.
const NOT_TOLD: f64 = 3.0;
/// p of the test that the gaps at a joint's reversals are alike, below which a note says that they differ.
const ALIKE_P: f64 = 1e-3;

/// What the fit says of one joint.
pub(super) struct Estimate {
    /// Place among the problem's joints.
    place: usize,
    pub(super) gap: JointGap,
    pub(super) detail: JointDetail,
}

/// The joints that are reported; `variance` is that of a row in units of its noise.
pub(super) fn estimates(problem: &Problem, selected: &Selected, variance: f64, options: &Options) -> Vec<Estimate> {
    let cov = Covariance::new(problem, &selected.values, &selected.form, variance);
    let t95 = student::factor(0.95, selected.dof);
    let asked = (0..problem.joints.len()).filter(|&g| options.reports(problem.joints[g].axis));
    asked
        .map(|g| {
            let (mut gap, detail) = joint(g, problem, selected, &cov, t95);
            if let Some(ci95) = options.known.iter().find(|k| k.axis == gap.axis).and_then(|k| k.ci95) {
                // the width is that of the held document; the middle that of this path
                let wide = (ci95[1] - ci95[0]) / 2.0;
                gap.ci95 = [(gap.half_gap - wide).max(0.0), gap.half_gap + wide];
                gap.significant = gap.half_gap > wide;
            }
            if selected.inflation > MISTRUST {
                gap.significant &= gap.half_gap > MISTRUST_MARGIN * (gap.ci95[1] - gap.half_gap);
            }
            Estimate { place: g, gap, detail }
        })
        .collect()
}

impl Estimate {
    /// Adds what a reader should know of this joint; `alike` are the tests that the gaps at its reversals are the same.
    pub(super) fn notes(&self, robot: &Robot, alike: &[Alike], widened: &[f64], notes: &mut Vec<Note>) {
        let axis = robot.axis(self.gap.axis);
        let joint = || axis.name.clone();
        if !self.gap.significant && widened.get(self.place).is_some_and(|w| *w > NOT_TOLD) {
            notes.push(Note::LagNotTold { joint: joint() });
        }
        if let Some(s) = &self.detail.stiction {
            notes.push(Note::LagKnownBest {
                joint: joint(),
                kind: axis.kind,
                at_s: s.best_s,
                lag: s.lag,
                ci95: s.lag_ci95,
            });
            if s.relative > SEPARABLE {
                notes.push(Note::SpikeAndDecayNotSeparated { joint: joint() });
            }
        }
        if let Some(a) = alike.iter().find(|a| a.joint == self.place) {
            let p_value = chi_squared::tail(a.chi2, a.dof);
            if p_value < ALIKE_P {
                notes.push(Note::GapsDiffer { joint: joint(), p_value });
            }
        }
    }
}

/// A joint's entry of the document, and the rest.
fn joint(g: usize, problem: &Problem, s: &Selected, cov: &Covariance, t95: f64) -> (JointGap, JointDetail) {
    let j = &problem.joints[g];
    let v = &s.values[g];
    let stiction = if s.form.sticky[g] { interval::stiction(cov, g, v, t95) } else { None };
    let (half_gap, sigma, schedule) = match &j.held {
        Some(curve) => (solve::mean_gap(problem, g, v), 0.0, curve.constant().is_none().then(|| curve.clone())),
        None if v.c.len() == 1 => {
            (v.c[0], cov.place(Name::Gap { joint: g, power: 0 }).map_or(0.0, |k| cov.sigma(&[(k, 1.0)])), None)
        }
        None => {
            // mean over the travel: even powers of x only
            let weight = |k: usize| if k.is_multiple_of(2) { 1.0 / (k as f64 + 1.0) } else { 0.0 };
            let mean = v.c.iter().enumerate().map(|(k, c)| c * weight(k)).sum();
            let parts: Vec<(usize, f64)> = (0..v.c.len())
                .filter_map(|power| cov.place(Name::Gap { joint: g, power }).map(|p| (p, weight(power))))
                .collect();
            (mean, cov.sigma(&parts), Some(polynomial(&v.c, j.center, j.half)))
        }
    };
    let ci95 = [(half_gap - t95 * sigma).max(0.0), half_gap + t95 * sigma];
    let gap = JointGap {
        axis: j.axis,
        half_gap,
        ci95,
        significant: half_gap - t95 * sigma > 0.0,
        sides: None,
        schedule,
        varies_p_value: s.varies_p[g],
        stiction: stiction.map(|i| StictionFound {
            spike: v.spike,
            ci95: i.spike_ci95,
            decay: Decay::Time(v.tau_s),
            decay_ci95: i.tau_ci95_s,
        }),
        stiction_p_value: s.stiction_p[g],
    };
    let detail = JointDetail {
        axis: j.axis,
        stiction_f: s.stiction_f[g],
        stiction,
        shared_decay: s.form.shared && s.form.sticky[g],
        held: j.held.is_some(),
    };
    (gap, detail)
}

/// `sum c_k ((p - center)/half)^k` as a polynomial in `p`.
fn polynomial(c: &[f64], center: f64, half: f64) -> GapCurve {
    let mut out = vec![0.0; c.len()];
    let mut power = vec![1.0];
    for ck in c {
        for (o, x) in out.iter_mut().zip(&power) {
            *o += ck * x;
        }
        let mut next = vec![0.0; power.len() + 1];
        for (k, x) in power.iter().enumerate() {
            next[k] -= x * center / half;
            next[k + 1] += x / half;
        }
        power = next;
    }
    GapCurve::Polynomial { coefficients: out, range: [center - half, center + half] }
}
