//! numpy arrays and the columns of the engine: degrees and millimetres outside, radians and metres inside.

use crate::errors::bad;
use lostmotion::robot::Robot;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

/// Row after row in SI, checked: one column per axis, finite.
pub fn joints(robot: &Robot, q: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<f64>> {
    let view = q.as_array();
    if view.ncols() != robot.dof() {
        let names = robot.axis_names().join(", ");
        return Err(bad(format!("an array of {} columns; expected {}: {names}", view.ncols(), robot.dof())));
    }
    let si: Vec<f64> = robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect();
    let mut out = Vec::with_capacity(view.len());
    for (row, values) in view.rows().into_iter().enumerate() {
        for (value, si) in values.iter().zip(&si) {
            if !value.is_finite() {
                return Err(bad(format!("{value} in row {row}; expected finite joint positions")));
            }
            out.push(value * si);
        }
    }
    Ok(out)
}

/// Rows of joint positions in deg or mm.
pub fn joints_out<'py>(py: Python<'py>, robot: &Robot, rows: &[f64]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let n = robot.dof();
    let si: Vec<f64> = robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect();
    let values: Vec<f64> = rows.iter().enumerate().map(|(i, v)| v / si[i % n]).collect();
    shaped(py, values, n)
}

/// A flat vector as rows of `columns`.
pub fn shaped(py: Python<'_>, values: Vec<f64>, columns: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    use numpy::PyArrayMethods;
    let rows = values.len() / columns.max(1);
    values.into_pyarray(py).reshape([rows, columns])
}
