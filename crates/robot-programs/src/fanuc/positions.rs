//! `/POS`: the positions `P[n]` with their groups.
//!
//! Group 1 is the robot. Its entry is either joints (`J1=    35.130 deg`, then `E1=` of extended axes) or Cartesian
//! (`X =`, `Y =`, `Z =` in mm, `W =`, `P =`, `R =` in degrees: turns about fixed X, Y, Z in this order). What is not the
//! robot's own (further groups, further axes) is compared byte by byte, never changed.

use super::reason::Reason;
use super::statement::{is_position, shown};
use crate::axes::{Axes, JointKind, OF_ARM, Places};
use crate::error::Result;
use crate::script::cursor::{Cursor, integer, strip_word};
use crate::script::lex::upper_of;
use crate::script::pose::{Configuration, Frame, OfAxis, PoseGoal, Solution};
use crate::script::{Span, Text, number};
use nalgebra::{UnitQuaternion, Vector3};
use std::borrow::Cow;
use std::ops::Range;

/// A number field of a position. Small, as a program has one for each of its numbers.
#[derive(Debug, Clone)]
pub(super) struct Field {
    /// From after the `=` to the end of the number.
    pub field: Span,
    pub number: Span,
    /// deg or mm; 0 where it is not taught.
    own: f64,
    style: number::Style,
    /// A number stands there, not `********`.
    taught: bool,
    /// mm, not deg.
    pub mm: bool,
    /// Place of its name in [`USUAL`]; beyond: another one.
    usual: u8,
    // one word instead of three, and nearly always none
    #[allow(clippy::box_collection)]
    unusual: Option<Box<String>>,
}

impl Field {
    /// `J1`, `E2`, `X`, in upper case.
    pub fn name(&self) -> &str {
        match &self.unusual {
            Some(name) => name,
            None => USUAL.get(usize::from(self.usual)).copied().unwrap_or_default(),
        }
    }

    /// Value, deg or mm, and style; `None`: `********`, not taught.
    pub fn value(&self) -> Option<(f64, number::Style)> {
        self.taught.then_some((self.own, self.style))
    }

    /// It has the name of an axis: `J1`, `E2`.
    fn is_axis(&self, letter: u8, number: usize) -> bool {
        match self.name().as_bytes() {
            [first, digit] => {
                *first == letter && (1..10).contains(&number) && usize::from(digit.wrapping_sub(b'0')) == number
            }
            [first, digits @ ..] => *first == letter && *digits == *number.to_string().as_bytes(),
            [] => false,
        }
    }
}

/// A position.
#[derive(Debug, Clone, Default)]
pub(super) struct Position {
    pub index: u64,
    pub line: u64,
    /// The whole entry with its last line ending.
    pub span: Range<usize>,
    /// From after `P[` to the `{`.
    pub head: Range<usize>,
    /// Numbers of group 1.
    pub fields: Vec<Field>,
    /// User frame and tool of group 1.
    pub frame: Option<u64>,
    pub tool: Option<u64>,
    /// Which joints of those that reach a Cartesian position are meant.
    pub configuration: Option<Configuration>,
    /// Group 1 is there.
    pub ours: bool,
    /// Numbers of the other groups, for comparison.
    pub others: Vec<u8>,
}

impl Position {
    /// Whether group 1 holds joints.
    pub fn is_joints(&self) -> bool {
        self.fields.iter().any(|f| is_joint(f.name()))
    }

    /// Whether a number of group 1 is missing.
    pub fn untaught(&self) -> bool {
        self.fields.iter().any(|f| !f.taught)
    }

    /// Joint fields in the order of the axes: J1, J2, ..., then E1, ...
    pub fn axes(&self) -> Vec<&Field> {
        let mut out: Vec<&Field> = self.fields.iter().filter(|f| is_joint(f.name()) || is_extended(f.name())).collect();
        out.sort_by_key(|f| (is_extended(f.name()), f.name().get(1..).and_then(|d| d.parse::<u32>().ok())));
        out
    }

    /// How many joints of the arm it gives: `J1` to `J6`.
    pub fn arm_fields(&self) -> usize {
        (1..=OF_ARM).filter(|n| self.fields.iter().any(|f| f.is_axis(b'J', *n))).count()
    }

    /// The field of each axis of the robot: `J1`, ... of its arm by their numbers, `E1`, ... (older: `J7`, ...) of its external axes; the
    /// name of the first that is missing.
    ///
    /// `axis = ("J" | "E") number`
    ///
    /// # Errors
    /// One is missing.
    pub fn fields_of(&self, places: &Places) -> std::result::Result<Vec<&Field>, String> {
        let of = |letter: u8, number: usize| {
            // nearly always they stand in this order
            let likely = number.checked_sub(1).and_then(|k| self.fields.get(k)).filter(|f| f.is_axis(letter, number));
            likely.or_else(|| self.fields.iter().find(|f| f.is_axis(letter, number)))
        };
        let missing = |letter: u8, number: usize| format!("{}{number}", char::from(letter));
        let field = |axis: usize| match places.number(axis) {
            Some(number) => of(b'J', number).ok_or_else(|| missing(b'J', number)),
            None => {
                let number = places.external.iter().find(|e| e.1 == axis).map_or(0, |e| e.0);
                of(b'E', number).or_else(|| of(b'J', 6 + number)).ok_or_else(|| missing(b'E', number))
            }
        };
        (0..places.arm.len() + places.external.len()).map(field).collect()
    }

    /// Fields of the robot's external axes beside a Cartesian position, with their axes.
    pub fn placed(&self, robot: &Axes) -> Vec<(usize, &Field)> {
        let places = robot.places();
        let of = |&(number, axis): &(usize, usize)| {
            let field = self.fields.iter().find(|f| f.is_axis(b'E', number));
            let mm = robot.axis(axis).kind == JointKind::Prismatic;
            field.filter(|f| f.mm == mm).map(|f| (axis, f))
        };
        let found = places.external.iter().filter_map(of).collect();
        if places.certain { found } else { Vec::new() }
    }

    /// Fields of a Cartesian position: X, Y, Z, W, P, R; `None`: one is missing, not taught, or in another unit.
    pub fn coordinates(&self) -> Option<[&Field; 6]> {
        let of = |name: &str| {
            let field = self.fields.iter().find(|f| f.name() == name)?;
            let mm = matches!(name, "X" | "Y" | "Z");
            (field.mm == mm && field.taught).then_some(field)
        };
        Some([of("X")?, of("Y")?, of("Z")?, of("W")?, of("P")?, of("R")?])
    }

    /// The Cartesian target, whose numbers are those of target `target`.
    pub fn pose(&self, target: usize, robot: &Axes) -> Option<PoseGoal> {
        let values = self.coordinates()?.map(|f| f.value().map_or(0.0, |v| v.0));
        let [w, p, r] = [values[3], values[4], values[5]].map(f64::to_radians);
        let placed = self.placed(robot);
        let foreign = |f: &&Field| is_extended(f.name()) && placed.iter().all(|p| p.1.name() != f.name());
        let extended = || self.fields.iter().filter(foreign);
        let carried: Option<Vec<(String, f64)>> = extended()
            .map(|f| f.value().map(|v| (f.name().to_string(), v.0)))
            .filter(|v| v.as_ref().is_none_or(|v| v.1 != 0.0))
            .collect();
        let frame = match carried {
            None => Frame::unclear(Reason::CarrierNotTaught),
            Some(axes) => named(self.frame, "user frame").carried("0", &axes),
        };
        let solution = self.configuration.map_or(Solution::Same, Solution::Configured);
        let of_axis = |&(axis, field): &(usize, &Field)| {
            let si = robot.axis(axis).kind.si_per_user_unit();
            Some(OfAxis { axis, si: field.value()?.0 * si })
        };
        let external: Box<[OfAxis]> = placed.iter().map(of_axis).collect::<Option<_>>()?;
        Some(PoseGoal {
            target: Some(target),
            position_m: Vector3::new(values[0], values[1], values[2]) * 1e-3,
            rotation: Some(UnitQuaternion::from_euler_angles(w, p, r)),
            frame,
            tool: named(self.tool, "tool"),
            solution,
            binding: true,
            external: Some(external).filter(|all| !all.is_empty()),
            ..PoseGoal::default()
        })
    }
}

/// `N U T, 0, 0, 0`; `None`: not of this kind.
///
/// `configuration = letter {gap} letter {gap} letter gap turn gap turn gap turn`, `gap = {"," | blank}`
pub(super) fn configuration(text: &[u8]) -> Option<Configuration> {
    let text = String::from_utf8_lossy(text).to_ascii_uppercase();
    let mut letters = Vec::new();
    let mut turns = Vec::new();
    for word in text.split([',', ' ', '\t']).filter(|w| !w.is_empty()) {
        match word.parse::<i32>() {
            Ok(n) => turns.push(n),
            Err(_) if turns.is_empty() => letters.extend(word.chars()),
            Err(_) => return None,
        }
    }
    let turns: [i32; 3] = turns.try_into().ok().filter(|t: &[i32; 3]| t.iter().all(|n| n.abs() < 8))?;
    let one_of = |yes: char, no: char| match (letters.contains(&yes), letters.contains(&no)) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    };
    (letters.len() == 3).then_some(())?;
    Some(Configuration::Fanuc { flip: one_of('F', 'N')?, up: one_of('U', 'D')?, front: one_of('T', 'B')?, turns })
}

/// User frame or tool by its number; 0 is the world, or the flange.
pub(super) fn named(number: Option<u64>, what: &'static str) -> Frame {
    match number {
        Some(0) => Frame::Null,
        Some(n) => Frame::Named(n.to_string()),
        None => Frame::unclear(Reason::Selected(what)),
    }
}

pub(super) fn is_joint(name: &str) -> bool {
    name.strip_prefix('J').is_some_and(|d| !d.is_empty() && d.bytes().all(|b| b.is_ascii_digit()))
}

pub(super) fn is_extended(name: &str) -> bool {
    name.strip_prefix('E').is_some_and(|d| !d.is_empty() && d.bytes().all(|b| b.is_ascii_digit()))
}

/// The positions on lines `lines`.
///
/// `positions = {head {group} "}" ...}`,
/// `group = "GP" number ":" {line}`
pub(super) fn read(text: &Text, lines: Range<usize>) -> Result<Vec<Position>> {
    let mut out: Vec<Position> = Vec::new();
    let mut open: Option<Position> = None;
    let mut group = 0_u64;
    for k in lines {
        let span = text.line_span(k);
        let bytes = text.line(k);
        let content = bytes.trim_ascii();
        if content.is_empty() {
            continue;
        }
        let at = span.start + (bytes.len() - bytes.trim_ascii_start().len());
        let Some(position) = &mut open else {
            open = Some(head(text, k, at, content)?);
            group = 0;
            continue;
        };
        if content.starts_with(b"}") {
            position.span.end = span.end;
            out.extend(open.take());
        } else if is_position(content) && content.ends_with(b"{") {
            return Err(text.bad(at, "a position within a position", "`};` at the end of a position"));
        } else if let Some(number) = group_of(content) {
            group = number;
            if group == 1 {
                if position.ours {
                    return Err(text.bad(at, "a second group 1", "one group 1 in a position"));
                }
                position.ours = true;
            }
        } else if group == 1 {
            line(text, span.start..span.start + bytes.len(), position)?;
        } else {
            position.others.extend_from_slice(content);
            position.others.push(b'\n');
        }
    }
    if let Some(p) = open {
        return Err(text.bad(p.span.start, "a position without an end", "`};` at the end of a position"));
    }
    Ok(out)
}

/// `P[3:"comment"]{`.
///
/// `head = "P[" number [":" name] "]" "{"`
fn head(text: &Text, k: usize, at: usize, content: &[u8]) -> Result<Position> {
    let bad = || text.bad(at, format!("`{}`", shown(content)), "a position such as `P[1]{`");
    let inside = strip_word(content, b"P[").and_then(|c| c.strip_suffix(b"{")).ok_or_else(bad)?;
    let mut cursor = Cursor::new(inside);
    let index: u32 = integer(cursor.digits()).ok_or_else(bad)?;
    if !matches!(cursor.peek(), Some(b']' | b':')) {
        return Err(bad());
    }
    Ok(Position {
        index: u64::from(index),
        line: k as u64 + 1,
        span: text.line_span(k),
        head: at + 2..at + 2 + inside.len(),
        ..Position::default()
    })
}

/// `GP1:`.
///
/// `group = "GP" number ":"`
fn group_of(content: &[u8]) -> Option<u64> {
    let rest = strip_word(content, b"GP")?;
    std::str::from_utf8(rest.strip_suffix(b":")?.trim_ascii()).ok()?.parse().ok()
}

/// The fields of one line of group 1: `UF : 0`, `CONFIG : '...'`, `J1=    35.130 deg`.
///
/// `line = {"UF" ":" number | "UT" ":" number | "'" configuration "'" | field | ","}`
fn line(text: &Text, span: Range<usize>, position: &mut Position) -> Result<()> {
    let mut cursor = Cursor::new(text.slice(span.clone()));
    while let Some(b) = cursor.peek() {
        if !b.is_ascii_alphabetic() {
            cursor.skip(1);
            if b == b'\'' {
                position.configuration = configuration(cursor.while_is(|b| b != b'\''));
                cursor.skip(1);
            }
            continue;
        }
        let name = upper_of(cursor.while_is(|b| b.is_ascii_alphanumeric()));
        cursor.blanks();
        if cursor.eat(b':') {
            let value = integer(Cursor::new(cursor.rest().trim_ascii_start()).digits());
            match &*name {
                "UF" => position.frame = value,
                "UT" => position.tool = value,
                _ => {}
            }
        } else if cursor.eat(b'=') {
            field(text, &span, &mut cursor, name, position)?;
        }
    }
    Ok(())
}

const USUAL: &[&str] = &["J1", "J2", "J3", "J4", "J5", "J6", "X", "Y", "Z", "W", "P", "R", "E1", "E2", "E3"];

/// No group has as many numbers.
const MOST: usize = 64;

/// A number and its unit after `name=`.
///
/// `field = name "=" (number ("mm" | "deg") | "*" {"*"} [unit])`
fn field(text: &Text, span: &Range<usize>, cursor: &mut Cursor, name: Cow<str>, position: &mut Position) -> Result<()> {
    let from = cursor.at();
    cursor.blanks();
    let start = cursor.at();
    let token = cursor.while_is(|b| !b.is_ascii_whitespace() && b != b',');
    let bad = |found: &[u8], expected: &str| text.bad(span.start + start, format!("`{}`", shown(found)), expected);
    let value = if !token.is_empty() && token.iter().all(|b| *b == b'*') {
        None
    } else {
        Some(number::read(token).ok_or_else(|| bad(token, "a number, or `********` where nothing is taught"))?)
    };
    let after = cursor.at();
    cursor.blanks();
    let gap = cursor.at();
    let unit = cursor.letters();
    let mm = unit.eq_ignore_ascii_case(b"mm");
    if !mm && !unit.eq_ignore_ascii_case(b"deg") {
        if value.is_some() {
            return Err(bad(cursor.since(start), "a number with its unit, `deg` or `mm`"));
        }
        cursor.go_to(gap);
    }
    if position.fields.len() >= MOST {
        return Err(bad(token, "fewer numbers in a group"));
    }
    if position.fields.iter().any(|f| f.name() == name) {
        return Err(bad(token, "each axis once"));
    }
    // the names that nearly all fields have take no memory
    let usual = USUAL.iter().position(|usual| *usual == name);
    let unusual = if usual.is_none() { Some(Box::new(name.into_owned())) } else { None };
    let (own, style) = value.unwrap_or_default();
    if position.fields.is_empty() {
        // most robots have as many axes, and a pose as many numbers
        position.fields.reserve_exact(6);
    }
    position.fields.push(Field {
        field: (span.start + from..span.start + after).into(),
        number: (span.start + start..span.start + after).into(),
        own,
        style,
        taught: value.is_some(),
        mm,
        usual: usual.map_or(u8::MAX, |usual| usual as u8),
        unusual,
    });
    Ok(())
}
