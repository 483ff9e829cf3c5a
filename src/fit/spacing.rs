//! How far apart the points of a program are: the median TCP distance between points that differ.
//!
//! Only for equation 17, which counts points: a program of mixed spacing has no such number, which is refused where the middle
//! half of the distances spreads by more than [`EVEN`].

use crate::error::{Error, Place, Result};
use crate::program::Program;
use crate::robot::Robot;
use std::path::Path;

/// Upper over lower quartile of the distances up to which a program counts as evenly spaced.
const EVEN: f64 = 1.5;

/// Median TCP distance between the points of a program, m.
pub fn of_program(path: &Path, robot: &Robot) -> Result<f64> {
    let program = Program::load(path, robot)?;
    let name = &program.name;
    let mut q = vec![0.0; robot.dof()];
    let points: Vec<_> = (0..program.len())
        .map(|i| {
            program.point_into(i, &mut q);
            robot.tcp_m(&q)
        })
        .collect();
    let mut distances: Vec<f64> = points.windows(2).map(|w| (w[1] - w[0]).norm()).filter(|d| *d > 1e-9).collect();
    if distances.is_empty() {
        return Err(Error::bad(Place::file(name), "a program that does not move", "two points or more that differ"));
    }
    distances.sort_by(f64::total_cmp);
    let at = |share: f64| distances[((distances.len() - 1) as f64 * share) as usize];
    if at(0.75) > EVEN * at(0.25) {
        return Err(Error::bad(
            Place::file(name),
            format!("points {:.2} to {:.2} mm apart (middle half)", at(0.25) * 1e3, at(0.75) * 1e3),
            "points of one spacing, as equation 17 counts points; or a decay over time",
        )
        .mended_by(&["form"]));
    }
    Ok(at(0.5))
}
