//! The least-squares problem: lost motion of all joints against all logs, nuisances projected out.
//!
//! Variable projection (Golub and Pereyra 1973) in reduced form. With `y` the projected measurement, `J_j` the Jacobian columns,
//! `e_j` the joint errors and `Q` the nuisance basis of a log,
//!
//! `cost = |y|^2 - 2 sum e_j (y J_j) + sum e_j e_k (J_j J_k) - |Q^T sum J_j e_j|^2`,
//!
//! so one evaluation needs per bin the products `y J_j`, `J_j J_k` and the rows `Q^T J_j`, which are made once. Logs have nuisances of
//! their own and share the joints' parameters; each is scaled by its own noise.

use super::chain::{GapLaw, Law, Out, evaluate};
use super::nuisance::{Basis, With, basis, rigid};
use super::prepare::Binned;
use super::reduced::{Block, Part};
use crate::effects::GapCurve;
use crate::numerics::robust::range;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix6, Rotation3, Translation3, UnitQuaternion, Vector3};

/// A joint that reverses in at least one log.
#[derive(Debug, Clone)]
pub struct Joint {
    pub axis: usize,
    pub center: f64,
    pub half: f64,
    pub held: Option<GapCurve>,
}

/// Parameters of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    pub c: Vec<f64>,
    pub spike: f64,
    pub tau_s: f64,
}

/// What is fitted: the joints with stiction, and whether they share one decay.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    pub sticky: Vec<bool>,
    pub shared: bool,
}

/// Meaning of one fitted number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Name {
    Gap { joint: usize, power: usize },
    Spike { joint: usize },
    LnTau { joint: usize },
    SharedLnTau,
}

/// All logs and joints.
#[derive(Debug, Clone)]
pub struct Problem {
    pub joints: Vec<Joint>,
    parts: Vec<Part>,
    pub with: With,
}

/// Cost, gradient and normal matrix at some values.
pub struct Normal {
    pub cost: f64,
    pub gradient: DVector<f64>,
    pub matrix: DMatrix<f64>,
}

impl Problem {
    /// Joints that reverse, over all logs; `held` gives curves that are not fitted.
    pub fn new(logs: Vec<Binned>, held: &[(usize, GapCurve)]) -> Self {
        let mut axes: Vec<usize> =
            logs.iter().flat_map(|l| l.joints.iter().filter(|j| j.reverses()).map(|j| j.axis)).collect();
        axes.sort_unstable();
        axes.dedup();
        let joints = axes
            .iter()
            .map(|&axis| {
                let positions = logs.iter().flat_map(|l| l.joints.iter().filter(|j| j.axis == axis)).flat_map(|j| &j.p);
                let [lo, hi] = range(positions.copied());
                let held = held.iter().find(|(a, _)| *a == axis).map(|(_, c)| c.clone());
                Joint { axis, center: (lo + hi) / 2.0, half: ((hi - lo) / 2.0).max(1e-9), held }
            })
            .collect();
        let parts = logs
            .into_iter()
            .map(|log| {
                let reversing = log.joints.iter().enumerate().filter(|(_, j)| j.reverses());
                let pairs =
                    reversing.filter_map(|(k, j)| axes.iter().position(|&a| a == j.axis).map(|g| (g, k))).collect();
                let scale = 1.0 / log.sigma_m.max(1e-9);
                let basis = Basis { vectors: Vec::new(), root: Vec::new() };
                let (y, yj, qj, jj) = Default::default();
                Part { log, pairs, basis, y, yy: 0.0, yj, qj, jj, scale }
            })
            .collect();
        Self { joints, parts, with: With { links: true, lags: true, corners: false } }
    }

    pub fn logs(&self) -> impl ExactSizeIterator<Item = &Binned> {
        self.parts.iter().map(|p| &p.log)
    }

    /// Position of the joint `g` in log `l`.
    pub fn local(&self, l: usize, g: usize) -> Option<usize> {
        self.parts[l].pairs.iter().find(|(a, _)| *a == g).map(|(_, k)| *k)
    }

    pub fn roots(&self, l: usize) -> &[f64] {
        &self.parts[l].basis.root
    }

    pub fn basis(&self, l: usize) -> &Basis {
        &self.parts[l].basis
    }

    /// Scale of the residuals of log `l`, 1/m.
    pub fn scale(&self, l: usize) -> f64 {
        self.parts[l].scale
    }

    /// Rank of the nuisances over all logs.
    pub fn rank(&self) -> usize {
        self.parts.iter().map(|p| p.basis.rank()).sum()
    }

    /// Measured values that are used: 3 per bin.
    pub fn measured(&self) -> usize {
        self.parts.iter().map(|p| 3 * p.basis.used()).sum()
    }

    pub fn law<'a>(&'a self, g: usize, v: &'a Values) -> Law<'a> {
        let j = &self.joints[g];
        Law {
            gap: GapLaw { center: j.center, half: j.half, c: &v.c, held: j.held.as_ref() },
            spike: v.spike,
            tau_s: v.tau_s,
        }
    }

    /// Names of the fitted numbers in order.
    pub fn names(&self, values: &[Values], form: &Form) -> Vec<Name> {
        let mut out = Vec::new();
        for (joint, v) in values.iter().enumerate() {
            if self.joints[joint].held.is_none() {
                out.extend((0..v.c.len()).map(|power| Name::Gap { joint, power }));
            }
            if form.sticky[joint] {
                out.push(Name::Spike { joint });
                if !form.shared {
                    out.push(Name::LnTau { joint });
                }
            }
        }
        if form.shared && form.sticky.iter().any(|&s| s) {
            out.push(Name::SharedLnTau);
        }
        out
    }

    /// Makes everything that does not depend on the parameters but on which bins are used, at `values`.
    pub fn set_up(&mut self, values: &[Values]) {
        for l in 0..self.parts.len() {
            let pushed: Vec<Vec<bool>> = (0..self.parts[l].log.joints.len())
                .map(|k| {
                    let part = &self.parts[l];
                    let n = part.log.t_s.len();
                    let mut flags = vec![false; n];
                    if let Some((g, _)) = part.pairs.iter().find(|(_, j)| *j == k) {
                        let mut error = vec![0.0; n];
                        let mut out = Out { error: &mut error, derivatives: None, pushed: Some(&mut flags) };
                        let j = &part.log.joints[k];
                        evaluate(&j.runs, &part.log.t_s, &j.p, &self.law(*g, &values[*g]), &mut out);
                    }
                    flags
                })
                .collect();
            let with = self.with;
            let part = &mut self.parts[l];
            part.basis = basis(&part.log, &pushed, part.scale, with);
            part.reduce();
        }
    }

    /// Error of joint `g` in log `l` per bin; zero where it does not reverse there.
    pub fn error(&self, l: usize, g: usize, v: &Values) -> Vec<f64> {
        let part = &self.parts[l];
        let mut error = vec![0.0; part.log.t_s.len()];
        if let Some(k) = self.local(l, g) {
            let j = &part.log.joints[k];
            let mut out = Out { error: &mut error, derivatives: None, pushed: None };
            evaluate(&j.runs, &part.log.t_s, &j.p, &self.law(g, v), &mut out);
        }
        error
    }

    /// Cost at `values`.
    pub fn cost(&self, values: &[Values]) -> f64 {
        (0..self.parts.len())
            .map(|l| {
                let errors: Vec<Vec<f64>> =
                    self.parts[l].pairs.iter().map(|(g, _)| self.error(l, *g, &values[*g])).collect();
                self.parts[l].cost(&errors)
            })
            .sum()
    }

    /// Cost of trials that change joint `g` alone.
    pub fn cost_of_trials(&self, values: &[Values], g: usize, trials: &[Values]) -> Vec<f64> {
        let mut out = vec![0.0; trials.len()];
        for (l, part) in self.parts.iter().enumerate() {
            let mut errors: Vec<Vec<f64>> = part.pairs.iter().map(|(k, _)| self.error(l, *k, &values[*k])).collect();
            let at = part.pairs.iter().position(|(k, _)| *k == g);
            for (o, trial) in out.iter_mut().zip(trials) {
                if let Some(at) = at {
                    errors[at] = self.error(l, g, trial);
                }
                *o += part.cost(&errors);
            }
        }
        out
    }

    /// Cost, gradient and normal matrix by all names.
    pub fn normal(&self, values: &[Values], form: &Form) -> Normal {
        let names = self.names(values, form);
        let at = |name: Name| names.iter().position(|n| *n == name);
        let mut out = Normal {
            cost: 0.0,
            gradient: DVector::zeros(names.len()),
            matrix: DMatrix::zeros(names.len(), names.len()),
        };
        for part in &self.parts {
            let n = part.log.t_s.len();
            let mut errors = Vec::new();
            let mut blocks: Vec<Block> = Vec::new();
            for (g, k) in &part.pairs {
                let v = &values[*g];
                let law = self.law(*g, v);
                let fitted = law.gap.fitted();
                let width = fitted + 2;
                let mut error = vec![0.0; n];
                let mut der = vec![0.0; n * width];
                let j = &part.log.joints[*k];
                let mut o = Out { error: &mut error, derivatives: Some(&mut der), pushed: None };
                evaluate(&j.runs, &part.log.t_s, &j.p, &law, &mut o);
                errors.push(error);
                // columns that are fitted: (place among the derivatives, factor, place among the names)
                let mut columns = Vec::new();
                for power in 0..fitted {
                    columns.extend(at(Name::Gap { joint: *g, power }).map(|a| (power, 1.0, a)));
                }
                if form.sticky[*g] {
                    columns.extend(at(Name::Spike { joint: *g }).map(|a| (fitted, 1.0, a)));
                    let tau = if form.shared { Name::SharedLnTau } else { Name::LnTau { joint: *g } };
                    columns.extend(at(tau).map(|a| (fitted + 1, v.tau_s, a)));
                }
                let mut packed = vec![0.0; n * columns.len()];
                for i in 0..n {
                    for (c, (place, factor, _)) in columns.iter().enumerate() {
                        packed[i * columns.len() + c] = der[i * width + place] * factor;
                    }
                }
                blocks.push(Block { der: packed, names: columns.iter().map(|c| c.2).collect() });
            }
            out.cost += part.cost(&errors);
            part.add_normal(&errors, &blocks, &mut out);
        }
        out
    }

    /// Weighted residuals of log `l` at `values`, nuisances projected out.
    pub fn residual(&self, l: usize, values: &[Values]) -> Vec<Vector3<f64>> {
        let part = &self.parts[l];
        let mut r = part.y.clone();
        let mut u = vec![0.0; part.basis.rank()];
        for (slot, (g, k)) in part.pairs.iter().enumerate() {
            let e = self.error(l, *g, &values[*g]);
            let j = &part.log.joints[*k].jac;
            for i in 0..r.len() {
                r[i] -= j[i] * (e[i] * part.basis.root[i]);
            }
            part.add_projection(slot, &e, &mut u);
        }
        for (q, u) in part.basis.vectors.iter().zip(&u) {
            for (r, q) in r.iter_mut().zip(q) {
                *r += q * *u;
            }
        }
        r
    }

    /// Moves each log's frame to where it fits best once the lost motion at `values` is taken away. Returns the largest
    /// rotation in rad.
    pub fn move_frames(&mut self, values: &[Values]) -> f64 {
        (0..self.parts.len())
            .map(|l| {
                let (x, _) = self.frame_error(l, values);
                let centre = centroid(&self.parts[l].log.want);
                let turn = Rotation3::new(-Vector3::new(x[3], x[4], x[5]));
                let shift = centre - turn * centre - Vector3::new(x[0], x[1], x[2]);
                let frame_now = &mut self.parts[l].log.frame;
                *frame_now =
                    Isometry3::from_parts(Translation3::from(shift), UnitQuaternion::from_rotation_matrix(&turn))
                        * *frame_now;
                x.fixed_rows::<3>(3).norm()
            })
            .fold(0.0, f64::max)
    }

    /// Rigid motion left in log `l` (translation m, rotation rad) and its covariance for unit noise.
    pub fn frame_error(&self, l: usize, values: &[Values]) -> (nalgebra::Vector6<f64>, Matrix6<f64>) {
        let rest = self.corrected(l, values);
        let log = &self.parts[l].log;
        rigid(&log.want, &rest, &self.parts[l].basis.root, centroid(&log.want))
    }

    /// Measured minus commanded TCP in the world minus what the lost motion explains, m.
    pub fn corrected(&self, l: usize, values: &[Values]) -> Vec<Vector3<f64>> {
        let part = &self.parts[l];
        let mut rest = part.log.deviation();
        for (g, k) in &part.pairs {
            let e = self.error(l, *g, &values[*g]);
            for (r, (j, e)) in rest.iter_mut().zip(part.log.joints[*k].jac.iter().zip(&e)) {
                *r -= j * *e;
            }
        }
        rest
    }
}

fn centroid(points: &[Vector3<f64>]) -> Vector3<f64> {
    points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64
}

impl Problem {
    /// Least-squares half gaps of the joints `g` from the direction of movement alone, everywhere.
    pub fn regress_direction(&self, g: &[usize]) -> Vec<f64> {
        if g.is_empty() {
            return Vec::new();
        }
        let mut h = DMatrix::zeros(g.len(), g.len());
        let mut rhs = DVector::zeros(g.len());
        for part in &self.parts {
            let pairs = part.pairs.len();
            let directions: Vec<Vec<f64>> = part
                .pairs
                .iter()
                .map(|(_, k)| {
                    let mut e = vec![0.0; part.log.t_s.len()];
                    part.log.joints[*k].runs.iter().for_each(|r| e[r.bins.clone()].fill(-r.dir));
                    e
                })
                .collect();
            let project = |slot: usize| {
                let mut u = vec![0.0; part.basis.rank()];
                part.add_projection(slot, &directions[slot], &mut u);
                u
            };
            let projected: Vec<Vec<f64>> = (0..pairs).map(project).collect();
            for (a, (ga, _)) in part.pairs.iter().enumerate() {
                let Some(i) = g.iter().position(|x| x == ga) else { continue };
                rhs[i] += directions[a].iter().zip(&part.yj[a]).map(|(e, y)| e * y).sum::<f64>();
                for (b, (gb, _)) in part.pairs.iter().enumerate() {
                    let Some(j) = g.iter().position(|x| x == gb) else { continue };
                    let jj = &part.jj[a * pairs + b];
                    h[(i, j)] +=
                        directions[a].iter().zip(&directions[b]).zip(jj).map(|((x, y), j)| x * y * j).sum::<f64>();
                    h[(i, j)] -= projected[a].iter().zip(&projected[b]).map(|(x, y)| x * y).sum::<f64>();
                }
            }
        }
        let svd = h.svd(true, true);
        svd.solve(&rhs, 1e-12 * svd.singular_values.max())
            .map_or_else(|_| vec![0.0; g.len()], |x| x.as_slice().to_vec())
    }
}
