//! The jobs: identify, fit, rewrite, simulate, diagnose, join. Results leave as arrays, and as JSON and pages that `python/lostmotion`
//! dresses.

use crate::arrays::{joints, joints_out, shaped};
use crate::errors::{bad, raised, refused};
use crate::log::Log;
use crate::robot::Robot;
use lostmotion::cli::page;
use lostmotion::gaps::file;
use lostmotion::identify::{machine, path, static_test};
use lostmotion::log::ColumnMap;
use lostmotion::log::recording::Recording;
use lostmotion::model::Model;
use lostmotion::rewrite::{Engine, Options, Origin, OutputPoints, Points};
use lostmotion::simulate::Motion;
use lostmotion::{
    compensator, diagnose as diagnosis,
    error::Error,
    gaps,
    io::{bag::TopicChoice, input},
    program::Program,
};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

type Shared = Arc<lostmotion::robot::Robot>;

/// What an identification found.
#[pyclass(frozen, module = "lostmotion")]
pub struct Gaps {
    inner: gaps::Gaps,
    robot: Shared,
    page: String,
}

#[pymethods]
impl Gaps {
    #[staticmethod]
    fn load(path: PathBuf, robot: &Robot) -> PyResult<Self> {
        let inner = gaps::Gaps::load(&path, &robot.inner).map_err(raised)?;
        let page = page::gaps::of_readings(&robot.inner, &inner).render();
        Ok(Self { inner, robot: Arc::new(robot.inner.clone()), page })
    }

    fn json(&self) -> PyResult<String> {
        file::to_json(&file::document(&self.inner, &self.robot)).map_err(raised)
    }

    fn yaml(&self) -> PyResult<String> {
        file::to_yaml(&file::document(&self.inner, &self.robot)).map_err(raised)
    }

    fn page(&self) -> &str {
        &self.page
    }
}

/// Offsets by joint.
#[pyclass(frozen, module = "lostmotion")]
pub struct Compensator {
    inner: compensator::Compensator,
    robot: Shared,
}

#[pymethods]
impl Compensator {
    #[staticmethod]
    fn load(path: PathBuf, robot: &Robot) -> PyResult<Self> {
        let inner = compensator::Compensator::load(&path, &robot.inner).map_err(raised)?;
        Ok(Self { inner, robot: Arc::new(robot.inner.clone()) })
    }

    /// Every effect of a model that an offset can undo.
    #[staticmethod]
    fn of_model(path: PathBuf) -> PyResult<Self> {
        let model = Model::load(&path).map_err(raised)?;
        let inner = compensator::Compensator::from_model(&model).map_err(raised)?;
        Ok(Self { inner, robot: Arc::new(model.robot) })
    }

    fn json(&self) -> PyResult<String> {
        Ok(self.inner.to_json(&self.robot).map_err(raised)?.to_string())
    }

    fn yaml(&self) -> PyResult<String> {
        self.inner.to_yaml(&self.robot).map_err(raised)
    }

    fn page(&self) -> String {
        page::compensator::of_fit(&self.robot, &self.inner).render()
    }
}

#[pyfunction]
#[pyo3(signature = (robot, logs, kind = "machine"))]
pub fn identify(py: Python<'_>, robot: &Robot, logs: Vec<PyRef<'_, Log>>, kind: &str) -> PyResult<Gaps> {
    let read: Vec<_> = logs.iter().map(|l| l.inner.clone()).collect();
    let robot = &robot.inner;
    let found = py.detach(|| -> Result<(gaps::Gaps, String), Error> {
        Ok(match kind {
            "static" => {
                let found = static_test::identify(robot, &read, &static_test::Options::default())?;
                let page = page::gaps::of_static(robot, &found).render();
                (found.gaps, page)
            }
            "path" => {
                let found = path::identify(robot, &read, &path::Options::default())?;
                let page = page::gaps::of_path(robot, &found).render();
                (found.gaps, page)
            }
            _ => {
                let found = machine::identify(robot, &read, &[])?;
                let page = page::machine::of_identify(robot, &found).render();
                (found, page)
            }
        })
    });
    let (inner, page) = found.map_err(raised)?;
    Ok(Gaps { inner, robot: Arc::new(robot.clone()), page })
}

#[pyfunction]
pub fn fit(robot: &Robot, gaps: Vec<PyRef<'_, Gaps>>) -> PyResult<Compensator> {
    let documents: Vec<gaps::Gaps> = gaps.iter().map(|g| g.inner.clone()).collect();
    let inner = lostmotion::fit::fit(&robot.inner, &documents, lostmotion::fit::Form::Decay).map_err(raised)?;
    Ok(Compensator { inner, robot: Arc::new(robot.inner.clone()) })
}

/// Points of a path with offsets and new points: positions, times, whether a row is one of those given, and the statistics.
#[pyfunction]
#[pyo3(signature = (robot, compensator, q, t_s = None, tcp_speed_mm_s = None, gain = 1.0))]
pub fn rewrite<'py>(
    py: Python<'py>,
    robot: &Robot,
    compensator: &Compensator,
    q: PyReadonlyArray2<'py, f64>,
    t_s: Option<PyReadonlyArray1<'py, f64>>,
    tcp_speed_mm_s: Option<f64>,
    gain: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let robot = &robot.inner;
    let t_s = t_s.map_or_else(Vec::new, |t| t.as_array().to_vec());
    let points = Points { axes: robot.dof(), q: joints(robot, &q)?, t_s };
    if !points.t_s.is_empty() && points.t_s.len() != points.len() {
        return Err(bad(format!("{} times for {} points; expected one each", points.t_s.len(), points.len())));
    }
    if !(0.0..=1.0).contains(&gain) {
        return Err(bad(format!("gain {gain}; expected 0 to 1")));
    }
    let mut options = Options::new(robot.dof());
    options.tcp_speed_m_s = tcp_speed_mm_s.map(|v| v * 1e-3);
    options.gain = gain;
    let done = py.detach(|| -> Result<_, Error> {
        let mut engine = Engine::new(robot, &compensator.inner, options)?;
        let mut out = OutputPoints { axes: robot.dof(), ..OutputPoints::default() };
        engine.push(&points, &mut out)?;
        let stats = engine.finish(&mut out)?;
        Ok((out, stats))
    });
    let (out, stats) = done.map_err(raised)?;
    if let Some(v) = stats.violations.first() {
        let joint = robot.axis(v.axis);
        let (unit, edge) = (joint.kind.unit(), |v: f64| joint.kind.to_user_unit(v));
        let what = format!("{:?}", v.what).to_lowercase();
        let (value, limit) = (edge(v.value), edge(v.limit));
        let words = format!("{}: {what} of {value:.4} {unit} (per s, s2), limit {limit:.4}", joint.name);
        let all = stats.violations_total;
        return Err(refused(format!("{all} limits would be exceeded, the first at {:?}: {words}", v.origin)));
    }
    let given: Vec<bool> = out.origin.iter().map(|o| matches!(o, Origin::Point(_))).collect();
    let result = PyDict::new(py);
    result.set_item("q", joints_out(py, robot, &out.q)?)?;
    result.set_item("t_s", if out.t_s.is_empty() { None } else { Some(out.t_s.into_pyarray(py)) })?;
    result.set_item("given", given.into_pyarray(py))?;
    result.set_item("points", stats.points)?;
    result.set_item("inserted", stats.inserted)?;
    result.set_item("reversals", stats.reversals)?;
    result.set_item("largest_change_um", stats.largest_change_m * 1e6)?;
    Ok(result)
}

/// What a tracker sees of a log's commands, or of a program's, on a modelled machine: times, commands, TCP in mm.
#[pyfunction]
#[pyo3(signature = (model, log = None, program = None, rate_hz = 25.0, tcp_speed_mm_s = 1.5))]
#[allow(clippy::type_complexity)]
pub fn simulate<'py>(
    py: Python<'py>,
    model: PathBuf,
    log: Option<PyRef<'py, Log>>,
    program: Option<PathBuf>,
    rate_hz: f64,
    tcp_speed_mm_s: f64,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
    let model = Model::load(&model).map_err(raised)?;
    let motion = match (&log, &program) {
        (Some(log), None) => {
            let log = &log.inner;
            py.detach(|| Motion::of_log(&model, log))
        }
        (None, Some(path)) => {
            let program = Program::parse(input::read(path).map_err(raised)?, &model.robot).map_err(raised)?;
            let times = match &program.t_s {
                Some(t) => t.clone(),
                None => lostmotion::simulate::Timing::at_speed(&model.robot, &program, tcp_speed_mm_s * 1e-3).t_s,
            };
            py.detach(|| Motion::of_program(&model, &program, &times, rate_hz)).map_err(raised)?
        }
        _ => return Err(bad("a log and a program, or neither; expected one of them")),
    };
    let n = model.robot.dof();
    let rows: Vec<f64> = (0..motion.len())
        .flat_map(|i| (0..n).map(move |a| (i, a)))
        .map(|(i, a)| motion.trajectory.command(a)[i])
        .collect();
    let tcp = (0..motion.len()).flat_map(|i| <[f64; 3]>::from(motion.point_m(0, i) * 1e3)).collect();
    Ok((motion.trajectory.t_s().to_vec().into_pyarray(py), joints_out(py, &model.robot, &rows)?, shaped(py, tcp, 3)?))
}

/// What a model lacks to explain logs: the document, the page, and the model with what was found.
#[pyfunction]
#[pyo3(signature = (logs, model = None, robot = None))]
pub fn diagnose(
    py: Python<'_>,
    logs: Vec<PyRef<'_, Log>>,
    model: Option<PathBuf>,
    robot: Option<PyRef<'_, Robot>>,
) -> PyResult<(String, String, String)> {
    let (model, name) = match (model, robot) {
        (Some(path), None) => (Model::load(&path).map_err(raised)?, path.display().to_string()),
        (None, Some(robot)) => (Model::ideal(robot.inner.clone()), robot.inner.name.clone()),
        _ => return Err(bad("a model and a robot, or neither; expected one of them")),
    };
    let read: Vec<_> = logs.iter().map(|l| l.inner.clone()).collect();
    let done = py.detach(|| -> Result<_, Error> {
        let outcome = diagnosis::diagnose(&model, &read)?;
        let document = diagnosis::result::of(&outcome);
        let page = page::diagnose::of(&name, &outcome, &document).render();
        let found = diagnosis::model_with(&model, &outcome).to_yaml_inline()?;
        Ok((serde_json::to_string(&document).unwrap_or_default(), page, found))
    });
    done.map_err(raised)
}

/// Two recordings on one clock: the document, and the log as CSV.
#[pyfunction]
#[pyo3(signature = (robot, controller, tracker, controller_columns = None, tracker_columns = None, near_s = None))]
pub fn join(
    py: Python<'_>,
    robot: &Robot,
    controller: PathBuf,
    tracker: PathBuf,
    controller_columns: Option<PathBuf>,
    tracker_columns: Option<PathBuf>,
    near_s: Option<f64>,
) -> PyResult<(String, Vec<u8>)> {
    let robot = &robot.inner;
    let load = |path: &PathBuf, map: &Option<PathBuf>, wanted: TopicChoice| -> Result<Recording, Error> {
        Recording::load(path, robot, map.as_deref().map(ColumnMap::load).transpose()?.as_ref(), wanted)
    };
    let done = py.detach(|| -> Result<_, Error> {
        let (controller, tracker) = (
            load(&controller, &controller_columns, TopicChoice::Joints)?,
            load(&tracker, &tracker_columns, TopicChoice::Places)?,
        );
        let options = lostmotion::join::Options { near_s, ..lostmotion::join::Options::default() };
        let joined = lostmotion::join::join(robot, &controller, &tracker, &options)?;
        Ok((serde_json::to_string(&joined.report).unwrap_or_default(), joined.table.to_csv()))
    });
    done.map_err(raised)
}
