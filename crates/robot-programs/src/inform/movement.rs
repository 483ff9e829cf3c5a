//! A move of an INFORM job: its word, its positions, its tags.
//!
//! Whatever is not known on the line closes the move to new points; what may change its goal makes the goal one that cannot be
//! determined. Fails where a move names a C position that is not in the list.

use super::flow;
use super::job::{Kind, Position, Reference, Tag};
use super::read::Reader;
use super::reason::Reason;
use super::words::words;
use crate::error::Result;
use crate::script::cursor::integer;
use crate::script::lex::upper_of;
use crate::script::{self, Break, Few, Goal, How, Move, OtherWay, PathKind, Span, Speed, StepKind, Text, number};
use std::ops::Range;

/// The goal of a move of which no position has been read yet.
const UNREAD: Goal = Goal::Opaque(script::Reason::NoGoal);

/// The line of a move while its words are read.
struct MoveLine {
    m: Move,
    references: Vec<Reference>,
    /// Words that a copy takes along.
    tags: Vec<Tag>,
    /// Why its goal cannot be determined.
    unclear: Option<Reason>,
    /// An input may stop it.
    may_stop: bool,
    /// What follows are conditions: no word of the move.
    conditions: bool,
    /// What follows on the next lines runs with its start: `NWAIT`.
    runs_on: bool,
}

impl MoveLine {
    /// A move whose word is read, and nothing else yet.
    ///
    /// `word = ["S"] ("MOVJ" | "MOVL" | "MOVC" | "MOVS") | "IMOV" | ... "MOV" ...`
    fn new(word: &str, second_group: bool) -> Self {
        let path = match word {
            "MOVJ" | "SMOVJ" => PathKind::Joint,
            "MOVL" | "SMOVL" | "IMOV" => PathKind::Linear,
            _ => PathKind::Curve,
        };
        let closed = second_group.then(|| Reason::SecondGroup.into());
        let relative = word.contains("IMOV");
        let m = Move::new(How { path, closed, relative, ..How::default() }, UNREAD, Few::new());
        let unclear = match word {
            "MOVJ" | "MOVL" | "MOVC" | "MOVS" | "SMOVJ" | "SMOVL" | "SMOVC" | "SMOVS" => None,
            word if word.contains("IMOV") => Some(Reason::Relative),
            word => Some(Reason::UnknownMove(word.into())),
        };
        let (references, tags) = (Vec::new(), Vec::new());
        let mut line = Self { m, references, tags, unclear, may_stop: false, conditions: false, runs_on: false };
        if word.starts_with("SMOV") {
            line.close(Reason::Synchronised);
        }
        if matches!(word, "MOVC" | "MOVS") {
            line.close(Reason::ByNeighbours);
        }
        line
    }

    /// No point can be added.
    fn close(&mut self, why: Reason) {
        self.m.closed.get_or_insert_with(|| why.into());
    }

    /// A word that is no position: speed, blending, a condition.
    ///
    /// `tag = ("VJ" | "V" | "VR" | "VE" | "PL" | "CR" | "ACC" | "DEC") "=" value | "NWAIT" | "ENWAIT" | condition | word`,
    /// `condition = ("UNTIL" | "SRCH" | "NSRCH" | "IF") {word}`
    fn tag(&mut self, w: &Range<usize>, name: &str) {
        let (key, value) = name.split_once('=').map_or((name, None), |(a, b)| (a, Some(b)));
        let tag = value.and_then(|_| Tag::new(key, w.clone()));
        match key {
            _ if self.conditions => {}
            "NWAIT" => self.runs_on = true,
            "ENWAIT" => {}
            "UNTIL" | "SRCH" | "NSRCH" => (self.may_stop, self.conditions) = (true, true),
            "IF" => {
                self.unclear.get_or_insert(Reason::Conditional);
                self.conditions = true;
            }
            _ if tag.is_some() => {
                let n = value.and_then(|v| number::read(v.as_bytes()));
                match (key, n) {
                    ("VJ", Some((v, _))) => self.m.speed = Speed::Share((v / 100.0).clamp(0.0, 1.0)),
                    // without decimals it may be another unit than mm/s
                    ("V", Some((v, s))) if s.point && v > 0.0 => self.m.speed = Speed::Tcp(v * 1e-3),
                    ("PL", Some((0.0, _))) => self.m.blend_m = Some(0.0),
                    ("CR", Some((v, _))) if v >= 0.0 => self.m.blend_m = Some(v * 1e-3),
                    _ => {}
                }
                if matches!(key, "PL" | "CR") && n.is_none() {
                    self.close(Reason::CornerComputed(name.into()));
                }
                self.tags.extend(tag);
            }
            _ if Kind::read(key.as_bytes()).is_none() && looks_like_position(key) => {
                self.unclear.get_or_insert_with(|| Reason::SetAtRunTime(name.into()));
            }
            _ => self.close(Reason::UnknownTag(name.into())),
        }
    }
}

/// A line that is a move to one position, and says nothing else that depends on the job: bytes count from its start.
pub(super) struct Model {
    bytes: Vec<u8>,
    indent: Span,
    word: Span,
    /// The name of its position, and the digits of that.
    name: Span,
    digits: usize,
    kind: Kind,
    m: Move,
    tags: Vec<Tag>,
}

impl Model {
    fn of(text: &Text, k: usize, places: [Span; 2], line: &MoveLine) -> Option<Self> {
        let [reference] = line.references.as_slice() else { return None };
        // what follows the line counts, too
        if line.unclear.is_some() || line.may_stop || line.conditions || line.runs_on {
            return None;
        }
        let start = text.line_span(k).start;
        let of_line = |span: Span| -> Option<Span> {
            Some((span.start().checked_sub(start)?..span.end().checked_sub(start)?).into())
        };
        let [indent, word] = places.map(of_line);
        let (kind, _, digits) = Kind::read(text.slice(reference.span))?;
        Some(Self {
            bytes: text.line(k).to_vec(),
            indent: indent?,
            word: word?,
            name: of_line(reference.span)?,
            digits,
            kind,
            m: line.m.alike(UNREAD),
            tags: line.tags.iter().map(|tag| Some(tag.at(of_line(tag.span)?))).collect::<Option<_>>()?,
        })
    }

    /// The number of the position in a line like this one.
    fn number_in(&self, line: &[u8]) -> Option<u32> {
        let (head, rest) = line.split_at_checked(self.name.end() - self.digits)?;
        let (number, tail) = rest.split_at_checked(self.digits)?;
        let own = self.bytes.split_at_checked(head.len())?;
        (head == own.0 && tail == own.1.get(self.digits..)?).then(|| integer(number)).flatten()
    }
}

impl Reader<'_> {
    /// A move on line `k`; `word`: its first word in upper case.
    ///
    /// `move = word {position | tag} ["+" word {position}]`
    pub(super) fn movement(&mut self, k: usize, words: &[Range<usize>], word: &str) -> Result<()> {
        let text = self.text;
        let second = words.iter().skip(1).position(|w| text.slice(w.clone()).starts_with(b"+")).map(|p| p + 1);
        let (own, others) = words.split_at(second.unwrap_or(words.len()));
        for w in others {
            self.pin(w);
        }
        let stands = self.station_stands(k, own.get(1..).unwrap_or_default(), others);
        let mut line = MoveLine::new(word, second.is_some());
        let synchronised = word.starts_with("SMOV");
        line.m.other_way = (synchronised && !stands).then_some(OtherWay::Carried);
        let indent = (text.line_span(k).start..words[0].start).into();
        let word = words[0].clone().into();
        if let Some(group) = &self.list.foreign {
            line.unclear = Some(Reason::ForeignGroup(group.as_str().into()));
        }
        for w in &own[1..] {
            let name = upper_of(text.slice(w.clone()));
            match Kind::read(name.as_bytes()).filter(|_| !line.conditions) {
                Some((kind, n, _)) => self.named(&mut line, w, &name, kind, n)?,
                None => line.tag(w, &name),
            }
        }
        if line.may_stop {
            line.close(Reason::MayStop);
        }
        if line.runs_on && !flow::moves_next(text, k, &self.labels) {
            // its last piece would start what follows
            line.close(Reason::FollowerRunsWithIt);
        }
        let what = self.overlaid(k);
        if !what.is_empty() {
            line.unclear.get_or_insert_with(|| Reason::Overlaid(what.into()));
        }
        let alone = second.is_none() && !synchronised;
        self.model = if alone { Model::of(text, k, [indent, word], &line) } else { None };
        self.place(k, indent, word, line)
    }

    /// Whether the stations and robots of other groups certainly stand still on the way of the move on line `k`; `own`: its words,
    /// `others`: what it says of them. The move on the next line after a `+` is theirs, too.
    fn station_stands(&mut self, k: usize, own: &[Range<usize>], others: &[Range<usize>]) -> bool {
        let next =
            self.line_of_others(k).filter(|_| others.is_empty()).map(|k| words(self.text, k)).unwrap_or_default();
        let all = if others.is_empty() { &next[..] } else { others };
        // a station that is moved with the robot, or alone
        let moved = own.iter().any(|w| !matches!(self.kind_of(w), None | Some(Kind::C | Kind::P)));
        if all.is_empty() {
            self.station = self.station.take().filter(|_| !moved);
            return false;
        }
        let there = self.places_of(all).filter(|places| !places.is_empty() && !moved);
        let stands = there.is_some() && self.station == there;
        self.station = there;
        stands
    }

    /// The line of the other groups that belongs to the move on line `k`: the next one that is no comment, if it begins with a `+`.
    fn line_of_others(&self, k: usize) -> Option<usize> {
        let stands = |k: &usize| {
            let line = self.text.line(*k).trim_ascii();
            !line.is_empty() && !line.starts_with(b"'")
        };
        let next = (k + 1..self.text.line_count()).find(stands)?;
        self.text.line(next).trim_ascii_start().starts_with(b"+").then_some(next)
    }

    fn kind_of(&self, word: &Range<usize>) -> Option<Kind> {
        Kind::read(&self.text.slice(word.clone()).to_ascii_uppercase()).map(|read| read.0)
    }

    /// Positions of other groups that words name, as their numbers by bits; `None`: one of them is not in the list, or a variable.
    fn places_of(&self, all: &[Range<usize>]) -> Option<Vec<(Kind, Vec<u64>)>> {
        let mut places = Vec::new();
        for w in all {
            let name = upper_of(self.text.slice(w.clone()));
            let Some((kind, n, _)) = Kind::read(name.as_bytes()) else {
                let key = name.split('=').next().unwrap_or_default();
                if looks_like_position(key) {
                    return None;
                }
                continue;
            };
            if kind >= Kind::P {
                return None;
            }
            let numbers = self.list.positions.numbers(self.list.by_name.get((kind, n))?);
            let read = |span: &Span| number::read(self.text.slice(*span)).map(|v| v.0.to_bits());
            places.push((kind, numbers.iter().map(read).collect::<Option<Vec<u64>>>()?));
        }
        Some(places)
    }

    /// Reads line `k` where it is the move that was read last but for the number of its position: no word of it has to be read again.
    /// `false`: it is another line, and nothing was done.
    pub(super) fn again(&mut self, k: usize) -> Result<bool> {
        let (text, list) = (self.text, self.list);
        let Some(model) = self.model.as_ref().filter(|_| self.overlaid.get(k).is_none_or(|bits| *bits == 0)) else {
            return Ok(false);
        };
        let start = text.line_span(k).start;
        let found = model.number_in(text.line(k)).and_then(|n| list.by_name.get((model.kind, n)));
        let Some(position) = found.filter(|_| self.line_of_others(k).is_none()) else { return Ok(false) };
        let moved = |span: Span| Span::from(span.start() + start..span.end() + start);
        let line = MoveLine {
            m: model.m.alike(UNREAD),
            references: vec![Reference { position: position as u32, span: moved(model.name) }],
            tags: model.tags.iter().map(|tag| tag.at(moved(tag.span))).collect(),
            unclear: None,
            may_stop: false,
            conditions: false,
            runs_on: false,
        };
        let [indent, word] = [model.indent, model.word].map(moved);
        self.place(k, indent, word, line)?;
        Ok(true)
    }

    /// A position that the move names.
    fn named(&self, line: &mut MoveLine, w: &Range<usize>, name: &str, kind: Kind, n: u32) -> Result<()> {
        match self.list.by_name.get((kind, n)) {
            Some(position) => line.references.push(Reference { position: position as u32, span: w.clone().into() }),
            None if kind >= Kind::P => {
                line.unclear.get_or_insert_with(|| Reason::NotInList(name.into()));
            }
            None => {
                let found = format!("{name}, which is not in the list");
                return Err(self.text.bad(w.start, found, "a position of the list"));
            }
        }
        Ok(())
    }

    /// Where the move leads, and its step.
    fn place(&mut self, k: usize, indent: Span, word: Span, line: MoveLine) -> Result<()> {
        let MoveLine { mut m, references, tags, unclear, may_stop, .. } = line;
        m.goal = match unclear {
            Some(why) => Goal::opaque(why),
            None => self.goal(k, &references, &mut m)?,
        };
        let of_circle = self.circles.get(&k).map(|c| c.0);
        if of_circle == Some(0) {
            m.path = PathKind::Linear;
        }
        if (m.path == PathKind::Linear || of_circle.is_some()) && matches!(m.goal, Goal::Joints(_)) {
            let of_robot = |p: &&Position| matches!(p.kind, Kind::C | Kind::P);
            let lead = references.iter().map(|r| &self.list.positions[r.position()]).find(of_robot);
            m.tool = lead.map(|p| Box::new(self.tool(p)));
        }
        if let Some(why) = references.iter().find_map(|r| self.no_copy(r.position())) {
            m.closed.get_or_insert_with(|| why.into());
        }
        self.counted(&mut m);
        if m.goal.target().is_none() || m.fixed.is_some() {
            for r in &references {
                self.pinned[r.position()] = true;
            }
        }
        let ours = m.goal.target().map(|_| self.parts.statement([indent, word], references, tags));
        self.step(k, StepKind::Move(m), ours);
        if may_stop {
            self.step(k, StepKind::Break(Break::Jump), None);
        }
        Ok(())
    }
}

/// `LP000`, `P[I000]`, `PX001`: positions that only the controller knows.
///
/// `position = ["L"] ("P" | "BP" | "EX" | "PX" | "C" | "BC" | "EC") ("[" | digit) ...`
fn looks_like_position(word: &str) -> bool {
    let word = word.strip_prefix('L').unwrap_or(word);
    ["P", "BP", "EX", "PX", "C", "BC", "EC"]
        .iter()
        .filter_map(|k| word.strip_prefix(k))
        .any(|rest| rest.starts_with('[') || rest.starts_with(|c: char| c.is_ascii_digit()))
}
