//! Offset and drift of the tracker's clock, with their intervals, from the path that both recordings show.
//!
//! Method: least squares of the measured TCP over
//!
//! ```text
//! y(t) = R (p(q(u)) + F(u) d) + s,   u = t + offset + drift (t - middle)
//! ```
//!
//! with the frame of the tracker (`R`, `s`), the place `d` of the reflector in the flange frame, a zero offset and a half gap of every
//! joint that moves. The last two are there because a gap lags on every path and would else be read as time; it does not grow
//! with speed, as a late clock does. The gap is followed as a play, through the crossing. Reweighted rounds from the start that `search`
//! found, with weak priors (see the constants) where a motion leaves these open. Readings farther out than [`OUTLIER`] robust deviations
//! are left out.
//!
//! Intervals: the sandwich estimate with a Bartlett kernel (Newey and West 1987) over rows, its length by Andrews (1991), as what
//! jitter does to neighbouring rows is alike and grows with speed.
//!
//! Fails: an error where the recordings overlap too little, or do not move.

use super::failure::Failure;
use super::frame::Frame;
use super::placement::{COMMON, NO_GAP, Placement, Row};
use super::play::Play;
use super::search::Seen;
use super::step::{self, Reading, Step};
use super::variance::long_run_variance;
use crate::numerics::least_squares::{Dense, Flow, LinearModel, Reweighted, TerminationReason, ridge_weights, rounds};
use crate::numerics::normal::Z95;
use crate::numerics::qr::Triangle;
use crate::numerics::robust::{MEDIAN_DISTANCE, median_of};
use crate::numerics::series::Series;
use crate::robot::Robot;
use nalgebra::{DMatrix, DVector, Vector3};

/// Rows that are fitted at most; a longer recording is thinned.
const MOST_ROWS: usize = 40_000;
/// Rows needed.
const FEWEST_ROWS: usize = 50;
const ROUNDS: usize = 40;
/// In this many last rounds a step of the offset below this part of half its interval is taken as none.
const WAVERING: usize = 15;
const WAVER: f64 = 0.1;
/// Readings farther out than this many robust standard deviations are outliers.
const OUTLIER: f64 = 6.0;
/// A joint that travels less than this many half gaps does not move after its gap for certain.
const MOVES: f64 = 20.0;
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
    /// A step of a clock, where one explains much of what is left.
    pub step: Option<Step>,
}

impl Fit {
    /// Time of the controller for a time of the tracker, s.
    pub fn controller_s(&self, tracker_s: f64) -> f64 {
        tracker_s + self.offset_s.value + self.drift.value * (tracker_s - self.middle_s)
    }

    /// Adds to the intervals by how much a fit of the same readings with another law of friction differs: which of them the joints
    /// follow, the readings do not tell for certain.
    pub(super) fn widen(&mut self, other: &Self) {
        let at = self.middle_s;
        self.offset_s.half_95 += (other.controller_s(at) - self.controller_s(at)).abs();
        self.drift.half_95 += (other.drift.value - self.drift.value).abs();
    }
}

/// What a fit estimates: the clock first, then the frame and the joints, and what it predicts of a reading.
pub(super) trait Estimated {
    /// A joint after its gap.
    type Play;
    /// Offset, s, drift, and the tracker's time at which the offset holds, s.
    fn clock(&self) -> [f64; 3];
    /// Every joint after its gap, at the present gaps.
    fn plays(&self, commands: &Series) -> Vec<Self::Play>;
    /// A reading and its derivatives; `None` outside the commands, or where it tells nothing.
    fn row(&self, robot: &Robot, commands: &Series, plays: &[Self::Play], t: f64, at: &Vector3<f64>) -> Option<Row>;
    /// Takes a step of all parameters.
    fn moved(&mut self, step: &[f64]);
    /// Deviation of the parameters from their priors, in order, with the inverse variances.
    fn priors(&self) -> Vec<(f64, f64)>;
    /// Share of a step that a round takes.
    fn share(_round: usize) -> f64 {
        1.0
    }
    /// Whether what only a prior tells of a parameter widens the intervals.
    const BY_PRIORS: bool = false;
}

struct State {
    placement: Placement,
    zero: Vec<f64>,
    gap: Vec<f64>,
    travel: Vec<f64>,
}

impl Estimated for State {
    type Play = Play;

    fn clock(&self) -> [f64; 3] {
        self.placement.clock()
    }

    fn plays(&self, commands: &Series) -> Vec<Play> {
        self.gap.iter().enumerate().map(|(axis, gap)| Play::of(commands, axis, gap.max(NO_GAP))).collect()
    }

    fn row(&self, robot: &Robot, commands: &Series, plays: &[Play], t: f64, at: &Vector3<f64>) -> Option<Row> {
        let n = commands.channels();
        let (mut q, mut rate) = (vec![0.0; n], vec![0.0; n]);
        let u = self.placement.controller_s(t);
        if !commands.at(u, &mut q, &mut rate) {
            return None;
        }
        let mut sides = vec![0.0; n];
        for axis in 0..n {
            let (after, side) = plays[axis].at(commands, axis, u)?;
            // where a moving joint stands in its gap is unknown before its first contact
            if side == 0 && self.gap[axis] > NO_GAP && self.travel[axis] > MOVES * self.gap[axis] {
                return None;
            }
            sides[axis] = -f64::from(side);
            let crossing = (after - q[axis]).abs() < self.gap[axis] - NO_GAP;
            let lost = if self.gap[axis] > NO_GAP { after - q[axis] } else { sides[axis] * self.gap[axis] };
            q[axis] += self.zero[axis] + lost;
            if crossing {
                rate[axis] = 0.0;
            }
        }
        let (mut row, levers) = self.placement.row(robot, &q, &rate, t, at);
        row.columns.extend_from_slice(&levers);
        row.columns.extend(levers.iter().zip(&sides).map(|(c, side)| c * *side));
        Some(row)
    }

    fn moved(&mut self, step: &[f64]) {
        let n = self.zero.len();
        self.placement.moved(step);
        for axis in 0..n {
            self.zero[axis] += step[COMMON + axis];
            self.gap[axis] += step[COMMON + n + axis];
        }
    }

    fn priors(&self) -> Vec<(f64, f64)> {
        self.placement.priors((0.0, 0.0), &self.zero, &self.gap)
    }
}

/// Refuses a drift that no two clocks of devices have.
fn plausible_drift(drift: f64) -> Result<(), Failure> {
    if drift.abs() > MOST_DRIFT { Err(Failure::Drift((drift * 1e6).round() as i64)) } else { Ok(()) }
}

/// Fits the clock from a start offset, s.
///
/// `stamps`: variances of offset and drift of the clocks that gave the stamps of both recordings.
pub fn fit(robot: &Robot, commands: &Series, seen: &Seen, start_s: f64, stamps: [f64; 2]) -> Result<Fit, Failure> {
    let n = commands.channels();
    let state = |frame: Frame| State {
        placement: Placement::begin(&frame, start_s),
        zero: vec![0.0; n],
        gap: vec![0.0; n],
        travel: (0..n).map(|axis| commands.travel(axis)).collect(),
    };
    fit_from(state, (robot, commands), seen, start_s, stamps)
}

/// The same of any estimate, which begins at the frame of the tracker.
pub(super) fn fit_from<S: Estimated>(
    state: impl FnOnce(Frame) -> S,
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
    let state = state(Frame::of(robot, commands, seen, &rows, start_s).ok_or(Failure::NoFrame)?);
    let (kept, span_s) = (vec![true; rows.len()], span.end - span.start);
    let mut clock = Clock { robot, commands, seen, stamps, span_s, rows, state, kept, solved: None };
    let reason = rounds(&mut clock, ROUNDS)?;
    let step = step::find(&clock.readings());
    let Clock { state, kept, solved, .. } = clock;
    let solved = match reason {
        TerminationReason::NotFinite => return Err(Failure::Open),
        reason => solved.filter(|_| reason.converged()).ok_or(Failure::NotSettled)?,
    };
    let [offset_s, drift, middle_s] = state.clock();
    // a clock that steps looks like one that drifts
    if step.is_none_or(|s| s.share < step::CERTAIN) {
        plausible_drift(drift)?;
    }
    let half = solved.half_95(stamps);
    Ok(Fit {
        offset_s: Estimate { value: offset_s, half_95: half[0] },
        drift: Estimate { value: drift, half_95: half[1] },
        middle_s,
        rms_m: solved.rms_m,
        rows: solved.used,
        outliers: kept.iter().filter(|k| !**k).count(),
        step,
    })
}

/// The present estimate, and the readings that count.
struct Clock<'a, S> {
    robot: &'a Robot,
    commands: &'a Series,
    seen: &'a Seen<'a>,
    stamps: [f64; 2],
    span_s: f64,
    rows: Vec<usize>,
    state: S,
    kept: Vec<bool>,
    solved: Option<Solved>,
}

/// The linear problem at a state.
struct Solved {
    /// Influence of every row on offset and drift.
    influence: [Vec<f64>; 2],
    /// Variances of offset and drift by what only the priors tell, where that counts.
    by_priors: [f64; 2],
    residual_m: Vec<Option<f64>>,
    rms_m: f64,
    used: usize,
}

impl<S: Estimated> Clock<'_, S> {
    /// All readings at the present state, with the speeds of the commands.
    fn readings(&self) -> Vec<Reading> {
        let plays = self.state.plays(self.commands);
        let [offset_s, drift, middle_s] = self.state.clock();
        let n = self.commands.channels();
        let of = |(&k, &kept): (&usize, &bool)| {
            let t_s = self.seen.t_s[k];
            let (mut q, mut rate) = (vec![0.0; n], vec![0.0; n]);
            self.commands.at(t_s + offset_s + drift * (t_s - middle_s), &mut q, &mut rate);
            let row = self.state.row(self.robot, self.commands, &plays, t_s, &self.seen.at_m[k])?;
            Some(Reading { t_s, row, rate, kept })
        };
        self.rows.iter().zip(&self.kept).filter_map(of).collect()
    }
}

impl<S: Estimated> Reweighted for Clock<'_, S> {
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
            inverse.iter().zip(&priors).filter(|_| S::BY_PRIORS).map(of).sum()
        });
        let residual_m = lines.iter().map(|l| l.as_ref().map(|r| r.residual.norm())).collect();
        self.solved = Some(Solved { influence, by_priors, residual_m, rms_m: variance.sqrt(), used: used.len() });
        Ok(model)
    }

    fn take(&mut self, _model: &Dense, step: &[f64], round: usize) -> Flow {
        let share = S::share(round);
        let step: Vec<f64> = step.iter().map(|v| share * v).collect();
        self.state.moved(&step);
        let Some(solved) = &self.solved else { return Flow::Abandon };
        if round < 3 {
            return Flow::Continue;
        }
        let still = step[0].abs() < STEP_S && step[1].abs() * self.span_s < STEP_S;
        let dropped = drop_outliers(&solved.residual_m, &mut self.kept);
        // sides of a gap that flip to and fro at single rows move the clock by less than it is known
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

/// Marks the readings that are far out; true where that changed something.
fn drop_outliers(residual_m: &[Option<f64>], kept: &mut [bool]) -> bool {
    let mut sizes: Vec<f64> = residual_m.iter().flatten().copied().collect();
    let limit = OUTLIER * median_of(&mut sizes).unwrap_or(f64::INFINITY) / MEDIAN_DISTANCE;
    let mut changed = false;
    for (keep, size) in kept.iter_mut().zip(residual_m) {
        let inside = size.is_none_or(|s| s <= limit * 3f64.sqrt());
        changed |= *keep != inside;
        *keep = inside;
    }
    changed
}

impl Solved {
    fn half_95(&self, stamps: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|p| Z95 * (long_run_variance(&self.influence[p]) + self.by_priors[p] + stamps[p]).sqrt())
    }
}
