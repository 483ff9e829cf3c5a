//! Wall time of the way of a program through `rewrite`, CSV to CSV.
//!
//!   cargo bench --bench rewrite -- [PROGRAM.csv OUT.csv]
//!
//! Without arguments a program of 200,000 points is made. Three stages are timed: one that changes nothing (reading,
//! parsing, copying), one that changes every number (parsing and printing, no mathematics), and the engine.

use lostmotion::compensator::{BacklashOffset, Compensator, Evidence, JointCompensator};
use lostmotion::effects::GapCurve;
use lostmotion::error::{Error, Result};
use lostmotion::io::output::Durability;
use lostmotion::program::csv::Style;
use lostmotion::rewrite::sink;
use lostmotion::rewrite::stream::{Passage, Stage, pass};
use lostmotion::rewrite::{Engine, Options, Origin, OutputPoints, Points, RewriteStats};
use lostmotion::robot::Robot;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Adds the same to every number.
struct Shift {
    by: f64,
    next: u64,
}

impl Stage for Shift {
    fn push(&mut self, block: &Points, out: &mut OutputPoints) -> Result<()> {
        out.axes = block.axes;
        out.q.extend(block.q.iter().map(|v| v + self.by));
        out.t_s.extend_from_slice(&block.t_s);
        out.origin.extend((self.next..).take(block.len()).map(Origin::Point));
        self.next += block.len() as u64;
        Ok(())
    }

    fn finish(self, _: &mut OutputPoints) -> Result<RewriteStats> {
        Ok(RewriteStats::default())
    }
}

fn robot() -> Result<Robot> {
    Robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/kuka-kr120-r2500-pro.yaml"))
}

/// Half gaps of Zhang (2023) Table 3, deg, on the first three axes.
fn compensator(robot: &Robot) -> Compensator {
    let joints = [0.0028_f64, 0.0037, 0.0022].iter().enumerate().map(|(axis, half_gap)| {
        let gap = GapCurve::Constant(half_gap.to_radians());
        let backlash = Some(BacklashOffset { positive: gap.clone(), negative: gap });
        JointCompensator { axis, backlash, friction: None }
    });
    Compensator {
        robot_name: robot.name.clone(),
        robot_sha256: robot.fingerprint(),
        joints: joints.collect(),
        evidence: Evidence::default(),
    }
}

fn made(folder: &Path) -> Result<PathBuf> {
    let mut text = String::from("a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n");
    let (centre, swing) = ([0.0, -75.0, 90.0, 0.0, 20.0, 0.0], [40.0, 25.0, 30.0, 90.0, 60.0, 120.0]);
    for i in 0..200_000 {
        for j in 0..6 {
            let phase = f64::from(i) / (64.0 * (1.0 + 0.37 * j as f64)) + 0.9 * j as f64;
            let _ = write!(text, "{:.4}{}", centre[j] + swing[j] * 0.9 * phase.sin(), if j < 5 { ',' } else { '\n' });
        }
    }
    let path = folder.join("program.csv");
    std::fs::write(&path, text).map_err(|e| Error::io(&path, "write", e))?;
    Ok(path)
}

fn timed<E: Stage>(
    what: &str,
    robot: &Robot,
    input: &Path,
    output: &Path,
    make: impl FnOnce() -> Result<E>,
) -> Result<()> {
    let start = Instant::now();
    let passage = Passage { style: Style { forced: None, least: vec![4; robot.dof()] }, threads: true, hash: false };
    let reader = lostmotion::program::open_rows(input, robot)?;
    let done = pass(robot, reader, &passage, |_| make(), sink::File::create(output, Durability::Synced)?, &|_| {})?;
    done.sink.into_output().commit()?;
    let s = start.elapsed().as_secs_f64();
    println!("{what:<28} {:>10} points {s:>8.3} s {:>8.1} ns a point", done.points, s * 1e9 / done.points as f64);
    Ok(())
}

fn main() -> Result<()> {
    let args: Vec<PathBuf> = std::env::args_os().skip(1).filter(|a| a != "--bench").map(PathBuf::from).collect();
    let folder = tempfile::tempdir().map_err(|e| Error::io("temporary folder", "make", e))?;
    let (input, output) = match args.as_slice() {
        [input, output] => (input.clone(), output.clone()),
        _ => (made(folder.path())?, folder.path().join("out.csv")),
    };
    let robot = robot()?;
    let compensator = compensator(&robot);
    for _ in 0..3 {
        timed("nothing changed", &robot, &input, &output, || Ok(Shift { by: 0.0, next: 0 }))?;
        timed("every number changed", &robot, &input, &output, || Ok(Shift { by: 5e-5, next: 0 }))?;
        timed("engine, constant gaps", &robot, &input, &output, || {
            Engine::new(&robot, &compensator, Options::new(robot.dof()))
        })?;
    }
    Ok(())
}
