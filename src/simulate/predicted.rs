//! The predicted log as CSV.
//!
//! From a program: `t_s`, `cmd_*`, `enc_*` where requested, the TCP, the robot's further reflectors. From a log: its own
//! columns in their order, text as it was; what is a measurement (`x_mm`..., `enc_`, `screw_`, `meas_`) is predicted in its place,
//! and a TCP that the log has not is added. Commands have 6 decimals, positions [`POSITION_DECIMALS`] (1 nm). A log that was read
//! through a column map keeps its names, separator and decimal sign, and each predicted column its unit, sign and scale: the same map
//! reads it again.
//!
//! Parts:
//! - [`plan`]: the rows as text, in blocks.

mod plan;

use super::noise::Noise;
use super::note::Note;
use super::{Motion, Options};
use crate::effects::without_columns;
use crate::error::{Error, Place, Result, one_line};
use crate::io::input::Input;
use crate::log::columns::{Meaning, meaning};
use crate::log::read::reader;
use crate::log::text::{LogText, TextColumn};
use crate::log::write::{joint_column, position_columns};
use crate::model::Model;
use plan::Plan;
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
    pub notes: Vec<Note>,
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
    Ok(Written { rows: motion.len(), notes: idle(model, motion) })
}

/// Effects that follow columns which the motion does not have.
fn idle(model: &Model, motion: &Motion) -> Vec<Note> {
    without_columns(&model.effects, &model.robot, &[&motion.trajectory]).into_iter().map(Note::Idle).collect()
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
    notes: &mut Vec<Note>,
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
            None => notes.push(Note::NoReflector { column: one_line(name) }),
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
    let mut written = Written { rows: motion.len(), notes: idle(model, motion) };
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
    let start = motion.trajectory.t_s().first().copied().unwrap_or(0.0);
    (3..6).find(|&d| whole(10f64.powi(d) / rate_hz) && whole(10f64.powi(d) * start)).unwrap_or(6) as u8
}
