//! Exceptions: `BadInput` (exit code 2 of the command line) and `Refused` (exit code 1), with the same words.

use lostmotion::error::Error;
use pyo3::prelude::*;
use pyo3::{create_exception, exceptions::PyException};

create_exception!(lostmotion, LostMotionError, PyException, "Any refusal of lostmotion.");
create_exception!(lostmotion, BadInput, LostMotionError, "Unusable input: what was found, where, what was expected.");
create_exception!(lostmotion, Refused, LostMotionError, "The request is well formed, and the answer is no.");

pub fn register(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("LostMotionError", m.py().get_type::<LostMotionError>())?;
    m.add("BadInput", m.py().get_type::<BadInput>())?;
    m.add("Refused", m.py().get_type::<Refused>())
}

pub fn raised(error: Error) -> PyErr {
    let words = error.to_string();
    match error {
        Error::Refused(_) => Refused::new_err(words),
        _ => BadInput::new_err(words),
    }
}

/// An error of a command, by its exit code.
pub fn of_exit(code: u8, words: String) -> PyErr {
    if code == 1 { Refused::new_err(words) } else { BadInput::new_err(words) }
}

pub fn refused(words: String) -> PyErr {
    Refused::new_err(words)
}

pub fn bad(found: impl Into<String>) -> PyErr {
    BadInput::new_err(found.into())
}
