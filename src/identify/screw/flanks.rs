//! One gap between two sensors: the two flanks of its play, from the rows at which the parts are surely in touch.
//!
//! Gantry (2015) equation 2: `y = m (u - c_r)` moving up, `y = m (u - c_l)` moving down. Both lines are fitted together by least squares
//! with one slope, over rows whose stroke has gone farther than the lost motion before the output ([`mod@super::reach`]);
//! what happens inside the gap is not used, so that noise of the input, which a play operator would rectify, does no harm.
//! With a lag `tau` between the columns (a servo, another clock) the input is `u - tau du/dt`: another column, where the log can
//! tell it from a gap. Rows after a change of speed are left out then: there a lag is no shift yet.
//!
//! Intervals: the delete-one jackknife over strokes, each direction a stratum (Efron 1982), with Student's t. It
//! assumes nothing about the noise within a stroke: vibration and drift are alike to it. Where fewer than [`FEW_STROKES`] strokes of a
//! direction are there, strokes are cut into pieces; the interval then does not include repeatability, and a note reports it.
//!
//! Gross errors: rows farther from the lines than [`GROSS`] times the robust standard deviation are left out, and counted.

use super::strokes::Strokes;
pub use crate::gaps::note::screw::Missing;
use crate::numerics::normal_equations::scaled_inverse;
use crate::numerics::robust::{SIGMA_PER_MAD, median};
use crate::numerics::student;
use nalgebra::{DMatrix, Matrix4, Vector4};

/// Strokes of each direction from which on they are the repeats.
pub const FEW_STROKES: usize = 3;
/// Pieces per direction where strokes are few.
const PIECES: usize = 8;
/// Rows of a stroke, or of a piece, that say something.
const LEAST_ROWS: usize = 4;
/// Robust standard deviations of a gross error: wide, since a vibration is no normal noise.
const GROSS: f64 = 8.0;
/// Rounding of a file's last digit (0.1 um, or as many rad): residuals are never smaller.
const ROUNDING: f64 = 1e-7;
/// Time constants that a servo needs to follow a change of speed, and the part of the gap that it may be off by then.
const SETTLED: f64 = 6.0;
const STEADY: f64 = 0.01;
/// Growth of the gap's variance up to which a lag counts as distinguished from the gap.
const LAG_COST: f64 = 400.0;

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// The estimate, rad or m.
    pub value: f64,
    /// Its 95 % interval, rad or m.
    pub ci95: [f64; 2],
}

impl Known {
    /// Whether the 95 % interval leaves out `v` (rad or m).
    pub fn excludes(&self, v: f64) -> bool {
        self.ci95[0] > v || self.ci95[1] < v
    }
}

/// What the intervals are based on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Repeats {
    /// From strokes that repeat each other.
    Strokes,
    /// From pieces of strokes, where too few strokes go far enough.
    Pieces,
}

/// Both flanks of one gap; rad or m of the joint.
#[derive(Debug, Clone)]
pub struct Flanks {
    /// Output per input.
    pub slope: Known,
    /// Offsets of equation 2, each to the zero of the columns.
    pub c_r: Known,
    /// Offset of the left flank, rad or m.
    pub c_l: Known,
    /// `c_r - c_l`.
    pub total: Known,
    /// `(c_r + c_l)/2`.
    pub middle: Known,
    /// Mean of the input in the rows that were used, rad or m.
    pub centre: f64,
    /// s; `None` where none was fitted.
    pub lag_s: Option<Known>,
    /// A lag was looked for, and the log cannot tell it from a gap: gap per second of lag.
    pub total_per_lag: Option<f64>,
    /// Rms of output about the lines.
    pub rms: f64,
    /// Number of rows that were used.
    pub rows: usize,
    /// Number of rows that were left out.
    pub dropped: usize,
    /// Strokes that go far enough, up and down.
    pub strokes: [usize; 2],
    /// What the intervals were estimated from.
    pub repeats: Repeats,
}

impl Flanks {
    /// A gap that is surely there. A negative one is none: the output would run ahead of its input.
    pub fn significant(&self) -> bool {
        self.total.ci95[0] > 0.0
    }
}

/// Variance inflation from which on the lines have no slope that can be determined.
const SINGULAR: f64 = 1e10;

/// Input and output of a gap, and where it is surely closed.
pub struct Pair<'a> {
    /// Times, s.
    pub t_s: &'a [f64],
    /// Position of the driving side, rad or m; `None` where it was not measured.
    pub input: &'a [Option<f64>],
    /// Position of the driven side, rad or m; `None` where it was not measured.
    pub output: &'a [Option<f64>],
    /// Strokes between reversals.
    pub strokes: &'a Strokes,
    /// Rows count from this way into a stroke on.
    pub from: f64,
    /// Whether a lag between the two sides is fitted as well.
    pub with_lag: bool,
}

/// Normal equations of some rows: slope, upper line, lower line, lag.
#[derive(Debug, Clone, Copy)]
struct Normal {
    matrix: Matrix4<f64>,
    right: Vector4<f64>,
}

impl Normal {
    fn of(rows: &[Row]) -> Self {
        let mut sum = Self { matrix: Matrix4::zeros(), right: Vector4::zeros() };
        for r in rows {
            sum.matrix += r.design * r.design.transpose();
            sum.right += r.design * r.output;
        }
        sum
    }

    fn less(&self, part: &Self) -> Self {
        Self { matrix: self.matrix - part.matrix, right: self.right - part.right }
    }

    /// Solution and inverse; a lag that is not asked for is held at 0.
    fn solve(&self, lag: bool) -> Option<(Vector4<f64>, Matrix4<f64>)> {
        let (mut matrix, mut right) = (self.matrix, self.right);
        if !lag {
            matrix.fill_row(3, 0.0);
            matrix.fill_column(3, 0.0);
            matrix[(3, 3)] = 1.0;
            right[3] = 0.0;
        }
        let found = scaled_inverse(&DMatrix::from_fn(4, 4, |i, j| matrix[(i, j)]), 0.0)?;
        if found.inflation >= SINGULAR {
            return None;
        }
        let inverse = Matrix4::from_fn(|i, j| found.inverse[(i, j)]);
        Some((inverse * right, inverse))
    }
}

/// A row that counts.
#[derive(Clone)]
struct Row {
    row: usize,
    design: Vector4<f64>,
    output: f64,
    stroke: usize,
    up: bool,
}

/// `m, c_r, c_l, total, middle, tau` of a solution.
fn figures(x: &Vector4<f64>, centre: f64, level: f64) -> [f64; 6] {
    let (m, tau) = (x[0], -x[3] / x[0]);
    let c = |line: f64| centre - (level + line) / m;
    let (c_r, c_l) = (c(x[1]), c(x[2]));
    [m, c_r, c_l, (x[2] - x[1]) / m, 0.5 * (c_r + c_l), tau]
}

/// Fits again without rows that lie far from both flanks.
fn without_gross(
    rows: &mut Vec<Row>,
    mut total: Normal,
    mut x: Vector4<f64>,
    lag: bool,
) -> Result<(Normal, Vector4<f64>), Missing> {
    for _ in 0..3 {
        let error: Vec<f64> = rows.iter().map(|r| (r.output - r.design.dot(&x)).abs()).collect();
        let limit = GROSS * (SIGMA_PER_MAD * median(&error)).max(ROUNDING);
        let before = rows.len();
        let mut error = error.iter();
        rows.retain(|_| error.next().is_some_and(|e| *e <= limit));
        if rows.len() == before {
            break;
        }
        total = Normal::of(rows);
        x = total.solve(lag).ok_or(Missing::Singular)?.0;
    }
    Ok((total, x))
}

/// Half widths of the figures' 95 % intervals, by leaving out one stroke of each direction at a time.
fn half_widths(clusters: &[(bool, Normal)], without: &dyn Fn(&Normal) -> Option<[f64; 6]>) -> Option<[f64; 6]> {
    let mut variance = [0.0; 6];
    for up in [true, false] {
        let of_side = clusters.iter().filter(|c| c.0 == up).map(|c| without(&c.1));
        add_jackknife(&mut variance, &of_side.collect::<Option<Vec<_>>>()?);
    }
    let factor = student::factor(0.95, (clusters.len() - 2) as f64);
    // clean data agree better than their digits; at a stop all rows are rounded alike, so that it does not average out
    let digit = ROUNDING / 12f64.sqrt();
    let floor = [0.0, digit, digit, digit, digit, 0.0];
    Some(std::array::from_fn(|k| factor * variance[k].sqrt().max(floor[k])))
}

/// Adds the variance by which the figures differ where one stroke of a direction is left out.
fn add_jackknife(variance: &mut [f64; 6], without: &[[f64; 6]]) {
    let n = without.len() as f64;
    for (k, v) in variance.iter_mut().enumerate() {
        let mean = without.iter().map(|f| f[k]).sum::<f64>() / n;
        *v += (n - 1.0) / n * without.iter().map(|f| (f[k] - mean).powi(2)).sum::<f64>();
    }
}

/// Fits both flanks.
pub fn fit(pair: &Pair) -> Result<Flanks, Missing> {
    let (mut rows, centre, level) = usable(pair);
    let count = |rows: &[Row], up: bool| rows.iter().filter(|r| r.up == up).count();
    if [true, false].iter().any(|&up| count(&rows, up) < LEAST_ROWS) {
        return Err(Missing::TooShort);
    }
    let all = rows.len();
    let mut total = Normal::of(&rows);
    let (plain, inverse) = total.solve(false).ok_or(Missing::Singular)?;
    let spread = |inverse: &Matrix4<f64>| inverse[(1, 1)] + inverse[(2, 2)] - 2.0 * inverse[(1, 2)];
    let spread_without = spread(&inverse);
    let with = pair.with_lag.then(|| total.solve(true)).flatten();
    let lag = with.as_ref().is_some_and(|(_, i)| spread(i) <= LAG_COST * spread_without);
    let mut x = with.as_ref().filter(|_| lag).map_or(plain, |w| w.0);
    let mut all = all;
    if lag {
        // rows of a steady speed, where a lag is a distance
        for _ in 0..2 {
            let steady = |r: &&Row| steady(pair, r.row, x[3] / x[0], STEADY * (x[2] - x[1]) / x[0]);
            let kept: Vec<Row> = rows.iter().filter(steady).cloned().collect();
            let Some((next, inverse)) = Normal::of(&kept).solve(true) else { break };
            if spread(&inverse) > LAG_COST * spread_without {
                break;
            }
            (rows, x) = (kept, next);
        }
        (total, all) = (Normal::of(&rows), rows.len());
    }
    (total, x) = without_gross(&mut rows, total, x, lag)?;
    let squares: f64 = rows.iter().map(|r| (r.output - r.design.dot(&x)).powi(2)).sum();
    let (clusters, repeats, strokes) = clusters(&rows);
    let [n_up, n_down] = [true, false].map(|up| clusters.iter().filter(|c| c.0 == up).count());
    if n_up < 2 || n_down < 2 {
        return Err(Missing::TooShort);
    }
    let best = figures(&x, centre, level);
    let figures_without = |c: &Normal| total.less(c).solve(lag).map(|(x, _)| figures(&x, centre, level));
    let half = half_widths(&clusters, &figures_without).ok_or(Missing::TooShort)?;
    let known = |k: usize| Known { value: best[k], ci95: [best[k] - half[k], best[k] + half[k]] };
    let speed = rows.iter().map(|r| r.design[3].abs()).sum::<f64>() / rows.len() as f64;
    Ok(Flanks {
        slope: known(0),
        c_r: known(1),
        c_l: known(2),
        total: known(3),
        middle: known(4),
        centre,
        lag_s: lag.then(|| known(5)),
        // settled poses have no speed, and no lag
        total_per_lag: (pair.with_lag && !lag && speed > 0.0).then_some(2.0 * speed),
        rms: (squares / rows.len() as f64).sqrt(),
        rows: rows.len(),
        dropped: all - rows.len(),
        strokes,
        repeats,
    })
}

/// The speed has not changed for long enough that a lag is a shift of the position by less than `least`.
fn steady(pair: &Pair, row: usize, lag_s: f64, least: f64) -> bool {
    let (v, t) = (&pair.strokes.speed, pair.t_s);
    let same = |i: usize| ((v[i] - v[row]) * lag_s).abs() <= least.abs();
    let before = (0..row).rev().take_while(|&i| t[row] - t[i] <= SETTLED * lag_s.abs()).all(same);
    before && row.checked_sub(1).is_none_or(same) && v.get(row + 1).is_none_or(|_| same(row + 1))
}

/// Rows in touch, about the middle of their inputs and outputs.
fn usable(pair: &Pair) -> (Vec<Row>, f64, f64) {
    let s = pair.strokes;
    let there = |i: usize| Some((pair.input[i]?, pair.output[i]?));
    let counts = |i: usize| s.direction(i) != 0 && s.travel[i] > pair.from;
    let found: Vec<(usize, f64, f64)> =
        (0..s.travel.len()).filter(|&i| counts(i)).filter_map(|i| there(i).map(|(u, w)| (i, u, w))).collect();
    let n = found.len().max(1) as f64;
    let (centre, level) = (found.iter().map(|r| r.1).sum::<f64>() / n, found.iter().map(|r| r.2).sum::<f64>() / n);
    let mut per_stroke = vec![0usize; s.dir.len()];
    found.iter().for_each(|r| per_stroke[s.stroke[r.0]] += 1);
    let rows = found
        .into_iter()
        .filter(|r| per_stroke[s.stroke[r.0]] >= LEAST_ROWS)
        .map(|(i, u, w)| {
            let up = s.direction(i) > 0;
            let [a, b] = if up { [1.0, 0.0] } else { [0.0, 1.0] };
            Row {
                row: i,
                design: Vector4::new(u - centre, a, b, s.speed[i]),
                output: w - level,
                stroke: s.stroke[i],
                up,
            }
        })
        .collect();
    (rows, centre, level)
}

/// What is left out, one after the other: strokes, or pieces of them where they are few.
fn clusters(rows: &[Row]) -> (Vec<(bool, Normal)>, Repeats, [usize; 2]) {
    let by_stroke: Vec<&[Row]> = rows.chunk_by(|a, b| a.stroke == b.stroke).collect();
    let strokes = [true, false].map(|up| by_stroke.iter().filter(|s| s[0].up == up).count());
    let few = strokes.iter().any(|&n| n < FEW_STROKES);
    let mut out = Vec::new();
    for stroke in by_stroke {
        let up = stroke[0].up;
        let n = strokes[usize::from(!up)].max(1);
        let pieces = if few { PIECES.div_ceil(n).min(stroke.len() / LEAST_ROWS).max(1) } else { 1 };
        for piece in stroke.chunks(stroke.len().div_ceil(pieces)) {
            out.push((up, Normal::of(piece)));
        }
    }
    (out, if few { Repeats::Pieces } else { Repeats::Strokes }, strokes)
}
