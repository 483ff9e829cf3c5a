//! The motion that a ROS controller makes of points, and how a new point fits into it.
//!
//! `joint_trajectory_controller` (ros2_control, "Trajectory Representation") joins two points by a straight line where they
//! have positions alone, by a cubic where they have velocities, by a quintic where they have accelerations, too; industrial
//! drivers do the same. A polynomial that is cut at a point and given its own velocity and acceleration there is the same
//! polynomial, so a new point is *its own spline plus an offset*:
//! - time: when the trajectory's own spline of the leading joint has gone the wanted share of the way. From rest that is
//!   later than the share of the time; with the share of the time the joint would have to leave its rest with a jerk;
//! - position: as asked; offset = asked - own spline;
//! - velocity: own spline's + slope of the offset. Slopes are those of a monotone interpolation of the offset over all its
//!   points (zero where it is level or turns, else the weighted harmonic mean of the slopes on both sides: F. N. Fritsch
//!   and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300, equation 6), so that the offset never overshoots;
//! - acceleration: own spline's. An offset without acceleration at its ends is monotone as long as its slopes are at most
//!   1.25 times the mean slope (Bernstein coefficients of the derivative: `a, a, 5 - 2a - 2b, b, b`).
//!
//! Where an offset holds a joint still while its own spline moves on, the velocity is zero ([`limited`]), unless that bends the
//! splines beside it by more than a small part of the offset ([`BEND_OF_VELOCITY`]).

/// Most by which a spline bends for a velocity at one of its ends, in parts of the change of velocity times its time: 4/27 of a
/// cubic, 0.2 of a quintic (at 0.28 and 0.72 of it).
pub const BEND_OF_VELOCITY: f64 = 0.2;

/// A joint at a point: position, velocity and acceleration where the file has them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct State {
    pub p: f64,
    pub v: f64,
    pub a: f64,
}

/// Kind of polynomial between two points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    Linear,
    Cubic,
    Quintic,
}

impl Order {
    /// Largest slope of an offset in parts of its mean slope.
    fn offset_slope(self) -> f64 {
        if self == Self::Quintic { 1.25 } else { 3.0 }
    }

    /// Largest end slope that a monotone polynomial of this order can have, in parts of its mean slope.
    fn end_slope(self) -> f64 {
        if self == Self::Quintic { 5.0 } else { 3.0 }
    }
}

/// The joint at share `x` (0 to 1) of a segment of `h_s` seconds. Derivatives per second.
pub fn at(order: Order, from: State, to: State, h_s: f64, x: f64) -> State {
    let d = to.p - from.p;
    let (v0, v1, a0, a1) = (from.v * h_s, to.v * h_s, from.a * h_s * h_s, to.a * h_s * h_s);
    // p(x) = from.p + c1 x + c2 x^2 + ...
    let [c1, c2, c3, c4, c5] = match order {
        Order::Linear => [d, 0.0, 0.0, 0.0, 0.0],
        Order::Cubic => [v0, 3.0 * d - 2.0 * v0 - v1, v0 + v1 - 2.0 * d, 0.0, 0.0],
        Order::Quintic => [
            v0,
            a0 / 2.0,
            10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1,
            -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1,
            6.0 * d - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1,
        ],
    };
    State {
        p: from.p + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5)))),
        v: (c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / h_s,
        a: (2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))) / (h_s * h_s),
    }
}

/// Share of the time at which a joint has gone `share` of its way. A joint that does not move, or whose
/// numbers make no sense, takes the share itself.
pub fn time_share(order: Order, from: State, to: State, h_s: f64, share: f64) -> f64 {
    let d = to.p - from.p;
    let gone = |x: f64| (at(order, from, to, h_s, x).p - from.p) / d;
    if order == Order::Linear || !(gone(0.0) <= share && gone(1.0) >= share) {
        return share;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if gone(middle) < share {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// Slope of an offset at a point, from the mean slopes before and after it over `h0` and `h1` seconds.
pub fn slope(order: Order, before: f64, h0: f64, following: f64, h1: f64) -> f64 {
    if before * following <= 0.0 {
        return 0.0;
    }
    let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
    let mean = (w0 + w1) / (w0 / before + w1 / following);
    let most = order.offset_slope() * before.abs().min(following.abs());
    within(mean, most)
}

/// A velocity that turns no command back: zero where the joint stands or turns by its points, else in their direction and
/// within what a monotone polynomial can have.
pub fn limited(order: Order, v: f64, before: f64, following: f64) -> f64 {
    if before * following <= 0.0 || v * before <= 0.0 {
        return 0.0;
    }
    let most = order.end_slope() * before.abs().min(following.abs());
    within(v, most)
}

/// `f64::clamp` panics where numbers beyond all bounds made `most` no number; what comes out is refused as such.
fn within(v: f64, most: f64) -> f64 {
    if most.is_finite() { v.clamp(-most, most) } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(p: f64, v: f64, a: f64) -> State {
        State { p, v, a }
    }

    #[test]
    fn polynomials_come_back_exactly() {
        // p = 1 - 2 t + 3 t^2 - t^3 over 0.5 to 2 s; with + 0.2 t^5 for the quintic
        let cubic =
            |t: f64| state(1.0 - 2.0 * t + 3.0 * t * t - t * t * t, -2.0 + 6.0 * t - 3.0 * t * t, 6.0 - 6.0 * t);
        let quintic = |t: f64| {
            let c = cubic(t);
            state(c.p + 0.2 * t.powi(5), c.v + t.powi(4), c.a + 4.0 * t.powi(3))
        };
        for k in 0..=10 {
            let x = f64::from(k) / 10.0;
            let t = 0.5 + 1.5 * x;
            for (order, truth) in
                [(Order::Cubic, &cubic as &dyn Fn(f64) -> State), (Order::Quintic, &quintic as &dyn Fn(f64) -> State)]
            {
                let (got, want) = (at(order, truth(0.5), truth(2.0), 1.5, x), truth(t));
                assert!((got.p - want.p).abs() < 1e-12 && (got.v - want.v).abs() < 1e-12, "{order:?} {x}");
                assert!((got.a - want.a).abs() < 1e-11, "{order:?} {x}");
            }
        }
    }

    #[test]
    fn from_rest_to_rest_the_time_follows_the_spline() {
        // 3 x^2 - 2 x^3 = 0.15625 at x = 0.25
        let x = time_share(Order::Cubic, state(1.0, 0.0, 0.0), state(3.0, 0.0, 0.0), 4.0, 0.15625);
        assert!((x - 0.25).abs() < 1e-12, "{x}");
        assert_eq!(time_share(Order::Linear, state(1.0, 0.0, 0.0), state(3.0, 0.0, 0.0), 4.0, 0.3), 0.3);
        assert_eq!(time_share(Order::Cubic, state(1.0, 0.0, 0.0), state(1.0, 0.0, 0.0), 4.0, 0.3), 0.3);
    }

    #[test]
    fn an_offset_never_overshoots_in_either_spline() {
        for order in [Order::Cubic, Order::Quintic] {
            let (t, o) = ([0.0, 0.1, 0.4, 0.5, 1.0], [0.0, 0.02, 0.3, 0.9, 0.9]);
            let mean = |k: usize| (o[k + 1] - o[k]) / (t[k + 1] - t[k]);
            let slopes: Vec<f64> = (0..5)
                .map(|k| {
                    if k == 0 || k == 4 {
                        0.0
                    } else {
                        slope(order, mean(k - 1), t[k] - t[k - 1], mean(k), t[k + 1] - t[k])
                    }
                })
                .collect();
            assert_eq!(slopes[3], 0.0);
            let mut last = 0.0;
            for k in 0..4 {
                for i in 0..=200 {
                    let ends = (state(o[k], slopes[k], 0.0), state(o[k + 1], slopes[k + 1], 0.0));
                    let p = at(order, ends.0, ends.1, t[k + 1] - t[k], f64::from(i) / 200.0).p;
                    assert!(p >= last - 1e-12, "{order:?}: {p} behind {last}");
                    last = p;
                }
            }
        }
    }

    #[test]
    fn a_held_joint_has_no_velocity() {
        assert_eq!(limited(Order::Cubic, 0.4, 0.0, 1.0), 0.0);
        assert_eq!(limited(Order::Cubic, 0.4, 1.0, -1.0), 0.0);
        assert_eq!(limited(Order::Cubic, 5.0, 1.0, 2.0), 3.0);
        assert_eq!(limited(Order::Cubic, -1.0, -1.0, -2.0), -1.0);
    }
}
