//! Parameters of procedures for which every call of the program passes the same constant.
//!
//! A parameter is then as certain as that constant. The moves of the procedure are edited for all calls alike: its start is the start of a
//! routine, from where directions are not known, whoever calls it.

use super::arguments::arguments;
use super::facts::{self, Facts};
use super::lex::Kind;
use super::read::{Item, ItemKind, Storage};

impl Facts<'_> {
    /// The CONST that every call passes for a parameter which the procedure does not change; `None`: it is not certain.
    ///
    /// `procedure = "PROC" name "(" parameter {"," parameter} ")"`, none of them optional
    pub fn passed(&self, parameter: usize) -> Option<usize> {
        let decl = self.p.decls.get(parameter).filter(|d| d.storage == Storage::Bound)?;
        let (r, state) = (decl.routine?, self.states.get(parameter)?);
        if state.changed.is_some() || state.twice || !self.is_seen_whole(r) {
            return None;
        }
        let name = self.p.routines.get(r)?.name.as_str();
        let (position, count) = self.position(r, parameter)?;
        let mut found = None;
        for item in self.p.items.iter().filter(|item| facts::called(self.p, item).any(|called| called == name)) {
            let passed = self.argument(item, name, position, count).filter(|d| self.reaches(*d, decl.module))?;
            if *found.get_or_insert(passed) != passed {
                return None;
            }
        }
        found
    }

    /// Whether all calls of a procedure stand in the text.
    fn is_seen_whole(&self, r: usize) -> bool {
        let Some(routine) = self.p.routines.get(r).filter(|routine| self.is_called_here_alone(routine)) else {
            return false;
        };
        (routine.local || !self.is_set_by_name_outside())
            && !self.p.items.iter().any(|item| item.kind == ItemKind::Late)
    }

    /// Place of a parameter among those of its procedure, and their number; `None`: one is optional.
    fn position(&self, r: usize, parameter: usize) -> Option<(usize, usize)> {
        let start = |item: &&Item| item.routine == r && item.kind == ItemKind::Start;
        let head = self.p.items.iter().find(start)?.span.clone();
        if self.p.tokens.get(head.clone())?.iter().any(|t| t.kind == Kind::Mark(b'\\')) {
            return None;
        }
        let of = |d: &usize| self.p.decls.get(*d).is_some_and(|d| d.routine == Some(r) && head.contains(&d.at));
        let all: Vec<usize> = (0..self.p.decls.len()).filter(of).collect();
        Some((all.iter().position(|d| *d == parameter)?, all.len()))
    }

    /// The declaration that a call passes by its name alone.
    ///
    /// `call = procedure argument {"," argument}`
    fn argument(&self, item: &Item, name: &str, position: usize, count: usize) -> Option<usize> {
        let call = matches!(item.kind, ItemKind::Call { .. }) && self.word(item.span.start) == name;
        // once as the instruction itself, and not within its arguments
        if !call || facts::called(self.p, item).filter(|called| *called == name).count() != 1 {
            return None;
        }
        let args = arguments(self.p, item.span.start + 1..item.span.end);
        if args.len() != count || args.iter().any(|a| !a.switches.is_empty() || !a.name.is_empty()) {
            return None;
        }
        let span = args.get(position).map(|a| a.span.clone()).filter(|s| s.len() == 1)?;
        self.resolve(self.word(span.start), Some(item.routine), item.module)
    }

    /// Whether a declaration is a constant that a module sees.
    fn reaches(&self, d: usize, module: usize) -> bool {
        let seen =
            self.p.decls.get(d).is_some_and(|d| {
                d.storage == Storage::Const && d.routine.is_none() && (!d.local || d.module == module)
            });
        seen && self.certain(d).is_ok()
    }
}
