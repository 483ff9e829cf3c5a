//! Rows of a predicted log as text: blocks of rows, predicted side by side and written in order.

use super::*;
use crate::error::{Error, Result, one_line};
use crate::log::write::{field_between, number};
use crate::machine::parts;
use crate::model::Model;
use crate::numerics::parallel::ParMap;
use crate::simulate::noise::Noise;
use crate::simulate::{Motion, Options};
use std::io::Write;

/// What every row needs.
pub(super) struct Plan<'a> {
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
    pub(super) fn new(
        model: &'a Model,
        motion: &'a Motion,
        options: &'a Options,
        columns: Vec<Named>,
        style: Style,
    ) -> Self {
        let sources = || columns.iter().map(|c| c.1);
        let last = sources().map(|s| if let Source::Position(k, _) = s { k } else { 0 }).max().unwrap_or(0);
        let written =
            |axis: usize| sources().any(|s| matches!(s, Source::Screw(a) | Source::ScrewAngle(a) if a == axis));
        let screws = (0..model.robot.dof())
            .map(|a| if written(a) { parts::between_gaps(model, &motion.trajectory, a) } else { Vec::new() })
            .collect();
        Self { model, motion, options, columns, style, reflectors: last + 1, screws }
    }

    pub(super) fn head(&self, from: &str, out: &mut dyn Write) -> Result<()> {
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
    pub(super) fn rows(
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
            .par_map(|b| {
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
            .into_iter()
            .collect();
        for block in &blocks? {
            out.write_all(block).map_err(|e| Error::io("output", "write", e))?;
        }
        Ok(())
    }

    /// The refusal of a row with a value that is no number.
    fn no_number(&self, row: usize) -> Error {
        let t_s = self.motion.trajectory.t_s()[row];
        Error::setting(
            "model",
            format!("effects that predict no finite number for row {} (time {t_s} s)", row + 1),
            "parameters, times and commands of plausible sizes; nothing was written",
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
                Source::Time(decimals) => number(text, self.motion.trajectory.t_s()[row], decimals),
                Source::Command(axis) => joint(text, axis, self.motion.trajectory.command(axis)[row]),
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
            Source::Time(_) => self.motion.trajectory.t_s()[row],
            Source::Command(axis) => self.motion.trajectory.command(axis)[row],
            Source::Encoder(axis) | Source::EncoderAngle(axis) => self.motion.prediction.servo[axis][row],
            Source::Screw(axis) | Source::ScrewAngle(axis) => self.screws[axis][row],
            Source::Joint(axis) => self.motion.prediction.joint[axis][row],
            Source::Position(k, c) => points[k][c],
        })
    }
}
