//! Joint errors of a compensated run against the nominal program at the same place on the circle (Zhang (2023), Figure 13).
//!
//! A compensated log's own commands hold the offsets, so actual minus commanded shows the machine's lost motion again. What
//! counts is actual minus nominal. The place is the phase of the actual TCP on the nominal circle; the nominal joints there
//! come from the program's points by Catmull-Rom interpolation over the phase (1e-6 deg at 200 points a revolution). An
//! error along the path does not count.

use super::Nominal;
use crate::program::Program;
use crate::robot::Robot;
use nalgebra::Vector3;

/// Nominal joints over the phase of the circle.
#[derive(Debug, Clone)]
pub struct NominalJoints {
    phase_deg: Vec<f64>,
    /// `q[point][axis]`, rad or m.
    q: Vec<Vec<f64>>,
}

impl NominalJoints {
    /// Points of a program over their phase, which must rise or fall throughout.
    pub fn new(robot: &Robot, nominal: &Nominal, program: &Program) -> Self {
        let mut row = vec![0.0; robot.dof()];
        let q: Vec<Vec<f64>> = (0..program.len())
            .map(|i| {
                program.point_into(i, &mut row);
                row.clone()
            })
            .collect();
        let tcp: Vec<Vector3<f64>> = q.iter().map(|q| robot.tcp_m(q)).collect();
        Self { phase_deg: nominal.phases_deg(&tcp), q }
    }

    /// Joints of the first point.
    pub fn first(&self) -> &[f64] {
        self.q.first().map_or(&[], Vec::as_slice)
    }

    /// Nominal position of an axis at a phase; `None` outside the program.
    pub fn at(&self, axis: usize, phase_deg: f64) -> Option<f64> {
        let n = self.phase_deg.len();
        let i = self.phase_deg.partition_point(|p| *p <= phase_deg).checked_sub(1)?;
        if i + 1 >= n {
            return None;
        }
        let p = |k: usize| self.q[k.min(n - 1)][axis];
        let h = self.phase_deg[i + 1] - self.phase_deg[i];
        let s = (phase_deg - self.phase_deg[i]) / h;
        let (a, b, c, d) = (p(i.saturating_sub(1)), p(i), p(i + 1), p(i + 2));
        if i == 0 || i + 2 >= n {
            return Some(b + s * (c - b));
        }
        let (m0, m1) = ((c - a) / 2.0, (d - b) / 2.0);
        let (s2, s3) = (s * s, s * s * s);
        Some((2.0 * s3 - 3.0 * s2 + 1.0) * b + (s3 - 2.0 * s2 + s) * m0 + (3.0 * s2 - 2.0 * s3) * c + (s3 - s2) * m1)
    }
}
