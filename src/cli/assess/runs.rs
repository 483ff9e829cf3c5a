//! A nominal program and the logs of its runs without and with compensation: arguments that subcommands share.

use crate::cli::paths::Named;
use crate::error;
use crate::log::Log;
use crate::program::Program;
use crate::robot::Robot;
use anyhow::Result;
use std::path::{Path, PathBuf};

// no doc comment: it would be printed as the help of the command
#[allow(missing_docs)]
#[derive(Debug, clap::Args)]
pub struct RunsArgs {
    /// Robot file (YAML)
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: PathBuf,
    /// Program before compensation (joint-space CSV)
    #[arg(long, value_name = "PROGRAM.csv")]
    pub nominal: PathBuf,
    /// Log of the run without compensation
    #[arg(long, value_name = "LOG.csv")]
    pub before: PathBuf,
    /// Log of the run with compensation
    #[arg(long, value_name = "LOG.csv")]
    pub after: Option<PathBuf>,
    /// Column map (YAML): translates other column names, units and separators of a log
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
}

/// What the arguments name.
pub struct Runs {
    pub robot: Robot,
    pub nominal: Program,
    pub before: Log,
    pub after: Option<Log>,
}

/// Reads logs by a column map, for a robot.
type Loader = fn(&[PathBuf], Option<&Path>, &Robot) -> Result<Vec<Log>>;

impl RunsArgs {
    /// The files that are read, each with its option.
    pub fn inputs(&self) -> [Named<'_>; 5] {
        [
            ("--robot", Some(self.robot.as_path())),
            ("--nominal", Some(self.nominal.as_path())),
            ("--before", Some(self.before.as_path())),
            ("--after", self.after.as_deref()),
            ("--columns", self.columns.as_deref()),
        ]
    }

    /// Reads the files; `logs` reads those of the runs.
    pub fn load(&self, logs: Loader) -> Result<Runs> {
        let robot = Robot::load(&self.robot)?;
        let nominal = Program::load(&self.nominal, &robot)?;
        let paths: Vec<PathBuf> = std::iter::once(&self.before).chain(&self.after).cloned().collect();
        let mut logs = logs(&paths, self.columns.as_deref(), &robot)?.into_iter();
        let before = logs.next().ok_or_else(|| error::Error::internal("read a log", "there is none"))?;
        Ok(Runs { robot, nominal, before, after: logs.next() })
    }
}
