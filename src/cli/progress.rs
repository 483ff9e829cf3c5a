//! A line on the terminal while a command computes, so that one that takes long does not look dead.

use crate::cli::console;
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

const TICK: Duration = Duration::from_millis(200);

/// Shows what is under way and for how long; gone when it is dropped.
struct Busy(ProgressBar);

impl Busy {
    /// Starts the line; nothing where standard error is no terminal, or with `--quiet`.
    fn new(what: &str) -> Self {
        if !console::shows_progress() {
            return Self(ProgressBar::hidden());
        }
        let template = ProgressStyle::with_template("{spinner} {msg} {elapsed}");
        let bar = ProgressBar::new_spinner().with_style(template.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        bar.set_message(what.to_string());
        bar.enable_steady_tick(TICK);
        Self(bar)
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// Computes with a line on the terminal.
pub fn during<T>(what: &str, compute: impl FnOnce() -> T) -> T {
    let _busy = Busy::new(what);
    compute()
}
