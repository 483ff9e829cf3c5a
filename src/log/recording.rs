//! The columns of a file that is no whole log: a controller's without the tracker, a tracker's without commands.
//!
//! Read as a log is (names, maps, units, refusals with their place), but nothing must be there, and times need not increase: what they
//! are worth is for [`crate::join`] to judge.

use super::columns::{ColumnMap, Meaning, unit_named};
use super::read::table;
use super::text::LogText;
use crate::error::Result;
use crate::io::bag::TopicChoice;
use crate::io::input::{self, Input};
use crate::robot::Robot;
use nalgebra::Vector3;
use std::path::Path;

/// A file, column by column.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Name of the file as messages show it.
    pub name: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Line in the file of each row.
    pub line: Vec<u32>,
    /// Its columns but time.
    pub channels: Vec<Channel>,
    /// A recording of ROS 2 without a column map: its numbers are taken for rad and m, as its messages define them.
    pub is_si: bool,
}

/// A column in SI; an empty cell is NaN.
#[derive(Debug, Clone)]
pub struct Channel {
    /// What the column holds.
    pub meaning: Meaning,
    /// One value per row, SI; NaN in empty cells.
    pub values: Vec<f64>,
    /// Digits after the point in the unit of the contract.
    pub decimals: u8,
}

impl Recording {
    /// Reads a file, through a column map where one is given; `wanted` of a recording with several topics.
    pub fn load(path: &Path, robot: &Robot, map: Option<&ColumnMap>, wanted: TopicChoice) -> Result<Self> {
        Self::parse(input::read(path)?, robot, map, wanted)
    }

    /// Parses the bytes of a file.
    pub fn parse(input: Input, robot: &Robot, map: Option<&ColumnMap>, wanted: TopicChoice) -> Result<Self> {
        let (name, sha256) = (input.name.clone(), input.sha256.clone());
        let text = LogText::of(input, robot, map, wanted)?;
        let is_si = text.is_recording && map.is_none();
        let (table, columns) = table(&text, robot, |head, _, separator| head.refuse_one_piece(&name, separator))?;
        let channels = columns
            .iter()
            .zip(table.values.into_iter().zip(table.decimals))
            .map(|(column, (mut values, decimals))| {
                if let Some(stamp) = column.stamp {
                    stamp.since_first(&mut values);
                }
                values.iter_mut().for_each(|v| *v *= column.factor);
                let decimals = (f64::from(decimals) - column.edge.log10()).floor().clamp(0.0, 15.0) as u8;
                Channel { meaning: column.meaning, values, decimals }
            })
            .collect();
        Ok(Self { name, sha256, line: table.line, channels, is_si })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.line.len()
    }

    /// The values of a column, SI.
    pub fn values(&self, meaning: Meaning) -> Option<&[f64]> {
        self.channels.iter().find(|c| c.meaning == meaning).map(|c| c.values.as_slice())
    }

    /// Positions of the TCP, m; `None` where the tracker lost the reflector; empty without such columns.
    pub fn positions_m(&self) -> Vec<Option<Vector3<f64>>> {
        let [x, y, z] = [0, 1, 2].map(|coordinate| self.values(Meaning::Position { k: 0, coordinate }));
        let (Some(x), Some(y), Some(z)) = (x, y, z) else { return Vec::new() };
        let point = |i: usize| Some(Vector3::new(x[i], y[i], z[i])).filter(|p| !p.sum().is_nan());
        (0..self.rows()).map(point).collect()
    }
}

/// SI per unit in which the contract writes a column.
pub fn si_per_unit(meaning: Meaning, robot: &Robot) -> f64 {
    meaning.unit(robot).and_then(unit_named).map_or(1.0, |u| u.1)
}
