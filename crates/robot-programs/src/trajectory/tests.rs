//! Every trap of the format.
//!
//! Parts: [`splines`] new points against the plan; [`random`] random messages and edits.

mod random;
mod splines;

use super::*;
use crate::axes::{Axis, JointKind};
use crate::script::harness;
use crate::script::{Edit, NewPoint};
use std::fmt::Write as _;

fn robot() -> Axes {
    let revolute = |name| Axis::new(name, JointKind::Revolute);
    Axes::new("arm", vec![revolute("J1"), revolute("J2"), Axis::new("X", JointKind::Prismatic)])
}

fn parse(text: &str) -> Box<dyn Document> {
    harness::parse(&Ros, text.as_bytes(), &robot()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn refusal(text: &str) -> String {
    harness::refusal(&Ros, text, &robot())
}

/// The text after the edits, which are found in it again.
fn edited(text: &str, edits: &Edits) -> String {
    let out = harness::edited(&Ros, text.as_bytes(), edits, &robot()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    String::from_utf8(out).unwrap()
}

fn point(q: &[f64], share: f64) -> NewPoint {
    NewPoint { q: q.to_vec(), share, t_s: None, clearance_m: 0.01, of_way: false, waits: false }
}

fn put_before(q: &[f64], share: f64) -> Edit {
    Edit { before: vec![point(q, share)], ..Edit::default() }
}

fn before(step: usize, q: &[f64], share: f64) -> Edits {
    Edits { steps: [(step, put_before(q, share))].into(), digit: vec![1e-5; 3], ..Edits::default() }
}

fn goal(step: usize, q: &[f64]) -> Edits {
    let edit = Edit { goal: Some(q.to_vec()), ..Edit::default() };
    Edits { steps: [(step, edit)].into(), digit: vec![1e-5; 3], ..Edits::default() }
}

const BLOCK: &str = "header:
  frame_id: ''   # base
joint_names: [j2, J1, gripper]
points:
- positions:
  - 0.5
  - 1.0
  - 0.1
  velocities: [0.0, 0.0, 0.0]
  time_from_start:
    sec: 1
    nanosec: 0
# to the part
- positions:
  - 1.5   # high
  - 1.0
  - 0.3
  velocities: [0.0, 0.0, 0.0]
  effort: []
  time_from_start:
    sec: 3
    nanosec: 0
---
";

#[test]
fn joints_are_found_by_name_in_any_order_and_case_and_missing_ones_are_not_commanded() {
    let d = parse(BLOCK);
    let s = d.script();
    let first: Vec<_> = s.targets.get(0).unwrap().values.iter().map(|v| v.map(|v| v.si)).collect();
    assert_eq!(first, [Some(1.0), Some(0.5), None]);
    assert!(s.notes.iter().any(|n| n.text.contains("gripper")) && s.notes.iter().any(|n| n.text.ends_with(": X")));
    assert!(matches!(s.steps[0].kind, StepKind::Break(Break::Start)));
    let StepKind::Move(m) = &s.steps[2].kind else { panic!() };
    assert_eq!((m.speed, m.blend_m, m.path), (Speed::Seconds(2.0), Some(0.0), PathKind::Joint));
}

#[test]
fn a_goal_changes_in_place_and_nothing_else_does() {
    let out = edited(BLOCK, &goal(2, &[1.0, 1.52345, 9.0]));
    assert_eq!(out, BLOCK.replace("- 1.5   # high", "- 1.52345   # high"));
}

#[test]
fn a_new_point_is_a_whole_item_behind_the_one_before_and_comments_stay_with_theirs() {
    // 3 x^2 - 2 x^3 = 0.15625 at x = 0.25: 1.5 s; there 6 x (1 - x) / 2 s = 0.5625 of the way a second
    let out = edited(BLOCK, &before(2, &[1.0, 0.65625, 0.0], 0.15625));
    let new = "- positions:
  - 0.65625
  - 1.00000
  - 0.13125
  velocities: [0.5625, 0.0, 0.1125]
  effort: []
  time_from_start:
    sec: 1
    nanosec: 500000000
# to the part
";
    assert_eq!(out, BLOCK.replace("# to the part\n", new));
}

#[test]
fn line_endings_of_new_lines_are_those_of_the_file() {
    let crlf = BLOCK.replace('\n', "\r\n");
    let out = edited(&crlf, &before(2, &[1.0, 0.65625, 0.0], 0.15625));
    assert_eq!(out.matches('\n').count(), out.matches("\r\n").count());
    assert!(out.len() > crlf.len());
}

#[test]
fn flow_style_and_json_take_new_points_in_their_own_way() {
    let flow = "{joint_names: [J1, J2, X], points: [{positions: [0, 0, 0], time_from_start: {secs: 0, nsecs: 0}}, \
                {positions: [1, 2, 0.5], time_from_start: {secs: 2}}]}";
    let out = edited(flow, &before(2, &[0.26, 0.5, 0.125], 0.25));
    let new = "{positions: [0.26000, 0.50000, 0.12500], time_from_start: {secs: 0, nsecs: 500000000}}, {positions: [1,";
    assert_eq!(out, flow.replace("{positions: [1,", new));
    // times as a list, and whole seconds with a point
    for (zero, two, between) in [
        ("[0, 0]", "[2,0]", "[0,500000000]"),
        ("{secs: 0.0, nsecs: 0}", "{secs: 2.0, nsecs: 0}", "{secs: 0.0, nsecs: 500000000}"),
    ] {
        let times = |text: &str| text.replace("{secs: 0, nsecs: 0}", zero).replace("{secs: 2}", two);
        let out = edited(&times(flow), &before(2, &[0.26, 0.5, 0.125], 0.25));
        let new = new.replace("{secs: 0, nsecs: 500000000}", between);
        assert_eq!(out, times(flow).replace("{positions: [1,", &new));
    }

    let json = "{\n\t\"joint_names\": [\"J1\"],\n\t\"points\": [\n\t\t{\n\t\t\t\"positions\": [0.0],\n\t\t\t\"time_from_start\": 0.0\n\t\t},\n\t\t{\n\t\t\t\"positions\": [2.0],\n\t\t\t\"time_from_start\": 1.0\n\t\t}\n\t]\n}\n";
    let out = edited(json, &before(2, &[0.5, 0.0, 0.0], 0.25));
    let new = "\t\t},\n\t\t{\n\t\t\t\"positions\": [0.50000],\n\t\t\t\"time_from_start\": 0.25\n\t\t},\n\t\t{\n\t\t\t\"positions\": [2.0]";
    assert_eq!(out, json.replace("\t\t},\n\t\t{\n\t\t\t\"positions\": [2.0]", new));
    assert!(serde_json::from_str::<serde_json::Value>(&out).is_ok());
}

#[test]
fn comments_between_brackets_stay_where_they_are() {
    let flow = "joint_names: [J1]\npoints: [\n  {positions: [0.0], time_from_start: 0.0},   # start, [\n  # lostmotion: off\n  {positions: [1.0],   # x\n   # y\n   time_from_start: 1.0},\n]\n";
    let out = edited(flow, &before(3, &[0.5, 0.0, 0.0], 0.5));
    let new = "  {positions: [0.50000],\n   time_from_start: 0.5},\n";
    assert_eq!(out, flow.replace("lostmotion: off\n", &format!("lostmotion: off\n{new}")));
    let plain = flow.replace("# lostmotion: off", "# higher, then");
    let out = edited(&plain, &before(2, &[0.5, 0.0, 0.0], 0.5));
    assert_eq!(out, plain.replace("# start, [\n", &format!("# start, [\n{new}")));
}

#[test]
fn other_joints_keep_their_own_motion_when_a_point_is_put_in() {
    let text = "joint_names: [J1, tool]\npoints:\n- {positions: [0.0, 0.2], velocities: [0.0, 0.3], accelerations: [0.0, 0.4], time_from_start: 0.0}\n- {positions: [1.0, 0.9], velocities: [0.0, -0.1], accelerations: [0.0, 0.2], time_from_start: 2.0}\n";
    let out = edited(text, &before(2, &[0.5, 0.0, 0.0], 0.5));
    let d = parse(&out);
    let StepKind::Move(_) = d.script().steps[2].kind else { panic!() };
    let all = spline::at(
        spline::Order::Quintic,
        spline::State { p: 0.2, v: 0.3, a: 0.4 },
        spline::State { p: 0.9, v: -0.1, a: 0.2 },
        2.0,
        0.5,
    );
    let line = out.lines().nth(3).unwrap();
    let list = |key: &str| -> f64 {
        let at = line.find(key).unwrap();
        line[at..].split_once('[').unwrap().1.split_once(']').unwrap().0.split(", ").nth(1).unwrap().parse().unwrap()
    };
    assert!((list("positions") - all.p).abs() < 1e-8 && (list("velocities") - all.v).abs() < 1e-7, "{line}");
    assert!((list("accelerations") - all.a).abs() < 1e-6, "{line}");
    assert!(line.contains("time_from_start: 1.0}"), "{line}");
}

#[test]
fn the_points_of_a_plan_keep_their_velocities_whatever_is_added_to_their_positions() {
    let text = "joint_names: [J1]\npoints:\n- {positions: [0.0], velocities: [1.0], time_from_start: 0.0}\n- {positions: [1.0], velocities: [1.0], time_from_start: 1.0}\n- {positions: [2.0], velocities: [1.0], time_from_start: 2.0}\n- {positions: [3.0], velocities: [1.0], time_from_start: 3.0}\n- {positions: [4.0], velocities: [0.0], time_from_start: 4.0}\n";
    let mut edits = goal(3, &[2.1, 0.0, 0.0]);
    for (step, q) in [(4, 3.2), (5, 4.2)] {
        edits.steps.insert(step, Edit { goal: Some(vec![q, 0.0, 0.0]), ..Edit::default() });
    }
    let out = edited(text, &edits);
    let want = text
        .replace("[2.0], velocities", "[2.10000], velocities")
        .replace("[3.0]", "[3.20000]")
        .replace("[4.0]", "[4.20000]");
    assert_eq!(out, want);
}

#[test]
fn a_turn_stands_where_the_velocity_of_the_spline_is_zero() {
    // p = x - x^2 over 2 s: it turns in the middle, at 0.25; J2 goes evenly
    let text = "joint_names: [J1, J2, X]\npoints:\n- {positions: [0.0, 0.0, 0.0], velocities: [0.5, 0.5, 0.0], time_from_start: 0.0}\n- {positions: [0.0, 1.0, 0.0], velocities: [-0.5, 0.5, 0.0], time_from_start: 2.0}\n";
    let d = parse(text);
    let StepKind::Move(m) = &d.script().steps[2].kind else { panic!() };
    assert_eq!(m.way.len(), 1);
    let way = &m.way[0];
    assert!(
        (way.share - 0.5).abs() < 1e-9 && (way.q[0] - 0.25).abs() < 1e-9 && (way.q[1] - 0.5).abs() < 1e-9,
        "{way:?}"
    );
    assert!(d.on_way(2, 0.5).unwrap().iter().zip(&way.q).all(|(a, b)| (a - b).abs() < 1e-9));
    // a point at the turn, and one after it with an offset: both are at their time, and J2 keeps its velocity there
    let mut after = d.on_way(2, 0.6).unwrap();
    after[0] -= 0.01;
    let points = vec![NewPoint { of_way: true, ..point(&way.q, 0.5) }, point(&after, 0.6)];
    let mut edits = Edits {
        steps: [(2, Edit { before: points, ..Edit::default() })].into(),
        digit: vec![1e-9; 3],
        ..Edits::default()
    };
    edits.steps.change(2, |e| e.goal = Some(vec![-0.01, 1.0, 0.0]));
    let out = edited(text, &edits);
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines[3].contains("time_from_start: 1.0}") && lines[3].contains(", 0.5, 0.0], time"), "{out}");
    assert!(lines[4].contains("time_from_start: 1.2}") && lines[4].contains(", 0.5, 0.0]"), "{out}");
    assert!(lines[5].contains("velocities: [-0.5, 0.5, 0.0]"), "{out}");
}

#[test]
fn the_robot_stands_at_a_first_point_at_time_0() {
    let text = |t: f64| {
        format!(
            "joint_names: [J1]\npoints:\n- {{positions: [0.0], time_from_start: {t}}}\n- {{positions: [1.0], time_from_start: 2.0}}\n"
        )
    };
    let speeds = |t: f64| {
        let d = parse(&text(t));
        d.script().moves().map(|(_, m)| m.speed).collect::<Vec<_>>()
    };
    assert_eq!(speeds(0.0), [Speed::Seconds(0.0), Speed::Seconds(2.0)]);
    assert_eq!(speeds(0.5), [Speed::Seconds(0.5), Speed::Seconds(1.5)]);
}

#[test]
fn several_messages_in_a_file_are_runs_of_their_own() {
    let two = format!(
        "{BLOCK}trajectory:\n  joint_names: [x]\n  points: [{{positions: [0.5], time_from_start: 0.5}}]\ngoal_tolerance: []\n---\n"
    );
    let d = parse(&two);
    let starts = d.script().steps.iter().filter(|s| matches!(s.kind, StepKind::Break(_))).count();
    assert_eq!((starts, d.script().moves().count()), (2, 3));
    let moveit = "trajectory:\n- joint_trajectory:\n    joint_names: [J1]\n    points:\n    - {positions: [1.0], time_from_start: {sec: 0, nanosec: 5}}\n  multi_dof_joint_trajectory:\n    joint_names: []\n    points: []\n";
    let d = parse(moveit);
    assert_eq!((d.script().moves().count(), d.script().notes.len()), (1, 1));
}

#[test]
fn a_point_that_a_copy_cannot_stand_for_is_closed() {
    for (text, why) in [
        ("- {positions: [0.0], time_from_start: 0}\n- {positions: [1.0], io: 3, time_from_start: 1}", "`io`"),
        (
            "- {positions: [0.0], time_from_start: 0}\n- {positions: [1.0], velocities: [0], time_from_start: 1}",
            "one end",
        ),
        (
            "- {positions: [], velocities: [0], time_from_start: 0}\n- {positions: [1.0], velocities: [0], time_from_start: 1}",
            "without positions",
        ),
    ] {
        let text = format!("joint_names: [J1]\npoints:\n{text}\n");
        let d = parse(&text);
        let StepKind::Move(m) = &d.script().steps[2].kind else { panic!() };
        assert!(m.closed.as_ref().is_some_and(|c| c.to_string().contains(why)), "{:?}", m.closed);
        assert!(d.patches(&before(2, &[0.5, 0.0, 0.0], 0.5)).is_err());
        assert!(d.patches(&before(1, &[0.5, 0.0, 0.0], 0.5)).is_err());
    }
}

#[test]
fn bad_messages_are_refused_with_line_and_column() {
    let mut wrong = Vec::new();
    let one = |point: &str| format!("joint_names: [J1, J2]\npoints:\n- {point}\n");
    for (text, place, words) in [
        (one("{positions: [1.0], time_from_start: 0}"), "3:15", "1 positions; expected 2"),
        (one("{positions: [1, 2], velocities: [0], time_from_start: 0}"), "3:35", "1 velocities"),
        (one("{positions: [1, nan], time_from_start: 0}"), "3:19", "`nan`"),
        (one("{positions: [1, 010], time_from_start: 0}"), "3:19", "`010`"),
        (one("{positions: [1, '2'], time_from_start: 0}"), "3:19", "`2`"),
        (one("{positions: [1, !!float 2], time_from_start: 0}"), "3:19", "a tag"),
        (one("{positions: &a [1, 2], time_from_start: 0}"), "3:15", "an anchor"),
        (one("{positions: [1, 2]}"), "3:3", "time_from_start"),
        (one("{positions: [1, 2], time_from_start: {sec: 1.5}}"), "3:46", "whole number"),
        (one("{positions: [1, 2], time_from_start: {sec: 1, nanosec: 1000000000}}"), "3:58", "whole number"),
        (one("{positions: [1, 2], time_from_start: {min: 1}}"), "3:41", "`min`"),
        (one("{positions: [1, 2], time_from_start: 1}\n- {positions: [1, 2], time_from_start: 1}"), "4:40", "rise"),
        (one("{positions: [1, 2], positions: [1, 2], time_from_start: 1}"), "3:23", "second time"),
        (one("{positions: [1, 2], time_from_start: 1}\n- '...'"), "4:3", "--full-length"),
        ("joint_names: [A, B]\npoints: []\n".into(), "1:14", "of the robot: J1, J2, X"),
        ("joint_names: [J1, j1]\npoints: []\n".into(), "1:19", "second time"),
        ("p: &p [1]\njoint_names: [J1]\npoints:\n- {positions: *p, time_from_start: 1}\n".into(), "4:15", "alias"),
        ("a: &t\n  joint_names: [J1]\n  points: []\nb: *t\n".into(), "1:4", "alias repeats"),
        ("a: 1\n".into(), "1:1", "no trajectory"),
        ("a: [1\n".into(), "2:1", "no YAML"),
    ] {
        let message = refusal(&text);
        if !(message.starts_with(&format!("job:{place}: ")) && message.contains(words)) {
            wrong.push(format!("{message}\nnot at {place}, {words}\n{text}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn only_messages_are_recognised() {
    for yes in [BLOCK, "{\"points\": [], \"joint_names\" : []}", "---\njoint_names:\n- a\npoints:\n- positions: [1]\n"]
    {
        assert!(Ros.recognises(yes.as_bytes()), "{yes}");
    }
    for no in [
        "name: arm\njoints:\n  - {name: J1, kind: revolute}\n",
        "# joint_names: and points:\na: 1\n",
        "{\"points\": 12, \"joints\": []}",
        "joint_names: [a]\nwaypoints: []\n",
        "",
    ] {
        assert!(!Ros.recognises(no.as_bytes()), "{no}");
    }
}

#[test]
fn a_time_too_close_for_a_further_point_is_refused() {
    let text = "joint_names: [J1]\npoints:\n- {positions: [0.0], time_from_start: {sec: 0, nanosec: 1}}\n- {positions: [1.0], time_from_start: {sec: 0, nanosec: 2}}\n";
    let e = parse(text).patches(&before(2, &[0.5, 0.0, 0.0], 0.5)).unwrap_err();
    assert!(e.to_string().contains("job:4: there is no time"), "{e}");
    assert!(matches!(e, crate::Error::Refused(_)));
}

#[test]
fn ten_megabytes_pass_in_seconds() {
    let mut text = String::from("joint_names: [J1, J2, X]\npoints:\n");
    let mut k = 0;
    while text.len() < 10_000_000 {
        let _ =
            writeln!(text, "- positions: [{k}.25, 0.5, 0.125]   # {k}\n  time_from_start: {{sec: {k}, nanosec: 5}}");
        k += 1;
    }
    let started = std::time::Instant::now();
    let d = parse(&text);
    let edits =
        Edits { steps: (2..k).map(|s| (s, put_before(&[s as f64, 0.5, 0.0], 0.5))).collect(), ..Edits::default() };
    let patches = d.patches(&edits).unwrap();
    assert_eq!(patches.len(), k - 2);
    assert!(started.elapsed().as_secs() < 60, "{:?}", started.elapsed());
}

/// To YAML the key after the carriage return belongs to the message; a copy of the point's last line would have put it among the points.
#[test]
fn a_carriage_return_alone_among_line_feeds_is_refused() {
    let of = |end: &str| {
        format!(
            "joint_names: [J1, J2]\npoints:\n- positions: [0.0, 0.0]\n  time_from_start: {{sec: 0}}\n\
             - positions: [0.1, 0.1]\n  time_from_start:\n    sec: 1{end}stamp: 5\n"
        )
    };
    let read =
        |text: &str| Ros.parse(vec![Text::new("t.yaml", text.into())], &robot()).map(|d| d.script().moves().count());
    assert_eq!(read(&of("\n")).unwrap(), 2);
    assert_eq!(read(&of("\n").replace('\n', "\r\n")).unwrap(), 2);
    let said = read(&of("\r")).unwrap_err().to_string();
    assert!(said.contains("t.yaml:7") && said.contains("a carriage return without a line feed"), "{said}");
    let json = "{\"joint_names\": [\"J1\"],\n\"points\": [{\"positions\": [0.5],\r\"time_from_start\": 1.0}]}\n";
    assert_eq!(read(json).unwrap(), 1, "in JSON it is a blank");
}
