//! Where something leads the arm away from its targets although the text of the routine does not say so: it was switched on before the
//! routine was called, or at the end of the pass of a loop before.

use super::facts;
use super::read::{Item, ItemKind, Parsed};
use super::rules::Going;
use super::words;
use crate::script::Text;
use std::collections::HashMap;

/// What may lead the arm at the start of routines, by their names, and of loops, by their first tokens.
#[derive(Default)]
pub struct Led {
    routines: HashMap<String, &'static str>,
    loops: HashMap<usize, &'static str>,
}

impl Led {
    /// Of all routines; `first`: what holds at the start of each of them, whoever calls it.
    pub fn of(text: &Text, p: &Parsed, first: Going) -> Self {
        let mut led = Self::default();
        if !p.words.different().any(|w| words::leads(w, false).is_some()) {
            return led;
        }
        // it only grows, so that it comes to an end
        while led.pass(text, p, first) {}
        led
    }

    /// At the start of an item: of a routine, or of a loop.
    pub fn enter(&self, p: &Parsed, item: &Item, first: Going, going: &mut Going) {
        match item.kind {
            ItemKind::Start => {
                *going = first;
                going.may_be_led(p.routines.get(item.routine).and_then(|r| self.routines.get(&r.name)).copied());
            }
            ItemKind::Loop => going.may_be_led(self.loops.get(&item.span.start).copied()),
            _ => {}
        }
    }

    /// Goes through all items once; `true`: something was found.
    fn pass(&mut self, text: &Text, p: &Parsed, first: Going) -> bool {
        let known = self.routines.len() + self.loops.len();
        let (mut going, mut before, mut loops) = (first, Vec::new(), Vec::new());
        for item in &p.items {
            going.follow(text, p, item);
            going.pass_by(&mut before, item.kind);
            self.enter(p, item, first, &mut going);
            match item.kind {
                ItemKind::Start => loops.clear(),
                ItemKind::Loop => loops.push(item.span.start),
                ItemKind::EndLoop => {
                    if let (Some(head), Some(by)) = (loops.pop(), going.led) {
                        self.loops.entry(head).or_insert(by);
                    }
                }
                _ => {}
            }
            if let Some(by) = going.led {
                self.call(p, item, by);
            }
        }
        self.routines.len() + self.loops.len() > known
    }

    /// Something leads the arm at an item: so it does in what that calls, and in what may interrupt it.
    fn call(&mut self, p: &Parsed, item: &Item, by: &'static str) {
        for routine in &p.routines {
            let called = item.kind == ItemKind::Late || facts::called(p, item).any(|name| name == routine.name);
            if (called || routine.is_trap) && !self.routines.contains_key(&routine.name) {
                self.routines.insert(routine.name.clone(), by);
            }
        }
    }
}
