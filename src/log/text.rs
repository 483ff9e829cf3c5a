//! The text of a log: a recording's topic or a workbook's sheet as CSV, a file as it is; and what each of its columns is, for those
//! who write the log again.

use super::Log;
use super::columns::{Column, ColumnMap, Meaning, resolve};
use super::read::Head;
use crate::error::{Place, Result};
use crate::io::bag::{self, TopicChoice};
use crate::io::input::{self, Input};
use crate::io::workbook;
use crate::robot::Robot;

/// A log as text, with the map through which it is read.
#[derive(Debug)]
pub struct LogText {
    /// The file.
    pub input: Input,
    /// Byte between fields.
    pub separator: u8,
    /// Byte before the decimals.
    pub decimal: u8,
    /// A topic of a recording of ROS 2, whose columns have their own names.
    pub is_recording: bool,
    map: Option<ColumnMap>,
}

/// A column whose numbers a log uses.
#[derive(Debug, Clone, PartialEq)]
pub struct TextColumn {
    /// Field number from 0.
    pub index: usize,
    /// What it is; angles of a screw are its encoder or screw.
    pub meaning: Meaning,
    /// SI of the number 1 as written, sign and all.
    pub si_per_number: f64,
    /// Decimals that a number needs more than in the contract's unit, to show as much.
    pub more_decimals: i8,
}

impl LogText {
    /// The text of a file; `wanted` of a recording with several topics.
    pub fn of(input: Input, robot: &Robot, map: Option<&ColumnMap>, wanted: TopicChoice) -> Result<Self> {
        bag::refuse_sqlite(&input)?;
        let from_bag = bag::is_one(&input.bytes);
        let map = map.cloned().or_else(|| from_bag.then(|| ColumnMap::of_recording(robot)));
        let (input, from_sheet) = match from_bag {
            true => {
                let topic = map.as_ref().and_then(|m| m.topic.as_deref());
                let sought = |column: &str| map.as_ref().is_some_and(|m| m.of(column).is_some_and(|e| e.to.is_some()));
                (bag::unpacked_for(input, topic.map_or(wanted, TopicChoice::Topic), sought)?, true)
            }
            false => workbook::unpacked(input)?,
        };
        let map_of_text = map.as_ref().filter(|_| !from_sheet);
        let separator = map_of_text.map_or(b',', |m| m.separator_of(&input.bytes));
        let decimal = map_of_text.map_or(b'.', |m| m.decimal_of(&input.bytes, separator));
        Ok(Self { input, separator, decimal, is_recording: from_bag, map })
    }

    /// The log that it is.
    pub fn log(&self, robot: &Robot) -> Result<Log> {
        Log::of_text(self, robot)
    }

    /// The header and the columns that are used.
    pub(super) fn columns(&self, robot: &Robot) -> Result<(Head, Vec<Column>)> {
        let name = &self.input.name;
        input::refuse_utf16(name, &self.input.bytes)?;
        let head = Head::read(name, &self.input.bytes, self.separator)?;
        let at = Place::line(name, head.line);
        let columns = resolve(&head.names, robot, self.map.as_ref(), &at);
        let columns = columns.map_err(|e| head.explain(name, self.separator, e))?;
        Ok((head, columns))
    }

    /// Names of all columns, and what those are whose numbers are used.
    pub fn used(&self, robot: &Robot) -> Result<(Vec<String>, Vec<TextColumn>)> {
        let (head, columns) = self.columns(robot)?;
        let used = columns.into_iter().map(|c| TextColumn {
            index: c.index,
            meaning: c.meaning,
            si_per_number: c.factor,
            // a scale next to 1 is no other unit
            more_decimals: (c.edge.log10() - 1e-3).ceil().clamp(-15.0, 15.0) as i8,
        });
        Ok((head.names, used.collect()))
    }
}
