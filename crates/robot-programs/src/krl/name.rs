//! A declared point, and whether the text tells its value: it does where the point is declared with it, and where it is given
//! it once, by a line that certainly runs before every use. Data lists keep values from one run to the next, so that a use
//! that runs before the assignment finds another value there.

use super::aggregate::Aggregate;
use super::reason::{Reason, Uncertain};
use crate::script::{Few, Span};

/// What a point holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Holds {
    Axes,
    Pose,
}

/// A declared point.
#[derive(Debug, Clone)]
pub(super) struct Name {
    pub text: String,
    pub file: usize,
    /// Line of its declaration, from 0.
    pub line: usize,
    /// Word of its type.
    pub type_word: Span,
    pub holds: Holds,
    pub local: bool,
    pub global: bool,
    /// Declared in another module: it is never written.
    pub context: bool,
    /// An array: its elements are separate names.
    pub array: bool,
    /// The array of an element.
    pub of: Option<usize>,
    pub given: Option<Aggregate>,
    /// Assignments of the whole point in the program.
    pub assigned: Few<Assigned>,
    /// Something uses it, in the part of the program that has been read.
    pub used: bool,
    /// Why its value is not certain.
    pub spoiled: Option<Box<Uncertain>>,
    /// Something else than an assignment of its parts in the program makes it uncertain, too.
    pub spoiled_whole: bool,
    /// Something else than a motion reads it.
    pub read: bool,
}

/// `XP1={A1 5.0,...}` as a statement.
#[derive(Debug, Clone)]
pub(super) struct Assigned {
    /// From 0.
    pub line: usize,
    pub routine: usize,
    pub aggregate: Option<Aggregate>,
    /// The point that it takes its value from.
    pub from: Option<usize>,
    /// It certainly runs before whatever stands after it in its routine.
    pub always: bool,
}

impl Name {
    /// The aggregate that gives its value, where there is exactly one.
    pub fn value(&self) -> std::result::Result<&Aggregate, Reason> {
        let name = || Box::from(self.text.as_str());
        if let Some(why) = &self.spoiled {
            return Err(Reason::Uncertain { name: name(), why: why.clone() });
        }
        if self.array {
            return Err(Reason::Array(name()));
        }
        match (&self.given, self.assigned.as_slice()) {
            (Some(a), []) => Ok(a),
            (None, [Assigned { aggregate: Some(a), always: true, .. }]) if !self.global => Ok(a),
            (None, []) => Err(Reason::NoValue(name())),
            (None, [Assigned { aggregate: Some(_), always: false, line, .. }]) => {
                Err(Reason::AssignedSometimes { name: name(), line: *line as u64 + 1 })
            }
            (_, [a, ..]) => Err(Reason::Assigned { name: name(), line: a.line as u64 + 1 }),
        }
    }

    /// Its value is not certain, for a reason that stands there unless another one does already.
    pub fn spoil(&mut self, why: Uncertain) {
        self.spoiled_whole |= !matches!(why, Uncertain::PartAssigned(_));
        self.spoiled.get_or_insert_with(|| Box::new(why));
    }

    /// A use in a routine. Another routine than that of its assignment may run before it.
    pub fn used_in(&mut self, routine: usize) {
        self.used = true;
        self.assigned.iter_mut().filter(|a| a.routine != routine).for_each(|a| a.always = false);
    }
}

/// Whether a line certainly runs where its routine runs on after it.
#[derive(Debug, Default)]
pub(super) struct Flow {
    /// Blocks around it that may be passed by.
    depth: usize,
    /// A jump before it.
    jumps: bool,
}

impl Flow {
    /// A line by its first word. The body of LOOP and REPEAT runs once at least.
    pub fn pass(&mut self, first: &str) {
        match first {
            "IF" | "SWITCH" | "FOR" | "WHILE" => self.depth += 1,
            "ENDIF" | "ENDSWITCH" | "ENDFOR" | "ENDWHILE" => self.depth = self.depth.saturating_sub(1),
            "GOTO" | "EXIT" => self.jumps = true,
            _ => {}
        }
    }

    pub fn certain(&self) -> bool {
        self.depth == 0 && !self.jumps
    }
}
