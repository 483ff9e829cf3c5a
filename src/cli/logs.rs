//! Logs as commands read them: column map, reading side by side, hygiene before anything is computed.

use crate::error::Result;
use crate::log::{ColumnMap, Log, hygiene};
use crate::robot::Robot;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Reads the logs in order and refuses those whose units, axes or clocks cannot be right; notes go to standard error.
pub fn load(paths: &[PathBuf], columns: Option<&Path>, robot: &Robot) -> Result<Vec<Log>> {
    let map = columns.map(ColumnMap::load).transpose()?;
    let read = |path: &PathBuf| -> Result<(Log, Vec<String>)> {
        let log = Log::load_with(path, robot, map.as_ref())?;
        let notes = hygiene::check(&log, robot)?.notes;
        Ok((log, notes))
    };
    // the first file in order that is wrong is the one that is named
    let all: Vec<Result<(Log, Vec<String>)>> = paths.par_iter().map(read).collect();
    let mut logs = Vec::with_capacity(paths.len());
    for one in all {
        let (log, notes) = one?;
        for note in notes {
            eprintln!("note: {}: {note}", log.name);
        }
        logs.push(log);
    }
    Ok(logs)
}
