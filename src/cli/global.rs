//! Options that every command takes.

use crate::cli::console::{self, Words, detail};
use crate::error::counted;
use crate::io::threads;
use clap::ColorChoice;
use std::num::NonZeroUsize;
use std::time::Duration;

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Options of every command")]
pub struct Args {
    /// Print only errors and refusals on standard error
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print also the files read, the time taken and the memory used
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// When to colour help and error messages; auto: on a terminal, unless NO_COLOR is set
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    pub color: ColorChoice,
    /// Number of threads [default: number of processors]; the result does not depend on it
    #[arg(short, long, global = true, value_name = "N", value_parser = jobs)]
    pub jobs: Option<NonZeroUsize>,
}

impl Args {
    /// Sets what holds for the whole process.
    pub(super) fn apply(&self) {
        console::choose(match (self.quiet, self.verbose) {
            (true, _) => Words::Errors,
            (_, true) => Words::Details,
            _ => Words::Notes,
        });
        threads::prepare(self.jobs);
        let threads = counted(rayon::current_num_threads(), "thread");
        detail(format_args!("lostmotion {}, {threads}", env!("CARGO_PKG_VERSION")));
    }
}

/// Most threads that `--jobs` may ask for: far more than processors help nothing, and may bring a machine to a halt.
const MOST_JOBS: usize = 1024;

/// `--jobs`: a whole number from 1 to [`MOST_JOBS`].
fn jobs(text: &str) -> Result<NonZeroUsize, String> {
    let number: Option<NonZeroUsize> = text.parse().ok();
    number
        .filter(|n| n.get() <= MOST_JOBS)
        .ok_or_else(|| format!("a number of threads is a whole number from 1 to {MOST_JOBS}"))
}

/// The choice of `--color` as the words of a command line give it, for messages about a command line that cannot be parsed.
pub fn color_of(words: impl Iterator<Item = std::ffi::OsString>) -> ColorChoice {
    let words: Vec<String> = words.map(|w| w.to_string_lossy().into_owned()).collect();
    let joined = words.iter().find_map(|w| w.strip_prefix("--color="));
    let apart = words.windows(2).find(|w| w[0] == "--color").map(|w| w[1].as_str());
    joined.or(apart).and_then(|w| clap::ValueEnum::from_str(w, false).ok()).unwrap_or(ColorChoice::Auto)
}

/// Prints the time and the memory that a command took, with `--verbose`.
pub(super) fn print_cost(elapsed: Duration) {
    match most_memory_mb() {
        Some(mb) => detail(format_args!("{:.2} s, at most {mb} MB of memory", elapsed.as_secs_f64())),
        None => detail(format_args!("{:.2} s", elapsed.as_secs_f64())),
    }
}

/// The most memory that this process has held, where the system tells.
fn most_memory_mb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kb| kb / 1000)
}
