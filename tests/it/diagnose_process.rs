//! The force of a process in a diagnosis: joints that yield to it, by levers that are differences of places.

use crate::support::{WorkFolder, run};
use lostmotion::robot::Robot;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;
use std::fmt::Write;

const ROWS: u32 = 2500;
const STEP_S: f64 = 0.04;
const NOISE_M: f64 = 8e-6;
/// Of J2, deg/Nm.
const COMPLIANCE: f64 = 4e-5;

fn wave(axis: usize, t: f64) -> f64 {
    let w = [0.31, 0.23, 0.17][axis];
    20.0 * (w * t).sin() + 7.0 * (2.7 * w * t).sin()
}

/// N on the tool: a cut that comes and goes.
fn force_n(t: f64) -> Vector3<f64> {
    Vector3::new(200.0 * (0.9 * t).sin(), 80.0 + 60.0 * (1.4 * t).cos(), -250.0 + 150.0 * (0.6 * t).sin())
}

/// Diagnosis of an arm whose J2 yields, with the columns of the force or without.
fn diagnosed(with_force: bool) -> Value {
    let desk = WorkFolder::new();
    std::fs::copy("tests/data/machines/arm/robot.yaml", desk.join("robot.yaml")).unwrap();
    let robot = Robot::load(&desk.join("robot.yaml")).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let normal = Normal::new(0.0, NOISE_M).unwrap();
    let mut csv = String::from("t_s,cmd_J1_deg,cmd_J2_deg,cmd_J3_deg,cmd_J4_deg,cmd_J5_deg,cmd_J6_deg,x_mm,y_mm,z_mm");
    csv += if with_force { ",fx_n,fy_n,fz_n\n" } else { "\n" };
    for k in 0..ROWS {
        let t = STEP_S * f64::from(k);
        let [a, b, c] = [0, 1, 2].map(|k| wave(k, t));
        let commands = [a, b + 30.0, c, b, 40.0 + b, c];
        let mut q = commands.map(f64::to_radians);
        let place = |q: &[f64; 6], by: f64| {
            let mut q = *q;
            q[1] += by;
            robot.tcp_m(&q)
        };
        let (lever, force) = ((place(&q, 1e-5) - place(&q, -1e-5)) / 2e-5, force_n(t));
        q[1] += COMPLIANCE.to_radians() * lever.dot(&force);
        let at = (robot.tcp_m(&q) + Vector3::from_fn(|_, _| normal.sample(&mut rng))) * 1e3;
        write!(csv, "{t:.3}").unwrap();
        commands.iter().for_each(|v| write!(csv, ",{v:.6}").unwrap());
        at.iter().for_each(|v| write!(csv, ",{v:.5}").unwrap());
        if with_force {
            force.iter().for_each(|v| write!(csv, ",{v:.3}").unwrap());
        }
        csv.push('\n');
    }
    std::fs::write(desk.join("log.csv"), csv).unwrap();
    let out = run(desk.path(), "diagnose --robot robot.yaml --log log.csv --json").success();
    serde_json::from_slice(&out.stdout).unwrap()
}

#[test]
fn a_joint_that_yields_to_a_logged_force_is_named_with_its_compliance() {
    let found = diagnosed(true);
    let rounds = found["rounds"].as_array().unwrap();
    assert_eq!(rounds.len(), 1, "{found:#}");
    assert_eq!((&rounds[0]["effect"], &rounds[0]["target"]), (&"process_force".into(), &"J2".into()), "{found:#}");
    assert_eq!(found["verdict"], "named", "{found:#}");
    let size = &rounds[0]["parameters"]["compliance_deg_per_nm"];
    assert!((size["value"].as_f64().unwrap() - COMPLIANCE).abs() < 0.02 * COMPLIANCE, "{size}");
    assert!(size["ci95"][0].as_f64().unwrap() > 0.0, "{size}");
}

#[test]
fn without_columns_of_the_force_no_name_says_force() {
    let found = diagnosed(false);
    assert!(!found["rounds"].to_string().contains("process_force"), "{found:#}");
    assert!(!found["blind_spots"].to_string().contains("process_force"), "{found:#}");
}

#[test]
fn a_force_needs_all_three_columns() {
    let desk = WorkFolder::new();
    std::fs::copy("configs/gantry-xyz-ballscrew.yaml", desk.join("robot.yaml")).unwrap();
    std::fs::write(
        desk.join("log.csv"),
        "t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,x_mm,y_mm,z_mm,fz_n\n0,0,0,0,0,0,0,1\n1,1,0,0,1,0,0,1\n",
    )
    .unwrap();
    let out = run(desk.path(), "diagnose --robot robot.yaml --log log.csv").ends_with(2);
    let said = out.stderr;
    assert!(said.contains("fx_n") && said.contains("log.csv:1"), "{said}");
}
