//! Arcs in a plane: from words to an angle and back. Lengths in any one unit.
//!
//! `u` and `v` are the plane's axes in the order X-Y (G17), Z-X (G18), Y-Z (G19): seen against the third axis, G3 runs from `u`
//! to `v`. Centres from a radius: the left of the chord for G3 with up to half a turn, the right for G2 (NISTIR 6556, 3.5.3).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// An arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    /// Axes of the robot.
    pub u: usize,
    pub v: usize,
    pub centre: [f64; 2],
    /// At the start and at the end: as written, they differ by rounding.
    pub radius: [f64; 2],
    /// Angle of the start, and how far it runs; negative: G2.
    pub from: f64,
    pub sweep: f64,
}

/// Differences of the radii that controls take (Grbl: 5 um, else 0.1 %), mm.
const RADII_MM: f64 = 0.005;
const RADII_SHARE: f64 = 1e-3;
/// Ends nearer than this are one point: a full turn, mm.
const SAME_MM: f64 = 1e-7;

/// Why a block with G2 or G3 is no arc.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoArc {
    /// Start or end stands on the centre.
    #[error("an arc without a radius")]
    WithoutRadius,
    /// Start and end differ in their distance from the centre by more than controls take.
    #[error("an arc whose ends have different radii")]
    UnequalRadii,
    /// Its radius does not say on which side of the chord the centre stands.
    #[error("an arc by its radius that ends where it starts")]
    Closed,
    /// The chord is longer than the diameter.
    #[error("an arc whose radius does not reach its end")]
    OutOfReach,
    /// The plane is not known.
    #[error("no plane G17, G18 or G19 is certain here")]
    NoPlane,
    /// An axis of the plane is no linear axis of the robot.
    #[error("an arc in a plane whose axes the robot file does not have")]
    ForeignPlane,
    /// The start is not known.
    #[error("an arc, and the position before it is not known")]
    NoStart,
    /// `P` asks for more than one turn.
    #[error("an arc of several turns")]
    SeveralTurns,
    /// The third of `I`, `J` and `K` is given.
    #[error("a centre outside of the plane")]
    OutsidePlane,
    /// An absolute centre of one coordinate.
    #[error("G90.1 and not both words of the centre")]
    HalfCentre,
    /// An absolute centre where X words are diameters.
    #[error("G90.1 where X is a diameter: its centre may be one, too")]
    CentreAcross,
    /// `R` stands beside `I`, `J` or `K`, or nothing does.
    #[error("an arc with a radius and a centre, or with neither")]
    NoCentre,
}

impl Arc {
    /// From the centre. `Err`: why it is none.
    pub fn about(axes: [usize; 2], from: [f64; 2], to: [f64; 2], centre: [f64; 2], ccw: bool) -> Result<Self, NoArc> {
        let ray = |p: [f64; 2]| [p[0] - centre[0], p[1] - centre[1]];
        let (a, b) = (ray(from), ray(to));
        let radius = [a[0].hypot(a[1]), b[0].hypot(b[1])];
        let off = (radius[0] - radius[1]).abs();
        if radius.iter().any(|r| r.is_nan() || *r <= 1e-6) {
            return Err(NoArc::WithoutRadius);
        }
        if off > RADII_MM && off > RADII_SHARE * radius[0].min(radius[1]) {
            return Err(NoArc::UnequalRadii);
        }
        let [start, end] = [a[1].atan2(a[0]), b[1].atan2(b[0])];
        let chord = (to[0] - from[0]).hypot(to[1] - from[1]);
        let turn = if ccw { (end - start).rem_euclid(TAU) } else { (start - end).rem_euclid(TAU) };
        let turn = if chord < SAME_MM || turn == 0.0 { TAU } else { turn };
        Ok(Self { u: axes[0], v: axes[1], centre, radius, from: start, sweep: if ccw { turn } else { -turn } })
    }

    /// From the radius; negative: more than half a turn.
    pub fn of_radius(axes: [usize; 2], from: [f64; 2], to: [f64; 2], r: f64, ccw: bool) -> Result<Self, NoArc> {
        let chord = [to[0] - from[0], to[1] - from[1]];
        let length = chord[0].hypot(chord[1]);
        if length < SAME_MM {
            return Err(NoArc::Closed);
        }
        let square = r * r - 0.25 * length * length;
        // rounding of a half turn
        if square.is_nan() || square <= -RADII_MM * r.abs().max(1.0) {
            return Err(NoArc::OutOfReach);
        }
        let height = square.max(0.0).sqrt() / length;
        let side = if ccw == (r > 0.0) { 1.0 } else { -1.0 };
        let centre =
            [0.5 * (from[0] + to[0]) - side * height * chord[1], 0.5 * (from[1] + to[1]) + side * height * chord[0]];
        let arc = Self::about(axes, from, to, centre, ccw)?;
        // at half a turn rounding must not choose the other side
        let wanted = if r > 0.0 { arc.sweep.abs() <= PI + 1e-6 } else { arc.sweep.abs() >= PI - 1e-6 };
        if !wanted {
            return Err(NoArc::OutOfReach);
        }
        Ok(arc)
    }

    /// The point at a share of the way.
    pub fn at(&self, share: f64) -> [f64; 2] {
        let angle = self.from + share * self.sweep;
        let r = self.radius[0] + share * (self.radius[1] - self.radius[0]);
        [self.centre[0] + r * angle.cos(), self.centre[1] + r * angle.sin()]
    }

    /// Shares at which an axis turns, by `least` at least on both sides and no nearer than `apart` to an end.
    pub fn quadrants(&self, least: f64, apart: f64) -> Vec<f64> {
        let (lo, hi) =
            if self.sweep > 0.0 { (self.from, self.from + self.sweep) } else { (self.from + self.sweep, self.from) };
        let first = (lo / FRAC_PI_2).floor() as i64;
        let r = self.radius[0].min(self.radius[1]);
        let seen = |angle: f64| r * (1.0 - angle.min(PI).cos()) > least && r * angle > apart;
        let mut shares: Vec<f64> = (first..=first + 6)
            .map(|k| k as f64 * FRAC_PI_2)
            .filter(|q| *q > lo && *q < hi && seen(q - lo) && seen(hi - q))
            .map(|q| (q - self.from) / self.sweep)
            .collect();
        shares.sort_by(f64::total_cmp);
        shares
    }
}

/// How an arc's centre is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Centre {
    /// I, J, K from the start of the arc.
    Relative,
    /// I, J, K in the frame of the words (G90.1).
    Absolute,
    Radius,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centre_and_radius_describe_the_same_quarter() {
        for ccw in [true, false] {
            let to = if ccw { [0.0, 5.0] } else { [0.0, -5.0] };
            let a = Arc::about([0, 1], [5.0, 0.0], to, [0.0, 0.0], ccw).unwrap();
            let b = Arc::of_radius([0, 1], [5.0, 0.0], to, 5.0, ccw).unwrap();
            assert!((a.sweep.abs() - FRAC_PI_2).abs() < 1e-12 && (a.sweep - b.sweep).abs() < 1e-12);
            assert!(b.centre[0].abs() < 1e-12 && b.centre[1].abs() < 1e-12);
            let long = Arc::of_radius([0, 1], [5.0, 0.0], to, -5.0, ccw).unwrap();
            assert!((long.sweep.abs() - 3.0 * FRAC_PI_2).abs() < 1e-12);
        }
    }

    #[test]
    fn a_circle_turns_at_its_quadrants() {
        let circle = Arc::about([0, 1], [5.0, 0.0], [5.0, 0.0], [0.0, 0.0], true).unwrap();
        assert_eq!(circle.quadrants(1e-5, 0.0).len(), 3);
        let p = circle.at(circle.quadrants(1e-5, 0.0)[0]);
        assert!(p[0].abs() < 1e-12 && (p[1] - 5.0).abs() < 1e-12);
        let clockwise = Arc::about([0, 1], [3.0, 4.0], [3.0, -4.0], [0.0, 0.0], false).unwrap();
        assert_eq!(clockwise.quadrants(1e-5, 0.0).len(), 1);
        // an end that stands beside a quadrant by rounding
        let corner = Arc::about([0, 1], [0.055, -0.192], [-0.005, 0.2], [0.0, 0.0], true).unwrap();
        assert_eq!([0.0, 0.01].map(|apart| corner.quadrants(1e-5, apart).len()), [2, 1]);
    }

    #[test]
    fn what_is_no_arc_is_named() {
        assert!(Arc::about([0, 1], [5.0, 0.0], [0.0, 6.0], [0.0, 0.0], true).is_err());
        assert!(Arc::of_radius([0, 1], [5.0, 0.0], [-5.0, 0.0], 4.0, true).is_err());
        assert!(Arc::of_radius([0, 1], [5.0, 0.0], [5.0, 0.0], 4.0, true).is_err());
    }
}
