//! The clock from tests of dwells, and from motions that move one joint after another: what `plan-experiment static` records.
//!
//! Method: as [`super::fit`], with what such a test shows and a motion of all joints does not. A joint that waits for its turn stands
//! somewhere in its gap, which is fitted: left out, it would take the readings of all others along. Friction that fades after a
//! reversal has faded while a joint rests and lags while it moves, which would be read as time: it is fitted beside the gap, at three paces.
//! The drift has a prior. Later rounds take less of a step, because sides of a gap flip at single rows.
//!
//! Intervals: those of [`super::fit`], and what only a prior tells of a parameter widens them.
//!
//! Ordinary recordings, in which all joints move, are not fitted so: friction and late samples look alike there, and intervals held 13 of 20
//! offsets. How far a fit with another law of friction is from the one that is used widens its interval: of a test, one without friction; of an
//! ordinary recording, this one.
//!
//! Fails: as [`super::fit`].

mod play;
mod state;

use super::failure::Failure;
use super::fit::{Estimate, Fit, Row, drop_outliers, linear_model, long_run_variance, plausible_drift};
use super::search::Seen;
use crate::numerics::least_squares::{Dense, Flow, LinearModel, Reweighted, TerminationReason, rounds};
use crate::numerics::normal::Z95;
use crate::numerics::series::Series;
use crate::robot::Robot;
use state::{FRICTION, NO_FRICTION, State};

/// Rows that are fitted at most; a longer recording is thinned.
const MOST_ROWS: usize = 40_000;
/// Rows needed.
const FEWEST_ROWS: usize = 50;
const ROUNDS: usize = 40;
/// Rounds after which steps are taken in part.
const STEADY: usize = 10;
/// In this many last rounds a step of the offset below this part of half its interval is taken as none.
const WAVERING: usize = 15;
const WAVER: f64 = 0.1;
/// The path fits at the start; a fit that ends this far from it, s, has lost it.
const ASTRAY_S: f64 = 1.0;
/// Step of offset, s, and drift below which the fit stands.
const STEP_S: f64 = 1e-8;
/// Movement of a joint between two samples up to which it stands, rad or m.
const STANDS: f64 = 1e-7;
/// Joints that move at a time in a test of one after another, at most, and share of the time in which nothing moves in a test of dwells.
const AT_A_TIME: f64 = 1.5;
const RESTING: f64 = 0.2;

/// Whether joints move one after another, or rest for much of the time.
pub fn is_test(commands: &Series) -> bool {
    let n = commands.times().len().saturating_sub(1);
    let moves =
        |axis: usize, k: usize| (commands.within(axis, k, 1.0).0 - commands.within(axis, k, 0.0).0).abs() > STANDS;
    let (mut moving, mut joints) = (0usize, 0usize);
    for k in 0..n {
        let count = (0..commands.channels()).filter(|a| moves(*a, k)).count();
        moving += usize::from(count > 0);
        joints += count;
    }
    let resting = (n - moving) as f64 > RESTING * n as f64;
    moving > 0 && (resting || (joints as f64) < AT_A_TIME * moving as f64)
}

/// Fits the clock from a start offset, s.
///
/// `stamps`: variances of offset and drift of the clocks that gave the stamps of both recordings.
pub fn fit(robot: &Robot, commands: &Series, seen: &Seen, start_s: f64, stamps: [f64; 2]) -> Result<Fit, Failure> {
    fit_with(FRICTION, (robot, commands), seen, start_s, stamps)
}

/// The same without friction: by how much the other is off where joints have another law of it, or none.
pub fn without_friction(
    robot: &Robot,
    commands: &Series,
    seen: &Seen,
    start_s: f64,
    stamps: [f64; 2],
) -> Result<Fit, Failure> {
    fit_with(NO_FRICTION, (robot, commands), seen, start_s, stamps)
}

/// `friction`: standard deviation of its prior, rad or m.
fn fit_with(
    friction: f64,
    (robot, commands): (&Robot, &Series),
    seen: &Seen,
    start_s: f64,
    stamps: [f64; 2],
) -> Result<Fit, Failure> {
    let span = commands.span();
    let lo = seen.t_s.partition_point(|t| t + start_s < span.start);
    let hi = seen.t_s.partition_point(|t| t + start_s <= span.end);
    if hi < lo + FEWEST_ROWS {
        return Err(Failure::FewReadings(hi.saturating_sub(lo)));
    }
    let rows: Vec<usize> = (lo..hi).step_by((hi - lo).div_ceil(MOST_ROWS)).collect();
    let state = State::begin(robot, commands, seen, &rows, (start_s, friction)).ok_or(Failure::NoFrame)?;
    let (kept, span_s) = (vec![true; rows.len()], span.end - span.start);
    let mut clock = Clock { robot, commands, seen, stamps, span_s, rows, state, kept, solved: None };
    let reason = rounds(&mut clock, ROUNDS)?;
    let Clock { state, kept, solved, .. } = clock;
    let solved = match reason {
        TerminationReason::NotFinite => return Err(Failure::Open),
        reason => solved.filter(|_| reason.converged()).ok_or(Failure::NotSettled)?,
    };
    if (state.offset_s - start_s).abs() > ASTRAY_S {
        return Err(Failure::Open);
    }
    plausible_drift(state.drift)?;
    let [offset, drift] = solved.half_95(stamps);
    Ok(Fit {
        offset_s: Estimate { value: state.offset_s, half_95: offset },
        drift: Estimate { value: state.drift, half_95: drift },
        middle_s: state.middle_s,
        rms_m: solved.rms_m,
        rows: solved.used,
        outliers: kept.iter().filter(|k| !**k).count(),
    })
}

/// The present estimate, and the readings that count.
struct Clock<'a> {
    robot: &'a Robot,
    commands: &'a Series,
    seen: &'a Seen<'a>,
    stamps: [f64; 2],
    span_s: f64,
    rows: Vec<usize>,
    state: State,
    kept: Vec<bool>,
    solved: Option<Solved>,
}

/// The linear problem at a state.
struct Solved {
    /// Influence of every row on offset and drift.
    influence: [Vec<f64>; 2],
    /// Variances of offset and drift by what only the priors tell.
    by_priors: [f64; 2],
    residual_m: Vec<Option<f64>>,
    rms_m: f64,
    used: usize,
}

impl Reweighted for Clock<'_> {
    type Model = Dense;
    type Failure = Failure;

    fn linearise(&mut self) -> Result<Dense, Failure> {
        let Self { robot, commands, seen, state, .. } = self;
        let plays = state.plays(commands);
        let lines: Vec<Option<Row>> =
            self.rows.iter().map(|&k| state.row(robot, commands, &plays, seen.t_s[k], &seen.at_m[k])).collect();
        let used: Vec<&Row> =
            lines.iter().zip(&self.kept).filter_map(|(l, keep)| l.as_ref().filter(|_| *keep)).collect();
        if used.len() < FEWEST_ROWS {
            return Err(Failure::FewReadings(used.len()));
        }
        let squares: f64 = used.iter().map(|row| row.residual.norm_squared()).sum();
        let variance = squares / (3 * used.len()) as f64;
        let priors = state.priors();
        let model = linear_model(&used, &priors, variance).ok_or(Failure::Open)?;
        let information = model.information();
        if !information.is_full() {
            return Err(Failure::Open);
        }
        let influence = [0, 1].map(|p| {
            let inverse = information.inverse.row(p);
            let of = |row: &&Row| -> f64 {
                inverse.iter().zip(&row.columns).map(|(inverse, column)| inverse * column.dot(&row.residual)).sum()
            };
            used.iter().map(of).collect()
        });
        let by_priors = [0, 1].map(|p| {
            let inverse = information.inverse.row(p);
            let of = |(v, (_, precision)): (&f64, &(f64, f64))| (v * variance).powi(2) * precision;
            inverse.iter().zip(&priors).map(of).sum()
        });
        let residual_m = lines.iter().map(|l| l.as_ref().map(|r| r.residual.norm())).collect();
        self.solved = Some(Solved { influence, by_priors, residual_m, rms_m: variance.sqrt(), used: used.len() });
        Ok(model)
    }

    fn take(&mut self, _model: &Dense, step: &[f64], round: usize) -> Flow {
        // sides of a gap that flip at single rows throw the estimate to and fro: later rounds take less of a step
        let share = (STEADY as f64 / round.max(STEADY) as f64).powi(2);
        let step: Vec<f64> = step.iter().map(|v| share * v).collect();
        self.state.moved(&step);
        let Some(solved) = &self.solved else { return Flow::Abandon };
        if round < 3 {
            return Flow::Continue;
        }
        let still = step[0].abs() < STEP_S && step[1].abs() * self.span_s < STEP_S;
        let dropped = drop_outliers(&solved.residual_m, &mut self.kept);
        // what they still move the clock by is less than it is known
        let wavers = || round + WAVERING >= ROUNDS && step[0].abs() < WAVER * solved.half_95(self.stamps)[0];
        if !dropped && (still || wavers()) { Flow::Reached } else { Flow::Continue }
    }
}

impl Solved {
    fn half_95(&self, stamps: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|p| Z95 * (long_run_variance(&self.influence[p]) + self.by_priors[p] + stamps[p]).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_of_dwells_or_of_one_joint_after_another_is_told_from_a_motion_of_all() {
        let t: Vec<f64> = (0..400).map(f64::from).collect();
        let of = |value: &dyn Fn(usize, f64) -> f64| {
            let values = (0..3).map(|a| t.iter().map(|t| value(a, *t)).collect()).collect();
            is_test(&Series::new(t.clone(), values, &[1e-7; 3]))
        };
        assert!(!of(&|a, t| (0.03 * (a as f64 + 1.0) * t).sin()));
        assert!(of(&|a, t| if (t / 100.0) as usize == a { (0.06 * t).sin() } else { 0.0 }), "one after another");
        assert!(of(&|_, t| ((t / 20.0).floor() + (t / 20.0).fract().min(0.5)) * 0.1), "dwells of all joints");
    }
}
