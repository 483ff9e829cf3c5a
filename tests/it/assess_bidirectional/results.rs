//! What is written for a joint: gaps and models with the backlash over position and speed, on a joint's own axis.

use super::{Folder, GANTRY, KUKA, command, found, play, refused};
use crate::support;
use lostmotion::effects::{BacklashPosition, BacklashSpeed};
use lostmotion::gaps::Gaps;
use lostmotion::model::Model;
use lostmotion::robot::Robot;
use std::path::Path;

#[test]
fn the_curve_goes_through_gaps_and_fit_into_a_compensator_and_back_to_the_true_half_gap() {
    let folder = Folder::new();
    let half = |x: f64| 4.0 + 0.02 * x - 2e-5 * x * x;
    let readings = folder.write("readings.csv", &play(half, 6));
    let (gaps, model) = (folder.text("gaps.yaml"), folder.text("model.yaml"));
    let joint = ["--robot", GANTRY, "--joint", "X"];
    let mut args = vec![readings.as_str()];
    args.extend(joint);
    args.extend(["--origin", "50", "--output", &gaps, "--model-out", &model]);
    let (doc, _) = found(&args);
    assert_eq!(doc["model"]["degree"], 2);
    let robot = Robot::load(Path::new(GANTRY)).unwrap();
    let read = Gaps::load(&folder.path("gaps.yaml"), &robot).unwrap();
    let schedule = read.joints[0].schedule.as_ref().unwrap();
    let machine = Model::load(&folder.path("model.yaml")).unwrap();
    assert_eq!(machine.effects[0].effect.name(), "backlash_position");
    let b = machine.effects[0].effect.get::<BacklashPosition>().unwrap();
    for x in [0.0, 130.0, 333.0, 600.0] {
        let joint_m = (x + 50.0) * 1e-3;
        for found in [schedule.at(joint_m), b.half_gap.at(joint_m)] {
            assert!((found * 1e6 - half(x)).abs() < 0.6, "{x}: {}", found * 1e6);
        }
    }
    assert_eq!(read.points.len(), 5);
    assert!((read.points[1].at - 0.15).abs() < 1e-9 && read.points[1].cycles == 6);
    let compensator = folder.text("compensator.yaml");
    let fit = ["fit", "--robot", GANTRY, "--gaps", &gaps, "--output", &compensator];
    support::command().args(fit).assert().success();
    let text = std::fs::read_to_string(&compensator).unwrap();
    assert!(text.contains("X:") && text.contains("schedule"), "{text}");
}

/// A polynomial of degree 5 about joint position 0 would need 20 digits here.
#[test]
fn a_short_line_far_out_on_a_long_axis_keeps_its_schedule() {
    let folder = Folder::new();
    let half = |x: f64| 20.0 + 8.0 * (x / 130.0).sin();
    let mut text = String::from("position_mm,direction,repeat,error_um\n");
    for x in (0..=16).map(|k| f64::from(k) * 50.0) {
        for r in 0..4 {
            let [up, down] = [7, 5].map(|m| 0.1 * f64::from((r * m + x as i32 / 50 * 3) % 5 - 2));
            text += &format!("{x},+1,{r},{}\n{x},-1,{r},{}\n", up - half(x), down + half(x));
        }
    }
    let readings = folder.write("readings.csv", &text);
    let long = std::fs::read_to_string(GANTRY).unwrap().replacen("limits_mm: [0, 1000]", "limits_mm: [0, 60000]", 1);
    let robot = folder.write("long.yaml", &long);
    let (gaps, compensator) = (folder.text("gaps.yaml"), folder.text("compensator.yaml"));
    for origin in ["0", "5000", "30000", "50000"] {
        let joint = ["--robot", &robot, "--joint", "X", "--origin", origin, "--degree", "5", "--output", &gaps];
        found(&[&[readings.as_str()], joint.as_slice()].concat());
        let loaded = Robot::load(Path::new(&robot)).unwrap();
        let read = Gaps::load(&folder.path("gaps.yaml"), &loaded).unwrap();
        let schedule = read.joints[0].schedule.as_ref().unwrap();
        for x in [0.0, 130.0, 333.0, 600.0, 800.0] {
            let at = (x + origin.parse::<f64>().unwrap()) * 1e-3;
            assert!((schedule.at(at) * 1e6 - half(x)).abs() < 0.6, "{origin}, {x}: {}", schedule.at(at) * 1e6);
        }
        let fit = ["fit", "--robot", &robot, "--gaps", &gaps, "--output", &compensator, "--force"];
        support::command().args(fit).assert().success();
    }
}

#[test]
fn a_revolute_joint_takes_its_lever_arm() {
    let folder = Folder::new();
    let readings = folder.write("readings.csv", &play(|x| 10.0 + 0.02 * x, 6));
    let gaps = folder.text("gaps.yaml");
    for (lever, turned) in [("1000", false), ("-1000", true)] {
        found(&[&readings, "--robot", KUKA, "--joint", "A1", "--lever-mm", lever, "--output", &gaps]);
        let robot = Robot::load(Path::new(KUKA)).unwrap();
        let read = Gaps::load(&folder.path("gaps.yaml"), &robot).unwrap();
        let schedule = read.joints[0].schedule.as_ref().unwrap();
        // 300 mm on a lever of 1 m is 0.3 rad; 16 um are 16 urad
        let at = if turned { -0.3 } else { 0.3 };
        assert!((schedule.at(at) - 16e-6).abs() < 0.6e-6, "{lever}: {}", schedule.at(at));
    }
}

#[test]
fn speeds_become_a_backlash_speed_with_the_true_slope() {
    let folder = Folder::new();
    let mut text = String::from("position_mm,direction,repeat,error_um,speed_mm_s\n");
    for speed in [10.0, 200.0, 500.0] {
        for line in play(|_| 6.0 + 0.01 * speed, 5).lines().skip(1) {
            text += &format!("{line},{speed}\n");
        }
    }
    let readings = folder.write("speeds.csv", &text);
    let model = folder.text("model.yaml");
    found(&[&readings, "--robot", GANTRY, "--joint", "X", "--model-out", &model, "--effect", "backlash-speed"]);
    let machine = Model::load(&folder.path("model.yaml")).unwrap();
    let b = machine.effects[0].effect.get::<BacklashSpeed>().unwrap();
    assert!((b.half_gap * 1e6 - 6.0).abs() < 0.3 && (b.slope * 1e6 - 10.0).abs() < 0.5, "{b:?}");
    // the same speeds without an effect: the answer is no
    let flat = text.lines().take(51).chain(text.lines().skip(1).take(50)).collect::<Vec<_>>();
    let flat: String = flat
        .iter()
        .enumerate()
        .map(|(i, l)| if i > 50 { l.replace(",10", ",500") } else { l.to_string() } + "\n")
        .collect();
    let flat = folder.write("flat.csv", &flat);
    let no =
        refused(&[&flat, "--robot", GANTRY, "--joint", "X", "--model-out", &model, "--effect", "backlash_speed"], 1);
    assert!(no.contains("no speed changes the backlash"), "{no}");
}

#[test]
fn a_line_outside_the_joint_s_limits_is_refused_and_one_that_reaches_beyond_them_is_noted() {
    let folder = Folder::new();
    let (file, gaps) = (folder.write("readings.csv", &play(|_| 40.0, 5)), folder.text("gaps.yaml"));
    // X goes from 0 to 1000 mm, the line from 0 to 600
    let with = |origin: &str| {
        vec![
            file.clone(),
            "--robot".into(),
            GANTRY.into(),
            "--joint".into(),
            "X".into(),
            "--origin".into(),
            origin.into(),
        ]
    };
    let args = |origin: &str| [with(origin), vec!["--output".into(), gaps.clone()]].concat();
    let line = |origin: &str| command(&args(origin).iter().map(String::as_str).collect::<Vec<_>>()).output().unwrap();
    for (origin, code, says) in [
        ("400", 0, ""),
        ("500", 0, "a line from 500 to 1100 mm of X reaches beyond its limits 0 to 1000 mm"),
        ("1001", 2, "found a line from 1001 to 1601 mm of X; expected a line within its limits 0 to 1000 mm"),
        ("-700", 2, "found a line from -700 to -100 mm of X"),
    ] {
        let out = line(origin);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(code) && said.contains(says), "{origin}: {said}");
        assert_eq!(said.contains("limits"), origin != "400", "{said}");
        assert_eq!(folder.path("gaps.yaml").exists(), code == 0);
        let _ = std::fs::remove_file(folder.path("gaps.yaml"));
    }
}
