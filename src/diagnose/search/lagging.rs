//! A clock offset and lags of all joints by one time: what the one leaves of the other is no effect.
//!
//! A log of slow motion does not tell them apart to first order; what differs grows with the acceleration. Where the rounds hold a clock
//! offset and the joints lag, that difference is left, and a scale, an oscillation or a curve follows it. Method: the same fit with lags by
//! one time in the place of the offset; where it leaves as little, an effect is believed only if it is also needed beside the lags. Where
//! the lags are decidedly better ([`across::common_lag`]), they take the place of the offset, each joint's of its own size.

use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::search::Search;
use crate::diagnose::search::across::{self, ALL};
use crate::diagnose::search::doubt::BETTER;
use crate::diagnose::search::finding::{Refined, WITHIN};
use crate::diagnose::search::fit::{self, Fit};
use crate::effects::{EffectInstance, Nature, ServoLag, Target, servo_lag};
use crate::machine::parts;

/// Relative steps of the common lag between three fits, from whose costs its best value follows: twice, finer.
const STEPS: [f64; 2] = [0.1, 0.01];
/// The common lag is sought within this factor of the offset.
const APART: f64 = 1.5;

/// The found clock offset that may be lags, and the time, s.
fn clock_behind(fit: &Fit) -> Option<(usize, f64)> {
    fit.free.iter().find_map(|&i| {
        let found = &fit.hypothesis.effects[i];
        let offset_s = parts::clock(std::slice::from_ref(found)).offset_s;
        (found.effect.nature() == Nature::Clock && offset_s < 0.0).then_some((i, -offset_s))
    })
}

/// Lags by one time of all joints that move, beside the effects of a hypothesis: those that a joint has already grow by it. Returns which
/// effects are new.
fn add_lags(problem: &Problem, h: &mut Hypothesis, known: usize, lag_s: f64) -> Vec<usize> {
    let mut new = Vec::new();
    for axis in (0..problem.robot.dof()).filter(|a| problem.logs.iter().any(|l| !l.trajectory.is_stationary(*a))) {
        let target = Target::Joint(axis);
        let own = h.effects.iter_mut().skip(known).find(|e| e.target == target && e.effect.get::<ServoLag>().is_some());
        if let Some(own) = own {
            let own_s = own.effect.get::<ServoLag>().map_or(0.0, |l| l.lag_s);
            *own = EffectInstance::new(target, ServoLag { lag_s: own_s + lag_s });
        } else {
            new.push(h.effects.len());
            h.effects.push(EffectInstance::new(target, ServoLag { lag_s }));
        }
    }
    new
}

impl Search<'_> {
    /// The fit with lags of all joints by one time in the place of a clock offset, where it leaves as little.
    pub(in crate::diagnose) fn lagging(&self, fit: &Fit, whitening: &Whitening) -> Option<Fit> {
        let (gone, offset_s) = clock_behind(fit)?;
        let p = self.problem;
        let at = |lag_s: f64| {
            let mut h = fit.hypothesis.clone();
            h.effects.remove(gone);
            let held = add_lags(p, &mut h, self.known, lag_s);
            let free: Vec<usize> = (self.known..h.effects.len()).filter(|i| !held.contains(i)).collect();
            fit::refit(p, &h, &free, whitening)
        };
        let mut lag_s = offset_s;
        for part in STEPS {
            let step_s = part * lag_s;
            let [below, here, above] = [-step_s, 0.0, step_s].map(|by| at(lag_s + by).cost);
            let bend = below - 2.0 * here + above;
            if bend > 0.0 {
                lag_s = (lag_s + 0.5 * step_s * (below - above) / bend).clamp(offset_s / APART, offset_s * APART);
            }
        }
        let best = at(lag_s);
        (best.cost < fit.cost + WITHIN).then_some(best)
    }

    /// Whether an effect is needed beside lags of all joints, too; `lagging`: the fit with them.
    pub(in crate::diagnose) fn is_beside_lags(&self, lagging: &Fit, refined: &Refined, whitening: &Whitening) -> bool {
        let mut h = lagging.hypothesis.clone();
        let mut free = lagging.free.clone();
        for placed in &refined.placed {
            free.push(h.effects.len());
            h.effects.push(placed.clone());
        }
        let with = fit::refit(self.problem, &h, &free, whitening);
        let gain = lagging.cost - with.cost;
        self.believed(lagging, &Refined { gain, fit: with, ..refined.clone() })
    }

    /// What lags of all joints explain in the place of the found clock offset `own`; with a fit where they are decidedly better.
    pub(in crate::diagnose) fn lags_for_clock(
        &self,
        base: &Fit,
        own: &Refined,
        whitening: &Whitening,
    ) -> Option<Refined> {
        let found = own.placed.first()?;
        let lags = across::common_lag(self.problem, base, whitening, found, own.gain)?;
        if lags.merit(self.price) <= own.merit(self.price) + BETTER {
            return Some(lags);
        }
        let mut h = base.hypothesis.clone();
        add_lags(self.problem, &mut h, self.known, -parts::clock(std::slice::from_ref(found)).offset_s);
        let free: Vec<usize> = (self.known..h.effects.len()).collect();
        let fit = fit::refit(self.problem, &h, &free, whitening);
        if fit.cost >= own.fit.cost {
            // beside all that was found with the offset the lags leave more: it is not decided
            return Some(Refined { gain: lags.gain.min(own.gain + 0.5 * WITHIN), ..lags });
        }
        let is_lag = |e: &&EffectInstance| e.effect.get::<ServoLag>().is_some();
        let placed = fit.hypothesis.effects.iter().skip(self.known).filter(is_lag).cloned().collect();
        Some(Refined { effect: servo_lag::INFO.name, target: ALL.into(), placed, fit, ..lags })
    }
}
