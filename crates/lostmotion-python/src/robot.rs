//! `Robot`: a robot file, or one made of a URDF.

use crate::arrays::{joints, shaped};
use crate::errors::raised;
use lostmotion::robot::{self, plausible, urdf};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;

#[pyclass(frozen, module = "lostmotion")]
pub struct Robot {
    pub inner: robot::Robot,
}

#[pymethods]
impl Robot {
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self { inner: robot::Robot::load(&path).map_err(raised)? })
    }

    #[staticmethod]
    fn parse(text: &str) -> PyResult<Self> {
        Ok(Self { inner: robot::Robot::parse("robot", text).map_err(raised)? })
    }

    #[staticmethod]
    #[pyo3(signature = (path, tip = None))]
    fn from_urdf(path: PathBuf, tip: Option<&str>) -> PyResult<Self> {
        let (text, input) = lostmotion::io::input::read_text(&path).map_err(raised)?;
        Ok(Self { inner: urdf::read(&input.name, &text, tip).map_err(raised)?.robot })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    #[getter]
    fn axes(&self) -> Vec<String> {
        self.inner.axis_names().into_iter().map(String::from).collect()
    }

    /// `deg` or `mm` of each axis.
    #[getter]
    fn units(&self) -> Vec<&'static str> {
        self.inner.axis_joints().map(|j| j.kind.unit()).collect()
    }

    #[getter]
    fn sha256(&self) -> String {
        self.inner.fingerprint()
    }

    /// Lower and upper limit of each axis; NaN where the file has none.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let edge = |j: &robot::Joint| {
            j.limits.map_or([f64::NAN; 2], |[lo, hi]| [lo / j.kind.si_per_user_unit(), hi / j.kind.si_per_user_unit()])
        };
        shaped(py, self.inner.axis_joints().flat_map(edge).collect(), 2)
    }

    fn to_yaml(&self) -> PyResult<String> {
        self.inner.to_yaml().map_err(raised)
    }

    /// What is odd about the numbers: `(is a fault, what)`.
    fn findings(&self) -> Vec<(bool, String)> {
        plausible::findings(&self.inner).iter().map(|f| (f.is_fault(), format!("{f:?}"))).collect()
    }

    /// TCP of rows of joint positions: positions, mm, and rotation matrices.
    #[allow(clippy::type_complexity)]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        q: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>)> {
        let q = joints(&self.inner, &q)?;
        let rows = q.len() / self.inner.dof();
        let (mut xyz, mut turned) = (Vec::with_capacity(3 * rows), Vec::with_capacity(9 * rows));
        for row in q.chunks_exact(self.inner.dof()) {
            let pose = self.inner.forward(row);
            xyz.extend(pose.position.iter().map(|v| v * 1e3));
            turned.extend(pose.rotation.matrix().transpose().iter());
        }
        Ok((shaped(py, xyz, 3)?, turned.into_pyarray(py).reshape([rows, 3, 3])?))
    }

    fn __len__(&self) -> usize {
        self.inner.dof()
    }

    fn __repr__(&self) -> String {
        format!("<lostmotion.Robot {:?}, axes {}>", self.inner.name, self.inner.axis_names().join(" "))
    }
}
