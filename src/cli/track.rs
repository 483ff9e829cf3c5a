//! `lostmotion track`: Cartesian path -> joint program.

use crate::cli::exit::{bad, no};
use crate::cli::{page, paths};
use crate::error::{Place, counted, is_stdio};
use crate::gaps::LogRef;
use crate::io::input;
use crate::io::output::{self, Output};
use crate::learn::Learned;
use crate::model::Model;
use crate::robot::Robot;
use crate::track::{Kinematics, Method, Options, Origin, Path, follow, plausible, write};
use anyhow::Result;
use std::path::{Path as FilePath, PathBuf};

/// Convert a Cartesian path into a joint program.
///
/// The path is a CSV file with x_mm, y_mm, z_mm (an absent coordinate is free) and optionally t_s. The joints follow the
/// path by the bounded quadratic program of Cursi (2022), equation 1, or by numerical inverse kinematics, within the joint
/// limits, the joint speeds and, for learned kinematics, the range of the training data. --robot uses the nominal
/// kinematics, --model the geometry of the model, --kinematics a learned one. The path is in the frame of these kinematics
/// (for learned ones, the frame of their logs). If the path cannot be followed, the command names the places, writes nothing
/// and exits with code 1.
///
/// The program is not compensated: pass it to `rewrite`.
///
/// Examples:
///   lostmotion track --robot robot.yaml --path path.csv --speed-mm-s 5 --output program.csv
///   lostmotion track --robot robot.yaml --kinematics kinematics.yaml --path path.csv --output program.csv
///   lostmotion track --model found.yaml --path path.csv --method inverse --output program.csv
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
#[command(group = clap::ArgGroup::new("machine").required(true).args(["robot", "model"]))]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: Option<PathBuf>,
    /// Model file (YAML) instead of --robot: its link_error and tool_error are applied; `rewrite --model` undoes the other
    /// effects
    #[arg(long, value_name = "MODEL.yaml")]
    pub model: Option<PathBuf>,
    /// Learned kinematics from `learn`, instead of those of the robot file
    #[arg(long, value_name = "KINEMATICS.yaml", requires = "robot")]
    pub kinematics: Option<PathBuf>,
    /// Cartesian path (CSV); `-` for standard input
    #[arg(long, value_name = "PATH.csv")]
    pub path: PathBuf,
    /// Method for each step
    #[arg(long, value_enum, default_value_t = MethodArg::Qp)]
    pub method: MethodArg,
    /// Joint positions at which the search for the first point starts, deg or mm, such as 0,-90,90,0,0,0 [default: all 0]
    #[arg(long, value_name = "Q1,Q2,...", allow_hyphen_values = true)]
    pub start: Option<String>,
    /// TCP speed of a path without t_s, mm/s
    #[arg(long, value_name = "MM_S", allow_negative_numbers = true)]
    pub speed_mm_s: Option<f64>,
    /// Largest distance from the path at which a point counts as reached, mm
    #[arg(long, value_name = "MM", default_value_t = 0.1, allow_negative_numbers = true)]
    pub tolerance_mm: f64,
    /// Write the program to this file; `-` for standard output
    #[arg(long, short, value_name = "PROGRAM.csv")]
    pub output: PathBuf,
    /// Print the result as one JSON document (lostmotion/tracking/1) on standard output
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// `--method`.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum MethodArg {
    /// One bounded quadratic program for each step
    Qp,
    /// Numerical inverse kinematics at each point
    Inverse,
}

fn usage(found: impl Into<String>, expected: &str) -> anyhow::Error {
    bad(Place::file("command line"), found, expected)
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let inputs = [
        ("--robot", args.robot.as_deref()),
        ("--model", args.model.as_deref()),
        ("--kinematics", args.kinematics.as_deref()),
        ("--path", Some(args.path.as_path())),
    ];
    paths::refuse_shared(&inputs, &[("--output", Some(args.output.as_path())), ("--report", args.report.as_deref())])?;
    if args.json && args.output == FilePath::new("-") {
        return Err(usage("--json with --output -", "one of them: both go to standard output"));
    }
    let above_zero = |option: &str, v: f64| {
        if v.is_finite() && v > 0.0 { Ok(v * 1e-3) } else { Err(usage(format!("{option} {v}"), "a number above 0")) }
    };
    let tolerance_m = above_zero("--tolerance-mm", args.tolerance_mm)?;
    let speed_m_s = args.speed_mm_s.map(|v| above_zero("--speed-mm-s", v)).transpose()?;
    let mut out = Output::create(&args.output)?;
    let mut report = output::create(args.report.as_deref())?;
    let (model, source) = load(&args)?;
    let robot = &model.robot;
    let learned = args.kinematics.as_ref().map(|file| Learned::load(file, robot)).transpose()?;
    let path = Path::load(&args.path)?;
    if learned.is_none() {
        refuse_metres(robot, &path)?;
    }
    let (kinematics, mut origin) = kinematics(&model, source, learned, &path)?;
    let t_s = times(&path, speed_m_s)?;
    let method = match args.method {
        MethodArg::Qp => Method::Qp,
        MethodArg::Inverse => Method::Inverse,
    };
    let start = args.start.as_deref().map(|s| joints(s, robot)).transpose()?;
    let tracked = follow(robot, &kinematics, &path, &t_s, &Options { method, start, tolerance_m })?;
    if let Some(why) = tracked.refusal(robot, &path, tolerance_m) {
        return Err(no(why));
    }
    origin.by = format!("{}, {}", origin.by, method.text());
    out.put(&write::program(robot, &tracked, &path.name, &origin.by))?;
    page::write(&mut report, || page::track::of_tracked(robot, &kinematics, &path, &tracked, &origin))?;
    let mut stdout = if args.json { Some(Output::create(FilePath::new("-"))?) } else { None };
    if let Some(stdout) = &mut stdout {
        stdout.put(format!("{:#}\n", tracked.to_json(robot, &path, &origin, method.text())?).as_bytes())?;
    }
    output::commit([Some(out), report, stdout])?;
    eprint!("{}", tracked.words(&path, &origin.by));
    Ok(())
}

/// Refuses a path in metres of an arm; a note of another machine, where it may be one of a few millimetres.
fn refuse_metres(robot: &Robot, path: &Path) -> Result<()> {
    let Some(found) = plausible::in_metres(robot, path) else { return Ok(()) };
    let size = format!("{:.3} mm", found.largest_m * 1e3);
    if found.certain {
        let text = format!("a path within {size} of the origin of the robot file, inside of the arm");
        return Err(bad(Place::file(&path.name), text, "x_mm, y_mm, z_mm in millimetres (these look like metres)"));
    }
    eprintln!("note: the path lies within {size} of the origin: are its coordinates in metres?");
    Ok(())
}

/// Where the geometry comes from.
enum Source {
    /// A robot file.
    Nominal,
    /// A model file; without its name where it was standard input, which is read once.
    Model(Option<LogRef>),
}

/// `--model` or `--robot`.
fn load(args: &Args) -> Result<(Model, Source)> {
    match (&args.model, &args.robot) {
        (Some(file), _) => {
            let mut model_file = None;
            if !is_stdio(file) {
                let read = input::read(file)?;
                model_file = Some(LogRef { name: read.name, sha256: read.sha256 });
            }
            Ok((Model::load(file)?, Source::Model(model_file)))
        }
        (None, Some(file)) => Ok((Model::ideal(Robot::load(file)?), Source::Nominal)),
        (None, None) => Err(usage("neither --robot nor --model", "one of them")),
    }
}

/// The kinematics that the path is followed with, and where they come from.
fn kinematics(model: &Model, source: Source, learned: Option<Learned>, path: &Path) -> Result<(Kinematics, Origin)> {
    let file = match (learned, source) {
        (Some(learned), _) => return of_learned(learned, path),
        (None, Source::Nominal) => {
            let origin = Origin { by: "nominal kinematics".into(), file: None };
            return Ok((Kinematics::nominal(&model.robot, &path.coordinates), origin));
        }
        (None, Source::Model(file)) => file,
    };
    let left = model.effects.iter().filter(|e| e.effect.stage() != crate::effects::Stage::Geometry).count();
    if left > 0 {
        eprintln!(
            "note: {} of the model {} joints, not the geometry: `rewrite --model` compensates those that an offset can compensate",
            counted(left, "effect"),
            if left == 1 { "moves" } else { "move" }
        );
    }
    if model.registration.is_some() {
        eprintln!("note: the path is in the robot's frame; the registration of the model is not applied");
    }
    let origin = Origin { by: "kinematics of the model's geometry".into(), file };
    Ok((Kinematics::of_model(model, &path.coordinates), origin))
}

/// Kinematics that `learn` wrote.
fn of_learned(learned: Learned, path: &Path) -> Result<(Kinematics, Origin)> {
    let file = learned.file.clone();
    let name = file.as_ref().map_or(String::new(), |f| f.name.clone());
    if !learned.evidence.programs.is_empty() {
        eprintln!("note: {name} was learned on compensated runs: compensate this program in the same way (rewrite)");
    }
    let origin = Origin { by: format!("learned kinematics ({})", learned.kind.text()), file };
    Ok((Kinematics::learned(learned, &path.coordinates, &name)?, origin))
}

/// Times of the path's points: its own, or those of a constant speed.
fn times(path: &Path, speed_m_s: Option<f64>) -> Result<Vec<f64>> {
    match (&path.t_s, speed_m_s) {
        (Some(_), Some(_)) => Err(usage("--speed-mm-s and a path with t_s", "one of them")),
        (Some(t), None) => Ok(t.clone()),
        (None, Some(v)) => Ok(path.times_at(v)),
        (None, None) => Err(bad(Place::file(&path.name), "no column t_s", "times, or --speed-mm-s")),
    }
}

/// A joint vector in deg and mm, one value per axis.
fn joints(text: &str, robot: &Robot) -> Result<Vec<f64>> {
    let bad = || {
        let expected = format!("a number for each of {}, in deg or mm, commas between", robot.axis_names().join(", "));
        bad(Place::file("--start"), format!("`{text}`"), expected)
    };
    let values: Option<Vec<f64>> =
        text.split(',').map(|v| v.trim().parse().ok().filter(|v: &f64| v.is_finite())).collect();
    let values = values.filter(|v| v.len() == robot.dof()).ok_or_else(bad)?;
    Ok(robot.axis_joints().zip(values).map(|(j, v)| v * j.kind.si_per_user_unit()).collect())
}
