//! `lostmotion identify static`.

use super::common::{LogArgs, ResultArgs, SetupArgs, Shown};
use crate::cli::exit::bad;
use crate::cli::progress::during;
use crate::cli::{logs, page};
use crate::error::Place;
use crate::identify::static_test::{self, Knots, Options, display, document};
use crate::log::dwells::DwellOptions;
use crate::model::Model;
use crate::robot::Robot;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Estimate half gaps from bidirectional dwells: the joint reaches each angle from below and from above.
///
/// Move one joint at a time. Reach a test angle from below, stand still for one second, overshoot it by 2 degrees, reach it
/// from above and stand still again. Do this at least four times, then go to the next angle. Log the commands and the TCP
/// all the time. Half the difference between the two approaches is the half gap of the joint at that angle: geometry errors,
/// gravity and the tracker's frame cancel.
///
/// A log has the columns t_s, cmd_<joint>_deg (or _mm), x_mm, y_mm and z_mm. Without t_s, each row is one settled pose, in
/// the order of the visits. The columns trigger and cycle mark the dwells; without them, the dwells are found from the
/// commands. If the log has columns meas_<joint>_deg (secondary encoders), they are used instead of the TCP. A log without a
/// TCP may have dial_um (a dial gauge, with --direction) or r_mm or r_um (a ballbar, with --centre). The commands show which
/// joint is tested. One log may test several joints, and several logs may test the same joint.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lostmotion identify static --robot robot.yaml --log axis1.csv --log axis2.csv.gz --output gaps.yaml
  lostmotion identify static --robot robot.yaml --log poses.csv --json | jq '.joints[] | {joint, half_gap_deg, ci95}'
  lostmotion identify static --model machine.yaml --log axis6.csv   # the registration is already known

Reading the result: an interval that contains 0 means that no gap was found (\"not significant\"). \"varies\" shows whether the gap
depends on the position of the joint (p below 0.001); its schedule then has a knot at each tested angle. Between tested angles the
shape of a gap that varies is a guess: test at more angles for a better schedule.")]
#[command(override_usage = "lostmotion identify static [OPTIONS] <--robot <FILE>|--model <FILE>> --log <FILE>...")]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "FILE", required_unless_present = "model")]
    pub robot: Option<PathBuf>,
    #[command(flatten)]
    pub input: LogArgs,
    /// Model file (YAML) with a known registration of the tracker [default: the registration is estimated from the logs]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    #[command(flatten)]
    pub setup: SetupArgs,
    #[command(flatten)]
    pub result: ResultArgs,
    /// Shortest standstill that counts as a dwell, s; used if no column trigger or cycle marks the dwells
    #[arg(long, value_name = "S", default_value_t = 0.5)]
    pub min_dwell_s: f64,
    /// Time at the start of such a dwell that is left out because the servo still settles, s [default: 0.2, at most a third
    /// of the dwell]
    #[arg(long, value_name = "S")]
    pub settle_s: Option<f64>,
    /// Schedule of a gap that varies with position
    #[arg(long, value_enum, default_value_t = KnotsArg::All)]
    pub knots: KnotsArg,
}

/// Knots of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum KnotsArg {
    /// The best single curve of few parameters
    Few,
    /// A knot at every tested angle: the most accurate
    All,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    if !(args.min_dwell_s.is_finite() && args.min_dwell_s > 0.0) {
        return Err(bad(Place::file("--min-dwell-s"), args.min_dwell_s.to_string(), "seconds above 0"));
    }
    if let Some(s) = args.settle_s
        && !(s.is_finite() && s >= 0.0)
    {
        return Err(bad(Place::file("--settle-s"), s.to_string(), "seconds, 0 or more"));
    }
    let opened =
        args.result.open(&args.input, &[("--robot", args.robot.as_deref()), ("--model", args.model.as_deref())])?;
    let (robot, registration) = machine(args.robot.as_deref(), args.model.as_deref())?;
    let logs = logs::load(&args.input.logs, args.input.columns.as_deref(), &robot)?;
    logs::refuse_repeats(&logs)?;
    let options = Options {
        dwell: DwellOptions { min_s: args.min_dwell_s, settle_s: args.settle_s },
        knots: if args.knots == KnotsArg::Few { Knots::Few } else { Knots::All },
        registration,
        setup: args.setup.checked()?,
    };
    let found = during("identify", || static_test::identify(&robot, &logs, &options))?;
    let doc = document::document(&found, &robot);
    let shown = Shown { document: &doc, table: &display::table(&found, &robot), notes: &found.gaps.notes };
    args.result.finish(opened, &shown, || page::gaps::of_static(&robot, &found))
}

/// The robot, and the registration where a model brings one.
fn machine(robot: Option<&Path>, model: Option<&Path>) -> Result<(Robot, Option<nalgebra::Isometry3<f64>>)> {
    let given = robot.map(Robot::load).transpose()?;
    let Some(path) = model else {
        return match given {
            Some(r) => Ok((r, None)),
            None => Err(bad(Place::file("--robot"), "no robot", "--robot FILE or --model FILE")),
        };
    };
    let model = Model::load(path)?;
    if let Some(r) = &given
        && r.fingerprint() != model.robot.fingerprint()
    {
        return Err(bad(
            Place::file(crate::error::shown(path)),
            format!("a model of another robot, `{}`", model.robot.name),
            format!("a model of `{}`, or no --robot", r.name),
        ));
    }
    Ok((given.unwrap_or(model.robot), model.registration))
}
