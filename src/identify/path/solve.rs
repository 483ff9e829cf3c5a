//! The fit of the projected problem by [`crate::numerics::least_squares`], and the grid from which a stiction starts.
//!
//! It stops when a step gains less than 1e-8 of the cost. Bounds: a half gap of 0 or more, a spike from 0 to
//! [`SPIKE_OVER_GAP`] times the gap, a decay between the bin length and half the longest run, a decay step of at most a factor e.

use super::problem::{Form, Name, Problem, Values};
use crate::numerics::least_squares::{self, Criterion, Options, Products, Scaling, TerminationReason};

const SPIKE_OVER_GAP: f64 = 5.0;
/// Gap below which the bound of the spike no longer shrinks, rad or m (0.002 deg, 0.035 mm).
const LEAST_FOR_SPIKE: f64 = 3.5e-5;
/// Gap from which a fit starts where the regression finds none, rad or m (2e-4 deg).
pub const START_GAP: f64 = 3.5e-6;

/// Bounds of the decay, s.
#[derive(Debug, Clone, Copy)]
pub struct TauBounds {
    pub lo_s: f64,
    pub hi_s: f64,
}

impl TauBounds {
    /// From the runs of all logs.
    pub fn of(problem: &Problem) -> Self {
        let mut longest = 0.0f64;
        for log in problem.logs() {
            let end = log.t_s.last().copied().unwrap_or(0.0);
            for j in log.joints.iter().filter(|j| j.reverses()) {
                for (k, r) in j.runs.iter().enumerate() {
                    longest = longest.max(j.runs.get(k + 1).map_or(end, |n| n.t_s) - r.t_s);
                }
            }
        }
        let hi_s = (longest / 2.0).max(1.0);
        Self { lo_s: (1e-4 * hi_s).max(0.02), hi_s }
    }
}

/// Settings of the fit: gaps start near their values, and the cost is settled long before its last digit.
const SETTINGS: Options = Options {
    max_steps: 0,
    cost_tolerance: 1e-8,
    cost_tolerance_absolute: 0.0,
    gradient_tolerance: 1e-12,
    step_tolerance: 0.0,
    initial_damping: 1e-3,
    least_damping: 1e-9,
    most_damping: 1e9,
    least_easing: 0.1,
    scaling: Scaling::Columns,
    model_at_end: false,
};

/// Values that were fitted.
pub struct Fitted {
    pub values: Vec<Values>,
    pub cost: f64,
    pub reason: TerminationReason,
}

/// Minimises from `start` with at most `steps` steps.
pub fn minimise(problem: &Problem, start: &[Values], form: &Form, bounds: TauBounds, steps: usize) -> Fitted {
    let names = problem.names(start, form);
    let mut values = start.to_vec();
    for (v, sticky) in values.iter_mut().zip(&form.sticky) {
        if !sticky {
            v.spike = 0.0;
        }
    }
    if names.is_empty() {
        let cost = problem.cost(&values);
        return Fitted { values, cost, reason: TerminationReason::Converged(Criterion::Cost) };
    }
    let mut projected = Projected { problem, form, bounds, names };
    let found = least_squares::minimise(&mut projected, values, &Options { max_steps: steps, ..SETTINGS });
    Fitted { values: found.point, cost: found.cost, reason: found.reason }
}

/// The fit as a least-squares problem; its Jacobian is known by its products alone, as the nuisances are projected out.
struct Projected<'a> {
    problem: &'a Problem,
    form: &'a Form,
    bounds: TauBounds,
    names: Vec<Name>,
}

impl least_squares::Problem for Projected<'_> {
    type Point = Vec<Values>;
    /// The cost.
    type State = f64;
    type Model = Products;

    fn evaluate(&mut self, values: &Vec<Values>) -> f64 {
        self.problem.cost(values)
    }

    fn cost(&self, _values: &Vec<Values>, cost: &f64) -> f64 {
        *cost
    }

    fn linearise(&mut self, values: &Vec<Values>, _cost: &f64) -> Products {
        let normal = self.problem.normal(values, self.form);
        Products::new(normal.matrix, normal.gradient.iter().map(|g| -g).collect())
    }

    fn moved(&self, values: &Vec<Values>, change: &mut [f64]) -> Vec<Values> {
        let mut out = values.clone();
        for (name, by) in self.names.iter().zip(change) {
            let [lo, hi] = self.range(values, *name);
            let now = value(values, self.form, *name);
            let wanted = match name {
                Name::LnTau { .. } | Name::SharedLnTau => now + by.clamp(-1.0, 1.0),
                _ => now + *by,
            };
            let next = if (lo..=hi).contains(&wanted) { wanted } else { wanted.clamp(lo.min(now), hi.max(now)) };
            if next != now + *by {
                *by = next - now;
            }
            match *name {
                Name::Gap { joint, power } => out[joint].c[power] = next,
                Name::Spike { joint } => out[joint].spike = next,
                Name::LnTau { joint } => out[joint].tau_s = next.exp(),
                Name::SharedLnTau => {
                    for (v, _) in out.iter_mut().zip(&self.form.sticky).filter(|(_, s)| **s) {
                        v.tau_s = next.exp();
                    }
                }
            }
        }
        out
    }

    fn hold(&self, values: &Vec<Values>, gradient: &[f64], held: &mut [bool]) {
        for ((held, g), name) in held.iter_mut().zip(gradient).zip(&self.names) {
            let [lo, hi] = self.range(values, *name);
            let now = value(values, self.form, *name);
            *held = (now <= lo && *g > 0.0) || (now >= hi && *g < 0.0);
        }
    }
}

impl Projected<'_> {
    /// Bounds of a number: a mean gap is not negative, a spike is limited by its gap, a decay by the log.
    fn range(&self, values: &[Values], name: Name) -> [f64; 2] {
        match name {
            Name::Gap { power: 0, .. } => [0.0, f64::INFINITY],
            Name::Gap { .. } => [f64::NEG_INFINITY, f64::INFINITY],
            Name::Spike { joint } => {
                let gap = mean_gap(self.problem, joint, &values[joint]);
                [0.0, SPIKE_OVER_GAP * gap.max(LEAST_FOR_SPIKE)]
            }
            Name::LnTau { .. } | Name::SharedLnTau => [self.bounds.lo_s.ln(), self.bounds.hi_s.ln()],
        }
    }
}

/// A number of the fit; decays as logarithms.
fn value(values: &[Values], form: &Form, name: Name) -> f64 {
    match name {
        Name::Gap { joint, power } => values[joint].c[power],
        Name::Spike { joint } => values[joint].spike,
        Name::LnTau { joint } => values[joint].tau_s.ln(),
        Name::SharedLnTau => values.iter().zip(&form.sticky).find(|(_, s)| **s).map_or(0.0, |(v, _)| v.tau_s.ln()),
    }
}

/// Half gap of a joint in the middle of its travel; of a held one, the mean of nine places.
pub fn mean_gap(problem: &Problem, joint: usize, v: &Values) -> f64 {
    let j = &problem.joints[joint];
    match &j.held {
        None => v.c[0],
        Some(curve) => (-4..=4).map(|k| curve.at(j.center + j.half * f64::from(k) / 4.0)).sum::<f64>() / 9.0,
    }
}

/// Gaps from a linear regression on the direction of each joint.
pub fn start(problem: &Problem, bounds: TauBounds) -> Vec<Values> {
    let blank = Values { c: vec![START_GAP], spike: 0.0, tau_s: (bounds.lo_s * bounds.hi_s).sqrt() };
    let mut values = vec![blank; problem.joints.len()];
    let fitted: Vec<usize> = (0..values.len()).filter(|&g| problem.joints[g].held.is_none()).collect();
    let found = problem.regress_direction(&fitted);
    for (&g, b) in fitted.iter().zip(found) {
        values[g].c[0] = b.max(START_GAP);
    }
    values
}

/// Best spike and decay of joint `g` on a grid, the other joints held.
pub fn grid(problem: &Problem, values: &[Values], g: usize, bounds: TauBounds) -> Values {
    let gap = mean_gap(problem, g, &values[g]).max(START_GAP);
    let (lo, hi) = ((2.0 * bounds.lo_s).max(0.3), bounds.hi_s / 2.0);
    let mut trials = Vec::new();
    for k in 0..7 {
        let tau_s = (lo * (hi / lo).powf(f64::from(k) / 6.0)).clamp(bounds.lo_s, bounds.hi_s);
        trials.extend([0.25, 0.5, 1.0, 2.0].map(|f| Values { spike: f * gap, tau_s, ..values[g].clone() }));
    }
    let costs = problem.cost_of_trials(values, g, &trials);
    let best = costs.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |b| b.0);
    trials.swap_remove(best)
}
