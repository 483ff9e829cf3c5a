//! Edits of a URScript as patches.
//!
//! A goal is written in place. A list variable that other moves or readers need with its old value gets a clone: a new
//! assignment after the old one, with its qualifier and a fresh name, to which the move is turned. A new point is a copy of the
//! move's own call in front of it, with a list instead of its target, and its share of `t=`. Blends must not overlap on this
//! controller: the copy's `r=` is at most the space that it has, the move's own is shrunk where it is asked for.

use super::moves::CYCLE_S;
use super::steps::{Built, Site};
use super::words;
use crate::decimal::Decimal;
use crate::error::{Error, Result};
use crate::script::blocks::BySteps;
use crate::script::number::{self, Own};
use crate::script::sites::{EditRequest, Number, OneText, TargetEdit, in_place};
use crate::script::{EditRef, Edits, Move, NewPoint, Patch, Patches, PathKind, Span};
use std::collections::HashSet;
use std::ops::Range;

/// Largest blend of a new point, m: it must not cut what the point is there for.
const BLEND_M: f64 = 1e-3;
/// Blends are rounded down to this, m, which is the last of so many decimals.
const BLEND_STEP_M: f64 = 1e-5;
const BLEND_DECIMALS: u8 = 5;
/// Cycle of the e-Series, s.
const SHORT_CYCLE_S: f64 = 0.002;

pub struct Writer<'a> {
    pub built: &'a Built,
    /// Numbers of the axes in a list, from 1, where it has no others; `None`: others are beside them.
    pub numbers: Option<&'a [usize]>,
    /// Every word of the file.
    pub words: &'a HashSet<String>,
    pub edits: &'a Edits,
}

impl OneText for Writer<'_> {
    type Site = Site;

    fn asked(&self) -> EditRequest<'_> {
        EditRequest { script: &self.built.script, edits: self.edits }
    }

    fn sites(&self) -> &BySteps<Site> {
        &self.built.sites
    }

    fn each_number(&self, t: usize, q: &[f64], room: &mut Vec<u8>, each: &mut dyn FnMut(Range<usize>, &[u8])) {
        let (Some(target), Some(literal)) = (self.built.script.targets.get(t), self.built.literals.get(t)) else {
            return;
        };
        let Some(text) = self.built.script.texts.get(target.at.file) else { return };
        // the list of a computed target is put together anew: its numbers have no bytes of their own
        let place = |k: usize, own: Range<usize>| match &literal.folded {
            Some(folded) => folded.places.get(k).map_or(own, |at| *at..at + 1),
            None => own,
        };
        if target.pose.is_some() {
            for (k, v) in q.iter().enumerate() {
                let Some(own) = target.values.get(k) else { continue };
                if let Some(new) = target.pose_number(k, *v, self.edits, text) {
                    each(place(k, own.span()), new.as_bytes());
                }
            }
            return;
        }
        for (axis, ((value, unit), q)) in target.values.iter().zip(literal.units.iter()).zip(q).enumerate() {
            let Some(value) = value else { continue };
            let (digit, finest) = (self.digit(axis) / unit, value.finest / unit);
            let own = Own { text: text.slice(value.span()), value: value.si / unit, style: value.style };
            room.clear();
            if number::append_changed(room, own, q / unit, digit, finest) {
                each(place(axis, value.span()), room);
            }
        }
    }

    fn literal(&self, t: usize, numbers: &[Number]) -> Result<String> {
        let Some(literal) = self.built.literals.get(t) else { return Err(Error::Refused("no such target".into())) };
        if let Some(folded) = &literal.folded {
            return Ok(folded.with(numbers));
        }
        // the joints of the robot file may stand in another order
        let mut numbers: Vec<&Number> = numbers.iter().collect();
        numbers.sort_by_key(|(span, _)| span.start);
        let list =
            flat(self.text()?.substituted(literal.bytes.range(), numbers.into_iter().map(|(s, n)| (s.clone(), n))));
        String::from_utf8(list).map_err(|_| Error::Refused("a list that is no UTF-8 cannot be copied".into()))
    }

    /// `[..]` for a move whose own target is a pose.
    fn plain(&self, k: usize, _: &Site, q: &[f64]) -> Result<String> {
        let Some(numbers) = self.numbers.filter(|n| n.len() == q.len()) else {
            return Err(self.refused(k, "Cartesian moves are written as joint moves for arms of six axes only"));
        };
        let style = number::Style { decimals: 6, point: true, ..number::Style::default() };
        let axis =
            |(axis, q): (usize, &f64)| number::write(*q, style, number::decimals_for(style, self.digit(axis), 9));
        let mut list = vec![String::new(); q.len()];
        for (number, text) in numbers.iter().zip(q.iter().enumerate().map(axis)) {
            if let Some(place) = list.get_mut(number - 1) {
                *place = text;
            }
        }
        Ok(format!("[{}]", list.join(", ")))
    }

    fn via(&self, site: &Site) -> Option<Span> {
        site.via
    }
}

impl Writer<'_> {
    pub fn patches(&self) -> Result<Patches> {
        let mut out = self.goals()?;
        for (k, edit) in self.edits.steps.iter() {
            let (m, site) = self.at(k)?;
            if edit.as_joint_moves {
                // `movel` and `movep` take joint values too: path, speed and acceleration stay
                let q = self.asked().joints_for_pose(k, m, edit)?;
                out.push(Patch::new(0, site.goal, self.plain(k, site, q)?));
            }
            self.points(k, m, site, edit, &mut out)?;
            self.blend(k, m, site, edit, &mut out)?;
        }
        Ok(out)
    }

    /// Changed goals, by target: in place where all moves to it agree, else by clones.
    fn goals(&self) -> Result<Patches> {
        let text = self.text()?;
        let mut out = Patches::with_capacity(self.edits.steps.likely_patches());
        let mut fresh = HashSet::new();
        let owner = |t: usize| self.built.literals.get(t).and_then(|l| l.owner.as_deref());
        let folded = |t: usize| self.built.literals.get(t).is_some_and(|l| l.folded.is_some());
        let keeps = |t: usize| if folded(t) { Some(true) } else { Some(owner(t)?.keep) };
        let mut room = Vec::new();
        let mut each = |wanted: TargetEdit| {
            if let Some(q) = wanted.alone {
                self.each_number(wanted.target, q, &mut room, &mut |span, new| out.put(0, span, new));
            }
            out.extend(in_place(wanted.in_place));
            for (numbers, steps) in wanted.clones {
                if folded(wanted.target) {
                    let list = self.literal(wanted.target, &numbers)?;
                    for k in steps {
                        out.push(Patch::new(0, self.at(k)?.1.point, list.clone()));
                    }
                    continue;
                }
                let Some(owner) = owner(wanted.target) else { continue };
                let name = self.fresh(&owner.name, &mut fresh);
                let line = text.line_span(text.line_of(owner.bytes.start) as usize - 1);
                let last = text.line_of(owner.bytes.end.saturating_sub(1)) as usize - 1;
                let end = text.line_span(last).start + text.line(last).len();
                let mut bytes = text.ending(owner.bytes.start).to_vec();
                bytes.extend(text.slice(line).iter().copied().take_while(|b| matches!(b, b' ' | b'\t')));
                let list = self.literal(wanted.target, &numbers)?;
                bytes.extend(format!("{}{name} = {list}", owner.qualifier).into_bytes());
                out.push(Patch::new(0, end..end, bytes));
                for k in steps {
                    let (_, site) = self.at(k)?;
                    out.push(Patch::new(0, site.point, name.clone()));
                }
            }
            Ok(())
        };
        self.asked().wanted(&|t, q| self.numbers(t, q), &keeps, &mut each)?;
        Ok(out)
    }

    /// A name that nothing in the file has.
    fn fresh(&self, old: &str, taken: &mut HashSet<String>) -> String {
        (1u32..)
            .map(|n| format!("{old}_lm{n}"))
            .find(|name| !self.words.contains(name) && !words::is_reserved(name) && taken.insert(name.clone()))
            .unwrap_or_default()
    }

    fn points(&self, k: usize, m: &Move, site: &Site, edit: EditRef, out: &mut Patches) -> Result<()> {
        if !self.has_new_points(k, m, site, edit, out)? {
            return Ok(());
        }
        let text = self.text()?;
        let mut times = None;
        if let Some(time) = &site.time {
            let legs = EditRequest::legs(edit, time, &[CYCLE_S, SHORT_CYCLE_S], 5);
            let legs =
                legs.ok_or_else(|| self.refused(k, "its time t= is too short to be shared out over so many points"))?;
            out.push(Patch::new(0, time.0.clone(), legs.last().cloned().unwrap_or_default()));
            times = Some((time.0.clone(), legs));
        }
        let line = text.line_span(text.line_of(site.bytes.start()) as usize - 1);
        let indent = text.slice(line.start..site.bytes.start());
        let mut bytes = Vec::new();
        for (n, point) in edit.before.iter().enumerate() {
            let target = self.target(k, m, site, point, edit.as_joint_moves)?;
            let blend = self.room(m, point);
            let argument;
            let place = if edit.as_joint_moves { site.goal } else { site.point };
            let mut patches = vec![(place.range(), target.as_str())];
            let via = edit.piece(n).map(|at| self.on_arc(k, m, Some(&point.q), at)).transpose()?;
            if let (Some(span), Some(via)) = (&site.via, &via) {
                patches.push((span.range(), via.as_str()));
            }
            if let Some((span, legs)) = &times {
                patches.push((span.clone(), legs[n].as_str()));
            }
            match (&site.blend, &blend) {
                (Some(span), Some(blend)) => patches.push((span.range(), blend.as_str())),
                // a straight move or an arc without `r=` stops
                (None, Some(r)) if m.blend_m == Some(0.0) && r != "0" => {
                    let end = site.bytes.end() - 1;
                    argument = format!(", r={r}");
                    patches.push((end..end, argument.as_str()));
                }
                _ => {}
            }
            patches.sort_by_key(|p| p.0.start);
            bytes.extend(flat(text.substituted(site.bytes.range(), patches)));
            bytes.extend_from_slice(text.ending(site.bytes.start()));
            bytes.extend_from_slice(indent);
        }
        out.push(Patch::new(0, site.bytes.start()..site.bytes.start(), bytes));
        Ok(())
    }

    /// `r=` of a new point; `None`: the joint move stops exactly, and so does its copy. A straight TCP move is not stopped on
    /// its way.
    fn room(&self, m: &Move, point: &NewPoint) -> Option<String> {
        if m.blend_m == Some(0.0) && m.path == PathKind::Joint {
            return None;
        }
        let own = m.blend_m.filter(|r| *r > 0.0).unwrap_or(f64::INFINITY);
        Some(blend(point.clearance_m.min(own).min(BLEND_M)))
    }

    /// The move's own blend, where a new point lies too near for it.
    fn blend(&self, k: usize, m: &Move, site: &Site, edit: EditRef, out: &mut Patches) -> Result<()> {
        let (Some(most), Some(span)) = (edit.blend_at_most_m, &site.blend) else { return Ok(()) };
        match m.blend_m {
            Some(r) if r <= most => Ok(()),
            Some(_) => {
                let text = self.text()?;
                let new = blend(most);
                if new.as_bytes() != text.slice(*span) {
                    out.push(Patch::new(0, *span, new));
                }
                Ok(())
            }
            None => Err(self.refused(
                k,
                "its blend r= is no number here, so it cannot be kept clear of a new point; write it as a number",
            )),
        }
    }
}

/// A blend rounded down, m.
fn blend(most_m: f64) -> String {
    let steps = (most_m / BLEND_STEP_M + 1e-9).floor() as i64;
    Decimal::new(steps, BLEND_DECIMALS).filter(|_| steps > 0).map_or("0".into(), |r| r.to_string())
}

/// Text on one line: line breaks and comments become blanks.
fn flat(out: Vec<u8>) -> Vec<u8> {
    if !out.contains(&b'\n') {
        return out;
    }
    let lines = out.split(|&b| b == b'\n').map(|line| {
        let mut quote = None;
        let comment = line.iter().position(|&b| {
            match quote {
                None if matches!(b, b'"' | b'\'') => quote = Some(b),
                Some(q) if q == b => quote = None,
                _ => {}
            }
            quote.is_none() && b == b'#'
        });
        line[..comment.unwrap_or(line.len())].trim_ascii()
    });
    lines.collect::<Vec<_>>().join(&b' ')
}
