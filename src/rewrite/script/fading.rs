//! Friction that fades in seconds, on moves whose speed is not known: their gaps alone are compensated, and a note says so.

use super::run::Run;
use super::task::Task;
use crate::compensator::Compensator;
use crate::error::counted;
use crate::program::script::Note;

/// The compensator for runs that have a clock, and the one for those that have none.
pub struct ByClock<'a> {
    clocked: &'a Compensator,
    /// `None`: nothing fades in seconds, or a speed is given for all.
    unclocked: Option<Compensator>,
}

impl<'a> ByClock<'a> {
    pub fn of(task: &Task<'a>) -> Self {
        let clocked = task.compensator;
        let needed = clocked.fades_in_seconds() && task.options.tcp_speed_m_s.is_none();
        Self { clocked, unclocked: needed.then(|| clocked.without_clock()) }
    }

    /// What a run gets.
    pub fn on(&self, run: &Run) -> &Compensator {
        self.unclocked.as_ref().filter(|_| run.untimed.is_some()).unwrap_or(self.clocked)
    }

    /// What was left out, at the first move without a speed.
    pub fn note(&self, runs: &[Run]) -> Option<Note> {
        self.unclocked.as_ref()?;
        let without = || runs.iter().filter(|r| r.untimed.is_some());
        let place = without().find_map(|r| r.untimed)?;
        let moves = without().map(|r| r.vertices.len()).sum();
        let text = format!(
            "the speed of this move cannot be determined, and friction fades in seconds: of {}, only the gaps are compensated (give a TCP speed to compensate the friction)",
            counted(moves, "move")
        );
        Some(Note { place, text })
    }
}
