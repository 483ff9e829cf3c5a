//! Offset and drift of the tracker's clock, with their intervals, from the path that both recordings show.
//!
//! Method: least squares of the measured TCP over
//!
//! ```text
//! y(t) = R (p(q(u)) + F(u) d) + s,   u = t + offset + drift (t - middle)
//! ```
//!
//! with the frame of the tracker (`R`, `s`), the place `d` of the reflector in the flange frame, a zero offset and a half gap of every
//! joint. The last two are there because a gap lags on every path and would else be read as time; it does not grow
//! with speed, as a late clock does. The gap is followed as a play, through the crossing, from where the joint stands in it at first,
//! which is fitted too: in a test that moves one joint after another, the last one rests for most of the recording. Friction that
//! fades after a reversal is fitted beside the gap: in a test of dwells it has faded while the joint rests and lags while it moves, which
//! would be read as time, and no estimate from residuals could tell. Where gears turn by
//! sums of axes, `robot` and `commands` are those of the gears. Reweighted rounds from the start that `search` found, with weak priors
//! (see [`super::state`]) where a motion leaves these open. Readings farther out than [`OUTLIER`] robust deviations are left out.
//!
//! Intervals: the sandwich estimate with a Bartlett kernel (Newey and West 1987) over rows, its length by Andrews (1991), as what
//! jitter does to neighbouring rows is alike and grows with speed. What only a prior tells of a parameter widens them.
//!
//! Fails: an error where the recordings overlap too little, or do not move.

use super::search::Seen;
use super::state::{Row, State};
use crate::numerics::least_squares::{Dense, Flow, LinearModel, Reweighted, TerminationReason, ridge_weights, rounds};
use crate::numerics::normal::Z95;
use crate::numerics::qr::Triangle;
use crate::numerics::robust::{MEDIAN_DISTANCE, median_of};
use crate::numerics::series::Series;
use crate::robot::Robot;
use nalgebra::{DMatrix, DVector};

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
/// Readings farther out than this many robust standard deviations are outliers.
const OUTLIER: f64 = 6.0;
/// No two clocks of devices drift apart faster than this.
const MOST_DRIFT: f64 = 1000e-6;
/// Step of offset, s, and drift below which the fit stands.
const STEP_S: f64 = 1e-8;
/// Share of what the rows know of a parameter by which a step is held back.
const RIDGE: f64 = 1e-12;
/// Readings that are decomposed together.
const BLOCK: usize = 256;

/// An estimate and half its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Half the width of its 95 % interval.
    pub half_95: f64,
}

/// The tracker's clock against the controller's.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Controller's time minus the tracker's, s, at `middle_s`.
    pub offset_s: Estimate,
    /// Controller's seconds per tracker's second, minus 1.
    pub drift: Estimate,
    /// Tracker's time at which the offset holds, s.
    pub middle_s: f64,
    /// Per coordinate, m.
    pub rms_m: f64,
    /// Number of readings that were used.
    pub rows: usize,
    /// Number of readings that were left out as gross errors.
    pub outliers: usize,
}

impl Failure {
    /// What a motion or a recording must be like instead.
    pub fn expected(self) -> &'static str {
        match self {
            Self::FewReadings(_) | Self::NoFrame | Self::NotSettled => {
                "recordings of one motion that overlap by several seconds"
            }
            Self::Open => "an approximate offset, or a motion that moves every joint faster or longer",
            Self::Drift(_) => {
                "clocks that agree within 1000 ppm, as those of devices do: check the unit of both times, or give an approximate offset"
            }
        }
    }
}

impl Fit {
    /// Time of the controller for a time of the tracker, s.
    pub fn controller_s(&self, tracker_s: f64) -> f64 {
        tracker_s + self.offset_s.value + self.drift.value * (tracker_s - self.middle_s)
    }
}

/// Why there is no fit; the words stand after "found".
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// So few readings lie within the controller's recording.
    #[error("{0} readings of the tracker within the controller's recording")]
    FewReadings(usize),
    /// No rigid transform brings the commanded path to the measured one.
    #[error("a path that does not fit in any frame")]
    NoFrame,
    /// The motion leaves the clock open.
    #[error("a motion that does not determine the clock offset")]
    Open,
    /// Clocks of devices do not drift apart like this, ppm.
    #[error("clocks that drift apart by {0} ppm")]
    Drift(i64),
    /// The rounds were used up.
    #[error("a fit of the clock that does not converge")]
    NotSettled,
}

/// Fits the clock from a start offset, s.
///
/// `stamps`: variances of offset and drift of the clocks that gave the stamps of both recordings.
pub fn fit(robot: &Robot, commands: &Series, seen: &Seen, start_s: f64, stamps: [f64; 2]) -> Result<Fit, Failure> {
    let span = commands.span();
    let lo = seen.t_s.partition_point(|t| t + start_s < span.start);
    let hi = seen.t_s.partition_point(|t| t + start_s <= span.end);
    if hi < lo + FEWEST_ROWS {
        return Err(Failure::FewReadings(hi.saturating_sub(lo)));
    }
    let rows: Vec<usize> = (lo..hi).step_by((hi - lo).div_ceil(MOST_ROWS)).collect();
    let state = State::begin(robot, commands, seen, &rows, start_s).ok_or(Failure::NoFrame)?;
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
    if state.drift.abs() > MOST_DRIFT {
        return Err(Failure::Drift((state.drift * 1e6).round() as i64));
    }
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
        let dropped = solved.drop_outliers(&mut self.kept);
        // what they still move the clock by is less than it is known
        let wavers = || round + WAVERING >= ROUNDS && step[0].abs() < WAVER * solved.half_95(self.stamps)[0];
        if !dropped && (still || wavers()) { Flow::Reached } else { Flow::Continue }
    }
}

/// Linear model of the rows and of the priors: each parameter's deviation from its prior with the inverse variance. Rows are decomposed
/// in blocks in their order.
fn linear_model(used: &[&Row], priors: &[(f64, f64)], variance: f64) -> Option<Dense> {
    let size = priors.len();
    let mut squared_norms: Vec<f64> = priors.iter().map(|(_, precision)| variance * precision).collect();
    let mut blocks = Vec::new();
    for part in used.chunks(BLOCK) {
        let mut a = DMatrix::zeros(3 * part.len(), size);
        for (i, row) in part.iter().enumerate() {
            for (k, column) in row.columns.iter().enumerate() {
                a.fixed_view_mut::<3, 1>(3 * i, k).copy_from(column);
                squared_norms[k] += column.norm_squared();
            }
        }
        let right = part.iter().flat_map(|row| row.residual.iter().copied());
        blocks.push(Triangle::new(a, DVector::from_iterator(3 * part.len(), right)));
    }
    let mut a = DMatrix::zeros(2 * size, size);
    let mut right = DVector::zeros(2 * size);
    for (k, (value, precision)) in priors.iter().enumerate() {
        a[(k, k)] = (variance * precision).sqrt();
        right[k] = -a[(k, k)] * value;
    }
    let norms = squared_norms.iter().map(|v| v.sqrt());
    for (k, weight) in ridge_weights(norms, RIDGE).into_iter().enumerate() {
        a[(size + k, k)] = weight;
    }
    blocks.push(Triangle::new(a, right));
    Dense::of_blocks(blocks)
}

impl Solved {
    /// Marks the readings that are far out; true where that changed something.
    fn drop_outliers(&self, kept: &mut [bool]) -> bool {
        let mut sizes: Vec<f64> = self.residual_m.iter().flatten().copied().collect();
        let limit = OUTLIER * median_of(&mut sizes).unwrap_or(f64::INFINITY) / MEDIAN_DISTANCE;
        let mut changed = false;
        for (keep, size) in kept.iter_mut().zip(&self.residual_m) {
            let inside = size.is_none_or(|s| s <= limit * 3f64.sqrt());
            changed |= *keep != inside;
            *keep = inside;
        }
        changed
    }

    fn half_95(&self, stamps: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|p| Z95 * (long_run_variance(&self.influence[p]) + self.by_priors[p] + stamps[p]).sqrt())
    }
}

/// Variance of a sum of correlated terms: Bartlett kernel, its length by Andrews (1991) for a first-order autoregression.
fn long_run_variance(u: &[f64]) -> f64 {
    let n = u.len();
    let lagged = |l: usize| -> f64 { u.iter().zip(&u[l..]).map(|(a, b)| a * b).sum() };
    let zero = lagged(0).max(f64::MIN_POSITIVE);
    let rho = (lagged(1) / zero).clamp(-0.97, 0.97);
    let alpha = 4.0 * rho * rho / ((1.0 - rho).powi(2) * (1.0 + rho).powi(2));
    let length = (1.1447 * (alpha * n as f64).cbrt()).ceil().max(12.0).min(n as f64 / 4.0) as usize;
    let sum = (1..=length).map(|l| 2.0 * (1.0 - l as f64 / (length + 1) as f64) * lagged(l)).sum::<f64>();
    (zero + sum).max(0.25 * zero)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variance_of_a_sum_of_correlated_terms_is_found() {
        use rand::{Rng, SeedableRng};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        // a moving sum of five: variance of the sum is 25 times that of white terms
        let white: Vec<f64> = (0..40_000).map(|_| rng.random_range(-1.0..1.0)).collect();
        let u: Vec<f64> = white.windows(5).map(|w| w.iter().sum()).collect();
        let want = 25.0 * u.len() as f64 / 3.0;
        let found = long_run_variance(&u);
        assert!((found / want - 1.0).abs() < 0.12, "{found} {want}");
    }
}
