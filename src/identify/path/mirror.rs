//! Positions of a mirrored frame: two columns swapped, or one negated.
//!
//! On a path in a plane a turn of the frame hides it from the plausibility checks of logs; only the lost motion normal to the plane then
//! has the wrong sign. Asked only of logs that the model does not describe, since it costs another fit.

use super::prepare::{Binned, rigid_transform};
use super::problem::Problem;
use super::select::{Selected, select};
use crate::effects::GapCurve;
use crate::error::{Error, Place, Result};

/// Sum of squares of the mirrored fit over that of the log as it is, below which the log is mirrored.
const BETTER: f64 = 0.25;

/// Refuses the first log that fits far better with one axis of the tracker's frame negated.
pub fn refuse(problem: &Problem, selected: &Selected, held: &[(usize, GapCurve)]) -> Result<()> {
    let several = problem.logs().len() > 1;
    for (l, log) in problem.logs().enumerate() {
        let plain = if several { alone(log.clone(), held) } else { fit_of(problem, l, selected) };
        let mut mirrored = log.clone();
        mirrored.xyz.iter_mut().for_each(|x| x.x = -x.x);
        mirrored.frame = rigid_transform(mirrored.xyz.iter().zip(&mirrored.want));
        let mirrored = alone(mirrored, held);
        if mirrored.cost < BETTER * plain.cost {
            let found = format!(
                "positions of a mirrored frame (with one axis negated, the residual of the fit falls from {:.1} um to {:.1} um)",
                plain.sigma_m * 1e6,
                mirrored.sigma_m * 1e6
            );
            return Err(Error::bad(Place::file(&log.name), found, "x, y, z of a right-handed frame, in this order"));
        }
    }
    Ok(())
}

/// Sum of squares in units of the log's noise, and what it says a coordinate of a row is off, m.
struct Fit {
    cost: f64,
    sigma_m: f64,
}

fn fit_of(problem: &Problem, log: usize, selected: &Selected) -> Fit {
    Fit { cost: selected.cost, sigma_m: (selected.cost / selected.dof).sqrt() / problem.scale(log) }
}

/// The fit of one log without the others.
fn alone(log: Binned, held: &[(usize, GapCurve)]) -> Fit {
    let mut problem = Problem::new(vec![log], held);
    let selected = select(&mut problem);
    fit_of(&problem, 0, &selected)
}
