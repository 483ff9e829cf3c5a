//! `lostmotion identify path`: gaps and stiction from reversals in continuous motion.

use crate::cli::{logs, page, paths};
use crate::error::{Error, Place, Result, is_stdio};
use crate::gaps::{Gaps, file};
use crate::identify::path::{Options, PathFound, identify};
use crate::io::output::{self, write_whole};
use crate::model::Model;
use crate::robot::Robot;
use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use std::path::{Path, PathBuf};

/// Find half gaps and stiction from a log of continuous motion with reversals.
///
/// Any path on which the joints reverse will do, a slow circle best: about 1.5 mm/s at the TCP, two revolutions, all joints of
/// interest reversing at least twice. The tracker's frame need not be known. Each joint's half gap, the spike behind its
/// reversals and its decay are fitted together with the frame, with 95 % intervals.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lostmotion identify path --robot robot.yaml --log circle.csv --output gaps.yaml
  lostmotion identify path --robot robot.yaml --log a.csv.gz --log b.csv.gz --free A1,A2,A3 --json
  lostmotion identify path --robot robot.yaml --log circle.csv --known static.yaml --output gaps.yaml

Reading the result: a spike and its decay trade off against each other where a joint crosses its gap slowly; the notes give the
lag at the time behind a reversal where the log knows it best. A gap that varies along the path is better taken from a static
test and held with --known: on a path it is hard to tell from errors of the links.")]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    /// Log of a motion (CSV, .gz; `-` is standard input); several are fitted together, each with a frame of its own
    #[arg(long, value_name = "FILE", required = true)]
    pub log: Vec<PathBuf>,
    /// Column map (YAML) for a log with other names, units, separators: theirs -> ours
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
    /// Joints to report [default: all that move]; the lost motion of the others is fitted beside them
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    pub free: Vec<String>,
    /// Gaps file whose half gaps and schedules are held, for joints whose gap a static test knows
    #[arg(long, value_name = "FILE")]
    pub known: Option<PathBuf>,
    /// Model file whose gaps are held in the same way
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Write the result here (YAML; JSON where the name ends in .json); `-` is standard output
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Print the result as one JSON document
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables here
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let to_stdout = args.output.as_deref().is_some_and(is_stdio);
    if args.json && to_stdout {
        return Err(Error::bad(Place::file("--output"), "`-` together with --json", "one document on standard output"));
    }
    let inputs: Vec<paths::Named> = [
        ("--robot", Some(args.robot.as_path())),
        ("--columns", args.columns.as_deref()),
        ("--known", args.known.as_deref()),
        ("--model", args.model.as_deref()),
    ]
    .into_iter()
    .chain(args.log.iter().map(|p| ("--log", Some(p.as_path()))))
    .collect();
    paths::refuse_shared(&inputs, &[("--output", args.output.as_deref()), ("--report", args.report.as_deref())])?;
    let mut output = output::create(args.output.as_deref())?;
    let mut report = output::create(args.report.as_deref())?;
    let robot = Robot::load(&args.robot)?;
    let mut options = Options::default();
    for name in &args.free {
        let axis = robot.axis_named(name.trim()).ok_or_else(|| {
            let expected = format!("joints of {}", robot.axis_names().join(", "));
            Error::bad(Place::file("--free"), format!("joint `{name}`"), expected)
        })?;
        options.free.push(axis);
    }
    if let Some(path) = &args.known {
        options.hold_gaps(&Gaps::load(path, &robot)?);
    }
    if let Some(path) = &args.model {
        options.hold_model(&Model::load(path)?, &robot)?;
    }
    let logs = logs::load(&args.log, args.columns.as_deref(), &robot)?;
    let found = identify(&robot, &logs, &options)?;
    let document = file::document(&found.gaps, &robot);
    if let (Some(path), Some(out)) = (&args.output, &mut output) {
        let json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        let text = if json { file::to_json(&document)? } else { file::to_yaml(&document)? };
        out.put(text.as_bytes())?;
    }
    page::write(&mut report, || page::gaps::of_path(&robot, &found))?;
    output::commit([output, report])?;
    if args.json {
        write_whole(Path::new("-"), file::to_json(&document)?.as_bytes())?;
    } else if to_stdout {
        eprint!("{}", table(&found, &robot));
    } else {
        write_whole(Path::new("-"), table(&found, &robot).as_bytes())?;
    }
    for note in &found.gaps.notes {
        eprintln!("note: {note}");
    }
    Ok(())
}

/// What a person reads.
fn table(found: &PathFound, robot: &Robot) -> String {
    let mut t = Table::new();
    t.load_preset(UTF8_HORIZONTAL_ONLY);
    t.set_header(["joint", "half gap", "95 %", "stiction", "95 %", "decay s", "95 %"]);
    for j in &found.gaps.joints {
        let joint = robot.axis(j.axis);
        let edge = |v: f64| format!("{:.5}", joint.kind.to_edge(v));
        let span = |ci: [f64; 2]| format!("{} .. {}", edge(ci[0]), edge(ci[1]));
        let mark = if j.schedule.is_some() { " (varies)" } else { "" };
        let mut row = vec![
            joint.name.clone(),
            format!("{} {}{mark}", edge(j.half_gap), joint.kind.unit()),
            if j.significant { span(j.ci95) } else { format!("{} (not significant)", span(j.ci95)) },
        ];
        match &j.stiction {
            Some(s) => {
                let (crate::effect::Decay::Time(d) | crate::effect::Decay::Travel(d)) = s.decay;
                row.extend([edge(s.spike), span(s.ci95), format!("{d:.2}")]);
                row.push(format!("{:.2} .. {:.2}", s.decay_ci95[0], s.decay_ci95[1]));
            }
            None => row.extend(["none".into(), String::new(), String::new(), String::new()]),
        }
        t.add_row(row);
    }
    let mut out = format!("{t}\n");
    out.push_str(&format!("noise {:.1} um per coordinate\n", found.sigma_m * 1e6));
    out
}
