//! The predicted log as CSV.
//!
//! From a program: `t_s`, `cmd_*`, `enc_*` where asked for, the TCP, the robot's further reflectors. From a log: its own
//! columns in their order, text as it was; what is a measurement (`x_mm`..., `enc_`, `screw_`, `meas_`) is predicted in its place,
//! and a TCP that the log has not is added. Commands have 6 decimals, positions [`POSITION_DECIMALS`] (1 nm).

use super::noise::Noise;
use super::{Motion, Options};
use crate::error::{Error, Place, Result, one_line};
use crate::io::input::Input;
use crate::log::columns::{Meaning, meaning};
use crate::log::write::{field, joint_column, number, position_columns};
use crate::machine::parts;
use crate::model::Model;
use rayon::prelude::*;
use std::io::Write;

/// Decimals of positions in mm and of joints in deg or mm.
pub const POSITION_DECIMALS: u8 = 6;
const JOINT_DECIMALS: u8 = 6;

/// Rows that one thread formats at a time, and how many such blocks are held at once.
const BLOCK: usize = 4096;
const BLOCKS: usize = 32;

/// What was written, and what a user should know about it.
#[derive(Debug, Clone, Default)]
pub struct Written {
    pub rows: usize,
    pub notes: Vec<String>,
}

/// Where a column comes from.
#[derive(Debug, Clone, Copy)]
enum Source {
    /// Field of the input's row, as it was.
    Text(usize),
    Time(u8),
    Command(usize),
    Encoder(usize),
    Screw(usize),
    /// The same as angles of the screw of a prismatic joint.
    EncoderAngle(usize),
    ScrewAngle(usize),
    Joint(usize),
    /// Coordinate of reflector `k`; 0 is the TCP.
    Position(usize, usize),
}

/// Writes the log of a program.
pub fn write_program_log(
    model: &Model,
    motion: &Motion,
    options: &Options,
    from: &str,
    out: &mut dyn Write,
) -> Result<Written> {
    let robot = &model.robot;
    let mut columns = vec![("t_s".to_string(), Source::Time(time_decimals(motion, options.rate_hz)))];
    for (axis, joint) in robot.axis_joints().enumerate() {
        columns.push((joint_column("cmd", joint), Source::Command(axis)));
    }
    add_encoders(model, options, &mut columns);
    add_screws(model, options, &mut columns);
    for k in 0..=robot.reflectors_m.len() {
        add_position(k, &mut columns);
    }
    let plan = Plan::new(model, motion, options, columns);
    plan.head(from, out)?;
    let mut noise = Noise::new(options.noise_m, options.seed);
    let mut row = 0;
    while row < motion.len() {
        let rows = (motion.len() - row).min(BLOCK * BLOCKS);
        plan.rows(row, rows, &[], &mut noise, out)?;
        row += rows;
    }
    Ok(Written { rows: motion.len(), notes: Vec::new() })
}

/// The columns of a log that is written again: its own, a measurement predicted in its place, and those that are missing.
fn columns_again(
    header: &csv::ByteRecord,
    model: &Model,
    options: &Options,
    notes: &mut Vec<String>,
) -> Vec<(String, Source)> {
    let mut columns: Vec<(String, Source)> = Vec::new();
    let (mut has_tcp, mut has_encoders, mut has_screws) = (false, false, false);
    for (i, name) in header.iter().enumerate() {
        let name = String::from_utf8_lossy(name).into_owned();
        let source = match meaning(&name, &model.robot) {
            Meaning::Position { k, coordinate } if k <= model.robot.reflectors_m.len() => {
                has_tcp |= k == 0;
                Source::Position(k, coordinate)
            }
            Meaning::Position { .. } => {
                notes.push(format!("column {} left out: the robot file has no such reflector", one_line(&name)));
                continue;
            }
            Meaning::Encoder(axis) => {
                has_encoders = true;
                Source::Encoder(axis)
            }
            Meaning::EncoderAngle(axis) => {
                has_encoders = true;
                Source::EncoderAngle(axis)
            }
            Meaning::Screw(axis) => {
                has_screws = true;
                Source::Screw(axis)
            }
            Meaning::ScrewAngle(axis) => {
                has_screws = true;
                Source::ScrewAngle(axis)
            }
            Meaning::Measured(axis) => Source::Joint(axis),
            _ => Source::Text(i),
        };
        columns.push((name, source));
    }
    if !has_encoders {
        add_encoders(model, options, &mut columns);
    }
    if !has_screws {
        add_screws(model, options, &mut columns);
    }
    if !has_tcp {
        add_position(0, &mut columns);
    }
    columns
}

/// Writes the log of a log: `input` holds the bytes from which `motion` was made.
pub fn write_log_again(
    model: &Model,
    motion: &Motion,
    options: &Options,
    input: &Input,
    out: &mut dyn Write,
) -> Result<Written> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(input.bytes.as_slice());
    let broken = |e: csv::Error| Error::bad(Place::file(&input.name), e.to_string(), "CSV");
    let header = reader.byte_headers().map_err(broken)?.clone();
    let mut written = Written { rows: motion.len(), notes: Vec::new() };
    let columns = columns_again(&header, model, options, &mut written.notes);
    let plan = Plan::new(model, motion, options, columns);
    plan.head(&input.name, out)?;
    let mut noise = Noise::new(options.noise_m, options.seed);
    let mut row = 0;
    let mut records = Vec::with_capacity(BLOCK * BLOCKS);
    for record in reader.byte_records() {
        records.push(record.map_err(broken)?);
        if records.len() == BLOCK * BLOCKS {
            plan.rows(row, records.len(), &records, &mut noise, out)?;
            row += records.len();
            records.clear();
        }
    }
    plan.rows(row, records.len(), &records, &mut noise, out)?;
    Ok(written)
}

/// True where a log needs encoder columns: asked for, or in the log already.
pub fn has_encoders(input: &Input, model: &Model) -> bool {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(input.bytes.as_slice());
    reader.byte_headers().is_ok_and(|h| {
        h.iter().any(|n| {
            let (m, _) = meaning(&String::from_utf8_lossy(n), &model.robot).of_joint(&model.robot);
            matches!(m, Meaning::Encoder(_))
        })
    })
}

/// True for a log (it has a `cmd_` column of the robot), false for a program.
pub fn is_log(input: &Input, model: &Model) -> bool {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(input.bytes.as_slice());
    reader.byte_headers().is_ok_and(|h| {
        h.iter().any(|n| matches!(meaning(&String::from_utf8_lossy(n), &model.robot), Meaning::Command(_)))
    })
}

fn add_encoders(model: &Model, options: &Options, columns: &mut Vec<(String, Source)>) {
    if options.encoders {
        for (axis, joint) in model.robot.axis_joints().enumerate() {
            columns.push((joint_column("enc", joint), Source::Encoder(axis)));
        }
    }
}

/// Angles where a lead makes them.
fn add_screws(model: &Model, options: &Options, columns: &mut Vec<(String, Source)>) {
    if options.screws {
        for (axis, joint) in model.robot.axis_joints().enumerate() {
            columns.push(match joint.lead_m_per_rev {
                Some(_) => (Meaning::ScrewAngle(axis).name(&model.robot), Source::ScrewAngle(axis)),
                None => (Meaning::Screw(axis).name(&model.robot), Source::Screw(axis)),
            });
        }
    }
}

fn add_position(k: usize, columns: &mut Vec<(String, Source)>) {
    for (coordinate, name) in position_columns(k).into_iter().enumerate() {
        columns.push((name, Source::Position(k, coordinate)));
    }
}

/// Decimals that show the times of the rows: 3 to 6, as few as keep them.
fn time_decimals(motion: &Motion, rate_hz: f64) -> u8 {
    let whole = |x: f64| (x - x.round()).abs() < 1e-6;
    let start = motion.drive.t_s().first().copied().unwrap_or(0.0);
    (3..6).find(|&d| whole(10f64.powi(d) / rate_hz) && whole(10f64.powi(d) * start)).unwrap_or(6) as u8
}

/// What every row needs.
struct Plan<'a> {
    model: &'a Model,
    motion: &'a Motion,
    options: &'a Options,
    names: Vec<String>,
    sources: Vec<Source>,
    /// The TCP and the further reflectors that are written.
    reflectors: usize,
    /// Between the two gaps of a drive, by axis; empty where it is not written.
    screws: Vec<Vec<f64>>,
}

impl<'a> Plan<'a> {
    fn new(model: &'a Model, motion: &'a Motion, options: &'a Options, columns: Vec<(String, Source)>) -> Self {
        let (names, sources): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
        let last = sources.iter().map(|s| if let Source::Position(k, _) = s { *k } else { 0 }).max().unwrap_or(0);
        let written =
            |axis: usize| sources.iter().any(|s| matches!(s, Source::Screw(a) | Source::ScrewAngle(a) if *a == axis));
        let screws = (0..model.robot.dof())
            .map(|a| if written(a) { parts::between_gaps(model, &motion.drive, a) } else { Vec::new() })
            .collect();
        Self { model, motion, options, names, sources, reflectors: last + 1, screws }
    }

    fn head(&self, from: &str, out: &mut dyn Write) -> Result<()> {
        let from = from.rsplit(['/', '\\']).next().unwrap_or(from);
        let frame = if self.model.registration.is_some() { "tracker frame" } else { "base frame" };
        let mut line =
            format!("# lostmotion simulate: {} on {}, {frame}", one_line(from), one_line(&self.model.robot.name));
        if self.options.noise_m > 0.0 {
            // the decimal that was meant: 30e-6 m are 29.999999999999996 um
            let um = (self.options.noise_m * 1e12).round() / 1e6;
            line.push_str(&format!(", noise {um} um, seed {}", self.options.seed));
        }
        line.push('\n');
        let mut head = line.into_bytes();
        for (i, name) in self.names.iter().enumerate() {
            if i > 0 {
                head.push(b',');
            }
            field(&mut head, name.as_bytes());
        }
        head.push(b'\n');
        out.write_all(&head).map_err(|e| Error::io("output", "write", e))
    }

    /// Formats rows `first..first + rows`; `records` are those of the input, or none.
    fn rows(
        &self,
        first: usize,
        rows: usize,
        records: &[csv::ByteRecord],
        noise: &mut Option<Noise>,
        out: &mut dyn Write,
    ) -> Result<()> {
        let per_row = 3 * self.reflectors;
        let drawn: Vec<f64> = match noise {
            Some(n) => (0..rows * per_row).map(|_| n.draw_m()).collect(),
            None => Vec::new(),
        };
        let blocks: Result<Vec<Vec<u8>>> = (0..rows.div_ceil(BLOCK))
            .into_par_iter()
            .map(|b| {
                let range = b * BLOCK..((b + 1) * BLOCK).min(rows);
                let mut text = Vec::with_capacity(range.len() * self.sources.len() * 12);
                let mut points = vec![nalgebra::Vector3::zeros(); self.reflectors];
                for i in range {
                    for (k, p) in points.iter_mut().enumerate() {
                        *p = self.motion.point_m(k, first + i);
                        for c in 0..3 {
                            p[c] += drawn.get(i * per_row + 3 * k + c).copied().unwrap_or(0.0);
                        }
                    }
                    if !self.row(first + i, records.get(i), &points, &mut text) {
                        return Err(self.no_number(first + i));
                    }
                }
                Ok(text)
            })
            .collect();
        for block in &blocks? {
            out.write_all(block).map_err(|e| Error::io("output", "write", e))?;
        }
        Ok(())
    }

    /// The refusal of a row with a value that is no number.
    fn no_number(&self, row: usize) -> Error {
        let t_s = self.motion.drive.t_s()[row];
        Error::setting(
            "model",
            format!("effects that predict no number for row {} (time {t_s} s)", row + 1),
            "parameters, times and commands of sizes that a machine has; nothing was written",
        )
    }

    /// Writes one row; `false`: a predicted value is no number.
    fn row(
        &self,
        row: usize,
        record: Option<&csv::ByteRecord>,
        points: &[nalgebra::Vector3<f64>],
        text: &mut Vec<u8>,
    ) -> bool {
        let finite = std::cell::Cell::new(true);
        let number = |text: &mut Vec<u8>, value: f64, decimals| {
            finite.set(finite.get() && value.is_finite());
            number(text, value, decimals);
        };
        let joint = |text: &mut Vec<u8>, axis: usize, value: f64| {
            number(text, self.model.robot.axis(axis).kind.to_user_unit(value), JOINT_DECIMALS);
        };
        let angle = |text: &mut Vec<u8>, axis: usize, value: f64| {
            let lead = self.model.robot.axis(axis).lead_m_per_rev.unwrap_or(1.0);
            number(text, value / lead * 360.0, JOINT_DECIMALS);
        };
        for (i, source) in self.sources.iter().enumerate() {
            if i > 0 {
                text.push(b',');
            }
            match *source {
                Source::Text(c) => field(text, record.and_then(|r| r.get(c)).unwrap_or_default()),
                Source::Time(decimals) => number(text, self.motion.drive.t_s()[row], decimals),
                Source::Command(axis) => joint(text, axis, self.motion.drive.command(axis)[row]),
                Source::Encoder(axis) => joint(text, axis, self.motion.prediction.servo[axis][row]),
                Source::Screw(axis) => joint(text, axis, self.screws[axis][row]),
                Source::EncoderAngle(axis) => angle(text, axis, self.motion.prediction.servo[axis][row]),
                Source::ScrewAngle(axis) => angle(text, axis, self.screws[axis][row]),
                Source::Joint(axis) => joint(text, axis, self.motion.prediction.joint[axis][row]),
                Source::Position(k, c) => number(text, points[k][c] * 1e3, POSITION_DECIMALS),
            }
        }
        text.push(b'\n');
        finite.get()
    }
}
