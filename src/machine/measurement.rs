//! What an instrument reads of a robot: one model for every instrument.
//!
//! | instrument | reading | log columns |
//! | --- | --- | --- |
//! | [`Instrument::Tcp`] | position of the TCP in the tracker's frame | `x_mm,y_mm,z_mm` |
//! | [`Instrument::Distance`] | distance from a fixed point to the TCP (double ballbar, draw wire) | `r_mm`, or `r_um` off its nominal length |
//! | [`Instrument::Direction`] | displacement of the TCP along a fixed direction (dial gauge, probe, linear scale) | `dial_um` |
//! | [`Instrument::Joint`] | one joint after its gear (secondary encoder, level) | `meas_<joint>_deg` |
//!
//! Every reading is differentiable, so that an identification, a diagnosis and a plan use the same sensitivities:
//! `d reading / d joint = G J`, with `J` the joint's column of the Jacobian of the TCP and `G` the gradient here. Positions are in
//! the robot's world frame.
//!
//! Each quantity that an instrument does not know is a separate nuisance ([`Instrument::nuisances`]): the frame of a tracker, centre and
//! length of a ballbar, zero and tilt of a dial gauge.

use nalgebra::{Unit, Vector3};

/// An instrument; metres, world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instrument {
    /// Coordinates of the TCP: a laser tracker.
    Tcp,
    /// Distance of the TCP from a fixed point: a ballbar.
    Distance {
        /// The fixed point, m.
        centre_m: Vector3<f64>,
    },
    /// Movement of the TCP along a direction: a dial gauge.
    Direction {
        /// The direction in which the reading grows.
        along: Unit<Vector3<f64>>,
    },
    /// Position of one joint after its gear.
    Joint {
        /// Axis of the robot.
        axis: usize,
    },
}

/// Most readings of one row.
pub const MOST_READINGS: usize = 3;

impl Instrument {
    /// Name for people.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Tcp => "TCP position",
            Self::Distance { .. } => "distance to a fixed point",
            Self::Direction { .. } => "reading along a direction",
            Self::Joint { .. } => "joint sensor",
        }
    }

    /// Number of readings a row.
    pub fn readings(&self) -> usize {
        match self {
            Self::Tcp => 3,
            _ => 1,
        }
    }

    /// Reading of a scalar instrument for a TCP at `point`, m; `None`: the instrument has no scalar reading of the TCP.
    ///
    /// ```
    /// use lostmotion::machine::measurement::Instrument;
    /// use nalgebra::Vector3;
    /// let ballbar = Instrument::Distance { centre_m: Vector3::new(1.0, 0.0, 0.0) };
    /// assert_eq!(ballbar.reading(&Vector3::new(1.0, 0.3, 0.4)), Some(0.5));
    /// ```
    pub fn reading(&self, point: &Vector3<f64>) -> Option<f64> {
        match self {
            Self::Distance { centre_m } => Some((point - centre_m).norm()),
            Self::Direction { along } => Some(along.dot(point)),
            Self::Tcp | Self::Joint { .. } => None,
        }
    }

    /// Sensitivity of the readings to a movement of the TCP by `column` (m per rad, or m per m) at `point`.
    pub fn sensitivity(&self, point: &Vector3<f64>, column: &Vector3<f64>) -> [f64; MOST_READINGS] {
        match self {
            Self::Tcp => [column.x, column.y, column.z],
            Self::Distance { centre_m } => [unit(&(point - centre_m)).dot(column), 0.0, 0.0],
            Self::Direction { along } => [along.dot(column), 0.0, 0.0],
            Self::Joint { .. } => [0.0; MOST_READINGS],
        }
    }

    /// Sensitivities to what the instrument does not know of itself; m per m, or m per rad.
    ///
    /// TCP: three translations and three rotations of the frame. Distance: the centre's position, and the length. Direction:
    /// the zero, and two tilts.
    pub fn nuisances(&self, point: &Vector3<f64>) -> Vec<[f64; MOST_READINGS]> {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        match self {
            Self::Tcp => axes
                .iter()
                .map(|e| [e.x, e.y, e.z])
                .chain(axes.iter().map(|e| {
                    let v = e.cross(point);
                    [v.x, v.y, v.z]
                }))
                .collect(),
            Self::Distance { centre_m } => {
                let u = unit(&(point - centre_m));
                axes.iter().map(|e| [-u.dot(e), 0.0, 0.0]).chain([[1.0, 0.0, 0.0]]).collect()
            }
            Self::Direction { along } => {
                let [a, b] = across(along);
                vec![[1.0, 0.0, 0.0], [a.dot(point), 0.0, 0.0], [b.dot(point), 0.0, 0.0]]
            }
            Self::Joint { .. } => vec![[1.0, 0.0, 0.0]],
        }
    }
}

fn unit(v: &Vector3<f64>) -> Vector3<f64> {
    v.try_normalize(1e-12).unwrap_or_else(Vector3::zeros)
}

/// Two directions across a third.
fn across(along: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let helper = if along.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let a = unit(&along.cross(&helper));
    [a, along.cross(&a)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensitivities_are_the_derivatives_of_the_readings() {
        let p = Vector3::new(1.2, -0.3, 0.7);
        let column = Vector3::new(0.2, 0.5, -0.4);
        let instruments = [
            Instrument::Distance { centre_m: Vector3::new(0.9, 0.1, 0.6) },
            Instrument::Direction { along: Unit::new_normalize(Vector3::new(0.3, -0.9, 0.2)) },
        ];
        for i in instruments {
            let h = 1e-6;
            let read = |s: f64| i.reading(&(p + column * s)).unwrap();
            let numeric = (read(h) - read(-h)) / (2.0 * h);
            assert!((numeric - i.sensitivity(&p, &column)[0]).abs() < 1e-8, "{i:?}");
        }
    }

    #[test]
    fn a_moved_centre_of_a_ballbar_reads_as_its_nuisance_says() {
        let (p, c) = (Vector3::new(0.4, 0.2, 0.1), Vector3::new(0.1, 0.0, -0.1));
        let at = |c| Instrument::Distance { centre_m: c }.reading(&p).unwrap();
        let h = 1e-6;
        let numeric = (at(c + Vector3::y() * h) - at(c - Vector3::y() * h)) / (2.0 * h);
        let n = Instrument::Distance { centre_m: c }.nuisances(&p);
        assert!((numeric - n[1][0]).abs() < 1e-8);
    }
}
