//! Speeds, approximation and frames as a program sets them: known while the text is certain to be what ran last.

use super::data::upper;
use super::lex::{Kind, Token};
use crate::script::{Text, number as digits};

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Settings {
    /// %, of all axes by BAS, and of each by $VEL_AXIS.
    vel_ptp: Option<f64>,
    vel_axes: [Option<f64>; 6],
    /// m/s.
    pub vel_cp: Option<f64>,
    /// $APO.CDIS.
    pub apo_m: Option<f64>,
    /// $BASE and $TOOL are certainly null.
    pub base_null: bool,
    pub tool_null: bool,
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

    /// An assignment to `word`, its `=` at `sign`; whether it changes a frame.
    pub fn assign(&mut self, text: &Text, line: &[Token], sign: usize, word: &str) -> bool {
        let value = line.get(sign + 1..).unwrap_or_default();
        let number = number(text, value);
        let part = if line.get(1).is_some_and(|t| t.is(b'.')) { line.get(2).map(|t| upper(text, t)) } else { None };
        let null = part.is_none() && matches!(value, [t] if upper(text, t) == "$NULLFRAME");
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
            ("$BASE", _) => self.base_null = null,
            ("$TOOL", _) => self.tool_null = null,
            ("$IPO_MODE" | "$WORLD" | "$ROBROOT", _) => self.base_null = false,
            // the frame data of an inline form come into force with its BAS
            ("FDAT_ACT", _) => (self.base_null, self.tool_null) = (false, false),
            _ => {}
        }
        matches!(word, "$BASE" | "$TOOL" | "$IPO_MODE" | "$WORLD" | "$ROBROOT")
    }

    /// `BAS(#PTP_PARAMS,100)`: settings, no motion; whether it changes a frame for all that follows.
    pub fn bas(&mut self, text: &Text, line: &[Token]) -> bool {
        let command = line.get(3).map(|t| upper(text, t)).unwrap_or_default();
        let value = line.get(5..).and_then(|v| number(text, v.get(..v.len().saturating_sub(1)).unwrap_or_default()));
        match command.as_str() {
            "PTP_PARAMS" | "VEL_PTP" => {
                self.vel_ptp = value;
                self.vel_axes = [None; 6];
            }
            "CP_PARAMS" | "VEL_CP" => self.vel_cp = value,
            "BASE" => self.base_null = value == Some(0.0),
            "TOOL" => self.tool_null = value == Some(0.0),
            _ => {}
        }
        if matches!(command.as_str(), "CP_PARAMS" | "PTP_PARAMS" | "FRAMES") {
            // they set frames, and the distance of approximate positioning too
            (self.base_null, self.tool_null, self.apo_m) = (false, false, None);
        }
        matches!(command.as_str(), "BASE" | "TOOL")
    }
}
