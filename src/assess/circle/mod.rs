//! A measured circle, before and after compensation (Zhang (2023) sections 5 and 6.2, Table 5, Figures 7 and 12).
//!
//! Method: the program gives the nominal circle, its reversals and its last full revolution ([`nominal`]); a log's rows of
//! that revolution give the best-fit plane and circle ([`fit`]), their errors in the plane (radial) and out of it, averaged
//! over [`SMOOTHING_S`]; the error of a reversal is the largest within [`WINDOW_DEG`] of the circle around it. *Beyond
//! nominal* are these errors minus those of the program's own chords at the same place, which hide the result otherwise:
//! 200 chords on a radius of 250 mm leave a sagitta of 31 um. The tracker is registered to the base by the commanded
//! positions; only the place on the circle and the sense of its normal depend on that, not the errors.
//!
//! Assumes that the log runs the program, or a compensated version of it, from its start. A drift within the revolution
//! counts as error; an error that turns the whole circle into another circle or plane does not.
//!
//! Modules:
//! - [`nominal`]: what the program commands.
//! - [`fit`]: plane and circle.
//! - [`measured`]: one log against it.
//! - [`joints`]: joint errors against the nominal program at the same place.
//! - [`document`]: the result as JSON.
//! - [`mod@note`]: what a reader should know.

pub(crate) mod document;
pub(crate) mod fit;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod joints;
pub(crate) mod measured;
pub(crate) mod nominal;
pub mod note;

pub use fit::CircleFit;
pub use measured::{Measured, ReversalError, Trace};
pub use nominal::Nominal;
pub use note::{Note, Remark};

use crate::error::Result;
use crate::log::Log;
use crate::program::Program;
use crate::robot::Robot;

/// Errors are averaged over this time, s.
pub const SMOOTHING_S: f64 = 1.0;

/// Degrees of the circle before and after a reversal within which its largest error is looked for.
pub const WINDOW_DEG: [f64; 2] = [-0.9, 7.2];

/// One circle, before and maybe after.
#[derive(Debug, Clone)]
pub struct Assessment {
    /// The circle as it was commanded.
    pub nominal: Nominal,
    /// The log without compensation.
    pub before: Measured,
    /// The log with compensation, where one was given.
    pub after: Option<Measured>,
    /// How often deviations of each size occur, before and after.
    pub histogram: Histogram,
    /// What cannot be determined, and why.
    pub notes: Vec<Note>,
}

/// Total errors of all rows, counted in bins from 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Histogram {
    /// Width of a class, m.
    pub width_m: f64,
    /// Number of rows in each class without compensation.
    pub before: Vec<u64>,
    /// Number of rows in each class with compensation; empty without such a log.
    pub after: Vec<u64>,
}

/// Assesses one log, or two.
pub fn assess(robot: &Robot, program: &Program, before: &Log, after: Option<&Log>) -> Result<Assessment> {
    let nominal = Nominal::new(robot, program)?;
    let before = Measured::new(robot, &nominal, before)?;
    let after = after.map(|log| Measured::new(robot, &nominal, log)).transpose()?;
    let histogram = Histogram::new(&before, after.as_ref());
    let mut notes = notes_on(&nominal);
    for m in [Some(&before), after.as_ref()].into_iter().flatten() {
        notes.extend(m.notes.iter().map(|remark| Note::Log { log: m.name.clone(), remark: remark.clone() }));
    }
    Ok(Assessment { nominal, before, after, histogram, notes })
}

impl Assessment {
    /// Share of a reversal's total error that compensation took away; `None` without a log after it.
    pub fn reduction(&self, reversal: usize) -> Option<f64> {
        let before = self.before.reversals.get(reversal)?.total_m?;
        let after = self.after.as_ref()?.reversals.get(reversal)?.total_m?;
        (before > 0.0).then(|| 1.0 - after / before)
    }

    /// The same of the error beyond nominal.
    pub fn reduction_beyond_nominal(&self, reversal: usize) -> Option<f64> {
        let before = self.before.reversals.get(reversal)?.beyond_nominal_m?;
        let after = self.after.as_ref()?.reversals.get(reversal)?.beyond_nominal_m?;
        (before > 0.0).then(|| 1.0 - after / before)
    }
}

fn notes_on(nominal: &Nominal) -> Vec<Note> {
    let mut notes = Vec::new();
    let turns = nominal.revolutions();
    if !nominal.closed() {
        notes.push(Note::Arc { travel_deg: nominal.travel_deg });
    } else if turns < 2.0 - 1e-4 {
        notes.push(Note::FewRevolutions { revolutions: turns });
    }
    if nominal.reversals.is_empty() {
        notes.push(Note::NoReversal);
    }
    notes
}

impl Histogram {
    /// At most 40 bins of 1, 2 or 5 times a power of ten.
    fn new(before: &Measured, after: Option<&Measured>) -> Self {
        let largest = after.map_or(before.total_max_m, |a| a.total_max_m.max(before.total_max_m));
        if largest <= 0.0 {
            return Self::default();
        }
        let least = largest / 40.0;
        let power = 10f64.powf(least.log10().floor());
        let width_m = [1.0, 2.0, 5.0, 10.0].map(|k| k * power).into_iter().find(|w| *w >= least).unwrap_or(least);
        let bins = (largest / width_m).floor() as usize + 1;
        let count = |m: &Measured| {
            let mut n = vec![0u64; bins];
            for t in &m.totals_m {
                n[((t / width_m) as usize).min(bins - 1)] += 1;
            }
            n
        };
        Self { width_m, before: count(before), after: after.map(count).unwrap_or_default() }
    }
}
