//! `lostmotion diagnose`: model + logs -> what the model lacks, and the model with it inside.

use crate::cli::exit::{bad, no};
use crate::cli::identify::common::SetupsArgs;
use crate::cli::progress::during;
use crate::cli::{logs, page, paths};
use crate::diagnose::result::display;
use crate::diagnose::{self, Diagnosis};
use crate::error::{Error, Place, is_stdio};
use crate::io::output::{self, Output};
use crate::model::Model;
use crate::robot::Robot;
use crate::schemas;
use anyhow::Result;
use std::io::Write;
use std::path::PathBuf;

/// Find where a model and measured logs disagree, and name the effects that the model lacks.
///
/// Every effect of the catalogue is tried on every joint. Effects that are found are added to the model and everything is
/// fitted again, until only noise is left. If the logs cannot tell two effects apart, both are reported, with an experiment
/// that decides between them. Structure that no effect describes is reported as unknown.
///
/// Examples:
///   lostmotion diagnose --robot robot.yaml --log log.csv
///   lostmotion diagnose --model machine.yaml --log log.csv
///   lostmotion diagnose --model machine.yaml --log slow.csv --log fast.csv --model-out found.yaml --report report.html
///   lostmotion diagnose --model machine.yaml --log log.csv --columns map.yaml --json > diagnosis.json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
#[command(
    override_usage = "lostmotion diagnose [OPTIONS] <--model <MODEL.yaml>|--robot <ROBOT.yaml>> --log <LOG.csv>..."
)]
pub struct Args {
    /// Model file (YAML): the robot and its known effects
    #[arg(long, value_name = "MODEL.yaml", required_unless_present = "robot", conflicts_with = "robot")]
    pub model: Option<PathBuf>,
    /// Robot file (YAML) instead of a model: no effect is known, and the tracker's frame is estimated
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: Option<PathBuf>,
    /// Log to diagnose (CSV, or .csv.gz); repeat the option to fit several logs together
    #[arg(long = "log", required = true, value_name = "LOG.csv")]
    pub logs: Vec<PathBuf>,
    /// Column map (YAML): translates other column names, units and separators of the logs
    #[arg(long, value_name = "MAP.yaml")]
    pub columns: Option<PathBuf>,
    #[command(flatten)]
    pub setups: SetupsArgs,
    /// Write the model with the effects found and the estimated frame to this file
    #[arg(long, value_name = "MODEL.yaml")]
    pub model_out: Option<PathBuf>,
    /// Exit with code 1 if the residual with all effects found exceeds this value: rms per coordinate, um (gap.final_rms_um
    /// in the document)
    #[arg(long, value_name = "GAP")]
    pub max_gap_um: Option<f64>,
    /// Print the diagnosis as one JSON document on standard output
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let mut inputs = vec![("--model", args.model.as_deref()), ("--robot", args.robot.as_deref())];
    inputs.extend(args.logs.iter().map(|l| ("--log", Some(l.as_path()))));
    inputs.push(("--columns", args.columns.as_deref()));
    if let Some(most) = args.max_gap_um.filter(|m| !(m.is_finite() && *m >= 0.0)) {
        return Err(bad(Place::file("--max-gap-um"), most.to_string(), "a number of 0 or more"));
    }
    let outputs = [("--model-out", args.model_out.as_deref()), ("--report", args.report.as_deref())];
    paths::refuse_shared(&inputs, &outputs)?;
    let to_stdout = outputs.iter().find(|(_, path)| path.is_some_and(is_stdio));
    if let Some((option, _)) = to_stdout.filter(|_| args.json) {
        return Err(bad(Place::file(*option), "`-` and --json", "one document on standard output"));
    }
    let mut model_out = output::create(args.model_out.as_deref())?;
    let mut report = output::create(args.report.as_deref())?;
    let (model, name) = match (&args.model, &args.robot) {
        (Some(path), _) => (Model::load(path)?, crate::error::shown(path)),
        (None, Some(path)) => (Model::ideal(Robot::load(path)?), crate::error::shown(path)),
        (None, None) => {
            return Err(bad(Place::default(), "no machine", "--model MODEL.yaml or --robot ROBOT.yaml"));
        }
    };
    let mut read = logs::load(&args.logs, args.columns.as_deref(), &model.robot).map_err(|e| bad_data(e, args.json))?;
    logs::refuse_repeats(&read)?;
    args.setups.tell(&mut read)?;
    let outcome =
        during("diagnose", || diagnose::diagnose(&model, &read)).map_err(|e| bad_data(e.into(), args.json))?;
    let diagnosis = diagnose::result::document::of(&outcome);
    if let (Some(out), Some(path)) = (&mut model_out, &args.model_out) {
        let text = schemas::editor_line(path, "model") + &diagnose::model_with(&model, &outcome).to_yaml_inline()?;
        out.write_all(text.as_bytes()).map_err(|e| Error::io("--model-out", "write", e))?;
    }
    page::write(&mut report, || page::diagnose::of(&name, &outcome, &diagnosis))?;
    let story = display::story(&diagnosis);
    if to_stdout.is_some() {
        eprint!("{story}");
        output::commit([model_out, report])?;
        return within(&args, &diagnosis);
    }
    let mut stdout = Output::create(std::path::Path::new("-"))?;
    if args.json {
        let text = serde_json::to_string_pretty(&diagnosis).unwrap_or_default();
        writeln!(stdout, "{text}").map_err(|e| Error::io("standard output", "write", e))?;
    } else {
        stdout.write_all(story.as_bytes()).map_err(|e| Error::io("standard output", "write", e))?;
    }
    output::commit([model_out, report, Some(stdout)])?;
    within(&args, &diagnosis)
}

/// `--max-gap-um`: the answer is no where more remains.
fn within(args: &Args, diagnosis: &Diagnosis) -> Result<()> {
    let Some(most) = args.max_gap_um else { return Ok(()) };
    let left = diagnosis.gap.final_rms_um;
    if left <= most {
        return Ok(());
    }
    Err(no(format!("a gap of {} remains, more than --max-gap-um {most}", diagnosis.unit.with(left))))
}

/// The document where the log cannot be diagnosed.
#[derive(serde::Serialize)]
struct BadData {
    schema: &'static str,
    verdict: &'static str,
    reason: String,
}

/// A log whose units, axes, times or columns are wrong: with `--json` the verdict is printed too.
fn bad_data(error: anyhow::Error, json: bool) -> anyhow::Error {
    if json && error.downcast_ref().is_some_and(Error::is_bad_input) {
        let reason = error.to_string();
        let document = BadData { schema: diagnose::result::document::SCHEMA, verdict: "bad_data", reason };
        let text = serde_json::to_string_pretty(&document).unwrap_or_default() + "\n";
        // the reason is printed in any case: a reader that has gone is no further failure
        let _ = output::write_whole(std::path::Path::new("-"), text.as_bytes());
    }
    error
}
