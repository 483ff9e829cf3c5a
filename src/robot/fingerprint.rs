//! SHA-256 of a robot's numbers in canonical form: name, comments and key order do not count, every number does.

use super::{Convention, Robot};
use crate::io::input::sha256;
use std::fmt::Write;

impl Robot {
    /// Hex digest of the kinematics: convention, joints (names, DH, direction, coupling), base, flange with tool. Limits, masses and
    /// further reflectors may change without making a compensator wrong, so they do not count.
    pub fn fingerprint(&self) -> String {
        // 1 nm and 1e-9 rad: numbers that print the same are the same
        let r = |v: f64| (v * 1e9).round() + 0.0;
        let mut text = String::from(match self.convention {
            Convention::Standard => "standard\n",
            Convention::Modified => "modified\n",
        });
        for j in &self.joints {
            let (driver, ratio) = j.follows.map_or((-1, 0.0), |f| (f.joint as i64, f.ratio));
            let _ = writeln!(
                text,
                "{} {} {} {} {} {} {} {} {}",
                j.name.to_lowercase(),
                j.kind.unit(),
                r(j.theta_rad),
                r(j.d_m),
                r(j.a_m),
                r(j.alpha_rad),
                j.direction,
                driver,
                r(ratio)
            );
            if j.beta_rad != 0.0 {
                let _ = writeln!(text, "beta {}", r(j.beta_rad));
            }
        }
        for frame in [self.base, self.flange() * self.tool] {
            let m = frame.to_homogeneous();
            for v in m.fixed_view::<3, 4>(0, 0).iter() {
                let _ = write!(text, "{} ", r(*v));
            }
            text.push('\n');
        }
        sha256(text.as_bytes())
    }
}
