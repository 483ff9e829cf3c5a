//! Which creep the dwells support: hypotheses over a grid of paces, with their posterior probabilities.
//!
//! Method: every hypothesis is linear in its amplitudes once its paces are chosen. With normal priors of the amplitudes its
//! marginal likelihood against "no creep" is closed: `b' (A + D)^-1 b / 2 - ln det(I + D^-1 A) / 2`, `A` and `b` the normal equations
//! after the places' offsets are eliminated. Amplitudes that differ from place to place by a share of their mean are a
//! random effect, integrated out place by place. Priors: no creep, one pace and two paces as in [`PRIOR`]; a pace is log-normal
//! ([`PACE_S`], [`PACE_SPREAD`]: nineteen of twenty between 0.2 and 9 s, as servos of robots work friction off in 0.3 to 5 s); an
//! amplitude is of the order of the reading itself, and a single one is not negative.

use super::noise::{CreepNoise, Whitened, whitened};
use super::series::PairSeries;
use crate::numerics::normal;
use nalgebra::{DMatrix, DVector};

/// Median of a pace before the measurement, s.
pub const PACE_S: f64 = 1.3;
/// Standard deviation of its logarithm.
pub const PACE_SPREAD: f64 = 1.0;
/// Prior probabilities of none, one and two paces.
const PRIOR: [f64; 3] = [0.5, 0.45, 0.05];
/// Grid of paces: from 0.05 to 30 s.
const PACES: usize = 49;
const PACE_RANGE_S: [f64; 2] = [0.05, 30.0];
/// A cell of the grid that holds more than this share of what all single paces weigh is divided, with its neighbours, into so many parts;
/// so often at most: paces to a part in 500,000.
const DIVIDED: f64 = 0.6;
const PARTS: usize = 4;
const DIVISIONS: usize = 8;
/// Of two paces every this many of the grid is tried, and the slower is at least twice the faster.
const COARSE: usize = 4;
/// Prior standard deviation of an amplitude over the mean reading, at the stop and at the reversal.
const AMPLITUDE: [f64; 2] = [1.0, 1.5];
/// Shares by which amplitudes of places differ, and their prior probabilities.
const SHARES: [[f64; 2]; 3] = [[0.0, 0.6], [0.1, 0.3], [0.25, 0.1]];
/// Standard deviations beyond which a tail is taken as an exponential.
const FAR: f64 = 6.0;
/// Hypotheses below this probability are dropped.
const NEGLIGIBLE: f64 = 1e-6;

/// A hypothesis and what it says.
#[derive(Debug, Clone)]
pub struct Component {
    pub weight: f64,
    /// Empty: no creep.
    pub paces: Vec<f64>,
    pub from_turn: bool,
    /// Mean amplitudes and their covariance.
    amplitudes: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Factor of each place on its amplitudes, less 1, and the variance of that factor.
    place_factor: Vec<[f64; 2]>,
}

/// What a hypothesis takes from the readings.
#[derive(Debug, Clone)]
pub struct Effect {
    pub pairs: Vec<f64>,
    pub mean: f64,
    pub mean_variance: f64,
    pub places: Vec<f64>,
    pub place_variance: Vec<f64>,
    /// The part of a place's variance that other places do not share.
    pub own_variance: Vec<f64>,
    pub at_stop: f64,
    pub at_end: f64,
}

impl Component {
    pub fn effect(&self, pairs: &[PairSeries], places: usize) -> Effect {
        let k = self.paces.len();
        let n = pairs.len().max(1) as f64;
        let mut rows = vec![DVector::<f64>::zeros(k); places];
        let mut count = vec![0.0; places];
        let mut mean_row = DVector::<f64>::zeros(k);
        let (mut at_stop, mut at_end) = (0.0, 0.0);
        let mut values = Vec::with_capacity(pairs.len());
        for pair in pairs {
            let row = DVector::from_fn(k, |i, _| pair.in_mean(self.paces[i], self.from_turn));
            let factor = 1.0 + self.place_factor.get(pair.place).map_or(0.0, |f| f[0]);
            values.push(factor * row.dot(&self.amplitudes));
            for (i, &tau) in self.paces.iter().enumerate() {
                at_stop += self.amplitudes[i] * pair.at(tau, self.from_turn, 0.0) / n;
                at_end += self.amplitudes[i] * pair.at(tau, self.from_turn, pair.end_s) / n;
            }
            mean_row += &row / n;
            rows[pair.place] += row;
            count[pair.place] += 1.0;
        }
        let mut place_mean = vec![0.0; places];
        let (mut place_variance, mut own_variance) = (vec![0.0; places], vec![0.0; places]);
        let mut mean_variance = (mean_row.transpose() * &self.covariance * &mean_row)[(0, 0)];
        for i in 0..places {
            if count[i] == 0.0 {
                continue;
            }
            let row = &rows[i] / count[i];
            let base = row.dot(&self.amplitudes);
            let [factor, variance] = self.place_factor.get(i).copied().unwrap_or([0.0; 2]);
            place_mean[i] = (1.0 + factor) * base;
            let apart = &row - &mean_row;
            own_variance[i] = variance * base * base + (apart.transpose() * &self.covariance * &apart)[(0, 0)];
            place_variance[i] = variance * base * base + (row.transpose() * &self.covariance * &row)[(0, 0)];
            mean_variance += variance * (base * count[i] / n).powi(2);
        }
        let mean = values.iter().sum::<f64>() / n;
        Effect { pairs: values, mean, mean_variance, places: place_mean, place_variance, own_variance, at_stop, at_end }
    }
}

/// Normal equations of one place with its offset eliminated.
struct PlaceNormal {
    a: DMatrix<f64>,
    b: DVector<f64>,
}

/// Posterior over all hypotheses; `scale` is the mean reading, rad or m.
pub fn posterior(pairs: &[PairSeries], places: usize, noise: &CreepNoise, scale: f64) -> Option<Vec<Component>> {
    let used: Vec<&PairSeries> = pairs.iter().filter(|p| !p.bins.is_empty()).collect();
    let white = whitened(pairs, noise)?;
    let scale = scale.max(noise.variance.sqrt() / (used.len().max(1) as f64).sqrt());
    let paces: Vec<f64> = (0..PACES)
        .map(|i| {
            let share = i as f64 / (PACES - 1) as f64;
            PACE_RANGE_S[0] * (PACE_RANGE_S[1] / PACE_RANGE_S[0]).powf(share)
        })
        .collect();
    let density = |t: f64| (-0.5 * ((t / PACE_S).ln() / PACE_SPREAD).powi(2)).exp();
    let prior: Vec<f64> = paces.iter().map(|&t| density(t)).collect();
    let all: f64 = prior.iter().sum();
    let mut components = vec![(PRIOR[0].ln(), none(places))];
    for from_turn in [false, true] {
        let amplitude = scale * AMPLITUDE[usize::from(from_turn)];
        let column = |tau: f64| -> Option<Vec<DVector<f64>>> {
            used.iter().zip(&white).map(|(p, w)| w.whiten(p.in_bins(tau, from_turn))).collect()
        };
        let weigh = |cell: &Cell| -> Option<WeightedCell> {
            let log_prior = (PRIOR[1] * 0.5 * density(cell.pace_s) * cell.width / all).ln();
            let mut found = Vec::new();
            let columns = column(cell.pace_s)?;
            add(&mut found, &[(cell.pace_s, &columns)], &white, places, from_turn, amplitude, log_prior);
            Some((*cell, found))
        };
        let cells = paces.iter().map(|&pace_s| weigh(&Cell { pace_s, width: 1.0 })).collect::<Option<_>>()?;
        components.extend(divided(cells, &weigh)?.into_iter().flat_map(|(_, found)| found));
        let coarse: Vec<usize> = (0..PACES).step_by(COARSE).collect();
        let columns: Vec<Vec<DVector<f64>>> = paces.iter().map(|&tau| column(tau)).collect::<Option<_>>()?;
        let two: Vec<(usize, usize)> = coarse
            .iter()
            .flat_map(|&i| coarse.iter().map(move |&j| (i, j)))
            .filter(|&(i, j)| paces[j] >= 2.0 * paces[i])
            .collect();
        let total: f64 = two.iter().map(|&(i, j)| prior[i] * prior[j]).sum();
        for (i, j) in two {
            let log_prior = (PRIOR[2] * 0.5 * prior[i] * prior[j] / total).ln();
            let members = [(paces[i], &columns[i]), (paces[j], &columns[j])];
            add(&mut components, &members, &white, places, from_turn, amplitude, log_prior);
        }
    }
    let best = components.iter().map(|c| c.0).fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = components.iter().map(|c| (c.0 - best).exp()).sum();
    let mut kept: Vec<Component> = components
        .into_iter()
        .map(|(log, c)| Component { weight: (log - best).exp() / sum, ..c })
        .filter(|c| c.weight > NEGLIGIBLE)
        .collect();
    let total: f64 = kept.iter().map(|c| c.weight).sum();
    for c in &mut kept {
        c.weight /= total;
    }
    Some(kept)
}

/// A single pace and the part of the grid that it stands for, in steps of the grid.
#[derive(Debug, Clone, Copy)]
struct Cell {
    pace_s: f64,
    width: f64,
}

/// A cell with its hypotheses and their logarithms.
type WeightedCell = (Cell, Vec<(f64, Component)>);

/// Cells of the grid, finer where one of them holds most of the weight: readings that hardly scatter tell the pace better than the grid,
/// and the nearest pace of the grid would then stand as if it were certain.
fn divided(mut cells: Vec<WeightedCell>, weigh: &dyn Fn(&Cell) -> Option<WeightedCell>) -> Option<Vec<WeightedCell>> {
    let step = (PACE_RANGE_S[1] / PACE_RANGE_S[0]).ln() / (PACES - 1) as f64;
    for _ in 0..DIVISIONS {
        let highest = cells.iter().flat_map(|c| &c.1).map(|c| c.0).fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = cells.iter().map(|c| c.1.iter().map(|c| (c.0 - highest).exp()).sum()).collect();
        let total: f64 = weights.iter().sum();
        let Some(best) = (0..cells.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])) else { break };
        if weights[best].is_nan() || weights[best] <= DIVIDED * total {
            break;
        }
        let near = best.saturating_sub(1)..(best + 2).min(cells.len());
        let mut parts = Vec::new();
        for (cell, _) in &cells[near.clone()] {
            let width = cell.width / PARTS as f64;
            for k in 0..PARTS {
                let off = (k as f64 + 0.5) * width - 0.5 * cell.width;
                parts.push(weigh(&Cell { pace_s: cell.pace_s * (off * step).exp(), width })?);
            }
        }
        cells.splice(near, parts);
    }
    Some(cells)
}

fn none(places: usize) -> Component {
    Component {
        weight: 0.0,
        paces: Vec::new(),
        from_turn: false,
        amplitudes: DVector::zeros(0),
        covariance: DMatrix::zeros(0, 0),
        place_factor: vec![[0.0; 2]; places],
    }
}

/// Adds the hypotheses of these paces, one for each share by which places may differ.
fn add(
    components: &mut Vec<(f64, Component)>,
    members: &[(f64, &Vec<DVector<f64>>)],
    white: &[Whitened],
    places: usize,
    from_turn: bool,
    amplitude: f64,
    log_prior: f64,
) {
    let k = members.len();
    let by_place = normals(members, white, places);
    let mut a = DMatrix::<f64>::zeros(k, k);
    let mut b = DVector::<f64>::zeros(k);
    for p in &by_place {
        a += &p.a;
        b += &p.b;
    }
    let ridge = 1.0 / (amplitude * amplitude);
    let with_prior = &a + DMatrix::identity(k, k) * ridge;
    let Some(cholesky) = with_prior.cholesky() else { return };
    let mut mean = cholesky.solve(&b);
    let log_det = 2.0 * cholesky.l().diagonal().iter().map(|d| d.ln()).sum::<f64>() - k as f64 * ridge.ln();
    let mut evidence = 0.5 * b.dot(&mean) - 0.5 * log_det;
    let mut covariance = cholesky.inverse();
    if k == 1 {
        // friction holds a joint back and never pushes it past its command: the amplitude is not negative
        let (log, moments) = positive(mean[0], covariance[(0, 0)].sqrt());
        evidence += log;
        mean[0] = moments[0];
        covariance[(0, 0)] = moments[1];
    }
    for [share, prior] in SHARES {
        let mut log = log_prior + evidence + prior.ln();
        let mut place_factor = vec![[0.0; 2]; places];
        if share > 0.0 {
            for (p, factor) in by_place.iter().zip(&mut place_factor) {
                // the place's amplitudes are (1 + f) times the mean, f normal with this share
                let information = (mean.transpose() * &p.a * &mean)[(0, 0)];
                let pull = mean.dot(&(&p.b - &p.a * &mean));
                let precision = information + 1.0 / (share * share);
                *factor = [pull / precision, 1.0 / precision];
                log += 0.5 * pull * pull / precision - 0.5 * (1.0 + information * share * share).ln();
            }
        }
        let paces = members.iter().map(|m| m.0).collect();
        let component = Component {
            weight: 0.0,
            paces,
            from_turn,
            amplitudes: mean.clone(),
            covariance: covariance.clone(),
            place_factor,
        };
        components.push((log, component));
    }
}

/// Logarithm of the share of a normal distribution above 0 (over one half, that of its prior), and mean and variance of that part.
fn positive(mean: f64, sigma: f64) -> (f64, [f64; 2]) {
    let at = -mean / sigma;
    if at > FAR {
        // the far tail is an exponential of this rate
        let scale = sigma / at;
        return (-0.5 * at * at - (at * (std::f64::consts::TAU).sqrt()).ln() + 2f64.ln(), [scale, scale * scale]);
    }
    let above = normal::below(-at);
    let rate = (-0.5 * at * at).exp() / std::f64::consts::TAU.sqrt() / above;
    let variance = sigma * sigma * (1.0 + at * rate - rate * rate);
    ((2.0 * above).ln(), [mean + sigma * rate, variance.max(0.0)])
}

/// Normal equations of each place with its offset eliminated.
fn normals(members: &[(f64, &Vec<DVector<f64>>)], white: &[Whitened], places: usize) -> Vec<PlaceNormal> {
    let k = members.len();
    let mut out: Vec<PlaceNormal> =
        (0..places).map(|_| PlaceNormal { a: DMatrix::zeros(k, k), b: DVector::zeros(k) }).collect();
    let mut ones = vec![0.0; places];
    let mut cross = vec![DVector::<f64>::zeros(k); places];
    let mut value = vec![0.0; places];
    for (w, pair) in white.iter().enumerate() {
        let p = pair.place;
        ones[p] += pair.one.dot(&pair.one);
        value[p] += pair.one.dot(&pair.value);
        for (i, (_, first)) in members.iter().enumerate() {
            cross[p][i] += first[w].dot(&pair.one);
            out[p].b[i] += first[w].dot(&pair.value);
            for (j, (_, second)) in members.iter().enumerate() {
                out[p].a[(i, j)] += first[w].dot(&second[w]);
            }
        }
    }
    for (p, normal) in out.iter_mut().enumerate().filter(|(p, _)| ones[*p] > 0.0) {
        normal.a -= &cross[p] * cross[p].transpose() / ones[p];
        normal.b -= &cross[p] * (value[p] / ones[p]);
    }
    out
}

/// Quantile of the slowest pace, given that there is creep; s.
pub fn pace_quantile(components: &[Component], share: f64) -> f64 {
    let mut paces: Vec<(f64, f64)> =
        components.iter().filter_map(|c| c.paces.iter().copied().reduce(f64::max).map(|t| (t, c.weight))).collect();
    paces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = paces.iter().map(|p| p.1).sum();
    let mut sum = 0.0;
    for (pace, weight) in &paces {
        sum += weight;
        if sum >= share * total {
            return *pace;
        }
    }
    paces.last().map_or(PACE_S, |p| p.0)
}
