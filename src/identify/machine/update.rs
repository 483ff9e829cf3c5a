//! Learning from a run of the compensated program: the parameters that a compensator holds, corrected by what the run left.
//!
//! The run is fitted with the same laws as an identification, about the values that made the compensator: each may move by a
//! share of its joint's lost motion ([`super::prior::SHARE`]). A joint whose reversals show several times that share is first brought near
//! them as a whole ([`far_off`]). A joint whose correction is not significant, or does not help strokes that did not
//! see it ([`super::crossed`]), keeps its values; of a significant one [`DAMPED`] is applied, so that a run with unusual scatter does not
//! throw the next one off. A joint whose last correction made its reversals worse gets back the values from before
//! ([`super::measured`]).

use super::bins;
use super::carried::refuse_without_offsets;
use super::crossed::crossed;
use super::evidence::{self, Evidence, Reversal};
use super::frame;
use super::law::{FRICTION, JointLaw, OVER, SPIKES, TAUS_S, WINDUPS};
use super::measured;
use super::predict::random_effect;
use super::prior::SHARE;
use super::problem::{Part, Problem};
use super::readings::Readings;
use super::solve::{self, FixedLaws};
use super::spline::Spline;
use crate::compensator::note::Change;
use crate::compensator::response::{MOST_SPIKES, MOST_WINDUPS};
use crate::compensator::{
    BacklashOffset, Compensator, FrictionOffset, FrictionShape, JointCompensator, Note, Response, Spike, Windup,
};
use crate::effects::{GapCurve, curve::Pchip};
use crate::error::{Error, Place, Result};
use crate::gaps::LogRef;
use crate::identify::gears::geared;
use crate::identify::scalar::Setup;
use crate::log::Log;
use crate::numerics::chi_squared;
use crate::robot::Robot;
use nalgebra::DVector;

/// Share of a significant correction that is applied.
const DAMPED: f64 = 0.8;
/// p below which a correction is significant.
const SIGNIFICANT: f64 = 0.05;
/// Fall of the cost on halves that did not see a correction, above which it is applied: more than chance.
const HELPS: f64 = 4.0;
/// Share of its lost motion by which a joint is too far off for corrections about its values (four times their prior), and standard errors
/// beyond which that is no chance.
const FAR: f64 = 4.0 * SHARE;
const BEYOND_DOUBT: f64 = 4.0;
/// Rounds of fitting.
const ROUNDS: usize = 2;
/// Knots of a gap.
const KNOTS: usize = 5;

/// The compensator with what the logs of its own runs teach, and what was done to each joint as notes.
pub fn update(robot: &Robot, logs: &[Log], previous: &Compensator) -> Result<Compensator> {
    refuse_untracked(logs)?;
    let by_gears = geared(robot, logs);
    let (robot, logs) = (by_gears.robot.as_ref(), by_gears.logs.as_ref());
    for log in logs {
        refuse_without_offsets(robot, log, previous)?;
    }
    let all: Vec<&Log> = logs.iter().collect();
    let registered = frame::frame(robot, &all)?;
    let bins_per_s = bins::per_second(&all);
    let splines: Vec<Spline> = (0..robot.dof()).map(|a| Spline::over_travel(logs.iter(), a, KNOTS)).collect();
    let mut binned = Vec::new();
    for log in logs {
        let readings = Readings::of_log(robot, log, &Setup::default(), registered.as_ref())?;
        binned.extend(readings.iter().map(|r| bins::bin(r, robot, &splines, bins_per_s)));
    }
    let mut problem = Problem::new(robot, binned, splines);
    let start: Vec<Option<JointLaw>> = (0..robot.dof())
        .map(|a| problem.laws[a].as_ref().map(|_| law(previous.on(a), &problem.splines[a], problem.sizes[a])))
        .collect();
    stand_at(&mut problem, &start);
    let parts: Vec<Part> = (0..problem.logs.len()).map(|l| problem.part(l)).collect();
    let standing = evidence::standing(&problem, &parts);
    let mut gains: Vec<Option<f64>> = (0..robot.dof()).map(|a| crossed(&problem, &parts, a)).collect();
    let scales: Vec<f64> = (0..robot.dof()).map(|a| far_off(&standing, a)).collect();
    if scales.iter().any(|s| *s != 1.0) {
        let scaled: Vec<Option<JointLaw>> =
            start.iter().zip(&scales).map(|(law, s)| law.as_ref().map(|l| scaled(l, *s))).collect();
        stand_at(&mut problem, &scaled);
        // by single reversals of a run that nothing was fitted to
        gains.iter_mut().zip(&scales).filter(|(_, s)| **s != 1.0).for_each(|(g, _)| *g = Some(f64::INFINITY));
    }
    solve::round(&mut problem, FixedLaws::Nothing);
    let evidence = evidence::evaluate(&problem).ok_or_else(|| {
        let name = logs.first().map_or(String::new(), |l| l.name.clone());
        Error::bad(
            Place::file(name),
            "a run that does not determine the correction",
            "finite measurements of moving joints",
        )
    })?;
    let mut next = previous.clone();
    next.evidence.notes.clear();
    for log in logs {
        next.evidence.logs.push(LogRef { name: log.name.clone(), sha256: log.sha256.clone() });
    }
    for (axis, before) in start.iter().enumerate() {
        let Some(before) = before else { continue };
        let run = measured::of_joint(&standing, axis);
        if measured::restored(robot, axis, run, &mut next) {
            continue;
        }
        let left_m2 = left_m2(&standing, axis);
        let changed = corrected(&problem, &evidence, axis, (gains[axis], left_m2), before, &mut next);
        measured::kept_in_mind(axis, run, changed.then(|| previous.on(axis)), &mut next);
    }
    Ok(next)
}

/// Refuses runs that no tracker has measured.
fn refuse_untracked(logs: &[Log]) -> Result<()> {
    let tracked = |l: &&Log| l.instruments.scalar().is_none() && !l.tcp_m.is_empty();
    let Some(log) = logs.iter().find(|l| !tracked(l)) else { return Ok(()) };
    let single = log.instruments.scalar().is_some();
    let found = if single { "readings of a ballbar or a dial" } else { "no columns `x_mm,y_mm,z_mm`" };
    Err(Error::bad(Place::file(&log.name), found, "a run measured with a tracker (`x_mm,y_mm,z_mm`)"))
}

/// Puts the laws of the joints to known values, about which corrections are estimated, and fits the rest.
fn stand_at(problem: &mut Problem, laws: &[Option<JointLaw>]) {
    problem.laws = laws.to_vec();
    problem.centre = Some(laws.iter().flatten().flat_map(JointLaw::to_vec).collect());
    for _ in 0..ROUNDS {
        solve::round(problem, FixedLaws::Laws);
        solve::refresh_unused(problem);
        solve::refresh_noise(problem);
    }
    solve::round(problem, FixedLaws::Laws);
}

/// The lost motion of a run as a multiple of the compensator's, where it is so far from it, beyond doubt, that small corrections about the
/// compensator's values do not reach it; else 1.
fn far_off(standing: &[Reversal], axis: usize) -> f64 {
    let own: Vec<&Reversal> = standing.iter().filter(|r| r.axis == axis).collect();
    let ratio = random_effect(&own);
    let off = (ratio.mean - 1.0).abs();
    if ratio.mean > 0.0 && off > FAR && off > BEYOND_DOUBT * ratio.sigma { ratio.mean } else { 1.0 }
}

/// A law with all of its lost motion times `by`.
fn scaled(law: &JointLaw, by: f64) -> JointLaw {
    JointLaw {
        gap: law.gap.iter().map(|g| g * by).collect(),
        spikes: law.spikes.map(|s| s * by),
        windups: law.windups.map(|w| w * by),
        presliding: law.presliding,
    }
}

/// Mean square error after the reversals of a joint that the offsets of the run leave, m^2.
fn left_m2(standing: &[Reversal], axis: usize) -> f64 {
    let own = standing.iter().filter(|r| r.axis == axis);
    let n = own.clone().count().max(1) as f64;
    (own.map(|r| r.left_m2).sum::<f64>() / n).max(0.0)
}

/// Puts the correction of a joint into the compensator; `false`: it keeps its values.
fn corrected(
    problem: &Problem,
    evidence: &Evidence,
    axis: usize,
    (gain, left_m2): (Option<f64>, f64),
    before: &JointLaw,
    next: &mut Compensator,
) -> bool {
    let Some(after) = &problem.laws[axis] else { return false };
    let joint = problem.robot.axis(axis);
    let p = probability(problem, evidence, axis, before, after);
    let note = |change| Note::Run { joint: joint.name.clone(), change };
    let kept = match gain {
        _ if p >= SIGNIFICANT => Some(Change::NotSignificant { p_value: p }),
        None => Some(Change::TooFewStrokes),
        Some(gain) if gain <= HELPS => Some(Change::DoesNotHelp { gain }),
        Some(_) => None,
    };
    if let Some(change) = kept {
        next.evidence.notes.push(note(change));
        return false;
    }
    let (a, b) = (DVector::from_vec(before.to_vec()), DVector::from_vec(after.to_vec()));
    let law = JointLaw::from_slice((&a + (b - &a) * DAMPED).as_slice());
    let own = next.joints.iter().find(|j| j.axis == axis);
    let curve = curve(own, &problem.splines[axis], before, &law);
    let largest = law
        .gap
        .iter()
        .zip(&before.gap)
        .map(|(a, b)| a - b)
        .fold(0.0, |m: f64, v| if v.abs() > m.abs() { v } else { m });
    next.evidence.notes.push(note(Change::Corrected {
        kind: joint.kind,
        half_gap: largest,
        spikes: law.spikes.iter().sum::<f64>() - before.spikes.iter().sum::<f64>(),
        windup: law.windup() - before.windup(),
        p_value: p,
        left_m: left_m2.sqrt(),
    }));
    next.joints.retain(|j| j.axis != axis);
    next.joints.push(compensator_of(axis, &law, curve));
    next.joints.sort_by_key(|j| j.axis);
    true
}

/// The offsets that undo a law.
fn compensator_of(axis: usize, law: &JointLaw, curve: GapCurve) -> JointCompensator {
    let mut spikes = [Spike { gain: 0.0, decay_s: 1.0 }; MOST_SPIKES];
    for (s, (gain, tau)) in spikes.iter_mut().zip(law.spikes.iter().zip(TAUS_S)) {
        *s = Spike { gain: *gain, decay_s: tau };
    }
    let mut windups = [Windup { half: 0.0, presliding: law.presliding }; MOST_WINDUPS];
    for (w, (half, over)) in windups.iter_mut().zip(law.windups.iter().zip(OVER)) {
        *w = Windup { half: *half, presliding: law.presliding * over };
    }
    let friction = FrictionOffset::of_response(Response { presliding: law.presliding, windups, spikes });
    JointCompensator {
        axis,
        backlash: Some(BacklashOffset::symmetric(curve)),
        friction: friction.acts().then_some(friction),
    }
}

/// p value of the test that nothing is to be corrected.
///
/// The prior draws corrections towards zero, most where the run knows least. With `C` the covariance of a correction `s` and `P` the
/// precision of its prior, `s' C^-1 s` is then a sum of squares with weights `1 - eig(C P)`, which a scaled chi-squared
/// distribution of the same mean and variance stands for (Satterthwaite 1946).
fn probability(problem: &Problem, evidence: &Evidence, axis: usize, before: &JointLaw, after: &JointLaw) -> f64 {
    let (at, n) = (problem.offset(axis), before.parameters());
    let step = DVector::from_vec(after.to_vec()) - DVector::from_vec(before.to_vec());
    let covariance = evidence.within.view((at, at), (n, n)).into_owned();
    let shrunk = &covariance * problem.prior().0.view((at, at), (n, n));
    let Some(factor) = nalgebra::Cholesky::new(covariance) else { return 1.0 };
    let squares = step.dot(&factor.solve(&step));
    let weights = n as f64 - shrunk.trace();
    let weights2 = n as f64 - 2.0 * shrunk.trace() + (&shrunk * &shrunk).trace();
    if weights <= 0.0 || weights2 <= 0.0 {
        return 1.0;
    }
    let (scale, dof) = (weights2 / weights, weights * weights / weights2);
    chi_squared::tail(squares / scale, dof)
}

/// The schedule moved by the correction; beyond the run's own range by that of its end.
fn curve(own: Option<&JointCompensator>, spline: &Spline, before: &JointLaw, after: &JointLaw) -> GapCurve {
    let change: Vec<f64> = after.gap.iter().zip(&before.gap).map(|(a, b)| a - b).collect();
    let base = own.and_then(|j| j.backlash.as_ref()).map_or(GapCurve::Constant(0.0), |b| b.positive.clone());
    let (lo, hi) = (spline.knot(0), spline.knot(spline.knots() - 1));
    let mut places: Vec<f64> =
        (0..=4 * (KNOTS - 1)).map(|i| lo + (hi - lo) * i as f64 / (4 * (KNOTS - 1)) as f64).collect();
    if let GapCurve::Pchip(p) = &base {
        places.extend(p.knots().iter().map(|k| k[0]).filter(|x| *x < lo || *x > hi));
        places.sort_by(f64::total_cmp);
    }
    places.dedup_by(|b, a| *b - *a < 1e-9);
    let knots: Vec<[f64; 2]> = places.iter().map(|&x| [x, (base.at(x) + spline.at(x, &change)).max(0.0)]).collect();
    Pchip::new(&knots).map_or(base, GapCurve::Pchip)
}

/// The law that a joint's offsets stand for; a joint without any has none.
fn law(own: Option<&JointCompensator>, spline: &Spline, size: f64) -> JointLaw {
    let mut law =
        JointLaw { gap: vec![0.0; spline.knots()], spikes: [0.0; SPIKES], windups: [0.0; WINDUPS], presliding: size };
    let Some(own) = own else { return law };
    if let Some(b) = &own.backlash {
        for (k, g) in law.gap.iter_mut().enumerate() {
            *g = b.positive.at(spline.knot(k));
        }
    }
    match own.friction.map(|f| (f.gain, f.shape)) {
        Some((_, FrictionShape::Response(r))) => {
            law.presliding = r.presliding;
            for s in &r.spikes {
                let near = (0..SPIKES).min_by(|a, b| far(TAUS_S[*a], s.decay_s).total_cmp(&far(TAUS_S[*b], s.decay_s)));
                law.spikes[near.unwrap_or(0)] += s.gain;
            }
            for w in &r.windups {
                let over = w.presliding / r.presliding;
                let near = (0..WINDUPS).min_by(|a, b| far(OVER[*a], over).total_cmp(&far(OVER[*b], over)));
                law.windups[near.unwrap_or(0)] += w.half;
            }
        }
        Some((gain, FrictionShape::Decay(crate::effects::Decay::Time(tau)))) => {
            let near = (0..SPIKES).min_by(|a, b| far(TAUS_S[*a], tau).total_cmp(&far(TAUS_S[*b], tau)));
            law.spikes[near.unwrap_or(0)] = gain / 2.0;
        }
        _ => {}
    }
    debug_assert_eq!(law.parameters(), law.gap.len() + FRICTION);
    law
}

/// Distance of two positive numbers by ratio.
fn far(a: f64, b: f64) -> f64 {
    (a / b.max(f64::MIN_POSITIVE)).ln().abs()
}
