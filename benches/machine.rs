//! Cost of one axis through servo and gear, as a fit calls it thousands of times: 262,144 rows, and of the whole chain.
//!
//! `cargo bench --bench machine`.

use lostmotion::effects::{Backlash, Decay, Effect, Hysteresis, ServoLag, Stiction, TransmissionError};
use lostmotion::machine::{CommandTrajectory, predict};
use lostmotion::model::Model;
use lostmotion::robot::Robot;
use std::path::Path;

const ROWS: usize = 262_144;

fn main() {
    divan::main();
}

fn robot() -> Robot {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    Robot::load(&root.join("configs/kuka-kr120-r2500-pro.yaml")).expect("the bundled robot")
}

/// Five joints swing at 25 Hz, the sixth rests.
fn trajectory(robot: &Robot) -> CommandTrajectory {
    let t_s: Vec<f64> = (0..ROWS).map(|i| i as f64 * 0.04).collect();
    let column =
        |a: usize| t_s.iter().map(move |t| if a < 5 { 0.3 * (t * (0.05 + 0.02 * a as f64)).sin() } else { 0.1 });
    let cmd = (0..6).map(|a| column(a).collect()).collect();
    CommandTrajectory::of_columns(robot, t_s.clone(), cmd, None, false)
}

fn gear(bencher: divan::Bencher, effects: &[Effect]) {
    let trajectory = trajectory(&robot());
    let effects: Vec<&Effect> = effects.iter().collect();
    bencher.bench_local(|| trajectory.gear(0, &effects, 0));
}

#[divan::bench]
fn nothing(bencher: divan::Bencher) {
    gear(bencher, &[]);
}

#[divan::bench]
fn backlash(bencher: divan::Bencher) {
    gear(bencher, &[Effect::new(Backlash::constant(5e-5))]);
}

#[divan::bench]
fn stiction(bencher: divan::Bencher) {
    gear(bencher, &[Effect::new(Stiction { spike: 5e-5, decay: Decay::Time(1.5) })]);
}

#[divan::bench]
fn hysteresis(bencher: divan::Bencher) {
    gear(bencher, &[Effect::new(Hysteresis { half_width: 5e-5, presliding: 1e-3 })]);
}

#[divan::bench]
fn transmission_error(bencher: divan::Bencher) {
    gear(
        bencher,
        &[Effect::new(TransmissionError {
            amplitude: 5e-5,
            cycles_per_rev: 30.0,
            phase_rad: 0.0,
            fade: None,
            further_phases_rad: Vec::new(),
        })],
    );
}

#[divan::bench]
fn servo_lag(bencher: divan::Bencher) {
    gear(bencher, &[Effect::new(ServoLag { lag_s: 0.01 })]);
}

#[divan::bench]
fn backlash_behind_a_lag(bencher: divan::Bencher) {
    gear(bencher, &[Effect::new(ServoLag { lag_s: 0.01 }), Effect::new(Backlash::constant(5e-5))]);
}

#[divan::bench]
fn prepare(bencher: divan::Bencher) {
    let robot = robot();
    bencher.bench_local(|| trajectory(&robot));
}

#[divan::bench]
fn whole_chain(bencher: divan::Bencher) {
    let robot = robot();
    let trajectory = trajectory(&robot);
    let model = Model::ideal(robot);
    bencher.bench_local(|| predict(&model, &trajectory));
}
