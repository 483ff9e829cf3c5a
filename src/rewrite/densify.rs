//! `--refine cartesian`: points on the smooth path between program points, so that the program's own chords go.
//!
//! Between points 1 and 2 of four neighbours the TCP follows the arcs through points 0, 1, 2 and 1, 2, 3, blended over the
//! leg (exact on circles and straight lines); joints start from parabolas blended in the same way and are brought onto the
//! arc by minimum-norm Newton steps of the joints that move there (numerical inverse; Whitney 1969). Corners stay corners:
//! where the path turns by more than 25 degrees, neighbouring legs differ by more than 3 to 1, or points coincide, the leg
//! uses its other end alone, and stays straight with two corners. A leg gets as many points as its chords need.

use super::Origin;
use super::path::between;
use super::turning::{OVERSHOOT, Turning, UNEVEN};
use super::vertices::Vertices;
use crate::robot::Robot;
use nalgebra::{Matrix3, Vector3};

const CORNER_RAD: f64 = 25.0 * std::f64::consts::PI / 180.0;
const MOST_PER_LEG: f64 = 256.0;

/// Takes program points and hands a dense path on to [`Turning`].
pub struct Densify<'a> {
    robot: &'a Robot,
    points: Vertices,
    tcp: Vec<Vector3<f64>>,
    tcp_first: usize,
    chord_m: f64,
    next: usize,
    timed: bool,
}

impl<'a> Densify<'a> {
    pub fn new(robot: &'a Robot, chord_m: f64) -> Self {
        Self {
            robot,
            points: Vertices::new(robot.dof()),
            tcp: Vec::new(),
            tcp_first: 0,
            chord_m,
            next: 0,
            timed: false,
        }
    }

    /// Takes one point and hands on what is settled.
    pub fn push(&mut self, q: &[f64], t_s: f64, timed: bool, origin: Origin, turning: &mut Turning) {
        self.timed = timed;
        self.points.push(q, t_s, origin);
        self.tcp.push(self.robot.tcp_m(q));
        while self.next + 2 < self.points.end() {
            self.leg(self.next, turning);
            self.next += 1;
        }
        self.points.forget(self.next.saturating_sub(2));
        let n = self.points.start() - self.tcp_first;
        self.tcp.drain(..n);
        self.tcp_first += n;
    }

    /// Hands on the rest.
    pub fn finish(&mut self, turning: &mut Turning) {
        while self.next < self.points.end() {
            self.leg(self.next, turning);
            self.next += 1;
        }
    }

    fn x(&self, i: usize) -> Vector3<f64> {
        self.tcp[i - self.tcp_first]
    }

    /// The path goes smoothly through point `i`.
    fn smooth(&self, i: usize) -> bool {
        if i <= self.points.start() || i + 1 >= self.points.end() {
            return false;
        }
        let (a, b) = (self.x(i) - self.x(i - 1), self.x(i + 1) - self.x(i));
        let (la, lb) = (a.norm(), b.norm());
        la > 1e-8 && lb > 1e-8 && la < UNEVEN * lb && lb < UNEVEN * la && a.angle(&b) < CORNER_RAD
    }

    /// Point `i` and the points of the leg after it.
    fn leg(&self, i: usize, turning: &mut Turning) {
        turning.push(self.points.q(i), self.points.t_s(i), self.timed, self.points.origin(i));
        if i + 1 >= self.points.end() {
            return;
        }
        let (before, after) = (self.smooth(i), self.smooth(i + 1));
        if !before && !after {
            return;
        }
        let middle = self.arc(i, before, after, 0.5);
        let straight: Vec<f64> =
            self.points.q(i).iter().zip(self.points.q(i + 1)).map(|(a, b)| 0.5 * (a + b)).collect();
        let sagitta = (middle - self.robot.tcp_m(&straight)).norm();
        let parts = (sagitta / self.chord_m).sqrt().ceil().min(MOST_PER_LEG);
        if parts.is_nan() || parts < 2.0 {
            return;
        }
        let (t0, t1) = (self.points.t_s(i), self.points.t_s(i + 1));
        for k in 1..parts as usize {
            let share = k as f64 / parts;
            let q = self.joints(i, before, after, share);
            let origin = between(self.points.origin(i), self.points.origin(i + 1), share);
            turning.push(&q, t0 + share * (t1 - t0), self.timed, origin);
            let ends = self.points.q(i).iter().zip(self.points.q(i + 1));
            turning.set_given(ends.map(|(a, b)| a + share * (b - a)).collect());
        }
    }

    /// Point of the smooth TCP path at `share` of the leg.
    fn arc(&self, i: usize, before: bool, after: bool, share: f64) -> Vector3<f64> {
        let first = || arc(self.x(i - 1), self.x(i), self.x(i + 1), 1.0 + share);
        let second = || arc(self.x(i), self.x(i + 1), self.x(i + 2), share);
        match (before, after) {
            (true, true) => first() * (1.0 - share) + second() * share,
            (true, false) => first(),
            _ => second(),
        }
    }

    /// Joints at `share` of the leg, on the smooth TCP path.
    fn joints(&self, i: usize, before: bool, after: bool, share: f64) -> Vec<f64> {
        let n = self.robot.dof();
        let range = i - usize::from(before)..=i + 1 + usize::from(after);
        let parabola = |k: usize, from: usize| {
            let h0 = (self.x(from + 1) - self.x(from)).norm();
            let h1 = (self.x(from + 2) - self.x(from + 1)).norm();
            let s = if from == i { share * h0 } else { h0 + share * h1 };
            let p = |m: usize| self.points.q(from + m)[k];
            let (d0, d1) = ((p(1) - p(0)) / h0, (p(2) - p(1)) / h1);
            p(0) + s * d0 + s * (s - h0) * (d1 - d0) / (h0 + h1)
        };
        let mut q: Vec<f64> = (0..n)
            .map(|k| match (before, after) {
                (true, true) => (1.0 - share) * parabola(k, i - 1) + share * parabola(k, i),
                (true, false) => parabola(k, i - 1),
                _ => parabola(k, i),
            })
            .collect();
        let moving: Vec<usize> =
            (0..n).filter(|&k| range.clone().any(|m| self.points.q(m)[k] != self.points.q(i)[k])).collect();
        let straight = |k: usize| self.points.q(i)[k] + share * (self.points.q(i + 1)[k] - self.points.q(i)[k]);
        let most = |k: usize| {
            let p = |m: usize| self.points.q(m)[k];
            2.0 * OVERSHOOT * range.clone().skip(1).map(|m| (p(m) - p(m - 1)).abs()).fold(0.0, f64::max)
        };
        let want = self.arc(i, before, after, share);
        let start = q.clone();
        let mut columns = vec![Vector3::zeros(); n];
        for _ in 0..3 {
            let miss = want - self.robot.chain().position_and_jacobian(&q, &mut columns);
            if miss.norm() < 1e-10 {
                break;
            }
            let mut gram = Matrix3::zeros();
            for &k in &moving {
                gram += columns[k] * columns[k].transpose();
            }
            // directions in which these joints cannot move the TCP are left as they are
            let eps = 1e-6 * gram.trace().max(f64::MIN_POSITIVE);
            let Ok(pseudo) = gram.pseudo_inverse(eps) else { return start };
            let step = pseudo * miss;
            for &k in &moving {
                q[k] += columns[k].dot(&step);
            }
        }
        let sound = q
            .iter()
            .zip(self.robot.axis_joints())
            .all(|(v, j)| v.is_finite() && j.limits.is_none_or(|[lo, hi]| *v >= lo && *v <= hi));
        // joints that the TCP does not settle stay near the straight way, too
        let near = |q: &[f64]| (0..n).all(|k| (q[k] - straight(k)).abs() <= most(k));
        match (sound && near(&q), near(&start)) {
            (true, _) => q,
            (false, true) => start,
            _ => (0..n).map(straight).collect(),
        }
    }
}

/// Point on the arc through three points: parameter 0 at `a`, 1 at `b`, 2 at `c`; the share of the angle within each part.
fn arc(a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>, parameter: f64) -> Vector3<f64> {
    let line = |p: Vector3<f64>, q: Vector3<f64>, s: f64| p + (q - p) * s;
    let (u, v) = (b - a, c - a);
    let normal = u.cross(&v);
    let flat = normal.norm_squared();
    let straight = || if parameter < 1.0 { line(a, b, parameter) } else { line(b, c, parameter - 1.0) };
    // sagitta below a nanometre or so: a straight line
    if flat <= 1e-18 * u.norm_squared() * v.norm_squared() {
        return straight();
    }
    let centre = a + (v.norm_squared() * normal.cross(&u) + u.norm_squared() * v.cross(&normal)) / (2.0 * flat);
    let axis = normal / flat.sqrt();
    let turned = |from: Vector3<f64>, to: Vector3<f64>, s: f64| {
        let (r0, r1) = (from - centre, to - centre);
        let angle = r0.cross(&r1).dot(&axis).atan2(r0.dot(&r1)) * s;
        centre + r0 * angle.cos() + axis.cross(&r0) * angle.sin()
    };
    if parameter < 1.0 { turned(a, b, parameter) } else { turned(b, c, parameter - 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_lies_on_its_circle_and_passes_its_points() {
        let on = |deg: f64| Vector3::new(1.0 + 0.25 * deg.to_radians().cos(), 2.0, 0.25 * deg.to_radians().sin());
        let (a, b, c) = (on(10.0), on(12.0), on(15.0));
        for (s, deg) in [(0.0, 10.0), (0.5, 11.0), (1.0, 12.0), (1.5, 13.5), (2.0, 15.0)] {
            assert!((arc(a, b, c, s) - on(deg)).norm() < 1e-12, "{s}");
        }
    }

    #[test]
    fn a_straight_line_stays_straight() {
        let p = |x: f64| Vector3::new(x, 2.0 * x, -x);
        assert!((arc(p(0.0), p(1.0), p(3.0), 1.25) - p(1.5)).norm() < 1e-12);
    }
}
