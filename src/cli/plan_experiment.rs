//! `lostmotion plan-experiment`: alternatives, or the whole catalogue -> the motion that decides, as a program.

use crate::cli::exit::bad;
use crate::cli::{page, paths, plan_recording};
use crate::diagnose::noise::Noise;
use crate::diagnose::problem::synthetic::Channels;
use crate::error::{Error, Place};
use crate::io::input;
use crate::io::output::{self, Output};
use crate::model::Model;
use crate::plan::document::QuestionKind;
use crate::plan::path::{Envelope, EnvelopeOptions};
use crate::plan::question::{self, Set};
use crate::plan::recording::Kind;
use crate::plan::separate::Experiment;
use crate::plan::sizes::{self, Scale};
use crate::plan::{self, display, document, motions};
use crate::robot::Robot;
use anyhow::Result;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Propose a motion that separates hypotheses which a diagnosis could not separate.
///
/// Each motion of a library (sweeps, stairs, slow reversals, circles, all joints, waiting, two payloads) is evaluated with
/// the engine of `diagnose`: how much worse would the wrong hypothesis fit? The best motion, or the best two, are written as
/// a program that starts and ends at rest at the pose. Without --diagnosis and --between, the command selects the motion
/// that shows the whole catalogue best.
///
/// Examples:
///   lostmotion plan-experiment --model machine.yaml --diagnosis diagnosis.json --output program.csv
///   lostmotion plan-experiment --model machine.yaml --between backlash:A2,hysteresis:A2 --output program.csv
///   lostmotion plan-experiment --model machine.yaml --between servo_lag:A2:lag_s=0.004,time_offset --json
///   lostmotion plan-experiment --model machine.yaml --output first.csv
///   lostmotion plan-experiment static --robot robot.yaml --tracker 3000,0,1000 --output static.csv
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Args {
    #[command(subcommand)]
    pub recording: Option<Recording>,
    /// Model file (YAML): the robot and its known effects
    #[arg(long, value_name = "MODEL.yaml", required = true)]
    pub model: Option<PathBuf>,
    /// Diagnosis (from `diagnose --json`) whose alternatives are to be separated
    #[arg(long, value_name = "DIAGNOSIS.json", conflicts_with = "between")]
    pub diagnosis: Option<PathBuf>,
    /// Alternative hypotheses, separated by commas: EFFECT:TARGET[:key=value...]. `+` joins effects, `*` is every joint, and
    /// `frame` is no effect
    #[arg(long, value_name = "HYPOTHESES")]
    pub between: Option<String>,
    /// Joint pose at which the program starts and ends, deg or mm [default: near the middle of the joint ranges]
    #[arg(long, value_name = "Q1,Q2,...", allow_hyphen_values = true)]
    pub pose: Option<String>,
    /// Longest duration of one motion, s
    #[arg(long, value_name = "S", default_value_t = 120.0, value_parser = above_zero)]
    pub duration_s: f64,
    /// Standard deviation of the measurement noise on each coordinate, um [default: that of the diagnosis, otherwise 10]
    #[arg(long, value_name = "UM", value_parser = above_zero)]
    pub noise_um: Option<f64>,
    /// Rows per second of the log, Hz
    #[arg(long, value_name = "HZ", default_value_t = 25.0, value_parser = above_zero)]
    pub rate_hz: f64,
    /// Payload used for the motions with two payloads, kg
    #[arg(long, value_name = "KG", default_value_t = 5.0, value_parser = above_zero)]
    pub payload_kg: f64,
    /// Working speed of the TCP, mm/s
    #[arg(long, value_name = "MM_S", default_value_t = 100.0, value_parser = above_zero)]
    pub speed_mm_s: f64,
    /// Largest travel of a revolute joint from the pose, deg
    #[arg(long, value_name = "DEG", default_value_t = 30.0, value_parser = above_zero)]
    pub travel_deg: f64,
    /// Largest travel of a prismatic joint from the pose, mm
    #[arg(long, value_name = "MM", default_value_t = 200.0, value_parser = above_zero)]
    pub travel_mm: f64,
    /// Write the program to this file (joint-space CSV with t_s)
    #[arg(long, short, value_name = "PROGRAM.csv")]
    pub output: Option<PathBuf>,
    /// Print the plan as one JSON document on standard output
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Programs to record, so that every gap can be identified.
#[derive(Debug, clap::Subcommand)]
pub enum Recording {
    /// Plan bidirectional dwells of one joint after another, for `identify static`
    Static(Box<plan_recording::Args>),
    /// Plan a slow motion of all joints, for `identify path`
    Path(Box<plan_recording::Args>),
    /// Plan a faster motion of all joints with pauses, for friction, lags and predictions
    Excitation(Box<plan_recording::Args>),
}

/// Most rows of a program, and of the log of one motion.
const MOST_ROWS: f64 = 200_000.0;

fn above_zero(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0).ok_or_else(|| "expected a number above 0".into())
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    match &args.recording {
        Some(Recording::Static(a)) => return plan_recording::run(a, Kind::Static),
        Some(Recording::Path(a)) => return plan_recording::run(a, Kind::Path),
        Some(Recording::Excitation(a)) => return plan_recording::run(a, Kind::Excitation),
        None => {}
    }
    let model = Model::load(checked_model_file(&args)?)?;
    let robot = &model.robot;
    let options = EnvelopeOptions {
        pose: args.pose.as_deref().map(|p| pose(p, &model.robot)).transpose()?,
        duration_s: args.duration_s,
        rate_hz: args.rate_hz,
        speed_m_s: args.speed_mm_s * 1e-3,
        travel_rad: args.travel_deg.to_radians(),
        travel_m: args.travel_mm * 1e-3,
    };
    let mut envelope = Envelope::new(robot, &options);
    let window = envelope.window.clone();
    let (speed_m_s, duration_s) = (envelope.speed_m_s, envelope.duration_s);
    let mut scale = Scale { robot, window: &window, speed_m_s, duration_s, lost: vec![None; robot.dof()] };
    let asked = Question::of(&args, &mut scale)?;
    widen(&mut envelope, asked.sets());
    let mut out = output::create(args.output.as_deref())?;
    let mut report = output::create(args.report.as_deref())?;
    let noise = args.noise_um.map(|um| Noise::white(um * 1e-6)).unwrap_or(asked.noise());
    let bench = Experiment {
        model: &model,
        envelope: &envelope,
        noise,
        payload_kg: args.payload_kg,
        channels: Channels::default(),
    };
    let (plan, motion) = asked.answer(&bench, &scale);
    page::write(&mut report, || page::plan::of_plan(robot, &plan, motion.as_ref(), &envelope))?;
    match (&mut out, motion.map(|m| document::program(&m, &envelope))) {
        (Some(out), Some(bytes)) => out.put(&bytes)?,
        (Some(_), None) => {
            let file = crate::error::shown(args.output.as_deref().unwrap_or(Path::new("-")));
            eprintln!("note: no program is written to {file}");
            out = None;
        }
        _ => {}
    }
    let text = match args.json {
        true => serde_json::to_string_pretty(&plan).unwrap_or_default() + "\n",
        false => display::story(&plan),
    };
    if args.output.as_deref() == Some(Path::new("-")) {
        // the program goes to standard output: the words beside it
        eprint!("{text}");
        return output::commit([out, report]).map_err(Into::into);
    }
    let mut stdout = Output::create(Path::new("-"))?;
    stdout.write_all(text.as_bytes()).map_err(|e| Error::io("standard output", "write", e))?;
    output::commit([out, report, Some(stdout)]).map_err(Into::into)
}

/// The model file, where the options agree with each other.
fn checked_model_file(args: &Args) -> Result<&Path> {
    let Some(model_file) = args.model.as_deref() else {
        let expected = "--model MODEL.yaml, or static, path or excitation";
        return Err(bad(Place::file("--model"), "no model", expected));
    };
    let inputs = [("--model", Some(model_file)), ("--diagnosis", args.diagnosis.as_deref())];
    let outputs = [("--output", args.output.as_deref()), ("--report", args.report.as_deref())];
    paths::refuse_shared(&inputs, &outputs)?;
    paths::refuse_program_ending("--output", args.output.as_deref())?;
    if args.json && args.output.as_deref() == Some(Path::new("-")) {
        let expected = "a file, because standard output contains the document";
        return Err(bad(Place::file("--output"), "`-` with --json", expected));
    }
    if args.duration_s * args.rate_hz.max(25.0) > MOST_ROWS {
        let found = format!("{} s at {} Hz", args.duration_s, args.rate_hz);
        return Err(bad(Place::file("--duration-s"), found, format!("at most {MOST_ROWS:.0} rows")));
    }
    Ok(model_file)
}

/// What the motion is to decide.
enum Question {
    /// The sets that a diagnosis left open, under the noise that it found.
    Diagnosis(Vec<Set>, Option<Noise>),
    /// Hypotheses that the user names.
    Between(Vec<Set>),
    /// Every effect of the catalogue.
    Catalogue,
}

impl Question {
    fn of(args: &Args, scale: &mut Scale) -> Result<Self> {
        match (&args.diagnosis, &args.between) {
            (Some(path), _) => {
                let (text, input) = input::read_text(path)?;
                let sets = question::of_diagnosis(&input.name, &text, scale)?;
                Ok(Self::Diagnosis(sets, noise_of(&text)))
            }
            (None, Some(text)) => Ok(Self::Between(vec![question::between("--between", text, scale)?])),
            (None, None) => Ok(Self::Catalogue),
        }
    }

    fn sets(&self) -> &[Set] {
        match self {
            Self::Diagnosis(sets, _) | Self::Between(sets) => sets,
            Self::Catalogue => &[],
        }
    }

    /// Noise of a coordinate where the user gives none.
    fn noise(&self) -> Noise {
        match self {
            Self::Diagnosis(_, Some(noise)) => *noise,
            _ => Noise::white(10e-6),
        }
    }

    /// The plan, and its motion where there is one.
    fn answer(&self, bench: &Experiment, scale: &Scale) -> (document::Plan, Option<motions::Motion>) {
        let (envelope, dof) = (bench.envelope, bench.model.robot.dof());
        let payload = !bench.model.robot.links.is_empty();
        let (name, sets) = match self {
            Self::Catalogue => {
                let answer = plan::observe(bench, motions::library(envelope, &[], payload), scale);
                let (plan, motion) = document::of_catalogue(&answer, bench);
                return (plan, motion.cloned());
            }
            Self::Diagnosis(sets, _) => (QuestionKind::Diagnosis, sets),
            Self::Between(sets) => (QuestionKind::Between, sets),
        };
        if sets.is_empty() {
            return (document::of_nothing(bench), None);
        }
        let library = motions::library(envelope, &plan::axes_of(sets, dof), payload);
        let answer = plan::separate(bench, library, sets);
        let (plan, motion) = document::of_separation(name, &answer, sets, bench);
        (plan, motion.cloned())
    }
}

/// Transitions as long as the alternatives'.
fn widen(envelope: &mut Envelope, sets: &[Set]) {
    let mut found: Vec<Option<f64>> = vec![None; envelope.pose.len()];
    for p in sets.iter().flat_map(|s| &s.alternatives).flat_map(|r| &r.effects) {
        if let (Some(axis), Some(x)) = (p.axis(), sizes::transition(&p.effect)) {
            found[axis] = Some(found[axis].unwrap_or(0.0).max(x));
        }
    }
    for (t, x) in envelope.transition.iter_mut().zip(found) {
        *t = x.unwrap_or(*t);
    }
}

/// Noise as a diagnosis found it.
fn noise_of(text: &str) -> Option<Noise> {
    let value: serde_json::Value = serde_json::from_str(text).ok()?;
    let noise = value.get("noise")?;
    let sigma = noise.get("sigma_um")?.as_f64().filter(|s| s.is_finite() && *s > 0.0)? * 1e-6;
    let part = |key: &str| noise.get(key).and_then(|v| v.as_f64()).filter(|v| (0.0..=1.0).contains(v)).unwrap_or(0.0);
    Some(Noise { sigma, phi: part("phi").min(0.99), share: part("share") })
}

/// A pose within the joints' ranges.
pub fn pose(text: &str, robot: &Robot) -> Result<Vec<f64>> {
    let bad = |found: String| {
        let expected =
            format!("{} numbers within the joints' ranges, deg or mm: {}", robot.dof(), robot.axis_names().join(","));
        bad(Place::file("--pose"), found, expected)
    };
    let values: Option<Vec<f64>> =
        text.split(',').map(|v| v.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    let values = values.filter(|v| v.len() == robot.dof()).ok_or_else(|| bad(format!("`{text}`")))?;
    let mut q = Vec::with_capacity(values.len());
    for (joint, v) in robot.axis_joints().zip(values) {
        let si = v * joint.kind.si_per_user_unit();
        if joint.limits.is_some_and(|[lo, hi]| si < lo || si > hi) {
            return Err(bad(format!("{} at {v} {}", joint.name, joint.kind.unit())));
        }
        q.push(si);
    }
    Ok(q)
}
