//! What a program does, in the order of its text.

use super::order::{Join, Round};
use super::step::{At, Move, Note, Step, StepKind};
use super::targets::Targets;
use super::{Text, pose};
use std::collections::{BTreeMap, BTreeSet};

/// What a program does, in the order of its text.
#[derive(Debug, Clone, Default)]
pub struct Script {
    /// The program's own text, then its companions, then its context.
    pub texts: Vec<Text>,
    /// In the order of the text.
    pub steps: Vec<Step>,
    /// Joint targets, inline or declared; moves name them by index. One may be used by several moves.
    pub targets: Targets,
    /// What a user should know, with its line: `second motion group is left as it is`.
    pub notes: Vec<Note>,
    /// Words that the program never says although its targets depend on them: `G90 or G91`.
    pub missing: Vec<&'static str>,
    /// No number of an axis word has a decimal point, so that whole numbers may count increments
    /// ([`crate::control::Control::whole_units`]).
    pub only_whole_numbers: bool,
    /// X words may be diameters, as it may be a program of a lathe, and nothing says so ([`crate::control::Control::diameter`]): they stay.
    pub diameter_unstated: bool,
    /// The [`Break::Start`](super::Break::Start) with which the program starts, where that is not the first.
    pub entry: Option<usize>,
    /// At its start the robot may stand anywhere: the program begins in a text that is not written with it, or runs again from more ends
    /// than are followed.
    pub starts_anywhere: bool,
    /// Loops whose every pass goes the same way, innermost ones alone.
    pub rounds: Vec<Round>,
    /// Breaks of which it is known from where alone control comes there, ascending.
    pub joins: Vec<Join>,
    /// The same as the text has them, ascending, each from the places that lead to it at once, and the starts of routines from the calls
    /// of them that the text holds; only where the program has processes.
    pub ways: Vec<Join>,
    /// The start of a program that runs again from there when it has ended, and the places at which it ends.
    pub again: Option<Join>,
    /// Lines whose calls may move the robot, and the names that would have to move nothing for these calls to move nothing: none of them is
    /// among the files. Lines of other calls that may move are not here.
    pub unknown_calls: BTreeMap<At, BTreeSet<String>>,
    /// What the controller's files of its project say of where the robot stands and how far its axes go.
    pub installed: Vec<Installed>,
    /// Where its project lets the arm work; only where the program names no joints and a target of it has no configuration.
    pub stance: Option<Stance>,
}

impl Script {
    /// At its start the robot may stand anywhere, or another program calls it.
    pub fn has_no_start(&self) -> bool {
        self.starts_anywhere || self.texts.first().is_some_and(|text| text.called)
    }
}

/// What a file of the controller says of where the robot stands and how far its axes go.
#[derive(Debug, Clone)]
pub struct Installed {
    /// Where it says so.
    pub at: At,
    /// The place of the robot's base in the world in which frames are given; inside `None`: its numbers cannot be read.
    pub root: Option<Option<nalgebra::Isometry3<f64>>>,
    /// Lowest and highest value of each axis, rad or m; `None`: not given.
    pub limits: Vec<Option<[f64; 2]>>,
}

/// Where the project of a program lets its arm work: what tells the configuration of targets that have none.
#[derive(Debug, Clone, Default)]
pub struct Stance {
    /// Joints of its home position, rad or m, one per axis.
    pub home: Vec<f64>,
    /// Joints of all its other points that name them.
    pub others: Vec<Vec<f64>>,
    /// Configurations of all its points that name one.
    pub configurations: Vec<pose::Configuration>,
}

impl Script {
    /// Place of a line for a message.
    pub fn place(&self, at: At) -> crate::error::Place {
        let name = self.texts.get(at.file).map_or("", |t| t.name.as_str());
        crate::error::Place::line(name, at.line)
    }

    /// The moves in order, with their steps.
    pub fn moves(&self) -> impl Iterator<Item = (usize, &Move)> {
        self.steps.iter().enumerate().filter_map(|(k, s)| match &s.kind {
            StepKind::Move(m) => Some((k, m)),
            _ => None,
        })
    }

    /// How many moves lead to each target.
    pub fn use_counts(&self) -> Vec<usize> {
        let mut counts = vec![0; self.targets.len()];
        for (_, m) in self.moves() {
            if let Some(count) = m.goal.target().and_then(|t| counts.get_mut(t)) {
                *count += 1;
            }
        }
        counts
    }

    /// Steps whose moves lead to each target.
    pub fn uses(&self) -> Vec<Vec<usize>> {
        let mut uses = vec![Vec::new(); self.targets.len()];
        for (k, m) in self.moves() {
            if let Some(t) = m.goal.target()
                && let Some(list) = uses.get_mut(t)
            {
                list.push(k);
            }
        }
        uses
    }
}

/// A comment's word for the tool: `lostmotion: off`, `lostmotion on`; `None`: the comment is not meant for it.
pub fn pragma(comment: &[u8]) -> Option<bool> {
    let text = String::from_utf8_lossy(comment).to_ascii_lowercase();
    let rest = text.trim_start_matches(|c: char| !c.is_ascii_alphanumeric()).strip_prefix("lostmotion")?;
    match rest.trim_matches(|c: char| !c.is_ascii_alphanumeric()) {
        "off" => Some(false),
        "on" => Some(true),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_switches_the_tool_off_and_on() {
        assert_eq!(pragma(b"' lostmotion: off"), Some(false));
        assert_eq!(pragma(b"; LOSTMOTION ON"), Some(true));
        assert_eq!(pragma(b"(lostmotion: on)"), Some(true));
        assert_eq!(pragma(b"! lostmotion is a tool"), None);
        assert_eq!(pragma(b"! weld on"), None);
    }
}
