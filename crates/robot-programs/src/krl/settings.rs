//! Speeds, approximation and frames as a program sets them: known while the text is certain to be what ran last.

use super::aggregate::aggregate;
use super::data::Data;
use super::going::Turning;
use super::lex::{Kind, Token, upper};
use crate::script::pose::Frame;
use crate::script::{Text, number as digits};
use nalgebra::Isometry3;
use std::collections::BTreeMap;

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Settings {
    /// %, of all axes by BAS, and of each by $VEL_AXIS.
    pub vel_ptp: Option<f64>,
    pub vel_axes: [Option<f64>; 6],
    /// m/s.
    pub vel_cp: Option<f64>,
    /// $APO.CDIS.
    pub apo_m: Option<f64>,
    /// $BASE and $TOOL as the text sets them; `None`: it has not.
    pub base: Option<Frame>,
    pub tool: Option<Frame>,
    /// BASE_DATA and TOOL_DATA that the text sets before.
    pub bases: BTreeMap<u32, Frame>,
    pub tools: BTreeMap<u32, Frame>,
    /// BASE_DATA and TOOL_DATA are set by an index that is computed: any of them may be another one.
    pub any: [bool; 2],
    /// Base and tool of `FDAT_ACT`, which `BAS` puts into force with the parameters of a motion.
    pub frame_data: Option<[Frame; 2]>,
    /// What makes any base mean something else: `$IPO_MODE`, `$WORLD`.
    pub carried: Option<String>,
    pub moved: Option<String>,
    /// How the tool turns on the way, by `$ORI_TYPE`; by `LDAT_ACT`, which `BAS` puts into force; the latter is set and not in force yet.
    pub turning: Turning,
    pub motion_data: Option<Turning>,
    pub pending: bool,
}

/// What the text sets in the lists of the controller, wherever it stands: by number, any of these.
#[derive(Debug, Clone, Default)]
pub(super) struct Lists {
    bases: BTreeMap<u32, Frame>,
    tools: BTreeMap<u32, Frame>,
    any: [bool; 2],
}

impl Lists {
    /// Takes what an assignment has set.
    pub fn add(&mut self, set: &Settings) {
        for (all, own) in [(&mut self.bases, &set.bases), (&mut self.tools, &set.tools)] {
            for (n, frame) in own {
                let both = all.remove(n).map_or_else(|| frame.clone(), |there| either(there, frame.clone()));
                all.insert(*n, both);
            }
        }
        self.any = [self.any[0] || set.any[0], self.any[1] || set.any[1]];
    }

    /// Whether the text sets none.
    pub fn is_empty(&self) -> bool {
        self.bases.is_empty() && self.tools.is_empty() && self.any == [false; 2]
    }
}

/// One of two frames, and which is not certain.
fn either(a: Frame, b: Frame) -> Frame {
    let of = |frame| match frame {
        Frame::Any(all) => all,
        one => vec![one],
    };
    let mut all = of(a);
    for frame in of(b) {
        if !all.contains(&frame) {
            all.push(frame);
        }
    }
    match all.len() {
        1 => all.remove(0),
        _ => Frame::Any(all),
    }
}

impl Settings {
    /// Settings of which nothing is known but how the tool may turn.
    pub fn turning(turning: Turning) -> Self {
        let motion_data = (turning != Turning::Evenly).then_some(turning);
        Self { turning, motion_data, ..Self::default() }
    }

    /// `$ORI_TYPE` is set, or (`of_data`) `LDAT_ACT`.
    pub fn turns(&mut self, turning: Turning, of_data: bool) {
        if of_data {
            (self.motion_data, self.pending) = (Some(turning), true);
        } else {
            (self.turning, self.pending) = (turning, false);
        }
    }

    /// How the tool turns on the way of a motion.
    pub fn turning_now(&self) -> Turning {
        self.turning.max(self.motion_data.filter(|_| self.pending).unwrap_or_default())
    }

    /// Where control may come from elsewhere: a list of the controller holds what it held here, or what the text sets anywhere;
    /// `unset`: or what the controller has.
    pub fn merge_all(&mut self, all: &Lists, unset: bool) {
        let lists = [(&mut self.bases, &all.bases, all.any[0]), (&mut self.tools, &all.tools, all.any[1])];
        for (list, other, any) in lists {
            for (n, frame) in other {
                let computed = any.then(|| Frame::Named(format!("{n} as the program sets it")));
                let frame = computed.map_or_else(|| frame.clone(), |computed| either(frame.clone(), computed));
                let own = Frame::Named(n.to_string());
                let here = list.remove(n).unwrap_or_else(|| own.clone());
                let here = if unset { either(own, here) } else { here };
                list.insert(*n, either(here, frame));
            }
        }
        self.any = [self.any[0] || all.any[0], self.any[1] || all.any[1]];
    }

    /// After a block that may have been passed by: what it has put into a list of the controller, or what was there before.
    pub fn merge_lists(&mut self, before: &Self) {
        for (list, was) in [(&mut self.bases, &before.bases), (&mut self.tools, &before.tools)] {
            for n in was.keys().copied().chain(list.keys().copied()).collect::<Vec<u32>>() {
                let of = |list: &BTreeMap<u32, Frame>| list.get(&n).cloned().unwrap_or(Frame::Named(n.to_string()));
                let merged = either(of(was), of(list));
                list.insert(n, merged);
            }
        }
        self.any = [self.any[0] || before.any[0], self.any[1] || before.any[1]];
    }

    /// The frame of a list by its number, as the text has set it.
    fn of_list(&self, frame: Frame, list: &str) -> Frame {
        let tools = usize::from(list == "TOOL_DATA");
        let all = if tools == 1 { &self.tools } else { &self.bases };
        match &frame {
            Frame::Named(name) => match name.parse::<u32>().ok().and_then(|n| all.get(&n).cloned()) {
                Some(own) => own,
                None if self.any[tools] => Frame::Named(format!("{name} as the program sets it")),
                None => frame,
            },
            _ => frame,
        }
    }
}

/// Base and tool as `either` of both.
pub(super) fn one_of(a: Option<&Frame>, name: &str, b: Option<&Frame>) -> Option<Frame> {
    let named = || Frame::Named(name.into());
    match (a, b) {
        (None, None) => None,
        (a, b) => Some(either(a.cloned().unwrap_or_else(named), b.cloned().unwrap_or_else(named))),
    }
}

/// `TOOL_NO 1` of an aggregate.
///
/// `field = name digit {digit}`
pub(super) fn numbered_field(text: &Text, value: &[Token], field: &str) -> Option<u32> {
    let at = value.iter().position(|t| upper(text, t) == field)?;
    std::str::from_utf8(text.slice(value.get(at + 1)?.span())).ok()?.parse().ok()
}

/// Tokens as they stand there.
fn written(text: &Text, value: &[Token]) -> String {
    let (Some(a), Some(b)) = (value.first(), value.last()) else { return String::new() };
    crate::error::one_line(&String::from_utf8_lossy(text.slice(a.start..b.end)))
}

/// A plain number.
pub(super) fn number(text: &Text, value: &[Token]) -> Option<f64> {
    let [t] = value else { return None };
    (t.kind == Kind::Number).then(|| digits::read(text.slice(t.span())).map(|v| v.0)).flatten()
}

impl Settings {
    /// Speed of a joint motion in percent.
    pub fn share(&self) -> Option<f64> {
        let first = self.vel_axes[0];
        self.vel_ptp.or_else(|| first.filter(|_| self.vel_axes.iter().all(|v| *v == first)))
    }

    /// An assignment to `word`, its `=` at `sign`.
    ///
    /// `setting = word ["." part | "[" digit {digit} "]"] "=" value`
    pub fn assign(&mut self, text: &Text, line: &[Token], sign: usize, word: &str, data: &Data, routine: usize) {
        let known = &|name: &str| data.frame(routine, name);
        let value = line.get(sign + 1..).unwrap_or_default();
        let number = number(text, value);
        let part = if line.get(1).is_some_and(|t| t.is(b'.')) { line.get(2).map(|t| upper(text, t)) } else { None };
        match (word, part.as_deref()) {
            ("$VEL", Some("CP")) => self.vel_cp = number,
            ("$VEL", None) => self.vel_cp = None,
            ("$APO", Some("CDIS")) => self.apo_m = number.map(|v| v * 1e-3),
            ("$APO", None) => self.apo_m = None,
            ("$VEL_AXIS", _) => {
                self.vel_ptp = None;
                let index = line.get(2).filter(|_| sign == 4);
                match index.and_then(|t| std::str::from_utf8(text.slice(t.span())).ok()?.parse::<usize>().ok()) {
                    Some(i) => {
                        if let Some(v) = i.checked_sub(1).and_then(|i| self.vel_axes.get_mut(i)) {
                            *v = number;
                        }
                    }
                    // a loop over the axes
                    None => self.vel_axes = [number; 6],
                }
            }
            ("$BASE", part) => {
                self.base = Some(self.of_list(frame(text, value, part, "BASE_DATA", known), "BASE_DATA"))
            }
            ("$TOOL", part) => {
                self.tool = Some(self.of_list(frame(text, value, part, "TOOL_DATA", known), "TOOL_DATA"))
            }
            // #BASE: the robot carries the tool
            ("$IPO_MODE", None) if value.get(1).is_some_and(|t| upper(text, t) == "BASE") => self.carried = None,
            ("$IPO_MODE", _) => self.carried = Some(format!("{word} is set")),
            ("$WORLD" | "$ROBROOT", _) => self.moved = Some(format!("{word} is set")),
            // the frame data of an inline form come into force with its BAS
            ("FDAT_ACT", None) => {
                let name = value.first().map(|t| upper(text, t)).unwrap_or_default();
                // {TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}, or a name that is declared so
                let numbers = match value.first() {
                    Some(t) if t.is(b'{') => ["TOOL_NO", "BASE_NO"].map(|field| numbered_field(text, value, field)),
                    _ => data.numbers.get(&name).copied().unwrap_or_default(),
                };
                let of = |number: Option<u32>, what: &str| match number {
                    Some(0) => Frame::Null,
                    Some(n) => Frame::Named(n.to_string()),
                    None => Frame::Named(format!("{what} of {name}")),
                };
                let tool = self.of_list(of(numbers[0], "tool"), "TOOL_DATA");
                let base = self.of_list(of(numbers[1], "base"), "BASE_DATA");
                self.frame_data = Some([base.clone(), tool.clone()]);
                (self.tool, self.base, self.carried) = (Some(tool), Some(base), None);
            }
            ("FDAT_ACT", Some("TOOL_NO")) => {
                let tool = self.of_list(numbered(text, value, "TOOL_DATA"), "TOOL_DATA");
                if let Some([_, of_data]) = &mut self.frame_data {
                    of_data.clone_from(&tool);
                }
                self.tool = Some(tool);
            }
            ("FDAT_ACT", Some("BASE_NO")) => {
                let base = self.of_list(numbered(text, value, "BASE_DATA"), "BASE_DATA");
                if let Some([of_data, _]) = &mut self.frame_data {
                    of_data.clone_from(&base);
                }
                self.base = Some(base);
            }
            ("FDAT_ACT", Some(_)) => {}
            // BASE_DATA[2]={X 0,...}
            ("BASE_DATA" | "TOOL_DATA", None) => {
                // the index alone, or a part of the frame at it: BASE_DATA[2].X=100
                let plain = line.get(3).is_some_and(|t| t.is(b']'));
                let number = line.get(2).filter(|_| plain).and_then(|t| self::number(text, std::slice::from_ref(t)));
                let tools = usize::from(word == "TOOL_DATA");
                let list = if tools == 1 { &mut self.tools } else { &mut self.bases };
                match number.filter(|n| *n > 0.0 && n.fract() == 0.0) {
                    Some(n) => {
                        let part = (sign != 4).then_some(());
                        let whole = || frame(text, value, None, word, known);
                        let set = part.map_or_else(whole, |()| Frame::Named(format!("{n:.0} as the program sets it")));
                        list.insert(n as u32, set);
                    }
                    // any of them
                    None => {
                        list.clear();
                        self.any[tools] = true;
                    }
                }
            }
            _ => {}
        }
    }

    /// `BAS(#PTP_PARAMS,100)`: settings, no motion.
    ///
    /// `bas = "BAS" "(" "#" command ["," argument] ")"`
    pub fn bas(&mut self, text: &Text, line: &[Token]) {
        let command = line.get(3).map(|t| upper(text, t)).unwrap_or_default();
        let argument = line.get(5..).and_then(|v| v.get(..v.len().saturating_sub(1))).unwrap_or_default();
        let value = number(text, argument);
        match command.as_str() {
            "PTP_PARAMS" | "VEL_PTP" => {
                self.vel_ptp = value;
                self.vel_axes = [None; 6];
            }
            "CP_PARAMS" | "VEL_CP" => self.vel_cp = value,
            "BASE" => self.base = Some(self.of_list(numbered(text, argument, "BASE_DATA"), "BASE_DATA")),
            "TOOL" => self.tool = Some(self.of_list(numbered(text, argument, "TOOL_DATA"), "TOOL_DATA")),
            // the base on the flange of an external axis: it moves with that
            "EX_BASE" => self.base = Some(Frame::Named(format!("EX_BASE {}", written(text, argument)))),
            // back to the frames with which programs begin: the world, and a tool that differs by the version of BAS
            "INITMOV" => {
                (self.base, self.tool, self.carried) = (None, None, None);
                (self.turning, self.pending) = (Turning::Evenly, false);
            }
            _ => {}
        }
        if matches!(command.as_str(), "CP_PARAMS" | "CP_DAT") {
            (self.turning, self.pending) = (self.motion_data.unwrap_or(self.turning), false);
        }
        if matches!(command.as_str(), "CP_PARAMS" | "PTP_PARAMS" | "FRAMES") {
            // they put base and tool of FDAT_ACT into force again, whatever was set since
            match &self.frame_data {
                Some([base, tool]) => (self.base, self.tool) = (Some(base.clone()), Some(tool.clone())),
                None => {
                    let of_data = |what: &str| Some(Frame::Named(format!("{what} of FDAT_ACT")));
                    self.base = self.base.take().and_then(|_| of_data("base"));
                    self.tool = self.tool.take().and_then(|_| of_data("tool"));
                }
            }
        }
        if matches!(command.as_str(), "CP_PARAMS" | "PTP_PARAMS" | "FRAMES") {
            // they set the distance of approximate positioning, too; frames are those of FDAT_ACT
            self.apo_m = None;
        }
    }
}

/// What a motion (or a spline block) sets for itself: `WITH $TOOL=STOOL2(FP1), $BASE=SBASE(FP1.BASE_NO)`; base and tool.
///
/// `with = "WITH" ... ("$BASE" | "$TOOL") [part] "=" ("STOOL2" | "STOOL" | "SBASE") "(" frame_data ... | ... "=" frame`
pub(super) fn with(set: &Settings, text: &Text, line: &[Token], data: &Data, routine: usize) -> [Option<Frame>; 2] {
    let Some(at) = line.iter().position(|t| t.kind == Kind::Word && upper(text, t) == "WITH") else {
        return [None, None];
    };
    let known = &|name: &str| data.frame(routine, name);
    let of = |word: &str, list: &str, field: usize| {
        let place = line.iter().enumerate().skip(at).find(|(_, t)| t.kind == Kind::Word && upper(text, t) == word)?.0;
        let Some(sign) = (place + 1..line.len()).find(|&k| line[k].is(b'=')) else {
            return Some(Frame::Unknown(format!("WITH {word}")));
        };
        let (mut depth, mut end) = (0_usize, sign + 1);
        while let Some(t) = line.get(end) {
            match t.kind {
                Kind::Mark(b'{' | b'(' | b'[') => depth += 1,
                Kind::Mark(b'}' | b')' | b']') => depth = depth.saturating_sub(1),
                Kind::Mark(b',') if depth == 0 => break,
                Kind::Word if depth == 0 && end > sign + 1 && upper(text, t).starts_with("C_") => break,
                _ => {}
            }
            end += 1;
        }
        let value = &line[sign + 1..end];
        let part = (sign > place + 1).then_some("a part");
        let function = value.first().map(|t| upper(text, t)).unwrap_or_default();
        let frame_data = value.get(2).map(|t| upper(text, t)).filter(|_| value.get(1).is_some_and(|t| t.is(b'(')));
        let number = match function.as_str() {
            "STOOL2" | "STOOL" | "SBASE" => frame_data.and_then(|name| data.numbers.get(&name).copied()?[field]),
            _ => None,
        };
        let frame = match number {
            Some(0) => Frame::Null,
            Some(n) => Frame::Named(n.to_string()),
            None => frame(text, value, part, list, known),
        };
        Some(set.of_list(frame, list))
    };
    [of("$BASE", "BASE_DATA", 1), of("$TOOL", "TOOL_DATA", 0)]
}

/// A frame by its number in a list; one that is computed is asked for by what computes it.
fn numbered(text: &Text, value: &[Token], list: &str) -> Frame {
    match number(text, value) {
        Some(0.0) => Frame::Null,
        Some(n) if n > 0.0 && n.fract() == 0.0 => Frame::Named(format!("{n:.0}")),
        _ => Frame::Named(format!("{list}[{}]", written(text, value))),
    }
}

/// What is assigned to a frame: `$NULLFRAME`, `BASE_DATA[2]`, `{X 0,Y 0,Z 180,A 0,B 0,C 0}`, the name of such a one.
///
/// `value = "$NULLFRAME" | name | list "[" number "]" | aggregate | expression`
fn frame(
    text: &Text,
    value: &[Token],
    part: Option<&str>,
    list: &str,
    known: &dyn Fn(&str) -> Option<Isometry3<f64>>,
) -> Frame {
    let computed = || Frame::Named(written(text, value));
    if let Some(part) = part {
        return Frame::Named(format!("{part} set to {}", written(text, value)));
    }
    match value {
        [t] if upper(text, t) == "$NULLFRAME" => Frame::Null,
        [t] if t.kind == Kind::Word => known(&upper(text, t)).map_or_else(computed, Frame::Given),
        [t, open, n, close] if upper(text, t) == list && open.is(b'[') && close.is(b']') => {
            numbered(text, std::slice::from_ref(n), list)
        }
        [open, ..] if open.is(b'{') => {
            let whole = aggregate(text, 0, value, 0).ok().filter(|(_, next)| *next == value.len());
            whole.and_then(|(a, _)| a.isometry()).map_or_else(computed, Frame::Given)
        }
        _ => computed(),
    }
}
