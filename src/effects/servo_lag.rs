//! `servo_lag`: the servo follows its command with a first-order lag, `lag dq/dt + q = p`, starting at rest.
//!
//! In a steady movement the joint trails by `lag * dp/dt`. Parameter: `lag_s`, 0 to 1 s (a position loop slower than that
//! is no servo). Action: feed-forward of the velocity in the controller, or a lower speed; offsets in a program cannot
//! undo it without its times.
//!
//! Method: per interval the exact solution for a cubic command, `q = R(x) + (q0 - R(0)) exp(-x/lag)` with
//! `R = p - lag p' + lag^2 p'' - lag^3 p'''`; the cubic is that of [`super::smooth`] over the rows of a log, the straight line
//! between the points of a program. What earlier effects added to the command is filtered too (the equation is linear),
//! straight between samples. Settled poses have no lag.

use super::common::*;
use super::smooth::{self, Samples};

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "servo_lag",
    heading: "servo lag",
    stage: Stage::Servo,
    family: Family::Lag,
    acts_on: ActsOn::Joint,
    adds: "the joint trails its command by lag times speed",
    equation: "lag dq/dt + q = p, starting at rest",
    reference: "velocity error of a type-1 position loop: Pritschow (1996), CIRP Annals 45(1)",
    parameters: &[("lag_s", "time constant, 0 to 1 s (a position loop is never slower)")],
    confused_with: &["time_offset"],
    decide_by: "log the encoders; or move one joint at a time, at two speeds: a time offset is the same for all joints",
    action: "enable or tune velocity feed-forward, or run slower; offsets in a program cannot compensate it",
    undone: "nothing: it is not an error of position",
    special: Special { needs_motion: true, ..Special::NONE },
    example: ("{effect: servo_lag, joint: A1, lag_s: 0.01}", View::JointOverCommand),
    read: |f| Ok(ServoLag { lag_s: f.needed("lag_s", 0.0)? }.into()),
    typical: |_| vec![("lag_s".into(), 0.01.into())],
    candidates: |survey, list| {
        if survey.clock.is_some() {
            let lag = |target| Candidate::of_size(survey.robot, target, 1e-4, |lag_s| ServoLag { lag_s }).positive();
            list.extend(survey.moving().map(|axis| lag(Target::Joint(axis))));
        }
    },
};

/// Time constant, s (0 or more).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoLag {
    /// Time constant, s, 0 or more.
    pub lag_s: f64,
}

/// Difference of command and joint below which the joint stands (rad or m): it makes no turning point.
const STANDS: f64 = 1e-12;

/// The samples through which the command's cubics go.
struct Support<'a>(&'a Track<'a>);

impl Support<'_> {
    /// Sample of the track.
    #[inline]
    fn at(&self, i: usize) -> usize {
        match self.0.rows {
            Some(rows) if self.0.between == Between::Smooth => rows[i] as usize,
            _ => i,
        }
    }

    #[inline]
    fn cubic(&self, i: usize) -> [f64; 3] {
        if self.0.between == Between::Straight {
            return [(self.p(i + 1) - self.p(i)) / (self.t_s(i + 1) - self.t_s(i)), 0.0, 0.0];
        }
        self.0.cubics.get(i).copied().unwrap_or_else(|| smooth::cubic(self, i))
    }
}

impl Samples for Support<'_> {
    #[inline]
    fn len(&self) -> usize {
        match self.0.rows {
            Some(rows) if self.0.between == Between::Smooth => rows.len(),
            _ => self.0.len(),
        }
    }
    #[inline]
    fn t_s(&self, i: usize) -> f64 {
        self.0.t_s[self.at(i)]
    }
    #[inline]
    fn p(&self, i: usize) -> f64 {
        self.0.p[self.at(i)]
    }
}

/// The cubics of a smooth command, one after each of its rows but the last.
pub fn cubics(track: &Track) -> Vec<[f64; 3]> {
    let support = Support(track);
    (0..support.len().saturating_sub(1)).map(|i| smooth::cubic(&support, i)).collect()
}

/// Command at the time `t_s` after sample `j`, by the motion between samples that a lag assumes.
pub fn command_between(track: &Track, j: usize, t_s: f64) -> f64 {
    let support = Support(track);
    let i = match track.rows {
        Some(rows) if track.between == Between::Smooth => rows.partition_point(|&r| r as usize <= j).saturating_sub(1),
        _ => j,
    };
    if i + 1 >= support.len() {
        return track.p[j];
    }
    smooth::value(support.p(i), &support.cubic(i), t_s - support.t_s(i))
}

/// The lagged command within one interval.
struct Piece {
    p: f64,
    c: [f64; 3],
    lag_s: f64,
    /// `q0 - R(0)`.
    fades: f64,
}

impl Piece {
    fn new(p: f64, c: [f64; 3], lag_s: f64, q0: f64) -> Self {
        let mut piece = Self { p, c, lag_s, fades: 0.0 };
        piece.fades = q0 - piece.steady(0.0);
        piece
    }

    /// `R(x)`.
    #[inline]
    fn steady(&self, x: f64) -> f64 {
        let [c0, c1, c2] = self.c;
        let (first, second) = (c0 + x * (2.0 * c1 + 3.0 * c2 * x), 2.0 * c1 + 6.0 * c2 * x);
        smooth::value(self.p, &self.c, x) - self.lag_s * (first - self.lag_s * (second - self.lag_s * 6.0 * c2))
    }

    fn command(&self, x: f64) -> f64 {
        smooth::value(self.p, &self.c, x)
    }

    fn at(&self, x: f64) -> f64 {
        self.steady(x) + self.fades * (-x / self.lag_s).exp()
    }
}

/// `exp(-h/lag)`, kept while the step stays the same.
struct Fade {
    lag_s: f64,
    h: f64,
    left: f64,
}

impl Fade {
    #[inline]
    fn over(&mut self, h: f64) -> f64 {
        if h != self.h {
            self.h = h;
            self.left = (-h / self.lag_s).exp();
        }
        self.left
    }
}

impl EffectType for ServoLag {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::Lag
    }

    fn values(&self) -> Vec<f64> {
        vec![self.lag_s]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { lag_s: v[0] }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        vec![Parameter::seconds("lag_s", (0.0, 1.0), 0.01)]
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        self.lag(track, signal);
    }

    fn filters_in_time(&self) -> bool {
        true
    }

    fn turning_points(&self, track: &Track) -> Vec<(usize, f64, f64)> {
        self.turns(track)
    }

    fn idle(&self, _site: &Site, settled_poses: bool) -> Option<&'static str> {
        in_settled_poses(settled_poses)
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("it is no error of position: tune the servo")
    }
}

impl ServoLag {
    fn does_nothing(&self, track: &Track) -> bool {
        self.lag_s.is_nan() || self.lag_s <= 0.0 || track.between == Between::Settled || track.len() < 2
    }

    /// Lags the signal in place.
    fn lag(&self, track: &Track, signal: &mut [f64]) {
        if self.does_nothing(track) {
            return;
        }
        let support = Support(track);
        let mut fade = Fade { lag_s: self.lag_s, h: 0.0, left: 1.0 };
        let mut q = track.p[0];
        // what earlier effects added: as it arrives, and lagged
        let mut added = signal[0] - track.p[0];
        let mut lagged = added;
        for i in 0..support.len() - 1 {
            let (a, b) = (support.at(i), support.at(i + 1));
            if track.t_s[b] <= track.t_s[a] {
                continue;
            }
            let piece = Piece::new(track.p[a], support.cubic(i), self.lag_s, q);
            for (j, s) in signal.iter_mut().enumerate().take(b + 1).skip(a + 1) {
                let now = *s - track.p[j];
                let h = track.t_s[j] - track.t_s[j - 1];
                if (added != 0.0 || now != 0.0 || lagged != 0.0) && h > 0.0 {
                    let steady = |e: f64| e - self.lag_s * (now - added) / h;
                    lagged = steady(now) + (lagged - steady(added)) * fade.over(h);
                }
                added = now;
                let x = track.t_s[j] - track.t_s[a];
                q = piece.steady(x) + piece.fades * fade.over(x);
                *s = q + lagged;
            }
        }
    }

    /// Where the lagged command turns between samples: `(sample before, t in s, command there)`. A play after the servo
    /// depends on these points, which no sample shows.
    fn turns(&self, track: &Track) -> Vec<(usize, f64, f64)> {
        let mut found = Vec::new();
        if self.does_nothing(track) {
            return found;
        }
        let support = Support(track);
        let mut q = track.p[0];
        for i in 0..support.len() - 1 {
            let (a, b) = (support.at(i), support.at(i + 1));
            let h = track.t_s[b] - track.t_s[a];
            if h <= 0.0 {
                continue;
            }
            let piece = Piece::new(track.p[a], support.cubic(i), self.lag_s, q);
            // the joint moves towards its command: it turns where it meets it
            let ahead = |x: f64| piece.command(x) - piece.at(x);
            let mut before = track.p[a] - q;
            let mut from = 0.0;
            for j in a + 1..=b {
                let to = track.t_s[j] - track.t_s[a];
                let after = ahead(to);
                if before * after < 0.0 && before.abs() > STANDS && after.abs() > STANDS {
                    let (mut low, mut high) = (from, to);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        if ahead(middle) * before > 0.0 { low = middle } else { high = middle }
                    }
                    let x = 0.5 * (low + high);
                    if x > from && x < to {
                        found.push((j - 1, track.t_s[a] + x, piece.command(x)));
                    }
                }
                (before, from) = (after, to);
            }
            q = piece.at(h);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_trailed_by_lag_times_speed() {
        let t: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.04).collect();
        let p: Vec<f64> = t.iter().map(|t| 0.3 * t).collect();
        let mut track = Track::new(&t, &p, 0.0);
        for between in [Between::Smooth, Between::Straight] {
            track.between = between;
            let mut s = p.clone();
            ServoLag { lag_s: 0.02 }.apply(&track, &mut s);
            for (i, &t) in t.iter().enumerate() {
                let want = 0.3 * (t - 0.02 * (1.0 - (-t / 0.02f64).exp()));
                assert!((s[i] - want).abs() < 1e-13, "{i}: {} {want}", s[i]);
            }
        }
    }

    #[test]
    fn a_smooth_motion_at_ten_samples_a_second_is_lagged_as_its_equation_says() {
        // p = A (1 - cos wt): q = A (1 - (cos wt + w lag sin wt)/(1 + w^2 lag^2)) - A (1 - 1/(1 + w^2 lag^2)) exp(-t/lag)
        let (a, w) = (0.5, 0.9);
        let t: Vec<f64> = (0..150).map(|i| f64::from(i) * 0.1).collect();
        let p: Vec<f64> = t.iter().map(|t| a * (1.0 - (w * t).cos())).collect();
        let track = Track::new(&t, &p, 0.0);
        for lag in [0.001, 0.005, 0.02, 0.05] {
            let mut s = p.clone();
            ServoLag { lag_s: lag }.apply(&track, &mut s);
            let g = 1.0 / (1.0 + (w * lag).powi(2));
            let worst = t.iter().zip(&s).map(|(&t, s)| {
                let want = a * (1.0 - g * ((w * t).cos() + w * lag * (w * t).sin())) - a * (1.0 - g) * (-t / lag).exp();
                (s - want).abs()
            });
            let worst = worst.fold(0.0, f64::max);
            // 1e-6 rad is 3 um at 3 m; the lag itself is up to 0.0225 rad
            assert!(worst < 1e-6, "lag {lag}: {worst:e}");
        }
    }

    #[test]
    fn settled_poses_do_not_lag() {
        let (t, p) = ([0.0, 1.0, 2.0], [0.0, 1.0, 0.5]);
        let mut track = Track::new(&t, &p, 0.0);
        track.between = Between::Settled;
        let mut s = p.to_vec();
        ServoLag { lag_s: 0.5 }.apply(&track, &mut s);
        assert_eq!(s, p);
    }

    #[test]
    fn the_turning_point_of_the_lagged_joint_is_where_it_meets_its_command() {
        let t: Vec<f64> = (0..120).map(|i| f64::from(i) * 0.05).collect();
        let p: Vec<f64> = t.iter().map(|t| (t - 0.5).sin()).collect();
        let track = Track::new(&t, &p, 0.0);
        let lag = ServoLag { lag_s: 0.03 };
        let found = lag.turns(&track);
        // the phase of the lag is atan(0.03) = 0.03 rad at 1 rad/s: 0.03 s after the command's own extreme
        let turn = |k: f64| 0.5 + std::f64::consts::FRAC_PI_2 + k * std::f64::consts::PI + 0.03f64.atan();
        let late: Vec<_> = found.iter().filter(|f| f.1 > 1.0).collect();
        assert_eq!(late.len(), 2);
        for (k, f) in late.iter().enumerate() {
            assert!((f.1 - turn(k as f64)).abs() < 1e-4, "{f:?} {}", turn(k as f64));
        }
    }
}
