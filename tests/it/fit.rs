//! `fit`: from gaps documents to a compensator.

use crate::path_bench::{file, kuka};
use crate::support::{self, WorkFolder};
use lostmotion::compensator::{Compensator, FrictionShape};
use lostmotion::effects::{Decay, GapCurve};
use lostmotion::fit::{Form, fit};
use lostmotion::gaps::Gaps;
use lostmotion::robot::Robot;

fn document(robot: &Robot, rest: &str) -> Gaps {
    let head = format!("schema: lostmotion/gaps/1\nrobot: {{name: k, sha256: {}}}\n", robot.fingerprint());
    Gaps::parse("gaps.yaml", &(head + rest), robot).unwrap()
}

const PATH: &str = "logs: [{name: circle.csv, sha256: aa}]
tcp_speed_mm_s: 1.5
joints:
  - {joint: A1, half_gap_deg: 0.0028, ci95: [0.00276, 0.00284], significant: true, stiction: {spike_deg: 0.0034, ci95: [0.0030, 0.0038], decay_s: 5.2, decay_ci95: [4.8, 5.6]}}
  - {joint: A2, half_gap_deg: 0.0030, ci95: [0.0029, 0.0031], significant: true, stiction: null, stiction_p_value: 0.4}
  - {joint: A3, half_gap_deg: 0.0022, ci95: [0.0021, 0.0023], significant: true, stiction: {spike_deg: 0.0010, ci95: [0.0002, 0.0050], decay_s: 5.2, decay_ci95: [1, 20]}}
";
const STATIC: &str = "logs: [{name: static.csv, sha256: bb}]
points:
  - {joint: A2, at_deg: -100, half_gap_deg: 0.0035, ci95: [0.0034, 0.0036], cycles: 4}
  - {joint: A2, at_deg: -50, half_gap_deg: 0.0022, ci95: [0.0021, 0.0023], cycles: 4}
  - {joint: A2, at_deg: 0, half_gap_deg: 0.0001, ci95: [-0.0002, 0.0004], cycles: 4}
joints:
  - {joint: A1, half_gap_deg: 0.0029, ci95: [0.0027, 0.0031], significant: true}
  - {joint: A2, half_gap_deg: 0.0020, ci95: [0.0019, 0.0021], significant: true, schedule: {kind: pchip, knots: [[-100, 0.0035], [-50, 0.0022], [0, 0.0001]]}, varies_p_value: 1.0e-9}
  - {joint: A4, half_gap_deg: 0.0002, ci95: [-0.0001, 0.0005], significant: false}
";

fn deg(v: f64) -> f64 {
    v.to_degrees()
}

#[test]
fn constants_come_from_the_surer_document_schedules_from_the_static_one() {
    let robot = kuka();
    let c = fit(&robot, &[document(&robot, STATIC), document(&robot, PATH)], Form::Decay).unwrap();
    assert_eq!(c.joints.iter().map(|j| j.axis).collect::<Vec<_>>(), [0, 1, 2]);
    let gap = |axis: usize| c.on(axis).unwrap().backlash.as_ref().unwrap().positive.clone();
    assert!((deg(gap(0).constant().unwrap()) - 0.0028).abs() < 1e-12, "the path knows A1 better");
    assert!(matches!(gap(1), GapCurve::Pchip(_)));
    assert!((deg(gap(1).at(-50f64.to_radians())) - 0.0022).abs() < 1e-9);
    assert_eq!(gap(1).at(0.0), 0.0, "where the gap is smaller than its uncertainty nothing is compensated");
    let friction = c.on(0).unwrap().friction.unwrap();
    // three quarters of a standard error (of the logarithm) below the spike, the decay as much above
    let shade = |ci: [f64; 2]| 0.75 * (ci[1] / ci[0]).ln() / (2.0 * 1.959_963_984_540_054);
    assert!((deg(friction.gain) - 0.0034 * (-shade([0.0030, 0.0038])).exp()).abs() < 1e-12);
    let FrictionShape::Decay(Decay::Time(tau_s)) = friction.shape else { panic!("{:?}", friction.shape) };
    assert!((tau_s - 5.2 * shade([4.8, 5.6]).exp()).abs() < 1e-9, "{tau_s}");
    assert_eq!(c.evidence.logs.len(), 2);
    assert_eq!(c.evidence.tcp_speed_m_s, Some(1.5e-3));
}

#[test]
fn terms_that_are_not_known_are_left_out_and_the_notes_say_why() {
    let robot = kuka();
    let c = fit(&robot, &[document(&robot, STATIC), document(&robot, PATH)], Form::Decay).unwrap();
    assert!(c.on(1).unwrap().friction.is_none() && c.on(2).unwrap().friction.is_none() && c.on(3).is_none());
    for words in [
        "A2: no friction term: the log shows no stiction (p = 0.40)",
        "A3: friction term of 0.00100 deg is left out",
        "A4: half gap 0.00020 deg is left out",
        "A2: at 1 tested positions",
    ] {
        assert!(c.evidence.notes.iter().any(|n| n.to_string().starts_with(words)), "{words}: {:?}", c.evidence.notes);
    }
}

/// Gap and friction estimated together: what decides is the error at the TCP, whether the fit happened to have friction or not, and
/// `rewrite` decides as `fit` did.
#[test]
fn a_joint_that_is_proved_at_the_tcp_is_compensated_with_or_without_friction() {
    let folder = WorkFolder::new();
    let robot = kuka();
    let joint = |name: &str, spikes: &str, compensate: bool| {
        format!(
            "  - {{joint: {name}, half_gap_deg: 0.003, ci95: [0, 0.006], significant: false, response: {{presliding_deg: 0.0003, \
             windup_deg: 0, windups: [], spikes: [{spikes}]}}, trust: {{compensate: {compensate}, before_um: 80, after_um: 4, \
             reversals: 20, reason: test}}}}\n"
        )
    };
    let joints = joint("A1", "", true) + &joint("A2", "[0.0001, 1.2]", true) + &joint("A3", "", false);
    let c = fit(
        &robot,
        &[document(&robot, &format!("logs: [{{name: a.csv, sha256: aa}}]\njoints:\n{joints}"))],
        Form::Decay,
    )
    .unwrap();
    assert_eq!(c.joints.iter().map(|j| j.axis).collect::<Vec<_>>(), [0, 1]);
    let again = Compensator::parse("c.yaml", &c.to_yaml(&robot).unwrap(), &robot).unwrap();
    assert!(again.unproved().is_empty() && again.evidence.joints.iter().filter(|j| j.proved).count() == 2);
    let without = {
        let mut c = again.clone();
        c.evidence.joints.iter_mut().for_each(|j| j.proved = false);
        c.unproved()
    };
    assert_eq!(without, [0], "an interval alone that contains zero proves nothing");
    std::fs::write(folder.join("c.yaml"), c.to_yaml(&robot).unwrap()).unwrap();
    std::fs::write(
        folder.join("p.csv"),
        "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n0,-90,90,0,0,0\n5,-85,90,0,0,0\n1,-88,90,0,0,0\n",
    )
    .unwrap();
    let robot = file("configs/kuka-kr120-r2500-pro.yaml");
    let told = folder
        .run(&format!(
            "rewrite --robot {} --compensator c.yaml p.csv --output done.csv --speed-mm-s 50",
            robot.display()
        ))
        .success();
    assert!(!told.stderr.contains("may be zero"), "{}", told.stderr);
}

#[test]
fn gaps_at_reversals_that_differ_get_the_offset_of_least_largest_error() {
    let robot = kuka();
    let points = "points:
  - {joint: A1, at_deg: 10, half_gap_deg: 0.0020, ci95: [0.00198, 0.00202], cycles: 1}
  - {joint: A1, at_deg: -10, half_gap_deg: 0.0021, ci95: [0.00208, 0.00212], cycles: 1}
  - {joint: A1, at_deg: 10, half_gap_deg: 0.0030, ci95: [0.00298, 0.00302], cycles: 1}
joints: [{joint: A1, half_gap_deg: 0.00237, ci95: [0.0023, 0.0024], significant: true}]
";
    let c = fit(&robot, &[document(&robot, points)], Form::Decay).unwrap();
    let d = c.joints[0].backlash.as_ref().unwrap().positive.constant().unwrap();
    assert!((deg(d) - 0.0025).abs() < 1e-9, "{}", deg(d));
    let e = &c.evidence.joints[0];
    assert!(
        (deg(e.largest_after.unwrap()) - 0.0005).abs() < 1e-9 && (deg(e.largest_before.unwrap()) - 0.003).abs() < 1e-9
    );
}

#[test]
fn poses_follow_the_decay_at_the_programs_spacing() {
    let robot = kuka();
    let c = fit(&robot, &[document(&robot, PATH)], Form::Poses { spacing_s: 5.236 }).unwrap();
    let f = c.on(0).unwrap().friction.unwrap();
    let FrictionShape::Poses { exponent, poses } = f.shape else { panic!("{f:?}") };
    assert!((0.25..=8.0).contains(&exponent) && (2..=60).contains(&poses));
    assert!((deg(f.gain) / 0.0034 - 1.0).abs() < 0.15, "{}", deg(f.gain));
    let left = deg(c.evidence.joints[0].largest_after.unwrap());
    assert!(left < 0.12 * 0.0034, "{left}");
}

#[test]
fn points_too_far_apart_for_a_decay_leave_the_friction_out() {
    let robot = kuka();
    let c = fit(&robot, &[document(&robot, PATH)], Form::Poses { spacing_s: 200.0 }).unwrap();
    assert!(c.on(0).unwrap().friction.is_none(), "{:?}", c.on(0));
    assert!(c.evidence.notes.iter().any(|n| n.to_string().contains("cannot follow a decay")));
}

#[test]
fn from_log_to_compensator_on_the_command_line() {
    let work = WorkFolder::new();
    let (gaps, out) = (work.join("gaps.yaml"), work.join("compensator.yaml"));
    let robot_file = file("configs/kuka-kr120-r2500-pro.yaml");
    let command = || support::command();
    let log = file("samples/circle/circle_uncompensated_table3.csv.gz");
    command()
        .args(["identify", "path", "--robot"])
        .arg(&robot_file)
        .arg("--log")
        .arg(log)
        .arg("--output")
        .arg(&gaps)
        .assert()
        .success();
    let fit = |more: &[&str]| {
        let mut c = command();
        c.args(["fit", "--json", "--robot"])
            .arg(&robot_file)
            .arg("--gaps")
            .arg(&gaps)
            .arg("--output")
            .arg(&out)
            .args(more);
        c
    };
    fit(&["--valid-until", "2031-05-31"]).assert().success();
    let robot = kuka();
    let c = Compensator::load(&out, &robot).unwrap();
    for (axis, truth) in [(0, 0.0028), (1, 0.0037), (2, 0.0022)] {
        let b = c.on(axis).unwrap().backlash.as_ref().unwrap().positive.constant().unwrap();
        assert!((deg(b) / truth - 1.0).abs() < 0.01);
    }
    assert!(c.on(0).unwrap().friction.is_some() && c.on(1).unwrap().friction.is_none());
    assert_eq!(c.evidence.valid_until.as_deref(), Some("2031-05-31"));
    let program = file("samples/circle/circle_program.csv").display().to_string();
    fit(&["--form", "poses", "--program", &program]).assert().success();
    let c = Compensator::load(&out, &robot).unwrap();
    assert!(matches!(c.on(0).unwrap().friction.unwrap().shape, FrictionShape::Poses { .. }));
    let said = fit(&["--form", "poses"]).assert().code(2).get_output().stderr.clone();
    assert!(String::from_utf8_lossy(&said).contains("no spacing of points"));
    fit(&["--valid-until", "tomorrow"]).assert().code(2);
    let other = file("configs/abb-irb1600-6-145.yaml");
    let refused = command()
        .args(["fit", "--robot"])
        .arg(other)
        .arg("--gaps")
        .arg(&gaps)
        .arg("--output")
        .arg(&out)
        .assert()
        .code(2)
        .get_output()
        .stderr
        .clone();
    assert!(String::from_utf8_lossy(&refused).contains("another robot"), "{}", String::from_utf8_lossy(&refused));
}

#[test]
fn a_half_gap_below_zero_is_left_out_and_called_no_gap() {
    let robot = kuka();
    let rest = "joints:
  - {joint: A1, half_gap_deg: -0.0028, ci95: [-0.0029, -0.0027], significant: true}
  - {joint: A2, half_gap_deg: -0.0001, ci95: [-0.0004, 0.0002], significant: false}
";
    let c = fit(&robot, &[document(&robot, rest)], Form::Decay).unwrap();
    assert!(c.joints.is_empty());
    for words in [
        "A1: half gap -0.00280 deg is left out: the joint overshoots its command",
        "A2: half gap -0.00010 deg is left out because it is not larger",
    ] {
        assert!(c.evidence.notes.iter().any(|n| n.to_string().starts_with(words)), "{words}: {:?}", c.evidence.notes);
    }
}

#[test]
fn gaps_that_cannot_be_trusted_are_fitted_by_force_alone_and_say_so() {
    let folder = WorkFolder::new();
    let (gaps, out) = (folder.join("gaps.yaml"), folder.join("comp.yaml"));
    let robot = kuka();
    let head = format!("schema: lostmotion/gaps/1\nrobot: {{name: k, sha256: {}}}\n", robot.fingerprint());
    let distrust = "distrust: {reason: model_does_not_describe_log, variance_inflation: 18.2, gaps_held: false}\n";
    std::fs::write(&gaps, head + PATH + distrust).unwrap();
    let fit = |more: &[&str]| {
        let mut run = support::command();
        run.args(["fit", "--robot", "configs/kuka-kr120-r2500-pro.yaml", "--gaps"])
            .arg(&gaps)
            .arg("--output")
            .arg(&out);
        run.args(more).output().unwrap()
    };
    let refused = fit(&[]);
    assert_eq!(refused.status.code(), Some(1));
    let words = String::from_utf8_lossy(&refused.stderr);
    assert!(words.contains("the gaps cannot be trusted") && words.contains("(--force fits them"), "{refused:?}");
    assert!(!out.exists());
    assert!(fit(&["--force"]).status.success());
    assert!(std::fs::read_to_string(&out).unwrap().contains("cannot be trusted"));
}

/// The circle of one KUKA fits another one if the TCP may stand three quarters of a metre from the flange: the gaps are marked, the file
/// tells why, and `fit` refuses them. The arm itself, even with its tool left out of the file, is not marked.
#[test]
fn gaps_from_the_log_of_another_arm_are_marked_and_refused() {
    let folder = WorkFolder::new();
    let log = "samples/circle/circle_uncompensated_figure5.csv.gz";
    for robot in ["kuka-kr16-2", "kuka-kr10-r1100-sixx", "kuka-kr16-r2010-2", "kuka-kr50-r2500"] {
        let line = format!("identify path --robot configs/{robot}.yaml --log {log} --output {{}}/gaps.yaml");
        support::run_from_root(folder.path(), &line).success();
        let text = std::fs::read_to_string(folder.join("gaps.yaml")).unwrap();
        assert!(
            text.contains("reason: another_arm") && text.contains("seems to describe another arm"),
            "{robot}: {text}"
        );
        let line = format!("fit --robot configs/{robot}.yaml --gaps {{}}/gaps.yaml --output {{}}/comp.yaml");
        let refused = support::run_from_root(folder.path(), &line).ends_with(1);
        assert!(refused.stderr.contains("check the robot file (model, lengths"), "{}", refused.stderr);
        assert!(!folder.join("comp.yaml").exists());
    }
}

#[test]
fn a_tool_that_the_robot_file_does_not_know_is_no_other_arm() {
    let folder = WorkFolder::new();
    let text = std::fs::read_to_string(support::bundled("configs/kuka-kr120-r2500-pro.yaml")).unwrap();
    let tool = "tool: {xyz_mm: [";
    let at = text.find(tool).unwrap() + tool.len();
    let end = at + text[at..].find(']').unwrap();
    let with = format!("{}180, -60, 320{}", &text[..at], &text[end..]);
    std::fs::write(folder.join("robot.yaml"), with).unwrap();
    let log = "samples/circle/circle_uncompensated_figure5.csv.gz";
    let line = format!("identify path --robot {{}}/robot.yaml --log {log} --output {{}}/gaps.yaml");
    let outcome = support::run_from_root(folder.path(), &line).success();
    assert!(outcome.stderr.contains("check `tool`"), "{}", outcome.stderr);
    let gaps = std::fs::read_to_string(folder.join("gaps.yaml")).unwrap();
    assert!(!gaps.contains("distrust"), "{gaps}");
}
