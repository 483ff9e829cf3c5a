//! `Log`: a measurement log, from a file or from arrays.

use crate::arrays::{joints, joints_out, shaped};
use crate::errors::{bad, raised};
use crate::robot::Robot;
use lostmotion::log::{self, ColumnMap, Instruments, plausibility};
use nalgebra::Vector3;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

#[pyclass(frozen, module = "lostmotion")]
pub struct Log {
    pub inner: log::Log,
    pub robot: Arc<lostmotion::robot::Robot>,
}

#[pymethods]
impl Log {
    /// Reads a log and refuses units, axes and clocks that cannot be right.
    #[staticmethod]
    #[pyo3(signature = (path, robot, columns = None, check = true))]
    fn load(py: Python<'_>, path: PathBuf, robot: &Robot, columns: Option<PathBuf>, check: bool) -> PyResult<Self> {
        let map = columns.as_deref().map(ColumnMap::load).transpose().map_err(raised)?;
        let of = &robot.inner;
        let mut inner = py.detach(|| log::Log::load_with(&path, of, map.as_ref())).map_err(raised)?;
        if check {
            inner.prepare(of, plausibility::Kinematics::OfFile).map_err(raised)?;
        }
        Ok(Self { inner, robot: Arc::new(of.clone()) })
    }

    /// A log of arrays: times in s (or none: settled poses), commands, TCP in mm with NaN where nothing was seen.
    #[staticmethod]
    #[pyo3(signature = (robot, commands, tcp_mm, t_s = None, check = true))]
    fn from_arrays(
        robot: &Robot,
        commands: PyReadonlyArray2<'_, f64>,
        tcp_mm: PyReadonlyArray2<'_, f64>,
        t_s: Option<PyReadonlyArray1<'_, f64>>,
        check: bool,
    ) -> PyResult<Self> {
        let of = &robot.inner;
        let q = joints(of, &commands)?;
        let rows = q.len() / of.dof();
        let tcp = tcp_mm.as_array();
        if tcp.nrows() != rows || tcp.ncols() != 3 {
            return Err(bad(format!("tcp_mm of shape {:?}; expected ({rows}, 3)", tcp.shape())));
        }
        let times = t_s.map(|t| t.as_array().to_vec());
        if let Some(t) = &times
            && (t.len() != rows || t.windows(2).any(|w| w[1].partial_cmp(&w[0]) != Some(std::cmp::Ordering::Greater)))
        {
            return Err(bad(format!("t_s; expected {rows} times that strictly increase")));
        }
        let points = tcp.rows().into_iter().map(|r| Vector3::new(r[0], r[1], r[2]) * 1e-3);
        let n = of.dof();
        let mut inner = log::Log {
            name: "arrays".into(),
            sha256: String::new(),
            line: (0..rows as u32).collect(),
            poses: times.is_none(),
            t_s: times.unwrap_or_else(|| (0..rows).map(|i| i as f64).collect()),
            cmd: (0..n).map(|a| q.iter().skip(a).step_by(n).copied().collect()).collect(),
            cmd_decimals: vec![9; n],
            tcp_m: points.map(|p| Some(p).filter(|p| p.iter().all(|v| v.is_finite()))).collect(),
            lone_m: [None, None, None],
            reflectors_m: Vec::new(),
            enc: vec![None; n],
            screw: vec![None; n],
            meas: vec![None; n],
            trigger: None,
            cycle: None,
            speed_m_s: None,
            payload_kg: None,
            temp_c: None,
            instruments: Instruments::default(),
        };
        if check {
            inner.prepare(of, plausibility::Kinematics::OfFile).map_err(raised)?;
        }
        Ok(Self { inner, robot: Arc::new(of.clone()) })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    #[getter]
    fn sha256(&self) -> &str {
        &self.inner.sha256
    }

    #[getter]
    fn t_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.inner.t_s.clone().into_pyarray(py)
    }

    /// Commands, one row a sample, one column an axis, deg or mm.
    #[getter]
    fn commands<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.inner.cmd.len();
        let rows: Vec<f64> = (0..self.inner.len())
            .flat_map(|i| (0..n).map(move |a| (i, a)))
            .map(|(i, a)| self.inner.cmd[a][i])
            .collect();
        joints_out(py, &self.robot, &rows)
    }

    /// Measured TCP, mm; NaN where the tracker saw nothing.
    #[getter]
    fn tcp_mm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let values = self.inner.tcp_m.iter().flat_map(|p| p.map_or([f64::NAN; 3], |p| (p * 1e3).into())).collect();
        shaped(py, values, 3)
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    fn __repr__(&self) -> String {
        format!("<lostmotion.Log {:?}, {} rows>", self.inner.name, self.inner.len())
    }
}
