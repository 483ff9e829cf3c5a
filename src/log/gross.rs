//! Gross errors of a tracker: single rows that stand off the rows around them, as after a beam break or a reflection.
//!
//! Method: the measured path less the one that the robot file gives for the commands changes slowly and by steps, whatever the geometry
//! errors; rows that stand off its running median are lost (Hampel 1974). A step, and whatever takes longer than half a window, stays.
//!
//! How it fails: where the log is too short, or where a fifth of the rows would be lost, nothing is.

use super::Log;
use super::faults::Sample;
use super::shape;
use crate::numerics::robust::{SIGMA_PER_MAD, median_of};
use crate::robot::Robot;
use nalgebra::Vector3;

/// Rows with a measurement on each side of a row.
const SIDE: usize = 3;
/// Distance from the median that is no gross error, m: reversals of a worn joint are within it.
const LEAST_M: f64 = 3e-4;
/// ... and times the scatter of the rows about it.
const TIMES: f64 = 8.0;
/// Largest share of the rows that can be in error.
const MOST: f64 = 0.2;

/// Loses rows in gross error; how many, and by how much the least of them stands off, m.
pub(super) fn leave_out(log: &mut Log, robot: &Robot) -> Option<(usize, f64)> {
    if log.poses || !suspicious(&log.tcp_m) {
        return None;
    }
    let sample = Sample::take(log);
    let fit = shape::fit(&sample.computed(robot), &sample.measured, false);
    let columns: Vec<&[f64]> = log.cmd.iter().map(Vec::as_slice).collect();
    let mut nominal = vec![Vector3::zeros(); log.len()];
    robot.chain().positions(&columns, 0, &mut nominal);
    let back = fit.rotation.transpose();
    let rows: Vec<usize> = (0..log.len()).filter(|i| log.tcp_m[*i].is_some()).collect();
    let off: Vec<Vector3<f64>> =
        rows.iter().filter_map(|i| log.tcp_m[*i].map(|p| back * (p - fit.translation) - nominal[*i])).collect();
    let stands: Vec<f64> = (0..off.len()).map(|k| (off[k] - running_median(&off, k)).norm()).collect();
    let scatter = SIGMA_PER_MAD * median_of(&mut stands.clone())?;
    let limit = LEAST_M.max(TIMES * scatter);
    let gross: Vec<usize> = (0..off.len()).filter(|k| stands[*k] > limit).collect();
    if gross.is_empty() || gross.len() as f64 > MOST * rows.len() as f64 {
        return None;
    }
    gross.iter().for_each(|k| log.tcp_m[rows[*k]] = None);
    Some((gross.len(), limit))
}

/// Whether any row stands off the middle of its neighbours by more than a motion makes of it: most logs need not be looked at closer.
fn suspicious(tcp_m: &[Option<Vector3<f64>>]) -> bool {
    let seen: Vec<&Vector3<f64>> = tcp_m.iter().flatten().collect();
    seen.windows(3).any(|w| ((w[0] + w[2]) / 2.0 - w[1]).norm() > LEAST_M / 2.0)
}

fn running_median(off: &[Vector3<f64>], k: usize) -> Vector3<f64> {
    let near = &off[k.saturating_sub(SIDE)..(k + SIDE + 1).min(off.len())];
    Vector3::from_fn(|c, _| median_of(&mut near.iter().map(|v| v[c]).collect::<Vec<_>>()).unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::Input;

    const ROBOT: &str = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n  - {name: A2, kind: revolute, a_mm: 400}\n";

    /// A joint swings; the TCP in a frame of the tracker's own, 0.2 mm of lost motion that changes sides at reversals.
    fn log(error_mm: impl Fn(usize) -> f64) -> (Log, Robot) {
        let robot = Robot::parse("robot.yaml", ROBOT).unwrap();
        let mut text = String::from("t_s,cmd_A1_deg,cmd_A2_deg,x_mm,y_mm,z_mm\n");
        for i in 0..600 {
            let t = i as f64 * 0.05;
            let (a, b) = (30.0 * (0.4 * t).sin(), 20.0 + 3.0 * t);
            let side = if (0.4 * t).cos() > 0.0 { 0.1 } else { -0.1 };
            let p = robot.tcp_m(&[a.to_radians(), b.to_radians()]) * 1e3;
            let (x, y) = (p.y + side + error_mm(i), 1000.0 - p.x);
            text += &format!("{t:.3},{a:.6},{b:.6},{x:.5},{y:.5},{:.5}\n", p.z);
        }
        let input = Input { name: "log.csv".into(), bytes: text.into(), sha256: String::new() };
        (Log::parse(input, &robot).unwrap(), robot)
    }

    fn lost(log: &Log) -> Vec<usize> {
        (0..log.len()).filter(|i| log.tcp_m[*i].is_none()).collect()
    }

    #[test]
    fn single_rows_far_off_are_lost_and_steps_are_kept() {
        let at = [7, 100, 101, 599];
        let (mut bad, robot) = log(|i| if at.contains(&i) { 4.0 } else { 0.0 });
        assert_eq!(leave_out(&mut bad, &robot).map(|f| f.0), Some(4));
        assert_eq!(lost(&bad), at);
        // the tracker was moved: no single rows
        let (mut moved, robot) = log(|i| if i > 300 { 1.0 } else { 0.0 });
        assert!(leave_out(&mut moved, &robot).is_none());
        assert!(lost(&moved).is_empty());
    }

    #[test]
    fn reversals_are_no_errors_and_a_log_of_errors_is_not_thinned() {
        let (mut good, robot) = log(|_| 0.0);
        assert!(leave_out(&mut good, &robot).is_none());
        let (mut noisy, robot) = log(|i| if i % 3 == 0 { 2.0 } else { 0.0 });
        assert!(leave_out(&mut noisy, &robot).is_none());
        assert!(lost(&noisy).is_empty());
    }
}
