//! A machine on the bench for path tests: programs run at a TCP speed, lost motion from the effect catalogue, noise from a seed.

use crate::support::root;
use lostmotion::effects::{BacklashPosition, Decay, Effect, GapCurve, Stiction, Track, joint_output};
use lostmotion::log::Log;
use lostmotion::robot::Robot;
use nalgebra::{Isometry3, Vector3};
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use std::path::PathBuf;

/// A file of the repository.
pub fn file(relative: &str) -> PathBuf {
    root().join(relative)
}

pub fn kuka() -> Robot {
    Robot::load(&file("configs/kuka-kr120-r2500-pro.yaml")).unwrap()
}

/// Half gap, spike and decay of one axis; degrees and seconds.
#[derive(Debug, Clone)]
pub struct Fault {
    pub axis: usize,
    pub half_gap: GapCurve,
    pub spike_deg: f64,
    pub decay_s: f64,
}

impl Fault {
    pub fn new(axis: usize, gap_deg: f64, spike_deg: f64, decay_s: f64) -> Self {
        Self { axis, half_gap: GapCurve::Constant(gap_deg.to_radians()), spike_deg, decay_s }
    }
}

/// The machine of the circle log `table3`.
pub fn table3() -> Vec<Fault> {
    vec![Fault::new(0, 0.0028, 0.0034, 5.2), Fault::new(1, 0.0037, 0.0, 1.0), Fault::new(2, 0.0022, 0.0017, 5.2)]
}

/// Commands `cmd[axis][row]` in rad of smooth movements, `seconds` long at 25 Hz: `(axis, centre, amplitude, turns, phase)`.
pub fn waves(
    robot: &Robot,
    still_deg: &[f64],
    seconds: f64,
    waves: &[(usize, f64, f64, f64, f64)],
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let n = (seconds * 25.0) as usize;
    let t: Vec<f64> = (0..n).map(|i| i as f64 / 25.0).collect();
    let mut cmd: Vec<Vec<f64>> = (0..robot.dof()).map(|a| vec![still_deg[a].to_radians(); n]).collect();
    for &(axis, centre, amplitude, turns, phase) in waves {
        for (c, t) in cmd[axis].iter_mut().zip(&t) {
            let p = centre + amplitude * (std::f64::consts::TAU * turns * t / seconds + phase).sin();
            *c = ((p * 1e6).round() / 1e6).to_radians();
        }
    }
    (t, cmd)
}

/// The log of a run of `cmd` on a machine with `faults`, seen from `frame` with white noise.
pub fn run(
    robot: &Robot,
    t: &[f64],
    cmd: &[Vec<f64>],
    faults: &[Fault],
    frame: &Isometry3<f64>,
    noise_m: f64,
    seed: u64,
) -> Log {
    let mut q = cmd.to_vec();
    for f in faults {
        let track = Track::new(t, &cmd[f.axis], 1e-9);
        let effects = [
            Effect::new(Stiction { spike: f.spike_deg.to_radians(), decay: Decay::Time(f.decay_s) }),
            BacklashPosition::or_constant(f.half_gap.clone()),
        ];
        q[f.axis] = joint_output(&track, &effects);
    }
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, noise_m.max(1e-15)).unwrap();
    let mut tcp_m = Vec::with_capacity(t.len());
    let mut row = vec![0.0; cmd.len()];
    for i in 0..t.len() {
        row.iter_mut().zip(&q).for_each(|(r, q)| *r = q[i]);
        let noise = Vector3::from_fn(|_, _| normal.sample(&mut rng));
        tcp_m.push(Some(frame.rotation * robot.tcp_m(&row) + frame.translation.vector + noise));
    }
    Log {
        name: "bench.csv".into(),
        sha256: String::new(),
        line: (2..t.len() as u32 + 2).collect(),
        t_s: t.to_vec(),
        poses: false,
        cmd: cmd.to_vec(),
        cmd_decimals: vec![6; cmd.len()],
        tcp_m,
        reflectors_m: Vec::new(),
        lone_m: [const { None }; 3],
        enc: vec![None; cmd.len()],
        screw: vec![None; cmd.len()],
        meas: vec![None; cmd.len()],
        trigger: None,
        cycle: None,
        speed_m_s: None,
        payload_kg: None,
        temp_c: None,
        instruments: lostmotion::log::Instruments::default(),
    }
}
