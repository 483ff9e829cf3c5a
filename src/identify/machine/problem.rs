//! The joint estimation as one least-squares problem: laws of all joints, nuisances of all logs, priors, noise.
//!
//! Every log gives whitened residuals and whitened columns; normal equations add up over the logs in their order. The laws are
//! linear but for the presliding and the side on which a play is touched, so Gauss-Newton with a damping that grows where a
//! step does not help settles in a few rounds.

use super::bins::BinnedLog;
use super::law::{JointLaw, Response, SPIKES, WINDUPS};
use super::noise::Noise;
use super::nuisance::{self, Column, Name, Ripple};
use super::spline::Spline;
use crate::numerics::parallel::ParMap;
use crate::robot::Robot;
use nalgebra::{DMatrix, DVector, Vector3};

/// Size of lost motion at the TCP that priors and starting values assume, m.
const TYPICAL_M: f64 = 30e-6;

/// A log with its columns.
pub struct LogColumns {
    /// Global number of each nuisance column.
    pub index: Vec<usize>,
    pub values: Vec<Vec<Vector3<f64>>>,
    /// The same, whitened: three stretches of bins, one per principal direction.
    pub white: DMatrix<f64>,
    /// Products of the whitened columns with each other: they change with the noise only.
    products: DMatrix<f64>,
}

/// The problem and its present estimate.
pub struct Problem<'a> {
    pub robot: &'a Robot,
    pub logs: Vec<BinnedLog>,
    pub splines: Vec<Spline>,
    /// Law of each axis; `None` where it never moves.
    pub laws: Vec<Option<JointLaw>>,
    /// Root mean square lever of each axis, m per rad or m.
    pub levers: Vec<f64>,
    pub names: Vec<Name>,
    pub sigmas: Vec<f64>,
    pub columns: Vec<LogColumns>,
    pub nuisances: Vec<f64>,
    pub noise: Vec<Noise>,
    /// Bins that do not count, per log: not measured, discarded, or before the joints have settled.
    pub unused: Vec<Vec<bool>>,
    /// Lost motion of each axis as priors assume it, rad or m.
    pub sizes: Vec<f64>,
    /// Values about which the laws' parameters are estimated, where they are corrections of known ones.
    pub centre: Option<Vec<f64>>,
    /// Axes whose gap is held constant over position.
    pub constant: Vec<bool>,
}

/// One log's part: the whitened residual, its columns and which global parameters they belong to.
pub struct Part {
    pub index: Vec<usize>,
    pub design: DMatrix<f64>,
    pub residual: DVector<f64>,
}

/// Sums over the logs.
pub struct Normal {
    pub hessian: DMatrix<f64>,
    pub gradient: DVector<f64>,
    pub cost: f64,
}

impl<'a> Problem<'a> {
    pub fn new(robot: &'a Robot, logs: Vec<BinnedLog>, splines: Vec<Spline>) -> Self {
        let axes = robot.dof();
        let mut levers = vec![0.0f64; axes];
        let mut laws = vec![None; axes];
        for axis in 0..axes {
            let with: Vec<&BinnedLog> = logs.iter().filter(|l| l.moving.iter().any(|m| m.0 == axis)).collect();
            if with.is_empty() {
                continue;
            }
            levers[axis] = with.iter().map(|l| nuisance::lever(l, axis)).fold(0.0, f64::max);
            let size = TYPICAL_M / levers[axis];
            laws[axis] = Some(JointLaw {
                gap: vec![size; splines[axis].knots()],
                spikes: [0.0; SPIKES],
                windups: [0.0; WINDUPS],
                presliding: size,
            });
        }
        let unused = logs.iter().map(|l| l.missing.clone()).collect();
        let noise = logs.iter().map(|l| Noise::first(&l.deviation_m, &l.missing)).collect();
        let mut problem = Self {
            robot,
            splines,
            laws,
            centre: None,
            sizes: levers.iter().map(|l| TYPICAL_M / l.max(1e-3)).collect(),
            levers,
            names: Vec::new(),
            sigmas: Vec::new(),
            columns: Vec::new(),
            nuisances: Vec::new(),
            noise,
            unused,
            constant: vec![false; axes],
            logs,
        };
        let columns = nuisance::of_logs(&problem.logs, robot, &[]);
        problem.columns = problem
            .logs
            .iter()
            .map(|_| LogColumns {
                index: Vec::new(),
                values: Vec::new(),
                white: DMatrix::zeros(0, 0),
                products: DMatrix::zeros(0, 0),
            })
            .collect();
        for (l, c) in columns.into_iter().enumerate() {
            problem.add_columns(l, c);
        }
        problem.whiten_columns();
        problem
    }

    /// Adds nuisance columns of a log; those that other logs have already share their parameter.
    pub fn add_columns(&mut self, log: usize, columns: Vec<Column>) {
        for c in columns {
            let at = self.names.iter().position(|n| *n == c.name).unwrap_or_else(|| {
                self.names.push(c.name);
                self.sigmas.push(c.sigma);
                self.nuisances.push(0.0);
                self.names.len() - 1
            });
            self.columns[log].index.push(at);
            self.columns[log].values.push(c.values);
        }
    }

    /// Adds ripples to all logs.
    pub fn add_ripples(&mut self, ripples: &[Ripple], first: usize) {
        for l in 0..self.logs.len() {
            let columns = nuisance::of_ripples(&self.logs[l], ripples, first);
            self.add_columns(l, columns);
        }
        self.whiten_columns();
    }

    /// Sets the sizes that priors assume to what has been estimated: gap, wind-up and spikes together.
    pub fn refresh_sizes(&mut self) {
        for (axis, law) in self.laws.iter().enumerate() {
            let Some(law) = law else { continue };
            let gap = law.gap.iter().sum::<f64>() / law.gap.len() as f64;
            let total = gap + law.windup() + law.spikes.iter().sum::<f64>();
            self.sizes[axis] = total.abs().max(0.1 * TYPICAL_M / self.levers[axis]);
        }
    }

    /// Numbers of the parameters that cannot be negative: gaps, spikes and wind-ups.
    pub fn not_negative(&self) -> Vec<usize> {
        let of = |axis: usize, law: &JointLaw| {
            let first = self.offset(axis);
            first..first + law.gap.len() + SPIKES + WINDUPS
        };
        self.laws.iter().enumerate().filter_map(|(a, l)| Some(of(a, l.as_ref()?))).flatten().collect()
    }

    /// Numbers of all parameters of friction.
    pub fn friction(&self) -> Vec<usize> {
        let of = |axis: usize, law: &JointLaw| self.offset(axis) + law.gap.len()..self.offset(axis) + law.parameters();
        self.laws.iter().enumerate().filter_map(|(a, l)| Some(of(a, l.as_ref()?))).flatten().collect()
    }

    /// First global number of the parameters of an axis.
    pub fn offset(&self, axis: usize) -> usize {
        self.laws[..axis].iter().flatten().map(JointLaw::parameters).sum()
    }

    /// Number of parameters of all laws.
    pub fn lost(&self) -> usize {
        self.laws.iter().flatten().map(JointLaw::parameters).sum()
    }

    /// Number of all parameters.
    pub fn len(&self) -> usize {
        self.lost() + self.names.len()
    }

    /// All parameters as one vector.
    pub fn values(&self) -> DVector<f64> {
        let mut v: Vec<f64> = self.laws.iter().flatten().flat_map(JointLaw::to_vec).collect();
        v.extend(&self.nuisances);
        DVector::from_vec(v)
    }

    pub fn set_values(&mut self, v: &DVector<f64>) {
        let mut at = 0;
        for law in self.laws.iter_mut().flatten() {
            let n = law.parameters();
            *law = JointLaw::from_slice(&v.as_slice()[at..at + n]);
            at += n;
        }
        self.nuisances.copy_from_slice(&v.as_slice()[at..]);
    }

    /// Whitens a vector of bins into three stretches.
    pub fn whiten(&self, log: usize, values: &[Vector3<f64>], out: &mut [f64]) {
        self.whiten_from(log, 0, values, out);
    }

    /// Whitens `values` of the bins from `from`, as if they were zero before; the first of them, as many as the noise has lags, become
    /// zero.
    pub fn whiten_from(&self, log: usize, from: usize, values: &[Vector3<f64>], out: &mut [f64]) {
        let n = values.len();
        let noise = &self.noise[log];
        let mut history = Vec::with_capacity(n);
        for c in 0..3 {
            let row = noise.rotation.row(c);
            let part = &mut out[c * n..(c + 1) * n];
            for (o, v) in part.iter_mut().zip(values) {
                *o = row[0] * v.x + row[1] * v.y + row[2] * v.z;
            }
            noise.along[c].whiten(part, &self.unused[log][from..from + n], &mut history);
        }
    }

    /// Whitens all nuisance columns by the present noise.
    pub fn whiten_columns(&mut self) {
        let white: Vec<(DMatrix<f64>, DMatrix<f64>)> = (0..self.logs.len()).par_map(|l| {
            let (n, c) = (self.logs[l].len(), &self.columns[l]);
            let mut m = DMatrix::zeros(3 * n, c.values.len());
            for (k, values) in c.values.iter().enumerate() {
                self.whiten(l, values, m.column_mut(k).as_mut_slice());
            }
            let products = m.transpose() * &m;
            (m, products)
        });
        for (c, (white, products)) in self.columns.iter_mut().zip(white) {
            c.white = white;
            c.products = products;
        }
    }

    /// Responses of the joints that move in a log.
    pub fn responses(&self, log: usize, derivatives: bool) -> Vec<(usize, Response)> {
        let with_law = self.logs[log].moving.iter().filter_map(|(a, rows)| Some((*a, rows, self.laws[*a].as_ref()?)));
        with_law.map(|(a, rows, law)| (a, rows.respond(law, derivatives))).collect()
    }

    /// What the joints' errors do to the TCP, bin by bin.
    pub fn lost_motion(&self, log: usize, responses: &[(usize, Response)]) -> Vec<Vector3<f64>> {
        let l = &self.logs[log];
        let mut out = vec![Vector3::zeros(); l.len()];
        let mut column = Vec::new();
        for (axis, r) in responses {
            l.average(&r.error, &mut column);
            for ((o, j), e) in out.iter_mut().zip(&l.sensitivity).zip(&column) {
                *o += j[*axis] * *e;
            }
        }
        out
    }

    /// Residual of a log in metres, bin by bin: measured less everything that is estimated.
    pub fn residual(&self, log: usize, responses: &[(usize, Response)]) -> Vec<Vector3<f64>> {
        let mut out = self.lost_motion(log, responses);
        for (o, d) in out.iter_mut().zip(&self.logs[log].deviation_m) {
            *o = d - *o;
        }
        let c = &self.columns[log];
        for (&at, values) in c.index.iter().zip(&c.values) {
            let x = self.nuisances[at];
            if x != 0.0 {
                out.iter_mut().zip(values).for_each(|(o, v)| *o -= v * x);
            }
        }
        out
    }

    /// The same, whitened; the nuisances' columns are already.
    fn white_residual(&self, log: usize, responses: &[(usize, Response)]) -> DVector<f64> {
        let mut left = self.lost_motion(log, responses);
        for (o, d) in left.iter_mut().zip(&self.logs[log].deviation_m) {
            *o = d - *o;
        }
        let mut white = DVector::zeros(3 * left.len());
        self.whiten(log, &left, white.as_mut_slice());
        let c = &self.columns[log];
        let values = DVector::from_iterator(c.index.len(), c.index.iter().map(|&i| self.nuisances[i]));
        white.gemv(-1.0, &c.white, &values, 1.0);
        white
    }

    /// A log's whitened columns of the laws, their parameters, and its whitened residual.
    fn lost_part(&self, log: usize) -> Part {
        let responses = self.responses(log, true);
        let white = self.white_residual(log, &responses);
        let l = &self.logs[log];
        let n = l.len();
        let lost: usize = responses.iter().map(|r| r.1.by.len()).sum();
        let mut design = DMatrix::zeros(3 * n, lost);
        let mut index = Vec::with_capacity(lost);
        let (mut column, mut values) = (Vec::new(), vec![Vector3::zeros(); n]);
        for (axis, r) in &responses {
            for (k, by) in r.by.iter().enumerate() {
                l.average(by, &mut column);
                for ((v, j), d) in values.iter_mut().zip(&l.sensitivity).zip(&column) {
                    *v = j[*axis] * *d;
                }
                self.whiten(log, &values, design.column_mut(index.len()).as_mut_slice());
                index.push(self.offset(*axis) + k);
            }
        }
        Part { index, design, residual: white }
    }

    /// A log's part of the problem at the present estimate: laws and nuisances.
    pub fn part(&self, log: usize) -> Part {
        let Part { mut index, design: laws, residual } = self.lost_part(log);
        let nuisances = &self.columns[log];
        let (lost, first) = (laws.ncols(), self.lost());
        let mut design = DMatrix::zeros(laws.nrows(), lost + nuisances.index.len());
        design.columns_mut(0, lost).copy_from(&laws);
        design.columns_mut(lost, nuisances.index.len()).copy_from(&nuisances.white);
        index.extend(nuisances.index.iter().map(|i| first + i));
        Part { index, design, residual }
    }

    /// Whitened cost at the present estimate, priors included.
    pub fn cost(&self) -> f64 {
        let costs: Vec<f64> =
            (0..self.logs.len()).par_map(|l| self.white_residual(l, &self.responses(l, false)).norm_squared());
        let (prior, by) = self.prior();
        let v = self.values();
        let d = &v - &by;
        costs.iter().sum::<f64>() + d.dot(&(&prior * &d))
    }

    /// Normal equations at the present estimate.
    pub fn normal(&self) -> Normal {
        let n = self.len();
        // columns, products, right-hand side and cost of each log
        type Part = (Vec<usize>, DMatrix<f64>, DVector<f64>, f64);
        let parts: Vec<Part> = (0..self.logs.len()).par_map(|l| {
            let p = self.lost_part(l);
            let c = &self.columns[l];
            let (lost, own) = (p.design.ncols(), c.index.len());
            let mut h = DMatrix::zeros(lost + own, lost + own);
            let transposed = p.design.transpose();
            let mixed = &transposed * &c.white;
            h.view_mut((0, 0), (lost, lost)).copy_from(&(&transposed * &p.design));
            h.view_mut((lost, 0), (own, lost)).copy_from(&mixed.transpose());
            h.view_mut((0, lost), (lost, own)).copy_from(&mixed);
            h.view_mut((lost, lost), (own, own)).copy_from(&c.products);
            let mut g = DVector::zeros(lost + own);
            g.rows_mut(0, lost).copy_from(&p.design.tr_mul(&p.residual));
            g.rows_mut(lost, own).copy_from(&c.white.tr_mul(&p.residual));
            let mut index = p.index;
            index.extend(c.index.iter().map(|i| self.lost() + i));
            (index, h, g, p.residual.norm_squared())
        });
        let (mut hessian, about) = self.prior();
        let d = about - self.values();
        let mut gradient = &hessian * &d;
        let mut cost = d.dot(&gradient);
        for (index, h, g, c) in parts {
            for (i, &gi) in index.iter().enumerate() {
                gradient[gi] += g[i];
                for (k, &gk) in index.iter().enumerate() {
                    hessian[(gi, gk)] += h[(i, k)];
                }
            }
            cost += c;
        }
        debug_assert_eq!(hessian.nrows(), n);
        Normal { hessian, gradient, cost }
    }
}
