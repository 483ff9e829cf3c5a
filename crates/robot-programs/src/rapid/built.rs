//! What is needed to write the moves of a module again.

use super::arguments::Arg;
use crate::script::alike::Anchors;
use crate::script::blocks::BySteps;
use crate::script::sites::Time;
use crate::script::{Few, Script, Span as Bytes};
use std::ops::Range;
use std::sync::Arc;

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
    /// Other modules of the task see it, and so do they what is declared beside it.
    pub shared: bool,
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

/// Where a move stands, in little memory: moves that differ in their numbers alone have one site in common.
#[derive(Debug, Clone)]
pub struct SharedSite {
    model: Arc<(Site, Anchors)>,
    /// Its own places instead of those of the model.
    start: u32,
    first: u32,
    last: u32,
}

impl SharedSite {
    /// Where the model itself stands.
    pub fn of(site: Site) -> Self {
        Self::new(&Arc::new((site, Anchors { start: 0, first: 0, last: 0 })), Anchors { start: 0, first: 0, last: 0 })
    }

    /// A move like the one of a site whose line has these anchors.
    pub fn new(model: &Arc<(Site, Anchors)>, at: Anchors) -> Self {
        let [start, first, last] = [at.start, at.first, at.last].map(|byte| byte as u32);
        Self { model: Arc::clone(model), start, first, last }
    }

    /// What does not differ from move to move: all but the bytes.
    pub fn model(&self) -> &Site {
        &self.model.0
    }

    /// The site of the move.
    pub fn shown(&self) -> Site {
        let [start, first, last] = [self.start, self.first, self.last].map(|byte| byte as usize);
        let at = Anchors { start, first, last };
        let (site, of_model) = &*self.model;
        if at == *of_model { site.clone() } else { site.moved(of_model.to(at)) }
    }
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
    pub sites: BySteps<SharedSite>,
    /// One per target of the script.
    pub literals: Vec<Literal>,
}
