//! What may be in force where control comes from several places: states that instructions switch on and off (weaving, a sensor that
//! leads), followed through labels, jumps and blocks until nothing is added.
//!
//! A state counts as on wherever one way through the program leaves it on: an instruction that switches it off and may be passed by
//! ends nothing for those who pass by. A program that is called leaves behind what its own text does, as far as that text is there
//! ([`Effects`]); one that is not there leaves everything as it was.

use std::collections::BTreeMap;

/// What running a program does to the states, as bits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Effect {
    /// That it may leave on, whatever was on before it.
    leaves: u32,
    /// That may stay on through it.
    keeps: u32,
}

/// What the programs that may be called do, by their names.
#[derive(Debug, Default)]
pub struct Effects(BTreeMap<String, Effect>);

impl Effects {
    /// Of programs by their names, which may call each other. Of several with one name any may be meant.
    pub fn of(programs: &[(String, Vec<Event>)]) -> Self {
        let mut known = Self(programs.iter().map(|(name, _)| (name.clone(), Effect::default())).collect());
        // effects only grow, so that it comes to an end
        loop {
            let mut next = Self::default();
            for (name, events) in programs {
                let end = |start| at_end(events, start, &known);
                let all = next.0.entry(name.clone()).or_default();
                all.leaves |= end(0);
                all.keeps |= end(u32::MAX);
            }
            if next.0 == known.0 {
                return known;
            }
            known = next;
        }
    }

    /// Whether none of the programs switches anything.
    pub fn is_empty(&self) -> bool {
        self.0.values().all(|e| *e == Effect { leaves: 0, keeps: u32::MAX })
    }
}

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
    /// A program is called.
    Call(String),
    /// The program may end here.
    End,
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
pub fn before_each(events: &[Event], start: u32, called: &Effects) -> Vec<u32> {
    let mut joins = Joins::default();
    // what is joined only grows, so that it comes to an end
    let mut states = joins.pass(events, start, called);
    loop {
        let next = joins.pass(events, start, called);
        if next == states {
            return states;
        }
        states = next;
    }
}

/// The states that may be on where a program ends.
fn at_end(events: &[Event], start: u32, called: &Effects) -> u32 {
    let states = before_each(events, start, called);
    let ends = events.iter().zip(&states).filter(|(event, _)| **event == Event::End).map(|(_, state)| *state);
    ends.chain(states.last().copied()).fold(0, |all, state| all | state)
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
    fn pass(&mut self, events: &[Event], start: u32, called: &Effects) -> Vec<u32> {
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
                Event::Other | Event::On(_) | Event::Off(_) | Event::Call(_) | Event::End => {}
            }
            states.push(now);
            match event {
                Event::On(bits) => now |= bits,
                Event::Off(bits) => now &= !bits,
                Event::Call(name) => {
                    if let Some(effect) = called.0.get(name) {
                        now = now & effect.keeps | effect.leaves;
                    }
                }
                _ => {}
            }
        }
        states.push(now);
        states
    }
}

#[cfg(test)]
mod tests {
    use super::Event::{self, Call, Close, End, Jump, Label, Leave, Middle, Off, On, Open, Other};
    use super::{Effects, before_each, from_before};

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
            assert_eq!(before_each(&events, 0, &Effects::default()), expected, "{what}");
        }
    }

    fn call(name: &str) -> Event {
        Call(name.into())
    }

    #[test]
    fn a_program_that_is_called_leaves_on_what_it_switches_on() {
        // worked out by hand: what holds after `call(A)`, from nothing and from both states
        let cases = [
            ("it switches on", vec![("A", vec![On(1)])], [1, 3]),
            ("it switches off", vec![("A", vec![Off(1)])], [0, 2]),
            ("it does both", vec![("A", vec![On(1), Other, Off(1)])], [0, 2]),
            ("it may end in between", vec![("A", vec![On(1), End, Off(1)])], [1, 3]),
            ("it may not come there", vec![("A", vec![Open(false), Off(1), Close])], [0, 3]),
            ("through another", vec![("A", vec![call("B"), Off(2)]), ("B", vec![On(1)])], [1, 1]),
            ("it calls itself", vec![("A", vec![Open(false), On(1), call("A"), Close])], [1, 3]),
            ("one of two", vec![("A", vec![On(1)]), ("A", vec![Off(2)])], [1, 3]),
            ("another one", vec![("B", vec![On(1)])], [0, 3]),
        ];
        for (what, programs, expected) in cases {
            let programs: Vec<_> = programs.into_iter().map(|(name, events)| (name.to_string(), events)).collect();
            let effects = Effects::of(&programs);
            let after = [0, 3].map(|start| before_each(&[call("A")], start, &effects)[1]);
            assert_eq!(after, expected, "{what}");
        }
    }

    #[test]
    fn what_is_ended_first_was_on_before() {
        assert_eq!(from_before(&[Other, Off(1), On(1), Off(1), On(2), Off(2)]), 1);
    }
}
