//! Errors on rows: root mean squares of position and velocity (Cursi (2022) Table II), of any kinematics.
//!
//! The nominal kinematics is measured in the frame that fits the training rows best (Kabsch), as a tracker's frame is not known
//! here: what is left is what no rigid transform explains.

use super::data::Row;
use super::{Learned, Nominal, Rmse};
use crate::log::registration::{Pair, register};
use crate::robot::Robot;
use nalgebra::Vector3;

/// Velocity of the learned TCP at `q` moving at `dq`: the derivative layer, m/s.
pub fn speed(learned: &Learned, q: &[f64], dq: &[f64]) -> Vec<f64> {
    let u = learned.scaled(q);
    let du: Vec<f64> = dq.iter().zip(&learned.inputs).map(|(d, i)| d * i.gain()).collect();
    learned.networks.iter().map(|n| n.value_and_speed(&u, &du).1).collect()
}

/// Errors of `of` (position and, where the row has a speed, velocity of each coordinate), and the distance of each row.
pub fn rmse(
    rows: &[Row],
    coordinates: &[usize],
    of: impl Fn(&Row) -> (Vec<f64>, Option<Vec<f64>>),
) -> (Vec<Rmse>, Vec<f64>) {
    let mut position = vec![0.0; coordinates.len()];
    let mut speed = vec![0.0; coordinates.len()];
    let mut moving = 0usize;
    let mut distances = Vec::with_capacity(rows.len());
    for row in rows {
        let (p, v) = of(row);
        let mut square = 0.0;
        for (k, &c) in coordinates.iter().enumerate() {
            let e = (p[k] - row.p_m[c]).powi(2);
            position[k] += e;
            square += e;
        }
        distances.push(square.sqrt());
        if let (Some(v), Some((_, dp))) = (v, &row.speed) {
            moving += 1;
            for (k, &c) in coordinates.iter().enumerate() {
                speed[k] += (v[k] - dp[c]).powi(2);
            }
        }
    }
    if rows.is_empty() {
        return (Vec::new(), distances);
    }
    let mean = |sum: f64, n: usize| (sum / n as f64).sqrt();
    let all = position
        .iter()
        .zip(&speed)
        .map(|(&p, &v)| Rmse { position_m: mean(p, rows.len()), speed_m_s: (moving > 0).then(|| mean(v, moving)) });
    (all.collect(), distances)
}

/// Errors of the nominal kinematics; `None` where the rows leave its frame open.
pub fn nominal(robot: &Robot, train: &[Row], test: &[Row], coordinates: &[usize]) -> Option<Nominal> {
    let pairs: Vec<Pair> = train.iter().map(|r| Pair { base_m: robot.tcp_m(&r.q), tracker_m: r.p_m }).collect();
    let frame = register(&pairs).ok()?.found.frame;
    let of = |row: &Row| {
        let mut columns = vec![Vector3::zeros(); robot.dof()];
        let p = frame * nalgebra::Point3::from(robot.chain().position_and_jacobian(&row.q, &mut columns));
        let v = row.speed.as_ref().map(|(dq, _)| {
            let v = frame.rotation * columns.iter().zip(dq).map(|(c, d)| c * *d).sum::<Vector3<f64>>();
            coordinates.iter().map(|&c| v[c]).collect()
        });
        (coordinates.iter().map(|&c| p[c]).collect(), v)
    };
    let (train_rmse, of_train) = rmse(train, coordinates, of);
    let (test_rmse, of_test) = rmse(test, coordinates, of);
    let distances_m = if test.is_empty() { of_train } else { of_test };
    Some(Nominal { train: train_rmse, test: test_rmse, distances_m })
}
