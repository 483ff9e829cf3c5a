//! Functions over the measured torque of joints that are held, for the test without the catalogue.
//!
//! A joint whose command is stationary shows its wind-up alone. Splines over the torque, and the same with the sign of its change, stand
//! for any curve and any loop of it; of a moving joint the torque follows speed and position, which have their own functions.

use crate::diagnose::candidates::basis::{Aspect, BasisGroup, splines_at};
use crate::diagnose::problem::forward::{Problem, State};
use crate::effects::Inputs;
use crate::numerics::robust::range;

/// Splines over the torque, and over the torque with the sign of its change.
const CURVE: usize = 8;
const LOOP: usize = 6;

/// Both kinds for every held joint whose torque changes.
pub fn groups(problem: &Problem, state: &State) -> Vec<BasisGroup> {
    let held = |a: usize| {
        let still = 1e-3 * problem.robot.axis(a).kind.si_per_user_unit();
        problem.logs.iter().all(|l| l.log.travel(a) <= still)
    };
    (0..problem.robot.dof()).filter(|&a| held(a)).filter_map(|a| group(problem, state, a)).collect()
}

fn group(problem: &Problem, state: &State, axis: usize) -> Option<BasisGroup> {
    let torques: Vec<&[f64]> =
        problem.logs.iter().map(|l| l.trajectory.measured_torque(axis).unwrap_or_default()).collect();
    let [lo, hi] = range(torques.iter().copied().flatten().copied());
    if hi.is_nan() || hi <= lo {
        return None;
    }
    let signs: Vec<Vec<f64>> = torques.iter().map(|t| rising(t)).collect();
    let column = |k: usize, n: usize, signed: bool| {
        let mut out = vec![0.0; problem.n];
        for (l, torque) in torques.iter().enumerate().filter(|(_, t)| !t.is_empty()) {
            let mut values = vec![0.0; n];
            let table: Vec<f64> = torque
                .iter()
                .zip(&signs[l])
                .map(|(&t, sign)| {
                    splines_at(t, lo, hi, n, &mut values);
                    if signed { sign * values[k] } else { values[k] }
                })
                .collect();
            problem.add_joint_change(state, l, axis, &|r| table[r], None, &mut out);
        }
        out
    };
    let columns = (0..CURVE).map(|k| column(k, CURVE, false)).chain((0..LOOP).map(|k| column(k, LOOP, true)));
    Some(BasisGroup { axis: Some(axis), aspect: Aspect::Torque, columns: columns.collect() })
}

/// Sign of the last change of a series, row by row; 0 before the first.
fn rising(values: &[f64]) -> Vec<f64> {
    let mut sign = 0.0;
    let mut before = values.first().copied().unwrap_or(0.0);
    let mut one = |v: &f64| {
        let step = v - before;
        before = *v;
        if step != 0.0 {
            sign = step.signum();
        }
        sign
    };
    values.iter().map(&mut one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_of_the_last_change_holds_where_the_torque_stays() {
        assert_eq!(rising(&[1.0, 1.0, 2.0, 2.0, 1.5, 1.5, 3.0]), [0.0, 0.0, 1.0, 1.0, -1.0, -1.0, 1.0]);
        assert!(rising(&[]).is_empty());
    }
}
