//! One case: a machine, what its model lacks, two logs, and the truth.

use crate::alternatives;
use crate::badfile;
use crate::effects::Effect;
use crate::kinematics::rigid_fit;
use crate::noise::{MDB, Metric, Noise, Spoiled};
use crate::outside::{self, Outside};
use crate::paths;
use crate::physics::{Grid, STEP_S, force, registration, rms_um, torque};
use crate::robots::{self, Robot, rounded};
use crate::truth::{FURTHER, NAMES, Setting};
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

/// What a case is to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Null,
    /// One effect, at so many minimal detectable biases; the index goes through the names.
    Single(f64, usize),
    Large(usize),
    /// A hysteresis of two or three elements that no single one explains.
    Elements,
    Pair,
    Triple,
    Outside(usize),
    /// One of the effects that the mixed set does not draw.
    Further(usize),
    Bad(usize),
}

/// A log in file units.
#[derive(Clone)]
pub struct Log {
    pub t_s: Vec<f64>,
    pub cmd: Vec<Vec<f64>>,
    pub tcp_mm: Vec<Option<[f64; 3]>>,
    /// Torques of the drives, Nm or N, where they are logged.
    pub torque: Option<Vec<Vec<f64>>>,
    /// Force on the tool, N, where it is logged.
    pub force: Option<Vec<[f64; 3]>>,
    /// Of the commands.
    pub decimals: usize,
    pub tcp_decimals: usize,
}

pub struct Case {
    pub name: String,
    pub robot: Robot,
    pub truth: Value,
    pub model_yaml: String,
    pub train: Log,
    pub test: Log,
}

/// A path with its clean courses and rows.
struct Course {
    kind: &'static str,
    rate_hz: f64,
    grid: Grid,
    rows: Vec<usize>,
}

impl Course {
    fn draw(robot: &Robot, kind: &'static str, rate_hz: f64, count: usize, rng: &mut ChaCha8Rng) -> Course {
        let stride = (1.0 / rate_hz / STEP_S).round() as usize;
        let grid = Grid::new(paths::draw(kind, robot, count * stride + 500, rng));
        Course { kind, rate_hz, grid, rows: (0..count).map(|k| k * stride).collect() }
    }

    /// The same with a joint that stands still.
    fn holding(self, joint: usize, at: f64) -> Course {
        let mut joints = self.grid.joints;
        joints[joint].fill(at);
        Course { grid: Grid::new(joints), ..self }
    }
}

fn path_kind(rng: &mut ChaCha8Rng) -> &'static str {
    match rng.random_range(0..20) {
        0..=8 => "fourier",
        9..=13 => "mixed",
        14..=15 => "stairs",
        16..=17 => "sweeps",
        18 => "circle",
        _ => "raster",
    }
}

/// Makes the case of a kind from its seed; draws again where the effect would not show on the path.
pub fn make(kind: Kind, index: usize, seed: u64) -> Case {
    let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1_000_003).wrapping_add(index as u64));
    // a frame that is estimated takes up what bends the beam
    let refracted = matches!(kind, Kind::Further(k) if FURTHER[k % FURTHER.len()] == "tracker_refraction");
    let given = rng.random_bool(0.5) || refracted;
    loop {
        if let Some(case) = attempt(kind, index, given, &mut rng) {
            return case;
        }
    }
}

fn attempt(kind: Kind, index: usize, given: bool, rng: &mut ChaCha8Rng) -> Option<Case> {
    let robot = robots::draw(rng);
    let noise = Noise::draw(rng);
    let xyz = [0; 3].map(|_: i32| rounded(rng.random_range(-3000.0..3000.0), 4));
    let xyz = [xyz[0], xyz[1], rounded(xyz[2] * 0.2, 4)];
    let angles = [rng.random_range(-8.0..8.0), rng.random_range(-8.0..8.0), rng.random_range(-180.0..180.0)]
        .map(|v| rounded(v, 6));
    let frame = registration(xyz, angles);
    let rate_hz = [10.0, 20.0, 20.0, 25.0][rng.random_range(0..4)];
    let count = if rate_hz < 15.0 { rng.random_range(3000..3550) } else { rng.random_range(3400..5000) };
    let mut train = Course::draw(&robot, path_kind(rng), rate_hz, count, rng);
    let test_count = rng.random_range(2500..3700.min((350.0 * rate_hz) as usize));
    let mut test = Course::draw(&robot, path_kind(rng), rate_hz, test_count, rng);
    // friction of a joint that moves turns the torque over with the movement: a loop over the torque is asked for where it is held
    if matches!(kind, Kind::Further(k) if FURTHER[k % FURTHER.len()] == "torque_hysteresis") {
        let all = paths::moving(&train.grid.joints);
        if all.len() < 2 {
            return None;
        }
        let joint = all[rng.random_range(0..all.len())];
        let at = train.grid.joints[joint][0];
        (train, test) = (train.holding(joint, at), test.holding(joint, at));
    }
    let moving = paths::moving(&train.grid.joints);

    let known = known_effects(&robot, &moving, kind, rng);
    let clean_known = {
        let m = crate::physics::Machine { robot: &robot, registration: frame, effects: known.clone(), outside: vec![] };
        m.run(&train.grid, &train.rows)
    };
    let ticks: Vec<usize> = (0..train.rows.len()).collect();
    let metric = Metric::new(&noise, &ticks, &clean_known, given);
    let setting = Setting {
        robot: &robot,
        registration: frame,
        grid: &train.grid,
        rows: &train.rows,
        metric: &metric,
        known: &known,
        moving: &moving,
        rate_hz,
    };
    let (effects, faults) = content(kind, &setting, &clean_known, rng)?;

    let mut listed = Vec::new();
    let beside = setting.conditional(&clean_known, &effects);
    for (e, conditional) in effects.iter().zip(&beside) {
        let size = setting.sensitivity(&clean_known, std::slice::from_ref(e), &[]).norm() / MDB;
        let mut entry = e.json();
        entry.insert("mdb_multiple".into(), json!(rounded(size, 2)));
        entry.insert("mdb_conditional".into(), json!(rounded(*conditional, 2)));
        let alternatives =
            if matches!(kind, Kind::Bad(_)) { vec![] } else { alternatives::find(&setting, &clean_known, e) };
        entry.insert("also_right".into(), alternatives::json(&alternatives));
        listed.push(Value::Object(entry));
    }

    let mut logs = Vec::new();
    let mut stories = Vec::new();
    for course in [&train, &test] {
        // what happens to one log does not happen to the next
        let here = |e: &&Effect| logs.is_empty() || e.name != "tracker_frame";
        let here: Vec<Effect> = effects.iter().filter(here).cloned().collect();
        let (log, story) = log_of(&robot, frame, given, course, &known, &here, &faults, &noise, rng);
        logs.push(log);
        stories.push(story);
    }
    let (mut test_log, mut train_log) = (logs.pop()?, logs.pop()?);
    test_log.decimals = 6;
    let fault = match kind {
        Kind::Bad(k) => badfile::spoil(badfile::KINDS[k % badfile::KINDS.len()], &robot, &mut train_log, &moving, rng),
        _ => Value::Null,
    };
    if fault.get("kind").and_then(Value::as_str) == Some("tcp_in_metres") {
        train_log.tcp_decimals = 7;
    }
    let (word, right) = match kind {
        Kind::Null => ("null", json!(["none", "not_observable"])),
        Kind::Single(..) | Kind::Large(_) | Kind::Further(_) | Kind::Elements => {
            ("single", json!(["named", "named_set"]))
        }
        Kind::Pair => ("pair", json!(["named", "named_set"])),
        Kind::Triple => ("triple", json!(["named", "named_set"])),
        Kind::Outside(_) => ("unknown", json!(["unknown"])),
        Kind::Bad(_) => ("bad", json!(["bad_data"])),
    };
    let what: Vec<String> = match kind {
        Kind::Bad(_) => vec![fault["kind"].as_str().unwrap_or("").into()],
        Kind::Outside(_) => faults.iter().map(|f| f.kind.clone()).collect(),
        _ => effects.iter().map(|e| e.name.clone()).collect(),
    };
    let size = match kind {
        Kind::Single(k, _) => format!("{k:.0}"),
        Kind::Large(_) | Kind::Further(_) | Kind::Elements => "large".into(),
        _ => String::new(),
    };
    let name = format!("{index:03}-{word}{size}{}{}", if what.is_empty() { "" } else { "-" }, what.join("-"));
    let truth = json!({
        "schema": "lostmotion/case/1",
        "kind": word,
        "robot": robot.name,
        "registration_given": given,
        "registration": {"xyz_mm": xyz, "rpy_deg": angles},
        "known_effects": known.iter().map(|e| Value::Object(e.json())).collect::<Vec<_>>(),
        "effects": listed,
        "outside_the_catalogue": faults.iter().map(|f| f.json(&robot)).collect::<Vec<_>>(),
        "fault_of_the_file": fault,
        "right_verdict": right,
        "noise": noise.json(),
        "train": stories[0].clone(),
        "test": stories[1].clone(),
    });
    Some(Case {
        name,
        model_yaml: model_yaml(given.then_some((xyz, angles)), &known),
        robot,
        truth,
        train: train_log,
        test: test_log,
    })
}

/// In one case of five the model knows an effect already.
fn known_effects(robot: &Robot, moving: &[usize], kind: Kind, rng: &mut ChaCha8Rng) -> Vec<Effect> {
    if matches!(kind, Kind::Bad(_)) || !rng.random_bool(0.2) {
        return vec![];
    }
    let j = &robot.joints[moving[rng.random_range(0..moving.len())]];
    let (x, unit) = (j.suffix(), if j.revolute { 1.0 } else { 15.0 });
    let e = if rng.random_bool(0.6) {
        Effect::new("backlash", &j.name, &[(&format!("half_gap_{x}"), unit * rng.random_range(0.001..0.004))])
    } else {
        Effect::new("joint_zero_offset", &j.name, &[(&format!("offset_{x}"), unit * rng.random_range(0.005..0.03))])
    };
    vec![e.printed()]
}

/// The effects, or the faults, that a kind asks for; none where the path does not show them.
fn content(
    kind: Kind,
    s: &Setting,
    clean: &[Vector3<f64>],
    rng: &mut ChaCha8Rng,
) -> Option<(Vec<Effect>, Vec<Outside>)> {
    let free = |e: &Effect| s.known.iter().all(|k| k.target != e.target);
    let one = |name: &str, multiple: f64, rng: &mut ChaCha8Rng| {
        (0..4).find_map(|_| s.sized(clean, &s.draw(name, rng), multiple)).filter(free)
    };
    let any = |rng: &mut ChaCha8Rng| NAMES[rng.random_range(0..NAMES.len())];
    match kind {
        Kind::Null => Some((vec![], vec![])),
        Kind::Single(multiple, k) => Some((vec![one(NAMES[k % 16], multiple, rng)?], vec![])),
        Kind::Further(k) => {
            let multiple = log_uniform(20.0, 80.0, rng);
            Some((vec![one(FURTHER[k % FURTHER.len()], multiple, rng)?], vec![]))
        }
        Kind::Large(k) => {
            let multiple = log_uniform(20.0, 150.0, rng);
            Some((vec![one(NAMES[k % 16], multiple, rng)?], vec![]))
        }
        Kind::Elements => {
            let draw = s.draw_elements(rng);
            let e = s.sized(clean, &draw, log_uniform(40.0, 150.0, rng)).filter(free)?;
            let course = s.sensitivity(clean, std::slice::from_ref(&e), &[]);
            (alternatives::least_left(s, clean, &course) > 4.0 * MDB).then_some((vec![e], vec![]))
        }
        Kind::Pair | Kind::Triple => {
            let n = if kind == Kind::Pair { 2 } else { 3 };
            let mut effects: Vec<Effect> = Vec::new();
            for _ in 0..n {
                let multiple = log_uniform(5.0, 80.0, rng);
                effects.push(one(any(rng), multiple, rng)?);
            }
            let twice = (0..n).any(|a| {
                (0..a).any(|b| {
                    let (x, y) = (&effects[a], &effects[b]);
                    let plays = |e: &Effect| e.name.starts_with("backlash") || e.name == "hysteresis";
                    (x.name == y.name && x.target == y.target) || (x.target == y.target && plays(x) && plays(y))
                })
            });
            // Each must be there to be found beside the others.
            let seen = s.conditional(clean, &effects).iter().all(|m| *m >= 4.0);
            (!twice && seen).then_some((effects, vec![]))
        }
        Kind::Bad(_) => {
            let e = if rng.random_bool(0.5) { one(any(rng), 5.0, rng).into_iter().collect() } else { vec![] };
            Some((e, vec![]))
        }
        Kind::Outside(k) => {
            let name = outside::KINDS[k % outside::KINDS.len()];
            let mut fault = Outside::draw(name, &s.grid.joints, s.moving, rng);
            let goal = log_uniform(10.0, 100.0, rng) * MDB;
            for _ in 0..10 {
                let now = s.sensitivity(clean, &[], std::slice::from_ref(&fault)).norm();
                fault.size *= goal / now.max(1e-9);
            }
            let course = s.sensitivity(clean, &[], std::slice::from_ref(&fault));
            if (course.norm() / goal - 1.0).abs() > 0.05 || !fault.size.is_finite() || fault.size > 0.02 {
                return None;
            }
            // A catalogue effect must not explain it: what the best one leaves still shows, at 6 biases or more.
            let left = alternatives::least_left(s, clean, &course);
            (left > 6.0 * MDB).then_some((vec![], vec![fault]))
        }
    }
}

fn log_uniform(low: f64, high: f64, rng: &mut ChaCha8Rng) -> f64 {
    (rng.random_range(low.ln()..high.ln())).exp()
}

#[allow(clippy::too_many_arguments)]
fn log_of(
    robot: &Robot,
    frame: crate::kinematics::Pose,
    given: bool,
    course: &Course,
    known: &[Effect],
    effects: &[Effect],
    faults: &[Outside],
    noise: &Noise,
    rng: &mut ChaCha8Rng,
) -> (Log, Value) {
    let machine = |effects: Vec<Effect>, outside: Vec<Outside>| {
        crate::physics::Machine { robot, registration: frame, effects, outside }.run(&course.grid, &course.rows)
    };
    let model = machine(known.to_vec(), vec![]);
    let truth = machine(known.iter().chain(effects).cloned().collect(), faults.to_vec());
    let n = course.rows.len();
    let Spoiled { outliers, empty, missing } = noise.spoil(n, rng);
    let mut measured: Vec<Vector3<f64>> = truth.iter().zip(noise.course(n, rng)).map(|(p, e)| p + e).collect();
    let decimals = if noise.round_um > 0.0 { 3 } else { 4 };
    let clean_of_outliers: Vec<Option<Vector3<f64>>> = (0..n)
        .map(|k| (!empty[k] && !missing[k] && outliers.iter().all(|(o, _)| *o != k)).then_some(measured[k]))
        .collect();
    for (k, d) in &outliers {
        measured[*k] += d;
    }
    let gap = |from: &[Vector3<f64>], to: &[Option<Vector3<f64>>]| {
        let fit = if given { crate::kinematics::Pose::identity() } else { rigid_fit(from, to) };
        let moved: Vec<_> = from.iter().map(|p| crate::kinematics::apply(&fit, p)).collect();
        rounded(rms_um(&moved, to), 3)
    };
    let exact: Vec<_> = truth.iter().map(|p| Some(*p)).collect();
    let kept: Vec<usize> = (0..n).filter(|k| !missing[*k]).collect();
    let story = json!({
        "path": course.kind,
        "rate_hz": course.rate_hz,
        "rows": kept.len(),
        "gap_noise_free_rms_um": gap(&model, &exact),
        "gap_measured_rms_um": gap(&model, &clean_of_outliers),
        "gap_with_truth_rms_um": gap(&truth, &clean_of_outliers),
    });
    let log = Log {
        t_s: kept.iter().map(|&k| k as f64 / course.rate_hz).collect(),
        cmd: kept
            .iter()
            .map(|&k| robot.joints.iter().zip(&course.grid.joints).map(|(j, q)| q[course.rows[k]] / j.unit()).collect())
            .collect(),
        tcp_mm: kept
            .iter()
            .map(|&k| (!empty[k]).then(|| [0, 1, 2].map(|c| rounded(measured[k][c] * 1e3, decimals))))
            .collect(),
        torque: effects.iter().any(|e| e.name.starts_with("torque_")).then(|| {
            let row = |k: &usize| (0..robot.joints.len()).map(|j| torque(j, *k as f64 / course.rate_hz)).collect();
            kept.iter().map(row).collect()
        }),
        force: effects
            .iter()
            .any(|e| e.name == "process_force")
            .then(|| kept.iter().map(|k| force(*k as f64 / course.rate_hz).into()).collect()),
        decimals: 6,
        tcp_decimals: decimals as usize,
    };
    (log, story)
}

fn model_yaml(frame: Option<([f64; 3], [f64; 3])>, known: &[Effect]) -> String {
    let mut s = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\n");
    if let Some((x, r)) = frame {
        s += &format!(
            "registration: {{xyz_mm: [{}, {}, {}], rpy_deg: [{}, {}, {}]}}\n",
            x[0], x[1], x[2], r[0], r[1], r[2]
        );
    }
    if known.is_empty() {
        return s + "effects: []\n";
    }
    s += "effects:\n";
    for e in known {
        s += &format!("  - {}\n", e.yaml());
    }
    s
}

/// What a share of the cases are, for a number of cases: the index picks the kind, so that any prefix is a fair mixture.
pub fn kind_of(index: usize) -> Kind {
    match index % 16 {
        0..=3 => Kind::Single(10.0, index / 16 * 4 + index % 16),
        4..=7 => Kind::Single(3.0, index / 16 * 4 + index % 16 - 4),
        8 => Kind::Large(index / 16 * 7),
        9 | 10 => Kind::Null,
        11 | 12 => Kind::Pair,
        13 => Kind::Triple,
        14 => Kind::Outside(index / 16),
        _ => Kind::Bad(index / 16),
    }
}
