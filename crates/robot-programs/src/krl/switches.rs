//! What statements switch on and off that leads the robot away from its points, as bits of the states that [`led`](super::led) follows.
//!
//! A soft servo: `$TORQUE_AXIS` and `$CURR_RED[axis,limit]` of KRC2, `SET_TORQUE_LIMITS(axis,...)` of KRC4, by axis. A sensor: `RSI_ON`,
//! and `ST_ON` of the RSI of KRC2. Weaving and seam tracking of KUKA.ArcTech, by the [weld data](super::seam) of the seam.

use super::calls::arc_state;
use super::frame::written;
use super::lex::{Kind, Token, in_upper, upper};
use super::reason::Reason;
use super::seam::{Seam, WeldData};
use super::statement::{assignment, is_routine, statements};
use crate::script::Text;
use crate::script::held::Event;
use crate::script::number as digits;

const CONVEYOR: u32 = 1;
const SENSOR: u32 = 2;
const OFFSET: u32 = 4;
const GENERATOR: u32 = 8;
const TORQUE: u32 = 16;
const WEAVES: u32 = 32;
const TRACKS: u32 = 64;
const WELD_DATA: u32 = 128;
/// What holds on a seam.
const SEAM: u32 = WEAVES | TRACKS | WELD_DATA;
/// Bits of `$CURR_RED`, and of `SET_TORQUE_LIMITS`, by what stands in the brackets.
const CURRENTS: u32 = 0x001f_ff00;
const LIMITS: u32 = 0xffe0_0000;

/// States that a text does not begin with although it ends them: a new seam ends what held on the one before, and a program begins with
/// full currents.
pub(super) const ENDED_ANYWAY: u32 = SEAM | CURRENTS;

/// What the texts of a program have in common: weld data, and the bits of axes.
#[derive(Debug, Default)]
pub(super) struct Switches {
    weld_data: WeldData,
    /// Weld data of seams that are not certain, with their lines in the program itself.
    uncertain: Vec<(Option<usize>, Box<str>)>,
    currents: Vec<String>,
    limits: Vec<String>,
}

/// The bit of a key among those of `mask`; the last one is that of all further keys.
fn bit(keys: &mut Vec<String>, mask: u32, key: String) -> u32 {
    let at = keys.iter().position(|k| *k == key).unwrap_or_else(|| {
        keys.push(key);
        keys.len() - 1
    });
    1 << (mask.trailing_zeros() + (at as u32).min(mask.count_ones() - 1))
}

/// The same where it stands for this key alone: several cannot be told to have ended.
fn own_bit(keys: &mut Vec<String>, mask: u32, key: String) -> u32 {
    let own = bit(keys, mask, key);
    if own.leading_zeros() == mask.leading_zeros() { 0 } else { own }
}

/// The tokens of a bracket that opens at token `at`, up to `ends`, without blanks.
fn key(text: &Text, line: &[Token], at: usize, ends: &[u8]) -> String {
    let inside = line.iter().skip(at + 1).take_while(|t| !t.mark().is_some_and(|m| ends.contains(&m)));
    inside.map(|t| upper(text, t)).collect()
}

/// The token of a name that stands before a bracket.
fn called(text: &Text, line: &[Token], name: &str) -> Option<usize> {
    line.windows(2).position(|w| w[0].kind == Kind::Word && w[1].is(b'(') && in_upper(text, &w[0]) == name)
}

/// A plain number, also in bits (`'B000000'`, `'H0F'`).
fn value(text: &Text, value: &[Token]) -> Option<f64> {
    let [t] = value else { return None };
    let bytes = text.slice(t.span());
    match (t.kind, bytes) {
        (Kind::Number, _) => digits::read(bytes).map(|v| v.0),
        (Kind::Quoted, [_, base, inside @ .., _]) => {
            let radix = if base.eq_ignore_ascii_case(&b'B') { 2 } else { 16 };
            let inside: String = String::from_utf8_lossy(inside).split_whitespace().collect();
            u32::from_str_radix(&inside, radix).ok().map(f64::from)
        }
        _ => None,
    }
}

impl Switches {
    /// Of a program and its project.
    pub fn of(texts: &[Text]) -> Self {
        Self { weld_data: WeldData::of(texts), ..Self::default() }
    }

    /// Why a motion on line `k` stays where these states are on.
    pub fn reason(&self, bits: u32, k: usize) -> Option<Reason> {
        let names = [
            (CONVEYOR, "a conveyor"),
            (SENSOR, "a sensor (RSI_ON)"),
            (OFFSET, "$JOINT_OFFSET"),
            (GENERATOR, "a function generator ($TECH)"),
            (TORQUE | CURRENTS | LIMITS, "a soft servo"),
            (WEAVES, "weaving"),
            (TRACKS, "seam tracking"),
        ];
        if let Some((_, by)) = names.iter().find(|n| bits & n.0 != 0) {
            return Some(Reason::Led(by));
        }
        let before = || self.uncertain.iter().rfind(|(line, _)| line.is_some_and(|line| line < k));
        let name = || before().or(self.uncertain.first()).map(|(_, name)| name.clone()).unwrap_or_default();
        (bits & WELD_DATA != 0).then(|| Reason::WeldDataUncertain(name()))
    }

    /// Adds what a line switches; `k`: the line, in the program itself. What stands after DO runs perhaps.
    pub fn add(&mut self, text: &Text, k: Option<usize>, line: &[Token], out: &mut Vec<Event>) {
        let second = line.get(1).map(|t| upper(text, t)).unwrap_or_default();
        let first = line.first().map(|t| upper(text, t)).unwrap_or_default();
        if is_routine(&first, &second) || first.starts_with("EXT") {
            return;
        }
        for (n, statement) in statements(text, line).into_iter().enumerate() {
            let from = out.len();
            self.statement(text, k, statement, out);
            if n > 0 && out.len() > from {
                out.insert(from, Event::Open(false));
                out.push(Event::Close);
            }
        }
    }

    /// `switch = lead | "$TORQUE_AXIS" "=" value | "$CURR_RED" "[" axis "," number "]" "=" value | ... "SET_TORQUE_LIMITS" "(" axis ... |
    /// ... "RESET_TORQUE_LIMITS" "(" axis ")" | ... ("ST_ON" | "ST_ON1" | "ST_OFF") "(" ... | seam`
    fn statement(&mut self, text: &Text, k: Option<usize>, line: &[Token], out: &mut Vec<Event>) {
        let Some(word) = line.first().map(|t| upper(text, t)) else { return };
        let is_called = |name: &str| called(text, line, name).is_some();
        lead(text, line, &word, out);
        if is_called("ST_ON") || is_called("ST_ON1") {
            out.push(Event::On(SENSOR));
        } else if is_called("ST_OFF") {
            out.push(Event::Off(SENSOR));
        }
        let number = assignment(line).map(|sign| value(text, line.get(sign + 1..).unwrap_or_default()));
        match (word.as_str(), number) {
            ("$TORQUE_AXIS", Some(Some(0.0))) if line.get(1).is_some_and(|t| t.is(b'=')) => {
                let currents = self.currents.clone();
                let all = currents.into_iter().fold(TORQUE, |all, key| all | bit(&mut self.currents, CURRENTS, key));
                out.push(Event::Off(all));
            }
            ("$TORQUE_AXIS", Some(_)) => out.push(Event::On(TORQUE)),
            ("$CURR_RED", Some(share)) => {
                let key = key(text, line, 1, b"]");
                out.push(match share {
                    Some(100.0) => Event::Off(own_bit(&mut self.currents, CURRENTS, key)),
                    _ => Event::On(bit(&mut self.currents, CURRENTS, key)),
                });
            }
            _ => {}
        }
        if let Some(at) = called(text, line, "SET_TORQUE_LIMITS") {
            out.push(Event::On(bit(&mut self.limits, LIMITS, key(text, line, at + 1, b",)"))));
        } else if let Some(at) = called(text, line, "RESET_TORQUE_LIMITS") {
            out.push(Event::Off(own_bit(&mut self.limits, LIMITS, key(text, line, at + 1, b",)"))));
        }
        self.seam(text, k, line, &word, out);
    }

    /// A seam begins, goes on with other weld data, or ends.
    ///
    /// `seam = "ARCMAINNG" "(" "#" word ["," weld_data] ... | ("ARCON" | "ARC_ON" | "ARC_STRT" | "ARCSWI" | "ARC_SWI") ... weld_data ... |
    /// ("ARCOFF" | "ARC_OFF" | "ARCOF") ...`
    fn seam(&mut self, text: &Text, k: Option<usize>, line: &[Token], word: &str, out: &mut Vec<Event>) {
        match word {
            "ARCMAINNG" => {
                let Some(state) = arc_state(text, line) else { return };
                let on = ["ARCON", "ARCSWI"].iter().any(|begin| state.starts_with(begin));
                if on {
                    let on = self.bits(text, k, line.get(5..).unwrap_or_default());
                    out.push(match state.contains("AFTER") {
                        true => Event::Off(SEAM & !on),
                        false => Event::On(on),
                    });
                } else if state.starts_with("ARCOFFAFTER") {
                    out.push(Event::Off(SEAM));
                }
            }
            "ARC_ON" | "ARCON" | "ARC_STRT" | "ARC_SWI" | "ARCSWI" => {
                let names = |t: &Token| {
                    let name = upper(text, t);
                    t.kind == Kind::Word && (name.starts_with("WDAT") || self.weld_data.knows(text, &name))
                };
                if let Some(at) = line.iter().skip(1).position(names) {
                    let on = self.bits(text, k, &line[at + 1..]);
                    out.extend([Event::On(on), Event::Off(SEAM & !on)]);
                }
            }
            "ARC_OFF" | "ARCOFF" | "ARCOF" => out.push(Event::Off(SEAM)),
            _ => {}
        }
    }

    /// What holds on a seam with the weld data that stand first in `data`.
    fn bits(&mut self, text: &Text, k: Option<usize>, data: &[Token]) -> u32 {
        let end = data.iter().position(|t| t.is(b',') || t.is(b')')).unwrap_or(data.len());
        let name = match &data[..end] {
            [t] if t.kind == Kind::Word => upper(text, t),
            [] => "the weld data".into(),
            data => written(text, data),
        };
        let Seam { weaves, tracks, uncertain } = self.weld_data.seam(text, &name);
        if uncertain {
            self.uncertain.push((k, name.into()));
        }
        [(weaves, WEAVES), (tracks, TRACKS), (uncertain, WELD_DATA)].iter().filter(|b| b.0).fold(0, |all, b| all | b.1)
    }
}

/// `lead = "CONVEYOR" "." ("FOLLOW" | "SKIP" | "QUIT" | "OFF") ... | ... ("RSI_ON" | "RSI_OFF") "(" ... | "$JOINT_OFFSET" ... "=" ... |
/// "$TECH" ["[" number "]"] ["." "MODE"] "=" ...`
fn lead(text: &Text, line: &[Token], word: &str, out: &mut Vec<Event>) {
    let says = |name: &str| line.iter().any(|t| t.kind == Kind::Word && upper(text, t) == name);
    if says("RSI_ON") {
        return out.push(Event::On(SENSOR));
    }
    out.push(match word {
        "CONVEYOR" => match line.get(2).map(|t| upper(text, t)).as_deref() {
            Some("FOLLOW" | "SKIP") => Event::On(CONVEYOR),
            Some("QUIT" | "OFF") => Event::Off(CONVEYOR),
            _ => return,
        },
        "$JOINT_OFFSET" => Event::On(OFFSET),
        "$TECH" if says("OFF") => Event::Off(GENERATOR),
        // another part than the mode
        "$TECH" if line.iter().any(|t| t.is(b'.')) && !says("MODE") => return,
        "$TECH" => Event::On(GENERATOR),
        _ if says("RSI_OFF") => Event::Off(SENSOR),
        _ => return,
    });
}
