//! Commands from rest to rest: used by every motion of the library.
//!
//! Method: all joints share one path parameter that runs through a trapezoid of speed, so that they start and stop
//! together; the slowest joint sets the time, rounded up to whole intervals. Rows stand one interval apart. Rounded to the
//! digits with which a program is written, so that what is evaluated is what is run.
//!
//! Speed and acceleration stay within half of the joint's limits; where the robot file has none, within [`SPEED`] and
//! [`ACCEL`]. Fails softly: [`Path::finish`] reports a path that leaves its window, or a limit.

use crate::robot::{JointKind, Robot};
use nalgebra::Vector3;

/// Part of a limit that a motion uses.
const SHARE: f64 = 0.5;
/// Speed where the robot file has no limit: rad/s, m/s.
const SPEED: [f64; 2] = [0.5, 0.1];
/// Acceleration where the robot file has no limit: rad/s2, m/s2.
const ACCEL: [f64; 2] = [0.5, 0.5];
/// Shortest time to reach the working speed, s.
const SPEED_UP_S: f64 = 0.3;
/// Rows of the log that the shortest move lasts: of a quicker one the log would not know how it went.
const ROWS_OF_A_MOVE: f64 = 10.0;
/// Shortest lever by which a joint's speed follows from that of the TCP, m.
const LEVER_M: f64 = 0.05;
/// Decimals of a program in deg and mm.
pub const DECIMALS: u8 = 6;
/// Part of a joint's range that is kept free at either end.
const MARGIN: f64 = 0.02;
/// Rate of a program's rows, or up to twice as much, Hz: a controller runs straight from row to row, a diagnosis takes the motion
/// between rows of a log to be smooth. At 25 Hz the corners are worth tens of micrometres to a lagging joint.
const PROGRAM_RATE_HZ: f64 = 100.0;

/// Where and how fast motions may run.
#[derive(Debug, Clone)]
pub struct Envelope<'a> {
    /// The robot that moves.
    pub robot: &'a Robot,
    /// Start and end.
    pub pose: Vec<f64>,
    /// Least and most of each axis, rad or m.
    pub window: Vec<[f64; 2]>,
    /// Working speed of each axis, rad/s or m/s: that of the TCP over its lever, within limits.
    pub fast: Vec<f64>,
    /// Largest acceleration used, rad/s2 or m/s2.
    pub accel: Vec<f64>,
    /// Travel of each axis over which an alternative's transition after a reversal is expected, rad or m.
    pub transition: Vec<f64>,
    /// Interval of the program's rows, s.
    pub step_s: f64,
    /// Rows of the log per second: a whole number of intervals of the program apart, or the reverse.
    pub rate_hz: f64,
    /// Longest motion, s.
    pub duration_s: f64,
    /// Largest speed of the TCP, m/s.
    pub speed_m_s: f64,
}

/// What the user requests of an envelope.
#[derive(Debug, Clone)]
pub struct EnvelopeOptions {
    /// Joints at start and end, rad or m; `None`: chosen by the envelope.
    pub pose: Option<Vec<f64>>,
    /// Longest motion, s.
    pub duration_s: f64,
    /// Rate of the rows, Hz.
    pub rate_hz: f64,
    /// Largest speed of the TCP, m/s.
    pub speed_m_s: f64,
    /// Largest travel of a revolute joint to either side, rad.
    pub travel_rad: f64,
    /// Largest travel of a prismatic joint to either side, m.
    pub travel_m: f64,
}

impl<'a> Envelope<'a> {
    /// Limits of the motions of a robot, from its own limits and the options.
    pub fn new(robot: &'a Robot, options: &EnvelopeOptions) -> Self {
        let pose = options.pose.clone().unwrap_or_else(|| resting_pose(robot));
        let pose: Vec<f64> = pose.iter().enumerate().map(|(a, v)| rounded(robot.axis(a).kind, *v)).collect();
        let mut lever = vec![Vector3::zeros(); robot.dof()];
        robot.chain().position_and_jacobian(&pose, &mut lever);
        let index = |kind: JointKind| if kind == JointKind::Revolute { 0 } else { 1 };
        let window = robot.axis_joints().zip(&pose).map(|(j, p)| {
            let travel = if j.kind == JointKind::Revolute { options.travel_rad } else { options.travel_m };
            let [lo, hi] = j.limits.map_or([f64::NEG_INFINITY, f64::INFINITY], |[lo, hi]| {
                let keep = MARGIN * (hi - lo);
                [(lo + keep).min(*p), (hi - keep).max(*p)]
            });
            [(p - travel).max(lo), (p + travel).min(hi)]
        });
        let fast: Vec<f64> = robot
            .axis_joints()
            .zip(&lever)
            .map(|(j, l)| {
                let most = j.max_speed.map_or(SPEED[index(j.kind)], |v| SHARE * v);
                (options.speed_m_s / l.norm().max(LEVER_M)).min(most)
            })
            .collect();
        let accel = robot
            .axis_joints()
            .zip(&fast)
            .map(|(j, v)| j.max_accel.map_or(ACCEL[index(j.kind)], |a| SHARE * a).min(v / SPEED_UP_S))
            .collect();
        let step_s = if options.rate_hz >= PROGRAM_RATE_HZ {
            (options.rate_hz / PROGRAM_RATE_HZ).floor() / options.rate_hz
        } else {
            1.0 / (options.rate_hz * (PROGRAM_RATE_HZ / options.rate_hz).ceil())
        };
        Self {
            robot,
            window: window.collect(),
            transition: robot.axis_joints().map(|j| 0.3 * j.kind.si_per_user_unit()).collect(),
            pose,
            fast,
            accel,
            step_s,
            rate_hz: options.rate_hz,
            duration_s: options.duration_s,
            speed_m_s: options.speed_m_s,
        }
    }

    /// The same for a run of another length.
    pub fn of_duration(&self, duration_s: f64) -> Self {
        Self { duration_s, ..self.clone() }
    }

    /// Length of an axis' window.
    pub fn span(&self, axis: usize) -> f64 {
        self.window[axis][1] - self.window[axis][0]
    }
}

/// Middle of the joints' ranges, a little off, so that no two axes stand in line.
fn resting_pose(robot: &Robot) -> Vec<f64> {
    robot
        .axis_joints()
        .map(|j| {
            j.limits
                .map_or(0.0, |[lo, hi]| 0.5 * (lo + hi) + 0.1 * (0.5 * (hi - lo)).min(90.0 * j.kind.si_per_user_unit()))
        })
        .collect()
}

/// A value as a program writes it.
pub fn rounded(kind: JointKind, value: f64) -> f64 {
    let scale = 10f64.powi(i32::from(DECIMALS));
    (kind.to_user_unit(value) * scale).round() / scale * kind.si_per_user_unit()
}

/// Joint vectors one interval apart.
#[derive(Debug, Clone)]
pub struct Path<'a> {
    /// Limits that the path keeps.
    pub envelope: &'a Envelope<'a>,
    rows: Vec<Vec<f64>>,
}

impl<'a> Path<'a> {
    /// At rest at the pose.
    pub fn new(envelope: &'a Envelope<'a>) -> Self {
        Self { envelope, rows: vec![envelope.pose.clone()] }
    }

    /// Joints at the end of the path, rad or m.
    pub fn at(&self) -> Vec<f64> {
        self.rows.last().cloned().unwrap_or_else(|| self.envelope.pose.clone())
    }

    /// Time so far, s.
    pub fn length_s(&self) -> f64 {
        (self.rows.len() - 1) as f64 * self.envelope.step_s
    }

    /// Time that is left, s.
    pub fn left_s(&self) -> f64 {
        self.envelope.duration_s - self.length_s()
    }

    /// Stands still for `time_s` seconds.
    pub fn stand(&mut self, time_s: f64) {
        let q = self.at();
        for _ in 0..(time_s / self.envelope.step_s).round().max(1.0) as usize {
            self.rows.push(q.clone());
        }
    }

    /// From rest to rest at `pace` times the working speed.
    pub fn go(&mut self, to: &[f64], pace: f64) {
        self.go_softly(to, pace, f64::INFINITY);
    }

    /// The same with an acceleration of at most `accel` (rad/s2 or m/s2): turning points become wide parabolas.
    pub fn go_softly(&mut self, to: &[f64], pace: f64, accel: f64) {
        let from = self.at();
        let (mut v, mut a) = (f64::INFINITY, f64::INFINITY);
        for (axis, (x, y)) in from.iter().zip(to).enumerate() {
            let way = (y - x).abs();
            if way > 0.0 {
                v = v.min(pace * self.envelope.fast[axis] / way);
                a = a.min(self.envelope.accel[axis].min(accel) / way);
            }
        }
        if !v.is_finite() {
            return;
        }
        // of the path parameter: speed-up, top speed, and the whole
        let shape = |v: f64, a: f64| {
            let up = (v / a).min((1.0 / a).sqrt());
            (up, a * up, up + 1.0 / (a * up))
        };
        let slower = (ROWS_OF_A_MOVE / self.envelope.rate_hz / shape(v, a).2).max(1.0);
        a /= slower * slower;
        let (up, top, whole) = shape(v / slower, a);
        let n = (whole / self.envelope.step_s - 1e-9).ceil().max(1.0);
        for i in 1..=n as usize {
            let t = whole * i as f64 / n;
            let s = if t < up {
                0.5 * a * t * t
            } else if t > whole - up {
                1.0 - 0.5 * a * (whole - t) * (whole - t)
            } else {
                top * (t - 0.5 * up)
            };
            self.rows.push(from.iter().zip(to).map(|(x, y)| if s >= 1.0 { *y } else { x + s * (y - x) }).collect());
        }
        if let Some(last) = self.rows.last_mut() {
            last.copy_from_slice(to);
        }
    }

    /// One axis to a position.
    pub fn axis_to(&mut self, axis: usize, to: f64, pace: f64) {
        let mut q = self.at();
        q[axis] = to;
        self.go(&q, pace);
    }

    /// Back to the pose.
    pub fn home(&mut self) {
        let pose = self.envelope.pose.clone();
        self.go(&pose, 1.0);
    }

    /// Rows as they are given; they begin one interval after the last.
    pub fn follow(&mut self, rows: impl IntoIterator<Item = Vec<f64>>) {
        self.rows.extend(rows);
    }

    /// Repeats a cycle that ends where it begins as often as the time allows; `None` where it does not fit once.
    pub fn repeat(self, cycle: impl Fn(&mut Self)) -> Option<Vec<Vec<f64>>> {
        let mut path = self;
        let start = path.rows.len();
        cycle(&mut path);
        if path.left_s() < -1e-6 {
            return None;
        }
        let once: Vec<Vec<f64>> = path.rows[start..].to_vec();
        if once.is_empty() {
            return None;
        }
        while path.length_s() + once.len() as f64 * path.envelope.step_s <= path.envelope.duration_s + 1e-6 {
            path.rows.extend(once.iter().cloned());
        }
        path.finish()
    }

    /// Rows, rounded; `None` where a window or half a limit is left, or the path does not end at its pose.
    pub fn finish(mut self) -> Option<Vec<Vec<f64>>> {
        let envelope = self.envelope;
        for row in &mut self.rows {
            for (axis, v) in row.iter_mut().enumerate() {
                *v = rounded(envelope.robot.axis(axis).kind, *v);
            }
        }
        let ends = self.rows.len() > 2 && self.rows.last() == Some(&envelope.pose);
        (ends && self.left_s() > -1e-6 && self.kept()).then_some(self.rows)
    }

    fn kept(&self) -> bool {
        let h = self.envelope.step_s;
        (0..self.envelope.pose.len()).all(|axis| {
            let joint = self.envelope.robot.axis(axis);
            // one digit of the program, and the speed that it makes
            let digit = 2e-6 * joint.kind.si_per_user_unit();
            let [lo, hi] = self.envelope.window[axis];
            let most_v = joint.max_speed.unwrap_or(f64::INFINITY);
            let most_a = joint.max_accel.unwrap_or(f64::INFINITY);
            let inside = self.rows.iter().all(|q| q[axis] >= lo - digit && q[axis] <= hi + digit);
            let speed = self.rows.windows(2).all(|w| (w[1][axis] - w[0][axis]).abs() / h <= 0.98 * most_v);
            let change = |w: &[Vec<f64>]| (w[2][axis] - 2.0 * w[1][axis] + w[0][axis]).abs() / (h * h);
            inside && speed && self.rows.windows(3).all(|w| change(w) <= 0.98 * most_a)
        })
    }
}
