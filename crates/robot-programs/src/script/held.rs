//! What may be in force where control comes from several places: states that instructions switch on and off (weaving, a sensor that
//! leads), followed through labels, jumps and blocks until nothing is added.
//!
//! A state counts as on wherever one way through the program leaves it on: an instruction that switches it off and may be passed by
//! ends nothing for those who pass by.

use std::collections::BTreeMap;

/// What a line of a program means here.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Event {
    /// Nothing.
    #[default]
    Other,
    /// A label.
    Label(String),
    /// A jump that may be taken; `None`: to any label.
    Jump(Option<String>),
    /// A block opens: what stands in it may be passed by; of a loop (`true`), it may be done again.
    Open(bool),
    /// Another branch.
    Middle,
    /// Its end.
    Close,
    /// A jump to the end of an open block.
    Leave,
    /// States, as bits, that go on.
    On(u32),
    /// States that go off.
    Off(u32),
}

/// A block that is open.
struct Block {
    line: usize,
    repeats: bool,
    before: u32,
    /// At the ends of its branches.
    ends: u32,
}

/// States at labels and at the end of loops, from wherever control comes.
#[derive(Default)]
struct Joins {
    labels: BTreeMap<String, u32>,
    any: u32,
    loops: BTreeMap<usize, u32>,
}

/// The states, as bits, that may be on before each line, and after the last; `start`: those at the start.
pub fn before_each(events: &[Event], start: u32) -> Vec<u32> {
    let mut joins = Joins::default();
    // what is joined only grows, so that it comes to an end
    let mut states = joins.pass(events, start);
    loop {
        let next = joins.pass(events, start);
        if next == states {
            return states;
        }
        states = next;
    }
}

/// The states that a text switches off before it ever switches them on: something before it did.
pub fn from_before(events: &[Event]) -> u32 {
    let (mut seen, mut found) = (0, 0);
    for event in events {
        match event {
            Event::On(bits) => seen |= bits,
            Event::Off(bits) => found |= bits & !seen,
            _ => {}
        }
    }
    found
}

impl Joins {
    fn pass(&mut self, events: &[Event], start: u32) -> Vec<u32> {
        let (mut now, mut open) = (start, Vec::<Block>::new());
        let mut states = Vec::with_capacity(events.len() + 1);
        for (line, event) in events.iter().enumerate() {
            match event {
                Event::Label(name) => {
                    let joined = self.labels.entry(name.clone()).or_default();
                    *joined |= now;
                    now = *joined | self.any;
                }
                Event::Jump(Some(name)) => *self.labels.entry(name.clone()).or_default() |= now,
                Event::Jump(None) => self.any |= now,
                Event::Open(repeats) => {
                    now |= self.loops.get(&line).copied().unwrap_or_default();
                    open.push(Block { line, repeats: *repeats, before: now, ends: 0 });
                }
                Event::Middle => {
                    if let Some(block) = open.last_mut() {
                        block.ends |= now;
                        now = block.before;
                    }
                }
                Event::Close => {
                    if let Some(block) = open.pop() {
                        if block.repeats {
                            *self.loops.entry(block.line).or_default() |= now;
                        }
                        now |= block.before | block.ends;
                    }
                }
                Event::Leave => open.iter_mut().for_each(|block| block.ends |= now),
                Event::Other | Event::On(_) | Event::Off(_) => {}
            }
            states.push(now);
            match event {
                Event::On(bits) => now |= bits,
                Event::Off(bits) => now &= !bits,
                _ => {}
            }
        }
        states.push(now);
        states
    }
}

#[cfg(test)]
mod tests {
    use super::Event::{self, Close, Jump, Label, Leave, Middle, Off, On, Open, Other};
    use super::{before_each, from_before};

    fn to(name: &str) -> Event {
        Jump(Some(name.into()))
    }

    fn at(name: &str) -> Event {
        Label(name.into())
    }

    #[test]
    fn what_may_be_passed_by_ends_nothing() {
        // worked out by hand, line by line
        let cases = [
            ("straight", vec![On(1), Other, Off(1), Other], vec![0, 1, 1, 0, 0]),
            ("a jump past the end", vec![On(1), to("A"), Off(1), at("A"), Other], vec![0, 1, 1, 1, 1, 1]),
            ("a branch with the end", vec![On(1), Open(false), Off(1), Close, Other], vec![0, 1, 1, 1, 1, 1]),
            ("a jump back", vec![at("A"), Other, On(2), to("A")], vec![2, 2, 2, 2, 2]),
            (
                "a label elsewhere",
                vec![at("A"), On(2), to("B"), Off(2), at("A"), Other, at("B")],
                vec![0, 0, 2, 2, 0, 0, 2, 2],
            ),
            (
                "perhaps neither branch",
                vec![On(1), Open(false), Off(1), Middle, Off(1), Close],
                vec![0, 1, 1, 1, 1, 1, 1],
            ),
            ("out of a loop", vec![Open(true), On(1), Leave, Off(1), Close, Other], vec![0, 0, 1, 1, 1, 1, 1]),
            ("round a loop", vec![Open(true), Other, On(4), Close], vec![4, 4, 4, 4, 4]),
            ("to any label", vec![at("A"), On(1), Jump(None), Off(1)], vec![1, 1, 1, 1, 0]),
        ];
        for (what, events, expected) in cases {
            assert_eq!(before_each(&events, 0), expected, "{what}");
        }
    }

    #[test]
    fn what_is_ended_first_was_on_before() {
        assert_eq!(from_before(&[Other, Off(1), On(1), Off(1), On(2), Off(2)]), 1);
    }
}
