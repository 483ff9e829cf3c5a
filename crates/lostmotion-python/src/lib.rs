//! The module `lostmotion._native`: the engine with numpy arrays; `python/lostmotion` dresses its results.
//!
//! Files: `errors` (exceptions with the words of the command line), `arrays` (numpy and back, degrees and millimetres at the edge),
//! `robot`, `log`, `jobs` (identify, fit, rewrite, simulate, diagnose, join), `command` (the command line in this process).

mod arrays;
mod command;
mod errors;
mod jobs;
mod log;
mod robot;

use pyo3::prelude::*;

#[pymodule]
fn _native(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    lostmotion::io::notice::handle_with(lostmotion::cli::console::print);
    errors::register(m)?;
    m.add_class::<robot::Robot>()?;
    m.add_class::<log::Log>()?;
    m.add_class::<jobs::Gaps>()?;
    m.add_class::<jobs::Compensator>()?;
    m.add_function(wrap_pyfunction!(jobs::identify, m)?)?;
    m.add_function(wrap_pyfunction!(jobs::fit, m)?)?;
    m.add_function(wrap_pyfunction!(jobs::rewrite, m)?)?;
    m.add_function(wrap_pyfunction!(jobs::simulate, m)?)?;
    m.add_function(wrap_pyfunction!(jobs::diagnose, m)?)?;
    m.add_function(wrap_pyfunction!(jobs::join, m)?)?;
    m.add_function(wrap_pyfunction!(command::main, m)?)?;
    m.add_function(wrap_pyfunction!(command::run, m)?)?;
    Ok(())
}
