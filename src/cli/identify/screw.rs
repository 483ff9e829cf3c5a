//! `lostmotion identify screw`.

use super::common::{LogArgs, ResultArgs, Shown};
use crate::cli::exit::bad;
use crate::cli::{logs, page};
use crate::error::Place;
use crate::identify::screw::{display, document, identify};
use crate::robot::Robot;
use anyhow::Result;
use std::path::PathBuf;

/// Estimate the two gaps in series of a screw drive: coupling (motor to screw) and nut (screw to carriage).
///
/// Move one joint up and down for at least four cycles, with strokes at least ten times as long as the gap and a stop of
/// half a second at each end. Begin with the preload of Gantry (2015): move below the start of the test, then up to it, so
/// that the gap lies on one side. Log the motor angle, the screw angle and the carriage position. Each gap is the distance
/// between the flanks of upward and downward movement: c_r - c_l of equation 2, with the slope m.
///
/// Columns: t_s; cmd_<joint>_mm; enc_<joint>_deg or _mm (motor); screw_<joint>_deg or _mm (output side of the coupling);
/// meas_<joint>_mm (carriage), or x_mm, y_mm, z_mm of a tracker, of which the one along the joint is enough. Angles are
/// screw angles; lead_mm_per_rev in the robot file converts them to mm. Without screw_<joint> the two gaps cannot be
/// separated and their sum is reported. Without enc_<joint> the command is used as the motor position. A log may test
/// several joints. Revolute joints with a sensor between coupling and gear are evaluated in the same way, in degrees.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lostmotion identify screw --robot gantry.yaml --log z.csv --output gaps.yaml
  lostmotion identify screw --robot gantry.yaml --log z.csv.gz --joint Z --json | jq '.series[] | {coupling, nut}'
  lostmotion identify screw --robot gantry.yaml --log z.csv --report gaps.html && lostmotion fit --robot gantry.yaml --gaps gaps.yaml -o c.yaml

Reading the result: `total` is the whole gap c_r - c_l; `fit` uses half of it in each direction, or c_r and -c_l if they differ
significantly. c_l and c_r refer to the zero of the columns; a tracker has no such zero. `> 0.2 mm` means that no stroke crossed
the gap: make longer strokes. `slope m` is carriage travel per commanded travel: 1 means that the lead in the robot file is right.")]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    #[command(flatten)]
    pub input: LogArgs,
    /// Joint to evaluate [default: all that move]
    #[arg(long, value_name = "JOINT")]
    pub joint: Option<String>,
    #[command(flatten)]
    pub result: ResultArgs,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let opened = args.result.open(&args.input, &[("--robot", Some(args.robot.as_path()))])?;
    let robot = Robot::load(&args.robot)?;
    let joint = match &args.joint {
        None => None,
        Some(name) => Some(robot.axis_named(name.trim()).ok_or_else(|| {
            let expected = format!("one of {}", robot.axis_names().join(", "));
            bad(Place::file("--joint"), format!("joint `{name}`"), expected)
        })?),
    };
    let logs = logs::load_lone(&args.input.logs, args.input.columns.as_deref(), &robot)?;
    logs::refuse_repeats(&logs)?;
    let found = identify(&robot, &logs, joint)?;
    let doc = document::document(&found, &robot);
    let shown = Shown { document: &doc, table: &display::table(&found, &robot), notes: &found.gaps.notes };
    args.result.finish(opened, &shown, || page::screw::of_screw(&robot, &found))
}
