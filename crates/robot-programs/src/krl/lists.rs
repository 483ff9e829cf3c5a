//! `BASE_DATA` and `TOOL_DATA` of the controller, as far as the text sets them.

use crate::script::pose::Frame;
use std::collections::BTreeMap;
use std::fmt::Display;

/// Which of the lists.
pub(super) const BASES: usize = 0;
pub(super) const TOOLS: usize = 1;
/// What KRL calls them.
pub(super) const LISTS: [&str; 2] = ["BASE_DATA", "TOOL_DATA"];

/// What the text sets in the lists.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Lists {
    /// By number.
    frames: [BTreeMap<u32, Frame>; 2],
    /// They are set by an index that is computed: any of them may be another one.
    any: [bool; 2],
}

impl Lists {
    /// An assignment to the element of a number; `None`: which is not known.
    pub fn set(&mut self, list: usize, number: Option<f64>, frame: impl FnOnce(f64) -> Frame) {
        match number.filter(|n| *n > 0.0 && n.fract() == 0.0) {
            Some(n) => drop(self.frames[list].insert(n as u32, frame(n))),
            None => {
                self.frames[list].clear();
                self.any[list] = true;
            }
        }
    }

    /// The frame of a list by its number, as the text has set it.
    pub fn of(&self, list: usize, frame: Frame) -> Frame {
        let (Frame::Named(name) | Frame::Computed(name)) = &frame else { return frame };
        match name.parse().ok().and_then(|n: u32| self.frames[list].get(&n).cloned()) {
            Some(own) => own,
            None if self.any[list] => as_set(name),
            None => frame,
        }
    }

    /// Takes what another assignment sets, wherever it stands: by number, any of these.
    pub fn add(&mut self, set: &Self) {
        for (all, own) in self.frames.iter_mut().zip(&set.frames) {
            for (n, frame) in own {
                let both = all.remove(n).map_or_else(|| frame.clone(), |there| either(there, frame.clone()));
                all.insert(*n, both);
            }
        }
        self.add_any(set);
    }

    fn add_any(&mut self, other: &Self) {
        self.any.iter_mut().zip(other.any).for_each(|(own, other)| *own |= other);
    }

    /// Where control may come from elsewhere: a list holds what it held here, or what the text sets anywhere; `unset`: or what the
    /// controller has.
    pub fn merge_all(&mut self, all: &Self, unset: bool) {
        for ((list, other), any) in self.frames.iter_mut().zip(&all.frames).zip(all.any) {
            for (n, frame) in other {
                let frame = if any { either(frame.clone(), as_set(n)) } else { frame.clone() };
                let own = Frame::Named(n.to_string());
                let here = list.remove(n).unwrap_or_else(|| own.clone());
                let here = if unset { either(own, here) } else { here };
                list.insert(*n, either(here, frame));
            }
        }
        self.add_any(all);
    }

    /// After a block that may have been passed by: what it has put into a list, or what was there before.
    pub fn merge(&mut self, before: &Self) {
        for (list, was) in self.frames.iter_mut().zip(&before.frames) {
            for n in was.keys().copied().chain(list.keys().copied()).collect::<Vec<u32>>() {
                let of = |list: &BTreeMap<u32, Frame>| list.get(&n).cloned().unwrap_or(Frame::Named(n.to_string()));
                let merged = either(of(was), of(list));
                list.insert(n, merged);
            }
        }
        self.add_any(before);
    }
}

/// An element that is not known before the program runs.
pub(super) fn as_set(number: impl Display) -> Frame {
    Frame::Computed(format!("{number} as the program sets it"))
}

/// One of two frames, and which is not certain.
fn either(a: Frame, b: Frame) -> Frame {
    let of = |frame| match frame {
        Frame::Any(all) => all,
        one => vec![one],
    };
    let mut all = of(a);
    for frame in of(b) {
        if !all.contains(&frame) {
            all.push(frame);
        }
    }
    match all.len() {
        1 => all.remove(0),
        _ => Frame::Any(all),
    }
}

/// Base and tool as `either` of both.
pub(super) fn one_of(a: Option<&Frame>, name: &str, b: Option<&Frame>) -> Option<Frame> {
    let named = || Frame::Named(name.into());
    match (a, b) {
        (None, None) => None,
        (a, b) => Some(either(a.cloned().unwrap_or_else(named), b.cloned().unwrap_or_else(named))),
    }
}
