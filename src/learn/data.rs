//! Logs to rows that a network can learn from: commands, TCP, and the speeds of both.
//!
//! Speeds are central differences over the two neighbouring rows, of commands and of measurements, so that both are smoothed in the
//! same way. A row beside a lost reflector or beside a pause in the log (more than [`PAUSE`] usual intervals) has no speed and
//! counts with its position alone; settled poses have none at all.
//!
//! The input may be another command than the logged one (Cursi (2022), section IV-C2: the network sees the desired motor
//! positions, the machine got compensated ones): that of a program with times, linear between its points.

use crate::error::{Error, Place, Result};
use crate::log::Log;
use crate::numerics::robust::median;
use crate::program::Program;
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Two intervals together are this many usual ones at most, or the log paused there.
const PAUSE: f64 = 3.0;
/// A log may reach beyond the ends of its program by this many usual intervals: rounding of times.
const BEYOND: f64 = 0.01;

/// One row with a measurement; rad or m, m, per second.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Joint commands, rad or m.
    pub q: Vec<f64>,
    /// Measured TCP, m.
    pub p_m: Vector3<f64>,
    /// Speed of commands and of the TCP.
    pub speed: Option<(Vec<f64>, Vector3<f64>)>,
}

/// Rows of a log; `desired` replaces its commands.
pub fn rows(log: &Log, desired: Option<&Program>) -> Result<Vec<Row>> {
    if log.tcp_m.is_empty() {
        return Err(Error::bad(Place::file(&log.name), "no columns x_mm, y_mm, z_mm", "a log with the measured TCP"));
    }
    let intervals: Vec<f64> = log.t_s.windows(2).map(|w| w[1] - w[0]).collect();
    let usual = median(&intervals);
    let looked_up;
    let commands = match desired {
        None => &log.cmd,
        Some(program) => {
            looked_up = at_times(log, program, usual)?;
            &looked_up
        }
    };
    let q = |i: usize| -> Vec<f64> { commands.iter().map(|c| c[i]).collect() };
    let speed = |i: usize| {
        if log.poses || i == 0 || i + 1 >= log.len() {
            return None;
        }
        let span = log.t_s[i + 1] - log.t_s[i - 1];
        let (Some(before), Some(after)) = (log.tcp_m[i - 1], log.tcp_m[i + 1]) else { return None };
        (span <= PAUSE * usual).then(|| {
            let dq = commands.iter().map(|c| (c[i + 1] - c[i - 1]) / span).collect();
            (dq, (after - before) / span)
        })
    };
    let found = (0..log.len()).filter_map(|i| Some(Row { q: q(i), p_m: log.tcp_m[i]?, speed: speed(i) }));
    Ok(found.collect())
}

/// Commands of a program at the times of a log, `[axis][row]`.
fn at_times(log: &Log, program: &Program, usual_s: f64) -> Result<Vec<Vec<f64>>> {
    let Some(t_s) = program.t_s.as_ref().filter(|t| t.len() > 1) else {
        let expected = "a program with times, in which the rows of the log are looked up";
        return Err(Error::bad(Place::file(&program.name), "no column t_s, or one point", expected));
    };
    if log.poses {
        return Err(Error::bad(Place::file(&log.name), "no column t_s", "times: rows are looked up in the program"));
    }
    let (from, to) = (t_s[0], t_s[t_s.len() - 1]);
    let room = BEYOND * usual_s;
    if let Some(i) = log.t_s.iter().position(|t| *t < from - room || *t > to + room) {
        let place = Place::line(&log.name, u64::from(log.line[i]));
        let expected = format!("times from {from} to {to} s, as in {}", program.name);
        return Err(Error::bad(place, format!("time {} s", log.t_s[i]), expected));
    }
    let share: Vec<(usize, f64)> = log
        .t_s
        .iter()
        .map(|&t| {
            let k = t_s.partition_point(|&x| x <= t).clamp(1, t_s.len() - 1);
            let length = t_s[k] - t_s[k - 1];
            (k, if length > 0.0 { ((t - t_s[k - 1]) / length).clamp(0.0, 1.0) } else { 1.0 })
        })
        .collect();
    let column = |c: &Vec<f64>| share.iter().map(|&(k, s)| c[k - 1] + s * (c[k] - c[k - 1])).collect();
    Ok(program.q.iter().map(column).collect())
}

/// A share of the rows, drawn at random from the seed, and the rest; both in the order of the log.
pub fn split(rows: Vec<Row>, share: f64, seed: u64) -> (Vec<Row>, Vec<Row>) {
    let mut order: Vec<usize> = (0..rows.len()).collect();
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    for i in (1..order.len()).rev() {
        order.swap(i, generator.random_range(0..=i as u64) as usize);
    }
    let kept = (share * rows.len() as f64).round() as usize;
    let mut train = vec![false; rows.len()];
    order.iter().take(kept).for_each(|&i| train[i] = true);
    let (mut first, mut rest) = (Vec::with_capacity(kept), Vec::new());
    for (row, train) in rows.into_iter().zip(train) {
        if train { first.push(row) } else { rest.push(row) }
    }
    (first, rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::from_bytes;
    use crate::robot::Robot;

    fn robot() -> Robot {
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n";
        Robot::parse("robot.yaml", text).unwrap()
    }

    fn log(text: &str) -> Log {
        Log::parse(from_bytes("log.csv".into(), text.into()).unwrap(), &robot()).unwrap()
    }

    #[test]
    fn a_row_beside_a_lost_reflector_or_a_pause_has_no_speed() {
        let log = log(
            "t_s,cmd_A1_deg,x_mm,y_mm,z_mm\n0,0,0,0,0\n1,1,1,0,0\n2,2,2,0,0\n3,3,,,\n4,4,4,0,0\n5,5,5,0,0\n6,6,6,0,0\n60,6,6,0,0\n61,7,7,0,0\n",
        );
        let rows = rows(&log, None).unwrap();
        let has: Vec<bool> = rows.iter().map(|r| r.speed.is_some()).collect();
        assert_eq!(has, [false, true, false, false, true, false, false, false]);
        let (dq, dp) = rows[1].speed.clone().unwrap();
        assert!((dq[0].to_degrees() - 1.0).abs() < 1e-12 && (dp.x - 1e-3).abs() < 1e-15);
    }

    #[test]
    fn commands_of_a_program_take_the_place_of_the_logged_ones() {
        let log = log("t_s,cmd_A1_deg,x_mm,y_mm,z_mm\n0,9,0,0,0\n1,9,1,0,0\n2,9,2,0,0\n");
        let program = |text: &str| Program::parse(from_bytes("p.csv".into(), text.into()).unwrap(), &robot()).unwrap();
        let rows = rows(&log, Some(&program("t_s,a1_deg\n0,0\n2,4\n"))).unwrap();
        let deg: Vec<f64> = rows.iter().map(|r| r.q[0].to_degrees()).collect();
        assert!(deg.iter().zip([0.0, 2.0, 4.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{deg:?}");
        let e = super::rows(&log, Some(&program("t_s,a1_deg\n0,0\n1,4\n"))).unwrap_err();
        assert!(e.to_string().contains("log.csv:4"), "{e}");
    }

    #[test]
    fn a_split_is_the_same_for_the_same_seed_and_loses_no_row() {
        let rows: Vec<Row> =
            (0..50).map(|i| Row { q: vec![f64::from(i)], p_m: Vector3::zeros(), speed: None }).collect();
        let (train, test) = split(rows.clone(), 0.8, 3);
        assert_eq!((train.len(), test.len()), (40, 10));
        assert_eq!(split(rows.clone(), 0.8, 3), (train.clone(), test.clone()));
        assert_ne!(split(rows.clone(), 0.8, 4).1, test);
        let mut all: Vec<f64> = train.iter().chain(&test).map(|r| r.q[0]).collect();
        all.sort_by(f64::total_cmp);
        assert_eq!(all, rows.iter().map(|r| r.q[0]).collect::<Vec<_>>());
    }
}
