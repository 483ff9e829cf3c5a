//! What the arguments of `rewrite` ask for, every value checked.

use super::args::{Args, usage};
use crate::compensator::{Compensator, from_model::not_compensated};
use crate::effects::EffectInstance;
use crate::error::shown;
use crate::io::input;
use crate::io::name::text_of_name;
use crate::io::output::Durability;
use crate::model::Model;
use crate::program::fanuc::Registers;
use crate::program::files::Files;
use crate::program::format_named;
use crate::program::no_motion::NoMotion;
use crate::rewrite::equation2::Law;
use crate::rewrite::guard::{Named, Notes};
use crate::rewrite::job::Job;
use crate::rewrite::script::Choices;
use crate::rewrite::script::context::Contexts;
use crate::rewrite::statics::Statics;
use crate::rewrite::{Options, Refine};
use crate::robot::frames::Frames;
use crate::robot::{JointKind, Robot};
use anyhow::Result;
use robot_programs::control::{Control, WORDS};
use std::path::Path;
use std::sync::Arc;

/// Robot, compensator, and where they came from.
pub(super) struct Source {
    pub(super) robot: Robot,
    pub(super) compensator: Compensator,
    pub(super) named: Named,
    pub(super) file: String,
    /// Side of its gap on which each axis starts, where a model says so.
    initial_gap_side: Option<Vec<i8>>,
    /// Static joint errors of a model.
    statics: Option<Arc<Statics>>,
    /// The machine on which the verdict is worked out: the model, or that of a compensator with evidence.
    pub(super) machine: Option<Model>,
    /// What of a model is not compensated.
    pub(super) left: Vec<String>,
}

impl Source {
    pub(super) fn load(args: &Args) -> Result<Self> {
        let (mut statics, mut left) = (None, Vec::new());
        let machine;
        let (robot, compensator, path, initial_gap_side) = match (&args.model, &args.robot, &args.compensator) {
            (Some(path), ..) => {
                let model = Model::load(path)?;
                let speed = args.speed_mm_s.map(|v| v * 1e-3);
                let compensator = Compensator::from_model_at(&model, speed.unwrap_or(0.0))?;
                left = not_compensated(&model, speed);
                statics = statics_of(args, &model, &mut left)?.map(Arc::new);
                machine = Some(model.clone());
                (model.robot, compensator, path, Some(model.initial_gap_side))
            }
            (None, Some(robot), Some(path)) => {
                let robot = Robot::load(robot)?;
                let compensator = Compensator::load(path, &robot)?;
                machine = compensator.machine(&robot);
                (robot, compensator, path, None)
            }
            _ => return Err(usage("no compensator", "--robot and --compensator, or --model")),
        };
        let (mut robot, mut compensator) = (robot, compensator);
        if let Some(words) = &args.assume {
            let control = Control::of_words(words.split(','));
            let expected = format!("{WORDS}: --assume G21,G90");
            robot.assume(control.map_err(|word| usage(&format!("--assume {}", word.0), &expected))?);
        }
        if let Some(name) = args.no_motion.iter().find(|name| !NoMotion::is_name(name)) {
            return Err(usage(&format!("--no-motion `{name}`"), "the name of a program, a macro or a routine"));
        }
        robot.declare_no_motion(args.no_motion.iter().map(String::as_str));
        let listed = args.frames.iter().map(|path| Ok(Frames::load(path)?.registers));
        let listed: Vec<Registers> = listed.collect::<Result<_>>()?;
        robot.hold_registers(one_listing(listed)?);
        leave_out(args, &robot, &mut compensator, &mut left)?;
        let sha256 = input::read(path)?.sha256;
        let name = path.file_name().map_or_else(|| shown(path), text_of_name);
        Ok(Self {
            robot,
            compensator,
            named: Named { name, sha256 },
            file: shown(path),
            initial_gap_side,
            statics,
            machine,
            left,
        })
    }
}

/// The registers of the listings that are given; those of two listings are one controller's at different times.
fn one_listing(listed: Vec<Registers>) -> Result<Registers> {
    let mut all = listed.into_iter().filter(|r| !r.positions.is_empty());
    let first = all.next().unwrap_or_default();
    match all.next() {
        Some(_) => Err(usage("two listings of position registers in --frames", "one of them")),
        None => Ok(first),
    }
}

/// What of a model is undone at every point, without the joints that are left out.
fn statics_of(args: &Args, model: &Model, left: &mut Vec<String>) -> Result<Option<Statics>> {
    if args.lost_motion_only {
        let line =
            |p: &EffectInstance| format!("{} of {}: --lost-motion-only", p.effect.name(), p.target_text(&model.robot));
        left.extend(Statics::undone(model).map(line));
        return Ok(None);
    }
    let out = left_out(args, &model.robot)?;
    let kept = Statics::undone(model).filter(|p| p.axis().is_none_or(|axis| !out.contains(&axis)));
    Ok(Statics::of_effects(&model.robot, kept))
}

/// Axes of `--leave-out`.
fn left_out(args: &Args, robot: &Robot) -> Result<Vec<usize>> {
    let names = args.leave_out.iter().flat_map(|l| l.split(',')).map(str::trim).filter(|n| !n.is_empty());
    if args.leave_out.is_some() && names.clone().next().is_none() {
        let expected = format!("joints of {}", robot.axis_names().join(", "));
        return Err(usage("--leave-out without a joint", &expected));
    }
    let one = |name: &str| {
        let expected = || format!("joints of {}", robot.axis_names().join(", "));
        robot.axis_named(name).ok_or_else(|| usage(&format!("--leave-out {name}"), &expected()))
    };
    names.map(one).collect()
}

/// Frames and tools of `--frames`; they and those of the robot file stand in the note.
fn frames(args: &Args, robot: &Robot, said: &mut Vec<String>) -> Result<Frames> {
    let mut frames = Frames::default();
    for path in &args.frames {
        said.push(format!("frames {}", input::read(path)?.sha256));
        let more = Frames::load(path)?;
        differing(&robot.frames, &more, "in the robot file")?;
        differing(&frames, &more, "in another file of --frames")?;
        frames = frames.with(&more);
    }
    Ok(frames)
}

/// Refuses a frame or tool that is given twice with different numbers: a mistake in one of the files.
fn differing(ours: &Frames, theirs: &Frames, place: &str) -> Result<()> {
    for (what, ours, theirs) in [("frame", &ours.frames, &theirs.frames), ("tool", &ours.tools, &theirs.tools)] {
        if let Some((name, _)) = theirs.iter().find(|(name, f)| ours.get(*name).is_some_and(|o| o != *f)) {
            return Err(usage(&format!("{what} `{name}` of --frames, whose numbers {place} differ"), "one of them"));
        }
    }
    let both = ours.machine.as_ref().zip(theirs.machine.as_ref());
    if both.is_some_and(|(ours, theirs)| ours != theirs) {
        return Err(usage(&format!("a `$machine.dat` of --frames, whose numbers {place} differ"), "one of them"));
    }
    Ok(())
}

/// The job that the arguments ask for, every value checked.
pub(super) fn of<'a>(args: &Args, source: &'a Source) -> Result<Job<'a>> {
    let robot = &source.robot;
    let mut options = Options::new(robot.dof());
    options.statics = source.statics.clone();
    let mut said = Vec::new();
    law(args, &mut options, &mut said)?;
    step(args, &mut options, &mut said)?;
    let lengths = Lengths::of(args)?;
    options.ramp = lengths.ramp.per_axis(robot).into_iter().map(|v| v.unwrap_or(0.0)).collect();
    lengths.note(args, &mut said);
    if let Some(side) = &source.initial_gap_side {
        options.initial_direction = side.clone();
    }
    if let Some(text) = &args.initial_direction {
        directions("initial-direction", text, robot, &mut options.initial_direction)?;
        said.push(format!("initial_direction {text}"));
    }
    let speed = number("speed-mm-s", args.speed_mm_s, |v| v > 0.0, "a speed above 0")?;
    options.tcp_speed_m_s = speed.map(|v| v * 1e-3).or(source.compensator.evidence.tcp_speed_m_s);
    if let Some(c) = number("chord-um", args.chord_um, |v| v > 0.0, "a distance above 0")? {
        if options.refine != Refine::Cartesian {
            return Err(usage(&format!("--chord-um {c} without --refine cartesian"), "both, or neither"));
        }
        options.chord_m = c * 1e-6;
    }
    // limits and pulses are not in the fingerprint, but in the result
    said.push(format!("robot_file {}", input::sha256(robot.to_yaml()?.as_bytes())));
    let choices = choices(args, robot, speed, &mut said)?;
    Ok(Job {
        format: args.format.as_deref().map(format_named).transpose()?,
        choices,
        files: Files::Disk,
        contexts: Contexts::default(),
        tolerance: number("tolerance", args.tolerance, |v| v >= 0.0, "a number of 0 or more")?,
        durability: if args.output_dir.is_some() { Durability::RenameOnly } else { Durability::Synced },
        notes: Notes::default(),
        robot,
        compensator: &source.compensator,
        source: source.named.clone(),
        options,
        deadband: lengths.deadband.per_axis(robot),
        decimals: args.decimals,
        said,
        force: args.force,
        replace: args.replace,
        hash: args.json || args.summary.is_some() || args.output_dir.is_some(),
        all_changes: args.json,
        threads: !(args.input != Path::new("-") && args.input.is_dir()),
    })
}

/// The value of an option, checked.
fn number(flag: &str, value: Option<f64>, ok: impl Fn(f64) -> bool, expected: &str) -> Result<Option<f64>> {
    match value {
        Some(v) if !(v.is_finite() && ok(v)) => Err(usage(&format!("--{flag} {v}"), expected)),
        v => Ok(v),
    }
}

/// `--law` and `--refine`.
fn law(args: &Args, options: &mut Options, said: &mut Vec<String>) -> Result<()> {
    options.law = args.law.into();
    if options.law != Law::SymmetricHalfGap {
        if args.refine.is_some() {
            return Err(usage("--refine with --law equation-2", "equation 2 adds no points: leave --refine out"));
        }
        said.push(format!("law {}", if options.law == Law::Equation2 { "equation-2" } else { "equation-2-held" }));
    }
    if let Some(r) = args.refine {
        options.refine = r.into();
        said.push(format!("refine {}", format!("{r:?}").to_lowercase()));
    }
    Ok(())
}

/// `--step-fraction` and `--gain`.
fn step(args: &Args, options: &mut Options, said: &mut Vec<String>) -> Result<()> {
    let expected = "a share above 0, at most 1";
    if let Some(f) = number("step-fraction", args.step_fraction, |v| v > 0.0 && v <= 1.0, expected)? {
        options.step_fraction = f;
        options.step_exact = true;
        said.push(format!("step_fraction {f}"));
    }
    if number("gain", Some(args.gain), |v| (0.0..=1.0).contains(&v), "a share from 0 to 1")? != Some(1.0) {
        options.gain = args.gain;
        said.push(format!("gain {}", args.gain));
    }
    Ok(())
}

/// A length for revolute joints and one for prismatic joints.
struct Length {
    deg: Option<f64>,
    mm: Option<f64>,
}

impl Length {
    fn of(name: &str, deg: Option<f64>, mm: Option<f64>) -> Result<Self> {
        let checked = |unit: &str, v| number(&format!("{name}-{unit}"), v, |v| v >= 0.0, "a number of 0 or more");
        Ok(Self { deg: checked("deg", deg)?, mm: checked("mm", mm)? })
    }

    /// One per axis, rad or m.
    fn per_axis(&self, robot: &Robot) -> Vec<Option<f64>> {
        let of_kind = |kind: JointKind| match kind {
            JointKind::Revolute => self.deg,
            JointKind::Prismatic => self.mm,
        };
        robot.axis_joints().map(|j| of_kind(j.kind).map(|v| v * j.kind.si_per_user_unit())).collect()
    }
}

/// `--ramp-*` and `--deadband-*`.
struct Lengths {
    ramp: Length,
    deadband: Length,
}

impl Lengths {
    fn of(args: &Args) -> Result<Self> {
        Ok(Self {
            ramp: Length::of("ramp", args.ramp_deg, args.ramp_mm)?,
            deadband: Length::of("deadband", args.deadband_deg, args.deadband_mm)?,
        })
    }

    /// As they stand in the note, with the other numbers of the command.
    fn note(&self, args: &Args, said: &mut Vec<String>) {
        for (what, v) in [
            ("ramp_deg", self.ramp.deg),
            ("ramp_mm", self.ramp.mm),
            ("deadband_deg", self.deadband.deg),
            ("deadband_mm", self.deadband.mm),
            ("speed_mm_s", args.speed_mm_s),
            ("chord_um", args.chord_um),
            ("decimals", args.decimals.map(f64::from)),
        ] {
            said.extend(v.map(|v| format!("{what} {v}")));
        }
    }
}

/// What concerns vendor programs.
fn choices(args: &Args, robot: &Robot, speed_mm_s: Option<f64>, said: &mut Vec<String>) -> Result<Choices> {
    if args.insignificant {
        said.push("insignificant".into());
    }
    said.extend(robot.axes().no_motion.names().map(|name| format!("no_motion {name}")));
    for (what, value) in [("format", &args.format), ("require_coverage", &args.require_coverage)] {
        said.extend(value.as_ref().map(|v| format!("{what} {v}")));
    }
    if let Some(list) = &args.leave_out {
        said.push(format!("leave_out {list}"));
    }
    if args.lost_motion_only {
        said.push("lost_motion_only".into());
    }
    let solve_um = number("solve-cartesian", args.solve_cartesian, |v| v > 0.0, "a distance above 0")?;
    said.extend(solve_um.map(|v| format!("solve_cartesian_um {v}")));
    for (what, asked) in [
        ("exclude_process", args.exclude_process),
        ("leave_cartesian", args.leave_cartesian),
        ("leave_process", args.leave_process),
        ("approach_unknown", args.approach_unknown),
    ] {
        said.extend(asked.then(|| what.to_string()));
    }
    said.extend(args.max_added.map(|n| format!("max_added {n}")));
    let least_gain_um = number("min-gain", args.min_gain, |v| v > 0.0, "a distance above 0")?;
    said.extend(least_gain_um.map(|v| format!("min_gain_um {v}")));
    Ok(Choices {
        exclude_process: args.exclude_process,
        solve_within_m: solve_um.map(|um| um * 1e-6),
        speed_m_s: speed_mm_s.map(|v| v * 1e-3),
        require_coverage: args.require_coverage.as_deref().map(share).transpose()?,
        frames: frames(args, robot, said)?,
        leave_poses: args.leave_cartesian,
        max_added: args.max_added,
        least_gain_m: least_gain_um.map(|um| um * 1e-6),
        leave_process: args.leave_process,
        approach_from: approach(args, robot, said)?,
        approach_unknown: args.approach_unknown,
    })
}

/// `--approach-from`: `+`, `-`, or signs of single joints.
fn approach(args: &Args, robot: &Robot, said: &mut Vec<String>) -> Result<Vec<i8>> {
    let Some(text) = &args.approach_from else { return Ok(Vec::new()) };
    let mut signs = vec![0; robot.dof()];
    match text.trim() {
        "+" => signs.fill(1),
        "-" => signs.fill(-1),
        list => directions("approach-from", list, robot, &mut signs)?,
    }
    said.push(format!("approach_from {text}"));
    Ok(signs)
}

/// `A1=+,A2=-` into one sign per axis.
fn directions(flag: &str, text: &str, robot: &Robot, into: &mut [i8]) -> Result<()> {
    let parts = text.split(',').map(str::trim).filter(|p| !p.is_empty());
    if parts.clone().next().is_none() {
        return Err(usage(&format!("--{flag} without a joint"), "JOINT=+ or JOINT=-, such as A1=+,A2=-"));
    }
    for part in parts {
        let (joint, sign) = part.split_once('=').unwrap_or((part, ""));
        let sign = match sign.trim() {
            "+" | "+1" | "1" => 1,
            "-" | "-1" => -1,
            "0" => 0,
            _ => return Err(usage(&format!("--{flag} {part}"), "JOINT=+ or JOINT=-, such as A1=+,A2=-")),
        };
        match robot.axis_named(joint.trim()) {
            Some(axis) => into[axis] = sign,
            None => {
                let expected = format!("a joint of {}", robot.axis_names().join(", "));
                return Err(usage(&format!("--{flag} {part}"), &expected));
            }
        }
    }
    Ok(())
}

/// Joints that are not compensated: those that the user names, and those whose gap is not significant.
fn leave_out(args: &Args, robot: &Robot, compensator: &mut Compensator, left: &mut Vec<String>) -> Result<()> {
    for axis in left_out(args, robot)? {
        compensator.joints.retain(|j| j.axis != axis);
        left.push(format!("{}, as asked", robot.axis(axis).name));
    }
    if args.insignificant {
        return Ok(());
    }
    for axis in compensator.unproved() {
        compensator.joints.retain(|j| j.axis != axis);
        left.push(format!("{}, whose gap may be zero (--insignificant does)", robot.axis(axis).name));
    }
    Ok(())
}

/// `95%` or `95` as a share.
fn share(text: &str) -> Result<f64> {
    let percent = text.trim().trim_end_matches('%').trim().parse::<f64>().ok();
    match percent.filter(|p| (0.0..=100.0).contains(p)) {
        Some(p) => Ok(p / 100.0),
        None => Err(usage(&format!("--require-coverage {text}"), "a percentage from 0% to 100%")),
    }
}
