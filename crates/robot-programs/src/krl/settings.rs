//! Speeds, approximation and frames as a program sets them: known while the text is certain to be what ran last.

use super::data::upper;
use super::data::{Data, aggregate};
use super::lex::{Kind, Token};
use crate::script::pose::{Frame, PoseForm};
use crate::script::{Text, number as digits};

#[derive(Debug, Clone, Default)]
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
    pub fn assign(&mut self, text: &Text, line: &[Token], sign: usize, word: &str, data: &Data) {
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
            ("$BASE", part) => self.base = Some(frame(text, value, part, "BASE_DATA")),
            ("$TOOL", part) => self.tool = Some(frame(text, value, part, "TOOL_DATA")),
            // #BASE: the robot carries the tool
            ("$IPO_MODE", None) if value.get(1).is_some_and(|t| upper(text, t) == "BASE") => {}
            ("$IPO_MODE" | "$WORLD" | "$ROBROOT", _) => self.base = Some(Frame::Unknown(format!("{word} is set"))),
            // the frame data of an inline form come into force with its BAS
            ("FDAT_ACT", None) => {
                let name = value.first().map(|t| upper(text, t)).unwrap_or_default();
                let numbers = data.numbers.get(&name).copied().unwrap_or_default();
                let of = |number: Option<u32>| match number {
                    Some(0) => Frame::Null,
                    Some(n) => Frame::Named(n.to_string()),
                    None => Frame::Unknown(format!("frame data {name}, which are not in the files given")),
                };
                (self.tool, self.base) = (Some(of(numbers[0])), Some(of(numbers[1])));
            }
            ("FDAT_ACT", Some(_)) => {
                let computed = || Some(Frame::Unknown("frame data that are set in parts".into()));
                (self.tool, self.base) = (computed(), computed());
            }
            _ => {}
        }
    }

    /// `BAS(#PTP_PARAMS,100)`: settings, no motion.
    pub fn bas(&mut self, text: &Text, line: &[Token]) {
        let command = line.get(3).map(|t| upper(text, t)).unwrap_or_default();
        let value = line.get(5..).and_then(|v| number(text, v.get(..v.len().saturating_sub(1)).unwrap_or_default()));
        match command.as_str() {
            "PTP_PARAMS" | "VEL_PTP" => {
                self.vel_ptp = value;
                self.vel_axes = [None; 6];
            }
            "CP_PARAMS" | "VEL_CP" => self.vel_cp = value,
            "BASE" => self.base = Some(numbered(value)),
            "TOOL" => self.tool = Some(numbered(value)),
            _ => {}
        }
        if matches!(command.as_str(), "CP_PARAMS" | "PTP_PARAMS" | "FRAMES") {
            // they set the distance of approximate positioning, too; frames are those of FDAT_ACT
            self.apo_m = None;
        }
    }
}

/// A frame by a number that is written.
fn numbered(value: Option<f64>) -> Frame {
    match value {
        Some(0.0) => Frame::Null,
        Some(n) if n > 0.0 && n.fract() == 0.0 => Frame::Named(format!("{n:.0}")),
        _ => Frame::Unknown("its number is computed".into()),
    }
}

/// What is assigned to a frame: `$NULLFRAME`, `BASE_DATA[2]`, `{X 0,Y 0,Z 180,A 0,B 0,C 0}`.
fn frame(text: &Text, value: &[Token], part: Option<&str>, list: &str) -> Frame {
    let computed = || Frame::Unknown("it is computed".into());
    if part.is_some() {
        return Frame::Unknown("a part of it is assigned".into());
    }
    match value {
        [t] if upper(text, t) == "$NULLFRAME" => Frame::Null,
        [t, open, n, close] if upper(text, t) == list && open.is(b'[') && close.is(b']') => {
            numbered(number(text, std::slice::from_ref(n)))
        }
        [open, ..] if open.is(b'{') => {
            let whole = aggregate(text, 0, value, 0).ok().filter(|(_, next)| *next == value.len());
            let numbers = whole.and_then(|(a, _)| a.coordinates()).map(|v| v.iter().flatten().map(|v| v.si).collect());
            let pose = numbers.and_then(|n: Vec<f64>| PoseForm::EulerZyx.pose(&n));
            pose.map_or_else(computed, Frame::Given)
        }
        _ => computed(),
    }
}
