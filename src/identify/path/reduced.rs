//! One log in reduced form: the products from which cost, gradient and normal matrix follow without going back to its points.

use super::nuisance::{Basis, dot};
use super::prepare::Binned;
use super::problem::Normal;
use nalgebra::Vector3;

/// A log with what the fit needs of it.
#[derive(Debug, Clone)]
pub struct Part {
    pub log: Binned,
    /// `(joint of the problem, joint of the log)`.
    pub pairs: Vec<(usize, usize)>,
    pub basis: Basis,
    /// Weighted measurement with the nuisances projected out.
    pub y: Vec<Vector3<f64>>,
    /// Cost without lost motion.
    pub yy: f64,
    /// Per pair and bin: `y J`, and the rows `Q^T J` (rank values each).
    pub yj: Vec<Vec<f64>>,
    pub qj: Vec<Vec<f64>>,
    /// Per pair of pairs and bin: `J J`.
    pub jj: Vec<Vec<f64>>,
    pub scale: f64,
}

impl Binned {
    /// Measured minus commanded TCP in the world, m.
    pub fn deviation(&self) -> Vec<Vector3<f64>> {
        let r = self.frame.rotation.to_rotation_matrix();
        let t = self.frame.translation.vector;
        self.xyz.iter().zip(&self.want).map(|(x, w)| r * x + t - w).collect()
    }
}

/// Derivatives of one joint: per bin one value per name.
pub struct Block {
    pub der: Vec<f64>,
    pub names: Vec<usize>,
}

impl Part {
    /// The products that an evaluation needs.
    pub fn reduce(&mut self) {
        let root = &self.basis.root;
        let rank = self.basis.rank();
        let n = root.len();
        let measured: Vec<Vector3<f64>> = self.log.deviation().iter().zip(root).map(|(d, r)| d * *r).collect();
        let mut y = measured.clone();
        for q in &self.basis.vectors {
            let share = dot(q, &measured);
            for (v, q) in y.iter_mut().zip(q) {
                *v -= q * share;
            }
        }
        self.yy = dot(&measured, &y);
        let jac = |pair: usize| &self.log.joints[self.pairs[pair].1].jac;
        let pairs = self.pairs.len();
        self.yj = (0..pairs).map(|k| (0..n).map(|i| y[i].dot(&jac(k)[i]) * root[i]).collect()).collect();
        self.qj = (0..pairs)
            .map(|k| {
                let j = jac(k);
                let mut rows = vec![0.0; n * rank];
                for (c, q) in self.basis.vectors.iter().enumerate() {
                    for i in 0..n {
                        rows[i * rank + c] = q[i].dot(&j[i]) * root[i];
                    }
                }
                rows
            })
            .collect();
        self.jj = (0..pairs * pairs)
            .map(|ab| {
                let (a, b) = (jac(ab / pairs), jac(ab % pairs));
                (0..n).map(|i| a[i].dot(&b[i]) * root[i] * root[i]).collect()
            })
            .collect();
        self.y = y;
    }

    /// Adds `Q^T J e` of one joint to `u`.
    pub fn add_projection(&self, slot: usize, e: &[f64], u: &mut [f64]) {
        let rank = u.len();
        if rank == 0 {
            return;
        }
        for (row, e) in self.qj[slot].chunks_exact(rank).zip(e) {
            for (u, q) in u.iter_mut().zip(row) {
                *u += q * e;
            }
        }
    }

    pub fn projection(&self, errors: &[Vec<f64>]) -> Vec<f64> {
        let mut u = vec![0.0; self.basis.rank()];
        for (slot, e) in errors.iter().enumerate() {
            self.add_projection(slot, e, &mut u);
        }
        u
    }

    pub fn cost(&self, errors: &[Vec<f64>]) -> f64 {
        let pairs = errors.len();
        let mut cost = self.yy;
        for (a, ea) in errors.iter().enumerate() {
            cost -= 2.0 * ea.iter().zip(&self.yj[a]).map(|(e, y)| e * y).sum::<f64>();
            for (b, eb) in errors.iter().enumerate().skip(a) {
                let twice = if a == b { 1.0 } else { 2.0 };
                let s: f64 = ea.iter().zip(eb).zip(&self.jj[a * pairs + b]).map(|((x, y), j)| x * y * j).sum();
                cost += twice * s;
            }
        }
        cost - self.projection(errors).iter().map(|u| u * u).sum::<f64>()
    }

    /// Block `a` along the nuisance's basis, and along the residual `rest`; one row, one value for each of its parameters.
    fn projected(&self, a: usize, block: &Block, rest: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (width, rank) = (block.names.len(), self.basis.rank());
        let mut qt = vec![0.0; width * rank];
        let mut g = vec![0.0; width];
        for (i, rest) in rest.iter().enumerate() {
            let row = &self.qj[a][i * rank..(i + 1) * rank];
            for c in 0..width {
                let d = block.der[i * width + c];
                if d != 0.0 {
                    g[c] += d * rest;
                    for (t, q) in qt[c * rank..(c + 1) * rank].iter_mut().zip(row) {
                        *t += d * q;
                    }
                }
            }
        }
        (qt, g)
    }

    pub fn add_normal(&self, errors: &[Vec<f64>], blocks: &[Block], out: &mut Normal) {
        let pairs = errors.len();
        let rank = self.basis.rank();
        let n = self.basis.root.len();
        let u = self.projection(errors);
        let mut rest = vec![0.0; n];
        let mut projected: Vec<Vec<f64>> = Vec::with_capacity(pairs);
        for (a, block) in blocks.iter().enumerate() {
            let width = block.names.len();
            rest.copy_from_slice(&self.yj[a]);
            for (b, eb) in errors.iter().enumerate() {
                for ((r, e), j) in rest.iter_mut().zip(eb).zip(&self.jj[a * pairs + b]) {
                    *r -= e * j;
                }
            }
            let (qt, g) = self.projected(a, block, &rest);
            for c in 0..width {
                let along: f64 = qt[c * rank..(c + 1) * rank].iter().zip(&u).map(|(a, b)| a * b).sum();
                out.gradient[block.names[c]] += g[c] + along;
            }
            for (b, other) in blocks.iter().enumerate().take(a + 1) {
                let wb = other.names.len();
                let jj = &self.jj[a * pairs + b];
                let h = inner(block, other, jj);
                let qb = if b == a { &qt } else { &projected[b] };
                for c in 0..width {
                    for k in 0..wb {
                        let inner: f64 = qt[c * rank..(c + 1) * rank]
                            .iter()
                            .zip(&qb[k * rank..(k + 1) * rank])
                            .map(|(x, y)| x * y)
                            .sum();
                        let value = h[c * wb + k] - inner;
                        out.matrix[(block.names[c], other.names[k])] += value;
                        if b != a {
                            out.matrix[(other.names[k], block.names[c])] += value;
                        }
                    }
                }
            }
            projected.push(qt);
        }
    }
}

/// Products of the derivatives of two blocks, weighted by `jj` at each bin.
fn inner(block: &Block, other: &Block, jj: &[f64]) -> Vec<f64> {
    let (width, wb) = (block.names.len(), other.names.len());
    let mut h = vec![0.0; width * wb];
    for (i, jj) in jj.iter().enumerate() {
        for c in 0..width {
            let d = block.der[i * width + c] * jj;
            for k in 0..wb {
                h[c * wb + k] += d * other.der[i * wb + k];
            }
        }
    }
    h
}
