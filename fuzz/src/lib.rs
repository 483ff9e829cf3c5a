//! What the fuzz targets share: robots, and what must hold of every input.
//!
//! What is looked at besides panics: a zero compensator changes no byte; no refusal names a mistake of ours (the result is read again, step
//! by step, before it is given out); and, found without the library's own edit plan, the rewritten program leads to every joint target of
//! the program within the gap, in its order.

use lostmotion::compensator::{BacklashOffset, Compensator, Evidence, JointCompensator};
use lostmotion::effects::GapCurve;
use lostmotion::error::Error;
use lostmotion::rewrite::script::{Choices, Task, rewrite};
use lostmotion::rewrite::{Options, Refine};
use lostmotion::robot::Robot;
use lostmotion::robot::frames::Frames;
use robot_programs::script::{Format, Goal, Script, Text};
use std::sync::LazyLock;

/// The robot of a configuration, whose text is part of the target.
pub fn robot(text: &str) -> Robot {
    Robot::parse("robot.yaml", text).expect("a robot file of the repository")
}

pub const KUKA: &str = include_str!("../../configs/kuka-kr120-r2500-pro.yaml");
pub const ABB: &str = include_str!("../../configs/abb-irb1600-6-145.yaml");
pub const FANUC: &str = include_str!("../../configs/fanuc-m10ia.yaml");
pub const MOTOMAN: &str = include_str!("../../configs/motoman-ma2010.yaml");
pub const UR: &str = include_str!("../../configs/universal-robots-ur10.yaml");
pub const GANTRY: &str = include_str!("../../configs/gantry-xyz-ballscrew.yaml");

/// Half gap of every axis, deg or mm.
const HALF_GAP: f64 = 0.02;
/// What may stand between two files of one program: ASCII's record separator, which no program contains.
pub const NEXT_FILE: u8 = 0x1e;

/// Frames and tools that programs name, all at zero, so that Cartesian targets are solved.
static FRAMES: LazyLock<Frames> = LazyLock::new(|| {
    let names = (0..10).map(|k| format!("\"{k}\"")).chain(["\"$BASE\"".into(), "\"$TOOL\"".into()]);
    let entries: String = names.map(|n| format!("  {n}: {{xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}}\n")).collect();
    let text = format!("schema: lostmotion/frames/1\nframes:\n{entries}tools:\n{entries}");
    Frames::parse("frames.yaml", &text).expect("frames of ours")
});

/// The same half gap on every axis: [`HALF_GAP`] times `scale`.
pub fn compensator(robot: &Robot, scale: f64) -> Compensator {
    let joints = robot.axis_joints().enumerate().map(|(axis, joint)| {
        let gap = GapCurve::Constant(HALF_GAP * scale * joint.kind.si_per_user_unit());
        JointCompensator {
            axis,
            backlash: Some(BacklashOffset { positive: gap.clone(), negative: gap }),
            friction: None,
        }
    });
    Compensator {
        robot_name: robot.name.clone(),
        robot_sha256: robot.fingerprint(),
        joints: joints.collect(),
        evidence: Evidence::default(),
    }
}

/// The files of a program: those that are rewritten, then those that are only looked up.
fn texts(format: &dyn Format, bytes: &[u8]) -> Vec<Text> {
    let krl = format.name() == "krl";
    let mut all = bytes.splitn(3, |b| *b == NEXT_FILE).map(<[u8]>::to_vec);
    let mut out = vec![Text::new(if krl { "program.src" } else { "program" }, all.next().unwrap_or_default())];
    if krl {
        out.extend(all.next().map(|b| Text::new("program.dat", b)));
        out.extend(all.next().map(|b| Text::of_context("$config.dat", b)));
    } else {
        out.extend(all.map(|b| Text::of_context("other.mod", b)));
    }
    out
}

/// A mistake of the library: nothing that an input may lead to.
fn is_fault(e: &Error) -> bool {
    match e {
        Error::Internal { .. } => true,
        Error::MendedBy { source, .. } => is_fault(source),
        _ => false,
    }
}

/// Options that differ from input to input, so that all of them meet all inputs: which ones is a matter of the bytes.
fn choices(robot: &Robot, bytes: &[u8]) -> (Options, Choices) {
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
    let bit = |k: u32| hash >> (20 + k) & 1 == 1;
    let mut options = Options::new(robot.dof());
    options.refine = if bit(0) && bit(1) { Refine::Cubic } else { Refine::None };
    options.tcp_speed_m_s = bit(2).then_some(0.25);
    let posture = [0.0, -90.0, 90.0, 0.0, 45.0, 0.0];
    let mut frames = if bit(3) { FRAMES.clone() } else { Frames::default() };
    frames.posture_deg = (bit(3) && robot.dof() == posture.len()).then(|| posture.to_vec());
    let choices = Choices {
        frames,
        solve_within_m: (bit(4) && bit(5)).then_some(1e-4),
        leave_poses: bit(6) && bit(7),
        max_added: (bit(8) && bit(9)).then_some(1),
        exclude_process: bit(10) && bit(11),
        leave_process: bit(12) && bit(13),
        approach_from: if bit(14) && bit(15) { vec![1; robot.dof()] } else { Vec::new() },
        ..Choices::default()
    };
    (options, choices)
}

/// Reads a program and rewrites it. A zero compensator must give the same bytes; with gaps the result must read as it was meant, which
/// `rewrite` checks itself: an internal error is its word for a fault. Returns whether anything was edited.
pub fn rewrite_and_check(format: &dyn Format, robot: &Robot, bytes: &[u8]) -> bool {
    let mut edited = false;
    let (options, choices) = choices(robot, bytes);
    let none = vec![None; robot.dof()];
    let digit: Vec<f64> = robot.axis_joints().map(|j| 1e-3 * j.kind.si_per_user_unit()).collect();
    for scale in [0.0, 1.0] {
        if scale == 0.0 && options.refine != Refine::None {
            // a finer path is another program even without a gap
            continue;
        }
        let compensator = compensator(robot, scale);
        let task = Task {
            robot,
            compensator: &compensator,
            options: &options,
            choices: &choices,
            deadband: &none,
            digit: &digit,
            pose_digit: [1e-7, 1.75e-6],
            listed: 10,
        };
        match rewrite(format, texts(format, bytes), &task) {
            // Cartesian moves become joint moves and targets are approached without a gap, too
            Ok(done) if scale == 0.0 && choices.approach_from.is_empty() && choices.solve_within_m.is_none() => {
                assert!(done.unchanged(), "a zero compensator changes bytes");
            }
            Ok(done) if !done.unchanged() => {
                for (text, original) in done.texts.iter().zip(&done.originals) {
                    assert!(!original.context || text.bytes == original.bytes, "a file that is only looked up changes");
                }
                leads_to_the_same(format, robot, done.originals, done.texts);
                edited = true;
            }
            Ok(_) => {}
            Err(e) => assert!(!is_fault(&e), "{e}"),
        }
    }
    edited
}

/// Every joint target of the program is met again in its order, within what a gap may move it.
fn leads_to_the_same(format: &dyn Format, robot: &Robot, originals: Vec<Text>, texts: Vec<Text>) {
    let read = |texts| format.parse(texts, robot.axes());
    let (Ok(before), Ok(after)) = (read(originals), read(texts)) else { panic!("a result that is not read") };
    let after: Vec<_> = goals(after.script());
    let before = goals(before.script());
    let mut at = 0;
    for (line, want) in before {
        let near = |is: &[(f64, f64)]| {
            let axes = robot.axis_joints().zip(is.iter().zip(&want));
            axes.into_iter().all(|(joint, (is, want))| {
                let gap = HALF_GAP * joint.kind.si_per_user_unit();
                // coupled axes take a share of each other's gap; numbers are rounded to the coarser digit
                let most = 2.5 * gap + is.1.max(want.1);
                is.0.is_nan() || want.0.is_nan() || (is.0 - want.0).abs() <= most
            })
        };
        let Some(found) = after.get(at..).and_then(|rest| rest.iter().position(|(_, q)| near(q))) else {
            panic!("line {line}: a target that the result does not lead to: {want:?}");
        };
        at += found + 1;
    }
}

/// The joint targets of a script's moves: line; value and last digit of each axis, rad or m, NaN where it is not commanded.
fn goals(script: &Script) -> Vec<(u64, Vec<(f64, f64)>)> {
    let of = |t: usize| {
        let values = script.targets.get(t).map(|t| t.values).unwrap_or_default();
        values.iter().map(|v| v.map_or((f64::NAN, 0.0), |v| (v.si, v.digit))).collect()
    };
    let joints = |m: &robot_programs::script::Move| match m.goal {
        Goal::Joints(t) => Some(of(t)),
        _ => None,
    };
    script.moves().filter_map(|(k, m)| Some((script.steps[k].at.line, joints(m)?))).collect()
}
