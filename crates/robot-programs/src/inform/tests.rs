//! What a job says as steps and targets, what of it is refused, and corners of new points.
//!
//! Parts: [`positions`] entries of the list; [`groups`] stations, rails and second groups; [`arcs`] circular steps; [`flow`] what a job does
//! between two moves; [`order`] numbers of C lines by joints; [`left_alone`] jobs and moves that stay; [`random`] random jobs.

mod arcs;
mod flow;
mod groups;
mod left_alone;
mod order;
mod positions;
mod random;

use super::Inform;
use crate::axes::Axes;
use crate::error::Error;
use crate::fixtures;
use crate::script::harness::{self, count, edited, generator, moves, random_edits, refusal, script_of, values};
use crate::script::pose::Frame;
use crate::script::{Break, Edit, Edits, Format, Goal, Move, NewPoint, PathKind, Script, Speed, StepKind};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

fn robot() -> Axes {
    fixtures::ma2010(None)
}

/// A job with a list and instructions, lines ended by CRLF.
fn job(npos: &str, list: &str, instructions: &str) -> String {
    let text = format!(
        "/JOB\n//NAME TEST\n//POS\n///NPOS {npos}\n{list}\n//INST\n///DATE 2024/01/01 10:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n{instructions}\nEND\n"
    );
    text.replace('\n', "\r\n")
}

const PULSES: &str = "///TOOL 0\n///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1000,-2000,300,0,-500,622";

fn two(instructions: &str) -> String {
    job("2,0,0,0,0,0", PULSES, instructions)
}

/// Step, goal and new points in pulses.
type Wish = (usize, Option<[f64; 6]>, Vec<[f64; 6]>);

/// Goals and new points as joint values.
fn edit(robot: &Axes, steps: &[Wish]) -> Edits {
    let si = |p: &[f64; 6]| p.iter().zip(robot.axis_joints()).map(|(v, j)| v / j.pulses.unwrap()).collect::<Vec<f64>>();
    let mut edits = Edits { digit: vec![1e-7; 6], ..Edits::default() };
    for (k, goal, before) in steps {
        let before = before.iter().map(|p| NewPoint {
            q: si(p),
            share: 0.5,
            t_s: None,
            clearance_m: 0.001,
            of_way: false,
            waits: false,
        });
        let edit = Edit { before: before.collect(), goal: goal.as_ref().map(si), ..Edit::default() };
        edits.steps.insert(*k, edit);
    }
    edits
}

fn written(text: &str, steps: &[Wish]) -> String {
    let robot = robot();
    String::from_utf8(edited(&Inform, text.as_bytes(), &edit(&robot, steps), &robot).unwrap()).unwrap()
}

#[test]
fn pulses_become_radians_by_the_robot_file() {
    let robot = robot();
    let script = script_of(&Inform, &two("MOVJ C00000 VJ=25.00\nMOVL C00001 V=50.0 PL=0"), &robot);
    let moves = moves(&script);
    let q = values(&script, moves[1].0);
    assert!((q[1].to_degrees() + 2000.0 / 1341.4).abs() < 1e-12 && (q[5].to_degrees() - 1.0).abs() < 1e-12);
    assert_eq!(
        (moves[1].1.path, moves[1].1.speed, moves[1].1.blend_m),
        (PathKind::Linear, Speed::Tcp(0.05), Some(0.0))
    );
    assert_eq!((moves[0].1.speed, moves[0].1.blend_m), (Speed::Share(0.25), None));
}

#[test]
fn angle_jobs_keep_four_decimals() {
    let robot = robot();
    let list = "///POSTYPE ANGLE\n///ANGLE\nC00000=10.0000,0.0000,0.0000,0.0000,0.0000,0.0000";
    let text = job("1,0,0,0,0,0", list, "MOVJ C00000 VJ=25.00");
    let mut edits = Edits { digit: vec![1e-9; 6], ..Edits::default() };
    let goal = [10.12345f64.to_radians(), 0.0, 0.0, 0.0, 0.0, 0.0].to_vec();
    edits.steps.insert(1, Edit { goal: Some(goal), ..Edit::default() });
    let out = String::from_utf8(edited(&Inform, text.as_bytes(), &edits, &robot).unwrap()).unwrap();
    assert!(out.contains("C00000=10.1235,0.0000,") || out.contains("C00000=10.1234,0.0000,"), "{out}");
    let value = script_of(&Inform, &text, &robot).targets.get(0).unwrap().values.get(0).unwrap();
    assert!((value.finest.to_degrees() - 1e-4).abs() < 1e-15);
}

#[test]
fn without_pulses_the_joint_and_the_key_are_named() {
    let robot = fixtures::ma2010(Some("T"));
    let why = refusal(&Inform, &two("MOVJ C00001 VJ=25.00"), &robot);
    assert!(why.contains("pulses_per_deg") && why.contains("joint T") && why.contains(":9:"), "{why}");
    // a job that makes no use of pulses is read
    script_of(&Inform, &two("DOUT OT#(1) ON"), &robot);
}

#[test]
fn counts_that_are_not_the_real_ones_are_refused() {
    let text = two("MOVJ C00000 VJ=25.00").replace("NPOS 2", "NPOS 3");
    assert!(refusal(&Inform, &text, &robot()).contains("job:4:9"), "{}", refusal(&Inform, &text, &robot()));
}

#[test]
fn broken_jobs_are_refused_with_their_place() {
    let robot = robot();
    let good = two("MOVJ C00000 VJ=25.00");
    for (from, to, place) in [
        ("END\r\n", "", "job:16:1"),
        ("C00001=1000", "C00000=1000", "job:9:1"),
        ("1000,-2000", "1000,-20x0", "job:9:13"),
        ("1000,-2000", "1000,-20.5", "job:9:13"),
        ("MOVJ C00000", "MOVJ C00009", "job:15:6"),
        ("/JOB", "JOB", "job:1:1"),
        ("//INST\r\n", "", "job:13:1"),
        ("C00000=0,0,0,0,0,0", "C00000=0,0,0,0,0", "job:8:1"),
        ("END\r\n", "END\r\n/JOB\r\n", "job:17:1"),
    ] {
        let why = refusal(&Inform, &good.replacen(from, to, 1), &robot);
        assert!(why.starts_with(place), "{from} -> {to}: {why}");
    }
}

#[test]
fn cartesian_relative_and_untyped_positions_are_no_joint_targets() {
    let list = "C00000=1,1,1,1,1,1\n///POSTYPE ROBOT\n///RECTAN\nC00001=1000.000,0.000,500.000,180.0000,0.0000,0.0000\n\
                ///USER 2\n///POSTYPE USER\n///RECTAN\nC00002=1.000,0.000,0.000,0.0000,0.0000,0.0000";
    let text =
        job("3,0,0,0,0,0", list, "MOVJ C00000 VJ=5.00\nMOVL C00001 V=5.0\nMOVL C00002 V=5.0\nIMOV P001 V=5.0 RF");
    let script = script_of(&Inform, &text, &robot());
    let goals: Vec<Goal> = moves(&script).into_iter().map(|m| m.1.goal).collect();
    assert!(matches!(&goals[0], Goal::Opaque(why) if why.to_string().contains("POSTYPE")));
    assert!(matches!(&goals[1], Goal::Pose(p) if p.frame == Frame::Null && (p.position_m.x - 1.0).abs() < 1e-15));
    assert!(matches!(&goals[2], Goal::Pose(p) if p.frame == Frame::Named("2".into())));
    assert!(matches!(&goals[3], Goal::Opaque(why) if why.to_string().contains("relative")));
}

#[test]
fn labels_calls_shifts_timers_and_processes_are_steps() {
    let text = two(
        "*A\n'lostmotion: off\nTIMER T=0.50\nTIMER T=I000\nARCON ASF#(1)\nARCOF\nCALL JOB:X IF IN#(1)=ON\nJUMP *A\n\
                    SFTON P000 BF\nMOVJ C00000 VJ=5.00\nSFTOF\nWHILE B000=1\nENDWHILE\nIFTHENEXP B000=1\nENDIF\nDOUT OT#(2) ON\n'MOVJ C00001\nMACRO1 MJ#(5)",
    );
    let script = script_of(&Inform, &text, &robot());
    let kinds: Vec<String> = script
        .steps
        .iter()
        .map(|s| match &s.kind {
            StepKind::Move(m) => {
                if matches!(m.goal, Goal::Opaque(_)) {
                    "opaque".into()
                } else {
                    "move".into()
                }
            }
            StepKind::Dwell(s) => format!("{s:?}"),
            StepKind::Break(b) => format!("{b:?}"),
            StepKind::Process(p) => format!("{p}"),
            StepKind::Sets(name) => format!("sets {name}"),
            StepKind::Pragma(p) => format!("pragma {p}"),
        })
        .collect();
    assert_eq!(
        kinds,
        [
            "Start",
            "Jump",
            "pragma false",
            "Some(0.5)",
            "None",
            "true",
            "false",
            "Call",
            "Jump",
            "Frame",
            "opaque",
            "Frame",
            // a loop and a branch in which nothing moves end nothing
            "Call"
        ]
    );
    assert!(matches!(script.steps[0].kind, StepKind::Break(Break::Start)));
}

#[test]
fn corners_are_narrowed_and_new_points_get_the_finest_that_fits() {
    let robot = robot();
    let text = two("MOVJ C00000 VJ=25.00 PL=4 ACC=50 DEC=50\nMOVL C00001 V=50.0 CR=20.0");
    let mut edits = edit(&robot, &[(1, None, vec![[1.0; 6]]), (2, None, vec![[1.0; 6]])]);
    edits.steps.change(1, |e| e.before[0].clearance_m = 0.02);
    edits.steps.change(1, |e| e.blend_at_most_m = Some(0.03));
    edits.steps.change(2, |e| e.before[0].clearance_m = 0.00456);
    edits.steps.change(2, |e| e.blend_at_most_m = Some(0.0004));
    let out = String::from_utf8(edited(&Inform, text.as_bytes(), &edits, &robot).unwrap()).unwrap();
    assert!(
        out.contains("MOVJ C00002 VJ=25.00 PL=1 ACC=50 DEC=50\r\nMOVJ C00000 VJ=25.00 PL=2 ACC=50 DEC=50\r\n"),
        "{out}"
    );
    assert!(out.contains("MOVL C00003 V=50.0 CR=4.5\r\nMOVL C00001 V=50.0 PL=0\r\n"), "{out}");
}

#[test]
fn latin_bytes_and_old_short_names_pass() {
    let robot = robot();
    let mut text = b"/JOB\r\n//NAME \xc4\r\n//POS\r\n///NPOS 1,0,0,0,0,0\r\n///POSTYPE PULSE\r\n///PULSE\r\nC000= 1, 2, 3, 4, 5, 6  \r\n//INST\r\nNOP\r\n' \xe9t\xe9\r\nMOVJ C000 VJ=5\r\nEND\r\n".to_vec();
    let out =
        edited(&Inform, &text, &edit(&robot, &[(1, Some([1.0, 2.0, 3.0, 4.0, 5.0, 7.0]), vec![[0.0; 6]])]), &robot)
            .unwrap();
    let at = text.windows(3).position(|w| w == b", 6").unwrap();
    text[at + 2] = b'7';
    let head = out.windows(6).position(|w| w == b"C000= ").unwrap();
    assert_eq!(out[head..head + 24], text[head..head + 24]);
    assert!(String::from_utf8_lossy(&out).contains("C001= 0, 0, 0, 0, 0, 0"), "{}", String::from_utf8_lossy(&out));
}

#[test]
fn a_section_of_arguments_between_list_and_instructions_is_passed_over() {
    let text = two("MOVJ C00000 VJ=25.00")
        .replace("//INST", "//ARGINFO\r\n///ARGTYPE B,I,,,,,,\r\n///COMMENT\r\nSide\r\nC00009=count\r\n//INST");
    assert_eq!(moves(&script_of(&Inform, &text, &robot())).len(), 1);
    // lines without such a section are none of a job
    let text = two("MOVJ C00000 VJ=25.00").replace("//NAME TEST", "//NAME TEST\r\nSide");
    assert!(refusal(&Inform, &text, &robot()).contains(":3:"));
}

#[test]
fn lines_that_end_in_lone_carriage_returns_are_read_and_keep_them() {
    let text = two("MOVJ C00000 VJ=25.00");
    let old = text.replace("\r\n", "\r");
    let script = |text: &str| script_of(&Inform, text, &robot()).moves().count();
    assert_eq!(script(&old), script(&text));
    assert_eq!(crate::script::Text::new("j", old.into_bytes()).ending(7), b"\r");
}

#[test]
fn a_straight_move_is_not_stopped_on_its_way_and_ends_as_it_did() {
    let out = |instructions: &str, clearance_m: f64| {
        let (robot, text) = (robot(), two(instructions));
        let mut edits = edit(&robot, &[(2, None, vec![[1.0; 6]])]);
        edits.steps.change(2, |e| e.before[0].clearance_m = clearance_m);
        String::from_utf8(edited(&Inform, text.as_bytes(), &edits, &robot).unwrap()).unwrap()
    };
    let straight = "MOVJ C00000 VJ=25.00 PL=0\nMOVL C00001 V=50.0 PL=0";
    assert!(out(straight, 0.02).contains("MOVL C00002 V=50.0 PL=1\r\nMOVL C00001 V=50.0 PL=0\r\n"));
    // a controller that knows radii, and one of which that is not known
    let radii = format!("{straight}\nMOVL C00000 V=50.0 CR=20.0");
    assert!(out(&radii, 0.00456).contains("MOVL C00002 V=50.0 CR=4.5\r\n"));
    assert!(out(&radii, 0.0004).contains("MOVL C00002 V=50.0 PL=0\r\n"));
    assert!(out(straight, 0.00456).contains("MOVL C00002 V=50.0 PL=0\r\n"));
    // a joint move that stops exactly has copies that do
    let joint = "MOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00 PL=0";
    assert!(out(joint, 0.02).contains("MOVJ C00002 VJ=25.00 PL=0\r\n"));
}

#[test]
fn a_move_without_a_corner_gets_none_and_neither_does_its_new_point() {
    let robot = robot();
    for instructions in ["MOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00", "MOVL C00000 V=6.3\nMOVL C00001 V=6.3"] {
        let text = two(instructions);
        let mut edits = edit(&robot, &[(1, None, vec![]), (2, None, vec![[1.0; 6]])]);
        // half a metre of room: the factory's largest level would fit
        edits.steps.change(1, |e| e.blend_at_most_m = Some(0.6));
        edits.steps.change(2, |e| e.before[0].clearance_m = 0.6);
        edits.steps.change(2, |e| e.blend_at_most_m = Some(0.6));
        let out = String::from_utf8(edited(&Inform, text.as_bytes(), &edits, &robot).unwrap()).unwrap();
        assert!(!out.contains("PL=") && !out.contains("CR="), "{out}");
        let word = &instructions[instructions.find('C').unwrap() + 6..instructions.find('\n').unwrap()];
        assert!(out.contains(&format!(" C00002{word}\r\n")), "{out}");
    }
}

/// Lines that are like the move before them but for the number of their position are not read again; a comment on each makes them others.
#[test]
fn moves_that_differ_in_their_position_alone_are_read_as_each_of_them_is() {
    let list = "///TOOL 0\n///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1000,-2000,300,0,-500,622\nC00002=+5,1,2,3,4,5\nc003=7,0,0,0,0,0";
    let lines = [
        "MOVJ C00000 VJ=25.00 PL=1",
        "MOVJ C00001 VJ=25.00 PL=1",
        "MOVJ C00002 VJ=25.00 PL=1",
        "MOVJ C003 VJ=25.00 PL=1",
        "MOVJ C00002 VJ=25.00 PL=1",
        "WVON WEV#(1)",
        "MOVJ C00001 VJ=25.00 PL=1",
        "WVOF",
        "MOVJ C00002 VJ=25.00 PL=1",
        "TIMER T=0.50",
        "MOVL C00000 V=50.0",
        "MOVL C00001 V=50.0",
        "MOVL C00001 V=50.0 NWAIT UNTIL IN#(1)=ON",
        "MOVL C00002 V=50.0 NWAIT UNTIL IN#(1)=ON",
        "MOVJ C00001 VJ=25.00 +MOVJ BC1",
        "MOVJ C00002 VJ=25.00 +MOVJ BC1",
    ];
    let other: Vec<String> = lines.iter().enumerate().map(|(n, line)| format!("{line} '{n}")).collect();
    let [alike, each] = [lines.join("\n"), other.join("\n")]
        .map(|instructions| script_of(&Inform, &job("4,0,0,0,0,0", list, &instructions), &robot()));
    assert_eq!(format!("{:?}", alike.steps), format!("{:?}", each.steps));
    let targets = |script: &Script| script.targets.iter().map(|t| format!("{t:?}")).collect::<Vec<_>>();
    assert_eq!(targets(&alike), targets(&each));
    assert_eq!((alike.moves().count(), alike.targets.len()), (13, 4));
    // a position that is not in the list is named by its line all the same
    let missing = job("4,0,0,0,0,0", list, &[lines[0], lines[1], "MOVJ C00009 VJ=25.00 PL=1"].join("\n"));
    assert!(refusal(&Inform, &missing, &robot()).contains("C00009, which is not in the list"));
}
