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

/// Find half gaps from bidirectional dwells: every angle reached from below and from above.
///
/// Move one joint at a time. Reach each test angle from below, stand still for a second, pass it by 2 degrees, reach it from
/// above, stand still again; four cycles or more; then the next angle. Log commands and TCP while you do. Half the
/// difference between the two approaches is the half gap of that joint at that angle; geometry errors, gravity and the tracker's
/// frame cancel in it.
///
/// A log holds columns t_s, cmd_<joint>_deg (or _mm), x_mm, y_mm, z_mm; a log without t_s holds one settled pose a row, in
/// the order visited. Columns trigger and cycle mark the dwells where present, else the commands show them. Columns
/// meas_<joint>_deg (a secondary encoder) are used instead of the TCP; a log without TCP may hold dial_um (a dial gauge, with
/// --direction) or r_mm or r_um (a ballbar, with --centre). Which joint is tested is found from the commands; a log may
/// test several joints, and several logs may test one.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lostmotion identify static --robot robot.yaml --log axis1.csv --log axis2.csv.gz --output gaps.yaml
  lostmotion identify static --robot robot.yaml --log poses.csv --json | jq '.joints[] | {joint, half_gap_deg, ci95}'
  lostmotion identify static --model machine.yaml --log axis6.csv   # a registration that is already known

Reading the result: an interval that holds 0 means that no gap was found (\"not significant\"). \"varies\" tells whether the gap
depends on the position of the joint (p below 0.001); its schedule then has a knot at each tested angle. A gap that varies is only
as good as the test is dense: its shape between tested angles is a guess.")]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "FILE", required_unless_present = "model")]
    pub robot: Option<PathBuf>,
    #[command(flatten)]
    pub input: LogArgs,
    /// Model file whose registration is known; else it is found from the logs
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    #[command(flatten)]
    pub setup: SetupArgs,
    #[command(flatten)]
    pub result: ResultArgs,
    /// Shortest dwell in seconds, where no trigger or cycle column marks them
    #[arg(long, value_name = "S", default_value_t = 0.5)]
    pub min_dwell_s: f64,
    /// Seconds left to the servo at the start of such a dwell [default: 0.2, a third of the dwell at most]
    #[arg(long, value_name = "S")]
    pub settle_s: Option<f64>,
    /// Schedule of a gap that varies: a knot at every tested angle, or the best curve of few parameters
    #[arg(long, value_enum, default_value_t = KnotsArg::All)]
    pub knots: KnotsArg,
}

/// Knots of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum KnotsArg {
    Few,
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
