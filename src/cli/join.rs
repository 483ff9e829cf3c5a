//! `lostmotion join`: a tracker's and a controller's recordings on one clock.

use crate::cli::columns;
use crate::cli::exit::bad;
use crate::cli::paths;
use crate::cli::progress::during;
use crate::error::{Error, Place, counted, is_stdio, shown};
use crate::io::bag::TopicChoice;
use crate::io::output::{self, Output};
use crate::join::{self, Options, Report, Rows};
use crate::log::ColumnMap;
use crate::log::recording::Recording;
use crate::robot::Robot;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Join a controller's and a tracker's recordings of the same motion into one log.
///
/// The motion itself synchronises the clocks: the speed of the TCP gives a first estimate, and the path gives the offset and
/// the drift with their 95 % intervals. Readings are not smoothed, and reversals stay where they are. The columns have the
/// names of docs/log.md, or a column map translates them: your own file, or a built-in map (rtde, rws, rsi for controllers,
/// tracker).
///
/// Examples:
///   lostmotion join --robot robot.yaml --controller rtde.csv --controller-columns rtde --tracker export.csv --tracker-columns tracker --output log.csv
///   lostmotion join --robot robot.yaml --controller joints.csv --tracker points.csv --output log.csv --json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: PathBuf,
    /// Recording of the controller: t_s and the command of every joint (CSV, or .csv.gz)
    #[arg(long, value_name = "CONTROLLER.csv")]
    pub controller: PathBuf,
    /// Column map of the controller's recording: a file, or the built-in rtde, rws or rsi
    #[arg(long, value_name = "MAP")]
    pub controller_columns: Option<PathBuf>,
    /// Recording of the tracker: t_s, x_mm, y_mm, z_mm (CSV, or .csv.gz)
    #[arg(long, value_name = "TRACKER.csv")]
    pub tracker: PathBuf,
    /// Column map of the tracker's recording: a file, or the built-in tracker
    #[arg(long, value_name = "MAP")]
    pub tracker_columns: Option<PathBuf>,
    /// Write the joined log to this file; `-` for standard output
    #[arg(long, short, value_name = "LOG.csv", default_value = "-")]
    pub output: PathBuf,
    /// Rows of the joined log
    #[arg(long, value_enum, default_value_t = RowsOf::Tracker)]
    pub rows: RowsOf,
    /// Controller time minus tracker time, known to about 1 s; needed if the motion repeats
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    pub near_s: Option<f64>,
    /// Print the result as one JSON document (lostmotion/join/1) on standard output; needs --output FILE
    #[arg(long)]
    pub json: bool,
}

/// `--rows`.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum RowsOf {
    /// The tracker's readings, with interpolated commands
    Tracker,
    /// The controller's rows, with interpolated readings
    Controller,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let inputs = [
        ("--robot", Some(args.robot.as_path())),
        ("--controller", Some(args.controller.as_path())),
        ("--tracker", Some(args.tracker.as_path())),
    ];
    paths::refuse_shared(&inputs, &[("--output", Some(args.output.as_path()))])?;
    paths::refuse_program_ending("--output", Some(&args.output))?;
    if args.json && is_stdio(&args.output) {
        let expected = "a file, because standard output contains the document";
        return Err(bad(Place::file("--output"), "standard output with --json", expected));
    }
    if let Some(near) = args.near_s.filter(|v| !v.is_finite()) {
        return Err(bad(Place::file("--near-s"), format!("{near}"), "a finite number of seconds"));
    }
    let mut out = Output::create(&args.output)?;
    let robot = Robot::load(&args.robot)?;
    let map = |path: &Option<PathBuf>| path.as_deref().map(ColumnMap::load).transpose();
    let hinted = |e: Error| {
        let of_tracker = matches!(&e, Error::UnknownHeader(bad) if bad.place.file == shown(&args.tracker));
        let (file, given, option) = match of_tracker {
            true => (&args.tracker, &args.tracker_columns, "--tracker-columns"),
            false => (&args.controller, &args.controller_columns, "--controller-columns"),
        };
        columns::with_hint(e, file, given.as_deref(), &robot, option)
    };
    let load = |file: &Path, given: &Option<PathBuf>, wanted| -> Result<Recording> {
        Recording::load(file, &robot, map(given)?.as_ref(), wanted).map_err(|e| hinted(e).into())
    };
    let controller = load(&args.controller, &args.controller_columns, TopicChoice::Joints)?;
    let tracker = load(&args.tracker, &args.tracker_columns, TopicChoice::Places)?;
    let rows = match args.rows {
        RowsOf::Tracker => Rows::Tracker,
        RowsOf::Controller => Rows::Controller,
    };
    let joined = during("join", || join::join(&robot, &controller, &tracker, &Options { rows, near_s: args.near_s }))
        .map_err(hinted)?;
    out.put(&joined.table.to_csv())?;
    let mut document = args.json.then(|| Output::create(Path::new("-"))).transpose()?;
    if let Some(document) = &mut document {
        let text = serde_json::to_string_pretty(&joined.report).unwrap_or_default();
        document.put((text + "\n").as_bytes())?;
    }
    output::commit([Some(out), document])?;
    tell(&joined.report);
    Ok(())
}

fn tell(report: &Report) {
    for (who, part) in [("controller", &report.controller), ("tracker", &report.tracker)] {
        if let Some(jitter) = part.jitter_ms {
            eprintln!(
                "{}: the {who}'s stamps jitter by {jitter:.2} ms about a regular {:.2} Hz, which is used",
                part.name, part.rate_hz
            );
        }
    }
    let half = |i: &join::Interval| 0.5 * (i.ci95[1] - i.ci95[0]);
    let side = if report.offset_ms.value < 0.0 { "behind" } else { "ahead of" };
    let rate = if report.drift_ppm.value < 0.0 { "slower" } else { "faster" };
    let (off, off_half) = (report.offset_ms.value.abs(), half(&report.offset_ms));
    // the digits that count stand at the end of a number of hours
    let offset = if off < 10_000.0 {
        format!("{off:.3} +- {off_half:.3} ms")
    } else {
        format!("{:.6} +- {:.6} s", off * 1e-3, off_half * 1e-3)
    };
    eprintln!(
        "the controller's clock is {offset} {side} the tracker's (at its {:.1} s) and runs {:.2} +- {:.2} ppm {rate}",
        report.at_tracker_s,
        report.drift_ppm.value.abs(),
        half(&report.drift_ppm),
    );
    eprintln!("{}; the paths agree within {:.1} um rms per coordinate", counted(report.rows, "row"), report.rms_um);
    for note in &report.notes {
        eprintln!("note: {note}");
    }
}
