//! `lostmotion assess impact`.

use crate::assess::impact::{AxisGap, JointImpact, displacement_m, over_program};
use crate::cli::exit::bad;
use crate::cli::print::{print, print_json, table};
use crate::cli::{page, paths};
use crate::effects::GapCurve;
use crate::error::Place;
use crate::gaps::file::NameAndHash;
use crate::io::keyed::Keyed;
use crate::io::output;
use crate::model::Model;
use crate::program::Program;
use crate::robot::{Joint, Robot};
use anyhow::Result;
use serde::Serialize;
use std::path::PathBuf;

pub const SCHEMA: &str = "lostmotion/impact/1";

/// Compute how far one half gap of each joint moves the TCP, at a pose or over a program.
///
/// The computation needs only the robot: |F(q + gap) - F(q)|. Two measurements from opposite sides differ by twice this
/// distance. Over a program, the joints are ranked by the error at their reversals.
///
/// Give --pose once for all joints, or once per joint, in their order. A pose for one joint by its name (A4@...) takes
/// precedence over a pose for all joints.
///
/// Examples:
///   lostmotion assess impact --robot robot.yaml --pose 40,-10,5,0,0,0 \
///       --half-gap 0.0032,0.005,0.0022,0.008,0.0092,0.0078
///   lostmotion assess impact --robot robot.yaml --pose A1@40,-10,5,0,0,0 \
///       --pose A4@-3,-52,58,-80,0,0 --half-gap A1=0.0032,A4=0.008
///   lostmotion assess impact --model machine.yaml --program circle.csv --json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
#[command(group = clap::ArgGroup::new("machine").required(true).args(["robot", "model"]))]
#[command(group = clap::ArgGroup::new("place").required(true).args(["pose", "program"]))]
#[command(
    override_usage = "lostmotion assess impact [OPTIONS] --robot <ROBOT.yaml> --half-gap <G1,...> <--pose <[NAME@]Q1,...>|--program <PROGRAM.csv>>\n       lostmotion assess impact [OPTIONS] --model <MODEL.yaml> <--pose <[NAME@]Q1,...>|--program <PROGRAM.csv>>"
)]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "ROBOT.yaml", requires = "half_gap")]
    pub robot: Option<PathBuf>,
    /// Model file (YAML): uses its robot and the half gaps of its backlash effects (several gaps of one joint add up)
    #[arg(long, value_name = "MODEL.yaml")]
    pub model: Option<PathBuf>,
    /// Joint positions, deg or mm, in the order of the robot file; NAME@... for the gap of one joint; repeat the option for
    /// several poses
    #[arg(long, value_name = "[NAME@]Q1,Q2,...", allow_hyphen_values = true)]
    pub pose: Vec<String>,
    /// Program whose points are used as poses (joint-space CSV)
    #[arg(long, value_name = "PROGRAM.csv", conflicts_with = "pose")]
    pub program: Option<PathBuf>,
    /// Half gaps, deg or mm: one for each joint, or NAME=GAP,NAME=GAP
    #[arg(long, value_name = "G1,G2,... | NAME=G,...", conflicts_with = "model")]
    pub half_gap: Option<String>,
    /// Print the result as one JSON document (lostmotion/impact/1) instead of the table
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let inputs = [
        ("--robot", args.robot.as_deref()),
        ("--model", args.model.as_deref()),
        ("--program", args.program.as_deref()),
    ];
    paths::refuse_shared(&inputs, &[("--report", args.report.as_deref())])?;
    let mut report = output::create(args.report.as_deref())?;
    let (robot, gaps) = match (&args.model, &args.robot) {
        (Some(path), _) => {
            let model = Model::load(path)?;
            let gaps = AxisGap::of_model(&model);
            if gaps.is_empty() {
                return Err(bad(
                    Place::file(crate::error::shown(path)),
                    "no backlash effect",
                    "a gap on at least one joint",
                ));
            }
            (model.robot, gaps)
        }
        (None, Some(path)) => {
            let robot = Robot::load(path)?;
            let gaps = gaps_of_text(&robot, args.half_gap.as_deref().unwrap_or_default())?;
            (robot, gaps)
        }
        (None, None) => return Err(usage("neither --robot nor --model", "one of them")),
    };
    match &args.program {
        Some(path) => {
            let program = Program::load(path, &robot)?;
            let joints = over_program(&robot, &program, &gaps);
            page::write(&mut report, || page::impact::of_program(&robot, &joints))?;
            output::commit([report])?;
            if args.json {
                print_json(&program_document(&robot, &program, &joints))
            } else {
                print(&program_table(&robot, &program, &joints))
            }
        }
        None => {
            let poses = Poses::parse(&robot, &args.pose)?;
            let mut rows = Vec::new();
            for gap in &gaps {
                let q = poses.of(&robot, gap.axis)?;
                let half_gap = gap.at(q[gap.axis]);
                rows.push((gap.axis, half_gap, q, displacement_m(&robot, q, gap.axis, half_gap)));
            }
            page::write(&mut report, || page::impact::of_poses(&robot, &rows))?;
            output::commit([report])?;
            if args.json { print_json(&pose_document(&robot, &rows)) } else { print(&pose_table(&robot, &rows)) }
        }
    }
}

fn usage(found: impl Into<String>, expected: impl Into<String>) -> anyhow::Error {
    bad(Place::file("command line"), found, expected)
}

fn finite(text: &str, what: &str) -> Result<f64> {
    let value = text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    value.ok_or_else(|| usage(format!("`{text}` in {what}"), "a finite number with a decimal point"))
}

fn axis_named(robot: &Robot, name: &str) -> Result<usize> {
    robot
        .axis_named(name.trim())
        .ok_or_else(|| usage(format!("joint `{name}`"), format!("one of {}", robot.axis_names().join(", "))))
}

/// Gaps of the command line, in SI and in the order of the axes.
fn gaps_of_text(robot: &Robot, text: &str) -> Result<Vec<AxisGap>> {
    let parts: Vec<&str> = text.split(',').collect();
    let named = parts.iter().filter(|p| p.contains('=')).count();
    let mut gaps: Vec<AxisGap> = Vec::new();
    if named == 0 && parts.len() != robot.dof() || named != 0 && named != parts.len() {
        let expected = format!("one gap for each of {}, or NAME=GAP for some of them", robot.axis_names().join(", "));
        return Err(usage(format!("--half-gap {text}"), expected));
    }
    for (i, part) in parts.iter().enumerate() {
        let (axis, number) = match part.split_once('=') {
            Some((name, number)) => (axis_named(robot, name)?, number),
            None => (i, *part),
        };
        let gap = finite(number, "--half-gap")?;
        if gap < 0.0 || gaps.iter().any(|g| g.axis == axis) {
            return Err(usage(format!("`{part}` in --half-gap"), "one gap of 0 or more for a joint"));
        }
        gaps.push(AxisGap { axis, curves: vec![GapCurve::Constant(gap * robot.axis(axis).kind.si_per_user_unit())] });
    }
    gaps.sort_by_key(|g| g.axis);
    Ok(gaps)
}

/// Poses of the command line.
struct Poses {
    for_all: Option<Vec<f64>>,
    of_axis: Vec<Option<Vec<f64>>>,
}

impl Poses {
    fn parse(robot: &Robot, texts: &[String]) -> Result<Self> {
        let mut plain = Vec::new();
        let mut of_axis = vec![None; robot.dof()];
        for text in texts {
            let (name, numbers) = match text.split_once('@') {
                Some((name, numbers)) => (Some(name), numbers),
                None => (None, text.as_str()),
            };
            let values: Vec<&str> = numbers.split(',').collect();
            if values.len() != robot.dof() {
                return Err(usage(
                    format!("--pose {text} with {} values", values.len()),
                    format!("one for each of {}", robot.axis_names().join(", ")),
                ));
            }
            let mut q = Vec::with_capacity(values.len());
            for (v, joint) in values.iter().zip(robot.axis_joints()) {
                q.push(finite(v, "--pose")? * joint.kind.si_per_user_unit());
            }
            match name {
                Some(name) => {
                    let axis = axis_named(robot, name)?;
                    if of_axis[axis].replace(q).is_some() {
                        return Err(usage(format!("a second --pose for {name}"), "one pose for a joint"));
                    }
                }
                None => plain.push(q),
            }
        }
        if plain.len() > 1 {
            if plain.len() != robot.dof() || of_axis.iter().any(Option::is_some) {
                let expected = format!("one --pose, or {} (one per joint), or NAME@... for some joints", robot.dof());
                return Err(usage(format!("{} times --pose", texts.len()), expected));
            }
            return Ok(Self { for_all: None, of_axis: plain.into_iter().map(Some).collect() });
        }
        Ok(Self { for_all: plain.pop(), of_axis })
    }

    fn of(&self, robot: &Robot, axis: usize) -> Result<&[f64]> {
        self.of_axis[axis].as_deref().or(self.for_all.as_deref()).ok_or_else(|| {
            let name = &robot.axis(axis).name;
            usage(format!("a gap for {name} and no pose"), format!("--pose {name}@..., or a --pose for all joints"))
        })
    }
}

type PoseRow<'a> = (usize, f64, &'a [f64], f64);

fn edge(joint: &Joint, si: f64) -> f64 {
    (joint.kind.to_user_unit(si) * 1e9).round() / 1e9
}

fn um(m: f64) -> f64 {
    (m * 1e9).round() / 1e3
}

/// What `--json` prints: at poses, or over a program.
#[derive(Serialize)]
struct Document<'a, J> {
    schema: &'static str,
    robot: NameAndHash,
    #[serde(skip_serializing_if = "Option::is_none")]
    program: Option<ProgramFields<'a>>,
    joints: Vec<J>,
}

#[derive(Serialize)]
struct ProgramFields<'a> {
    name: &'a str,
    points: usize,
}

/// What the gap of a joint does at one pose.
#[derive(Serialize)]
struct AtPose<'a> {
    joint: &'a str,
    tcp_um: f64,
    between_directions_um: f64,
    #[serde(flatten)]
    half_gap: Keyed<f64>,
    pose: Vec<f64>,
}

/// What the gap of a joint does over a program.
#[derive(Serialize)]
struct OverProgram<'a> {
    joint: &'a str,
    tcp_um: f64,
    line: Option<u64>,
    #[serde(flatten)]
    half_gap: Keyed<f64>,
    rms_um: f64,
    reversals: usize,
    at_reversals_um: Option<f64>,
    share: f64,
}

fn half_gap(joint: &Joint, si: f64) -> Keyed<f64> {
    Keyed::new("half_gap", joint.kind.unit(), edge(joint, si))
}

fn pose_document<'a>(robot: &'a Robot, rows: &[PoseRow]) -> Document<'a, AtPose<'a>> {
    let joints = rows.iter().map(|(axis, gap, q, m)| {
        let joint = robot.axis(*axis);
        AtPose {
            joint: &joint.name,
            tcp_um: um(*m),
            between_directions_um: um(2.0 * m),
            half_gap: half_gap(joint, *gap),
            pose: robot.axis_joints().zip(*q).map(|(j, v)| edge(j, *v)).collect(),
        }
    });
    Document { schema: SCHEMA, robot: NameAndHash::of_robot(robot), program: None, joints: joints.collect() }
}

fn pose_table(robot: &Robot, rows: &[PoseRow]) -> String {
    let mut t = table(&["joint", "half gap", "TCP, um", "between directions, um", "at"]);
    for (axis, gap, q, m) in rows {
        let joint = robot.axis(*axis);
        let pose: Vec<String> = robot.axis_joints().zip(*q).map(|(j, v)| format!("{}", edge(j, *v))).collect();
        t.add_row(vec![
            joint.name.clone(),
            format!("{:.6} {}", edge(joint, *gap), joint.kind.unit()),
            format!("{:.2}", m * 1e6),
            format!("{:.2}", 2e6 * m),
            pose.join(", "),
        ]);
    }
    format!("{t}\n")
}

fn program_document<'a>(
    robot: &'a Robot,
    program: &'a Program,
    joints: &[JointImpact],
) -> Document<'a, OverProgram<'a>> {
    let joints = joints.iter().map(|j| {
        let joint = robot.axis(j.axis);
        OverProgram {
            joint: &joint.name,
            tcp_um: um(j.largest_m),
            line: j.largest_line,
            half_gap: half_gap(joint, j.half_gap),
            rms_um: um(j.rms_m),
            reversals: j.reversals,
            at_reversals_um: j.at_reversals_m.map(um),
            share: (j.share * 1e4).round() / 1e4,
        }
    });
    Document {
        schema: SCHEMA,
        robot: NameAndHash::of_robot(robot),
        program: Some(ProgramFields { name: &program.name, points: program.len() }),
        joints: joints.collect(),
    }
}

fn program_table(robot: &Robot, program: &Program, joints: &[JointImpact]) -> String {
    let mut t = table(&[
        "joint",
        "half gap",
        "largest, um",
        "at line",
        "rms, um",
        "reversals",
        "largest at reversal, um",
        "share",
    ]);
    for j in joints {
        let joint = robot.axis(j.axis);
        t.add_row(vec![
            joint.name.clone(),
            format!("{:.6} {}", edge(joint, j.half_gap), joint.kind.unit()),
            format!("{:.1}", j.largest_m * 1e6),
            j.largest_line.map_or("-".into(), |l| l.to_string()),
            format!("{:.1}", j.rms_m * 1e6),
            j.reversals.to_string(),
            j.at_reversals_m.map_or("-".into(), |m| format!("{:.1}", m * 1e6)),
            if j.reversals > 0 { format!("{:.1} %", j.share * 100.0) } else { "-".into() },
        ]);
    }
    format!("{} points of {}\n\n{t}\n", program.len(), program.name)
}
