//! Runs the built program on a case's folder.

use crate::case::Log;
use crate::files;
use crate::robots::Robot;
use nalgebra::Vector3;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// What `diagnose` said.
pub struct Diagnosed {
    pub document: Option<Value>,
    pub exit: i32,
    pub stderr: String,
    pub seconds: f64,
}

fn program() -> Command {
    // A built program may be named instead, so that a figure can be compared between builds.
    Command::new(std::env::var_os("LOSTMOTION_BIN").unwrap_or_else(|| env!("CARGO_BIN_EXE_lostmotion").into()))
}

pub fn run(folder: &Path, found: &Path) -> Diagnosed {
    let start = Instant::now();
    let mut command = program();
    command.arg("diagnose").arg("--json").arg("--model").arg(folder.join("model.yaml"));
    command.arg("--log").arg(folder.join("train.csv")).arg("--model-out").arg(found);
    let output = command.output().expect("the program starts");
    Diagnosed {
        document: serde_json::from_slice(&output.stdout).ok(),
        exit: output.status.code().unwrap_or(-1),
        stderr: String::from_utf8_lossy(&output.stderr).trim().to_string(),
        seconds: start.elapsed().as_secs_f64(),
    }
}

/// TCP (m) that the found model predicts for the second log; none where it cannot.
pub fn predict(found: &Path, test: &Path, robot: &Robot, work: &Path) -> Option<Vec<Vector3<f64>>> {
    let predicted = work.join("predicted.csv");
    let mut command = program();
    command.arg("simulate").arg("--model").arg(found).arg("--input").arg(test).arg("--output").arg(&predicted);
    command.output().ok().filter(|o| o.status.success())?;
    let log: Log = files::read_log(&predicted, robot);
    log.tcp_mm.iter().map(|p| p.map(|p| Vector3::from(p) * 1e-3)).collect()
}
