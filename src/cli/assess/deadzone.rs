//! `lostmotion assess deadzone`.

use super::{print, print_json, table};
use crate::assess::deadzone::{Assessment, Left, assess};
use crate::cli::{logs, paths};
use crate::program::Program;
use crate::robot::Robot;
use anyhow::Result;
use std::path::PathBuf;

/// Report the deadzones of a motion without and with compensation (Cursi (2022), Table I).
///
/// The joints move one at a time. Both logs are compared with the nominal program: a deadzone is the part of the nominal
/// motion after a reversal during which the tip stands still. The command reports the mean size for each joint, and the
/// share that compensation removes.
///
/// Examples:
///   lostmotion assess deadzone --robot robot.yaml --nominal random.csv --before before.csv
///   lostmotion assess deadzone --robot robot.yaml --nominal random.csv \
///       --before before.csv --after after.csv --json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: PathBuf,
    /// Program before compensation (joint-space CSV with t_s)
    #[arg(long, value_name = "PROGRAM.csv")]
    pub nominal: PathBuf,
    /// Log of the run without compensation
    #[arg(long, value_name = "LOG.csv")]
    pub before: PathBuf,
    /// Log of the run with compensation
    #[arg(long, value_name = "LOG.csv")]
    pub after: Option<PathBuf>,
    /// Column map (YAML): translates other column names, units and separators of a log
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
    /// Print the result as one JSON document (lostmotion/deadzone/1) instead of the table
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let inputs = [
        ("--robot", Some(args.robot.as_path())),
        ("--nominal", Some(args.nominal.as_path())),
        ("--before", Some(args.before.as_path())),
        ("--after", args.after.as_deref()),
        ("--columns", args.columns.as_deref()),
    ];
    paths::refuse_shared(&inputs, &[])?;
    let robot = Robot::load(&args.robot)?;
    let nominal = Program::load(&args.nominal, &robot)?;
    let paths: Vec<PathBuf> = std::iter::once(&args.before).chain(&args.after).cloned().collect();
    let logs = logs::load_free(&paths, args.columns.as_deref(), &robot)?;
    let Some(before) = logs.first() else { return Ok(()) };
    let result = assess(&robot, &nominal, before, logs.get(1))?;
    for note in &result.notes {
        eprintln!("note: {note}");
    }
    if args.json { print_json(&result.document(&robot)) } else { print(&text(&result, &robot)) }
}

fn text(result: &Assessment, robot: &Robot) -> String {
    let mut header = vec!["joint", "", "deadzones", "mean size", "95 %"];
    if result.joints.iter().any(|j| j.after.is_some()) {
        header.extend(["after:\ndeadzones", "mean size", "95 %", "reduction"]);
    }
    let mut table = table(&header);
    for j in &result.joints {
        let kind = robot.axis(j.axis).kind;
        let of = |l: &Left| {
            let [lo, hi] = l.ci95.map(|v| kind.to_user_unit(v));
            [l.deadzones.to_string(), format!("{:.4}", kind.to_user_unit(l.mean)), format!("{lo:.4} .. {hi:.4}")]
        };
        let mut row = vec![robot.axis(j.axis).name.clone(), kind.unit().into()];
        row.extend(of(&j.before));
        if let Some(a) = &j.after {
            row.extend(of(a));
            row.push(j.reduction().map_or("-".into(), |r| format!("{:.1} %", 100.0 * r)));
        }
        table.add_row(row);
    }
    format!("{table}\n")
}
