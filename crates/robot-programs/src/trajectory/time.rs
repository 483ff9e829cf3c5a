//! Times of new points: when a share of a way has been gone, in the digits in which the format writes it.

use super::read::{Point, Time, Trajectory};
use super::spline::{self, Order, State};
use super::{RATE_DECIMALS, fine, state};
use crate::script::number;

/// Last digit of a time, s. The format's own parts are nanoseconds.
const TIME_DIGIT_S: f64 = 1e-9;

/// What shares of the way between two points mean.
pub(super) struct Shares {
    order: Order,
    /// The joint of the robot that goes furthest, at both ends; `None`: shares are those of the time.
    leading: Option<(State, State)>,
    from_s: f64,
    h_s: f64,
}

impl Shares {
    /// On a way with its own turns shares are those of the time, else those of the way of the joint that goes furthest.
    pub(super) fn of(t: &Trajectory, (before, p): (&Point, &Point), axes: &[Option<usize>]) -> Self {
        let timed = !super::turns(t, before, p, axes).is_empty();
        let ends = |c: usize| (state(t, before, c), state(t, p, c));
        let ours = (0..axes.len()).filter(|&c| axes.get(c).is_some_and(Option::is_some)).map(ends);
        let way = |e: &(State, State)| (e.1.p - e.0.p).abs();
        let leading = ours.max_by(|a, b| way(a).total_cmp(&way(b))).unwrap_or_default();
        Self {
            order: p.order_from(before),
            leading: (!timed).then_some(leading),
            from_s: before.t_s,
            h_s: p.t_s - before.t_s,
        }
    }

    /// The time of a share of the way to `p`, as it is written and in s.
    pub(super) fn time(&self, p: &Point, share: f64) -> (String, f64) {
        let x = match self.leading {
            Some((from, to)) => spline::time_share(self.order, from, to, self.h_s, share),
            None => share,
        };
        text(&p.time, self.from_s + x * self.h_s)
    }

    /// The share of the time at which a point of a share of the way to `p` stands, as its time is written.
    pub(super) fn of_time(&self, p: &Point, share: f64) -> f64 {
        (self.time(p, share).1 - self.from_s) / self.h_s
    }
}

/// A time as it is written (`s.nnnnnnnnn` for parts), and what it then is, s. Positions and velocities belong to the time that
/// is written.
fn text(form: &Time, t_s: f64) -> (String, f64) {
    let text = match form {
        Time::Seconds(n) => fine(t_s, n.style, number::decimals_for(n.style, TIME_DIGIT_S, RATE_DECIMALS)),
        Time::Parts { .. } => format!("{t_s:.9}"),
    };
    let t_s = match form {
        Time::Seconds(_) => text.parse().unwrap_or(f64::NAN),
        Time::Parts { .. } => {
            let (s, ns) = text.split_once('.').unwrap_or((&text, "0"));
            s.parse::<f64>().unwrap_or(f64::NAN) + ns.parse::<f64>().unwrap_or(f64::NAN) * 1e-9
        }
    };
    (text, t_s)
}
