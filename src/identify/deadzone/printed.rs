//! Algorithm 1 of Cursi (2022) exactly as printed, to compare with.
//!
//! Speeds are differences from row to row over their time; `eps` and `eps_v` are the user's. A row begins a deadzone where
//! the motor is faster than `eps` and the tip slower than `eps_v`; the next row at which both are faster ends it. On a log with
//! noise the tip's speed crosses `eps_v` at random: below the speed of the noise nothing is found, above it the
//! sizes grow with the threshold and one deadzone becomes many.

use super::motion::Stretch;

/// Motor position at which a deadzone begins, and its size; rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    pub from: f64,
    pub size: f64,
}

/// Deadzones of a stretch; `eps` in rad/s (or m/s) of the motor, `eps_v` in m/s of the tip. Rows without a tip are passed over.
pub fn identify(s: &Stretch, eps: f64, eps_v: f64) -> Vec<Printed> {
    let rows: Vec<usize> = (0..s.t_s.len()).filter(|&i| s.tip[i].is_some()).collect();
    // motor value, and whether motor and tip move, at each row
    let speeds: Vec<(f64, bool, bool)> = rows
        .windows(2)
        .filter_map(|w| {
            let dt = s.t_s[w[1]] - s.t_s[w[0]];
            let tip = (s.tip[w[1]]? - s.tip[w[0]]?).norm() / dt;
            let motor = (s.p[w[1]] - s.p[w[0]]).abs() / dt;
            Some((s.p[w[1]], motor > eps, tip >= eps_v))
        })
        .collect();
    let mut found = Vec::new();
    let mut t = 0;
    while t < speeds.len() {
        let (from, motor, tip) = speeds[t];
        if motor && !tip {
            let end = (t + 1..speeds.len()).find(|&i| speeds[i].1 && speeds[i].2);
            let Some(end) = end else { break };
            found.push(Printed { from, size: (speeds[end].0 - from).abs() });
            t = end;
        }
        t += 1;
    }
    found
}
