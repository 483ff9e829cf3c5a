//! `lostmotion assess circle`.

use super::runs::{Runs, RunsArgs};
use crate::assess::circle::{Assessment, Measured, assess};
use crate::cli::print::{print, print_json, table};
use crate::cli::{logs, page, paths};
use crate::io::output;
use crate::robot::Robot;
use anyhow::Result;
use std::fmt::Write;
use std::path::PathBuf;

/// Report the errors of a measured circle at the reversals of the joints, before and after compensation.
///
/// The reference is the plane and the circle fitted to the last revolution (Taubin). Errors are averaged over 1 s, and the
/// error of a reversal is the largest one from 0.9 deg of the circle before it to 7.2 deg after it. "Beyond nominal"
/// subtracts the error that the chords of the program cause. The nominal program defines where the reversals are. Run it for
/// two revolutions, and start it away from a reversal.
///
/// Examples:
///   lostmotion assess circle --robot robot.yaml --nominal circle.csv --before log.csv
///   lostmotion assess circle --robot robot.yaml --nominal circle.csv \
///       --before before.csv.gz --after after.csv --json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
#[command(mut_arg("nominal", |a| a.help("Program of the circle before compensation (joint-space CSV)")))]
// an argument that is changed goes to the end of the usage line: this one follows it
#[command(mut_arg("before", |a| a))]
#[command(mut_arg("after", |a| a.help("Log of the run with compensation; it contains the compensated commands")))]
pub struct Args {
    #[command(flatten)]
    pub runs: RunsArgs,
    /// Print the result as one JSON document (lostmotion/circle/1) instead of the tables
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    paths::refuse_shared(&args.runs.inputs(), &[("--report", args.report.as_deref())])?;
    let mut report = output::create(args.report.as_deref())?;
    let Runs { robot, nominal, before, after } = args.runs.load(logs::load)?;
    let result = assess(&robot, &nominal, &before, after.as_ref())?;
    for note in &result.notes {
        eprintln!("note: {note}");
    }
    page::write(&mut report, || page::circle::of_assessment(&robot, &result))?;
    output::commit([report])?;
    if args.json { print_json(&result.document(&robot)) } else { print(&tables(&result, &robot)) }
}

/// Reversals, then the whole path.
fn tables(result: &Assessment, robot: &Robot) -> String {
    let um = |v: Option<f64>| v.map_or("-".into(), |v| format!("{:.1}", v * 1e6));
    let percent = |v: Option<f64>| v.map_or("-".into(), |v| format!("{:.0} %", v * 100.0));
    let n = &result.nominal;
    let mut text = format!(
        "Circle of radius {:.3} mm, {:.2} revolutions; assessed: phase {:.2} to {:.2} deg, {} rows, averaged over {} rows.\n\n",
        n.circle.radius_m * 1e3,
        n.revolutions(),
        n.from_deg,
        n.to_deg,
        result.before.rows,
        result.before.averaged_rows
    );
    let mut header = vec!["reversal", "at\ndeg", "total\num", "in plane", "out of\nplane", "beyond\nnominal"];
    if result.after.is_some() {
        header.extend(["after:\ntotal", "in plane", "out of\nplane", "beyond\nnominal", "reduction\nof total"]);
    }
    let mut reversals = table(&header);
    for (i, (r, b)) in n.reversals.iter().zip(&result.before.reversals).enumerate() {
        let mut row = vec![
            robot.axis(r.axis).name.clone(),
            format!("{:.2}", r.at_deg),
            um(b.total_m),
            um(b.in_plane_m),
            um(b.out_of_plane_m),
            um(b.beyond_nominal_m),
        ];
        if let Some(a) = result.after.as_ref().and_then(|m| m.reversals.get(i)) {
            row.extend([a.total_m, a.in_plane_m, a.out_of_plane_m, a.beyond_nominal_m].map(um));
            row.push(percent(result.reduction(i)));
        }
        reversals.add_row(row);
    }
    let _ = writeln!(text, "{reversals}\n");
    let mut path = table(&["whole revolution, um", "before", "after"]);
    let after = |f: &dyn Fn(&Measured) -> f64| um(result.after.as_ref().map(f));
    let mut line = |name: &str, f: &dyn Fn(&Measured) -> f64| {
        path.add_row(vec![name.to_string(), um(Some(f(&result.before))), after(f)]);
    };
    line("total, largest", &|m| m.total_max_m);
    line("in plane, largest", &|m| m.in_plane_max_m);
    line("out of plane, largest", &|m| m.out_of_plane_max_m);
    line("beyond nominal, largest", &|m| m.beyond_nominal_max_m);
    line("in plane, rms", &|m| m.in_plane_rms_m);
    line("beyond nominal, rms", &|m| m.beyond_nominal_rms_m);
    let _ = writeln!(text, "{path}");
    text
}
