//! Files that are wrong: units, axes, signs, columns and clocks.

use crate::case::Log;
use crate::robots::Robot;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

pub const KINDS: [&str; 11] = [
    "cmd_in_radians",
    "one_cmd_in_radians",
    "tcp_in_metres",
    "tcp_in_inches",
    "tcp_axes_swapped",
    "tcp_axis_mirrored",
    "cmd_sign",
    "cmd_columns_swapped",
    "time_not_increasing",
    "clocks_apart",
    "time_in_milliseconds",
];

/// Spoils a log in one way that shows; says how.
pub fn spoil(kind: &str, robot: &Robot, log: &mut Log, moving: &[usize], rng: &mut ChaCha8Rng) -> Value {
    let turning: Vec<usize> = moving.iter().copied().filter(|j| robot.joints[*j].revolute).collect();
    let pick = |of: &[usize], rng: &mut ChaCha8Rng| of[rng.random_range(0..of.len())];
    let column = |j: usize| format!("cmd_{}_{}", robot.joints[j].name, robot.joints[j].suffix());
    let tcp =
        |log: &mut Log, f: &dyn Fn([f64; 3]) -> [f64; 3]| log.tcp_mm.iter_mut().flatten().for_each(|p| *p = f(*p));
    log.decimals = 8;
    let place = match kind {
        "cmd_in_radians" => {
            let all: Vec<usize> = (0..robot.joints.len()).filter(|j| robot.joints[*j].revolute).collect();
            log.cmd.iter_mut().for_each(|row| all.iter().for_each(|&j| row[j] = row[j].to_radians()));
            all.iter().map(|&j| column(j)).collect::<Vec<_>>().join(",")
        }
        "one_cmd_in_radians" => {
            let j = pick(&turning, rng);
            log.cmd.iter_mut().for_each(|row| row[j] = row[j].to_radians());
            column(j)
        }
        "tcp_in_metres" => {
            tcp(log, &|p| p.map(|v| v * 1e-3));
            "x_mm,y_mm,z_mm".into()
        }
        "tcp_in_inches" => {
            tcp(log, &|p| p.map(|v| v / 25.4));
            "x_mm,y_mm,z_mm".into()
        }
        "tcp_axes_swapped" => {
            let (a, b) = [(0, 1), (1, 2), (0, 2)][rng.random_range(0..3)];
            log.tcp_mm.iter_mut().flatten().for_each(|p| p.swap(a, b));
            format!("columns {a} and {b} of the TCP")
        }
        "tcp_axis_mirrored" => {
            let a = rng.random_range(0..3);
            log.tcp_mm.iter_mut().flatten().for_each(|p| p[a] = -p[a]);
            format!("column {a} of the TCP")
        }
        "cmd_sign" => {
            let j = pick(moving, rng);
            log.cmd.iter_mut().for_each(|row| row[j] = -row[j]);
            column(j)
        }
        "cmd_columns_swapped" => {
            let a = pick(moving, rng);
            let same: Vec<usize> = (0..robot.joints.len())
                .filter(|&j| j != a && robot.joints[j].revolute == robot.joints[a].revolute)
                .collect();
            let b = pick(&same, rng);
            log.cmd.iter_mut().for_each(|row| row.swap(a, b));
            format!("{},{}", column(a), column(b))
        }
        "time_not_increasing" => {
            let k = rng.random_range(log.t_s.len() / 4..3 * log.t_s.len() / 4);
            if rng.random_bool(0.5) {
                let t0 = log.t_s[k];
                log.t_s[k..].iter_mut().for_each(|t| *t -= t0);
            } else {
                log.t_s.swap(k, k + 1);
            }
            format!("row {k}")
        }
        "clocks_apart" => {
            let period = log.t_s[1] - log.t_s[0];
            let shift = (rng.random_range(0.6..3.0) / period) as usize;
            let n = log.tcp_mm.len();
            if rng.random_bool(0.5) {
                log.tcp_mm.drain(..shift);
                log.t_s.truncate(n - shift);
                log.cmd.truncate(n - shift);
            } else {
                log.tcp_mm.truncate(n - shift);
                log.cmd.drain(..shift);
                log.t_s.truncate(n - shift);
            }
            format!("{:.2} s", shift as f64 * period)
        }
        _ => {
            log.t_s.iter_mut().for_each(|t| *t *= 1e3);
            "t_s".into()
        }
    };
    json!({"kind": kind, "where": place})
}
