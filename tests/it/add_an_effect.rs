//! The steps of docs/add-an-effect.md: its code is compiled here, simulated, read, written, tried and undone.

mod hose_pull;

use hose_pull::{HosePull, INFO};
use lostmotion::effects::candidate::AxisSurvey;
use lostmotion::effects::{EffectInstance, Family, Survey, Target, entry};
use lostmotion::io::yaml::Document;
use lostmotion::machine::{CommandTrajectory, predict};
use lostmotion::model::Model;
use lostmotion::rewrite::points::Points;
use lostmotion::rewrite::statics::Statics;
use lostmotion::robot::Robot;
use std::f64::consts::FRAC_PI_2;

fn arm() -> Robot {
    let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 800}\n  - {name: A2, kind: revolute, a_mm: 500}\n";
    Robot::parse("robot.yaml", text).unwrap()
}

/// The entry of the example, read with a catalogue that holds the new effect alone.
fn example(text: &str) -> lostmotion::error::Result<EffectInstance> {
    let value = serde_yaml::from_str(text).unwrap();
    entry::read_with(&[&INFO], &value, &arm(), &Document { name: "model.yaml", text })
}

#[test]
fn the_page_shows_the_code_that_is_tested() {
    let page = std::fs::read_to_string("docs/add-an-effect.md").unwrap();
    let code = include_str!("add_an_effect/hose_pull.rs");
    assert!(page.contains(&format!("```rust\n{code}```")), "docs/add-an-effect.md differs from {}", file!());
}

#[test]
fn its_entry_is_read_and_written_and_a_wrong_one_is_refused_with_its_line() {
    let placed = example(INFO.example.0).unwrap();
    assert_eq!(placed.target, Target::Joint(0));
    assert!((placed.effect.get::<HosePull>().unwrap().pull - 0.004f64.to_radians()).abs() < 1e-18);
    let written = serde_json::to_value(entry::write(&placed, &arm())).unwrap();
    assert_eq!(written["effect"], "hose_pull");
    assert!((written["pull_deg"].as_f64().unwrap() - 0.004).abs() < 1e-15);
    let refused = example("{effect: hose_pull, joint: A1, pull_deg: -1}").unwrap_err().to_string();
    assert!(refused.contains("model.yaml:1") && refused.contains("pull_deg: -1"), "{refused}");
    let unknown = example("{effect: hose_pull, joint: A1, pull_deg: 1, push_deg: 2}").unwrap_err().to_string();
    assert!(unknown.contains("unknown key `push_deg`"), "{unknown}");
}

#[test]
fn the_simulated_joint_obeys_its_equation() {
    let robot = arm();
    let t_s: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.05).collect();
    let a1: Vec<f64> = t_s.iter().map(|t| 1.4 * (0.8 * t).sin()).collect();
    let trajectory = CommandTrajectory::of_columns(&robot, t_s.clone(), vec![a1.clone(), vec![0.3; 200]], None, false);
    let mut model = Model::ideal(robot);
    let ideal = predict(&model, &trajectory);
    model.effects.push(example(INFO.example.0).unwrap());
    let real = predict(&model, &trajectory);
    let pull = 0.004f64.to_radians();
    let reach = (0.64 + 0.25 + 2.0 * 0.8 * 0.5 * 0.3f64.cos()).sqrt();
    for (row, p) in a1.iter().enumerate() {
        let error = -pull * (p / FRAC_PI_2).powi(3);
        assert!((real.joint[0][row] - p - error).abs() < 1e-15);
        // the TCP turns about the first joint
        let moved = (real.points_m[0][row] - ideal.points_m[0][row]).norm();
        assert!((moved - 2.0 * reach * (0.5 * error).sin().abs()).abs() < 1e-12, "row {row}: {moved}");
    }
}

#[test]
fn a_diagnosis_tries_it_on_every_joint_that_moves() {
    let robot = arm();
    let axis = |travel: f64| AxisSurvey { travel, range: [0.0, travel], ..AxisSurvey::default() };
    let axes = vec![axis(1.0), axis(0.0)];
    let survey = Survey { axes, points: true, ..Survey::nothing(&robot) };
    let mut list = Vec::new();
    (INFO.candidates)(&survey, &mut list);
    assert_eq!(list.len(), 1);
    assert_eq!((list[0].effect, list[0].target.as_str(), list[0].positive), ("hose_pull", "A1", true));
    assert_eq!(list[0].at(&[2e-5])[0], EffectInstance::on_axis(0, HosePull { pull: 2e-5 }));
    assert_eq!(INFO.family, Family::Gravity);
}

#[test]
fn rewrite_undoes_it_point_by_point() {
    let mut model = Model::ideal(arm());
    model.effects.push(example(INFO.example.0).unwrap());
    let q = vec![1.2, 0.3, -0.9, 0.4];
    let points = Points { axes: 2, q: q.clone(), t_s: Vec::new() };
    let mut largest = [0.0; 2];
    let commands = Statics::of_model(&model).unwrap().commands(&points, 1.0, &mut largest);
    for (row, wanted) in q.chunks(2).enumerate() {
        let c = commands.row(row)[0];
        let reached = c - 0.004f64.to_radians() * (c / FRAC_PI_2).powi(3);
        assert!((reached - wanted[0]).abs() < 1e-13 && commands.row(row)[1] == wanted[1]);
    }
    assert!(largest[0] > 1e-6 && largest[1] == 0.0);
}
