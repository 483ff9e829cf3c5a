//! `lostmotion plan-experiment static|path|excitation`: a program to record, and the precision to expect.

use crate::cli::exit::bad;
use crate::cli::paths;
use crate::error::{Error, Place};
use crate::io::input;
use crate::io::output::{self, Output};
use crate::machine::measurement::Instrument;
use crate::plan::recording::vendor::{self, Language};
use crate::plan::recording::{self, Kind, Options, document, work};
use crate::program::ScriptPath;
use crate::program::formats::{self, Recognised};
use crate::rewrite::script::path::Reading;
use crate::robot::frames::Frames;
use crate::robot::{Joint, Robot};
use anyhow::Result;
use nalgebra::{Unit, Vector3};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What all three programs take.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: PathBuf,
    /// Position of the tracker in the robot's world frame, mm; the reflector at the TCP stays visible from it
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub tracker: Option<String>,
    /// Largest angle between the reflector's axis and the laser beam, deg
    #[arg(long, value_name = "DEG", default_value_t = 30.0)]
    pub acceptance_deg: f64,
    /// Use a double ballbar with its centre at this position in the world frame, mm: `path` plans circles about it
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with_all = ["dial", "draw_wire"])]
    pub ballbar: Option<String>,
    /// Length of the ballbar from ball to ball, mm
    #[arg(long, value_name = "MM", default_value_t = 300.0, requires = "ballbar")]
    pub bar_mm: f64,
    /// Use a draw wire or another distance sensor of long range, fixed at this position in the world frame, mm
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "dial")]
    pub draw_wire: Option<String>,
    /// Use a dial gauge (probe, scale) that reads along this direction in the world frame
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub dial: Option<String>,
    /// Joint pose at which the program starts and ends, deg or mm [default: a pose in which every joint moves the TCP
    /// clearly]
    #[arg(long, value_name = "Q1,Q2,...", allow_hyphen_values = true)]
    pub pose: Option<String>,
    /// Record where this program works: the pose is in the middle of its joints; may be given several times
    #[arg(long, value_name = "PROGRAM", conflicts_with = "pose")]
    pub program: Vec<PathBuf>,
    /// Frames and tools of the programs' Cartesian targets (YAML, or the controller's own file)
    #[arg(long, value_name = "FRAMES.yaml", requires = "program", conflicts_with = "pose")]
    pub frames: Option<PathBuf>,
    /// Standard deviation of the noise of one reading, um [default: 10; a ballbar: 1]
    #[arg(long, value_name = "UM")]
    pub noise_um: Option<f64>,
    /// Rows per second of the log, Hz
    #[arg(long, value_name = "HZ", default_value_t = 20.0)]
    pub rate_hz: f64,
    /// Working speed of the TCP, mm/s [default: 50; path: 10; excitation: 60; circles of a ballbar: 50]
    #[arg(long, value_name = "MM_S")]
    pub speed_mm_s: Option<f64>,
    /// Largest travel of a revolute joint from the pose, deg
    #[arg(long, value_name = "DEG", default_value_t = 30.0)]
    pub travel_deg: f64,
    /// Largest travel of a prismatic joint from the pose, mm
    #[arg(long, value_name = "MM", default_value_t = 150.0)]
    pub travel_mm: f64,
    /// Duration of a path or an excitation, s
    #[arg(long, value_name = "S", default_value_t = 240.0)]
    pub duration_s: f64,
    /// Duration of one dwell of a static test, s
    #[arg(long, value_name = "S", default_value_t = 3.0)]
    pub dwell_s: f64,
    /// Number of times that a static test reaches each position from both sides
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub cycles: u16,
    /// Number of test positions of each joint in a static test
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=50))]
    pub places: u16,
    /// Write the program to this file: joint-space CSV with t_s; a static test also in the language of the robot, by the ending (.ls, .mod,
    /// .src, .jbi, .script, .nc)
    #[arg(long, short, value_name = "PROGRAM")]
    pub output: Option<PathBuf>,
    /// Print the plan as one JSON document on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(args: &Args, kind: Kind) -> Result<()> {
    let programs = args.program.iter().map(|p| ("--program", Some(p.as_path())));
    let inputs = [("--robot", Some(args.robot.as_path())), ("--frames", args.frames.as_deref())];
    let inputs: Vec<_> = inputs.into_iter().chain(programs).collect();
    paths::refuse_shared(&inputs, &[("--output", args.output.as_deref())])?;
    let language = language(args.output.as_deref());
    if language.is_none() {
        paths::refuse_program_ending("--output", args.output.as_deref())?;
    }
    let to_stdout = args.output.as_deref() == Some(Path::new("-"));
    if args.json && to_stdout {
        return Err(bad(
            Place::file("--output"),
            "`-` with --json",
            "a file, because standard output contains the document",
        ));
    }
    let robot = Robot::load(&args.robot)?;
    let mut options = options(args, kind, &robot)?;
    let mut notes = Vec::new();
    match args.program.is_empty() {
        false => options.pose = Some(work_pose(args, &robot, &mut notes)?),
        true if args.pose.is_none() => notes.push(
            "the test is at a pose in which every joint moves the TCP; --program PROGRAM puts it where your program works, which describes its gaps and friction best"
                .into(),
        ),
        true => {}
    }
    notes.extend(language.and_then(|l| of_another_maker(&robot, l)));
    let mut out = output::create(args.output.as_deref())?;
    let recording = recording::plan(&robot, kind, &options)?;
    if let Some(out) = &mut out {
        let bytes = match (language, &args.output) {
            (Some(language), Some(path)) => {
                let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
                vendor::program(&recording, &robot, language, &stem)?
            }
            _ => document::program(&recording, &robot),
        };
        out.put(&bytes)?;
    }
    let mut text = document::words(&recording, &robot, &options);
    if args.json {
        text =
            serde_json::to_string_pretty(&document::document(&recording, &robot, &options)).unwrap_or_default() + "\n";
    }
    if to_stdout {
        eprint!("{text}");
        output::commit([out])?;
    } else {
        let mut stdout = Output::create(Path::new("-"))?;
        stdout.write_all(text.as_bytes()).map_err(|e| Error::io("standard output", "write", e))?;
        output::commit([out, Some(stdout)])?;
    }
    for note in notes.into_iter().chain(recording.notes.iter().map(ToString::to_string)) {
        eprintln!("note: {note}");
    }
    eprintln!("note: the program does not know of obstacles: run it slowly first");
    Ok(())
}

/// A note where the language is not the one that the maker in the robot's name reads.
fn of_another_maker(robot: &Robot, language: Language) -> Option<String> {
    const MAKERS: [(&str, Language, &str); 7] = [
        ("kuka", Language::Krl, "KRL (.src)"),
        ("abb", Language::Rapid, "RAPID (.mod)"),
        ("fanuc", Language::Fanuc, "FANUC TP (.ls)"),
        ("motoman", Language::Inform, "INFORM (.jbi)"),
        ("yaskawa", Language::Inform, "INFORM (.jbi)"),
        ("universal", Language::UrScript, "URScript (.script)"),
        ("ur", Language::UrScript, "URScript (.script)"),
    ];
    let name = robot.name.to_lowercase();
    let mut words = name.split(|c: char| !c.is_alphabetic());
    let (_, own, title) = words.find_map(|word| MAKERS.iter().find(|m| m.0 == word))?;
    let written = MAKERS.iter().find(|m| m.1 == language).map_or("G-code", |m| m.2);
    (*own != language).then(|| {
        format!(
            "the program is in {written}, but the robot file describes `{}`, whose controller reads {title}",
            robot.name
        )
    })
}

/// The pose in the middle of the programs, with what a user should know of them.
fn work_pose(args: &Args, robot: &Robot, notes: &mut Vec<String>) -> Result<Vec<f64>> {
    let frames = args.frames.as_deref().map(Frames::load).transpose()?.unwrap_or_default();
    // of moves without a speed: the pose does not depend on it
    let tcp_speed_m_s = Some(0.05);
    let reading = Reading { robot, frames: &frames, tcp_speed_m_s, format: None };
    let mut programs = Vec::new();
    for path in &args.program {
        let program = reading.load(path, input::read(path)?)?;
        let left = program.script.as_ref().map(ScriptPath::left);
        notes.extend(left.into_iter().flatten().map(|note| format!("{}: {note}", program.name)));
        programs.push(program);
    }
    let pose = work::middle_of(&programs);
    let pose = pose.ok_or_else(|| bad(Place::file("--program"), "no point of a path", "a program with moves"))?;
    let joints = robot.axis_joints().zip(&pose);
    if let Some((joint, q)) = joints.clone().find(|(j, q)| j.limits.is_some_and(|[lo, hi]| **q < lo || **q > hi)) {
        let found = format!("{} at {:.3} {}", joint.name, joint.kind.to_user_unit(*q), joint.kind.unit());
        return Err(bad(Place::file("--program"), found, "programs within the limits of the joints"));
    }
    let words =
        |(joint, q): (&Joint, &f64)| format!("{} {:.1} {}", joint.name, joint.kind.to_user_unit(*q), joint.kind.unit());
    notes.push(format!("pose in the middle of the programs: {}", joints.map(words).collect::<Vec<_>>().join(", ")));
    Ok(pose)
}

/// The language that the ending of the output names; `None`: a table.
fn language(output: Option<&Path>) -> Option<Language> {
    const TABLES: [&str; 5] = ["csv", "txt", "json", "yaml", "yml"];
    let path = output.filter(|p| *p != Path::new("-"))?;
    let ending = formats::ending(path)?;
    if TABLES.contains(&ending.as_str()) || !formats::endings().contains(&ending.as_str()) {
        return None;
    }
    match formats::recognise(path, b"") {
        Recognised::Script(format) => Language::of_format(format.name()),
        Recognised::Csv => None,
    }
}

fn options(args: &Args, kind: Kind, robot: &Robot) -> Result<Options> {
    let above = |flag: &str, v: f64| {
        if v.is_finite() && v > 0.0 { Ok(v) } else { Err(bad(Place::file(flag), v.to_string(), "a number above 0")) }
    };
    let double = args.ballbar.is_some();
    let speed = args.speed_mm_s.unwrap_or(match kind {
        Kind::Static => 50.0,
        Kind::Path if double => 50.0,
        Kind::Path => 10.0,
        Kind::Excitation => 60.0,
    });
    let place = |flag: &str, text: &Option<String>| text.as_deref().map(|t| three(flag, t)).transpose();
    let distance = place("--ballbar", &args.ballbar)?.or(place("--draw-wire", &args.draw_wire)?);
    let instrument = match (distance, place("--dial", &args.dial)?) {
        (Some(mm), _) => Instrument::Distance { centre_m: mm * 1e-3 },
        (None, Some(d)) if d.norm() > 0.0 => Instrument::Direction { along: Unit::new_normalize(d) },
        (None, Some(_)) => return Err(bad(Place::file("--dial"), "0,0,0", "a direction")),
        (None, None) => Instrument::Tcp,
    };
    let pose = args.pose.as_deref().map(|p| super::plan_experiment::pose(p, robot)).transpose()?;
    const MOST_S: f64 = 36_000.0;
    let duration_s = above("--duration-s", args.duration_s)?;
    if duration_s > MOST_S {
        return Err(bad(Place::file("--duration-s"), duration_s.to_string(), format!("at most {MOST_S} s")));
    }
    Ok(Options {
        pose,
        tracker_m: place("--tracker", &args.tracker)?.map(|mm| mm * 1e-3),
        acceptance_rad: above("--acceptance-deg", args.acceptance_deg)?.min(180.0).to_radians(),
        instrument,
        bar_m: double.then(|| above("--bar-mm", args.bar_mm)).transpose()?.map(|mm| mm * 1e-3),
        noise_m: above("--noise-um", args.noise_um.unwrap_or(if double { 1.0 } else { 10.0 }))? * 1e-6,
        rate_hz: above("--rate-hz", args.rate_hz)?,
        speed_m_s: above("--speed-mm-s", speed)? * 1e-3,
        travel_rad: above("--travel-deg", args.travel_deg)?.to_radians(),
        travel_m: above("--travel-mm", args.travel_mm)? * 1e-3,
        duration_s,
        dwell_s: above("--dwell-s", args.dwell_s)?,
        cycles: usize::from(args.cycles),
        places: usize::from(args.places),
    })
}

/// Three numbers.
pub fn three(flag: &str, text: &str) -> Result<Vector3<f64>> {
    let values: Option<Vec<f64>> =
        text.split(',').map(|v| v.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match values.as_deref() {
        Some([x, y, z]) => Ok(Vector3::new(*x, *y, *z)),
        _ => Err(bad(Place::file(flag), format!("`{text}`"), "three numbers, such as 2500,-400,300")),
    }
}
