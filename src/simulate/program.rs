//! A small reader of joint-space CSV programs, for the simulator only: it keeps numbers and lines, no spans.
//!
//! Columns `<joint>_deg` or `<joint>_mm` for every axis (`cmd_` in front is allowed), case ignored, in any order; an
//! optional `t_s`; other columns are passed over. `#` lines are comments. Times must not decrease.

use crate::error::{Error, Place, Result};
use crate::io::input::Input;
use crate::robot::Robot;

/// Program points in SI.
#[derive(Debug, Clone)]
pub struct Program {
    pub name: String,
    /// Line in the file of each point.
    pub line: Vec<u32>,
    /// Times in s where the program has them.
    pub t_s: Option<Vec<f64>>,
    /// `q[axis][point]`, rad or m.
    pub q: Vec<Vec<f64>>,
}

impl Program {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.line.len()
    }

    pub fn is_empty(&self) -> bool {
        self.line.is_empty()
    }

    /// Joint vector of a point into `q`.
    pub fn point_into(&self, i: usize, q: &mut [f64]) {
        for (v, column) in q.iter_mut().zip(&self.q) {
            *v = column[i];
        }
    }

    /// Parses the bytes of a program.
    pub fn parse(input: &Input, robot: &Robot) -> Result<Self> {
        let name = input.name.as_str();
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(input.bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&input.bytes));
        let broken = |e: csv::Error| {
            let place = Place { file: name.into(), line: e.position().map(|p| p.line()), column: None };
            Error::bad(place, e.to_string(), "CSV with as many fields in each row as in its header")
        };
        let header = reader.byte_headers().map_err(broken)?.clone();
        let names: Vec<String> = header.iter().map(|h| String::from_utf8_lossy(h).to_ascii_lowercase()).collect();
        let mut columns = Vec::with_capacity(robot.dof());
        for joint in robot.axis_joints() {
            let want = format!("{}_{}", joint.name.to_ascii_lowercase(), joint.kind.unit());
            let found = names.iter().position(|n| n.strip_prefix("cmd_").unwrap_or(n) == want);
            columns.push(found.ok_or_else(|| {
                let line = header.position().map_or(1, |p| p.line());
                Error::bad(
                    Place::line(name, line),
                    format!("no column `{want}`"),
                    format!(
                        "a joint-space CSV program with a column for each joint of {}",
                        robot.axis_names().join(", ")
                    ),
                )
            })?);
        }
        let time = names.iter().position(|n| n == "t_s");
        let si: Vec<f64> = robot.axis_joints().map(|j| j.kind.si()).collect();
        let mut program = Self {
            name: name.into(),
            line: Vec::new(),
            t_s: time.map(|_| Vec::new()),
            q: vec![Vec::new(); columns.len()],
        };
        let mut record = csv::ByteRecord::new();
        while reader.read_byte_record(&mut record).map_err(broken)? {
            let line = record.position().map_or(0, |p| p.line());
            let number = |c: usize| -> Result<f64> {
                match std::str::from_utf8(&record[c]).ok().and_then(|s| s.parse::<f64>().ok()) {
                    Some(v) if v.is_finite() => Ok(v),
                    _ => Err(Error::bad(
                        Place::field(name, line, c as u64 + 1),
                        format!("`{}` in column `{}`", String::from_utf8_lossy(&record[c]), names[c]),
                        "a finite number with a decimal point",
                    )),
                }
            };
            for ((axis, &c), si) in program.q.iter_mut().zip(&columns).zip(&si) {
                axis.push(number(c)? * si);
            }
            if let (Some(c), Some(times)) = (time, &mut program.t_s) {
                let t = number(c)?;
                if let Some(&before) = times.last()
                    && t < before
                {
                    return Err(Error::bad(
                        Place::field(name, line, c as u64 + 1),
                        format!("time {t} s after {before} s"),
                        "times that do not decrease",
                    ));
                }
                times.push(t);
            }
            program.line.push(line as u32);
        }
        if program.len() < 2 {
            return Err(Error::bad(
                Place::file(name),
                format!("a program of {} points", program.len()),
                "at least two points",
            ));
        }
        Ok(program)
    }
}
