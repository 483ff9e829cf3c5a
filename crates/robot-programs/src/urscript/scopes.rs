//! Which names of a URScript mean one variable, and what is known of its value.

use super::lex::Kind;
use super::read::{ItemKind, Parsed};
use super::reason::Reason;
use std::collections::{HashMap, HashSet};

impl Parsed {
    /// Settles which assignments belong to one variable, and which variables are read. `goals`: per item the token of the
    /// name that a move leads to.
    pub fn settle(&mut self, goals: &[Option<usize>]) {
        let by_function = std::mem::take(&mut self.variables);
        let mut keys: Vec<_> = by_function.keys().cloned().collect();
        keys.sort();
        let assigned: HashSet<(Option<usize>, String)> = keys.iter().cloned().collect();
        let scopes: HashMap<_, _> = keys.iter().map(|(d, n)| ((*d, n.clone()), self.scope(*d, n, &assigned))).collect();
        for key in keys {
            let (Some(one), Some(scope)) = (by_function.get(&key), scopes.get(&key)) else { continue };
            let all = self.variables.entry((*scope, key.1.clone())).or_default();
            all.assigned.extend(&one.assigned);
            if all.changed.is_none() {
                all.changed.clone_from(&one.changed);
            }
        }
        let items = std::mem::take(&mut self.items);
        for ((_, name), v) in &mut self.variables {
            if v.assigned.len() > 1 {
                v.changed.get_or_insert_with(|| Reason::AssignedTwice(name.as_str().into()));
            }
        }
        let names: HashSet<String> = self.variables.keys().map(|key| key.1.clone()).collect();
        for (item, goal) in items.iter().zip(goals) {
            let from = match item.kind {
                ItemKind::Assign { value, whole: true, .. } => value,
                ItemKind::Start => item.span.end,
                _ => item.span.start,
            };
            for i in from..item.span.end {
                let name = self.words.at(i);
                if name.is_empty() || Some(i) == *goal || !names.contains(name) {
                    continue;
                }
                if let Some(key) = self.key(item.def, name) {
                    let changed =
                        self.method(i).map(|method| Reason::Method { name: name.into(), method: method.into() });
                    if let Some(v) = self.variables.get_mut(&key) {
                        v.read = true;
                        v.method |= changed.is_some();
                        v.changed = v.changed.take().or(changed);
                    }
                }
            }
        }
        self.items = items;
    }

    /// The method of a variable at token `i` that may change its list.
    ///
    /// `method = name "." word "("`
    fn method(&self, i: usize) -> Option<&str> {
        const READS: [&str; 2] = ["length", "slice"];
        let mark = |k: usize, b: u8| self.tokens.get(k).is_some_and(|t| t.kind == Kind::Mark(b));
        let method = self.words.at(i + 2);
        let called = mark(i + 1, b'.') && mark(i + 3, b'(');
        (called && !method.is_empty() && !READS.contains(&method)).then_some(method)
    }

    fn scope(&self, def: Option<usize>, name: &str, assigned: &HashSet<(Option<usize>, String)>) -> Option<usize> {
        let own = |d: Option<usize>| (d, name.to_string());
        if self.locals.contains(&own(def)) {
            return def;
        }
        if self.globals.contains(name) {
            return None;
        }
        let mut found = def;
        let mut at = def;
        while let Some(d) = at {
            if assigned.contains(&own(at)) || self.locals.contains(&own(at)) {
                found = at;
            }
            at = self.defs[d].1;
        }
        found
    }

    /// The variable that a name means in a function; `None`: nothing in the file assigns it there.
    pub fn key(&self, def: Option<usize>, name: &str) -> Option<(Option<usize>, String)> {
        let mut at = def;
        loop {
            let key = (at, name.to_string());
            if self.variables.contains_key(&key) || self.locals.contains(&key) {
                return self.variables.contains_key(&key).then_some(key);
            }
            match at {
                Some(d) => at = self.defs[d].1,
                None => return None,
            }
        }
    }

    /// Whether a name is a parameter of the function.
    pub fn is_parameter(&self, def: Option<usize>, name: &str) -> bool {
        self.locals.contains(&(def, name.to_string()))
    }
}
