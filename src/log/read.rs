//! CSV (and gzip) to a [`Log`].

use super::Log;
use super::columns::{Meaning, meaning};
use crate::error::{Error, Place, Result};
use crate::io::input::{self, Input};
use crate::robot::Robot;
use nalgebra::Vector3;
use std::path::Path;

impl Log {
    /// Reads a log with the contract's column names.
    pub fn load(path: &Path, robot: &Robot) -> Result<Self> {
        Self::parse(input::read(path)?, robot)
    }

    /// Parses the bytes of a log.
    pub fn parse(input: Input, robot: &Robot) -> Result<Self> {
        let name = input.name;
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).flexible(false).from_reader(input.bytes.as_slice());
        let header = reader.byte_headers().map_err(|e| csv_error(&name, &e))?.clone();
        let meanings: Vec<Meaning> = header.iter().map(|h| meaning(&String::from_utf8_lossy(h), robot)).collect();
        let column_of = |m: Meaning| meanings.iter().position(|x| *x == m);
        let n_axes = robot.dof();
        let mut cmd_columns = Vec::with_capacity(n_axes);
        for (axis, joint) in robot.axis_joints().enumerate() {
            cmd_columns.push(column_of(Meaning::Command(axis)).ok_or_else(|| {
                Error::bad(
                    Place::line(&name, 1),
                    format!("no column `cmd_{}_{}`", joint.name, joint.kind.unit()),
                    format!("a command column for each joint of {}", robot.axis_names().join(", ")),
                )
            })?);
        }
        let time = column_of(Meaning::Time);
        let position = |k: usize| -> Option<[usize; 3]> {
            let c = [0, 1, 2].map(|coordinate| column_of(Meaning::Position { k, coordinate }));
            Some([c[0]?, c[1]?, c[2]?])
        };
        let tcp = position(0);
        let trigger = column_of(Meaning::Trigger);
        let cycle = column_of(Meaning::Cycle);
        let optional = |m| column_of(m);
        let (speed, payload, temp) =
            (optional(Meaning::Speed), optional(Meaning::Payload), optional(Meaning::Temperature));
        let enc_columns: Vec<Option<usize>> = (0..n_axes).map(|a| column_of(Meaning::Encoder(a))).collect();
        let meas_columns: Vec<Option<usize>> = (0..n_axes).map(|a| column_of(Meaning::Measured(a))).collect();
        let si: Vec<f64> = robot.axis_joints().map(|j| j.kind.si()).collect();
        let mut log = Log {
            name: name.clone(),
            sha256: input.sha256,
            line: Vec::new(),
            t_s: Vec::new(),
            poses: time.is_none(),
            cmd: vec![Vec::new(); n_axes],
            cmd_decimals: vec![0; n_axes],
            tcp_m: Vec::new(),
            reflectors_m: Vec::new(),
            enc: enc_columns.iter().map(|c| c.map(|_| Vec::new())).collect(),
            meas: meas_columns.iter().map(|c| c.map(|_| Vec::new())).collect(),
            trigger: trigger.map(|_| Vec::new()),
            cycle: cycle.map(|_| Vec::new()),
            speed_m_s: speed.map(|_| Vec::new()),
            payload_kg: payload.map(|_| Vec::new()),
            temp_c: temp.map(|_| Vec::new()),
        };
        let reflectors: Vec<[usize; 3]> = (1..).map_while(position).collect();
        log.reflectors_m = vec![Vec::new(); reflectors.len()];
        let mut record = csv::ByteRecord::new();
        while reader.read_byte_record(&mut record).map_err(|e| csv_error(&name, &e))? {
            let line = record.position().map_or(0, |p| p.line());
            let row = Row { record: &record, header: &header, name: &name, line };
            let t = match time {
                Some(c) => row.number(c)?,
                None => log.t_s.len() as f64,
            };
            if let Some(&before) = log.t_s.last()
                && t <= before
            {
                return Err(row.bad(
                    time.unwrap_or(0),
                    format!("time {t} s after {before} s"),
                    "times that strictly increase",
                ));
            }
            log.line.push(line as u32);
            log.t_s.push(t);
            for (axis, &c) in cmd_columns.iter().enumerate() {
                log.cmd[axis].push(row.number(c)? * si[axis]);
                log.cmd_decimals[axis] = log.cmd_decimals[axis].max(decimals(&record[c]));
            }
            if let Some(c) = tcp {
                log.tcp_m.push(row.point(c)?);
            }
            for (track, &c) in log.reflectors_m.iter_mut().zip(&reflectors) {
                track.push(row.point(c)?);
            }
            for (columns, tracks) in [(&enc_columns, &mut log.enc), (&meas_columns, &mut log.meas)] {
                for (axis, (c, track)) in columns.iter().zip(tracks.iter_mut()).enumerate() {
                    if let (Some(c), Some(track)) = (c, track) {
                        track.push(row.optional(*c)?.map(|v| v * si[axis]));
                    }
                }
            }
            if let (Some(c), Some(v)) = (trigger, &mut log.trigger) {
                v.push(row.number(c)? as i8);
            }
            if let (Some(c), Some(v)) = (cycle, &mut log.cycle) {
                v.push(row.number(c)? as u32);
            }
            for (c, v, scale) in
                [(speed, &mut log.speed_m_s, 1e-3), (payload, &mut log.payload_kg, 1.0), (temp, &mut log.temp_c, 1.0)]
            {
                if let (Some(c), Some(v)) = (c, v) {
                    v.push(row.optional(c)?.map(|x| x * scale));
                }
            }
        }
        if log.is_empty() {
            return Err(Error::bad(Place::file(&name), "a header and no rows", "at least one row"));
        }
        Ok(log)
    }
}

/// One row, with what its messages need.
struct Row<'a> {
    record: &'a csv::ByteRecord,
    header: &'a csv::ByteRecord,
    name: &'a str,
    line: u64,
}

impl Row<'_> {
    fn bad(&self, column: usize, found: String, expected: &str) -> Error {
        let head = String::from_utf8_lossy(&self.header[column]);
        Error::bad(
            Place::field(self.name, self.line, column as u64 + 1),
            format!("{found} in column `{head}`"),
            expected,
        )
    }

    fn optional(&self, column: usize) -> Result<Option<f64>> {
        let text = self.record[column].trim_ascii();
        if text.is_empty() {
            return Ok(None);
        }
        match std::str::from_utf8(text).ok().and_then(|s| s.parse::<f64>().ok()) {
            Some(v) if v.is_finite() => Ok(Some(v)),
            _ => Err(self.bad(
                column,
                format!("`{}`", String::from_utf8_lossy(text)),
                "a finite number with a decimal point",
            )),
        }
    }

    fn number(&self, column: usize) -> Result<f64> {
        self.optional(column)?.ok_or_else(|| self.bad(column, "an empty cell".into(), "a finite number"))
    }

    fn point(&self, columns: [usize; 3]) -> Result<Option<Vector3<f64>>> {
        Ok(match (self.optional(columns[0])?, self.optional(columns[1])?, self.optional(columns[2])?) {
            (Some(x), Some(y), Some(z)) => Some(Vector3::new(x, y, z) * 1e-3),
            _ => None,
        })
    }
}

/// Decimals behind the point of a number as written.
fn decimals(text: &[u8]) -> u8 {
    match text.iter().position(|&b| b == b'.') {
        Some(i) => text[i + 1..].iter().take_while(|b| b.is_ascii_digit()).count().min(15) as u8,
        None => 0,
    }
}

fn csv_error(name: &str, e: &csv::Error) -> Error {
    let line = e.position().map(|p| p.line());
    let place = Place { file: name.into(), line, column: None };
    match e.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            Error::bad(place, format!("{len} fields"), format!("{expected_len} fields, as in the header"))
        }
        csv::ErrorKind::Io(io) => Error::bad(place, io.to_string(), "readable CSV"),
        _ => Error::bad(place, e.to_string(), "CSV"),
    }
}
