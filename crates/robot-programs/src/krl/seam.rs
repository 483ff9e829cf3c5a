//! Weld data of KUKA.ArcTech (`DECL stArcDat_T WDAT1={...}`): whether the torch weaves on a seam, or a sensor tracks it.
//!
//! `ArcMainNG(#ArcOnBeforeMoveStd, WDAT1, ...)` begins a seam with such data, `#ArcSwi...` goes on with others, and they hold until
//! `#ArcOffAfter...`. Declarations of the program's own files are looked at, and of other modules those that hold for all of them. Data
//! that none of the files declares, or of which the program changes this part, are not certain.

use super::lex::{Kind, Token, first_word, in_upper, tokens, upper};
use super::statement::assignment;
use crate::script::Text;
use crate::script::called::stem_of;
use crate::script::lex::{outside, upper_of};
use std::collections::BTreeMap;

/// What holds on a seam.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Seam {
    pub weaves: bool,
    pub tracks: bool,
    /// The files do not tell whether it does either.
    pub uncertain: bool,
}

impl Seam {
    const UNCERTAIN: Self = Self { weaves: false, tracks: false, uncertain: true };

    fn or(self, other: Self) -> Self {
        Self {
            weaves: self.weaves || other.weaves,
            tracks: self.tracks || other.tracks,
            uncertain: self.uncertain || other.uncertain,
        }
    }
}

/// The weld data of a program and its project.
#[derive(Debug, Default)]
pub(super) struct WeldData {
    /// By module, and what holds for all modules under an empty name.
    seams: BTreeMap<(String, String), Seam>,
}

/// The module of a text: the program itself, or another by its name.
fn module(text: &Text) -> String {
    if text.context { stem_of(text) } else { "*".into() }
}

impl WeldData {
    /// Of all texts.
    pub fn of(texts: &[Text]) -> Self {
        let mut data = Self::default();
        for text in texts {
            let of_all = stem_of(text) == "$CONFIG";
            for (global, name, seam) in &text.known(Declared::of).0 {
                let module = if of_all || *global { String::new() } else { module(text) };
                let all = data.seams.entry((module, name.clone())).or_default();
                *all = all.or(*seam);
            }
        }
        if !data.seams.is_empty() {
            texts.iter().for_each(|text| data.assigned(text));
        }
        data
    }

    /// What holds on a seam with data of this name in a text.
    pub fn seam(&self, text: &Text, name: &str) -> Seam {
        self.key(text, name).and_then(|key| self.seams.get(&key)).copied().unwrap_or(Seam::UNCERTAIN)
    }

    /// Whether data of this name are declared for a text.
    pub fn knows(&self, text: &Text, name: &str) -> bool {
        self.key(text, name).is_some()
    }

    /// Where data of this name are found: the module's own come before those of all modules.
    fn key(&self, text: &Text, name: &str) -> Option<(String, String)> {
        if self.seams.is_empty() || name.is_empty() {
            return None;
        }
        let keys = [module(text), String::new()].map(|module| (module, name.to_string()));
        keys.into_iter().find(|key| self.seams.contains_key(key))
    }

    /// Data whose weaving or tracking a text assigns: `WDAT1.Weave.Pattern=#Spiral`.
    ///
    /// `assignment = name {"." part} "=" value`
    fn assigned(&mut self, text: &Text) {
        let (own, mut line) = (module(text), Vec::new());
        if !self.seams.keys().any(|(module, _)| module.is_empty() || *module == own) {
            return;
        }
        for k in 0..text.line_count() {
            let name = upper_of(first_word(text, k)).into_owned();
            let Some(all) = self.key(text, &name).and_then(|key| self.seams.get_mut(&key)) else { continue };
            tokens(text, k, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            let Some(sign) = assignment(&line) else { continue };
            let steers = || line[1..sign].iter().any(|t| matches!(in_upper(text, t).as_ref(), "WEAVE" | "TRACK"));
            match line.get(1).is_some_and(|t| t.is(b'.')) {
                false if line.get(sign + 1).is_some_and(|t| t.is(b'{')) => *all = all.or(seam(text, &line[sign + 1..])),
                true if !steers() => {}
                _ => all.uncertain = true,
            }
        }
    }
}

const TYPE: &str = "STARCDAT_T";

/// The weld data that a text declares; whether for all modules.
struct Declared(Vec<(bool, String, Seam)>);

impl Declared {
    fn of(text: &Text) -> Self {
        let is_type = |at: usize| {
            text.bytes.get(at..at + TYPE.len()).is_some_and(|word| word.eq_ignore_ascii_case(TYPE.as_bytes()))
        };
        let (mut all, mut line) = (Vec::new(), Vec::new());
        for at in memchr::memchr2_iter(b's', b'S', &text.bytes).filter(|at| is_type(*at)) {
            tokens(text, text.line_of(at) as usize - 1, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            all.extend(declared(text, &line));
        }
        Self(all)
    }
}

/// The weld data that a line declares; whether for all modules.
///
/// `declaration = {"DECL" | "GLOBAL" | "CONST"} "STARCDAT_T" name ["=" aggregate] {"," name ["=" aggregate]}`
fn declared(text: &Text, line: &[Token]) -> Vec<(bool, String, Seam)> {
    let Some(at) = line.iter().position(|t| t.kind == Kind::Word && in_upper(text, t) == TYPE) else {
        return Vec::new();
    };
    let is_one_of = |t: &Token, words: &[&str]| words.contains(&in_upper(text, t).as_ref());
    if !line[..at].iter().all(|t| is_one_of(t, &["DECL", "GLOBAL", "CONST"])) {
        return Vec::new();
    }
    let global = line[..at].iter().any(|t| is_one_of(t, &["GLOBAL"]));
    let commas: Vec<usize> = outside(at + 1..line.len(), |k| line[k].mark()).filter(|k| line[*k].is(b',')).collect();
    let starts = std::iter::once(at + 1).chain(commas.iter().map(|k| k + 1));
    let ends = commas.iter().copied().chain([line.len()]);
    let item = |(start, end): (usize, usize)| {
        let name = line.get(start).filter(|t| t.kind == Kind::Word)?;
        let sign = (start..end).find(|k| line[*k].is(b'='));
        let seam = sign.map_or(Seam::UNCERTAIN, |sign| seam(text, &line[sign + 1..end]));
        Some((global, upper(text, name), seam))
    };
    starts.zip(ends).filter_map(item).collect()
}

/// What the value of weld data says; a part that is missing does nothing.
///
/// `aggregate = ... "WEAVE" "{" "PATTERN" "#" word ... "}" ... "TRACK" "{" "ISARCSENSEENABLED" word ... "}" ...`
fn seam(text: &Text, value: &[Token]) -> Seam {
    let after = |name: &str| {
        let at = value.iter().position(|t| t.kind == Kind::Word && in_upper(text, t) == name)?;
        let next = |k: usize| value.get(k).map(|t| upper(text, t)).unwrap_or_default();
        Some(if next(at + 1) == "#" { next(at + 2) } else { next(at + 1) })
    };
    let weaves = after("PATTERN").is_some_and(|pattern| pattern != "NONE");
    let tracks = after("ISARCSENSEENABLED").is_some_and(|on| on != "FALSE");
    // weaving whose pattern is not given
    let uncertain = after("WEAVE").is_some() && after("PATTERN").is_none();
    Seam { weaves, tracks, uncertain }
}
