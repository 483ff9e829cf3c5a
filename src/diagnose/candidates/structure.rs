//! Is there structure in the residual that no effect was asked for? A test without the catalogue.
//!
//! Method: per moving joint splines over position for both directions together and for their difference, terms in speed
//! and acceleration, tails after reversals of three lengths; splines over time; the linear geometry. All of it is
//! whitened, taken off the tangent of the fitted effects, and tested as a whole and in groups with F ratios. The whole is
//! also what the first noise estimate is freed of: a noise model fitted to a residual with structure would swallow it.
//!
//! Assumptions: structure is a smooth function of one joint at a time, or of time. What it sees is reported by joint and
//! aspect; what depends on several joints at once it sees only in part.

use crate::diagnose::candidates::basis::{Aspect, BasisGroup, MOST_SPLINES, splines_at};
use crate::diagnose::candidates::screen::{SWALLOWED, ScreeningContext};
use crate::diagnose::candidates::{self, Candidate, held};
use crate::diagnose::problem::forward::{Hypothesis, Problem, State};
use crate::diagnose::problem::normal::dot;
use crate::effects::Track;
use crate::machine::CommandTrajectory;
use crate::numerics::fisher;
use crate::numerics::parallel::{self, ParMap};
use crate::numerics::robust::range;
use nalgebra::{DMatrix, DVector, Vector3};

/// Observations per basis function, at least.
const PER_FUNCTION: usize = 25;

/// The basis at a hypothesis: raw sensitivities in the long vector.
pub fn basis(problem: &Problem, h: &Hypothesis, state: &State, list: &[Candidate]) -> Vec<BasisGroup> {
    let moving: Vec<usize> = (0..problem.robot.dof())
        .filter(|&a| {
            problem.logs.iter().any(|l| l.log.travel(a) > 1e-3 * problem.robot.axis(a).kind.si_per_user_unit())
        })
        .collect();
    let room = problem.n / PER_FUNCTION;
    let per_joint = room / moving.len().max(1);
    let splines = (per_joint / 2).clamp(3, MOST_SPLINES);
    let odd = (splines / 2).max(2);
    let mut groups: Vec<BasisGroup> =
        moving.par_map(|&axis| groups_of_joint(problem, state, axis, splines, odd)).into_iter().flatten().collect();
    groups.extend(held::groups(problem, state));
    if let Some((_, length)) = candidates::clock(problem) {
        if room > 40 * moving.len() {
            groups.extend(moving.par_map(|&axis| slip_group(problem, state, axis)));
        }
        let functions = ((length / 8.0) as usize).clamp(4, 14).min((room / 8).max(2));
        groups.push(time_group(problem, functions));
    }
    let linear: Vec<&Candidate> = list.iter().filter(|c| c.depends_on_pose()).collect();
    if linear.len() * PER_FUNCTION < problem.n {
        let columns = linear.par_map(|c| c.columns(problem, h, state)).into_iter().flatten().collect();
        groups.push(BasisGroup { axis: None, aspect: Aspect::Geometry, columns });
    }
    groups
}

fn groups_of_joint(problem: &Problem, state: &State, axis: usize, splines: usize, odd: usize) -> Vec<BasisGroup> {
    let joint = JointBasis::new(problem, state, axis);
    let mut groups = vec![
        joint.group(Aspect::Position, joint.splines(splines, false)),
        joint.group(Aspect::Direction, joint.splines(odd, true)),
    ];
    let Some((step, length)) = candidates::clock(problem) else { return groups };
    let (speed, acceleration) = joint.powers_of_speed();
    groups.push(joint.group(Aspect::Speed, speed));
    groups.push(joint.group(Aspect::Acceleration, vec![acceleration]));
    if joint.tracks.iter().any(|t| !t.turns.is_empty()) {
        let tails = [3.0 * step, 12.0 * step, (48.0 * step).min(length / 4.0)].map(|tau_s| joint.tail(tau_s));
        groups.push(joint.group(Aspect::SinceReversal, tails.into()));
    }
    groups
}

/// What the columns of one joint are made of.
struct JointBasis<'a> {
    problem: &'a Problem,
    state: &'a State,
    axis: usize,
    tracks: Vec<Track<'a>>,
}

impl<'a> JointBasis<'a> {
    fn new(problem: &'a Problem, state: &'a State, axis: usize) -> Self {
        let track = |d: &'a CommandTrajectory| Track::new(d.t_s(), d.command(axis), d.deadband(axis).max(1e-9));
        let tracks = problem.logs.iter().map(|l| track(&l.trajectory)).collect();
        Self { problem, state, axis, tracks }
    }

    fn group(&self, aspect: Aspect, columns: Vec<Vec<f64>>) -> BasisGroup {
        BasisGroup { axis: Some(self.axis), aspect, columns }
    }

    /// What a change of the joint by `value(log, row)` does to everything measured.
    fn column(&self, value: &dyn Fn(usize, usize) -> f64) -> Vec<f64> {
        let mut out = vec![0.0; self.problem.n];
        for l in 0..self.problem.logs.len() {
            self.problem.add_joint_change(self.state, l, self.axis, &|r| value(l, r), None, &mut out);
        }
        out
    }

    /// Lowest and highest command in all logs.
    fn range(&self) -> [f64; 2] {
        range(self.problem.logs.iter().flat_map(|l| l.trajectory.command(self.axis).iter().copied()))
    }

    /// `n` splines over the joint's range, or times its direction; the values of all at each row are computed once.
    fn splines(&self, n: usize, by_direction: bool) -> Vec<Vec<f64>> {
        let [lo, hi] = self.range();
        let table = |t: &Track| -> Vec<f64> {
            let mut values = vec![0.0; n * t.len()];
            for ((&p, &d), row) in t.p.iter().zip(t.dir.iter()).zip(values.chunks_exact_mut(n)) {
                splines_at(p, lo, hi, n, row);
                if by_direction {
                    row.iter_mut().for_each(|v| *v *= f64::from(d));
                }
            }
            values
        };
        let tables: Vec<Vec<f64>> = self.tracks.iter().map(table).collect();
        (0..n).map(|k| self.column(&|l, r| tables[l][r * n + k])).collect()
    }

    /// Speed to its third power, even and odd, relative to the largest; and the acceleration.
    fn powers_of_speed(&self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let logs = &self.problem.logs;
        let slopes: Vec<Vec<f64>> =
            logs.iter().map(|l| crate::machine::slopes(l.trajectory.t_s(), l.trajectory.command(self.axis))).collect();
        let bends: Vec<Vec<f64>> =
            logs.iter().zip(&slopes).map(|(l, v)| crate::machine::slopes(l.trajectory.t_s(), v)).collect();
        let top = slopes.iter().flatten().fold(1e-300_f64, |m, v| m.max(v.abs()));
        let speed: [&dyn Fn(usize, usize) -> f64; 4] = [
            &|l, r| slopes[l][r] / top,
            &|l, r| (slopes[l][r] / top).powi(2),
            &|l, r| slopes[l][r] * slopes[l][r].abs() / (top * top),
            &|l, r| (slopes[l][r] / top).powi(3),
        ];
        (speed.iter().map(|f| self.column(f)).collect(), self.column(&|l, r| bends[l][r]))
    }

    /// What fades over `tau_s` after each reversal.
    fn tail(&self, tau_s: f64) -> Vec<f64> {
        let table = |t: &Track| -> Vec<f64> {
            let mut v = vec![0.0; t.len()];
            for (turn, rows) in t.strokes() {
                for r in rows {
                    v[r] = f64::from(turn.dir) * (-(t.t_s[r] - turn.t_s) / tau_s).exp();
                }
            }
            v
        };
        let tables: Vec<Vec<f64>> = self.tracks.iter().map(table).collect();
        self.column(&|l, r| tables[l][r])
    }
}

/// Splines over time of one joint: a slip, a creep.
const SLIPS: usize = 8;

fn slip_group(problem: &Problem, state: &State, axis: usize) -> BasisGroup {
    let columns = (0..SLIPS)
        .map(|k| {
            let mut out = vec![0.0; problem.n];
            let mut values = [0.0; SLIPS];
            for (l, log) in problem.logs.iter().enumerate() {
                let t = log.trajectory.t_s();
                let (lo, hi) = (t[0], t[t.len() - 1]);
                let table: Vec<f64> = t
                    .iter()
                    .map(|&t| {
                        splines_at(t, lo, hi, SLIPS, &mut values);
                        values[k]
                    })
                    .collect();
                problem.add_joint_change(state, l, axis, &|r| table[r], None, &mut out);
            }
            out
        })
        .collect();
    BasisGroup { axis: Some(axis), aspect: Aspect::Time, columns }
}

fn time_group(problem: &Problem, functions: usize) -> BasisGroup {
    let mut columns = Vec::new();
    let mut values = vec![0.0; functions];
    for k in 0..functions {
        for c in 0..3 {
            let mut out = vec![0.0; problem.n];
            for g in &problem.groups {
                let t = problem.logs[g.log].trajectory.t_s();
                let (lo, hi) = (t[0], t[t.len() - 1]);
                // a drift of a single reading is one column
                if g.sensor.is_length() && c < g.dims {
                    let table: Vec<f64> = t
                        .iter()
                        .map(|&t| {
                            splines_at(t, lo, hi, functions, &mut values);
                            values[k]
                        })
                        .collect();
                    match g.dims {
                        1 => g.add_numbers(&mut out, |r| table[r]),
                        _ => g.add_points(&mut out, |r| Vector3::ith(c, table[r])),
                    }
                }
            }
            columns.push(out);
        }
    }
    BasisGroup { axis: None, aspect: Aspect::Time, columns }
}

/// Outcome for one group, or for all together.
#[derive(Debug, Clone)]
pub struct Ratio {
    pub axis: Option<usize>,
    pub aspect: Option<Aspect>,
    /// Gain in 2 ln L.
    pub gain: f64,
    pub dof: usize,
    pub p_value: f64,
}

/// The basis whitened, projected and factored in one context: tests, and the residual freed of it.
pub struct Tested {
    pub whole: Ratio,
    pub groups: Vec<Ratio>,
    /// Residual without what the tangent and the whole basis explain, in the long vector (not whitened).
    pub freed: Vec<f64>,
}

/// Tests the residual of `context` with the basis.
pub fn test(context: &ScreeningContext, groups: &[BasisGroup]) -> Tested {
    let raw: Vec<&Vec<f64>> = groups.iter().flat_map(|b| &b.columns).collect();
    let mut columns: Vec<Vec<f64>> = raw.iter().map(|c| (*c).clone()).collect();
    let size = columns.len().div_ceil(2 * parallel::threads());
    parallel::change_pieces(&mut columns, size, |_, part| {
        let before = context.project(part);
        for (c, before) in part.iter_mut().zip(before) {
            // what the tangent swallows is rounding
            if dot(c, c) < SWALLOWED * before {
                c.fill(0.0);
            }
        }
    });
    let normal = product(&columns);
    let right = DVector::from_iterator(columns.len(), columns.par_map(|c| dot(c, &context.residual)));
    let n = context.residual.len() as f64;
    let rss = dot(&context.residual, &context.residual);
    let ratio = |gain: f64, dof: usize, axis, aspect| {
        let left = (n - dof as f64).max(1.0);
        let f = (gain / dof.max(1) as f64) / ((rss - gain).max(1e-300) / left);
        Ratio { axis, aspect, gain, dof, p_value: fisher::tail(f, dof as f64, left) }
    };
    let (solution, gain, dof) = solve(&normal, &right, &(0..columns.len()).collect::<Vec<_>>());
    let whole = ratio(gain, dof, None, None);
    let mut at = 0;
    let tested = groups
        .iter()
        .map(|b| {
            let pick: Vec<usize> = (at..at + b.columns.len()).collect();
            at += b.columns.len();
            let (_, gain, dof) = solve(&normal, &right, &pick);
            ratio(gain, dof, b.axis, Some(b.aspect))
        })
        .collect();
    let mut freed = context.residual.clone();
    for (c, s) in columns.iter().zip(solution.iter()) {
        if *s != 0.0 {
            for (f, v) in freed.iter_mut().zip(c) {
                *f -= s * v;
            }
        }
    }
    context.whitening.undo(context.problem, &mut freed);
    Tested { whole, groups: tested, freed }
}

/// Normal matrix by blocks, in a fixed order: the lower triangle is computed.
fn product(columns: &[Vec<f64>]) -> DMatrix<f64> {
    let k = columns.len();
    let n = columns.first().map_or(0, Vec::len);
    const PIECE: usize = 1024;
    const PANEL: usize = 48;
    let pieces: Vec<usize> = (0..n).step_by(PIECE).collect();
    let quarters: Vec<&[usize]> = pieces.chunks(pieces.len().div_ceil(4).max(1)).collect();
    let parts: Vec<DMatrix<f64>> = quarters.par_map(|starts| {
        let mut sum = DMatrix::zeros(k, k);
        for &s in *starts {
            let e = (s + PIECE).min(n);
            // both ways round: the library multiplies by blocks only without a transpose
            let a = DMatrix::from_fn(e - s, k, |i, j| columns[j][s + i]);
            let t = a.transpose();
            for from in (0..k).step_by(PANEL) {
                let width = PANEL.min(k - from);
                let below = t.rows_range(from..);
                sum.view_mut((from, from), (k - from, width)).gemm(1.0, &below, &a.columns(from, width), 1.0);
            }
        }
        sum
    });
    let mut whole = parts.into_iter().fold(DMatrix::zeros(k, k), |a, b| a + b);
    whole.fill_upper_triangle_with_lower_triangle();
    whole
}

/// Share of a function's squared norm that must be its own beside those taken before it.
const OWN: f64 = 1e-7;

/// Solution, gain and rank for the chosen columns, by a Cholesky factorisation of the scaled normal matrix that takes the
/// function with the largest part that no other has next and leaves out those with nothing.
fn solve(normal: &DMatrix<f64>, right: &DVector<f64>, pick: &[usize]) -> (DVector<f64>, f64, usize) {
    let mut solution = DVector::zeros(normal.nrows());
    let k = pick.len();
    let d: Vec<f64> =
        pick.iter().map(|&i| if normal[(i, i)] > 0.0 { 1.0 / normal[(i, i)].sqrt() } else { 0.0 }).collect();
    let mut own: Vec<f64> = d.iter().map(|d| if *d > 0.0 { 1.0 } else { 0.0 }).collect();
    let mut factor = DMatrix::<f64>::zeros(k, k);
    let (mut order, mut forward) = (Vec::with_capacity(k), Vec::with_capacity(k));
    let mut taken = vec![false; k];
    for rank in 0..k {
        let free = (0..k).filter(|&i| !taken[i] && own[i] > OWN);
        let Some(next) = free.max_by(|&a, &b| own[a].total_cmp(&own[b]).then(b.cmp(&a))) else { break };
        let pivot = own[next].sqrt();
        let mut column = DVector::from_fn(k, |i, _| normal[(pick[i], pick[next])] * d[i] * d[next]);
        let row = DVector::from_iterator(rank, (0..rank).map(|j| factor[(next, j)]));
        column.gemv(-1.0, &factor.columns(0, rank), &row, 1.0);
        let share = (right[pick[next]] * d[next] - row.dot(&DVector::from_column_slice(&forward))) / pivot;
        taken[next] = true;
        for i in 0..k {
            let v = if taken[i] && i != next { 0.0 } else { column[i] / pivot };
            factor[(i, rank)] = v;
            own[i] -= v * v;
        }
        order.push(next);
        forward.push(share);
    }
    for rank in (0..order.len()).rev() {
        let x = (forward[rank]
            - (rank + 1..order.len())
                .map(|j| factor[(order[j], rank)] * solution[pick[order[j]]] / d[order[j]])
                .sum::<f64>())
            / factor[(order[rank], rank)];
        solution[pick[order[rank]]] = x * d[order[rank]];
    }
    (solution, forward.iter().map(|f| f * f).sum(), order.len())
}

/// Fills nothing but names: a group in words.
pub fn described(ratio: &Ratio, problem: &Problem) -> String {
    match (ratio.axis, ratio.aspect) {
        (Some(a), Some(aspect)) => format!("{} of {}", aspect.text(), problem.robot.axis(a).name),
        (None, Some(aspect)) => aspect.text().into(),
        (Some(a), None) => {
            format!("one effect found several times on {}: one shape split into parts", problem.robot.axis(a).name)
        }
        _ => "nothing in particular".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_that_others_make_up_is_left_out_and_the_gain_is_that_of_the_others() {
        let a: Vec<f64> = (0..40).map(|i| (f64::from(i) * 0.3).sin()).collect();
        let b: Vec<f64> = (0..40).map(|i| (f64::from(i) * 0.11).cos()).collect();
        let both: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 2.0 * a - b).collect();
        let y: Vec<f64> = (0..40).map(|i| 3.0 * a[i] + 0.5 * b[i] + (i as f64 * 1.7).sin()).collect();
        let columns = vec![a.clone(), both, vec![0.0; 40], b.clone()];
        let normal = product(&columns);
        let right = DVector::from_iterator(4, columns.iter().map(|c| dot(c, &y)));
        let (solution, gain, rank) = solve(&normal, &right, &[0, 1, 2, 3]);
        assert_eq!(rank, 2);
        // the two normal equations by hand
        let (aa, ab, bb, ay, by) = (dot(&a, &a), dot(&a, &b), dot(&b, &b), dot(&a, &y), dot(&b, &y));
        let det = aa * bb - ab * ab;
        let (x, z) = ((bb * ay - ab * by) / det, (aa * by - ab * ay) / det);
        assert!((gain - (x * ay + z * by)).abs() < 1e-6 * gain, "{gain}");
        let found: Vec<f64> = (0..40).map(|i| (0..4).map(|c| solution[c] * columns[c][i]).sum()).collect();
        assert!((0..40).all(|i| (found[i] - x * a[i] - z * b[i]).abs() < 1e-6), "{solution}");
        let (alone, gain, rank) = solve(&normal, &right, &[3]);
        assert!(rank == 1 && (gain - by * by / bb).abs() < 1e-9 * gain && (alone[3] - by / bb).abs() < 1e-9);
    }
}
