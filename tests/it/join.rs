//! `join` on recordings of an independent simulator (tests/oracle/join.py), whose clocks are known.

use crate::support::{WorkFolder, bundled};
use lostmotion::effects::{Backlash, EffectInstance, Target};
use lostmotion::io::bag::TopicChoice;
use lostmotion::io::input::Input;
use lostmotion::join::{Options, Rows, join};
use lostmotion::log::Log;
use lostmotion::log::recording::Recording;
use lostmotion::machine::measurement::Instrument;
use lostmotion::model::Model;
use lostmotion::plan::recording::{self, Kind};
use lostmotion::program::Program;
use lostmotion::robot::Robot;
use lostmotion::simulate::Motion;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn robot() -> Robot {
    Robot::load(&bundled("configs/kuka-kr120-r2500-pro.yaml")).unwrap()
}

/// Controller's time minus the tracker's, ms, at a time of the tracker; parts per million.
fn truth(folder: &Path, seed: u32, at_tracker_s: f64) -> (f64, f64) {
    let text = std::fs::read_to_string(folder.join(format!("truth_{seed}.json"))).unwrap();
    let v: Value = serde_json::from_str(&text).unwrap();
    let rate = v["rate"].as_f64().unwrap() - 1.0;
    ((v["offset_s"].as_f64().unwrap() + rate * at_tracker_s) * 1e3, rate * 1e6)
}

fn joined(folder: &Path, seed: u32, options: &Options) -> lostmotion::join::Joined {
    let robot = robot();
    let load = |what: &str| {
        let plain = folder.join(format!("{what}_{seed}.csv"));
        let path = if plain.exists() { plain } else { folder.join(format!("{what}_{seed}.csv.gz")) };
        Recording::load(&path, &robot, None, TopicChoice::Any).unwrap()
    };
    join(&robot, &load("controller"), &load("tracker"), options).unwrap()
}

fn samples() -> PathBuf {
    bundled("samples/join")
}

#[test]
fn the_clock_of_the_samples_is_found_within_its_interval() {
    for seed in [2, 3] {
        let report = joined(&samples(), seed, &Options::default()).report;
        let (offset_ms, drift_ppm) = truth(&samples(), seed, report.at_tracker_s);
        assert!((report.offset_ms.value - offset_ms).abs() < 0.3, "{seed}: {:?} {offset_ms}", report.offset_ms);
        // three times the interval: two seeds are no coverage
        for (found, want) in [(report.offset_ms, offset_ms), (report.drift_ppm, drift_ppm)] {
            let half = 0.5 * (found.ci95[1] - found.ci95[0]);
            assert!((found.value - want).abs() < 1.6 * half, "{seed}: {found:?} {want}");
        }
        assert_eq!(report.tracker.jitter_ms.is_some(), seed == 3);
        assert!(report.rms_um < 13.0, "{}", report.rms_um);
    }
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn readings_keep_their_digits_and_commands_their_values() {
    let robot = robot();
    for rows in [Rows::Tracker, Rows::Controller] {
        let out = joined(&samples(), 2, &Options { rows, ..Options::default() });
        let csv = out.table.to_csv();
        let input = lostmotion::io::input::from_bytes("joined.csv".into(), csv.clone()).unwrap();
        let log = Log::parse(input, &robot).unwrap();
        assert_eq!(log.len(), out.report.rows);
        let (what, column) = if rows == Rows::Tracker { ("tracker", "x_mm") } else { ("controller", "cmd_A1_deg") };
        let (ours, theirs) = (cells(&csv, column), source(what, column));
        let at = theirs.iter().position(|v| *v == ours[0]).unwrap();
        assert_eq!(ours, theirs[at..at + ours.len()], "{what}");
    }
}

fn cells(csv: &[u8], column: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_reader(csv);
    let k = reader.headers().unwrap().iter().position(|h| h == column).unwrap();
    reader.records().map(|r| r.unwrap()[k].trim_end_matches('0').to_string()).collect()
}

fn source(what: &str, column: &str) -> Vec<String> {
    let input = lostmotion::io::input::read(&samples().join(format!("{what}_2.csv.gz"))).unwrap();
    cells(&input.bytes, column)
}

/// A reversal of a command stays one: the interpolated command turns as often as the recorded one, and as far.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn resampling_neither_adds_nor_cuts_reversals() {
    let out = joined(&samples(), 2, &Options::default());
    let robot = robot();
    let log =
        Log::parse(lostmotion::io::input::from_bytes("j.csv".into(), out.table.to_csv()).unwrap(), &robot).unwrap();
    let first = *log.t_s.first().unwrap();
    let last = *log.t_s.last().unwrap();
    let recorded = Recording::load(&samples().join("controller_2.csv.gz"), &robot, None, TopicChoice::Joints).unwrap();
    let t = recorded.values(lostmotion::log::columns::Meaning::Time).unwrap();
    for axis in 0..6 {
        let command = recorded.values(lostmotion::log::columns::Meaning::Command(axis)).unwrap();
        let within: Vec<f64> =
            t.iter().zip(command).filter(|(t, _)| (first..=last).contains(t)).map(|(_, c)| *c).collect();
        let (ours, theirs) = (peaks(&log.cmd[axis]), peaks(&within));
        assert_eq!(ours.len(), theirs.len(), "axis {axis}");
        for (a, b) in ours.iter().zip(&theirs) {
            assert!((a - b).abs().to_degrees() < 0.005, "axis {axis}: {} {}", a.to_degrees(), b.to_degrees());
        }
    }
}

fn peaks(v: &[f64]) -> Vec<f64> {
    v.windows(3).filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < 0.0).map(|w| w[1]).collect()
}

#[test]
fn a_motion_that_repeats_is_refused_with_its_offsets() {
    let robot = robot();
    let at = |t: f64| [20.0 + 10.0 * (t * 2.0).sin(), -60.0 + 6.0 * (t * 2.0).cos(), 80.0 + 3.0 * (t * 4.0).sin()];
    let mut controller = String::from("t_s,cmd_A1_deg,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg\n");
    let mut tracker = String::from("t_s,x_mm,y_mm,z_mm\n");
    for i in 0..2000 {
        let t = 0.02 * f64::from(i);
        let [a, b, c] = at(t);
        controller.push_str(&format!("{t:.3},{a:.6},{b:.6},{c:.6},0,0,0\n"));
        if (600..1100).contains(&i) {
            let p = robot.tcp_m(&[a, b, c, 0.0, 0.0, 0.0].map(f64::to_radians)) * 1e3;
            tracker.push_str(&format!("{:.3},{:.4},{:.4},{:.4}\n", t + 5.0, p.x, p.y, p.z));
        }
    }
    let of = |name: &str, text: String| {
        let input = lostmotion::io::input::from_bytes(name.into(), text.into_bytes()).unwrap();
        Recording::parse(input, &robot, None, TopicChoice::Any).unwrap()
    };
    let (controller, tracker) = (of("controller.csv", controller), of("tracker.csv", tracker));
    let error = join(&robot, &controller, &tracker, &Options::default()).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("repeats") && error.contains("about every 3.14 s"), "{error}");
    assert!(error.contains("an approximate offset") && error.len() < 260, "{error}");
    let near = Options { near_s: Some(-5.3), ..Options::default() };
    let report = join(&robot, &controller, &tracker, &near).unwrap().report;
    assert!((report.offset_ms.value + 5000.0).abs() < 0.05, "{:?}", report.offset_ms);
}

/// A time server set one of the clocks: rows would be off by half the step.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn a_clock_that_steps_is_refused_with_the_step() {
    use lostmotion::log::columns::Meaning;
    let robot = robot();
    let load = |what: &str| {
        Recording::load(&samples().join(format!("{what}_2.csv.gz")), &robot, None, TopicChoice::Any).unwrap()
    };
    let (controller, tracker) = (load("controller"), load("tracker"));
    assert!(join(&robot, &controller, &tracker, &Options::default()).is_ok());
    let times = tracker.values(Meaning::Time).unwrap();
    let (first, last) = (times[0], times[times.len() - 1]);
    for (share, by_s) in [(0.5, 0.02), (0.3, 0.012), (0.93, 0.05)] {
        let at_s = first + share * (last - first);
        let mut stepped = tracker.clone();
        let times = stepped.channels.iter_mut().filter(|c| c.meaning == Meaning::Time);
        times.for_each(|c| c.values.iter_mut().filter(|t| **t > at_s).for_each(|t| *t += by_s));
        let error = join(&robot, &controller, &stepped, &Options::default()).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("a clock that steps by about"), "{by_s}: {error}");
    }
}

/// Units, axes and order that are wrong are named, not called a motion that repeats.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn wrong_units_and_swapped_columns_are_named() {
    use lostmotion::log::columns::Meaning;
    let robot = robot();
    let load = |what: &str| {
        Recording::load(&samples().join(format!("{what}_2.csv.gz")), &robot, None, TopicChoice::Any).unwrap()
    };
    let (controller, tracker) = (load("controller"), load("tracker"));
    let scaled = |of: &Recording, factor: f64, which: &dyn Fn(Meaning) -> bool| {
        let mut of = of.clone();
        of.channels
            .iter_mut()
            .filter(|c| which(c.meaning))
            .for_each(|c| c.values.iter_mut().for_each(|v| *v *= factor));
        of
    };
    let swapped = |of: &Recording, a: Meaning, b: Meaning| {
        let mut of = of.clone();
        let at = |m: Meaning| of.channels.iter().position(|c| c.meaning == m).unwrap();
        let (i, j) = (at(a), at(b));
        (of.channels[i].meaning, of.channels[j].meaning) = (b, a);
        of
    };
    let place = |m: Meaning| matches!(m, Meaning::Position { .. });
    let command = |m: Meaning| matches!(m, Meaning::Command(_));
    let point = |coordinate| Meaning::Position { k: 0, coordinate };
    for (controller, tracker, says) in [
        (controller.clone(), scaled(&tracker, 1e-3, &place), "only if x, y and z are in metres"),
        (controller.clone(), swapped(&tracker, point(0), point(1)), "the measured frame is mirrored"),
        (scaled(&controller, 1f64.to_radians(), &command), tracker.clone(), "the commands are in radians"),
        (
            swapped(&controller, Meaning::Command(0), Meaning::Command(1)),
            tracker.clone(),
            "the commands of A1 and A2 are swapped",
        ),
    ] {
        let error = join(&robot, &controller, &tracker, &Options::default()).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(says), "{says}: {error}");
    }
}

/// Points of a recording of ROS 2 are in metres: millimetres there are a thousand times too large, and the entry says what the file has.
#[test]
fn millimetres_in_a_recording_of_ros_get_the_entry_for_millimetres() {
    use lostmotion::log::columns::Meaning;
    let robot = robot();
    let load = |what: &str| {
        Recording::load(&samples().join(format!("{what}_2.csv.gz")), &robot, None, TopicChoice::Any).unwrap()
    };
    let (controller, mut tracker) = (load("controller"), load("tracker"));
    tracker.is_si = true;
    let places = tracker.channels.iter_mut().filter(|c| matches!(c.meaning, Meaning::Position { .. }));
    places.for_each(|c| c.values.iter_mut().for_each(|v| *v *= 1e3));
    let error = join(&robot, &controller, &tracker, &Options::default()).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("`x: {to: x_mm, unit: mm}`") && !error.contains("unit: um"), "{error}");
}

/// Milliseconds read as seconds, and seconds read as milliseconds, by either file: the times are blamed, and nothing else.
#[test]
fn a_wrong_unit_of_time_is_named_and_no_unit_of_length() {
    use lostmotion::log::columns::Meaning;
    let robot = robot();
    let load = |what: &str| {
        Recording::load(&samples().join(format!("{what}_2.csv.gz")), &robot, None, TopicChoice::Any).unwrap()
    };
    let timed = |of: &Recording, factor: f64| {
        let mut of = of.clone();
        let times = of.channels.iter_mut().filter(|c| c.meaning == Meaning::Time);
        times.for_each(|c| c.values.iter_mut().for_each(|v| *v *= factor));
        of
    };
    let (controller, tracker) = (load("controller"), load("tracker"));
    for (ours, theirs, file, says) in [
        (timed(&controller, 1e3), tracker.clone(), "controller_2", "the times here are in milliseconds"),
        (controller.clone(), timed(&tracker, 1e6), "tracker_2", "the times here are in microseconds"),
        (controller.clone(), timed(&tracker, 1e-3), "tracker_2", "the times here are in seconds"),
    ] {
        let error = join(&robot, &ours, &theirs, &Options::default()).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(says) && error.contains(file) && !error.contains("x, y and z"), "{says}: {error}");
    }
}

#[test]
fn a_header_in_one_piece_names_its_separator_and_the_tracker_map_reads_it() {
    use lostmotion::log::columns::{ColumnMap, Meaning};
    let robot = robot();
    let parse = |text: &str, map: Option<&ColumnMap>| {
        let input = lostmotion::io::input::from_bytes("tracker.csv".into(), text.as_bytes().to_vec()).unwrap();
        Recording::parse(input, &robot, map, TopicChoice::Any)
    };
    let german = "Time [s];X [mm];Y [mm];Z [mm]\n0,00;1500,25;-2,5;30\n0,01;1500,5;-2,25;30,125\n";
    let error = parse(german, None).unwrap_err().to_string();
    assert!(error.contains("fields separated by `;`"), "{error}");
    let map = ColumnMap::load(Path::new("tracker")).unwrap();
    let english = german.replace(',', ".").replace(';', ",");
    for text in [german, english.as_str(), english.replace(',', "\t").as_str(), english.replace(',', ";").as_str()] {
        let read = parse(text, Some(&map)).unwrap();
        assert_eq!(read.values(Meaning::Time).unwrap(), [0.0, 0.01], "{text}");
        let points = read.positions_m();
        assert!((points[0].unwrap().x - 1.50025).abs() < 1e-12 && (points[1].unwrap().z - 0.030125).abs() < 1e-12);
    }
}

/// Offset within 0.3 ms always, intervals of 95 % that hold in 93 to 97 % of 400 recordings (`LOSTMOTION_JOIN_SEEDS=400`, a quarter of an
/// hour); of fewer, in a share that 95 % may give. Needs Python with numpy.
#[test]
#[ignore = "heavy: minutes of simulated recordings; LOSTMOTION_PYTHON names the interpreter"]
fn val_join_intervals_cover_as_often_as_they_say() {
    const BATCH: u32 = 20;
    let seeds: u32 = std::env::var("LOSTMOTION_JOIN_SEEDS").ok().map_or(40, |n| n.parse().expect("a number"));
    let python = std::env::var("LOSTMOTION_PYTHON").unwrap_or_else(|_| "python3".into());
    let mut worst = 0.0f64;
    // offset and drift, late samples and jittering stamps apart
    let (mut held, mut all) = ([[0u32; 2]; 2], [0u32; 2]);
    for first in (1..=seeds).step_by(BATCH as usize) {
        let work = WorkFolder::new();
        let swapped = (first / BATCH) % 2 == 1;
        let rates: [&str; 4] = if swapped {
            ["--tracker-hz", "50", "--controller-hz", "250"]
        } else {
            ["--tracker-hz", "250", "--controller-hz", "50"]
        };
        let made = std::process::Command::new(&python)
            .arg(bundled("tests/oracle/join.py"))
            .arg(work.path())
            .args(["--first", &first.to_string(), "--count", &BATCH.to_string()])
            .args(rates)
            .output()
            .expect("python runs");
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        for seed in first..first + BATCH {
            let report = joined(work.path(), seed, &Options::default()).report;
            let (offset_ms, drift_ppm) = truth(work.path(), seed, report.at_tracker_s);
            worst = worst.max((report.offset_ms.value - offset_ms).abs());
            let kind = (seed % 2) as usize;
            all[kind] += 1;
            for (k, (found, want)) in [(report.offset_ms, offset_ms), (report.drift_ppm, drift_ppm)].iter().enumerate()
            {
                held[kind][k] += u32::from((found.ci95[0]..=found.ci95[1]).contains(want));
            }
        }
    }
    println!("worst offset {worst:.4} ms; held {held:?} of {all:?} (late samples, jittering stamps; offset, drift)");
    assert!(worst < 0.3, "{worst} ms");
    let total = f64::from(all[0] + all[1]);
    // three standard deviations of a share of so few, or the target
    let margin = (3.0 * (0.95 * 0.05 / total).sqrt()).max(0.02);
    for k in 0..2 {
        let share = f64::from(held[0][k] + held[1][k]) / total;
        assert!((0.95 - share).abs() <= margin, "{}: {share}", ["offset", "drift"][k]);
    }
}

/// A program of `plan-experiment` at a pose (deg), run on a machine with gaps (joint, deg) and recorded twice: the tracker's clock is
/// behind by 7.25 s. Stamps to a ten-thousandth of a second, or to `stamp_decimals`.
struct Planned<'a> {
    kind: Kind,
    pose_deg: &'a [f64],
    gaps_deg: &'a [(usize, f64)],
    rate_hz: f64,
    stamp_decimals: usize,
    seed: u64,
}

const OFFSET_S: f64 = 7.25;

impl Planned<'_> {
    fn recorded(&self, robot: &Robot) -> (Recording, Recording) {
        let options = recording::Options {
            pose: Some(self.pose_deg.iter().map(|q| q.to_radians()).collect()),
            tracker_m: None,
            acceptance_rad: 30f64.to_radians(),
            instrument: Instrument::Tcp,
            bar_m: None,
            noise_m: 10e-6,
            rate_hz: self.rate_hz,
            speed_m_s: 50e-3,
            travel_rad: 20f64.to_radians(),
            travel_m: 0.15,
            duration_s: 60.0,
            dwell_s: 2.0,
            cycles: 1,
            places: 2,
        };
        let plan = recording::plan(robot, self.kind, &options).unwrap();
        let mut model = Model::ideal(robot.clone());
        for (axis, deg) in self.gaps_deg {
            let effect = Backlash::constant(deg.to_radians()).into();
            model.effects.push(EffectInstance { target: Target::Joint(*axis), effect });
        }
        let text = |name: &str, bytes: Vec<u8>| Input { name: name.into(), bytes, sha256: String::new() };
        let program = Program::parse(text("plan.csv", recording::document::program(&plan, robot)), robot).unwrap();
        let motion = Motion::of_program(&model, &program, program.t_s.as_ref().unwrap(), self.rate_hz).unwrap();
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(self.seed);
        let normal = Normal::new(0.0, 0.01).unwrap();
        let names: Vec<String> = robot.axis_joints().map(|j| format!("cmd_{}_deg", j.name)).collect();
        let (mut ours, mut theirs) = (format!("t_s,{}\n", names.join(",")), String::from("t_s,x_mm,y_mm,z_mm\n"));
        let d = self.stamp_decimals;
        for row in 0..motion.len() {
            let t = motion.trajectory.t_s()[row];
            let q: Vec<String> =
                (0..robot.dof()).map(|a| format!("{:.6}", motion.trajectory.command(a)[row].to_degrees())).collect();
            let _ = writeln!(ours, "{t:.d$},{}", q.join(","));
            let p = motion.point_m(0, row) * 1e3 + Vector3::from_fn(|_, _| normal.sample(&mut rng));
            let _ = writeln!(theirs, "{:.d$},{:.6},{:.6},{:.6}", t - OFFSET_S, p.x, p.y, p.z);
        }
        let parse =
            |name, bytes: String| Recording::parse(text(name, bytes.into()), robot, None, TopicChoice::Any).unwrap();
        (parse("controller.csv", ours), parse("tracker.csv", theirs))
    }

    /// The offset that was found, and half its interval, ms.
    fn joined(&self, robot: &Robot) -> (f64, f64) {
        let (controller, tracker) = self.recorded(robot);
        let report =
            join(robot, &controller, &tracker, &Options { near_s: Some(7.0), ..Options::default() }).unwrap().report;
        (report.offset_ms.value, 0.5 * (report.offset_ms.ci95[1] - report.offset_ms.ci95[0]))
    }
}

const FANUC_GAPS_DEG: [(usize, f64); 3] = [(0, 0.004), (1, 0.003), (2, 0.005)];

fn fanuc() -> Robot {
    Robot::load(&bundled("configs/fanuc-m10ia.yaml")).unwrap()
}

#[test]
fn a_planned_static_test_is_joined_though_joints_rest_until_their_turn() {
    // the reflector stands on the axis of J6, which moves last: nothing tells its gap, and its rest is no reason to leave out the others
    let pose_deg = [0.0, 0.0, 0.0, 0.0, -60.0, 0.0];
    for (rate_hz, stamp_decimals) in [(10.0, 4), (40.0, 3)] {
        let planned = Planned {
            kind: Kind::Static,
            pose_deg: &pose_deg,
            gaps_deg: &FANUC_GAPS_DEG,
            rate_hz,
            stamp_decimals,
            seed: 1,
        };
        let (offset_ms, half_ms) = planned.joined(&fanuc());
        assert!((offset_ms - 7250.0).abs() < (3.0 * half_ms).max(0.05), "{rate_hz} Hz: {offset_ms} +- {half_ms}");
        assert!(half_ms < 3.0, "{rate_hz} Hz: {half_ms}");
    }
}

#[test]
fn a_gap_of_a_sum_of_axes_does_not_move_the_clock() {
    let pose_deg = [10.0, 20.0, -10.0, 20.0, -50.0, 30.0];
    let planned = Planned {
        kind: Kind::Path,
        pose_deg: &pose_deg,
        gaps_deg: &FANUC_GAPS_DEG,
        rate_hz: 20.0,
        stamp_decimals: 4,
        seed: 2,
    };
    let (offset_ms, half_ms) = planned.joined(&fanuc());
    assert!((offset_ms - 7250.0).abs() < 3.0 * half_ms && half_ms < 1.0, "{offset_ms} +- {half_ms}");
}
