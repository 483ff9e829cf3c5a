//! What other modules of a project declare for all (`$config.dat`, public data lists), and what they do to the points of all.
//!
//! A point that another module assigns, or hands over to a routine, has no certain value. Names that such a module declares for itself
//! are others.

use super::aggregate::aggregate;
use super::calls::calls;
use super::data::{Data, Declared};
use super::lex::{Kind, Token, tokens, upper};
use super::project::is_read;
use super::reason::{Uncertain, Where};
use super::statement::{assignment, declaration, is_routine, statements};
use crate::script::Text;
use crate::script::lex::outside;
use std::collections::HashSet;

impl Data {
    /// What other modules declare for all. A file that cannot be read declares nothing.
    ///
    /// `list = "DEFDAT" name ["PUBLIC"] {declaration | assignment}`
    pub(super) fn declared_elsewhere(&mut self, texts: &[Text]) {
        let mut line = Vec::new();
        let lists = texts.iter().enumerate().filter(|(_, t)| t.context && is_list(t));
        for (file, text) in lists {
            let mut shared: Option<bool> = None;
            for k in 0..text.line_count() {
                tokens(text, k, &mut line);
                line.retain(|t| t.kind != Kind::Comment);
                let Some(first) = line.first().map(|t| upper(text, t)) else { continue };
                if first == "ENDDAT" {
                    break;
                }
                if first == "DEFDAT" {
                    let name = line.get(1).map(|t| upper(text, t)).unwrap_or_default();
                    let public = line.iter().any(|t| upper(text, t) == "PUBLIC");
                    shared = (name == "$CONFIG" || public).then_some(name == "$CONFIG");
                    if shared.is_none() {
                        break;
                    }
                } else if let (Some(all), Some(at)) = (shared, declaration(text, &line))
                    && (all || line[..at].iter().any(|t| upper(text, t) == "GLOBAL"))
                {
                    let _ = self.declare(text, Declared { file, line: k, scope: None }, &line, at);
                } else if let (Some(_), Some(sign)) = (shared, assignment(&line)) {
                    self.initial_elsewhere(text, file, &line, sign);
                }
            }
        }
    }

    /// What other modules do to points of all modules.
    pub(super) fn look_around(&mut self, texts: &[Text]) {
        self.imports(texts);
        let unread = texts.iter().find(|t| t.context && !is_read(t));
        if let Some(unread) = unread {
            // it may give a point of a public list another name, and assign that
            let public: Vec<bool> = texts.iter().map(|t| !t.context && is_public(t)).collect();
            for name in self.names.iter_mut().filter(|n| public.get(n.file).copied().unwrap_or_default()) {
                name.spoil(Uncertain::PublicList(unread.name.as_str().into()));
            }
        }
        if !self.names.iter().any(|n| n.global) {
            return;
        }
        let found = texts.iter().any(|t| t.context && file_name(t).eq_ignore_ascii_case("$config.dat"));
        if !found || unread.is_some() {
            for name in self.names.iter_mut().filter(|n| n.global) {
                let at = Where::in_file(texts.get(name.file).map_or("", |t| &t.name), name.line);
                let why = match unread {
                    Some(t) => Uncertain::GlobalUnread { at, unread: t.name.as_str().into() },
                    None => Uncertain::GlobalAlone(at),
                };
                name.spoil(why);
            }
        }
        let mut line = Vec::new();
        // points that a module assigns or hands over; its own of the same name are others
        for text in texts.iter().filter(|t| t.context && !is_list(t)) {
            let module = of_module(texts, text);
            let mut local = module.clone();
            for k in 0..text.line_count() {
                tokens(text, k, &mut line);
                line.retain(|t| t.kind != Kind::Comment);
                let word = |i: usize| line.get(i).map(|t| upper(text, t)).unwrap_or_default();
                if is_routine(&word(0), &word(1)) {
                    local.clone_from(&module);
                }
                match declaration(text, &line) {
                    Some(at) => local.extend(declared(text, &line, at)),
                    None => {
                        for part in statements(text, &line) {
                            self.used_elsewhere(text, k, part, &local);
                        }
                    }
                }
            }
        }
    }

    /// `IMPORT E6AXIS XQ IS /R1/Program/prog..XP2`: another name of a point, by which it may be assigned.
    ///
    /// `import = "IMPORT" type name "IS" path ".." name`
    fn imports(&mut self, texts: &[Text]) {
        let mut line = Vec::new();
        for text in texts.iter().filter(|t| memchr::memmem::find(&t.bytes, b"..").is_some()) {
            for k in text.lines_with(b".") {
                if memchr::memmem::find(text.line(k), b"..").is_none() {
                    continue;
                }
                tokens(text, k, &mut line);
                let begins = line.iter().take(3).any(|t| upper(text, t) == "IMPORT");
                let dots = line.windows(3).find(|w| w[0].is(b'.') && w[1].is(b'.') && w[2].kind == Kind::Word);
                let Some([_, _, name]) = dots.filter(|_| begins) else { continue };
                if let Some(n) = self.known(None, &upper(text, name)) {
                    self.names[n].spoil(Uncertain::OtherName(Where::in_file(&text.name, k)));
                }
            }
        }
    }

    /// `P[1]={X ...}` of another data list, where it declares the array for all.
    fn initial_elsewhere(&mut self, text: &Text, file: usize, line: &[Token], sign: usize) {
        let Some((n, next)) = self.at(0, text, line, 0).filter(|(_, next)| *next == sign) else { return };
        let ours = self.names[n].context && self.names[n].file == file && !self.names[n].array;
        if ours {
            let value = aggregate(text, file, line, next + 1).ok().filter(|(_, end)| *end == line.len());
            self.initial(n, value.map(|v| v.0), true);
        }
    }

    /// A line of another module that gives a point of all modules a value, or may do so.
    fn used_elsewhere(&mut self, text: &Text, k: usize, line: &[Token], local: &HashSet<String>) {
        let sign = assignment(line);
        let call = || calls(text, line).into_iter().next();
        for (i, t) in line.iter().enumerate() {
            if t.kind != Kind::Word || i > 0 && line[i - 1].is(b'.') {
                continue;
            }
            let name = upper(text, t);
            let Some(n) = self.known(None, &name) else { continue };
            if !self.names[n].global || local.contains(&name) {
                continue;
            }
            let (n, next) = self.at(usize::MAX, text, line, i).unwrap_or((n, i + 1));
            if i == 0 && sign.is_some() {
                if is_basis(text) && is_home(&name) {
                    continue;
                }
                self.names[n].spoil(Uncertain::Assigned(Where::in_file(&text.name, k)));
            } else if let Some(routine) = call().filter(|_| sign.is_none_or(|s| s != next)) {
                self.names[n].spoil(Uncertain::Passed { to: routine.into(), at: Where::in_file(&text.name, k) });
            }
        }
    }
}

/// Whether a data list opens its points to other modules: `DEFDAT name PUBLIC`.
fn is_public(text: &Text) -> bool {
    let mut line = Vec::new();
    (0..text.line_count()).any(|k| {
        tokens(text, k, &mut line);
        line.first().is_some_and(|t| upper(text, t) == "DEFDAT") && line.iter().any(|t| upper(text, t) == "PUBLIC")
    })
}

/// Whether a text is a data list by its ending.
fn is_list(text: &Text) -> bool {
    text.name.rsplit_once('.').is_some_and(|(_, e)| e.eq_ignore_ascii_case("dat"))
}

fn file_name(text: &Text) -> &str {
    text.name.rsplit(['/', '\\']).next().unwrap_or_default()
}

/// KUKA's own BAS: it assigns the home positions of delta kinematics, which these arms are not.
fn is_basis(text: &Text) -> bool {
    file_name(text).eq_ignore_ascii_case("bas.src")
}

/// `XHOME`, `XHOME1` to `XHOME5`.
///
/// `home = "XHOME" ["1" | "2" | "3" | "4" | "5"]`
fn is_home(name: &str) -> bool {
    matches!(name, "XHOME" | "XHOME1" | "XHOME2" | "XHOME3" | "XHOME4" | "XHOME5")
}

/// Names that the data list of the module of `text` declares for the module alone.
fn of_module(texts: &[Text], text: &Text) -> HashSet<String> {
    let stem = |t: &Text| t.name.rsplit_once('.').map_or(t.name.as_str(), |(s, _)| s).to_ascii_uppercase();
    let own = stem(text);
    let mut names = HashSet::new();
    let mut line = Vec::new();
    for text in texts.iter().filter(|t| is_list(t) && stem(t) == own) {
        for k in 0..text.line_count() {
            tokens(text, k, &mut line);
            if let Some(at) = declaration(text, &line)
                && !line[..at].iter().any(|t| upper(text, t) == "GLOBAL")
            {
                names.extend(declared(text, &line, at));
            }
        }
    }
    names
}

/// The names of a declaration whose type stands at token `at`; none of the words in their values.
///
/// `declaration = ... type name ["=" value] {"," name ["=" value]}`
fn declared(text: &Text, line: &[Token], at: usize) -> Vec<String> {
    let name = |k: &usize| line[*k].kind == Kind::Word && (*k == at + 1 || line[*k - 1].is(b','));
    outside(at + 1..line.len(), |k| line[k].mark()).filter(name).map(|k| upper(text, &line[k])).collect()
}
