//! Kinematics and log reading at the sizes that matter: one configuration of a six-axis arm, a log of 262,000 rows.
//!
//! `cargo bench --bench kinematics`. The peer stands in `benches/peer_pinocchio.py`; figures in `docs/robot.md`.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use lostmotion::io::input::Input;
use lostmotion::log::Log;
use lostmotion::robot::Robot;
use nalgebra::Vector3;
use std::fmt::Write;

fn main() {
    divan::main();
}

fn robot(file: &str) -> Robot {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(file);
    Robot::load(&path).unwrap()
}

/// Joint vectors that differ, so that nothing can be remembered from one call to the next.
fn poses(robot: &Robot, n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|i| (0..robot.dof()).map(|k| ((i * 7 + k * 13) as f64 * 0.017).sin()).collect()).collect()
}

const BATCH: usize = 1000;

#[divan::bench]
fn position(b: Bencher) {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    let q = poses(&robot, BATCH);
    b.counter(ItemsCount::new(BATCH)).bench_local(|| {
        for q in &q {
            black_box(robot.chain().position(black_box(q)));
        }
    });
}

#[divan::bench]
fn position_and_jacobian(b: Bencher) {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    let q = poses(&robot, BATCH);
    let mut columns = vec![Vector3::zeros(); robot.dof()];
    b.counter(ItemsCount::new(BATCH)).bench_local(|| {
        for q in &q {
            black_box(robot.chain().position_and_jacobian(black_box(q), &mut columns));
            black_box(&columns);
        }
    });
}

#[divan::bench]
fn jacobian_of_six_rows(b: Bencher) {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    let q = poses(&robot, BATCH);
    b.counter(ItemsCount::new(BATCH)).bench_local(|| {
        for q in &q {
            black_box(robot.chain().jacobian(black_box(q)));
        }
    });
}

#[divan::bench]
fn sines_and_cosines_alone(b: Bencher) {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    let q = poses(&robot, BATCH);
    b.counter(ItemsCount::new(BATCH)).bench_local(|| {
        for q in &q {
            for v in q {
                black_box(black_box(*v).sin_cos());
            }
        }
    });
}

#[divan::bench(sample_count = 20)]
fn read_a_log_of_262000_rows(b: Bencher) {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    let mut text =
        String::from("t_s,cmd_A1_deg,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg,x_mm,y_mm,z_mm\n");
    for i in 0..262_000 {
        let s = (f64::from(i) * 1e-4).sin();
        let t = f64::from(i) * 0.004;
        let (a1, a2, a3) = (-14.4 + 8.0 * s, -77.8 - s, 84.7 + s);
        let (x, y, z) = (993.7 + s, 2589.8 - s, 858.4 + s);
        writeln!(text, "{t:.3},{a1:.6},{a2:.6},{a3:.6},0.0,0.0,0.0,{x:.4},{y:.4},{z:.4}").unwrap();
    }
    b.with_inputs(|| Input { name: "log.csv".into(), bytes: text.clone().into_bytes(), sha256: String::new() })
        .bench_values(|input| Log::parse(input, &robot).unwrap());
}
