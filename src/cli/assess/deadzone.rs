//! `lostmotion assess deadzone`.

use super::runs::{Runs, RunsArgs};
use crate::assess::deadzone::{Assessment, Left, assess};
use crate::cli::print::{print, print_json, table};
use crate::cli::{logs, paths};
use crate::robot::Robot;
use anyhow::Result;

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
#[command(mut_arg("nominal", |a| a.help("Program before compensation (joint-space CSV with t_s)")))]
// an argument that is changed goes to the end of the usage line: this one follows it
#[command(mut_arg("before", |a| a))]
pub struct Args {
    #[command(flatten)]
    pub runs: RunsArgs,
    /// Print the result as one JSON document (lostmotion/deadzone/1) instead of the table
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    paths::refuse_shared(&args.runs.inputs(), &[])?;
    let Runs { robot, nominal, before, after } = args.runs.load(logs::load_free)?;
    let result = assess(&robot, &nominal, &before, after.as_ref())?;
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
