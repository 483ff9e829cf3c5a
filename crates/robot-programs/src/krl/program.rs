//! A program that has been read.

use super::data::Data;
use super::made::Made;
use super::motion::Motion;
use crate::axes::JointKind;
use crate::error::{Error, Result};
use crate::script::blocks::BySteps;
use crate::script::{Script, Span, Text};

/// Where a target's numbers stand.
pub(super) enum Source {
    /// In the motion: file, and bytes of the aggregate.
    Inline(u16, Span),
    /// In the declaration (or the only assignment) of a name.
    Name(u32),
    /// In an aggregate that is put together for one motion, and takes the place of its goal.
    Made(Box<Made>),
}

/// A program that has been read.
pub(super) struct Program {
    pub(super) script: Script,
    pub(super) kinds: Vec<JointKind>,
    /// Axis names as KRL has them: A1, ..., A6, E1, ...
    pub(super) axes: Vec<String>,
    /// By step.
    pub(super) motions: BySteps<Motion>,
    pub(super) data: Data,
    /// One per target.
    pub(super) sources: Vec<Source>,
}

impl Program {
    /// The place of a step, as messages show it.
    pub(super) fn place(&self, step: usize) -> String {
        self.script.steps.get(step).map(|s| self.script.place(s.at).to_string()).unwrap_or_default()
    }

    /// The motion of a step that can be written again.
    pub(super) fn motion(&self, step: usize) -> Result<&Motion> {
        let no = || Error::Refused(format!("{}: this motion cannot be rewritten", self.place(step)));
        self.motions.get(step).ok_or_else(no)
    }

    /// The text in which the numbers of a target stand.
    pub(super) fn text_of_target(&self, target: usize) -> Option<&Text> {
        match self.sources.get(target) {
            Some(Source::Made(made)) => Some(&made.text),
            _ => self.script.texts.get(self.script.targets.get(target)?.at.file),
        }
    }

    /// The text of a file.
    pub(super) fn text(&self, file: usize) -> Result<&Text> {
        self.script.texts.get(file).ok_or_else(|| Error::Refused("a text that is not there".into()))
    }
}
