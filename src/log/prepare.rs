//! What every command does with a log before it computes anything: what the recorder did is taken back, what cannot be right is refused.

use super::Log;
use super::note::Note;
use super::plausibility::{self, Kinematics};
use super::{gross, held};
use crate::error::Result;
use crate::robot::Robot;

impl Log {
    /// Takes back held readings, refuses units, axes and clocks that cannot be right, and loses rows in gross error; notes for the user.
    ///
    /// # Errors
    /// Bad input, as [`plausibility::check_for`].
    pub fn prepare(&mut self, robot: &Robot, kinematics: Kinematics) -> Result<Vec<Note>> {
        let mut notes = held::undo(self);
        notes.extend(plausibility::check_for(self, robot, kinematics)?.notes);
        if kinematics == Kinematics::OfFile
            && let Some((rows, limit_m)) = gross::leave_out(self, robot)
        {
            notes.push(Note::GrossErrors { rows, limit_m });
        }
        Ok(notes)
    }
}
