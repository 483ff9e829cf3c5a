//! A signal (interrupt, hang-up, termination) ends the process once no output is partly in place, and leaves no temporary file.
//!
//! While outputs come into place ([`interrupt`]) the signal waits: that takes a few renames. The exit code is the shell's, 128 and
//! the number of the signal (130, 129, 143). A signal that was ignored when the process began (`nohup`) stays ignored.

use crate::io::interrupt;

fn end(code: i32) {
    interrupt::end(|| std::process::exit(code));
}

/// Starts to listen. Without a thread for it a signal leaves temporary files; that is no reason not to run.
#[cfg(unix)]
pub fn listen() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let wanted: Vec<i32> = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|s| !is_ignored(*s)).collect();
    // on the thread itself: where there is none, signals do what they always do
    let _ = std::thread::Builder::new().name("signals".into()).spawn(move || {
        let Ok(mut signals) = signal_hook::iterator::Signals::new(&wanted) else { return };
        if let Some(signal) = signals.forever().next() {
            end(128 + signal);
        }
    });
}

#[cfg(not(unix))]
pub fn listen() {
    let _ = ctrlc::set_handler(|| end(130));
}

/// Whether the process was started with a signal ignored, where the system reports it.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else { return false };
    let mask = status.lines().find_map(|l| l.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|m| u64::from_str_radix(m.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}
