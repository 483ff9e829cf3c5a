//! Which reading of the two files' stamps fits best.

use super::clock::Clock;
use super::search::{self, Seen};
use super::{Options, STILL, failure, fit, refuse_repeated, rests, suspect};
use crate::error::{Error, Place, Result};
use crate::log::recording::Recording;
use crate::numerics::series::Series;
use crate::robot::Robot;
use nalgebra::Vector3;

/// A regular clock replaces the stamps only where it lowers the residual by this factor.
const CLEARLY: f64 = 0.9;
/// A fit of the clock: arm, commands, readings, start of the offset, s, and variances of the clocks that gave the stamps.
type OfClock = fn(&Robot, &Series, &Seen, f64, [f64; 2]) -> std::result::Result<fit::Fit, failure::Failure>;

/// What a fit of the clocks sees of the two files.
pub(super) struct Recordings<'a> {
    pub robot: &'a Robot,
    /// The robot by its gears.
    pub arm: &'a Robot,
    pub controller: &'a Recording,
    pub tracker: &'a Recording,
    /// Joint positions of the controller, by axis, rad or m.
    pub positions: &'a [Vec<f64>],
    /// Readings of the tracker, m.
    pub seen: &'a [Option<Vector3<f64>>],
}

/// The readings of the two files' stamps that leave least.
pub(super) struct Best<'a> {
    /// What is left, m, for comparison: larger than it is where stamps were replaced.
    pub misfit: f64,
    pub fit: fit::Fit,
    pub ours: &'a Clock,
    pub theirs: &'a Clock,
    /// Correlation of the speeds.
    pub correlation: f64,
}

impl Recordings<'_> {
    /// Fits every reading of the two files' stamps, and takes the one with the smallest residual; `geared`: positions by gears.
    pub fn best_clocks<'c>(
        &self,
        readings: &'c [Vec<Clock>; 2],
        geared: Vec<Vec<f64>>,
        options: &Options,
    ) -> Result<Best<'c>> {
        let tracker = self.tracker;
        let mut best: Option<Best> = None;
        let mut why = failure::Failure::Open;
        let still = vec![STILL; self.robot.dof()];
        let mut examined = false;
        for ours in &readings[0] {
            let series = Series::new(ours.t_s.clone(), geared.clone(), &still);
            for theirs in &readings[1] {
                let (t_s, at_m): (Vec<f64>, Vec<Vector3<f64>>) =
                    theirs.t_s.iter().zip(self.seen).filter_map(|(t, p)| p.map(|p| (*t, p))).unzip();
                let seen = Seen { t_s: &t_s, at_m: &at_m };
                let (controller, positions) = (self.controller, self.positions);
                let recorded = suspect::Recorded { controller, tracker, t_s: &ours.t_s, positions, still: &still };
                if !examined {
                    suspect::refuse_times(self.robot, &recorded, &seen)?;
                }
                let found = start(self.arm, &series, &seen, options, tracker)?;
                if !examined {
                    suspect::refuse(self.robot, &recorded, &seen, options.within(), found.misfit)?;
                    examined = true;
                }
                refuse_repeated(&found, options, tracker)?;
                let [a, b] = [ours.variances(), theirs.variances()];
                match widened_fit(self.arm, &series, &seen, found.offset_s, [a[0] + b[0], a[1] + b[1]]) {
                    Err(e) => why = e,
                    Ok(fit) => {
                        let regular = ours.jitter_s.is_some() || theirs.jitter_s.is_some();
                        let misfit = fit.rms_m * if regular { 1.0 / CLEARLY } else { 1.0 };
                        if best.as_ref().is_none_or(|b| misfit < b.misfit) {
                            best = Some(Best { misfit, fit, ours, theirs, correlation: found.correlation });
                        }
                    }
                }
            }
        }
        best.ok_or_else(|| {
            let refused = Error::bad(Place::file(&tracker.name), why.to_string(), why.expected());
            if why.near_helps() { refused.mended_by(&["near_s"]) } else { refused }
        })
    }
}

/// The fit of the clocks from a start, widened by what another method finds; `variances`: of the clocks that gave the stamps.
fn widened_fit(
    arm: &Robot,
    series: &Series,
    seen: &Seen,
    offset_s: f64,
    variances: [f64; 2],
) -> std::result::Result<fit::Fit, failure::Failure> {
    let (of_clock, other): (OfClock, OfClock) = match rests::is_test(series) {
        true => (rests::fit, rests::without_friction),
        false => (fit::fit, rests::fit),
    };
    let mut fit = of_clock(arm, series, seen, offset_s, variances)?;
    if let Ok(other) = other(arm, series, seen, fit.controller_s(fit.middle_s) - fit.middle_s, variances) {
        fit.widen(&other);
    }
    Ok(fit)
}

fn start(robot: &Robot, series: &Series, seen: &Seen, options: &Options, tracker: &Recording) -> Result<search::Found> {
    search::start(robot, series, seen, options.within()).ok_or_else(|| {
        let found = "no motion in common with the controller's recording";
        Error::bad(Place::file(&tracker.name), found, "recordings of one motion")
    })
}
