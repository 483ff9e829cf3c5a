//! Which moves of a program without routines may come last before places at which it reads where the robot stands, along control
//! ([`reach`]): through labels, jumps and blocks, and from the end of the program to its start, as it may be run again.

use super::held::Event;
use super::reach::{self, Atoms, BEFORE, Block, FIRST, Reach, Routine};
use std::collections::BTreeSet;

/// The kind of setting that is followed: the move that came last.
const LAST: usize = 0;
/// The name of the program here.
const PROGRAM: &str = "program";

/// Places, from 0, whose moves may come last before, or at, one of those that are `asked` for, ascending. `events`: what the places mean;
/// `first`: the first event of each.
pub fn before(events: &[Event], first: &[usize], moves: &BTreeSet<usize>, asked: &[usize]) -> BTreeSet<usize> {
    if asked.is_empty() {
        return BTreeSet::new();
    }
    let labels = || events.iter().filter_map(|e| if let Event::Label(name) = e { Some(name) } else { None });
    // a place stands after its number in the events, so that the first one has a place before it
    let mut program = Routine { name: PROGRAM.into(), events: Vec::new() };
    for (place, start) in first.iter().enumerate() {
        if moves.contains(&place) {
            program.comes_last(place + 1, LAST, place, asked);
        }
        let end = first.get(place + 1).copied().unwrap_or(events.len());
        for event in events.get(*start..end).unwrap_or_default() {
            program.events.extend(of(event, &labels).into_iter().map(|e| (place + 1, e)));
        }
    }
    let again = [reach::Event::Open(Block::Endless), reach::Event::Call(PROGRAM.into()), reach::Event::Close];
    let outside = Routine { name: String::new(), events: again.into_iter().map(|e| (0, e)).collect() };
    let nothing = vec![Atoms::from([BEFORE])];
    let reach = Reach::of(&[program, outside], &[None, Some(nothing.clone())], &nothing);
    let mut found = Atoms::new();
    for place in asked {
        // what stands on the place itself may come before its reading
        let states = [*place, *place + 1].into_iter().filter_map(|at| reach.after(0, at));
        found.extend(states.flat_map(|s| s.iter().flatten()));
    }
    found.into_iter().filter_map(|atom| Some(atom.checked_sub(FIRST)? as usize)).collect()
}

/// The same event as one of [`reach`]; a jump that may be taken goes on, too.
fn of<'a, I: Iterator<Item = &'a String>>(event: &Event, labels: &dyn Fn() -> I) -> Vec<reach::Event> {
    use reach::Event::{Close, End, Jump, Label, Leave, Middle, Open};
    let perhaps = |event: reach::Event| vec![Open(Block::Branch), event, Close];
    match event {
        Event::Label(name) => vec![Label(name.clone())],
        Event::Jump(Some(name)) => perhaps(Jump(name.clone())),
        Event::Jump(None) => {
            let each = labels().flat_map(|name| [Middle(false), Jump(name.clone())]);
            std::iter::once(Open(Block::Switch)).chain(each).chain([Close]).collect()
        }
        Event::Open(repeats) => vec![Open(if *repeats { Block::Loop } else { Block::Branch })],
        Event::Middle => vec![Middle(false)],
        Event::Close => vec![Close],
        Event::Leave => perhaps(Leave),
        Event::End => perhaps(End),
        Event::Other | Event::On(_) | Event::Off(_) | Event::Call(_) => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moves, places that are asked for, and what comes last before these.
    type Places<'a> = [&'a [usize]; 3];

    #[test]
    fn the_move_before_a_place_is_found_along_control() {
        let to = |name: &str| Event::Jump(Some(name.into()));
        let at = |name: &str| Event::Label(name.into());
        let other = || Event::Other;
        // one event per place; worked out by hand
        let cases: [(&str, Vec<Event>, Places<'_>); 7] = [
            ("straight", vec![other(), other(), other(), other()], [&[0, 1, 3], &[2], &[1]]),
            ("around a jump", vec![other(), to("A"), other(), at("A"), other()], [&[0, 2], &[4], &[0, 2]]),
            (
                "round a loop",
                vec![other(), Event::Open(true), other(), other(), Event::Close],
                [&[0, 3], &[2], &[0, 3]],
            ),
            ("a jump back", vec![at("A"), other(), other(), to("A")], [&[2], &[1], &[2]]),
            ("when it is run again", vec![other(), other(), other()], [&[1, 2], &[0], &[2]]),
            ("the move of the place", vec![other(), other()], [&[0, 1], &[1], &[0, 1]]),
            ("to any label", vec![other(), Event::Jump(None), other(), at("A"), other()], [&[0, 2], &[4], &[0, 2]]),
        ];
        for (what, events, [moves, asked, expected]) in cases {
            let first: Vec<usize> = (0..events.len()).collect();
            let found = before(&events, &first, &moves.iter().copied().collect(), asked);
            assert_eq!(found.into_iter().collect::<Vec<_>>(), expected, "{what}");
        }
    }
}
