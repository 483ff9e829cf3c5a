//! `lostmotion fit`: identified gaps -> compensator file.

use crate::cli::exit::{bad, no};
use crate::cli::{logs, page, paths};
use crate::compensator::{Compensator, FrictionShape, Note, file::is_date};
use crate::effects::Decay;
use crate::error::{self, Error, Place, is_stdio};
use crate::fit::{Form, contradict::contradictions, fit, spacing};
use crate::gaps::{Gaps, file::document};
use crate::identify::machine::update;
use crate::io::output::{self, write_whole};
use crate::log::Log;
use crate::robot::Robot;
use crate::schemas;
use anyhow::Result;
use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use std::path::{Path, PathBuf};

/// Make a compensator from identified gaps and stiction.
///
/// Each joint gets an offset of its half gap (a constant, or a schedule if the gap varies with position) and, if the log
/// shows stiction, a friction term that fades after each reversal. A term that is not significant, or not larger than its
/// uncertainty, is left out, and a note reports it. You can give the gaps of static tests and of paths together: a schedule
/// takes precedence over a constant, the more certain of two constants is used, and the friction comes from the path.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lostmotion fit --robot robot.yaml --gaps gaps.yaml --output compensator.yaml
  lostmotion fit --robot robot.yaml --gaps static.yaml --gaps path.yaml --output compensator.yaml
  lostmotion fit --robot robot.yaml --previous compensator.yaml --log after.csv --output better.yaml
  lostmotion fit --robot robot.yaml --gaps path.yaml --form poses --program circle.csv --output compensator.yaml

By default the friction term fades over time (`decay_s`, in seconds), which `rewrite` converts to the points of any program.
`--form poses` writes the three numbers g, l, k_t of Zhang (2023), equation 17, instead: they count points, so they hold only for
programs with the given spacing and speed.")]
#[command(
    override_usage = "lostmotion fit [OPTIONS] --robot <FILE> --gaps <FILE>... <--output <FILE>|--json>\n       lostmotion fit [OPTIONS] --robot <FILE> --previous <FILE> --log <FILE>... --output <FILE>"
)]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    /// Gaps file (YAML) from `identify`; repeat the option for several files
    #[arg(long, value_name = "FILE", required_unless_present = "previous", conflicts_with = "previous")]
    pub gaps: Vec<PathBuf>,
    /// Compensator to correct: the one with which the programs were rewritten whose runs are given as --log
    #[arg(long, value_name = "FILE", requires = "log")]
    pub previous: Option<PathBuf>,
    /// Log of a run of a rewritten program; repeat the option for several logs
    #[arg(long, value_name = "FILE", requires = "previous")]
    pub log: Vec<PathBuf>,
    /// Column map (YAML): translates other column names, units and separators of the logs
    #[arg(long, value_name = "FILE", requires = "previous")]
    pub columns: Option<PathBuf>,
    /// Write the compensator (YAML) to this file; `-` for standard output
    #[arg(long, short, value_name = "FILE", required_unless_present = "json")]
    pub output: Option<PathBuf>,
    /// Accept gaps that `identify` reports as not trustworthy
    #[arg(long)]
    pub force: bool,
    /// How the friction term fades
    #[arg(long, value_enum, default_value_t = FormArg::Decay)]
    pub form: FormArg,
    /// Program (joint-space CSV) whose point spacing --form poses uses
    #[arg(long, value_name = "FILE", conflicts_with = "pose_spacing_mm")]
    pub program: Option<PathBuf>,
    /// Distance between program points for --form poses, mm, instead of --program
    #[arg(long, value_name = "MM")]
    pub pose_spacing_mm: Option<f64>,
    /// TCP speed of the program, mm/s [default: the speed of the log]
    #[arg(long, value_name = "V")]
    pub speed_mm_s: Option<f64>,
    /// Last day on which the compensator may be used, YYYY-MM-DD; `rewrite` warns after it
    #[arg(long, value_name = "DATE")]
    pub valid_until: Option<String>,
    /// Print the compensator as one JSON document on standard output
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FormArg {
    /// Over time, in seconds: holds for any program
    Decay,
    /// Over a number of program points: holds for one point spacing and speed
    Poses,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let to_stdout = args.output.as_deref().is_some_and(is_stdio);
    if args.json && to_stdout {
        return Err(bad(Place::file("--output"), "`-` and --json", "one document on standard output"));
    }
    if let Some(day) = args.valid_until.as_deref().filter(|d| !is_date(d)) {
        return Err(bad(Place::file("--valid-until"), format!("`{day}`"), "a date as 2027-01-31"));
    }
    let inputs: Vec<paths::Named> = [("--robot", Some(args.robot.as_path())), ("--program", args.program.as_deref())]
        .into_iter()
        .chain([("--previous", args.previous.as_deref()), ("--columns", args.columns.as_deref())])
        .chain(args.gaps.iter().map(|p| ("--gaps", Some(p.as_path()))))
        .chain(args.log.iter().map(|p| ("--log", Some(p.as_path()))))
        .collect();
    paths::refuse_shared(&inputs, &[("--output", args.output.as_deref()), ("--report", args.report.as_deref())])?;
    let mut output = output::create(args.output.as_deref())?;
    let mut report = output::create(args.report.as_deref())?;
    let robot = Robot::load(&args.robot)?;
    let mut compensator = match &args.previous {
        Some(path) => corrected(path, &args, &robot)?,
        None => fitted(&args, &robot)?,
    };
    compensator.evidence.valid_until = args.valid_until;
    let text = compensator.to_yaml(&robot)?;
    // what is written must be read again
    Compensator::parse("the compensator", &text, &robot)?;
    if let (Some(out), Some(path)) = (&mut output, &args.output) {
        out.put((schemas::editor_line(path, "compensator") + &text).as_bytes())?;
    }
    page::write(&mut report, || page::compensator::of_fit(&robot, &compensator))?;
    output::commit([output, report])?;
    if args.json {
        let json = serde_json::to_string_pretty(&compensator.to_json(&robot)?)
            .map_err(|e| Error::internal("write JSON", e))?;
        write_whole(Path::new("-"), (json + "\n").as_bytes())?;
    } else if to_stdout {
        eprint!("{}", table(&compensator, &robot));
    } else {
        write_whole(Path::new("-"), table(&compensator, &robot).as_bytes())?;
    }
    for note in &compensator.evidence.notes {
        eprintln!("note: {note}");
    }
    Ok(())
}

/// A compensator of gaps documents.
fn fitted(args: &Args, robot: &Robot) -> Result<Compensator> {
    let documents = args.gaps.iter().map(|p| Gaps::load(p, robot)).collect::<error::Result<Vec<_>>>()?;
    refuse_repeats(&args.gaps, &documents, robot)?;
    let distrusted = args.gaps.iter().zip(&documents).find_map(|(p, d)| d.distrust.as_ref().map(|why| (p, why)));
    if let Some((path, why)) = distrusted.filter(|_| !args.force) {
        return Err(no(format!("{}: {why} (--force fits them anyway)", crate::error::shown(path))));
    }
    let contradictions = contradictions(&documents, robot);
    if let Some(first) = contradictions.first().filter(|_| !args.force) {
        return Err(no(format!("{first} (--force uses the one that is known best)")));
    }
    let form = form(args, &documents, robot)?;
    let mut compensator = fit(robot, &documents, form)?;
    compensator.evidence.notes.extend(distrusted.map(|(_, why)| Note::Distrust(why.clone())));
    compensator.evidence.notes.extend(contradictions.into_iter().map(Note::Contradiction));
    Ok(compensator)
}

/// The previous compensator, corrected by runs.
fn corrected(path: &Path, args: &Args, robot: &Robot) -> Result<Compensator> {
    let previous = Compensator::load(path, robot)?;
    let logs = logs::load(&args.log, args.columns.as_deref(), robot)?;
    logs::refuse_repeats(&logs)?;
    let used = |l: &&Log| previous.evidence.logs.iter().any(|u| !u.sha256.is_empty() && u.sha256 == l.sha256);
    if let Some(log) = logs.iter().find(used) {
        let expected = "a run of a program that was rewritten with this compensator";
        return Err(bad(Place::file(&log.name), "a log from which the compensator was made", expected));
    }
    update::update(robot, &logs, &previous).map_err(Into::into)
}

/// Refuses gaps that are given twice, under whatever name.
fn refuse_repeats(paths: &[PathBuf], documents: &[Gaps], robot: &Robot) -> Result<()> {
    let contents: Vec<_> = documents.iter().map(|d| document(d, robot)).collect();
    for (k, path) in paths.iter().enumerate() {
        if contents[..k].contains(&contents[k]) {
            let expected = "each gaps file once: its gaps would count twice";
            let place = Place::file(crate::error::shown(path));
            return Err(bad(place, "gaps that were given before (same content)", expected));
        }
    }
    Ok(())
}

/// The form, with the time between points where it counts them.
fn form(args: &Args, documents: &[Gaps], robot: &Robot) -> Result<Form> {
    let positive = |name: &str, v: Option<f64>| match v {
        Some(x) if !(x.is_finite() && x > 0.0) => Err(bad(Place::file(name), x.to_string(), "a number above 0")),
        other => Ok(other.map(|x| x * 1e-3)),
    };
    let spacing = positive("--pose-spacing-mm", args.pose_spacing_mm)?;
    let speed = positive("--speed-mm-s", args.speed_mm_s)?.or(documents.iter().find_map(|d| d.tcp_speed_m_s));
    if args.form == FormArg::Decay {
        return Ok(Form::Decay);
    }
    let spacing_m = match (&args.program, spacing) {
        (Some(path), _) => spacing::of_program(path, robot)?,
        (None, Some(m)) => m,
        (None, None) => {
            let expected = "--program FILE or --pose-spacing-mm MM (equation 17 counts points of one spacing)";
            return Err(bad(Place::file("--form poses"), "no spacing of points", expected));
        }
    };
    match speed {
        Some(v) => Ok(Form::Poses { spacing_s: spacing_m / v }),
        None => Err(bad(Place::file("--form poses"), "gaps without a TCP speed", "--speed-mm-s V")),
    }
}

/// What a person reads.
fn table(c: &Compensator, robot: &Robot) -> String {
    let mut t = Table::new();
    t.load_preset(UTF8_HORIZONTAL_ONLY);
    // an estimate of all logs judges joints at the TCP: its notes give that
    let judged = c.evidence.joints.iter().any(|k| k.largest_before.is_some());
    let header = ["joint", "backlash offset", "friction gain", "fades", "error before", "after"];
    t.set_header(&header[..if judged { 6 } else { 4 }]);
    for j in &c.joints {
        let joint = robot.axis(j.axis);
        let (kind, unit) = (joint.kind, joint.kind.unit());
        let edge = |v: f64| format!("{:.5} {unit}", kind.to_user_unit(v));
        let gap = j.backlash.as_ref().map_or("none".into(), |b| match b.positive.constant() {
            Some(d) => edge(d),
            None => format!("{:.5} to {}", kind.to_user_unit(b.positive.smallest()), edge(b.positive.largest())),
        });
        let fades = |s: FrictionShape| match s {
            FrictionShape::Decay(Decay::Time(tau)) => format!("{tau:.2} s"),
            FrictionShape::Decay(Decay::Travel(x)) => edge(x),
            FrictionShape::Poses { exponent, poses } => format!("l {exponent:.2}, k_t {poses}"),
            FrictionShape::Response(r) => r.decays_s().map_or("wound up".into(), |[lo, hi]| match hi - lo < 0.05 {
                true => format!("{lo:.1} s"),
                false => format!("{lo:.1} to {hi:.1} s"),
            }),
        };
        let known = c.evidence.joints.iter().find(|e| e.axis == j.axis);
        let mut row = vec![
            joint.name.clone(),
            gap,
            j.friction.map_or("none".into(), |f| edge(f.gain)),
            j.friction.map_or(String::new(), |f| fades(f.shape)),
        ];
        if judged {
            row.push(known.and_then(|k| k.largest_before).map_or(String::new(), edge));
            row.push(known.and_then(|k| k.largest_after).map_or(String::new(), edge));
        }
        t.add_row(row);
    }
    format!("{t}\n")
}
