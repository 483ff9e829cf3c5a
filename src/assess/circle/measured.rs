//! One log against the nominal circle.

use super::fit::CircleFit;
use super::nominal::{Nominal, NominalReversal};
use super::note::Remark;
use super::{SMOOTHING_S, WINDOW_DEG};
use crate::assess::rigid;
use crate::error::{Error, Place, Result};
use crate::log::Log;
use crate::numerics::robust::{largest_size, median_interval};
use crate::robot::Robot;
use nalgebra::Vector3;

/// Points kept for drawing.
const DRAWN: usize = 4000;

/// Rows below which there is nothing to average.
const LEAST_ROWS: usize = 20;

/// Registration residual beyond which commands and positions do not belong together, as a share of the radius.
const TOO_FAR: f64 = 0.05;

/// Errors of one log; metres.
#[derive(Debug, Clone)]
pub struct Measured {
    /// Name of the log.
    pub name: String,
    /// SHA-256 of the log, hexadecimal.
    pub sha256: String,
    /// Rows assessed, and the rows over which errors were averaged.
    pub rows: usize,
    /// Number of rows that each point of the trace averages.
    pub averaged_rows: usize,
    /// Phases that the rows cover.
    pub covered_deg: [f64; 2],
    /// Circle through the measured points.
    pub circle: CircleFit,
    /// Root mean square distance that the registration to the robot's frame leaves, m.
    pub registration_rms_m: f64,
    /// Largest distance from the best-fit circle, m.
    pub total_max_m: f64,
    /// Root mean square distance from the best-fit circle, m.
    pub total_rms_m: f64,
    /// Largest radial deviation in the plane of the circle, m.
    pub in_plane_max_m: f64,
    /// Root mean square radial deviation in the plane of the circle, m.
    pub in_plane_rms_m: f64,
    /// Largest deviation across the plane of the circle, m.
    pub out_of_plane_max_m: f64,
    /// Root mean square deviation across the plane of the circle, m.
    pub out_of_plane_rms_m: f64,
    /// Largest distance from the circle beyond what the program's own chords leave, m.
    pub beyond_nominal_max_m: f64,
    /// Root mean square distance from the circle beyond what the program's own chords leave, m.
    pub beyond_nominal_rms_m: f64,
    /// One per reversal of [`Nominal::reversals`], in that order.
    pub reversals: Vec<ReversalError>,
    /// Deviations over the angle, for pictures.
    pub trace: Trace,
    /// What a reader should know of the log.
    pub notes: Vec<Remark>,
    pub(super) totals_m: Vec<f64>,
}

/// Largest errors within the window of a reversal; `None` where the log has no row there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReversalError {
    /// Distance from the best-fit circle, m.
    pub total_m: Option<f64>,
    /// Radial deviation in the plane of the circle, m.
    pub in_plane_m: Option<f64>,
    /// Deviation across the plane of the circle, m.
    pub out_of_plane_m: Option<f64>,
    /// Distance beyond what the program's own chords leave, m.
    pub beyond_nominal_m: Option<f64>,
}

/// At most 4,000 rows in order, for drawing; averaged errors.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Angle on the circle by the program, deg.
    pub phase_deg: Vec<f64>,
    /// Radial deviation in the plane, m.
    pub in_plane_m: Vec<f64>,
    /// Deviation across the plane, m.
    pub out_of_plane_m: Vec<f64>,
    /// Radial deviation beyond that of the program's chords, m.
    pub beyond_in_plane_m: Vec<f64>,
    /// Deviation across the plane beyond that of the program's chords, m.
    pub beyond_out_of_plane_m: Vec<f64>,
    /// Point of the best-fit circle in the base frame, and the error vector there: `ideal + k * error` is the path drawn
    /// k times too far off.
    pub ideal_m: Vec<Vector3<f64>>,
    /// Error vector at each of these points, base frame, m.
    pub error_m: Vec<Vector3<f64>>,
}

impl Measured {
    /// Errors of the rows of `log` that lie in the assessed revolution.
    pub fn new(robot: &Robot, nominal: &Nominal, log: &Log) -> Result<Self> {
        let registered = Registered::new(robot, nominal, log)?;
        let (rows, points) = registered.assessed(nominal, log)?;
        let place = || Place::file(&log.name);
        let circle = CircleFit::new(&points, &nominal.circle.normal)
            .ok_or_else(|| Error::bad(place(), "measured positions without a circle", "positions along a circle"))?;
        let mut notes = Vec::new();
        let averaged_rows = if log.poses {
            notes.push(Remark::SingleRows);
            1
        } else {
            (SMOOTHING_S / median_interval(&registered.t_s).unwrap_or(f64::INFINITY)).round().max(1.0) as usize
        };
        let phase_deg: Vec<f64> = rows.iter().map(|&i| registered.phases_deg[i]).collect();
        let errors = Errors::new(nominal, &circle, &points, phase_deg, averaged_rows);
        let covered_deg = errors.phase_deg.iter().fold([f64::MAX, f64::MIN], |[l, h], &p| [l.min(p), h.max(p)]);
        let (asked, has) = (nominal.to_deg - nominal.from_deg, covered_deg[1] - covered_deg[0]);
        if has < 0.98 * asked {
            notes.push(Remark::Covers { measured_deg: has, assessed_deg: asked });
        }
        Ok(Self {
            name: log.name.clone(),
            sha256: log.sha256.clone(),
            rows: points.len(),
            averaged_rows,
            covered_deg,
            registration_rms_m: registered.rms_m,
            total_max_m: largest(&errors.total),
            total_rms_m: rms(&errors.total),
            in_plane_max_m: largest(&errors.in_plane),
            in_plane_rms_m: rms(&errors.in_plane),
            out_of_plane_max_m: largest(&errors.out_of_plane),
            out_of_plane_rms_m: rms(&errors.out_of_plane),
            beyond_nominal_max_m: largest(&errors.beyond),
            beyond_nominal_rms_m: rms(&errors.beyond),
            reversals: nominal.reversals.iter().map(|r| errors.at(r)).collect(),
            trace: errors.trace(&circle, &points),
            circle,
            notes,
            totals_m: errors.total,
        })
    }
}

/// The measured rows of a log in the base frame, by a rigid fit to the commanded path.
struct Registered {
    t_s: Vec<f64>,
    base_m: Vec<Vector3<f64>>,
    /// Phase of the commanded position of each row.
    phases_deg: Vec<f64>,
    rms_m: f64,
}

impl Registered {
    fn new(robot: &Robot, nominal: &Nominal, log: &Log) -> Result<Self> {
        let place = || Place::file(&log.name);
        if log.tcp_m.is_empty() {
            return Err(Error::bad(place(), "no columns `x_mm,y_mm,z_mm`", "a log with measured TCP positions"));
        }
        let (mut t_s, mut want, mut seen) = (Vec::new(), Vec::new(), Vec::new());
        let mut q = vec![0.0; robot.dof()];
        for (row, p) in log.tcp_m.iter().enumerate() {
            if let Some(p) = p {
                log.command_into(row, &mut q);
                t_s.push(log.t_s[row]);
                want.push(robot.tcp_m(&q));
                seen.push(*p);
            }
        }
        let frame = rigid::fit(&seen, &want).ok_or_else(|| {
            let found = format!("{} measured positions that lie on a line or are too few", seen.len());
            Error::bad(place(), found, "positions along a circle")
        })?;
        let base_m: Vec<Vector3<f64>> = seen.iter().map(|p| frame.rotation * p + frame.translation.vector).collect();
        let squares: f64 = base_m.iter().zip(&want).map(|(a, b)| (a - b).norm_squared()).sum();
        let rms_m = (squares / (3 * base_m.len()) as f64).sqrt();
        if rms_m > TOO_FAR * nominal.circle.radius_m {
            let rms_mm = rms_m * 1e3;
            return Err(Error::bad(
                place(),
                format!("measured positions {rms_mm:.3} mm rms away from the commanded ones after the best rigid fit"),
                "commands in deg and mm, positions in mm, of this robot",
            ));
        }
        Ok(Self { t_s, base_m, phases_deg: nominal.phases_deg(&want), rms_m })
    }

    /// The rows of the revolution that is assessed, and their positions.
    fn assessed(&self, nominal: &Nominal, log: &Log) -> Result<(Vec<usize>, Vec<Vector3<f64>>)> {
        let (from_deg, to_deg) = (nominal.from_deg, nominal.to_deg);
        let phases = &self.phases_deg;
        let rows: Vec<usize> = (0..phases.len()).filter(|&i| phases[i] >= from_deg && phases[i] < to_deg).collect();
        if rows.len() < LEAST_ROWS {
            let (lo, hi) = phases.iter().fold((f64::MAX, f64::MIN), |(l, h), &p| (l.min(p), h.max(p)));
            return Err(Error::bad(
                Place::file(&log.name),
                format!("{} measured rows in the last revolution (log: {lo:.1} to {hi:.1} deg)", rows.len()),
                format!("a log that runs the program to its end ({from_deg:.1} to {to_deg:.1} deg)"),
            ));
        }
        let points = rows.iter().map(|&i| self.base_m[i]).collect();
        Ok((rows, points))
    }
}

/// Errors along the assessed revolution about the best-fit circle, averaged, m; row by row.
struct Errors {
    phase_deg: Vec<f64>,
    in_plane: Vec<f64>,
    out_of_plane: Vec<f64>,
    total: Vec<f64>,
    /// Beyond what the chords of the nominal program explain.
    beyond_in: Vec<f64>,
    beyond_out: Vec<f64>,
    beyond: Vec<f64>,
}

impl Errors {
    fn new(
        nominal: &Nominal,
        circle: &CircleFit,
        points: &[Vector3<f64>],
        phase_deg: Vec<f64>,
        averaged_rows: usize,
    ) -> Self {
        let errors: Vec<[f64; 2]> = points.iter().map(|p| circle.error_m(p)).collect();
        let [in_plane, out_of_plane] =
            [0, 1].map(|k| moving_mean(&errors.iter().map(|e| e[k]).collect::<Vec<_>>(), averaged_rows));
        let chord: Vec<[f64; 2]> = phase_deg.iter().map(|&p| nominal.chord.at(p)).collect();
        let beyond_in: Vec<f64> = in_plane.iter().zip(&chord).map(|(e, c)| e - c[0]).collect();
        let beyond_out: Vec<f64> = out_of_plane.iter().zip(&chord).map(|(e, c)| e - c[1]).collect();
        let length = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a.hypot(*b)).collect::<Vec<f64>>();
        let total = length(&in_plane, &out_of_plane);
        let beyond = length(&beyond_in, &beyond_out);
        Self { phase_deg, in_plane, out_of_plane, total, beyond_in, beyond_out, beyond }
    }

    /// The largest errors about a reversal.
    fn at(&self, r: &NominalReversal) -> ReversalError {
        ReversalError {
            total_m: within(r, &self.phase_deg, &self.total),
            in_plane_m: within(r, &self.phase_deg, &self.in_plane),
            out_of_plane_m: within(r, &self.phase_deg, &self.out_of_plane),
            beyond_nominal_m: within(r, &self.phase_deg, &self.beyond),
        }
    }

    /// Every so many rows, for drawing.
    fn trace(&self, circle: &CircleFit, points: &[Vector3<f64>]) -> Trace {
        let mut trace = Trace::default();
        for i in (0..points.len()).step_by(points.len().div_ceil(DRAWN)) {
            let outward = circle.outward(&points[i]);
            trace.phase_deg.push(self.phase_deg[i]);
            trace.in_plane_m.push(self.in_plane[i]);
            trace.out_of_plane_m.push(self.out_of_plane[i]);
            trace.beyond_in_plane_m.push(self.beyond_in[i]);
            trace.beyond_out_of_plane_m.push(self.beyond_out[i]);
            trace.ideal_m.push(circle.centre_m + outward * circle.radius_m);
            trace.error_m.push(outward * self.in_plane[i] + circle.normal * self.out_of_plane[i]);
        }
        trace
    }
}

/// Largest magnitude of `e` in the window of a reversal.
fn within(r: &NominalReversal, phase_deg: &[f64], e: &[f64]) -> Option<f64> {
    let window = r.phase_deg + WINDOW_DEG[0]..=r.phase_deg + WINDOW_DEG[1];
    phase_deg.iter().zip(e).filter(|(p, _)| window.contains(p)).map(|(_, e)| e.abs()).max_by(f64::total_cmp)
}

fn largest(e: &[f64]) -> f64 {
    largest_size(e.iter().copied())
}

fn rms(e: &[f64]) -> f64 {
    (e.iter().map(|v| v * v).sum::<f64>() / e.len().max(1) as f64).sqrt()
}

/// Mean over `width` rows around each row (one more after than ahead where even); fewer at the ends.
fn moving_mean(e: &[f64], width: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(e.len() + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for v in e {
        sum += v;
        sums.push(sum);
    }
    let ahead = (width - 1) / 2;
    let after = width - 1 - ahead;
    (0..e.len())
        .map(|i| {
            let (lo, hi) = (i.saturating_sub(after), (i + ahead + 1).min(e.len()));
            (sums[hi] - sums[lo]) / (hi - lo) as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moving_mean_is_a_box_that_shrinks_at_the_ends() {
        let got = moving_mean(&[1.0, 2.0, 3.0, 4.0, 10.0], 3);
        let want = [1.5, 2.0, 3.0, 17.0 / 3.0, 7.0];
        assert!(got.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-12), "{got:?}");
        let got = moving_mean(&[1.0, 2.0, 3.0, 4.0], 2);
        assert!(got.iter().zip([1.0, 1.5, 2.5, 3.5]).all(|(a, b)| (a - b).abs() < 1e-12), "{got:?}");
    }
}
