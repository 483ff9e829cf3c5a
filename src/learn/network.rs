//! One hidden layer of sigmoid neurons: value, derivative by its inputs, and both by its weights, all analytic.
//!
//! `f(u) = c + sum_j v_j s(a_j)` with `a_j = b_j + sum_i w_ji u_i` and `s(a) = 1 / (1 + exp(-a))`. The derivative layer of
//! Cursi (2022) (figure 5b) has no weights itself: along a motion `du/dt` the output moves at
//! `df/dt = sum_j v_j s'(a_j) d_j`, `d_j = sum_i w_ji du_i/dt`. Weights stand in one vector: for each neuron `w_j1..w_jn, b_j, v_j`,
//! then `c`.
//!
//! Inputs are scaled to about -1..1 by the caller; outputs are what the targets are.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Weights of one network.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    /// Number of inputs.
    pub inputs: usize,
    /// Number of neurons in the hidden layer.
    pub hidden: usize,
    /// `hidden * (inputs + 2) + 1` numbers.
    pub weights: Vec<f64>,
}

impl Network {
    /// Number of weights of a network.
    pub fn count(inputs: usize, hidden: usize) -> usize {
        hidden * (inputs + 2) + 1
    }

    /// Random weights: neurons that bend at places spread over the inputs' range, outputs that add up to a spread of about `scale`
    /// around `centre` (after Nguyen and Widrow 1990, whose 0.7 is for the hyperbolic tangent).
    pub fn random(inputs: usize, hidden: usize, centre: f64, scale: f64, generator: &mut ChaCha8Rng) -> Self {
        // slope of a neuron across the range: `hidden` neurons share a range of `inputs` dimensions
        let steep = 1.4 * (hidden.max(1) as f64).powf(1.0 / inputs.max(1) as f64);
        let mut weights = Vec::with_capacity(Self::count(inputs, hidden));
        for _ in 0..hidden {
            let direction: Vec<f64> = (0..inputs).map(|_| generator.random_range(-1.0..1.0)).collect();
            let norm = direction.iter().map(|d| d * d).sum::<f64>().sqrt().max(1e-3);
            weights.extend(direction.iter().map(|d| steep * d / norm));
            weights.push(steep * generator.random_range(-1.0..1.0));
            weights.push(scale * generator.random_range(-1.0..1.0) / (hidden as f64).sqrt());
        }
        weights.push(centre);
        Self { inputs, hidden, weights }
    }

    /// The same network with every output times `scale`, plus `offset`.
    pub fn rescaled(&self, scale: f64, offset: f64) -> Self {
        let mut weights = self.weights.clone();
        weights.chunks_exact_mut(self.inputs + 2).for_each(|n| n[self.inputs + 1] *= scale);
        if let Some(c) = weights.last_mut() {
            *c = *c * scale + offset;
        }
        Self { weights, ..self.clone() }
    }

    fn neurons(&self) -> std::slice::ChunksExact<'_, f64> {
        self.weights.chunks_exact(self.inputs + 2)
    }

    /// The constant `c`.
    pub fn offset(&self) -> f64 {
        self.weights.last().copied().unwrap_or(0.0)
    }

    /// Each neuron's input weights, bias, output weight.
    pub fn parts(&self) -> impl Iterator<Item = (&[f64], f64, f64)> {
        self.neurons().map(|n| (&n[..self.inputs], n[self.inputs], n[self.inputs + 1]))
    }

    /// Value at scaled inputs `u`.
    pub fn value(&self, u: &[f64]) -> f64 {
        self.parts().map(|(w, b, v)| v * sigmoid(b + dot(w, u))).sum::<f64>() + self.offset()
    }

    /// Value, and its derivative by each input into `slope`.
    pub fn value_and_slope(&self, u: &[f64], slope: &mut [f64]) -> f64 {
        slope.fill(0.0);
        let mut value = self.offset();
        for (w, b, v) in self.parts() {
            let s = sigmoid(b + dot(w, u));
            value += v * s;
            let gain = v * s * (1.0 - s);
            for (d, w) in slope.iter_mut().zip(w) {
                *d += gain * w;
            }
        }
        value
    }

    /// Value and speed of the output at `u` moving at `du`.
    pub fn value_and_speed(&self, u: &[f64], du: &[f64]) -> (f64, f64) {
        self.parts().fold((self.offset(), 0.0), |(value, speed), (w, b, v)| {
            let s = sigmoid(b + dot(w, u));
            (value + v * s, speed + v * s * (1.0 - s) * dot(w, du))
        })
    }

    /// Value, and its derivative by every weight into `row`.
    pub fn value_by_weights(&self, u: &[f64], row: &mut [f64]) -> f64 {
        let n = self.inputs;
        let mut value = self.offset();
        for ((w, b, v), out) in self.parts().zip(row.chunks_exact_mut(n + 2)) {
            let s = sigmoid(b + dot(w, u));
            let gain = v * s * (1.0 - s);
            value += v * s;
            for (o, u) in out.iter_mut().zip(u) {
                *o = gain * u;
            }
            out[n] = gain;
            out[n + 1] = s;
        }
        if let Some(last) = row.last_mut() {
            *last = 1.0;
        }
        value
    }

    /// Value and speed, and their derivatives by every weight into `row` and `speed_row`.
    pub fn speed_by_weights(&self, u: &[f64], du: &[f64], row: &mut [f64], speed_row: &mut [f64]) -> (f64, f64) {
        let n = self.inputs;
        let (mut value, mut speed) = (self.offset(), 0.0);
        let outs = row.chunks_exact_mut(n + 2).zip(speed_row.chunks_exact_mut(n + 2));
        for ((w, b, v), (out, fast)) in self.parts().zip(outs) {
            let s = sigmoid(b + dot(w, u));
            let first = s * (1.0 - s);
            let second = first * (1.0 - 2.0 * s);
            let d = dot(w, du);
            value += v * s;
            speed += v * first * d;
            for i in 0..n {
                out[i] = v * first * u[i];
                fast[i] = v * (second * d * u[i] + first * du[i]);
            }
            (out[n], out[n + 1]) = (v * first, s);
            (fast[n], fast[n + 1]) = (v * second * d, first * d);
        }
        if let (Some(a), Some(b)) = (row.last_mut(), speed_row.last_mut()) {
            (*a, *b) = (1.0, 0.0);
        }
        (value, speed)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Never overflows: the exponential of a negative number only.
fn sigmoid(a: f64) -> f64 {
    let e = (-a.abs()).exp();
    if a >= 0.0 { 1.0 / (1.0 + e) } else { e / (1.0 + e) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    fn case() -> (Network, [f64; 3], [f64; 3]) {
        let mut generator = ChaCha8Rng::seed_from_u64(4);
        (Network::random(3, 7, 0.4, 2.0, &mut generator), [0.3, -0.7, 0.2], [1.1, 0.4, -2.0])
    }

    #[test]
    fn derivatives_by_the_inputs_are_those_of_finite_differences_at_two_scales() {
        let (net, u, du) = case();
        let mut slope = [0.0; 3];
        let value = net.value_and_slope(&u, &mut slope);
        assert!((value - net.value(&u)).abs() < 1e-14);
        for h in [1e-4, 1e-5] {
            for i in 0..3 {
                let at = |d: f64| {
                    let mut x = u;
                    x[i] += d;
                    net.value(&x)
                };
                assert!(((at(h) - at(-h)) / (2.0 * h) - slope[i]).abs() < 30.0 * h * h, "input {i}, step {h}");
            }
        }
        let speed = net.value_and_speed(&u, &du).1;
        assert!((speed - dot(&slope, &du)).abs() < 1e-13);
    }

    #[test]
    fn derivatives_by_the_weights_are_those_of_finite_differences_at_two_scales() {
        let (net, u, du) = case();
        let n = net.weights.len();
        let (mut row, mut alone, mut fast) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        net.speed_by_weights(&u, &du, &mut row, &mut fast);
        net.value_by_weights(&u, &mut alone);
        assert!(row.iter().zip(&alone).all(|(a, b)| (a - b).abs() < 1e-15 * (1.0 + a.abs())));
        for h in [1e-4, 1e-5] {
            for k in 0..n {
                let at = |d: f64| {
                    let mut other = net.clone();
                    other.weights[k] += d;
                    other.value_and_speed(&u, &du)
                };
                let (up, down) = (at(h), at(-h));
                let (value, speed) = ((up.0 - down.0) / (2.0 * h), (up.1 - down.1) / (2.0 * h));
                assert!((value - row[k]).abs() < 1e2 * h * h, "weight {k}, step {h}: {value} {}", row[k]);
                assert!((speed - fast[k]).abs() < 1e3 * h * h, "weight {k}, step {h}: {speed} {}", fast[k]);
            }
        }
    }

    #[test]
    fn a_neuron_far_out_saturates_and_stays_finite() {
        assert_eq!((sigmoid(1e4), sigmoid(-1e4)), (1.0, 0.0));
        assert!((sigmoid(0.7) + sigmoid(-0.7) - 1.0).abs() < 1e-15);
    }
}
