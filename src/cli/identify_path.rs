//! `lostmotion identify path`: gaps and stiction from reversals in continuous motion.

use crate::cli::exit::bad;
use crate::cli::identify::common::{LogArgs, Opened, ResultArgs, SetupArgs, Shown};
use crate::cli::progress::during;
use crate::cli::{logs, page};
use crate::effects::Decay;
use crate::error::Place;
use crate::gaps::{Gaps, file};
use crate::identify::path::{Options, PathFound, identify};
use crate::identify::scalar;
use crate::log::Log;
use crate::model::Model;
use crate::robot::Robot;
use anyhow::Result;
use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use std::path::PathBuf;

/// Estimate half gaps and stiction from logs of continuous motion with reversals.
///
/// Use any path on which the joints reverse. A slow circle is best: two revolutions at about 1.5 mm/s at the TCP, on which
/// each joint of interest reverses at least twice. The tracker's frame need not be known. The fit estimates the half gap of
/// each joint, the spike after its reversals and the decay of the spike, together with the frame, all with 95 % intervals.
/// Several logs are fitted together, each in its own frame. A log without a TCP may have the readings of a ballbar (r_mm,
/// r_um), of a dial gauge (dial_um) or of joint sensors (meas_<joint>) instead.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lostmotion identify path --robot robot.yaml --log circle.csv --output gaps.yaml
  lostmotion identify path --robot robot.yaml --log a.csv.gz --log b.csv.gz --free A1,A2,A3 --json
  lostmotion identify path --robot robot.yaml --log circle.csv --known static.yaml --output gaps.yaml

Reading the result: if a joint crosses its gap slowly, the log determines a spike and its decay only together; a note then gives the
lag at the time after a reversal at which it is best known. For a gap that varies along the path, run a static test and hold its
result with --known: on a path such a gap is hard to separate from link errors.")]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    #[command(flatten)]
    pub input: LogArgs,
    /// Joints to report [default: all that move]; the lost motion of the other joints is still fitted
    #[arg(long, value_name = "JOINTS", value_delimiter = ',')]
    pub free: Vec<String>,
    /// Gaps file (YAML) of a static test: its half gaps and schedules are held fixed
    #[arg(long, value_name = "FILE")]
    pub known: Option<PathBuf>,
    /// Model file (YAML): its gaps are held fixed
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    #[command(flatten)]
    pub setup: SetupArgs,
    #[command(flatten)]
    pub result: ResultArgs,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let opened = args.result.open(
        &args.input,
        &[
            ("--robot", Some(args.robot.as_path())),
            ("--known", args.known.as_deref()),
            ("--model", args.model.as_deref()),
        ],
    )?;
    let robot = Robot::load(&args.robot)?;
    let mut options = Options::default();
    for name in &args.free {
        let axis = robot.axis_named(name.trim()).ok_or_else(|| {
            let expected = format!("joints of {}", robot.axis_names().join(", "));
            bad(Place::file("--free"), format!("joint `{name}`"), expected)
        })?;
        options.free.push(axis);
    }
    if let Some(path) = &args.known {
        options.hold_gaps(&Gaps::load(path, &robot)?);
    }
    if let Some(path) = &args.model {
        options.hold_model(&Model::load(path)?, &robot)?;
    }
    let logs = logs::load(&args.input.logs, args.input.columns.as_deref(), &robot)?;
    if logs.iter().any(|l| l.tcp_m.is_empty() && (l.instruments.has_scalar() || l.meas.iter().any(Option::is_some))) {
        return single_readings(&args, &robot, &logs, opened);
    }
    let found = during("identify", || identify(&robot, &logs, &options))?;
    let document = file::document(&found.gaps, &robot);
    let shown = Shown { document: &document, table: &table(&found, &robot), notes: &found.gaps.notes };
    args.result.finish(opened, &shown, || page::gaps::of_path(&robot, &found))
}

/// Logs of a ballbar, a dial gauge or joint sensors.
fn single_readings(args: &Args, robot: &Robot, logs: &[Log], opened: Opened) -> Result<()> {
    let held =
        [("--free", !args.free.is_empty()), ("--known", args.known.is_some()), ("--model", args.model.is_some())];
    if let Some((flag, _)) = held.iter().find(|(_, given)| *given) {
        let found = format!("{flag} with a log of single readings");
        return Err(bad(Place::file(*flag), found, "no such option: all joints that reverse are fitted together"));
    }
    let found = {
        let setup = args.setup.checked()?;
        during("identify", || scalar::identify(robot, logs, &setup))?
    };
    let mut document = file::document(&found.gaps, robot);
    document["method"] = "single readings".into();
    document["instrument"] = found.instruments.first().map(|i| i.name()).into();
    let mut t = Table::new();
    t.load_preset(UTF8_HORIZONTAL_ONLY);
    t.set_header(["joint", "half gap", "95 %"]);
    for j in &found.gaps.joints {
        let joint = robot.axis(j.axis);
        let edge = |v: f64| format!("{:.5}", joint.kind.to_user_unit(v));
        let mark = if j.significant { "" } else { " (not significant)" };
        t.add_row([
            joint.name.clone(),
            format!("{} {}", edge(j.half_gap), joint.kind.unit()),
            format!("{} .. {}{mark}", edge(j.ci95[0]), edge(j.ci95[1])),
        ]);
    }
    let table = format!(
        "{t}\nnoise {:.1} um a reading, correlation {:.2} from row to row\n",
        found.sigma_m * 1e6,
        found.correlation
    );
    let shown = Shown { document: &document, table: &table, notes: &found.gaps.notes };
    args.result.finish(opened, &shown, || page::gaps::of_readings(robot, &found.gaps))
}

/// What a person reads.
fn table(found: &PathFound, robot: &Robot) -> String {
    let mut t = Table::new();
    t.load_preset(UTF8_HORIZONTAL_ONLY);
    t.set_header(["joint", "half gap", "95 %", "stiction", "95 %", "decay s", "95 %"]);
    for j in &found.gaps.joints {
        let joint = robot.axis(j.axis);
        let edge = |v: f64| format!("{:.5}", joint.kind.to_user_unit(v));
        let span = |ci: [f64; 2]| format!("{} .. {}", edge(ci[0]), edge(ci[1]));
        let mark = if j.schedule.is_some() { " (varies)" } else { "" };
        let mut row = vec![
            joint.name.clone(),
            format!("{} {}{mark}", edge(j.half_gap), joint.kind.unit()),
            if j.significant { span(j.ci95) } else { format!("{} (not significant)", span(j.ci95)) },
        ];
        match &j.stiction {
            Some(s) => {
                row.extend([edge(s.spike), span(s.ci95)]);
                match s.decay {
                    Decay::Time(d) => row.push(format!("{d:.2}")),
                    Decay::Travel(d) => row.push(format!("{} {}", edge(d), joint.kind.unit())),
                }
                row.push(match s.decay {
                    Decay::Time(_) => format!("{:.2} .. {:.2}", s.decay_ci95[0], s.decay_ci95[1]),
                    Decay::Travel(_) => span(s.decay_ci95),
                });
            }
            None => row.extend(["none".into(), String::new(), String::new(), String::new()]),
        }
        t.add_row(row);
    }
    let mut out = format!("{t}\n");
    out.push_str(&format!("noise {:.1} um per coordinate\n", found.sigma_m * 1e6));
    out
}
