//! `lostmotion identify deadzone`.

use super::common::{LogArgs, ResultArgs, Shown};
use crate::cli::exit::bad;
use crate::cli::progress::during;
use crate::cli::{logs, page};
use crate::error::Place;
use crate::gaps::file::{self, number};
use crate::identify::deadzone::{self, Options, display, document};
use crate::io::keyed::Keyed;
use crate::robot::{JointKind, Robot};
use anyhow::Result;
use std::path::PathBuf;

/// Estimate deadzones from sweeps of one joint at a time, from tip positions alone (Cursi (2022), algorithm 1).
///
/// Move one joint back and forth with growing amplitude, from zero to its full range, while the other joints stand still;
/// then the next joint. Log the commands and the tip. After each reversal of the motor the tip stands still until the motor
/// has crossed the deadzone. The size of the deadzone is the motor travel from the reversal to the point where the moving
/// branch, extrapolated, meets the resting position of the tip. Half of it is the half gap that `fit` and `rewrite` use. A
/// growing sweep reverses at many positions, so the gap is found as a function of position.
///
/// The tracker's frame and the lengths of the robot need not be known. A coupled joint is tested through the joint that
/// drives it. A log has the columns t_s, cmd_<joint>_deg (or _mm), x_mm, y_mm and z_mm; it may contain the sweeps of several
/// joints, one after another.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lostmotion identify deadzone --robot robot.yaml --log sweeps.csv.gz --output gaps.yaml
  lostmotion identify deadzone --robot robot.yaml --log e1.csv --log e2.csv --json | jq '.joints[] | {joint, half_gap_deg, ci95}'
  lostmotion identify deadzone --robot robot.yaml --log sweeps.csv --eps-motor-deg-s 0.05 --eps-tip-mm-s 1   # also as printed

Reading the result: \"deadzones\" is the number of deadzones that were crossed. The JSON document also counts reversals inside the gap,
strokes that were too short and reversals without tracker readings. An interval that contains 0 means that no gap was found.")]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    #[command(flatten)]
    pub input: LogArgs,
    /// Joint to evaluate; repeat the option for several joints [default: every joint that moves alone]
    #[arg(long = "joint", value_name = "JOINT")]
    pub joints: Vec<String>,
    /// The tip counts as standing still within this distance of where it stopped, um [default: 5 standard deviations of the
    /// tracker's noise, estimated from the log]
    #[arg(long, value_name = "UM")]
    pub rest_um: Option<f64>,
    /// Largest movement of a revolute joint's command that counts as noise and not as a reversal, deg [default: estimated
    /// from the log]
    #[arg(long, value_name = "DEG")]
    pub deadband_deg: Option<f64>,
    /// The same for prismatic joints, mm
    #[arg(long, value_name = "MM")]
    pub deadband_mm: Option<f64>,
    /// Report also the result of algorithm 1 exactly as printed, with this threshold of motor speed, deg/s (mm/s for a
    /// prismatic joint)
    #[arg(long, value_name = "DEG_S", requires = "eps_tip_mm_s")]
    pub eps_motor_deg_s: Option<f64>,
    /// Threshold of tip speed for algorithm 1 as printed, mm/s
    #[arg(long, value_name = "MM_S", requires = "eps_motor_deg_s")]
    pub eps_tip_mm_s: Option<f64>,
    #[command(flatten)]
    pub result: ResultArgs,
}

/// What algorithm 1 exactly as printed finds on a joint.
#[derive(serde::Serialize)]
struct AsPrinted {
    deadzones: usize,
    #[serde(flatten)]
    mean: Keyed<Option<serde_json::Value>>,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let opened = args.result.open(&args.input, &[("--robot", Some(args.robot.as_path()))])?;
    let robot = Robot::load(&args.robot)?;
    let options = options(&args, &robot)?;
    let logs = logs::load_free(&args.input.logs, args.input.columns.as_deref(), &robot)?;
    logs::refuse_repeats(&logs)?;
    let found = during("identify", || deadzone::identify(&robot, &logs, &options))?;
    let mut doc = document::document(&found, &robot);
    let mut as_printed = String::new();
    if let (Some(motor), Some(tip)) = (args.eps_motor_deg_s, args.eps_tip_mm_s) {
        for (i, (sweeps, sizes)) in
            deadzone::as_printed(&robot, &logs, &options, &found, motor, tip * 1e-3).iter().enumerate()
        {
            let kind = robot.axis(*sweeps).kind;
            let (n, unit) = (sizes.len(), kind.unit());
            let mean = (n > 0).then(|| kind.to_user_unit(sizes.iter().sum::<f64>() / n as f64));
            let fields = AsPrinted { deadzones: n, mean: Keyed::new("mean_deadzone", unit, mean.map(number)) };
            doc["joints"][i]["as_printed"] = file::value(&fields)?;
            let mean = mean.map_or(String::new(), |m| format!(", mean size {m:.5} {unit}"));
            as_printed += &format!("algorithm 1 as printed, {}: {n} deadzones{mean}\n", robot.axis(*sweeps).name);
        }
    }
    let shown =
        Shown { document: &doc, table: &(display::table(&found, &robot) + &as_printed), notes: &found.gaps.notes };
    args.result.finish(opened, &shown, || page::gaps::of_deadzones(&robot, &found))
}

/// Every value checked.
fn options(args: &Args, robot: &Robot) -> Result<Options> {
    let positive = |flag: &str, v: Option<f64>| match v {
        Some(x) if !(x.is_finite() && x > 0.0) => {
            Err(bad(Place::file(flag.to_string()), x.to_string(), "a finite number above 0"))
        }
        v => Ok(v),
    };
    let rest_m = positive("--rest-um", args.rest_um)?.map(|v| v * 1e-6);
    let deg = positive("--deadband-deg", args.deadband_deg)?.map(f64::to_radians);
    let mm = positive("--deadband-mm", args.deadband_mm)?.map(|v| v * 1e-3);
    positive("--eps-motor-deg-s", args.eps_motor_deg_s)?;
    positive("--eps-tip-mm-s", args.eps_tip_mm_s)?;
    let deadband = robot.axis_joints().map(|j| if j.kind == JointKind::Revolute { deg } else { mm }).collect();
    let mut axes = Vec::new();
    for name in &args.joints {
        match robot.axis_named(name.trim()) {
            Some(axis) => axes.push(axis),
            None => {
                let expected = format!("a joint with its own command: {}", robot.axis_names().join(", "));
                return Err(bad(Place::file("--joint"), format!("`{name}`"), expected));
            }
        }
    }
    Ok(Options { axes, rest_m, deadband })
}
