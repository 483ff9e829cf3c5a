//! Training: the cost of Cursi (2022) (sections IV-A and IV-B), minimised by Levenberg-Marquardt.
//!
//! Plain: `c = 1/2 sum |f - P|^2`. Augmented: `c = sum w_p/2 |f - P|^2 + w_dp/2 |df/dt - dP/dt|^2`, `w_p = 1e-3`, `w_dp = 1` as
//! published, positions in mm, velocities in mm/s (the seed prints no unit: "per unit of time"). A row without a velocity counts with its
//! position alone. The seed ran 20,000 epochs at a learning rate of 1e-4; a network of 181 weights is solved much sooner by
//! second-order steps (Hagan and Menhaj 1994).
//!
//! So many small epochs end before the weights are large; second-order steps run to the end would go on into the noise, and a
//! network that follows noise has a poor Jacobian. So the cost gets half the sum of the squared weights (but the constant), with a factor
//! that the data choose: the evidence framework of MacKay 1992 in the form of Foresee and Hagan 1997, `rho = (g / sum w^2) /
//! ((n - g) / sum r^2)`, `g = N - rho tr(H^-1)` the number of weights that the data determine, `n` the rows. Targets are scaled to unit
//! spread by the caller, so that weights compare.
//!
//! Normal equations are summed over blocks of fixed size in fixed order, so that the weights do not depend on the number
//! of threads. It reports why it stopped; not converged is data.

use super::network::Network;
use crate::numerics::least_squares::{
    Flow, Options, Problem, Products, Progress, Scaling, TerminationReason, minimise,
};
use crate::numerics::parallel::{ParMap, pieces};
use nalgebra::{DMatrix, DVector};

/// Rows of samples that one thread takes at a time.
const BLOCK: usize = 256;
/// Steps at most.
const MOST_STEPS: usize = 300;
/// Costs that change by less than this share over [`PATIENCE`] steps have arrived.
const LEAST_CHANGE: f64 = 1e-3;
const PATIENCE: usize = 6;
/// Factor of the squared weights at the start, over the rows: weak.
const FIRST_RHO: f64 = 1e-5;

/// One network's samples, scaled. Rows stand one after the other.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Number of inputs.
    pub inputs: usize,
    /// `u[row * inputs + i]`.
    pub u: Vec<f64>,
    /// Target of each row, scaled.
    pub target: Vec<f64>,
    /// Speed of the inputs, laid out as `u`; meaningless where the row has no target speed.
    pub du: Vec<f64>,
    /// Target of the velocity of each row; `None`: not known.
    pub target_speed: Vec<Option<f64>>,
}

impl Samples {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.target.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.target.is_empty()
    }

    fn row(&self, r: usize) -> (&[f64], &[f64]) {
        let range = r * self.inputs..(r + 1) * self.inputs;
        (&self.u[range.clone()], &self.du[range])
    }
}

/// Weights of the two parts of the cost; `speed` 0 is the plain network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Weight of the positions.
    pub position: f64,
    /// Weight of the velocities.
    pub speed: f64,
}

/// How a training went.
#[derive(Debug, Clone)]
pub struct Training {
    /// Why the training stopped.
    pub reason: TerminationReason,
    /// Number of steps.
    pub steps: usize,
    /// Without the squared weights.
    pub cost: f64,
    /// Number of weights that the data determine.
    pub determined: f64,
}

/// Settings of the least squares; the criterion of convergence is [`Evidence::judge`]'s.
const SETTINGS: Options = Options {
    max_steps: MOST_STEPS,
    cost_tolerance: 0.0,
    cost_tolerance_absolute: 0.0,
    gradient_tolerance: 1e-15,
    step_tolerance: 0.0,
    initial_damping: 1e-2,
    least_damping: 1e-15,
    most_damping: 1e12,
    least_easing: 1.0 / 3.0,
    scaling: Scaling::Columns,
    model_at_end: false,
};

/// Trains `network` in place.
pub fn train(network: &mut Network, samples: &Samples, cost: Cost) -> Training {
    let weights = network.weights.len();
    let rho = FIRST_RHO * samples.len() as f64;
    let mut problem = Evidence { samples, cost, rho, determined: weights as f64, history: Vec::new() };
    let found = minimise(&mut problem, network.clone(), &SETTINGS);
    *network = found.point;
    Training { reason: found.reason, steps: found.steps, cost: found.state, determined: problem.determined }
}

/// Training as a least-squares problem: the data's residuals, and the weights themselves times the root of a factor that the
/// data choose anew at every step.
struct Evidence<'a> {
    samples: &'a Samples,
    cost: Cost,
    rho: f64,
    determined: f64,
    /// Data's cost and prior after each step.
    history: Vec<[f64; 2]>,
}

impl Problem for Evidence<'_> {
    type Point = Network;
    /// The data's cost: half the sum of squares.
    type State = f64;
    type Model = Products;

    fn evaluate(&mut self, network: &Network) -> f64 {
        sum(network, self.samples, self.cost)
    }

    fn cost(&self, network: &Network, data: &f64) -> f64 {
        2.0 * (data + self.rho * prior(network))
    }

    fn linearise(&mut self, network: &Network, data: &f64) -> Products {
        let mut normal = Normal::of(network, self.samples, self.cost);
        if let Some(found) = evidence(&normal, network, self.samples.len(), *data, self.rho) {
            (self.rho, self.determined) = found;
        }
        normal.add_prior(network, self.rho);
        Products::new(normal.matrix, normal.gradient.as_slice().to_vec())
    }

    fn moved(&self, network: &Network, change: &mut [f64]) -> Network {
        let mut next = network.clone();
        next.weights.iter_mut().zip(change.iter()).for_each(|(w, d)| *w += d);
        next
    }

    fn judge(&mut self, network: &Network, data: &f64, progress: &Progress) -> Flow {
        if progress.steps == 0 {
            return Flow::Continue;
        }
        self.history.push([*data, prior(network)]);
        let still =
            |before: &[f64; 2], now: &[f64; 2]| before.iter().zip(now).all(|(b, a)| (b - a).abs() <= LEAST_CHANGE * b);
        let last = self.history.len() - 1;
        let arrived = last >= PATIENCE && still(&self.history[last - PATIENCE], &self.history[last]);
        if *data == 0.0 || arrived { Flow::Reached } else { Flow::Continue }
    }
}

/// Half the sum of the squared weights but the constant.
fn prior(network: &Network) -> f64 {
    let all = network.weights.len().saturating_sub(1);
    0.5 * network.weights[..all].iter().map(|w| w * w).sum::<f64>()
}

/// The factor of the squared weights that makes the data likeliest, and how many weights they determine.
fn evidence(normal: &Normal, network: &Network, rows: usize, data: f64, rho: f64) -> Option<(f64, f64)> {
    let all = network.weights.len() - 1;
    let mut matrix = normal.matrix.view((0, 0), (all, all)).into_owned();
    (0..all).for_each(|k| matrix[(k, k)] += rho);
    let trace = matrix.cholesky()?.inverse().trace();
    let determined = (all as f64 - rho * trace).clamp(1.0, all as f64);
    let free = (rows as f64 - determined).max(1.0);
    let next = determined / prior(network).max(f64::MIN_POSITIVE) * data / free;
    (next.is_finite() && next > 0.0).then_some((next, determined))
}

/// The cost.
fn sum(network: &Network, samples: &Samples, cost: Cost) -> f64 {
    let part = |rows: std::ops::Range<usize>| {
        rows.map(|r| {
            let (u, du) = samples.row(r);
            match samples.target_speed[r].filter(|_| cost.speed > 0.0) {
                Some(want) => {
                    let (value, speed) = network.value_and_speed(u, du);
                    0.5 * (cost.position * (value - samples.target[r]).powi(2) + cost.speed * (speed - want).powi(2))
                }
                None => 0.5 * cost.position * (network.value(u) - samples.target[r]).powi(2),
            }
        })
        .sum::<f64>()
    };
    pieces(samples.len(), BLOCK).par_map(|rows| part(rows.clone())).iter().sum()
}

/// Normal equations of the residuals, linearised at the weights.
struct Normal {
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Normal {
    fn add_prior(&mut self, network: &Network, rho: f64) {
        for k in 0..network.weights.len() - 1 {
            self.matrix[(k, k)] += rho;
            self.gradient[k] += rho * network.weights[k];
        }
    }

    fn of(network: &Network, samples: &Samples, cost: Cost) -> Self {
        let n = network.weights.len();
        let part = |rows: std::ops::Range<usize>| {
            // one column per residual: a row of the Jacobian lies in one piece
            let mut jac = DMatrix::<f64>::zeros(n, 2 * rows.len());
            let mut residual = DVector::<f64>::zeros(2 * rows.len());
            let (p, s) = (cost.position.sqrt(), cost.speed.sqrt());
            for (k, r) in rows.enumerate() {
                let (u, du) = samples.row(r);
                let two = &mut jac.as_mut_slice()[2 * k * n..2 * (k + 1) * n];
                let (row, fast) = two.split_at_mut(n);
                let value = match samples.target_speed[r].filter(|_| cost.speed > 0.0) {
                    Some(want) => {
                        let (value, speed) = network.speed_by_weights(u, du, row, fast);
                        residual[2 * k + 1] = s * (speed - want);
                        fast.iter_mut().for_each(|v| *v *= s);
                        value
                    }
                    None => network.value_by_weights(u, row),
                };
                residual[2 * k] = p * (value - samples.target[r]);
                row.iter_mut().for_each(|v| *v *= p);
            }
            (&jac * jac.transpose(), &jac * residual)
        };
        let parts: Vec<(DMatrix<f64>, DVector<f64>)> = pieces(samples.len(), BLOCK).par_map(|rows| part(rows.clone()));
        let mut all = Self { matrix: DMatrix::zeros(n, n), gradient: DVector::zeros(n) };
        for (matrix, gradient) in parts {
            all.matrix += matrix;
            all.gradient += gradient;
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Samples of `of`, moving at random speeds.
    fn samples(of: impl Fn(&[f64], &[f64]) -> (f64, f64), rows: usize, speeds: bool) -> Samples {
        let mut generator = ChaCha8Rng::seed_from_u64(9);
        let mut all = Samples { inputs: 2, ..Samples::default() };
        for _ in 0..rows {
            let u: Vec<f64> = (0..2).map(|_| generator.random_range(-1.0..1.0)).collect();
            let du: Vec<f64> = (0..2).map(|_| generator.random_range(-1.0..1.0)).collect();
            let (value, speed) = of(&u, &du);
            all.u.extend(&u);
            all.du.extend(&du);
            all.target.push(value);
            all.target_speed.push(speeds.then_some(speed));
        }
        all
    }

    fn wave(u: &[f64], du: &[f64]) -> (f64, f64) {
        let (s, c) = (1.5 * u[0]).sin_cos();
        (3.0 * s * u[1], 3.0 * (1.5 * c * du[0] * u[1] + s * du[1]))
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences_of_the_cost() {
        let all = samples(wave, 300, true);
        let cost = Cost { position: 1e-3, speed: 1.0 };
        let net = Network::random(2, 4, 0.0, 1.0, &mut ChaCha8Rng::seed_from_u64(2));
        let normal = Normal::of(&net, &all, cost);
        for k in 0..net.weights.len() {
            let at = |d: f64| {
                let mut other = net.clone();
                other.weights[k] += d;
                sum(&other, &all, cost)
            };
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((slope - normal.gradient[k]).abs() < 1e-6 * normal.gradient.amax(), "weight {k}");
        }
    }

    #[test]
    fn a_smooth_function_is_learned_from_positions_and_from_velocities() {
        let test = samples(wave, 77, true);
        for cost in [Cost { position: 1.0, speed: 0.0 }, Cost { position: 1e-3, speed: 1.0 }] {
            let all = samples(wave, 600, true);
            let mut net = Network::random(2, 12, 0.0, 1.0, &mut ChaCha8Rng::seed_from_u64(1));
            let training = train(&mut net, &all, cost);
            let worst = (0..test.len())
                .map(|r| {
                    let (u, du) = test.row(r);
                    let (value, speed) = net.value_and_speed(u, du);
                    let (want, fast) = wave(u, du);
                    ((value - want).abs(), (speed - fast).abs())
                })
                .fold((0f64, 0f64), |a, b| (a.0.max(b.0), a.1.max(b.1)));
            assert!(worst.0 < 0.05 && worst.1 < 0.3, "{cost:?}: {worst:?}, {training:?}");
        }
    }

    #[test]
    fn a_network_finds_the_weights_that_made_its_data_again() {
        let truth = Network::random(2, 2, 0.3, 2.0, &mut ChaCha8Rng::seed_from_u64(5));
        let all = samples(|u, du| truth.value_and_speed(u, du), 400, true);
        let mut net = truth.clone();
        net.weights.iter_mut().enumerate().for_each(|(k, w)| *w += 0.1 * ((k % 3) as f64 - 1.0));
        let training = train(&mut net, &all, Cost { position: 1e-3, speed: 1.0 });
        assert!(training.cost < 1e-16, "{training:?}");
        assert!(net.weights.iter().zip(&truth.weights).all(|(a, b)| (a - b).abs() < 1e-5));
    }

    #[test]
    fn noise_is_not_learned() {
        let mut generator = ChaCha8Rng::seed_from_u64(8);
        let mut all = samples(|u, _| (0.8 * u[0], 0.0), 400, false);
        all.target.iter_mut().for_each(|t| *t += 0.3 * generator.random_range(-1.0..1.0));
        let mut net = Network::random(2, 30, 0.0, 1.0, &mut ChaCha8Rng::seed_from_u64(3));
        let training = train(&mut net, &all, Cost { position: 1.0, speed: 0.0 });
        let clean = samples(|u, _| (0.8 * u[0], 0.0), 200, false);
        let square: f64 = (0..200).map(|r| (net.value(clean.row(r).0) - clean.target[r]).powi(2)).sum();
        // noise of 0.17 over 400 rows, shared by a dozen weights at most: 0.03
        assert!((square / 200.0).sqrt() < 0.04, "{}, {training:?}", (square / 200.0).sqrt());
        assert!(training.determined < 25.0, "{training:?}");
    }
}
