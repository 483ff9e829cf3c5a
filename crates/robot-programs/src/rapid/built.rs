//! What is needed to write the moves of a module again.

use super::arguments::Arg;
use crate::script::blocks::BySteps;
use crate::script::sites::Time;
use crate::script::{Few, Script, Span as Bytes};
use std::ops::Range;

/// A target as it can be written: bytes of its list, and where it is declared.
#[derive(Debug, Clone)]
pub struct Literal {
    /// In the text of the program with its context.
    pub bytes: Bytes,
    pub owner: Option<Box<Owner>>,
    /// Its text where it stands in another module, or is computed: numbers count from its start.
    pub foreign: Option<Box<[u8]>>,
}

/// Declaration of a target.
#[derive(Debug, Clone)]
pub struct Owner {
    /// From `LOCAL` or `CONST` to after the `;`.
    pub bytes: Range<usize>,
    /// `LOCAL CONST jointtarget`, as it is written.
    pub head: String,
    pub name: String,
    /// Its value is read elsewhere, or other modules may use it: it must stay.
    pub keep: bool,
}

/// Where a move stands.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Site {
    /// Instruction to after the `;`.
    pub bytes: Bytes,
    pub word: Bytes,
    pub args: Box<[Written]>,
    /// Which of `args` are target and zone.
    pub goal: u16,
    pub zone: Option<u16>,
    /// Of an arc that may be split: which of `args` is the point on its way.
    pub via: Option<u16>,
    /// Name or list of the target within it: that of the point in `Offs(p1,0,0,100)`.
    pub point: Bytes,
    /// `\T:=` of the whole move: bytes of the number, s, style.
    pub time: Option<Box<Time>>,
    /// External axes of a robtarget as text, for joint moves in its place.
    pub external: Option<Box<str>>,
}

/// An argument as it is written, with names and bytes of its switches.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    pub bytes: Bytes,
    pub switches: Few<(Box<str>, Bytes)>,
}

impl From<Arg> for Written {
    fn from(arg: Arg) -> Self {
        let switches = arg.switches.into_iter().map(|s| (s.name.into(), s.bytes.into())).collect();
        Self { bytes: arg.bytes.into(), switches }
    }
}

#[derive(Default)]
pub struct Built {
    pub script: Script,
    pub sites: BySteps<Site>,
    /// One per target of the script.
    pub literals: Vec<Literal>,
}
