//! The machine: joints with the crate's own effects, a circle that it runs twice, what is measured of the second time.

use lostmotion::effects::{Backlash, Decay, Effect, Stiction, Track, joint_output};
use lostmotion::robot::{InverseOptions, Robot, Target};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const CENTRE_M: [f64; 3] = [1.780, 0.450, 1.200];
const RADIUS_M: f64 = 0.250;
const START_DEG: f64 = 88.7;
const SPEED_M_S: f64 = 0.0015;
pub const RATE_HZ: f64 = 4.0;
pub const NOISE_UM: f64 = 2.2;
const GAP_MDEG: [f64; 3] = [2.8, 3.7, 2.2];
const SPIKE_MDEG: [f64; 3] = [3.4, 0.0, 1.7];
pub const DECAY_S: f64 = 5.2;
pub const JOINTS: [&str; 6] = ["A1", "A2", "A3", "A4", "A5", "A6"];

/// One run of the program, its second revolution.
pub struct Measured {
    pub t_s: Vec<f64>,
    pub circle_deg: Vec<f64>,
    /// Nominal TCP, mm, and its error, µm.
    pub nominal_mm: Vec<[f64; 3]>,
    pub error_um: Vec<[f64; 3]>,
    pub in_plane_um: Vec<f64>,
    pub total_um: Vec<f64>,
    /// Error of A1 to A3, mdeg: measured, and without noise.
    pub joint_mdeg: [Vec<f64>; 3],
    pub model_mdeg: [Vec<f64>; 3],
}

/// Reversal of a joint: axis, sample of the second revolution, new direction.
pub type Reversal = (usize, usize, i8);

fn mdeg(v: f64) -> f64 {
    (v * 1e-3).to_radians()
}

/// Sampled commands of two revolutions: times and A1 to A3, rad.
pub fn commands(robot: &Robot) -> (Vec<f64>, [Vec<f64>; 3], Vec<f64>) {
    let options = InverseOptions { free: vec![0, 1, 2], ..InverseOptions::default() };
    let mut q: Vec<f64> = [-14.4, -77.8, 84.7, 0.0, 0.0, 0.0].map(f64::to_radians).to_vec();
    let points: Vec<Vec<f64>> = (0..=400)
        .map(|k| {
            let a = (START_DEG + 1.8 * f64::from(k)).to_radians();
            let p = Vector3::new(CENTRE_M[0], CENTRE_M[1] + RADIUS_M * a.cos(), CENTRE_M[2] + RADIUS_M * a.sin());
            q = robot.inverse(&Target::Position(p), &q, &options).q;
            q.clone()
        })
        .collect();
    let chord_s = 2.0 * RADIUS_M * 0.9f64.to_radians().sin() / SPEED_M_S;
    let n = (400.0 * chord_s * RATE_HZ) as usize;
    let t_s: Vec<f64> = (0..n).map(|i| i as f64 / RATE_HZ).collect();
    let along = |t: f64| (((t / chord_s) as usize).min(399), t / chord_s - ((t / chord_s) as usize).min(399) as f64);
    let joint = |j: usize| {
        t_s.iter()
            .map(|&t| {
                let (k, f) = along(t);
                points[k][j] + f * (points[k + 1][j] - points[k][j])
            })
            .collect()
    };
    let circle = t_s.iter().map(|&t| START_DEG + 1.8 * t / chord_s).collect();
    let axes = [joint(0), joint(1), joint(2)];
    (t_s, axes, circle)
}

/// Command with offsets `gap` and `spike` (mdeg), never turning back.
fn compensated(t_s: &[f64], p: &[f64], gap: f64, spike: f64) -> Vec<f64> {
    let track = Track::new(t_s, p, 1e-9);
    let mut out: Vec<f64> = p.iter().zip(track.dir.iter()).map(|(p, d)| p + f64::from(*d) * mdeg(gap)).collect();
    let decay = Decay::Time(DECAY_S);
    for (turn, samples) in track.strokes() {
        for i in samples {
            let d = f64::from(turn.dir);
            out[i] += d * mdeg(spike) * decay.left(t_s[i] - turn.t_s, 0.0);
            if i > turn.index + 1 && d * (out[i] - out[i - 1]) < 0.0 {
                out[i] = out[i - 1];
            }
        }
    }
    out
}

pub fn measure(
    robot: &Robot,
    t_s: &[f64],
    nominal: &[Vec<f64>; 3],
    circle_deg: &[f64],
    share: Option<(f64, f64)>,
    seed: u64,
) -> Measured {
    let truth: Vec<Vec<f64>> = (0..3)
        .map(|j| {
            let (gap, spike) = share.map_or((0.0, 0.0), |(g, s)| (g * GAP_MDEG[j], s * SPIKE_MDEG[j]));
            let sent = compensated(t_s, &nominal[j], gap, spike);
            let track = Track::new(t_s, &sent, 1e-9);
            let effects = [
                Effect::new(Stiction { spike: mdeg(SPIKE_MDEG[j]), decay: Decay::Time(DECAY_S) }),
                Effect::new(Backlash::constant(mdeg(GAP_MDEG[j]))),
            ];
            joint_output(&track, &effects)
        })
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |sigma: f64| -> f64 {
        let z: f64 = StandardNormal.sample(&mut rng);
        sigma * z
    };
    let mut m = Measured {
        t_s: Vec::new(),
        circle_deg: Vec::new(),
        nominal_mm: Vec::new(),
        error_um: Vec::new(),
        in_plane_um: Vec::new(),
        total_um: Vec::new(),
        joint_mdeg: Default::default(),
        model_mdeg: Default::default(),
    };
    let half = t_s.len() / 2;
    for i in half..t_s.len() {
        let pose = |j: &dyn Fn(usize) -> f64| robot.tcp_m(&[j(0), j(1), j(2), 0.0, 0.0, 0.0]);
        let (want, got) = (pose(&|j| nominal[j][i]), pose(&|j| truth[j][i]));
        let e = (got - want) * 1e6 + Vector3::from_fn(|_, _| noise(NOISE_UM));
        let out = want - Vector3::from(CENTRE_M);
        let r = out.y.hypot(out.z);
        m.t_s.push(t_s[i] - t_s[half]);
        m.circle_deg.push(circle_deg[i] % 360.0);
        m.nominal_mm.push([want.x * 1e3, want.y * 1e3, want.z * 1e3]);
        m.error_um.push([e.x, e.y, e.z]);
        m.in_plane_um.push((e.y * out.y + e.z * out.z) / r);
        m.total_um.push(m.in_plane_um[m.in_plane_um.len() - 1].hypot(e.x));
        for j in 0..3 {
            let error = (truth[j][i] - nominal[j][i]).to_degrees() * 1e3;
            m.model_mdeg[j].push(error);
            m.joint_mdeg[j].push(error + noise(0.15));
        }
    }
    m
}

pub fn reversals(t_s: &[f64], nominal: &[Vec<f64>; 3]) -> Vec<Reversal> {
    let half = t_s.len() / 2;
    let mut all: Vec<Reversal> = (0..3)
        .flat_map(|j| {
            let turns = Track::new(t_s, &nominal[j], 1e-9).turns;
            turns.into_owned().into_iter().filter(move |t| t.index > half).map(move |t| (j, t.index - half, t.dir))
        })
        .collect();
    all.sort();
    all
}

pub fn largest(values: &[f64], from: usize, samples: usize) -> f64 {
    values[from..(from + samples).min(values.len())].iter().fold(0.0, |m, v| m.max(v.abs()))
}

pub fn p95(values: &[f64]) -> Option<f64> {
    let mut v = values.to_vec();
    v.sort_by(f64::total_cmp);
    v.get(v.len() * 95 / 100).copied()
}
