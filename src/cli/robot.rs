//! `lostmotion robot check|init`: a robot file looked over, and one made of a URDF.

use crate::cli::exit::{bad, no};
use crate::error::{Error, Place, counted, is_stdio, shown};
use crate::gaps::file::NameAndHash;
use crate::io::{input, output::Output};
use crate::robot::plausible::{self, Finding};
use crate::robot::{Convention, JointKind, Robot, table, urdf};
use crate::schemas;
use anyhow::Result;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

pub const SCHEMA: &str = "lostmotion/robot-check/1";
/// A robot made of a URDF follows the URDF's own chain within this, m.
const SAME_CHAIN_M: f64 = 1e-9;

/// Poses that every check shows.
const FIXED_POSES: usize = 2;

/// Check a robot file, or make one from a URDF file.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, clap::Subcommand)]
pub enum Command {
    Check(CheckArgs),
    Init(InitArgs),
}

/// Check a robot file: its syntax, its plausibility, and the TCP at poses that you can compare with the pendant.
///
/// The command prints the TCP in the robot's base frame at zero, at the middle of the limits, and at every --pose. Compare
/// one pose with the pendant. The exit code is 1 if the numbers cannot be those of a machine (metres written as millimetres,
/// limits in radians, two joints about the same axis).
///
/// Examples:
///   lostmotion robot check robot.yaml
///   lostmotion robot check robot.yaml --pose 0,-90,90,0,0,0 --pose 10,-80,95,20,30,40 --json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct CheckArgs {
    /// Robot file (YAML)
    #[arg(value_name = "ROBOT.yaml")]
    pub robot: PathBuf,
    /// Joint positions, deg or mm, in the order of the robot file; repeat the option for several poses
    #[arg(long, value_name = "Q1,Q2,...", allow_hyphen_values = true)]
    pub pose: Vec<String>,
    /// Print the result as one JSON document (lostmotion/robot-check/1) instead of the tables
    #[arg(long)]
    pub json: bool,
}

/// Make a robot file from a URDF file or from a Denavit-Hartenberg table.
///
/// The chain from the root link to the tip is converted to Denavit-Hartenberg parameters; limits, speeds, masses and mimic
/// joints are copied. The result is compared with the kinematics of the URDF file at 200 random positions. URDF files
/// contain no accelerations: add max_accel_deg_s2 by hand. Expand xacro files first.
///
/// Examples:
///   lostmotion robot init --urdf arm.urdf --output robot.yaml
///   lostmotion robot init --urdf arm.urdf --tip tool0 --output robot.yaml
///   lostmotion robot init --dh table.csv --output robot.yaml
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
#[command(override_usage = "lostmotion robot init [OPTIONS] <--urdf <FILE.urdf>|--dh <FILE.csv>>")]
pub struct InitArgs {
    /// URDF file; `-` for standard input
    #[arg(long, value_name = "FILE.urdf", required_unless_present = "dh", conflicts_with = "dh")]
    pub urdf: Option<PathBuf>,
    /// Denavit-Hartenberg table (CSV): one row for each joint, the keys of the robot file as headings, such as
    /// name,theta_deg,d_mm,a_mm,alpha_deg,min_deg,max_deg,max_speed_deg_s; `-` for standard input
    #[arg(long, value_name = "FILE.csv")]
    pub dh: Option<PathBuf>,
    /// The table of --dh follows the modified convention (Craig) instead of the standard one
    #[arg(long, requires = "dh")]
    pub modified: bool,
    /// Link whose frame is the TCP [default: the last link, if there is only one chain]
    #[arg(long, value_name = "LINK", requires = "urdf")]
    pub tip: Option<String>,
    /// Name of the robot [default: that of the URDF, or of the file of --dh without its ending]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Write the robot file to this file; `-` for standard output
    #[arg(short, long, value_name = "ROBOT.yaml", default_value = "-")]
    pub output: PathBuf,
    /// Replace an existing robot file
    #[arg(long)]
    pub force: bool,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    match args.command {
        Command::Check(a) => check(a),
        Command::Init(a) => init(a),
    }
}

fn check(args: CheckArgs) -> Result<()> {
    let robot = Robot::load(&args.robot)?;
    let mut poses =
        vec![("zero".to_string(), vec![0.0; robot.dof()]), ("middle of the limits".to_string(), middle(&robot))];
    for text in &args.pose {
        poses.push((text.clone(), pose_of(&robot, text)?));
    }
    let findings = plausible::findings(&robot);
    for (name, q) in poses.iter().skip(FIXED_POSES) {
        for text in beyond_limits(&robot, q) {
            eprintln!("note: --pose {name}: {text}");
        }
    }
    let text = if args.json {
        serde_json::to_string_pretty(&document(&robot, &poses, &findings)).unwrap_or_default() + "\n"
    } else {
        tables(&robot, &poses, &findings)
    };
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|e| Error::io("standard output", "write", e))?;
    let faults: Vec<String> = findings.iter().filter(|f| f.is_fault()).map(sentence).collect();
    if faults.is_empty() { Ok(()) } else { Err(no(faults.join("\n"))) }
}

fn init(args: InitArgs) -> Result<()> {
    let inputs = [("--urdf", args.urdf.as_deref()), ("--dh", args.dh.as_deref())];
    super::paths::refuse_shared(&inputs, &[("--output", Some(&args.output))])?;
    let there = std::fs::metadata(&args.output).is_ok_and(|m| m.is_file() && m.len() > 0);
    if there && !args.force && !is_stdio(&args.output) {
        let expected = "another file (changes made by hand would be lost; --force replaces it)";
        return Err(bad(Place::file(shown(&args.output)), "a file", expected));
    }
    match (&args.urdf, &args.dh) {
        (Some(file), _) => of_urdf(&args, file),
        (None, Some(file)) => of_table(&args, file),
        (None, None) => Err(bad(Place::file("robot init"), "no input", "--urdf FILE.urdf or --dh FILE.csv")),
    }
}

/// Writes the robot file, unless its lengths can be those of no machine.
fn write(args: &InitArgs, input: &str, robot: &Robot, expected: &str) -> Result<()> {
    if let Some(f) = plausible::findings(robot).iter().find(|f| matches!(f, Finding::Reach { .. })) {
        return Err(bad(Place::file(input), sentence(f), expected));
    }
    let mut output = Output::create(&args.output)?;
    let option = match (&args.urdf, args.modified) {
        (Some(_), _) => "--urdf",
        (None, true) => "--modified --dh",
        (None, false) => "--dh",
    };
    let tip = args.tip.as_ref().map_or(String::new(), |tip| format!(" --tip {tip}"));
    // without the folders of the machine that made it
    let file = input.rsplit(['/', '\\']).next().unwrap_or(input);
    let made_of = format!("made by: lostmotion robot init {option} {file}{tip}");
    let lines = robot.to_lines(&made_of)?;
    // what no command could read is not written
    Robot::parse(input, &lines)?;
    output.put((schemas::editor_line(&args.output, "robot") + &lines).as_bytes())?;
    output.commit().map_err(Into::into)
}

/// `--dh`.
fn of_table(args: &InitArgs, file: &Path) -> Result<()> {
    let (text, input) = input::read_text(file)?;
    let convention = if args.modified { Convention::Modified } else { Convention::Standard };
    let title = file.file_stem().map_or_else(|| "robot".into(), |s| s.to_string_lossy().into_owned());
    let title = args.name.clone().unwrap_or(title);
    let robot = table::read(&input.name, &text, &title, convention)?;
    write(args, &input.name, &robot, "lengths in millimetres, as the headings state")?;
    let axes = if robot.dof() == 1 { "1 axis".into() } else { format!("{} axes", robot.dof()) };
    let named = if args.name.is_some() { "" } else { ", after the file (--name gives another)" };
    eprintln!(
        "{}: {axes}; the robot is named `{}`{named}; add base, flange and tool, and compare a pose with the pendant",
        input.name, robot.name
    );
    for finding in plausible::findings(&robot) {
        eprintln!("note: {}", sentence(&finding));
    }
    Ok(())
}

/// `--urdf`.
fn of_urdf(args: &InitArgs, file: &Path) -> Result<()> {
    let (text, input) = input::read_text(file)?;
    let mut made = urdf::read(&input.name, &text, args.tip.as_deref())?;
    if let Some(name) = &args.name {
        made.robot.name.clone_from(name);
    }
    let (distance_m, _) = made.largest_error;
    if distance_m.is_nan() || distance_m > SAME_CHAIN_M {
        return Err(bad(
            Place::file(&input.name),
            format!("joint axes that Denavit-Hartenberg parameters reproduce only within {:.3e} mm", distance_m * 1e3),
            "axes that are not nearly parallel at a great distance",
        ));
    }
    write(args, &input.name, &made.robot, "lengths in metres, as URDF has them")?;
    eprintln!(
        "{}: {} axes from the root to {}; the TCP follows the URDF within {:.1e} mm at 200 positions",
        input.name,
        made.robot.dof(),
        made.tip,
        distance_m * 1e3
    );
    if !made.flange.ends_with("tool0") {
        eprintln!(
            "note: the URDF has no link `tool0`: `{}` is used as the flange; compare a pose with the pendant before Cartesian programs",
            made.flange
        );
    }
    if let Some(world) = &made.world {
        eprintln!("link `{world}` is the controller's world, from which `base` is counted");
    }
    if !made.snapped.is_empty() {
        eprintln!("angles taken as multiples of 45 deg: {}", made.snapped.join(", "));
    }
    let massless: Vec<&str> = (made.robot.joints.iter().zip(&made.robot.links))
        .filter(|(_, l)| l.mass_kg == 0.0)
        .map(|(j, _)| j.name.as_str())
        .collect();
    if !massless.is_empty() {
        eprintln!("note: the URDF gives no mass for what {} moves: 0 kg", massless.join(", "));
    }
    for finding in plausible::findings(&made.robot) {
        eprintln!("note: {}", sentence(&finding));
    }
    Ok(())
}

/// Joints of a pose that are beyond their limits, in words.
fn beyond_limits(robot: &Robot, q: &[f64]) -> Vec<String> {
    let edge = |j: &crate::robot::Joint, v: f64| (j.kind.to_user_unit(v) * 1e6).round() / 1e6;
    let of = |(j, v): (&crate::robot::Joint, &f64)| {
        let [lo, hi] = j.limits?;
        let text = format!("{} is beyond its limits {} to {} {}", j.name, edge(j, lo), edge(j, hi), j.kind.unit());
        (!(lo..=hi).contains(v)).then_some(text)
    };
    robot.axis_joints().zip(q).filter_map(of).collect()
}

fn middle(robot: &Robot) -> Vec<f64> {
    robot.axis_joints().map(|j| j.limits.map_or(0.0, |[lo, hi]| 0.5 * (lo + hi))).collect()
}

fn pose_of(robot: &Robot, text: &str) -> Result<Vec<f64>> {
    let values: Vec<Option<f64>> =
        text.split(',').map(|w| w.trim().parse::<f64>().ok().filter(|v| v.is_finite())).collect();
    let found =
        || bad(Place::file("--pose"), format!("`{text}`"), format!("{} numbers, deg or mm: one per axis", robot.dof()));
    if values.len() != robot.dof() {
        return Err(found());
    }
    robot.axis_joints().zip(values).map(|(j, v)| v.map(|v| v * j.kind.si_per_user_unit()).ok_or_else(found)).collect()
}

/// Position of the TCP, mm, and its fixed-axis X, Y, Z angles, deg.
fn tcp(robot: &Robot, q: &[f64]) -> ([f64; 3], [f64; 3]) {
    let pose = robot.forward(q);
    let (r, p, y) = pose.rotation.euler_angles();
    ((pose.position * 1e3).into(), [r, p, y].map(f64::to_degrees))
}

/// What `--json` prints.
#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    robot: NameAndHash,
    axes: Vec<&'a str>,
    reach_mm: f64,
    poses: Vec<PoseFields<'a>>,
    findings: Vec<FindingFields>,
}

/// The TCP at one pose.
#[derive(Serialize)]
struct PoseFields<'a> {
    pose: &'a str,
    joints: Vec<f64>,
    xyz_mm: [f64; 3],
    rpy_deg: [f64; 3],
}

#[derive(Serialize)]
struct FindingFields {
    fault: bool,
    finding: String,
}

fn document<'a>(robot: &'a Robot, poses: &'a [(String, Vec<f64>)], findings: &[Finding]) -> Document<'a> {
    let pose = |(name, q): &'a (String, Vec<f64>)| {
        let (xyz_mm, rpy_deg) = tcp(robot, q);
        let joints = robot.axis_joints().zip(q).map(|(j, v)| j.kind.to_user_unit(*v)).collect();
        PoseFields { pose: name, joints, xyz_mm, rpy_deg }
    };
    Document {
        schema: SCHEMA,
        robot: NameAndHash::of_robot(robot),
        axes: robot.axis_names(),
        reach_mm: plausible::reach_m(robot) * 1e3,
        poses: poses.iter().map(pose).collect(),
        findings: findings.iter().map(|f| FindingFields { fault: f.is_fault(), finding: sentence(f) }).collect(),
    }
}

fn tables(robot: &Robot, poses: &[(String, Vec<f64>)], findings: &[Finding]) -> String {
    let mut joints =
        super::print::table(&["joint", "kind", "theta", "d", "a", "alpha", "limits", "speed", "acceleration"]);
    for j in &robot.joints {
        let unit = j.kind.unit();
        let edge =
            |v: f64| format!("{:.6}", j.kind.to_user_unit(v)).trim_end_matches('0').trim_end_matches('.').to_string();
        let rate = |v: Option<f64>, per: &str| v.map_or("-".into(), |v| format!("{} {unit}/{per}", edge(v)));
        let kind = if j.kind == JointKind::Revolute { "revolute" } else { "prismatic" };
        joints.add_row([
            j.name.clone(),
            kind.to_string(),
            format!("{:.4} deg", j.theta_rad.to_degrees()),
            format!("{:.4} mm", j.d_m * 1e3),
            format!("{:.4} mm", j.a_m * 1e3),
            format!("{:.4} deg", j.alpha_rad.to_degrees()),
            j.limits.map_or("-".into(), |[lo, hi]| format!("{} to {} {unit}", edge(lo), edge(hi))),
            rate(j.max_speed, "s"),
            rate(j.max_accel, "s2"),
        ]);
    }
    let mut places = super::print::table(&["TCP at", "x mm", "y mm", "z mm", "rx deg", "ry deg", "rz deg"]);
    for (name, q) in poses {
        let (xyz, rpy) = tcp(robot, q);
        // -0.0000 reads badly
        let cells = xyz.into_iter().chain(rpy).map(|v| format!("{:.4}", (v * 1e4).round() / 1e4 + 0.0));
        places.add_row(std::iter::once(name.clone()).chain(cells));
    }
    let mut text = format!(
        "{}: {}, reach at most {:.0} mm\n\n{joints}\n\n{places}\n",
        robot.name,
        counted(robot.joints.len(), "joint"),
        plausible::reach_m(robot) * 1e3
    );
    for f in findings.iter().filter(|f| !f.is_fault()) {
        text.push_str(&format!("\nnote: {}", sentence(f)));
    }
    if findings.iter().any(|f| !f.is_fault()) {
        text.push('\n');
    }
    text
}

/// A finding in words: what was found, what follows.
fn sentence(finding: &Finding) -> String {
    match finding {
        Finding::Reach { reach_m } => format!(
            "the links span {:.4} mm, which no machine does: are metres written as millimetres, or millimetres as metres?",
            reach_m * 1e3
        ),
        Finding::LimitsInRadians => "every revolute joint has limits below 7 deg: are they radians?".into(),
        Finding::SameAxis { joints: [a, b] } => {
            format!("{a} and {b} move about the same axis: is an alpha or a link length missing?")
        }
        Finding::AngleInRadians { joint, key, value } => {
            format!("{key} of {joint} is {value:.4}: is this radians?")
        }
        Finding::FrameInRadians { frame, value } => {
            format!("rpy_deg of {frame} has an angle of {value:.4}: is this radians?")
        }
        Finding::ToolInMetres { mm } => {
            format!("tool is {} mm long: is xyz_mm in metres?", (mm * 1e6).round() / 1e6)
        }
        Finding::JointLimitsInRadians { joint, limits: [lo, hi] } => {
            let [lo, hi] = [lo, hi].map(|v| (v * 1e6).round() / 1e6);
            format!("{joint} has limits {lo} to {hi} deg, where others turn far: are they radians?")
        }
        Finding::LengthInMetres { joint, key, mm } => {
            format!("{key} of {joint} is {}, far below the other lengths: is this metres?", (mm * 1e9).round() / 1e9)
        }
        Finding::SpeedInRadians { joint, deg_s } => {
            format!("the largest speed of {joint} is {:.3} deg/s: is this rad/s?", deg_s)
        }
        Finding::Mass { joint, mass_kg } => format!("the link of {joint} weighs {mass_kg} kg: are these grams?"),
        Finding::NoLimits { joints } => {
            format!("no limits of travel for {}: rewrite cannot check them", joints.join(", "))
        }
        Finding::NoSpeeds { joints } => {
            format!("no largest speed for {}: rewrite cannot check the speed of its steps", joints.join(", "))
        }
        Finding::NoAccelerations { joints } => {
            format!(
                "no largest acceleration for {}: rewrite cannot check the acceleration of its steps",
                joints.join(", ")
            )
        }
        Finding::NoMasses => "no links with masses: deflections by gravity are not computed".into(),
    }
}
