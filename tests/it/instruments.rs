//! `identify` over logs with one reading a row, alone and beside those of a tracker.
//!
//! The readings are made of what a tracker measured on machines of an independent simulator (`tests/data/machines`): distances from a
//! point in its frame, and components along a direction. So they hold all of the tracker's noise, which a ballbar has not.

use crate::support::{self, WorkFolder, bundled};
use lostmotion::compensator::Compensator;
use lostmotion::gaps::Gaps;
use lostmotion::log::Log;
use lostmotion::robot::Robot;
use nalgebra::Vector3;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A machine, and a folder for what is made of it.
struct Bench {
    desk: WorkFolder,
    source: PathBuf,
    robot: Robot,
}

/// What is read of a point in the tracker's frame, m; its column, and the column's unit, m.
type Reading<'a> = (&'a str, f64, &'a dyn Fn(&Vector3<f64>) -> f64);

impl Bench {
    fn new(machine: &str) -> Self {
        let source = bundled("tests/data/machines").join(machine);
        let robot = Robot::load(&source.join("robot.yaml")).unwrap();
        Self { desk: WorkFolder::new(), source, robot }
    }

    fn at(&self, name: &str) -> String {
        self.desk.join(name).display().to_string()
    }

    fn of(&self, name: &str) -> String {
        self.source.join(name).display().to_string()
    }

    fn log(&self, name: &str) -> Log {
        Log::load(&self.source.join(name), &self.robot).unwrap()
    }

    fn statics(&self) -> Vec<String> {
        self.robot.axis_names().iter().take(3).map(|n| self.of(&format!("static_{n}.csv.gz"))).collect()
    }

    /// A log of single readings instead of the TCP.
    fn read(&self, log: &Log, name: &str, (column, unit_m, reading): Reading) -> String {
        let mut text = String::from("t_s");
        for j in self.robot.axis_joints() {
            let _ = write!(text, ",cmd_{}_{}", j.name, j.kind.unit());
        }
        let _ = writeln!(text, ",{column}");
        for row in 0..log.len() {
            let _ = write!(text, "{:.4}", log.t_s[row]);
            for (a, j) in self.robot.axis_joints().enumerate() {
                let _ = write!(text, ",{:.6}", j.kind.to_user_unit(log.cmd[a][row]));
            }
            let _ = match log.tcp_m[row] {
                Some(p) => writeln!(text, ",{:.4}", reading(&p) / unit_m),
                None => writeln!(text, ","),
            };
        }
        std::fs::write(self.desk.join(name), text).unwrap();
        self.at(name)
    }

    /// The document and what was said.
    fn identify(&self, logs: &[String], options: &[&str]) -> (Gaps, String) {
        let (robot, output) = (self.of("robot.yaml"), self.at("machine.yaml"));
        let mut command = support::command();
        command.args(["identify", "--robot", &robot, "--output", &output]).args(options);
        logs.iter().for_each(|l| {
            command.args(["--log", l]);
        });
        let run = command.output().unwrap();
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(run.status.success(), "{said}");
        (Gaps::load(Path::new(&output), &self.robot).unwrap(), said)
    }

    fn fit(&self) -> Compensator {
        let (robot, gaps, output) = (self.of("robot.yaml"), self.at("machine.yaml"), self.at("c.yaml"));
        let mut command = support::command();
        command.args(["fit", "--robot", &robot, "--gaps", &gaps, "--output", &output]).assert().success();
        Compensator::load(Path::new(&output), &self.robot).unwrap()
    }
}

/// Gap and wind-up together, and half the width of the gap's interval.
fn lost(gaps: &Gaps, axis: usize) -> (f64, f64) {
    let gap = gaps.joints.iter().find(|j| j.axis == axis).unwrap();
    let estimate = gaps.estimate.as_ref().unwrap().joints.iter().find(|j| j.axis == axis).unwrap();
    (gap.half_gap + estimate.response.windup(), 0.5 * (gap.ci95[1] - gap.ci95[0]))
}

/// A joint's lost motion by single readings within both intervals of that by a tracker, and within a fifth where it is compensated; below 3
/// um an offset that leaves less than there was is enough.
fn agrees(name: &str, (want, known): (f64, f64), (is, also): (f64, f64), compensated: bool) {
    let off = (is - want).abs();
    assert!(
        off < known.hypot(also) && (!compensated || off < 0.2 * want || (want < 3e-6 && off < want)),
        "{name}: {is:e} for {want:e}, +-{also:e}"
    );
}

/// Distances from a point near the middle of a path.
fn distances(log: &Log) -> impl Fn(&Vector3<f64>) -> f64 + use<> {
    let seen: Vec<Vector3<f64>> = log.tcp_m.iter().copied().flatten().collect();
    let centre = seen.iter().sum::<Vector3<f64>>() / seen.len() as f64 + Vector3::new(0.7e-3, -0.4e-3, 0.3e-3);
    move |p| (p - centre).norm()
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn val_dwells_by_a_tracker_and_a_circle_by_a_ballbar_make_one_document() {
    for machine in ["gantry", "arm"] {
        let bench = Bench::new(machine);
        let circle = bench.log("circle.csv.gz");
        let distance = distances(&circle);
        let bar = bench.read(&circle, "bar.csv", ("r_um", 1e-6, &|p| distance(p) - 0.1));
        let by_tracker = [bench.statics(), vec![bench.of("circle.csv.gz")]].concat();
        let (whole, _) = bench.identify(&by_tracker, &[]);
        let (mixed, said) = bench.identify(&[bench.statics(), vec![bar]].concat(), &[]);
        assert!(said.contains("bar.csv: centre of the ballbar estimated at"), "{said}");
        let compensator = bench.fit();
        let mut used = 0;
        for j in &mixed.estimate.as_ref().unwrap().joints {
            let name = &bench.robot.axis(j.axis).name;
            agrees(name, lost(&whole, j.axis), lost(&mixed, j.axis), j.trust.compensate);
            assert_eq!(compensator.on(j.axis).is_some(), j.trust.compensate, "{name}: {said}");
            used += usize::from(j.trust.compensate);
        }
        assert!(used >= 2, "{machine}: {said}");
    }
}

#[test]
fn val_a_ballbar_alone_tells_the_joints_that_its_circle_turns() {
    let bench = Bench::new("gantry");
    let circle = bench.log("circle.csv.gz");
    let (whole, _) = bench.identify(&[bench.statics(), vec![bench.of("circle.csv.gz")]].concat(), &[]);
    let distance = distances(&circle);
    // whole distances, and differences to a length that is not known, say the same
    let whole_mm = bench.read(&circle, "whole.csv", ("r_mm", 1e-3, &|p| distance(p)));
    let off_um = bench.read(&circle, "off.csv", ("r_um", 1e-6, &|p| distance(p) - 0.1));
    for log in [whole_mm, off_um] {
        let (found, said) = bench.identify(&[log], &[]);
        assert!(!found.joints.is_empty(), "{said}");
        for j in &found.estimate.as_ref().unwrap().joints {
            let name = &bench.robot.axis(j.axis).name;
            agrees(name, lost(&whole, j.axis), lost(&found, j.axis), j.trust.compensate);
        }
    }
}

#[test]
fn a_dial_tells_nothing_of_a_joint_that_moves_across_it() {
    let bench = Bench::new("gantry");
    let excitation = bench.log("excitation.csv.gz");
    let (whole, _) = bench.identify(&[bench.of("circle.csv.gz"), bench.of("excitation.csv.gz")], &[]);
    let frame = whole.registration.as_ref().unwrap().frame;
    let mut columns = vec![Vector3::zeros(); 3];
    bench.robot.chain().position_and_jacobian(&[0.5, 0.4, -0.2], &mut columns);
    let along = columns[0].normalize();
    let in_tracker = frame * along;
    let dial = bench.read(&excitation, "dial.csv", ("dial_um", 1e-6, &|p| in_tracker.dot(p)));
    let direction = format!("{},{},{}", along.x, along.y, along.z);
    let (found, said) = bench.identify(std::slice::from_ref(&dial), &["--direction", &direction]);
    assert_eq!(found.joints.iter().map(|j| j.axis).collect::<Vec<_>>(), [0], "{said}");
    for name in &bench.robot.axis_names()[1..] {
        assert!(said.contains(&format!("{name}: not determined by these readings")), "{said}");
    }
    agrees("X", lost(&whole, 0), lost(&found, 0), true);
    // without its direction a dial says nothing
    let (robot, output) = (bench.of("robot.yaml"), bench.at("none.yaml"));
    let mut command = support::command();
    let run = command.args(["identify", "--robot", &robot, "--log", &dial, "--output", &output]).output().unwrap();
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(!run.status.success() && said.contains("`dial_um` without its direction"), "{said}");
}
