//! Logs as commands read them: column map, reading side by side, plausibility checks before anything is computed.

use crate::cli::columns;
use crate::cli::exit::bad;
use crate::error::{self, Place};
use crate::log::plausibility::Kinematics;
use crate::log::{ColumnMap, Log, Note};
use crate::numerics::parallel::ParMap;
use crate::robot::Robot;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Reads the logs in order and refuses those whose units, axes or clocks cannot be right; notes go to standard error.
pub fn load(paths: &[PathBuf], columns: Option<&Path>, robot: &Robot) -> Result<Vec<Log>> {
    load_by(Log::load_with, Kinematics::OfFile, paths, columns, robot)
}

/// The same for machines whose kinematics need not be that of the robot file.
pub fn load_free(paths: &[PathBuf], columns: Option<&Path>, robot: &Robot) -> Result<Vec<Log>> {
    load_by(Log::load_with, Kinematics::Unknown, paths, columns, robot)
}

/// The same for logs in which coordinates of the TCP may be missing.
pub fn load_lone(paths: &[PathBuf], columns: Option<&Path>, robot: &Robot) -> Result<Vec<Log>> {
    load_by(Log::load_lone, Kinematics::OfFile, paths, columns, robot)
}

fn load_by(
    load: fn(&Path, &Robot, Option<&ColumnMap>) -> error::Result<Log>,
    kinematics: Kinematics,
    paths: &[PathBuf],
    columns_file: Option<&Path>,
    robot: &Robot,
) -> Result<Vec<Log>> {
    let map = columns_file.map(ColumnMap::load).transpose()?;
    let read = |path: &PathBuf| -> Result<(Log, Vec<Note>)> {
        let hinted = |e| columns::with_hint(e, path, columns_file, robot, "--columns");
        let mut log = load(path, robot, map.as_ref()).map_err(hinted)?;
        let notes = log.prepare(robot, kinematics)?;
        Ok((log, notes))
    };
    // the first file in order that is wrong is the one that is named
    let all: Vec<Result<(Log, Vec<Note>)>> = paths.par_map(read);
    // nothing is printed of the good ones before all are known to be good
    let all = all.into_iter().collect::<Result<Vec<_>>>()?;
    let mut logs = Vec::with_capacity(paths.len());
    for (log, notes) in all {
        for note in notes {
            eprintln!("note: {}: {note}", log.name);
        }
        logs.push(log);
    }
    Ok(logs)
}

/// Refuses a log that is given twice: counted twice, it would seem to know twice as much.
pub fn refuse_repeats(logs: &[Log]) -> Result<()> {
    let alike = |a: &Log, b: &Log| {
        (&a.t_s, &a.cmd, &a.tcp_m, &a.reflectors_m) == (&b.t_s, &b.cmd, &b.tcp_m, &b.reflectors_m)
            && (&a.enc, &a.meas, &a.screw, &a.instruments) == (&b.enc, &b.meas, &b.screw, &b.instruments)
    };
    for (i, log) in logs.iter().enumerate() {
        // packed or not, under whatever name
        let same = |l: &&Log| l.sha256 == log.sha256 || alike(l, log);
        if let Some(first) = logs[..i].iter().find(same) {
            let found = format!("the same log as {}", first.name);
            return Err(bad(Place::file(&log.name), found, "every log once"));
        }
    }
    Ok(())
}
