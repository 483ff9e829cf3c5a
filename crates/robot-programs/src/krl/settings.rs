//! Speeds, approximation and frames as a program sets them: known while the text is certain to be what ran last.

use super::aggregate::aggregate;
use super::data::Data;
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
}

/// What the text has put into a list of the controller.
fn listed(frame: Frame, list: &BTreeMap<u32, Frame>) -> Frame {
    let own = match &frame {
        Frame::Named(name) => name.parse::<u32>().ok().and_then(|n| list.get(&n).cloned()),
        _ => None,
    };
    own.unwrap_or(frame)
}

/// `TOOL_NO 1` of an aggregate.
fn numbered_field(text: &Text, value: &[Token], field: &str) -> Option<u32> {
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
            ("$BASE", part) => self.base = Some(listed(frame(text, value, part, "BASE_DATA", known), &self.bases)),
            ("$TOOL", part) => self.tool = Some(listed(frame(text, value, part, "TOOL_DATA", known), &self.tools)),
            // #BASE: the robot carries the tool
            ("$IPO_MODE", None) if value.get(1).is_some_and(|t| upper(text, t) == "BASE") => {}
            ("$IPO_MODE" | "$WORLD" | "$ROBROOT", _) => self.base = Some(Frame::Unknown(format!("{word} is set"))),
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
                (self.tool, self.base) = (Some(of(numbers[0], "tool")), Some(of(numbers[1], "base")));
            }
            ("FDAT_ACT", Some("TOOL_NO")) => self.tool = Some(numbered(text, value, "TOOL_DATA")),
            ("FDAT_ACT", Some("BASE_NO")) => self.base = Some(numbered(text, value, "BASE_DATA")),
            ("FDAT_ACT", Some(_)) => {}
            // BASE_DATA[2]={X 0,...}
            ("BASE_DATA" | "TOOL_DATA", None) => {
                let number =
                    line.get(2).filter(|_| sign == 4).and_then(|t| self::number(text, std::slice::from_ref(t)));
                let list = if word == "BASE_DATA" { &mut self.bases } else { &mut self.tools };
                match number.filter(|n| *n > 0.0 && n.fract() == 0.0) {
                    Some(n) => drop(list.insert(n as u32, frame(text, value, None, word, known))),
                    // any of them
                    None => list.clear(),
                }
            }
            _ => {}
        }
    }

    /// `BAS(#PTP_PARAMS,100)`: settings, no motion.
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
            "BASE" => self.base = Some(listed(numbered(text, argument, "BASE_DATA"), &self.bases)),
            "TOOL" => self.tool = Some(listed(numbered(text, argument, "TOOL_DATA"), &self.tools)),
            _ => {}
        }
        if matches!(command.as_str(), "CP_PARAMS" | "PTP_PARAMS" | "FRAMES") {
            // they set the distance of approximate positioning, too; frames are those of FDAT_ACT
            self.apo_m = None;
        }
    }
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
