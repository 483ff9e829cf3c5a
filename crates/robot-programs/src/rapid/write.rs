//! Edits of a RAPID program as patches.
//!
//! A goal is written in place. A declared target that other moves or readers need with its old value gets a clone: a new
//! declaration after the old one, with its storage class and a fresh name, to which the move is turned. A new point is a copy of
//! the move's own statement in front of it, with an inline target, the same speed and tool, without `\Conc`, `\Inpos`.
//! Its zone: `z0` (0.3 mm), or a smaller one by `\Z:=` where its neighbours are nearer, or `fine` where a joint move itself
//! stops exactly; a straight TCP move is not stopped on its way. ABB controllers halve overlapping zones by themselves, so the move's own
//! zone stays.

use super::built::{Built, Owner, SharedSite, Site, Written};
use super::value;
use super::words::{self, Z0_MM};
use crate::axes::{JointKind, OF_ARM};
use crate::error::{Error, Result};
use crate::script::blocks::BySteps;
use crate::script::number::{self, Own};
use crate::script::sites::{EditRequest, Number, OneText, TargetEdit, in_place};
use crate::script::{CLONE, EditRef, Edits, Move, NewPoint, Patch, Patches, PathKind, Span, Text};
use std::collections::HashSet;
use std::ops::Range;

/// Finest radius that is written by `\Z:=`, mm; below it the point is `fine`.
const FINEST_ZONE_MM: f64 = 0.01;
/// RAPID's longest name.
const LONGEST_NAME: usize = 32;

pub struct Writer<'a> {
    pub built: &'a Built,
    pub kinds: &'a [JointKind],
    /// Numbers of the axes, from 1, where they are all of the arm's; `None`: others are beside them.
    pub numbers: Option<&'a [usize]>,
    /// Every word of the file in lower case.
    pub words: &'a HashSet<String>,
    pub edits: &'a Edits,
}

impl OneText for Writer<'_> {
    type Site = SharedSite;

    fn asked(&self) -> EditRequest<'_> {
        EditRequest { script: &self.built.script, edits: self.edits }
    }

    fn sites(&self) -> &BySteps<SharedSite> {
        &self.built.sites
    }

    fn each_number(&self, t: usize, q: &[f64], scratch: &mut Vec<u8>, each: &mut dyn FnMut(Range<usize>, &[u8])) {
        let Some(target) = self.built.script.targets.get(t) else { return };
        let Some(text) = self.built.script.texts.get(target.at.file) else { return };
        if target.pose.is_some() {
            for (k, v) in q.iter().enumerate() {
                let Some(own) = target.values.get(k) else { continue };
                if let Some(new) = target.pose_number_of_size(k, *v, self.edits, text, value::seventh) {
                    each(own.span(), new.as_bytes());
                }
            }
            return;
        }
        for (axis, ((value, &q), kind)) in target.values.iter().zip(q).zip(self.kinds).enumerate() {
            let Some(value) = value else { continue };
            let si = kind.si_per_user_unit();
            let finest = (value.finest / si).min(value::seventh(q / si));
            let own = Own { text: text.slice(value.span()), value: value.si / si, style: value.style };
            scratch.clear();
            if number::append_changed(scratch, own, q / si, self.digit(axis) / si, finest) {
                each(value.span(), scratch);
            }
        }
    }

    fn literal(&self, t: usize, numbers: &[Number]) -> Result<String> {
        // external axes come after those of the robot in the text, wherever they stand in the robot file
        let mut numbers: Vec<&Number> = numbers.iter().collect();
        numbers.sort_by_key(|(span, _)| span.start);
        let Some(literal) = self.built.literals.get(t) else { return Err(Error::Refused("no such target".into())) };
        if let Some(foreign) = &literal.foreign {
            let own = Text::new("", foreign.to_vec());
            let start = literal.bytes.start();
            let moved = numbers.into_iter().map(|(s, n)| (s.start - start..s.end - start, n));
            return in_utf8(flat(&own.substituted(0..foreign.len(), moved)));
        }
        in_utf8(flat(
            &self.text()?.substituted(literal.bytes.range(), numbers.into_iter().map(|(s, n)| (s.clone(), n))),
        ))
    }

    /// `[[..],[..]]` for a move whose own target is Cartesian.
    fn plain(&self, k: usize, site: &SharedSite, q: &[f64]) -> Result<String> {
        let external =
            site.model().external.as_ref().ok_or_else(|| self.refused(k, "its external axes are no plain numbers"))?;
        let Some(numbers) = self.numbers.filter(|n| n.len() == q.len()) else {
            return Err(self.refused(k, "Cartesian moves are written as joint moves for arms of six axes only"));
        };
        let style = number::Style { decimals: 4, point: true, ..number::Style::default() };
        let axes = q.iter().zip(self.kinds).enumerate().map(|(axis, (q, kind))| {
            let si = kind.si_per_user_unit();
            number::write(q / si, style, number::decimals_for(style, self.digit(axis) / si, 6))
        });
        let mut list: [String; OF_ARM] = std::array::from_fn(|_| "0".into());
        for (number, text) in numbers.iter().zip(axes) {
            if let Some(place) = list.get_mut(number - 1) {
                *place = text;
            }
        }
        Ok(format!("[[{}],{}]", list.join(","), in_utf8(flat(external.as_bytes()))?))
    }

    fn via(&self, site: &SharedSite) -> Option<Span> {
        let via = site.model().via?;
        site.shown().args.get(usize::from(via)).map(|via| via.bytes)
    }
}

impl Writer<'_> {
    pub fn patches(&self) -> Result<Patches> {
        let mut out = self.goals()?;
        for (k, edit) in self.edits.steps.iter() {
            let (m, site) = self.at(k)?;
            if edit.as_joint_moves {
                let q = self.asked().joints_for_pose(k, m, edit)?;
                let shown = site.shown();
                out.push(Patch::new(0, shown.word, "MoveAbsJ"));
                out.push(Patch::new(0, shown.args[usize::from(shown.goal)].bytes, self.plain(k, site, q)?));
            }
            self.points(k, m, site, edit, &mut out)?;
        }
        Ok(out)
    }

    /// Changed goals, by target: in place where all moves to it agree, else by clones.
    fn goals(&self) -> Result<Patches> {
        let text = self.text()?;
        let mut out = Patches::with_capacity(self.edits.steps.likely_patches());
        let mut fresh = HashSet::new();
        let owner = |t: usize| self.built.literals.get(t).and_then(|l| l.owner.as_deref());
        let mut scratch = Vec::new();
        let mut each = |wanted: TargetEdit| {
            if let Some(q) = wanted.alone {
                self.each_number(wanted.target, q, &mut scratch, &mut |span, new| out.put(0, span, new));
            }
            out.extend(in_place(wanted.in_place));
            for (numbers, steps) in wanted.clones {
                let Some(owner) = owner(wanted.target) else { continue };
                if self.built.literals.get(wanted.target).is_some_and(|l| l.foreign.is_some()) {
                    let values = self.literal(wanted.target, &numbers)?;
                    for k in steps {
                        let (_, site) = self.at(k)?;
                        out.push(Patch::new(0, site.shown().point, values.clone()));
                    }
                    continue;
                }
                let name = self.fresh(owner, &mut fresh);
                let declaration = format!("{} {name}:={};", owner.head, self.literal(wanted.target, &numbers)?);
                out.push(beside(text, &owner.bytes, &declaration));
                for k in steps {
                    let (_, site) = self.at(k)?;
                    out.push(Patch::new(0, site.shown().point, name.clone()));
                }
            }
            Ok(())
        };
        self.asked().wanted(&|t, q| self.numbers(t, q), &|t| Some(owner(t)?.keep), &mut each)?;
        Ok(out)
    }

    /// A name that nothing in the file has, nor any other module of the task gets.
    fn fresh(&self, owner: &Owner, taken: &mut HashSet<String>) -> String {
        let base = base_of(&owner.name, owner.shared);
        (1u32..)
            .map(|n| format!("{base}{CLONE}{n}"))
            .find(|name| {
                let lower = name.to_ascii_lowercase();
                !self.words.contains(&lower) && !words::is_reserved(&lower) && taken.insert(lower)
            })
            .unwrap_or_default()
    }

    /// Writes the new points of a move, and its share of a time.
    fn points(&self, k: usize, m: &Move, placed: &SharedSite, edit: EditRef, out: &mut Patches) -> Result<()> {
        if !self.has_new_points(k, m, placed, edit, out)? {
            return Ok(());
        }
        let site = &placed.shown();
        let text = self.text()?;
        let times = match &site.time {
            None => None,
            Some(time) => {
                // 1 ms: nothing shorter can be commanded
                let legs = EditRequest::legs(edit, time, &[1e-3], 4);
                let legs = legs.ok_or_else(|| self.refused(k, "its time \\T is too short to be shared out"))?;
                out.push(Patch::new(0, time.0.clone(), legs.last().cloned().unwrap_or_default()));
                Some(legs)
            }
        };
        let line = text.line_span(text.line_of(site.bytes.start()) as usize - 1);
        let before = text.slice(line.start..site.bytes.start());
        let first = before.iter().all(u8::is_ascii_whitespace);
        let mut bytes = Vec::new();
        for (n, point) in edit.before.iter().enumerate() {
            let target = self.target(k, m, placed, point, edit.as_joint_moves)?;
            let via = edit.piece(n).map(|at| self.on_arc(k, m, Some(&point.q), at)).transpose()?;
            let word = match edit.as_joint_moves {
                true => b"MoveAbsJ".to_vec(),
                false => flat(text.slice(site.word)),
            };
            let (time, targets) = (times.as_ref().and_then(|t| t.get(n)), (target.as_str(), via.as_deref()));
            bytes.extend(self.copy(&word, m, site, point, targets, time)?);
            if first {
                bytes.extend_from_slice(text.ending(site.bytes.start()));
                bytes.extend_from_slice(before);
            } else {
                bytes.push(b' ');
            }
        }
        out.push(Patch::new(0, site.bytes.start()..site.bytes.start(), bytes));
        Ok(())
    }

    /// The statement of a new point.
    fn copy(
        &self,
        word: &[u8],
        m: &Move,
        site: &Site,
        point: &NewPoint,
        (target, via): (&str, Option<&str>),
        time: Option<&String>,
    ) -> Result<Vec<u8>> {
        let text = self.text()?;
        let mut parts: Vec<Vec<u8>> = Vec::new();
        for (n, arg) in site.args.iter().enumerate() {
            let is = |place: Option<u16>| place.map(usize::from) == Some(n);
            let mut part = if let Some(via) = via.filter(|_| is(site.via)) {
                via.as_bytes().to_vec()
            } else if n == usize::from(site.goal) {
                // joint moves take no displacement
                let point = if word == b"MoveAbsJ" { arg.bytes } else { site.point }.range();
                flat(&text.substituted(arg.bytes.range(), [(point, target)]))
            } else if is(site.zone) {
                self.zone(m, point, flat(text.slice(arg.bytes)))
            } else {
                flat(text.slice(arg.bytes))
            };
            for (name, switch) in &arg.switches {
                let keep = match &**name {
                    "conc" | "inpos" | "z" => false,
                    "t" => {
                        if let Some(time) = time {
                            part.extend(format!("\\T:={time}").into_bytes());
                        }
                        false
                    }
                    _ => true,
                };
                if keep {
                    part.extend(flat(text.slice(*switch)));
                }
            }
            if !part.is_empty() {
                parts.push(part);
            }
        }
        let comma: &[u8] = if spaced(text, site) { b", " } else { b"," };
        Ok([word, b" ", &parts.join(comma), b";"].concat())
    }

    /// Zone of a new point.
    fn zone(&self, m: &Move, point: &NewPoint, own: Vec<u8>) -> Vec<u8> {
        let exact = m.blend_m == Some(0.0);
        if exact && m.path == PathKind::Joint {
            return own;
        }
        let room_mm = point.clearance_m.min(m.blend_m.filter(|_| !exact).unwrap_or(f64::INFINITY)) * 1e3;
        let taken = |name: &str| self.words.contains(&format!("{name} declared"));
        // rounded down, so that it fits
        let mm = (room_mm.min(Z0_MM) / FINEST_ZONE_MM + 1e-9).floor() * FINEST_ZONE_MM;
        if taken("z0") || mm.is_nan() || mm < FINEST_ZONE_MM {
            if exact { own } else { b"fine".to_vec() }
        } else if room_mm >= Z0_MM {
            b"z0".to_vec()
        } else {
            format!("z0\\Z:={mm:.2}").into_bytes()
        }
    }
}

/// What the names of clones of a target begin with. Modules are written one by one, and names that they share are unique in the task: where
/// the whole name of a target is not in the new one, a number made of the whole tells it from others that begin alike.
fn base_of(old: &str, shared: bool) -> String {
    const LONGEST: usize = LONGEST_NAME - 9;
    let mut base: String = old.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    base.truncate(LONGEST);
    let base = base.trim_end_matches('_');
    let base = if base.starts_with(|c: char| c.is_ascii_alphabetic()) { base } else { "j" };
    if !shared || base == old {
        return base.to_string();
    }
    // FNV-1a of 32 bits
    let mix = |sum: u32, byte: u8| (sum ^ u32::from(byte)).wrapping_mul(0x0100_0193);
    let sum = old.to_lowercase().bytes().fold(0x811c_9dc5, mix);
    let begin: String = base.chars().take(LONGEST - 9).collect();
    format!("{}_{sum:08x}", begin.trim_end_matches('_'))
}

/// Whether a statement has blanks after its commas.
fn spaced(text: &Text, site: &Site) -> bool {
    let end = |a: &Written| a.switches.iter().map(|s| s.1.end()).fold(a.bytes.end(), usize::max);
    let Some(first) = site.args.first() else { return false };
    let rest = text.slice(end(first)..site.bytes.end());
    let comma = rest.iter().position(|&b| b == b',');
    comma.and_then(|c| rest.get(c + 1)) == Some(&b' ')
}

/// A new declaration after an old one: on a separate line, after the old one's comment, or on the same line where more
/// code follows there.
fn beside(text: &Text, old: &Range<usize>, declaration: &str) -> Patch {
    let line = text.line_of(old.end.saturating_sub(1)) as usize - 1;
    let end = text.line_span(line).start + text.line(line).len();
    let rest = text.slice(old.end..end);
    let code = rest.iter().find(|b| !b.is_ascii_whitespace());
    if code.is_some_and(|&b| b != b'!') {
        return Patch::new(0, old.end..old.end, format!(" {declaration}"));
    }
    let start = text.line_span(text.line_of(old.start) as usize - 1).start;
    let lead = text.slice(start..old.start);
    let indent: &[u8] = if lead.iter().all(u8::is_ascii_whitespace) { lead } else { b"" };
    let mut bytes = text.ending(old.start).to_vec();
    bytes.extend_from_slice(indent);
    bytes.extend_from_slice(declaration.as_bytes());
    let at = end.max(old.end);
    Patch::new(0, at..at, bytes)
}

/// The text of a target, which stands as text among new bytes.
fn in_utf8(target: Vec<u8>) -> Result<String> {
    String::from_utf8(target)
        .map_err(|_| Error::Refused("a target with a name that is no UTF-8 cannot be copied".into()))
}

/// Text on one line: line breaks and comments become blanks.
fn flat(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    let mut quoted = false;
    while let Some(&b) = bytes.get(i) {
        quoted ^= b == b'"';
        match b {
            b'!' if !quoted => {
                i += bytes[i..].iter().take_while(|&&b| b != b'\n').count();
                continue;
            }
            b'\r' | b'\n' | b'\t' => {
                if out.last() != Some(&b' ') {
                    out.push(b' ');
                }
            }
            b' ' if out.last() == Some(&b' ') => {}
            _ => out.push(b),
        }
        i += 1;
    }
    out.trim_ascii().to_vec()
}
