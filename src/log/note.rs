//! What a reader of a log should know, as data: suspicions that do not stop the work, and what was done to its rows. Code compares the
//! variants; the words are for readers.

use crate::robot::JointKind;
use std::fmt;

/// A remark on a log. Values of joints are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// Readings were held by the recorder.
    #[error("{columns} change only every {every_rows:.1} rows ({every_s:.3} s): {}", columns.done())]
    Held {
        /// Which columns.
        columns: Columns,
        /// Rows from one reading to the next.
        every_rows: f64,
        /// Time from one reading to the next, s.
        every_s: f64,
    },
    /// Gross errors of the tracker.
    #[error("{}", left_out(*rows, *limit_m))]
    GrossErrors {
        /// How many rows.
        rows: usize,
        /// Distance from their neighbours from which they are left out, m.
        limit_m: f64,
    },
    /// A sensor moves against the commands.
    #[error("{column} moves against the commands of {joint}: does it have the wrong sign?")]
    AgainstCommand {
        /// Name of the column, without its unit.
        column: String,
        /// Name of the joint.
        joint: String,
    },
    /// A sensor differs from the command.
    #[error("{column} differs from the command by {:.3} {} in the median", kind.to_user_unit(*median), kind.unit())]
    OffCommand {
        /// Name of the column, without its unit.
        column: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Median of the distances, rad or m.
        median: f64,
    },
    /// A sensor follows its command with a slope that is not 1.
    #[error(
        "{column} moves {slope:.3} times as far as the commands of {joint}: check the scale of the sensor and the gear ratio"
    )]
    Slope {
        /// Name of the column, without its unit.
        column: String,
        /// Name of the joint.
        joint: String,
        /// Sensor per command.
        slope: f64,
    },
    /// A joint is faster than it can be.
    #[error(
        "{joint} moves at {:.3e} {unit}/s, but its limit is {:.0}: is `t_s` in seconds, and are the commands in {unit}?",
        kind.to_user_unit(*speed), kind.to_user_unit(*limit), unit = kind.unit()
    )]
    TooFast {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// How fast it is, rad/s or m/s.
        speed: f64,
        /// How fast it can be, rad/s or m/s.
        limit: f64,
    },
    /// Times may be in milliseconds.
    #[error("rows are {apart_s} s apart and no joint is faster than 0.1 deg/s or mm/s: is `t_s` in milliseconds?")]
    SlowRows {
        /// Median time from one row to the next, s.
        apart_s: f64,
    },
    /// Rows without times that look like samples of a motion.
    #[error(
        "{rows} rows without `t_s` follow each other in small steps, like the samples of a motion, but count as settled poses: \
         if they are samples, name their time column `t_s`, or map it to `t_s` with a column map"
    )]
    SamplesWithoutTimes {
        /// How many rows.
        rows: usize,
    },
    /// A command beyond the limits of the robot file.
    #[error(
        "line {line}: {joint} is commanded to {:.3} {}, outside its limits {:.1} to {:.1}",
        kind.to_user_unit(*at), kind.unit(), kind.to_user_unit(limits[0]), kind.to_user_unit(limits[1])
    )]
    OutsideLimits {
        /// Line of the file.
        line: u32,
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Command, rad or m.
        at: f64,
        /// Limits, rad or m.
        limits: [f64; 2],
    },
    /// Another clock explains the measurement.
    #[error("{0}")]
    ClocksApart(ClocksApart),
    /// A mistake in the columns explains the measurement.
    #[error("{0}")]
    Explained(Explained),
    /// The path has another shape than the robot file's, of a machine whose kinematics is not known.
    #[error(
        "the measured path does not match the path computed with the robot file ({} of misfit on a path of {}): either the machine has other kinematics, or the robot file, or the units, the order or the clock of the columns do not belong to this log",
        millimetres(*misfit_m), millimetres(*path_m)
    )]
    OtherShape {
        /// 75th percentile of the distances, m.
        misfit_m: f64,
        /// Size of the path, m.
        path_m: f64,
    },
    /// The path differs by more than calibration errors.
    #[error(
        "the measured path differs by {} (75th percentile) from the path computed with the robot file, on a path of {}; calibration errors are at most a few millimetres: {}",
        millimetres(*misfit_m), millimetres(*path_m), to_check(tool_off_m.as_ref())
    )]
    Uncalibrated {
        /// 75th percentile of the distances, m.
        misfit_m: f64,
        /// Size of the path, m.
        path_m: f64,
        /// From the robot file's `tool` to the TCP with which the path fits, in the axes of the tool, m; `None`: no TCP makes it fit.
        tool_off_m: Option<[f64; 3]>,
    },
    /// The path fits another TCP than the robot file's.
    #[error(
        "the measured point is {} from the robot file's `tool` (in the axes of the tool): check `tool`",
        offset(tool_off_m)
    )]
    OtherTool {
        /// From the robot file's `tool` to the TCP with which the path fits, in the axes of the tool, m.
        tool_off_m: [f64; 3],
    },
}

/// Columns that a recorder writes together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Columns {
    /// Commands.
    #[error("joint positions")]
    Commands,
    /// Encoders.
    #[error("encoders")]
    Encoders,
    /// Sensors between coupling and nut.
    #[error("screws")]
    Screws,
    /// Sensors after the gear.
    #[error("joint sensors")]
    JointSensors,
    /// The tracker.
    #[error("TCP positions")]
    Tcp,
}

impl Columns {
    /// What is done with readings that were held.
    fn done(self) -> &'static str {
        if self == Self::Tcp { "repeated values are left out" } else { "interpolated between them" }
    }
}

/// Clocks of commands and measurements that are apart.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "measured positions about {:.2} s {} the commands",
    by_s.abs(), if *by_s > 0.0 { "ahead of" } else { "behind" }
)]
pub struct ClocksApart {
    /// By how much the measured positions are ahead, s; below 0: behind.
    pub by_s: f64,
}

/// Mistakes that explain why a measured path does not fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "a measured path that fits only if {} ({} instead of {} of misfit)",
    mistakes.iter().map(Mistake::to_string).collect::<Vec<_>>().join("; or if "), millimetres(*left_m), millimetres(*misfit_m)
)]
pub struct Explained {
    /// Each of them explains it alone; the commonest first.
    pub mistakes: Vec<Mistake>,
    /// Misfit with the first one mended, m.
    pub left_m: f64,
    /// Misfit as the file was read, m.
    pub misfit_m: f64,
}

/// What may be wrong with the columns of a log.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Mistake {
    /// The measured coordinates are in another unit.
    #[error("x, y and z are in {unit}")]
    TcpUnit {
        /// Which one.
        unit: &'static str,
    },
    /// The measured coordinates are a thousand times the computed ones.
    #[error("x, y and z are in micrometres, or the lengths of the robot file in metres")]
    Thousandfold,
    /// A mirrored frame.
    #[error("the measured frame is mirrored: two of x, y and z are swapped, or one has the wrong sign")]
    Mirrored,
    /// The commands of all joints are in another unit.
    #[error("the commands are in {unit}")]
    CommandUnit {
        /// Which one.
        unit: &'static str,
    },
    /// The commands of one joint are in another unit.
    #[error("the commands of {joint} are in {unit}")]
    JointUnit {
        /// Name of the joint.
        joint: String,
        /// Which unit.
        unit: &'static str,
    },
    /// The commands of a joint have the wrong sign.
    #[error("the commands of {joint} have the wrong sign")]
    Sign {
        /// Name of the joint.
        joint: String,
    },
    /// Two columns are swapped.
    #[error("the commands of {} and {} are swapped", joints[0], joints[1])]
    Swapped {
        /// Names of the joints.
        joints: [String; 2],
    },
}

/// A length for people: whole millimetres from a centimetre on.
pub(super) fn millimetres(length_m: f64) -> impl fmt::Display {
    let mm = length_m * 1e3;
    if length_m >= 0.01 { format!("{mm:.0} mm") } else { format!("{mm:.3} mm") }
}

fn left_out(rows: usize, limit_m: f64) -> String {
    let [differ, their, are] = if rows == 1 { ["row differs", "its", "is"] } else { ["rows differ", "their", "are"] };
    format!("{rows} {differ} by more than {:.2} mm from {their} neighbours and {are} left out", limit_m * 1e3)
}

fn to_check(tool_off_m: Option<&[f64; 3]>) -> String {
    match tool_off_m {
        None => "check that the file describes this robot (model, lengths) and that its zero positions are right"
            .to_string(),
        Some(off) => format!("the path fits if the TCP is {} from the robot file's `tool`: check `tool`", offset(off)),
    }
}

fn offset(off_m: &[f64; 3]) -> String {
    let [x, y, z] = off_m.map(|v| v * 1e3);
    format!("{x:.1}, {y:.1}, {z:.1} mm")
}

crate::io::in_words!(Note);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_row_and_several_are_named_as_people_do() {
        let note = |rows| Note::GrossErrors { rows, limit_m: 3e-4 }.to_string();
        assert_eq!(note(1), "1 row differs by more than 0.30 mm from its neighbours and is left out");
        assert_eq!(note(4), "4 rows differ by more than 0.30 mm from their neighbours and are left out");
    }

    #[test]
    fn mistakes_that_explain_a_path_stand_side_by_side() {
        let mistakes = vec![Mistake::Sign { joint: "A2".into() }, Mistake::Mirrored];
        let note = Note::Explained(Explained { mistakes, left_m: 0.0001, misfit_m: 0.0123 });
        assert_eq!(
            note.to_string(),
            "a measured path that fits only if the commands of A2 have the wrong sign; or if the measured frame is mirrored: two of x, y \
             and z are swapped, or one has the wrong sign (0.100 mm instead of 12 mm of misfit)"
        );
    }
}
