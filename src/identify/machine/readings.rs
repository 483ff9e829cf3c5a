//! What the instrument of a log reads: the coordinates of a tracker, one reading a row of a ballbar or a dial, or sensors of joints.
//!
//! Whatever is estimated moves joints and TCP; a reading sees a part of that ([`crate::machine::measurement`]). The one reading of a
//! ballbar or a dial stands in the first of the three coordinates of a bin; the other two are zero in readings and columns alike, and add
//! nothing to any sum. A sensor after a gear sees its joint alone, so each sensor of a log is an instrument by itself; it stands there
//! as what its joint moves the TCP by at its usual lever, so that sizes in metres mean the same for all instruments.
//!
//! The centre of a ballbar bends its readings, and by millimetres it is not known. Where it is not given it is fitted first, with the
//! bar's length alone: lost motion and geometry leave it within some tenths of a millimetre, about which it is linear.

use super::frame;
use crate::error::{Error, Place, Result, counted};
use crate::gaps::{Note, Registered};
use crate::identify::scalar::setup::{self, LEAST_ROWS, Setup};
use crate::log::Log;
use crate::machine::measurement::Instrument;
use crate::numerics::least_squares::{Function, Options, minimise};
use crate::robot::Robot;
use nalgebra::{DMatrix, Isometry3, Point3, Vector3};

/// Rows from which the centre of a ballbar is fitted first.
const CENTRED_BY: usize = 1000;
/// Standard deviations of the centre about the middle of the commanded circle, and of what else is in all readings alike, m.
const SET_UP_M: f64 = 5e-3;
const ELSE_M: f64 = 1e-4;

/// Least lever of a joint whose sensor is read, m: one that turns about the TCP is seen by its sensor all the same.
const LEAST_LEVER_M: f64 = 0.1;
/// Rows from which a lever is computed.
const LEVERED_BY: usize = 200;

/// Travel (rad, m) above which a joint moves.
const MOVES: [f64; 2] = [1e-5, 1e-6];

/// Axes of a log that move.
pub fn moving(log: &Log, robot: &Robot) -> Vec<usize> {
    log.moving(robot, MOVES)
}

/// The instrument of a log, and its readings.
pub struct Readings<'a> {
    /// Its centre as fitted.
    pub instrument: Instrument,
    /// Whether the centre was given, or need not be.
    pub given: bool,
    /// Whole distances, whose zero is known.
    pub whole: bool,
    log: &'a Log,
    /// Tracker to base frame.
    frame: Isometry3<f64>,
    single: &'a [Option<f64>],
    /// What a single reading counts from, m: a zero that is not known.
    zero_m: f64,
    /// Metres at the TCP of a unit of a joint sensor (rad, m); 1 of other instruments.
    pub lever: f64,
}

impl<'a> Readings<'a> {
    /// The instruments of a log: the TCP of a tracker; else its single reading; else the sensors of the joints that move.
    ///
    /// # Errors
    /// Where a log has none of them, a dial has no direction, or readings cannot be in their unit.
    pub fn of_log(robot: &Robot, log: &'a Log, setup: &Setup, registered: Option<&Registered>) -> Result<Vec<Self>> {
        refuse_poses(log)?;
        if !log.tcp_m.is_empty() || log.instruments.has_scalar() {
            return Ok(vec![Self::new(robot, log, setup, registered)?]);
        }
        let sensed = |a: &usize| log.meas.get(*a).is_some_and(Option::is_some);
        let moving: Vec<usize> = moving(log, robot).into_iter().filter(sensed).collect();
        let all: Vec<Self> = moving.into_iter().filter_map(|a| Self::of_sensor(robot, log, a)).collect();
        if all.is_empty() {
            let found = if log.meas.iter().any(Option::is_some) {
                "joint sensors of no joint that moves"
            } else {
                "no columns `x_mm,y_mm,z_mm`"
            };
            let expected = "the measured TCP of each row, readings of a ballbar (`r_mm`, `r_um`) or a dial (`dial_um`), or sensors of \
                            the joints that move (`meas_<joint>`)";
            return Err(Error::bad(Place::file(&log.name), found, expected));
        }
        Ok(all)
    }

    /// The sensor of a joint; `None` where too few rows have a reading.
    pub fn of_sensor(robot: &Robot, log: &'a Log, axis: usize) -> Option<Self> {
        let single = log.meas.get(axis)?.as_deref()?;
        let off: Vec<f64> = single.iter().zip(&log.cmd[axis]).filter_map(|(m, c)| Some((*m)? - c)).collect();
        if off.len() < LEAST_ROWS {
            return None;
        }
        let mut jacobian = vec![Vector3::zeros(); robot.dof()];
        let each = (log.len() / LEVERED_BY).max(1);
        let squares: Vec<f64> = (0..log.len())
            .step_by(each)
            .map(|i| {
                robot.chain().position_and_jacobian(&log.command(i), &mut jacobian);
                jacobian[axis].norm_squared()
            })
            .collect();
        let lever = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt().max(LEAST_LEVER_M);
        Some(Self {
            instrument: Instrument::Joint { axis },
            given: true,
            whole: false,
            log,
            frame: Isometry3::identity(),
            single,
            zero_m: lever * off.iter().sum::<f64>() / off.len() as f64,
            lever,
        })
    }

    /// The TCP of a tracker, or a single reading of it.
    fn new(robot: &Robot, log: &'a Log, setup: &Setup, registered: Option<&Registered>) -> Result<Self> {
        let single = log.instruments.scalar().unwrap_or_default();
        let mut out = Self {
            instrument: Instrument::Tcp,
            given: true,
            whole: false,
            log,
            frame: Isometry3::identity(),
            single,
            zero_m: 0.0,
            lever: 1.0,
        };
        if let (false, Some(all)) = (log.tcp_m.is_empty(), registered) {
            out.frame = frame::own_frame(robot, log, all)?;
            return Ok(out);
        }
        let rows: Vec<usize> = (0..log.len()).filter(|i| single[*i].is_some()).collect();
        if rows.len() < LEAST_ROWS {
            let found = format!("{} with a reading", counted(rows.len(), "row"));
            return Err(Error::bad(Place::file(&log.name), found, format!("{LEAST_ROWS} or more")));
        }
        setup::plausible(robot, log, setup)?;
        out.instrument = setup::instrument(robot, log, setup)?;
        out.whole = log.instruments.distance_m.is_some();
        out.given = setup.centre_m.is_some();
        let each = (rows.len() / CENTRED_BY).max(1);
        let points: Vec<(Vector3<f64>, f64)> =
            rows.iter().step_by(each).filter_map(|i| Some((robot.tcp_m(&log.command(*i)), single[*i]?))).collect();
        if let (Instrument::Distance { centre_m }, false) = (&mut out.instrument, out.given) {
            *centre_m = centre(&points, *centre_m, out.whole);
        }
        if !out.whole {
            let off = points.iter().filter_map(|(p, r)| Some(r - out.instrument.reading(p)?));
            out.zero_m = off.sum::<f64>() / points.len() as f64;
        }
        Ok(out)
    }

    /// Whether the log has the coordinates of the TCP.
    pub fn is_tcp(&self) -> bool {
        self.instrument == Instrument::Tcp
    }

    /// Rows with a reading.
    pub fn good(&self) -> Vec<bool> {
        if self.is_tcp() {
            self.log.tcp_m.iter().map(Option::is_some).collect()
        } else {
            self.single.iter().map(Option::is_some).collect()
        }
    }

    /// Reading of a row less that of the nominal TCP.
    pub fn deviation(&self, row: usize, nominal: &Vector3<f64>) -> Option<Vector3<f64>> {
        if self.is_tcp() {
            return Some((self.frame * Point3::from(self.log.tcp_m[row]?)).coords - nominal);
        }
        if let Instrument::Joint { axis } = self.instrument {
            let off = self.lever * (self.single[row]? - self.log.cmd[axis][row]) - self.zero_m;
            return Some(Vector3::new(off, 0.0, 0.0));
        }
        let off = self.single[row]? - self.zero_m - self.instrument.reading(nominal)?;
        Some(Vector3::new(off, 0.0, 0.0))
    }

    /// The axis that a joint sensor sees; `None`: the instrument sees the TCP.
    pub fn sensed(&self) -> Option<usize> {
        match self.instrument {
            Instrument::Joint { axis } => Some(axis),
            _ => None,
        }
    }

    /// The log that is read.
    pub fn log(&self) -> &'a Log {
        self.log
    }

    /// What to say of an instrument that was fitted.
    pub fn note(&self) -> Option<Note> {
        match self.instrument {
            Instrument::Distance { centre_m: c } if !self.given => {
                Some(Note::BallbarCentre { log: self.log.name.clone(), centre_m: c.into() })
            }
            _ => None,
        }
    }
}

/// Refuses settled poses.
fn refuse_poses(log: &Log) -> Result<()> {
    if !log.poses {
        return Ok(());
    }
    let (found, expected) = ("settled poses (no column `t_s`)", "samples of a motion with times `t_s`");
    Err(Error::bad(Place::file(&log.name), found, expected))
}

/// Centre of a ballbar by distances of nominal points, about where it was looked for; with the bar's length where that is not known.
fn centre(points: &[(Vector3<f64>, f64)], about: Vector3<f64>, whole: bool) -> Vector3<f64> {
    let rows = points.len() + 3;
    let prior = (ELSE_M / SET_UP_M) * (points.len() as f64).sqrt();
    let at = |p: &[f64]| about + Vector3::new(p[0], p[1], p[2]);
    let residuals = |p: &[f64]| -> Vec<f64> {
        let c = at(p);
        let of = |(x, r): &(Vector3<f64>, f64)| (x - c).norm() + p[3] - r;
        points.iter().map(of).chain((0..3).map(|k| prior * p[k])).collect()
    };
    let jacobian = |p: &[f64]| {
        let c = at(p);
        DMatrix::from_fn(rows, 4, |i, k| match points.get(i) {
            Some((x, _)) if k < 3 => -(x - c).normalize()[k],
            Some(_) => f64::from(u8::from(!whole)),
            None => prior * f64::from(u8::from(i - points.len() == k)),
        })
    };
    let length = points.iter().map(|(x, r)| r - (x - about).norm()).sum::<f64>() / points.len().max(1) as f64;
    let start = vec![0.0, 0.0, 0.0, if whole { 0.0 } else { length }];
    let options = Options { max_steps: 50, initial_damping: 1e-3, ..Options::default() };
    let found = minimise(&mut Function::new(residuals, jacobian), start, &options);
    if found.point.iter().all(|v| v.is_finite()) { at(&found.point) } else { about }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_of_a_ballbar_is_found_whether_or_not_its_length_is_known() {
        let about = Vector3::new(1.0, 0.2, 0.8);
        let true_centre = about + Vector3::new(2e-3, -3e-3, 1e-3);
        for (whole, short) in [(true, 0.0), (false, 0.15)] {
            let points: Vec<(Vector3<f64>, f64)> = (0..400)
                .map(|i| {
                    let a = f64::from(i) * 0.03;
                    let p = about + 0.15 * Vector3::new(a.cos(), a.sin(), 0.3 * (2.0 * a).sin());
                    (p, (p - true_centre).norm() - short)
                })
                .collect();
            let off = (centre(&points, about, whole) - true_centre).norm();
            // the prior draws it a little
            assert!(off < 5e-5, "{whole}: {off}");
        }
    }
}
