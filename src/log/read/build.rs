//! The columns of a table, put together as a [`Log`]: which quantities are there, whole or in part.

use super::table::{Cells, Table};
use crate::error::{Error, Place, Result};
use crate::log::Log;
use crate::log::columns::{Column, Meaning};
use crate::log::instruments::{Instruments, orientations};
use crate::robot::Robot;
use nalgebra::Vector3;

/// The columns of a table, each taken once, in SI.
struct Columns<'a> {
    table: &'a mut Table,
    columns: &'a [Column],
}

impl Columns<'_> {
    fn take(&mut self, m: Meaning) -> Option<Vec<f64>> {
        let k = self.columns.iter().position(|c| c.meaning == m)?;
        let mut values = std::mem::take(&mut self.table.values[k]);
        let factor = self.columns[k].factor;
        if let Some(stamp) = self.columns[k].stamp {
            // whole microseconds: differences are exact, which the seconds of today's dates are not
            stamp.since_first(&mut values);
        }
        if factor != 1.0 {
            values.iter_mut().for_each(|v| *v *= factor);
        }
        Some(values)
    }

    /// A column whose cells may be empty.
    fn cells(&mut self, m: Meaning) -> Option<Cells> {
        self.take(m).map(present)
    }

    /// Coordinates of the `k`-th reflector; a point with an empty cell is lost as a whole.
    fn points(&mut self, k: usize) -> Option<Vec<Option<Vector3<f64>>>> {
        self.vectors([0, 1, 2].map(|coordinate| Meaning::Position { k, coordinate }))
    }

    /// Vectors from three columns; one with an empty cell is lost as a whole.
    fn vectors(&mut self, columns: [Meaning; 3]) -> Option<Vec<Option<Vector3<f64>>>> {
        let [x, y, z] = columns.map(|m| self.take(m));
        let (x, y, z) = (x?, y?, z?);
        let point = |((x, y), z): ((&f64, &f64), &f64)| Some(Vector3::new(*x, *y, *z)).filter(|v| !v.sum().is_nan());
        Some(x.iter().zip(&y).zip(&z).map(point).collect())
    }

    /// Single coordinates of the TCP, where not all three are measured.
    fn lone(&mut self) -> [Option<Vec<f64>>; 3] {
        let coordinates = [0, 1, 2].map(|coordinate| Meaning::Position { k: 0, coordinate });
        let whole = coordinates.iter().all(|m| self.columns.iter().any(|c| c.meaning == *m));
        coordinates.map(|m| if whole { None } else { self.take(m) })
    }

    /// What instruments besides the tracker measure.
    fn instruments(&mut self, name: &str, axes: usize) -> Result<Instruments> {
        let torque_nm: Vec<Option<Cells>> = (0..axes).map(|a| self.cells(Meaning::Torque(a))).collect();
        let mut instruments = Instruments {
            distance_m: self.cells(Meaning::Distance),
            distance_off_m: self.cells(Meaning::DistanceOff),
            dial_m: self.cells(Meaning::Dial),
            orientation: Vec::new(),
            torque_nm: if torque_nm.iter().any(Option::is_some) { torque_nm } else { Vec::new() },
            force_n: self.vectors([0, 1, 2].map(Meaning::Force)),
            ..Instruments::default()
        };
        if let [Some(w), Some(x), Some(y), Some(z)] = [0, 1, 2, 3].map(|part| self.take(Meaning::Orientation(part))) {
            instruments.orientation = orientations([&w, &x, &y, &z]).map_err(|(row, norm)| {
                let line = self.table.line.get(row).map_or(0, |l| u64::from(*l));
                let found = format!("an orientation of length {norm:.4}");
                Error::bad(Place::line(name, line), found, "a unit quaternion qw, qx, qy, qz")
            })?;
        }
        Ok(instruments)
    }

    /// Decimals of an axis' command: another unit moves the last digit, 8 decimals of a radian are 6 of a degree.
    fn decimals(&self, axis: usize) -> u8 {
        match self.columns.iter().position(|c| c.meaning == Meaning::Command(axis)) {
            Some(k) => {
                (f64::from(self.table.decimals[k]) - self.columns[k].edge.log10()).floor().clamp(0.0, 15.0) as u8
            }
            None => 0,
        }
    }
}

/// Cells that are not empty.
fn present(values: Vec<f64>) -> Cells {
    values.into_iter().map(|v| Some(v).filter(|v| !v.is_nan())).collect()
}

/// Columns as written to a log in SI.
pub(super) fn build(name: &str, sha256: String, mut table: Table, columns: &[Column], robot: &Robot) -> Result<Log> {
    let rows = table.line.len();
    let axes = robot.dof();
    let mut c = Columns { table: &mut table, columns };
    let time = c.take(Meaning::Time);
    let poses = time.is_none();
    let lone_m = c.lone().map(|values| values.map(present));
    let instruments = c.instruments(name, axes)?;
    Ok(Log {
        name: name.into(),
        sha256,
        t_s: time.unwrap_or_else(|| (0..rows).map(|i| i as f64).collect()),
        poses,
        cmd: (0..axes).map(|a| c.take(Meaning::Command(a)).unwrap_or_default()).collect(),
        cmd_decimals: (0..axes).map(|a| c.decimals(a)).collect(),
        tcp_m: c.points(0).unwrap_or_default(),
        lone_m,
        reflectors_m: (1..).map_while(|k| c.points(k)).collect(),
        enc: (0..axes).map(|a| c.cells(Meaning::Encoder(a))).collect(),
        screw: (0..axes).map(|a| c.cells(Meaning::Screw(a))).collect(),
        meas: (0..axes).map(|a| c.cells(Meaning::Measured(a))).collect(),
        trigger: c.take(Meaning::Trigger).map(|v| v.into_iter().map(|x| x as i8).collect()),
        cycle: c.take(Meaning::Cycle).map(|v| v.into_iter().map(|x| x as u32).collect()),
        speed_m_s: c.cells(Meaning::Speed),
        payload_kg: c.cells(Meaning::Payload),
        temp_c: c.cells(Meaning::Temperature),
        instruments,
        line: table.line,
    })
}
