//! Names of a program: points and frame data that are declared, what they are given, and who else uses them.

use super::calls::calls;
use super::lex::{Kind, Token, first_word, tokens};
use super::motion;
use super::name::{Assigned, Flow, Holds, Name};
use super::target::finest;
use crate::error::Result;
use crate::script::pose::{Configuration, Frame};
use crate::script::{PathKind, PoseForm, PoseGoal, Solution, Text, Value, number};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// `A1 -50.70`.
#[derive(Debug, Clone)]
pub(super) struct Component {
    /// Upper case.
    pub name: Label,
    /// Bytes, value and style of a plain number; `None`: it is computed.
    pub value: Option<(Range<usize>, f64, number::Style)>,
}

/// The name of a component: short ones, which all are, need no memory of their own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Label {
    Short([u8; 8]),
    Long(String),
}

impl Label {
    /// Of a word, in upper case.
    fn of(word: &[u8]) -> Self {
        let mut short = [0; 8];
        match short.get_mut(..word.len()) {
            Some(place) if word.is_ascii() => {
                place.copy_from_slice(word);
                short.make_ascii_uppercase();
                Self::Short(short)
            }
            _ => Self::Long(String::from_utf8_lossy(word).to_ascii_uppercase()),
        }
    }

    pub fn as_str(&self) -> &str {
        match self {
            Self::Short(bytes) => {
                let len = bytes.iter().take_while(|b| **b != 0).count();
                bytes.get(..len).and_then(|b| std::str::from_utf8(b).ok()).unwrap_or_default()
            }
            Self::Long(text) => text,
        }
    }

    fn is(&self, name: &str) -> bool {
        match self {
            Self::Short(bytes) => bytes.starts_with(name.as_bytes()) && bytes.get(name.len()).is_none_or(|b| *b == 0),
            Self::Long(text) => text == name,
        }
    }
}

/// `{E6AXIS: A1 -50.70,A2 ...}`.
#[derive(Debug, Clone)]
pub(super) struct Aggregate {
    pub file: usize,
    /// Braces included.
    pub span: Range<usize>,
    pub components: Vec<Component>,
}

impl Aggregate {
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components.iter().find(|c| c.name.is(name))
    }

    /// Whether it gives axes; external axes alone also stand beside a Cartesian position.
    pub fn has_axes(&self) -> bool {
        let cartesian = self.components.iter().any(|c| matches!(c.name.as_str(), "X" | "Y" | "Z" | "A" | "B" | "C"));
        self.components.iter().map(|c| c.name.as_str()).any(|n| axis_name(n) && !(cartesian && n.starts_with('E')))
    }

    /// The Cartesian target in a frame and with a tool; `target`: index of its numbers, where they can be written. On straight
    /// paths the controller does not look at status and turn.
    pub fn pose(&self, frame: &Frame, tool: &Frame, path: PathKind, target: Option<usize>) -> Option<PoseGoal> {
        let of = |name: &str| self.component(name).and_then(|c| c.value.as_ref()).map(|v| v.1);
        let position_m = Vector3::new(of("X")?, of("Y")?, of("Z")?) * 1e-3;
        // turns about Z, then the new Y, then the new X
        let rotation = (|| {
            let [a, b, c] = [of("A")?, of("B")?, of("C")?].map(f64::to_radians);
            Some(UnitQuaternion::from_euler_angles(c, b, a))
        })();
        let external = |c: &&Component| {
            axis_name(c.name.as_str())
                && c.name.as_str().starts_with('E')
                && c.value.as_ref().is_none_or(|v| v.1 != 0.0)
        };
        let carried: Option<Vec<(String, f64)>> = self
            .components
            .iter()
            .filter(external)
            .map(|c| Some((c.name.as_str().to_string(), c.value.as_ref()?.1)))
            .collect();
        // bits beyond the sixth are those of external axes; status has bits beyond the third of no arm
        let bits = |name: &str, mask: u32| match self.component(name) {
            None => Ok(None),
            Some(_) => of(name).filter(|v| *v >= 0.0 && *v < 65536.0).map(|v| Some((v as u32 & mask) as u8)).ok_or(()),
        };
        let (status, turn) = (bits("S", 7), bits("T", 63));
        let joint = path == PathKind::Joint;
        let unread = joint && (status.is_err() || turn.is_err());
        let (status, turn) = (status.ok().flatten(), turn.ok().flatten());
        let solution = match (status, turn) {
            (None, None) => Solution::Same,
            (status, turn) => Solution::Configured(Configuration::Kuka { status, turn }),
        };
        let frame = match (carried, unread) {
            (None, _) => {
                Frame::Unknown("an external axis that is computed, and may carry the robot or the work piece".into())
            }
            (_, true) => Frame::Unknown("a status S or turn T that is computed".into()),
            (Some(axes), false) => frame.clone().carried("$NULLFRAME", &axes),
        };
        let tool = tool.clone();
        Some(PoseGoal { target, position_m, rotation, frame, tool, solution, binding: joint, ..PoseGoal::default() })
    }

    /// The numbers of a Cartesian target; `None`: one is missing or computed.
    pub fn coordinates(&self) -> Option<Vec<Option<Value>>> {
        let form = PoseForm::EulerZyx;
        let value = |(k, name): (usize, &&str)| {
            let (span, value, style) = self.component(name)?.value.clone()?;
            let (unit, digit) = (form.unit(k), 10_f64.powi(-i32::from(style.decimals)));
            let finest = finest(value).min(digit) * unit;
            Some(Some(Value { si: value * unit, start: span.start, end: span.end, style, digit: digit * unit, finest }))
        };
        ["X", "Y", "Z", "A", "B", "C"].iter().enumerate().map(value).collect()
    }

    /// The frame that the numbers are.
    pub fn isometry(&self) -> Option<Isometry3<f64>> {
        let numbers: Vec<f64> = self.coordinates()?.iter().flatten().map(|v| v.si).collect();
        PoseForm::EulerZyx.pose(&numbers)
    }

    /// Values of external axes and of axes that are none of the robot's, for comparison.
    pub fn others(&self, own: &[String], text: &Text) -> Vec<(String, Vec<u8>)> {
        let foreign = |name: &str| axis_name(name) && !own.iter().any(|o| o == name);
        let others = self.components.iter().filter(|c| foreign(c.name.as_str()));
        let value = |c: &Component| c.value.as_ref().map_or(b"?".to_vec(), |v| text.slice(v.0.clone()).to_vec());
        let mut out: Vec<_> = others.map(|c| (c.name.as_str().to_string(), value(c))).collect();
        out.sort();
        out
    }
}

/// A1 to A6, E1 to E6.
pub(super) fn axis_name(name: &str) -> bool {
    matches!(name.as_bytes(), [b'A' | b'E', b'1'..=b'6'])
}

/// No aggregate of KRL has as many components.
const MOST: usize = 64;

/// An aggregate whose brace is `tokens[k]`; the token behind it.
pub(super) fn aggregate(text: &Text, file: usize, tokens: &[Token], k: usize) -> Result<(Aggregate, usize)> {
    let open = tokens.get(k).map_or(0, |t| t.start);
    let unclosed = || text.bad(open, "`{` without `}` on its line", "an aggregate such as `{A1 0.0,A2 -90.0}`");
    let mut at = k + 1;
    // `E6AXIS:`
    if let (Some(a), Some(b)) = (tokens.get(at), tokens.get(at + 1))
        && a.kind == Kind::Word
        && b.is(b':')
    {
        at += 2;
    }
    let mut components: Vec<Component> = Vec::with_capacity(6);
    loop {
        let first = tokens.get(at).ok_or_else(unclosed)?;
        if first.is(b'}') {
            at += 1;
            break;
        }
        let (mut depth, mut end) = (0_usize, at);
        loop {
            let t = tokens.get(end).filter(|t| t.kind != Kind::Comment).ok_or_else(unclosed)?;
            match t.kind {
                Kind::Mark(b'{' | b'(' | b'[') => depth += 1,
                Kind::Mark(b'}') if depth == 0 => break,
                Kind::Mark(b'}' | b')' | b']') => depth = depth.saturating_sub(1),
                Kind::Mark(b',') if depth == 0 => break,
                _ => {}
            }
            end += 1;
        }
        if first.kind == Kind::Word {
            let name = Label::of(text.slice(first.span()));
            if components.len() >= MOST {
                return Err(text.bad(first.start, "a further component", format!("{MOST} components at most")));
            }
            if components.iter().any(|c| c.name == name) {
                return Err(text.bad(first.start, format!("a second `{}`", name.as_str()), "each component once"));
            }
            // `A1-5`: another number would run into the name
            let apart = |v: &(Range<usize>, f64, number::Style)| v.0.start > first.end;
            let value = match (name.as_str(), &tokens[at + 1..end]) {
                ("S" | "T", [t]) if t.kind == Kind::Quoted => {
                    bits(text.slice(t.span())).map(|v| (t.span(), v, number::Style::default()))
                }
                (_, rest) => literal(text, rest)?.filter(apart),
            };
            components.push(Component { name, value });
        } else if !first.is(b',') {
            let found = String::from_utf8_lossy(text.slice(first.span())).into_owned();
            return Err(text.bad(first.start, format!("`{found}`"), "the name of a component such as `A1`"));
        }
        at = end + usize::from(tokens.get(end).is_some_and(|t| t.is(b',')));
    }
    let span = open..tokens.get(at - 1).map_or(open, |t| t.end);
    Ok((Aggregate { file, span, components }, at))
}

/// `'B000111'`, `'H2A'`.
fn bits(text: &[u8]) -> Option<f64> {
    let inner = std::str::from_utf8(text.strip_prefix(b"'")?.strip_suffix(b"'")?).ok()?;
    let inner = inner.trim_start();
    let radix = match inner.bytes().next()? {
        b'B' | b'b' => 2,
        b'H' | b'h' => 16,
        _ => return None,
    };
    u16::from_str_radix(inner[1..].trim(), radix).ok().map(f64::from)
}

/// A number with its sign beside it; `None`: anything else.
fn literal(text: &Text, tokens: &[Token]) -> Result<Option<(Range<usize>, f64, number::Style)>> {
    let span = match tokens {
        [n] if n.kind == Kind::Number => n.span(),
        [s, n] if (s.is(b'-') || s.is(b'+')) && n.kind == Kind::Number && s.end == n.start => s.start..n.end,
        [n, ..]
            if n.kind == Kind::Number && tokens.get(1).is_some_and(|t| t.kind == Kind::Number && t.start == n.end) =>
        {
            let end = tokens.last().map_or(n.end, |t| t.end);
            let found = String::from_utf8_lossy(text.slice(n.start..end)).into_owned();
            return Err(text.bad(n.start, format!("`{found}`"), "a number"));
        }
        _ => return Ok(None),
    };
    Ok(number::read(text.slice(span.clone())).map(|(v, s)| (span, v, s)))
}

/// Every name of a program.
#[derive(Debug, Default)]
pub(super) struct Data {
    pub names: Vec<Name>,
    /// By routine (`None`: the data list) and name in upper case.
    by_name: HashMap<String, Vec<(Option<usize>, usize)>>,
    /// Frame data: file and line of the declaration.
    pub frames: HashMap<String, (usize, usize)>,
    /// Numbers of tool and base of frame data.
    pub numbers: HashMap<String, [Option<u32>; 2]>,
}

/// A word in upper case.
pub(super) fn upper(text: &Text, t: &Token) -> String {
    String::from_utf8_lossy(text.slice(t.span())).to_ascii_uppercase()
}

impl Data {
    /// A name as a routine sees it.
    pub fn find(&self, routine: usize, name: &str) -> Option<usize> {
        let all = self.by_name.get(name)?;
        let of = |scope| all.iter().find(|n| n.0 == scope).map(|n| n.1);
        of(Some(routine)).or_else(|| of(None))
    }

    /// A name of a routine (`None`: of the data list).
    fn known(&self, scope: Option<usize>, name: &str) -> Option<usize> {
        self.by_name.get(name)?.iter().find(|n| n.0 == scope).map(|n| n.1)
    }

    /// The frame of a name whose value is certain.
    pub fn frame(&self, routine: usize, name: &str) -> Option<Isometry3<f64>> {
        let name = self.names.get(self.find(routine, name)?)?;
        name.value().ok().filter(|_| name.holds == Holds::Pose)?.isometry()
    }

    pub fn collect(texts: &[Text]) -> Result<Self> {
        let mut data = Self::default();
        let mut line = Vec::new();
        let own = || texts.iter().enumerate().filter(|(_, t)| !t.context);
        // declarations first: the data list comes behind the program
        for pass in 0..2 {
            if pass == 1 && data.names.is_empty() {
                break;
            }
            for (file, text) in own() {
                let mut routine = 0;
                let mut flow = Flow::default();
                for k in 0..text.line_count() {
                    if pass == 0 && !may_declare(first_word(text, k)) {
                        continue;
                    }
                    tokens(text, k, &mut line);
                    line.retain(|t| t.kind != Kind::Comment);
                    let first = line.first().map(|t| upper(text, t)).unwrap_or_default();
                    let second = line.get(1).map(|t| upper(text, t)).unwrap_or_default();
                    if is_routine(&first, &second) {
                        routine += 1;
                        flow = Flow::default();
                    }
                    flow.pass(&first);
                    let scope = (file == 0).then_some(routine);
                    if let Some(at) = declaration(text, &line) {
                        if pass == 0 {
                            data.declare(text, file, k, scope, &line, at)?;
                        }
                    } else if pass == 1 && !matches!(first.as_str(), "STRUC" | "ENUM" | "EXT" | "EXTP" | "EXTFCT") {
                        data.uses(text, file, k, (scope.unwrap_or(0), flow.certain()), &line)?;
                    }
                }
            }
        }
        data.look_around(texts);
        data.spread();
        Ok(data)
    }

    /// What other modules declare for all, and what they do to it. A file that cannot be read declares nothing.
    fn look_around(&mut self, texts: &[Text]) {
        let mut line = Vec::new();
        let others = || texts.iter().enumerate().filter(|(_, t)| t.context);
        for (file, text) in others().filter(|(_, t)| is_list(t)) {
            let mut shared: Option<bool> = None;
            for k in 0..text.line_count() {
                tokens(text, k, &mut line);
                line.retain(|t| t.kind != Kind::Comment);
                let Some(first) = line.first().map(|t| upper(text, t)) else { continue };
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
                    let _ = self.declare(text, file, k, None, &line, at);
                } else if let (Some(_), Some(sign)) = (shared, assignment(&line)) {
                    self.initial_elsewhere(text, file, &line, sign);
                }
            }
        }
        if !self.names.iter().any(|n| n.global) {
            return;
        }
        // points that a module assigns or hands over; its own of the same name are others
        for (_, text) in others().filter(|(_, t)| !is_list(t) && !is_basis(t)) {
            let local: HashSet<String> = of_module(texts, text);
            for k in 0..text.line_count() {
                tokens(text, k, &mut line);
                line.retain(|t| t.kind != Kind::Comment);
                if declaration(text, &line).is_none() {
                    self.used_elsewhere(text, k, &line, &local);
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
            self.initial(n, value.map(|v| v.0));
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
                let why = format!("it is assigned while the program runs ({}:{})", text.name, k + 1);
                self.names[n].spoiled.get_or_insert(why);
            } else if let Some(routine) = call().filter(|_| sign.is_none_or(|s| s != next)) {
                let why = format!("it is passed to {routine}, which may change it ({}:{})", text.name, k + 1);
                self.names[n].spoiled.get_or_insert(why);
            }
        }
    }

    /// `DECL [GLOBAL] [CONST] E6AXIS XP1={...},XP2`; `at` is the token of the type.
    fn declare(
        &mut self,
        text: &Text,
        file: usize,
        k: usize,
        scope: Option<usize>,
        line: &[Token],
        at: usize,
    ) -> Result<()> {
        let kind = upper(text, &line[at]);
        let global = line[..at].iter().any(|t| upper(text, t) == "GLOBAL");
        let mut i = at + 1;
        while let Some(word) = line.get(i) {
            if word.kind != Kind::Word {
                i += 1;
                continue;
            }
            let (name, own) = (upper(text, word), String::from_utf8_lossy(text.slice(word.span())).into_owned());
            i += 1;
            let array = line.get(i).is_some_and(|t| t.is(b'['));
            while line.get(i).is_some_and(|t| !t.is(b',') && !t.is(b'=')) {
                i += 1;
            }
            let mut given = None;
            let mut spoiled = None;
            if line.get(i).is_some_and(|t| t.is(b'=')) {
                i += 1;
                if line.get(i).is_some_and(|t| t.is(b'{')) && kind != "FDAT" {
                    let (a, next) = aggregate(text, file, line, i)?;
                    (given, i) = (Some(a), next);
                } else if kind == "FDAT" {
                    // the program's own come first
                    self.frames.entry(name.clone()).or_insert((file, k));
                    let numbers = || ["TOOL_NO", "BASE_NO"].map(|field| field_number(text, line, field));
                    self.numbers.entry(name).or_insert_with(numbers);
                    return Ok(());
                } else {
                    spoiled = Some("its value is computed".into());
                }
            }
            while line.get(i).is_some_and(|t| !t.is(b',')) {
                i += 1;
            }
            let holds = match kind.as_str() {
                "E6AXIS" | "AXIS" => Holds::Axes,
                "FDAT" => continue,
                _ => Holds::Pose,
            };
            let next = self.names.len();
            let there = self.known(scope, &name);
            if text.context
                && let Some(there) = there
            {
                let there = &mut self.names[there];
                if there.context {
                    there.spoiled.get_or_insert_with(|| "it is declared in several modules".into());
                }
                continue;
            }
            if there.is_some() {
                return Err(text.bad(word.start, format!("a second declaration of {own}"), "each name declared once"));
            }
            self.by_name.entry(name.clone()).or_default().push((scope, next));
            let (type_word, local) = (line[at].span(), scope.is_some());
            let (assigned, used, read) = (Vec::new(), false, false);
            let line = k;
            self.names.push(Name {
                text: own,
                file,
                line,
                type_word,
                holds,
                local,
                global: global || text.context,
                context: text.context,
                array,
                of: None,
                given,
                assigned,
                used,
                spoiled,
                read,
            });
        }
        Ok(())
    }

    /// Assignments, and uses besides motions. `at`: the routine, and whether the line certainly runs in it.
    fn uses(&mut self, text: &Text, file: usize, k: usize, at: (usize, bool), line: &[Token]) -> Result<()> {
        let (routine, certain) = at;
        let goal = motion::goal_word(text, line);
        let sign = assignment(line);
        let call = calls(text, line).into_iter().next();
        for (i, t) in line.iter().enumerate() {
            if t.kind != Kind::Word || i > 0 && line[i - 1].is(b'.') {
                continue;
            }
            let Some((n, next)) = self.at(routine, text, line, i) else { continue };
            if (i, sign) != (0, Some(next)) {
                self.names[n].used_in(routine);
            }
            if Some(i) == goal {
                continue;
            }
            let spoil = |name: &mut Name, why: String| {
                name.spoiled.get_or_insert(why);
            };
            match sign {
                Some(sign) if i == 0 && sign == next && !self.names[n].array => {
                    let whole = line.get(sign + 1).filter(|t| t.is(b'{'));
                    let whole = whole.map(|_| aggregate(text, file, line, sign + 1)).transpose()?;
                    let whole = whole.filter(|(_, next)| *next == line.len()).map(|w| w.0);
                    if file > 0 {
                        self.initial(n, whole);
                        continue;
                    }
                    let used = self.names[n].used || self.names[n].of.is_some_and(|a| self.names[a].used);
                    let always = certain && !used;
                    self.names[n].assigned.push(Assigned { line: k, routine, aggregate: whole, always });
                }
                Some(_) if i == 0 => {
                    spoil(
                        &mut self.names[n],
                        format!("a part of it is assigned while the program runs (line {})", k + 1),
                    );
                }
                _ => match &call {
                    Some(name) => {
                        let why = format!("it is passed to {name}, which may change it (line {})", k + 1);
                        spoil(&mut self.names[n], why);
                    }
                    None => self.names[n].read = true,
                },
            }
        }
        Ok(())
    }

    /// The value that a data list gives a point on a line of its own.
    fn initial(&mut self, n: usize, value: Option<Aggregate>) {
        let name = &mut self.names[n];
        if name.given.is_some() || value.is_none() {
            name.spoiled.get_or_insert_with(|| "its value in the data list is not plain".into());
        }
        name.given = value;
    }

    /// The point that the word at token `i` names, and the token behind it: a name, an element of an array by a plain index, or the
    /// array itself where the index is computed.
    fn at(&mut self, routine: usize, text: &Text, line: &[Token], i: usize) -> Option<(usize, usize)> {
        let name = upper(text, line.get(i)?);
        let n = self.find(routine, &name)?;
        if !self.names[n].array {
            return Some((n, i + 1));
        }
        let Some((index, next)) = index(text, line, i + 1) else { return Some((n, i + 1)) };
        let scope = [Some(routine), None].into_iter().find(|s| self.known(*s, &name) == Some(n))?;
        let fresh = self.names.len();
        let element = format!("{name}[{index}]");
        let e = self.known(scope, &element).unwrap_or(fresh);
        if e == fresh {
            self.by_name.entry(element).or_default().push((scope, fresh));
            let array = &self.names[n];
            let element = Name {
                text: format!("{}[{index}]", array.text),
                array: false,
                of: Some(n),
                given: None,
                assigned: Vec::new(),
                used: false,
                spoiled: None,
                read: false,
                ..array.clone()
            };
            self.names.push(element);
        }
        Some((e, next))
    }

    /// What is done to an array by a computed index, or as a whole, is done to each of its elements.
    fn spread(&mut self) {
        for e in 0..self.names.len() {
            let Some(array) = self.names[e].of.and_then(|n| self.names.get(n)) else { continue };
            let (spoiled, read, used) = (array.spoiled.clone(), array.read, array.used);
            let element = &mut self.names[e];
            element.read |= read;
            if let Some(why) = spoiled {
                element.spoiled.get_or_insert(why);
            }
            if used {
                // which element is used before it is assigned is not known
                element.assigned.iter_mut().for_each(|a| a.always = false);
            }
        }
    }
}

/// `[2]` at token `at`: the index, and the token behind it.
pub(super) fn index(text: &Text, line: &[Token], at: usize) -> Option<(u32, usize)> {
    let [open, n, close] = line.get(at..at + 3)? else { return None };
    if !(open.is(b'[') && close.is(b']') && n.kind == Kind::Number) {
        return None;
    }
    Some((std::str::from_utf8(text.slice(n.span())).ok()?.parse().ok()?, at + 3))
}

/// Whether a text is a data list by its ending.
fn is_list(text: &Text) -> bool {
    text.name.rsplit_once('.').is_some_and(|(_, e)| e.eq_ignore_ascii_case("dat"))
}

/// KUKA's own BAS: it assigns the home positions of delta kinematics alone, which these arms are not.
fn is_basis(text: &Text) -> bool {
    let file = text.name.rsplit(['/', '\\']).next().unwrap_or_default();
    file.eq_ignore_ascii_case("bas.src")
}

/// Names that the module of `text` declares for itself: in the text, and in those of the same stem.
fn of_module(texts: &[Text], text: &Text) -> HashSet<String> {
    let stem = |t: &Text| t.name.rsplit_once('.').map_or(t.name.as_str(), |(s, _)| s).to_ascii_uppercase();
    let own = stem(text);
    let mut names = HashSet::new();
    let mut line = Vec::new();
    for text in texts.iter().filter(|t| stem(t) == own) {
        for k in 0..text.line_count() {
            tokens(text, k, &mut line);
            if let Some(at) = declaration(text, &line)
                && !line[..at].iter().any(|t| upper(text, t) == "GLOBAL")
            {
                let words = line[at + 1..].iter().filter(|t| t.kind == Kind::Word);
                names.extend(words.map(|t| upper(text, t)));
            }
        }
    }
    names
}

/// Whether a line begins a routine.
pub(super) fn is_routine(first: &str, second: &str) -> bool {
    matches!(first, "DEF" | "DEFFCT") || first == "GLOBAL" && matches!(second, "DEF" | "DEFFCT")
}

/// Whether a line that begins with this word may begin a routine or declare something.
fn may_declare(word: &[u8]) -> bool {
    let words = ["DEF", "DEFFCT", "GLOBAL", "DECL", "CONST", "E6AXIS", "AXIS", "E6POS", "POS", "FRAME", "FDAT"];
    words.iter().any(|w| word.eq_ignore_ascii_case(w.as_bytes()))
}

/// The token of the type of a declaration of points or frame data.
fn declaration(text: &Text, line: &[Token]) -> Option<usize> {
    let mut at = 0;
    while let Some(t) = line.get(at).filter(|t| t.kind == Kind::Word) {
        match upper(text, t).as_str() {
            "DECL" | "GLOBAL" | "CONST" => at += 1,
            "E6AXIS" | "AXIS" | "E6POS" | "POS" | "FRAME" | "FDAT" => {
                return line.get(at + 1).is_some_and(|t| t.kind == Kind::Word).then_some(at);
            }
            _ => return None,
        }
    }
    None
}

/// The `=` of an assignment; not `==`, `<=`, `>=`, and not within brackets.
pub(super) fn assignment(line: &[Token]) -> Option<usize> {
    if line.first()?.kind != Kind::Word {
        return None;
    }
    let mut depth = 0_usize;
    for (i, t) in line.iter().enumerate().skip(1) {
        match t.kind {
            Kind::Mark(b'[') => depth += 1,
            Kind::Mark(b']') => depth = depth.saturating_sub(1),
            Kind::Mark(b'=') if depth == 0 => return (!line.get(i + 1).is_some_and(|t| t.is(b'='))).then_some(i),
            Kind::Mark(b'.') => {}
            Kind::Word if line[i - 1].is(b'.') => {}
            _ if depth > 0 => {}
            _ => return None,
        }
    }
    None
}

/// The number that follows a field: `TOOL_NO 1`.
fn field_number<T: std::str::FromStr>(text: &Text, line: &[Token], field: &str) -> Option<T> {
    let at = line.iter().position(|t| upper(text, t) == field)?;
    std::str::from_utf8(text.slice(line.get(at + 1)?.span())).ok()?.parse().ok()
}
