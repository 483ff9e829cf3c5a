//! The predicted log as CSV.
//!
//! From a program: `t_s`, `cmd_*`, `enc_*` where asked for, the TCP, the robot's further reflectors. From a log: its own
//! columns in their order, text as it was; what is a measurement (`x_mm`..., `enc_`, `screw_`, `meas_`) is predicted in its place,
//! and a TCP that the log has not is added. Commands have 6 decimals, positions [`POSITION_DECIMALS`] (1 nm). A log that was read
//! through a column map keeps its names, separator and decimal sign, and each predicted column its unit, sign and scale: the same map
//! reads it again.

use super::noise::Noise;
use super::{Motion, Options};
use crate::error::{Error, Place, Result, one_line};
use crate::io::input::Input;
use crate::log::columns::{Meaning, meaning};
use crate::log::read::reader;
use crate::log::text::{LogText, TextColumn};
use crate::log::write::{field_between, joint_column, number, position_columns};
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
    /// Number of rows.
    pub rows: usize,
    /// What a user should know about the log.
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

/// How the numbers of a predicted column are written.
#[derive(Debug, Clone, Copy)]
struct Unit {
    /// SI of the number 1, sign and all.
    si: f64,
    decimals: u8,
}

/// A column: its name, where it comes from, and its unit where that is not the contract's.
type Named = (String, Source, Option<Unit>);

/// What stands between fields and before decimals.
#[derive(Debug, Clone, Copy)]
struct Style {
    separator: u8,
    decimal: u8,
}

impl Style {
    const OURS: Self = Self { separator: b',', decimal: b'.' };
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
    let mut columns: Vec<Named> = vec![("t_s".to_string(), Source::Time(time_decimals(motion, options.rate_hz)), None)];
    for (axis, joint) in robot.axis_joints().enumerate() {
        columns.push((joint_column("cmd", joint), Source::Command(axis), None));
    }
    add_encoders(model, options, &mut columns);
    add_screws(model, options, &mut columns);
    for k in 0..=robot.reflectors_m.len() {
        add_position(k, &mut columns);
    }
    let plan = Plan::new(model, motion, options, columns, Style::OURS);
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

/// What is predicted in a column's place; `None`: a reflector that the robot file has not.
fn predicted_in(what: Meaning, index: usize, reflectors: usize) -> Option<Source> {
    Some(match what {
        Meaning::Position { k, coordinate } if k <= reflectors => Source::Position(k, coordinate),
        Meaning::Position { .. } => return None,
        Meaning::Encoder(axis) => Source::Encoder(axis),
        Meaning::EncoderAngle(axis) => Source::EncoderAngle(axis),
        Meaning::Screw(axis) => Source::Screw(axis),
        Meaning::ScrewAngle(axis) => Source::ScrewAngle(axis),
        Meaning::Measured(axis) => Source::Joint(axis),
        _ => Source::Text(index),
    })
}

/// The columns of a log that is written again: its own, a measurement predicted in its place, and those that are missing. `used`
/// says what they are where a map does.
fn columns_again(
    header: &[String],
    used: Option<&[TextColumn]>,
    model: &Model,
    options: &Options,
    notes: &mut Vec<String>,
) -> Vec<Named> {
    let mut columns: Vec<Named> = Vec::new();
    for (i, name) in header.iter().enumerate() {
        let (what, unit) = match used {
            None => (meaning(name, &model.robot), None),
            Some(used) => match used.iter().find(|c| c.index == i) {
                Some(c) => {
                    let decimals = i16::from(POSITION_DECIMALS) + i16::from(c.more_decimals);
                    (c.meaning, Some(Unit { si: c.si_per_number, decimals: decimals.clamp(0, 15) as u8 }))
                }
                None => (Meaning::Other, None),
            },
        };
        match predicted_in(what, i, model.robot.reflectors_m.len()) {
            Some(source) => columns.push((name.clone(), source, unit)),
            None => notes.push(format!("column {} left out: the robot file has no such reflector", one_line(name))),
        }
    }
    let has = |is: fn(&Source) -> bool| columns.iter().any(|(_, source, _)| is(source));
    let encoders = has(|s| matches!(s, Source::Encoder(_) | Source::EncoderAngle(_)));
    let screws = has(|s| matches!(s, Source::Screw(_) | Source::ScrewAngle(_)));
    let tcp = has(|s| matches!(s, Source::Position(0, _)));
    if !encoders {
        add_encoders(model, options, &mut columns);
    }
    if !screws {
        add_screws(model, options, &mut columns);
    }
    if !tcp {
        add_position(0, &mut columns);
    }
    columns
}

/// Writes the log of a log: `text` holds the bytes from which `motion` was made, read through a map where `mapped`.
pub fn write_log_again(
    model: &Model,
    motion: &Motion,
    options: &Options,
    text: &LogText,
    mapped: bool,
    out: &mut dyn Write,
) -> Result<Written> {
    let broken = |e: csv::Error| Error::bad(Place::file(&text.input.name), e.to_string(), "CSV");
    let (header, used) = text.used(&model.robot)?;
    let mut written = Written { rows: motion.len(), notes: Vec::new() };
    let used = mapped.then_some(used.as_slice());
    let columns = columns_again(&header, used, model, options, &mut written.notes);
    let style = Style { separator: text.separator, decimal: text.decimal };
    let plan = Plan::new(model, motion, options, columns, style);
    plan.head(&text.input.name, out)?;
    let mut noise = Noise::new(options.noise_m, options.seed);
    let mut row = 0;
    let mut records = Vec::with_capacity(BLOCK * BLOCKS);
    // the header is the first record; a line of blanks is no row, as for who reads the log
    let rows = reader(&text.input.bytes, text.separator).into_byte_records().skip(1);
    for record in rows {
        let record = record.map_err(broken)?;
        if record.len() == 1 && header.len() > 1 && record[0].trim_ascii().is_empty() {
            continue;
        }
        records.push(record);
        if records.len() == BLOCK * BLOCKS {
            plan.rows(row, records.len(), &records, &mut noise, out)?;
            row += records.len();
            records.clear();
        }
    }
    plan.rows(row, records.len(), &records, &mut noise, out)?;
    Ok(written)
}

/// True for a log (it has a `cmd_` column of the robot), false for a program.
pub fn is_log(input: &Input, model: &Model) -> bool {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(input.bytes.as_slice());
    reader.byte_headers().is_ok_and(|h| {
        h.iter().any(|n| matches!(meaning(&String::from_utf8_lossy(n), &model.robot), Meaning::Command(_)))
    })
}

fn add_encoders(model: &Model, options: &Options, columns: &mut Vec<Named>) {
    if options.encoders {
        for (axis, joint) in model.robot.axis_joints().enumerate() {
            columns.push((joint_column("enc", joint), Source::Encoder(axis), None));
        }
    }
}

/// Angles where a lead makes them.
fn add_screws(model: &Model, options: &Options, columns: &mut Vec<Named>) {
    if options.screws {
        for (axis, joint) in model.robot.axis_joints().enumerate() {
            columns.push(match joint.lead_m_per_rev {
                Some(_) => (Meaning::ScrewAngle(axis).name(&model.robot), Source::ScrewAngle(axis), None),
                None => (Meaning::Screw(axis).name(&model.robot), Source::Screw(axis), None),
            });
        }
    }
}

fn add_position(k: usize, columns: &mut Vec<Named>) {
    for (coordinate, name) in position_columns(k).into_iter().enumerate() {
        columns.push((name, Source::Position(k, coordinate), None));
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
    columns: Vec<Named>,
    style: Style,
    /// The TCP and the further reflectors that are written.
    reflectors: usize,
    /// Between the two gaps of a drive, by axis; empty where it is not written.
    screws: Vec<Vec<f64>>,
}

impl<'a> Plan<'a> {
    fn new(model: &'a Model, motion: &'a Motion, options: &'a Options, columns: Vec<Named>, style: Style) -> Self {
        let sources = || columns.iter().map(|c| c.1);
        let last = sources().map(|s| if let Source::Position(k, _) = s { k } else { 0 }).max().unwrap_or(0);
        let written =
            |axis: usize| sources().any(|s| matches!(s, Source::Screw(a) | Source::ScrewAngle(a) if a == axis));
        let screws = (0..model.robot.dof())
            .map(|a| if written(a) { parts::between_gaps(model, &motion.drive, a) } else { Vec::new() })
            .collect();
        Self { model, motion, options, columns, style, reflectors: last + 1, screws }
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
        for (i, (name, ..)) in self.columns.iter().enumerate() {
            if i > 0 {
                head.push(self.style.separator);
            }
            field_between(&mut head, name.as_bytes(), self.style.separator);
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
                let mut text = Vec::with_capacity(range.len() * self.columns.len() * 12);
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
            let start = text.len();
            number(text, value, decimals);
            if self.style.decimal != b'.' {
                text[start..].iter_mut().filter(|b| **b == b'.').for_each(|b| *b = self.style.decimal);
            }
        };
        let joint = |text: &mut Vec<u8>, axis: usize, value: f64| {
            number(text, self.model.robot.axis(axis).kind.to_user_unit(value), JOINT_DECIMALS);
        };
        let angle = |text: &mut Vec<u8>, axis: usize, value: f64| {
            let lead = self.model.robot.axis(axis).lead_m_per_rev.unwrap_or(1.0);
            number(text, value / lead * 360.0, JOINT_DECIMALS);
        };
        let prediction = &self.motion.prediction;
        for (i, (_, source, unit)) in self.columns.iter().enumerate() {
            if i > 0 {
                text.push(self.style.separator);
            }
            if let Some(unit) = unit
                && let Some(value) = self.predicted(*source, row, points)
            {
                number(text, value / unit.si, unit.decimals);
                continue;
            }
            match *source {
                Source::Text(c) => {
                    field_between(text, record.and_then(|r| r.get(c)).unwrap_or_default(), self.style.separator);
                }
                Source::Time(decimals) => number(text, self.motion.drive.t_s()[row], decimals),
                Source::Command(axis) => joint(text, axis, self.motion.drive.command(axis)[row]),
                Source::Encoder(axis) => joint(text, axis, prediction.servo[axis][row]),
                Source::Screw(axis) => joint(text, axis, self.screws[axis][row]),
                Source::EncoderAngle(axis) => angle(text, axis, prediction.servo[axis][row]),
                Source::ScrewAngle(axis) => angle(text, axis, self.screws[axis][row]),
                Source::Joint(axis) => joint(text, axis, prediction.joint[axis][row]),
                Source::Position(k, c) => number(text, points[k][c] * 1e3, POSITION_DECIMALS),
            }
        }
        text.push(b'\n');
        finite.get()
    }

    /// The predicted value of a row, SI; `None`: it is a text.
    fn predicted(&self, source: Source, row: usize, points: &[nalgebra::Vector3<f64>]) -> Option<f64> {
        Some(match source {
            Source::Text(_) => return None,
            Source::Time(_) => self.motion.drive.t_s()[row],
            Source::Command(axis) => self.motion.drive.command(axis)[row],
            Source::Encoder(axis) | Source::EncoderAngle(axis) => self.motion.prediction.servo[axis][row],
            Source::Screw(axis) | Source::ScrewAngle(axis) => self.screws[axis][row],
            Source::Joint(axis) => self.motion.prediction.joint[axis][row],
            Source::Position(k, c) => points[k][c],
        })
    }
}
