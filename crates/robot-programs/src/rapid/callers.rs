//! Procedures of which all calls stand in the program: the robot comes to their first target from where it stands before one of these.
//!
//! No such one is `main`, a function, a trap, one of two of its name, or one that is called by a name that is computed or stands in a text
//! (`MoveLSync p1,v100,z10,tool0,"pick"`). One that is not LOCAL is such a one in a program with `main` alone, where nothing beside it
//! names it.

use super::facts::{Facts, called};
use super::lex::Kind;
use super::read::{Item, ItemKind};
use crate::script::lex::text_of;
use std::collections::HashSet;

/// Numbers of these procedures; `own`: items of the program's own text, whose calls are followed.
pub fn all_known(f: &Facts, own: &dyn Fn(&Item) -> bool) -> HashSet<usize> {
    let p = f.p;
    let late = p.items.iter().any(|item| item.kind == ItemKind::Late);
    if late || p.words.different().any(|w| w == "callbyvar") {
        return HashSet::new();
    }
    let strings = p.tokens.iter().filter(|t| t.kind == Kind::String);
    // `"module:procedure"`
    let of_string = |text: String| text.trim_matches('"').rsplit(':').next().unwrap_or_default().trim().to_lowercase();
    let mut elsewhere: HashSet<String> =
        strings.map(|t| of_string(text_of(f.text.slice(t.start()..t.end())).to_string())).collect();
    elsewhere.insert("main".into());
    let others = p.items.iter().filter(|item| !own(item));
    elsewhere.extend(others.flat_map(|item| called(p, item)).map(str::to_string));
    let here = |r: &super::read::Routine| !elsewhere.contains(&r.name) && f.is_called_here_alone(r);
    (0..p.routines.len()).filter(|k| here(&p.routines[*k])).collect()
}
