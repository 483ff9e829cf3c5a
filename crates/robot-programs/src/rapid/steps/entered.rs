//! From where control comes to a procedure of which all calls stand in the program.

use super::Builder;

impl Builder<'_> {
    /// From where external axes come that the robot file does not have is not known at the start of a routine.
    pub fn enter_with_axes(&mut self, used: bool) {
        if std::mem::take(&mut self.entering) && used {
            self.steps.all_calls_are_here(false);
        }
    }

    /// A routine calls a procedure.
    pub(super) fn calls_here(&mut self, routine: usize, name: &str) {
        if self.calls_of.0 != routine {
            self.calls_of = (routine, Vec::new());
        }
        self.calls_of.1.push(name.to_string());
    }

    /// The handler of a routine runs what failed again: a call, from where that has led.
    pub(super) fn calls_again(&mut self, routine: usize) {
        if self.calls_of.0 == routine {
            std::mem::take(&mut self.calls_of.1).into_iter().for_each(|name| self.steps.called_otherwise(name));
        }
    }
}
