//! Speeds, approximation and frames as a program sets them: known while the text is certain to be what ran last.

use super::data::Data;
use super::frame::{self, Known, number, numbered_field, written};
use super::going::Turning;
use super::lex::{Kind, Token, in_upper, upper};
use super::lists::{BASES, LISTS, Lists, TOOLS, as_set};
use super::motion;
use super::reason::{MovesBase, Reason};
use crate::script::Text;
use crate::script::cursor::integer;
use crate::script::lex::outside;
use crate::script::pose::Frame;

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
    /// What it sets before in the lists of the controller.
    pub lists: Lists,
    /// Base and tool of `FDAT_ACT`, which `BAS` puts into force with the parameters of a motion, as the lists are then.
    pub frame_data: Option<FrameData>,
    /// What makes any base mean something else: `$IPO_MODE`, `$WORLD`.
    pub carried: Option<MovesBase>,
    pub moved: Option<MovesBase>,
    /// How the tool turns on the way, by `$ORI_TYPE`; by `LDAT_ACT`, which `BAS` puts into force; the latter is set and not in force yet.
    pub turning: Turning,
    pub motion_data: Option<Turning>,
    pub pending: bool,
}

/// What frame data name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FrameData {
    base: Frame,
    /// Of the base, where that is known.
    number: Option<u32>,
    tool: Frame,
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
}

impl Settings {
    /// What a value makes `$BASE` or `$TOOL`.
    fn of_list(&self, list: usize, text: &Text, value: &[Token], part: Option<&str>, known: Known) -> Frame {
        self.lists.of(list, frame::frame(text, value, part, LISTS[list], known))
    }

    /// The frame of a number in a list.
    fn numbered(&self, list: usize, text: &Text, value: &[Token]) -> Frame {
        self.lists.of(list, frame::numbered(text, value, LISTS[list]))
    }

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
            ("$VEL_AXIS", _) => self.axis_speed(text, line.get(2).filter(|_| sign == 4), number),
            ("$BASE", part) => self.base = Some(self.of_list(BASES, text, value, part, known)),
            ("$TOOL", part) => self.tool = Some(self.of_list(TOOLS, text, value, part, known)),
            // #BASE: the robot carries the tool
            ("$IPO_MODE", None) if value.get(1).is_some_and(|t| upper(text, t) == "BASE") => self.carried = None,
            ("$IPO_MODE", _) => self.carried = Some(MovesBase::IpoMode),
            ("$WORLD" | "$ROBROOT", _) => self.moved = Some(MovesBase::of_world(word)),
            ("FDAT_ACT", None) => self.motion_frames(text, value, data),
            ("FDAT_ACT", Some("TOOL_NO")) => {
                let tool = frame::numbered(text, value, LISTS[TOOLS]);
                if let Some(of_data) = &mut self.frame_data {
                    of_data.tool.clone_from(&tool);
                }
                self.tool = Some(self.lists.of(TOOLS, tool));
            }
            ("FDAT_ACT", Some("BASE_NO")) => {
                let base = frame::numbered(text, value, LISTS[BASES]);
                let number = number.filter(|n| *n > 0.0 && n.fract() == 0.0).map(|n| n as u32);
                if let Some(of_data) = &mut self.frame_data {
                    of_data.base.clone_from(&base);
                    of_data.number = number;
                }
                self.base = Some(self.of_data(base, number, data));
            }
            ("FDAT_ACT", Some(_)) => {}
            // BASE_DATA[2]={X 0,...}
            ("BASE_DATA" | "TOOL_DATA", None) => {
                // the index alone, or a part of the frame at it: BASE_DATA[2].X=100
                let plain = line.get(3).is_some_and(|t| t.is(b']'));
                let number = line.get(2).filter(|_| plain).and_then(|t| frame::number(text, std::slice::from_ref(t)));
                self.lists.set(usize::from(word == LISTS[TOOLS]), number, |n| match sign {
                    4 => frame::frame(text, value, None, word, known),
                    _ => as_set(format_args!("{n:.0}")),
                });
            }
            _ => {}
        }
    }

    /// An assignment to `$VEL_AXIS`.
    fn axis_speed(&mut self, text: &Text, index: Option<&Token>, share: Option<f64>) {
        self.vel_ptp = None;
        match index.and_then(|t| integer::<usize>(text.slice(t.span()))) {
            Some(i) => {
                if let Some(v) = i.checked_sub(1).and_then(|i| self.vel_axes.get_mut(i)) {
                    *v = share;
                }
            }
            // a loop over the axes
            None => self.vel_axes = [share; 6],
        }
    }

    /// An assignment to `FDAT_ACT`: the frame data of an inline form, which come into force with its BAS.
    ///
    /// `value = "{" ... "TOOL_NO" number "," "BASE_NO" number ... "}" | name`
    fn motion_frames(&mut self, text: &Text, value: &[Token], data: &Data) {
        let name = value.first().map(|t| upper(text, t)).unwrap_or_default();
        // {TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}, or a name that is declared so
        let numbers = match value.first() {
            Some(t) if t.is(b'{') => ["TOOL_NO", "BASE_NO"].map(|field| numbered_field(text, value, field)),
            _ => data.numbers.get(&name).copied().unwrap_or_default(),
        };
        let of = |number: Option<u32>, what: &str| match number {
            Some(0) => Frame::Null,
            Some(n) => Frame::Named(n.to_string()),
            None => Frame::Computed(format!("{what} of {name}")),
        };
        let of_data = FrameData { base: of(numbers[1], "base"), number: numbers[1], tool: of(numbers[0], "tool") };
        self.in_force(&of_data, data);
        (self.frame_data, self.carried) = (Some(of_data), None);
    }

    /// Frame data come into force, as the lists are now.
    fn in_force(&mut self, of_data: &FrameData, data: &Data) {
        self.base = Some(self.of_data(of_data.base.clone(), of_data.number, data));
        self.tool = Some(self.lists.of(TOOLS, of_data.tool.clone()));
    }

    /// The base that frame data name.
    fn of_data(&self, base: Frame, number: Option<u32>, data: &Data) -> Frame {
        let base = self.lists.of(BASES, base);
        match number {
            Some(n) => data.carried.in_force(n, base),
            None => base,
        }
    }

    /// `BAS(#PTP_PARAMS,100)`: settings, no motion.
    ///
    /// `bas = "BAS" "(" "#" command ["," argument] ")"`
    pub fn bas(&mut self, text: &Text, line: &[Token], data: &Data) {
        let command = line.get(3).map(|t| upper(text, t)).unwrap_or_default();
        let argument = line.get(5..).and_then(|v| v.get(..v.len().saturating_sub(1))).unwrap_or_default();
        let value = number(text, argument);
        match command.as_str() {
            "PTP_PARAMS" | "VEL_PTP" => {
                self.vel_ptp = value;
                self.vel_axes = [None; 6];
            }
            "CP_PARAMS" | "VEL_CP" => self.vel_cp = value,
            "BASE" => self.base = Some(self.numbered(BASES, text, argument)),
            "TOOL" => self.tool = Some(self.numbered(TOOLS, text, argument)),
            // the base on the flange of an external axis: it moves with that
            "EX_BASE" => self.base = Some(Frame::Computed(format!("EX_BASE {}", written(text, argument)))),
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
            match self.frame_data.clone() {
                Some(of_data) => self.in_force(&of_data, data),
                None => {
                    let of_data = |what: &str| Some(Frame::Computed(format!("{what} of FDAT_ACT")));
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
    let Some(at) = with_at(text, line) else { return [None, None] };
    let known = &|name: &str| data.frame(routine, name);
    let of = |word: &'static str, list: usize| {
        let place = frame_at(text, line, at, word)?;
        let Some((sign, value)) = value_after(text, line, place) else {
            return Some(Frame::unclear(Reason::With(word)));
        };
        let part = (sign > place + 1).then_some("a part");
        let function = value.first().map(|t| upper(text, t)).unwrap_or_default();
        let frame_data = value.get(2).map(|t| upper(text, t)).filter(|_| value.get(1).is_some_and(|t| t.is(b'(')));
        let number = match function.as_str() {
            "STOOL2" | "STOOL" | "SBASE" => frame_data.and_then(|name| data.numbers.get(&name).copied()?[1 - list]),
            _ => None,
        };
        let frame = match number {
            Some(0) => Frame::Null,
            Some(n) => Frame::Named(n.to_string()),
            None => frame::frame(text, value, part, LISTS[list], known),
        };
        Some(set.lists.of(list, frame))
    };
    [of("$BASE", BASES), of("$TOOL", TOOLS)]
}

/// The token of `WITH`.
fn with_at(text: &Text, line: &[Token]) -> Option<usize> {
    line.iter().position(|t| t.kind == Kind::Word && in_upper(text, t) == "WITH")
}

/// The token of a variable that `WITH`, at token `at`, sets.
fn frame_at(text: &Text, line: &[Token], at: usize, word: &str) -> Option<usize> {
    let is = |t: &Token| t.kind == Kind::Word && in_upper(text, t) == word;
    line.iter().skip(at).position(is).map(|k| at + k)
}

/// The sign after token `place`, and the value.
///
/// `setting = variable [part] "=" value ("," | "C_..." | end)`
fn value_after<'a>(text: &Text, line: &'a [Token], place: usize) -> Option<(usize, &'a [Token])> {
    let sign = (place + 1..line.len()).find(|&k| line[k].is(b'='))?;
    let approximates = |k: usize| k > sign + 1 && line[k].kind == Kind::Word && upper(text, &line[k]).starts_with("C_");
    let ends = |k: &usize| line[*k].is(b',') || approximates(*k);
    let end = outside(sign + 1..line.len(), |k| line[k].mark()).find(ends).unwrap_or(line.len());
    Some((sign, &line[sign + 1..end]))
}

/// The values that a motion or a spline block gives `$BASE` and `$TOOL` for itself.
///
/// `with = ... "WITH" ... ("$BASE" | "$TOOL") [part] "=" value ...`
pub(super) fn values_with<'a>(text: &Text, line: &'a [Token]) -> [Option<&'a [Token]>; 2] {
    let Some(at) = with_at(text, line) else { return [None, None] };
    ["$BASE", "$TOOL"].map(|word| value_after(text, line, frame_at(text, line, at, word)?).map(|value| value.1))
}

/// Whether a line begins a motion or a spline block, which may set frames for itself.
pub(super) fn may_have_with(word: &str) -> bool {
    motion::word(word).is_some() || matches!(word, "SPLINE" | "PTP_SPLINE")
}

/// Whether an assignment to this variable holds for the motions after it: it sets speeds, approximation, frames, or how the tool turns.
pub(super) fn is_setting(word: &str) -> bool {
    const OTHERS: [&str; 5] = ["FDAT_ACT", "LDAT_ACT", "PDAT_ACT", "BASE_DATA", "TOOL_DATA"];
    const STARTS: [&str; 8] = ["$VEL", "$APO", "$BASE", "$TOOL", "$IPO_MODE", "$WORLD", "$ROBROOT", "$ORI_TYPE"];
    OTHERS.contains(&word) || STARTS.iter().any(|start| word.starts_with(start))
}
