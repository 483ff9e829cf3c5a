//! Which effects the data ask for: stiction joint by joint, gaps that vary, errors of the links, one decay for all.
//!
//! 1. With the errors of the links as nuisances: gaps alone, then each joint's stiction from a grid, then all together.
//! 2. A gap that varies with position (linear, quadratic) where `F >= ENTER`, beside a stiction, so that neither takes the
//!    other's place.
//! 3. Backward elimination: the stiction with the smallest F goes, the others are refitted, until all have `F >= ENTER` and a spike
//!    of more than a tenth of the gap.
//! 4. The errors of the links are dropped where the data show no sign of them (`p > LINKS_P`): they cost a third of the
//!    precision. Steps 1 to 3 again without them.
//!    The same of lags, unless without them the log would claim to know a gap better than it tells it from a lag.
//! 5. One decay for all joints with stiction unless the data refuse it (`p < SHARE_P`).
//!
//! Every F is divided by the inflation for correlated residuals ([`super::interval::inflation`]).

use super::interval::{Covariance, inflation};
use super::nuisance::With;
use super::problem::{Form, Name, Problem, Values};
use super::solve::{TauBounds, grid, mean_gap, minimise, start};
use crate::numerics::fisher::tail as f_tail;
use crate::numerics::least_squares::TerminationReason;

/// F from which an effect is believed: p of 5e-4 for one number, 6e-6 for two.
const ENTER: f64 = 12.0;
/// p of one decay for all below which the joints keep their own.
const SHARE_P: f64 = 1e-3;
/// p above which the errors of the links are not needed.
const LINKS_P: f64 = 0.05;
/// The same of lags: higher, as a lag of one joint alone hides among those of all, and lags that are not there cost little.
const LAGS_P: f64 = 0.1;
/// Lags are kept whatever the test says where they make the standard error of a gap this many times as large: a lag that the log hardly
/// tells from a gap passes the test unseen.
const LAGS_COST: f64 = 1.25;
/// Spike over gap below which a stiction is not distinguished from the gap's shape.
const LEAST_SPIKE: f64 = 0.1;
const STEPS: usize = 40;
/// Steps of the last fit, whose intervals are printed.
const LAST_STEPS: usize = 400;

/// The selected fit.
pub struct Selected {
    pub values: Vec<Values>,
    pub form: Form,
    pub cost: f64,
    /// Why the last fit stopped: intervals mean nothing where it did not converge.
    pub reason: TerminationReason,
    /// Degrees of freedom, inflation of the variance.
    pub dof: f64,
    pub inflation: f64,
    /// Per joint: F and p of its stiction where it was looked for.
    pub stiction_f: Vec<Option<f64>>,
    pub stiction_p: Vec<Option<f64>>,
    /// Per joint: p of a constant gap against the best varying one.
    pub varies_p: Vec<Option<f64>>,
    /// Per joint: how many times as large a lag that is not known makes the standard error of its gap.
    pub widened: Vec<f64>,
}

struct State {
    values: Vec<Values>,
    form: Form,
    cost: f64,
    reason: TerminationReason,
}

fn dof(problem: &Problem, s: &State) -> f64 {
    (problem.measured() as f64 - problem.rank() as f64 - problem.names(&s.values, &s.form).len() as f64).max(1.0)
}

fn refit(problem: &Problem, values: &[Values], form: &Form, bounds: TauBounds) -> State {
    let found = minimise(problem, values, form, bounds, STEPS);
    State { values: found.values, form: form.clone(), cost: found.cost, reason: found.reason }
}

/// Runs the whole selection.
pub fn select(problem: &mut Problem) -> Selected {
    let joints = problem.joints.len();
    let bounds = TauBounds::of(problem);
    let mut stiction_f = vec![None; joints];
    let mut varies_p = vec![None; joints];
    let guess = vec![Values { c: vec![0.0], spike: 0.0, tau_s: bounds.lo_s }; joints];
    problem.with = With { links: true, lags: true, corners: false };
    problem.set_up(&guess);
    let mut now = everything(problem, start(problem, bounds), bounds);
    vary(problem, &mut now, bounds, &mut varies_p);
    eliminate(problem, &mut now, bounds, &mut stiction_f);
    let links = without(problem, &now, bounds, With { links: false, ..problem.with }).is_none_or(|p| p <= LINKS_P);
    let lags = without(problem, &now, bounds, With { lags: false, ..problem.with }).is_none_or(|p| p <= LAGS_P)
        || widened(problem, &now, links).iter().any(|w| *w > LAGS_COST);
    let needed = With { links, lags, corners: !lags };
    if needed != problem.with {
        problem.with = needed;
        problem.set_up(&now.values);
        let gaps: Vec<Values> = now.values.iter().map(|v| Values { c: vec![v.c[0]], ..v.clone() }).collect();
        now = everything(problem, gaps, bounds);
        varies_p = vec![None; joints];
        vary(problem, &mut now, bounds, &mut varies_p);
        eliminate(problem, &mut now, bounds, &mut stiction_f);
    }
    share(problem, &mut now, bounds);
    // last pass on the bins that the final values leave
    problem.move_frames(&now.values);
    problem.set_up(&now.values);
    let found = minimise(problem, &now.values, &now.form, bounds, LAST_STEPS);
    let now = State { values: found.values, form: now.form, cost: found.cost, reason: found.reason };
    let widened = if problem.with.lags { widened(problem, &now, problem.with.links) } else { vec![1.0; joints] };
    let d = dof(problem, &now);
    let stiction_p = stiction_f.iter().map(|f: &Option<f64>| f.map(|f| f_tail(f, 2.0, d))).collect();
    Selected {
        cost: now.cost,
        reason: now.reason,
        dof: d,
        inflation: inflation(problem, &now.values),
        stiction_f,
        stiction_p,
        varies_p,
        widened,
        values: now.values,
        form: now.form,
    }
}

/// Gaps, then a stiction on every joint, frames moved until they stay.
fn everything(problem: &mut Problem, values: Vec<Values>, bounds: TauBounds) -> State {
    let joints = problem.joints.len();
    let mut form = Form { sticky: vec![false; joints], shared: false };
    let mut s = refit(problem, &values, &form, bounds);
    for pass in 0..4 {
        if pass == 0 {
            for g in 0..joints {
                s.values[g] = grid(problem, &s.values, g, bounds);
                form.sticky[g] = true;
                let found = minimise(problem, &s.values, &form, bounds, 15);
                s = State { values: found.values, form: form.clone(), cost: found.cost, reason: found.reason };
            }
        } else {
            s = refit(problem, &s.values, &form, bounds);
        }
        let turned = problem.move_frames(&s.values);
        problem.set_up(&s.values);
        if pass > 0 && turned < 1e-7 {
            break;
        }
    }
    refit(problem, &s.values, &form, bounds)
}

/// Lets gaps vary with position where that pays.
fn vary(problem: &mut Problem, now: &mut State, bounds: TauBounds, p: &mut [Option<f64>]) {
    let spread = inflation(problem, &now.values);
    for g in 0..problem.joints.len() {
        if problem.joints[g].held.is_some() {
            continue;
        }
        let mut best: Option<State> = None;
        for more in 1..=2usize {
            let mut values = now.values.clone();
            values[g].c.resize(1 + more, 0.0);
            let trial = refit(problem, &values, &now.form, bounds);
            let base = best.as_ref().unwrap_or(now);
            let extra = (trial.values[g].c.len() - base.values[g].c.len()) as f64;
            let d = dof(problem, &trial);
            let f = ((base.cost - trial.cost) / extra / (trial.cost / d) / spread).max(0.0);
            let tail = f_tail(f, extra, d);
            p[g] = Some(p[g].map_or(tail, |q: f64| q.min(tail)));
            let law = problem.law(g, &trial.values[g]);
            let j = &problem.joints[g];
            let positive = (0..=40).all(|k| law.gap.at(j.center + j.half * (f64::from(k) / 20.0 - 1.0)) >= 0.0);
            if f >= ENTER && positive {
                best = Some(trial);
            }
        }
        if let Some(b) = best {
            *now = b;
        }
    }
}

/// Backward elimination of stictions.
fn eliminate(problem: &mut Problem, now: &mut State, bounds: TauBounds, f: &mut [Option<f64>]) {
    loop {
        let d = dof(problem, now);
        let spread = inflation(problem, &now.values);
        let mut weakest: Option<(f64, State)> = None;
        for g in (0..problem.joints.len()).filter(|&g| now.form.sticky[g]) {
            let mut form = now.form.clone();
            form.sticky[g] = false;
            let without = refit(problem, &now.values, &form, bounds);
            let value = ((without.cost - now.cost) / 2.0 / (now.cost / d) / spread).max(0.0);
            f[g] = Some(value);
            let small = now.values[g].spike <= LEAST_SPIKE * mean_gap(problem, g, &now.values[g]);
            let rank = if small { value.min(ENTER * 0.999) } else { value };
            if weakest.as_ref().is_none_or(|(w, _)| rank < *w) {
                weakest = Some((rank, without));
            }
        }
        match weakest {
            Some((value, without)) if value < ENTER => {
                *now = without;
                problem.set_up(&now.values);
                *now = refit(problem, &now.values, &now.form, bounds);
            }
            _ => return,
        }
    }
}

/// p of the data with these nuisances alone: without errors of the links, or without lags.
fn without(problem: &mut Problem, now: &State, bounds: TauBounds, with: With) -> Option<f64> {
    let (rank, d, all) = (problem.rank(), dof(problem, now), problem.with);
    let spread = inflation(problem, &now.values);
    problem.with = with;
    problem.set_up(&now.values);
    let extra = rank.saturating_sub(problem.rank()) as f64;
    let without = refit(problem, &now.values, &now.form, bounds);
    problem.with = all;
    problem.set_up(&now.values);
    if extra == 0.0 {
        return None;
    }
    let f = ((without.cost - now.cost) / extra / (now.cost / d) / spread).max(0.0);
    Some(f_tail(f, extra, d))
}

/// How many times as large lags that are not known make the standard error of each gap, with errors of the links or without.
fn widened(problem: &mut Problem, now: &State, links: bool) -> Vec<f64> {
    let all = problem.with;
    let mut sigmas = |lags: bool| -> Vec<f64> {
        problem.with = With { links, lags, ..all };
        problem.set_up(&now.values);
        let cov = Covariance::new(problem, &now.values, &now.form, 1.0);
        let gap = |joint: usize| cov.place(Name::Gap { joint, power: 0 }).map_or(0.0, |k| cov.sigma(&[(k, 1.0)]));
        (0..problem.joints.len()).map(gap).collect()
    };
    let (with, alone) = (sigmas(true), sigmas(false));
    problem.with = all;
    problem.set_up(&now.values);
    with.iter().zip(alone).map(|(with, alone)| if alone > 0.0 { with / alone } else { 1.0 }).collect()
}

/// One decay for all unless refused.
fn share(problem: &Problem, now: &mut State, bounds: TauBounds) {
    let sticky: Vec<usize> = (0..problem.joints.len()).filter(|&g| now.form.sticky[g]).collect();
    if sticky.len() < 2 {
        return;
    }
    let surest = sticky.iter().copied().max_by(|&a, &b| {
        let size = |g: usize| now.values[g].spike / mean_gap(problem, g, &now.values[g]).max(1e-12);
        size(a).total_cmp(&size(b))
    });
    let Some(surest) = surest else { return };
    let mut values = now.values.clone();
    for &g in &sticky {
        values[g].tau_s = now.values[surest].tau_s;
    }
    let form = Form { shared: true, ..now.form.clone() };
    let trial = refit(problem, &values, &form, bounds);
    let d = dof(problem, now);
    let spread = inflation(problem, &now.values);
    let f = ((trial.cost - now.cost) / (sticky.len() - 1) as f64 / (now.cost / d) / spread).max(0.0);
    if f_tail(f, (sticky.len() - 1) as f64, d) >= SHARE_P {
        *now = trial;
    }
}
