//! Arcs with edits: pieces between the given points.
//!
//! A piece whose ends carry the same offset is the old arc, moved. Where the offset changes, a short piece becomes a straight one,
//! and one that is not short an arc whose centre lies on the middle perpendicular of its new ends. The last piece is always an
//! arc, so that the modal motion behind it stays. What was written is read as a control would read it before it is taken.

use super::arc::Arc;
use super::write::{SAME, Writer};
use super::{Centre, Statement, goal};
use crate::error::Result;
use crate::program::script::number::{self, Style};
use crate::program::script::{Edit, Patch};
use crate::robot::JointKind;
use std::f64::consts::{PI, TAU};

/// Rounding of a centre that needs no further digit, mm.
const CENTRE_MM: f64 = 1e-6;
/// Turn by which an arc whose centre words stay may differ, rad.
const MOST_OTHER_TURN: f64 = 0.1;
/// Ends of an arc that move differently: turns beyond this hold no other centre.
const MOST_TURN: f64 = TAU - 0.35;

impl Writer<'_> {
    /// An arc: pieces between the given points.
    pub(super) fn arc(
        &mut self,
        step: usize,
        s: &Statement,
        edit: Option<&Edit>,
        goal: &[Option<f64>],
        arc: &Arc,
        form: Centre,
    ) -> Result<()> {
        let (u, v) = (arc.u, arc.v);
        let off = |share: f64, p: [f64; 2]| {
            let own = arc.at(share);
            [p[0] - own[0], p[1] - own[1]]
        };
        let here = |now: &[Option<f64>]| [now[u].unwrap_or(0.0), now[v].unwrap_or(0.0)];
        let digit = [u, v].map(|a| self.edits.digit.get(a).copied().unwrap_or(0.0) / self.program.si[a]);
        let coarse = [u, v].map(|a| 10f64.powi(-i32::from(self.style(s, a).decimals)) * s.unit[a]);
        // what rounding alone makes of two equal offsets
        let noise = 1.5 * digit[0].max(digit[1]).max(1e-6).min(coarse[0].max(coarse[1]).max(1e-6)) + 1e-6;
        let end = here(goal);
        let points = edit.map(|e| e.before.as_slice()).unwrap_or_default();
        let mut bounds = vec![off(0.0, here(&self.now)), off(1.0, end)];
        for p in points.iter().filter(|p| p.of_way) {
            bounds.push(off(p.share, here(&self.wanted(step, s, &p.q)?)));
        }
        let (mut share, mut offset) = (0.0, bounds[0]);
        let mut straight = false;
        for p in points {
            let want = self.wanted(step, s, &p.q)?;
            let place = off(p.share, here(&want));
            // nearer than a fifth of what the offsets differ by: a sampled arc is not quite round
            let within = (0..2).all(|k| {
                let [lo, hi] = bounds.iter().fold([f64::MAX, f64::MIN], |[lo, hi], b| [lo.min(b[k]), hi.max(b[k])]);
                let slack = 2.0 * noise + 0.2 * (hi - lo);
                (lo - slack..=hi + slack).contains(&place[k])
            });
            let behind = (share - 1e-9..=1.0).contains(&p.share);
            if !behind || !within {
                let by = place[0].hypot(place[1]);
                return Err(
                    self.refused(step, &format!("a new point lies {by:.4} mm beside the arc on which it should be"))
                );
            }
            let from = here(&self.now);
            let leg = self.leg(s, &want, false);
            let to = here(&leg.to);
            let turn = (p.share - share).max(0.0) * arc.sweep.abs();
            let differ = (place[0] - offset[0]).hypot(place[1] - offset[1]);
            let sagitta = arc.radius[0] * (1.0 - (0.5 * turn.min(PI)).cos());
            straight = sagitta <= if differ > noise { differ } else { 0.3 * noise };
            if straight {
                self.insert(s, &leg, 1, None);
            } else {
                let mean = [0.5 * (offset[0] + place[0]), 0.5 * (offset[1] + place[1])];
                let centre = self.centre(step, s, arc, form, from, to, mean, turn, differ > noise)?;
                self.insert(s, &leg, s.motion, Some(self.centre_words(s, arc, &centre)));
            }
            self.now = leg.to;
            (share, offset) = (p.share, place);
        }
        let from = here(&self.now);
        let leg = self.leg(s, goal, true);
        let to = here(&leg.to);
        let last = off(1.0, end);
        let differ = (last[0] - offset[0]).hypot(last[1] - offset[1]);
        let whole = points.is_empty();
        let moved = offset[0].hypot(offset[1]) > SAME.max(1e-7);
        if !whole || differ > noise || (moved && form == Centre::Absolute) {
            let turn = (1.0 - share) * arc.sweep.abs();
            if turn * arc.radius[0] < 3.0 * noise {
                return Err(self.refused(step, "a new point stands at the very end of an arc"));
            }
            let mean = [0.5 * (offset[0] + last[0]), 0.5 * (offset[1] + last[1])];
            let centre = self.centre(step, s, arc, form, from, to, mean, turn, differ > noise)?;
            self.replace_centre(s, &centre);
        } else if form == Centre::Relative {
            // the centre's words stay: a control must still find one radius, and the same turn
            let start = arc.at(0.0);
            let centre = [from[0] + arc.centre[0] - start[0], from[1] + arc.centre[1] - start[1]];
            let read = Arc::about([u, v], from, to, centre, arc.sweep > 0.0);
            if !read.is_ok_and(|r| (r.sweep - arc.sweep).abs() < MOST_OTHER_TURN) {
                return Err(self.refused(step, "its ends would no longer fit its centre"));
            }
        }
        self.replace(s, &leg);
        if straight && s.motion_word.is_none() {
            let at = s.words.iter().find(|w| w.letter != b'N').map_or(0, |w| w.span.start);
            self.patches.push(Patch::new(0, at..at, format!("{} ", self.motion(s, s.motion))));
        }
        self.now = leg.to;
        Ok(())
    }

    /// Centre words (I, J, K or R) of a piece from and to these points: letter and text.
    #[allow(clippy::too_many_arguments)] // a piece of an arc, and how it is written
    pub(super) fn centre(
        &self,
        step: usize,
        s: &Statement,
        arc: &Arc,
        form: Centre,
        from: [f64; 2],
        to: [f64; 2],
        offset: [f64; 2],
        turn: f64,
        differ: bool,
    ) -> Result<Vec<(u8, String)>> {
        let chord = [to[0] - from[0], to[1] - from[1]];
        let length = chord[0].hypot(chord[1]);
        let mut centre = [arc.centre[0] + offset[0], arc.centre[1] + offset[1]];
        if differ && turn > MOST_TURN {
            return Err(self.refused(step, "the offset changes over a whole circle, and no point may stand between"));
        }
        if length > 0.05 * arc.radius[0] {
            // onto the middle perpendicular: both ends get the same radius
            let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
            let along = ((centre[0] - middle[0]) * chord[0] + (centre[1] - middle[1]) * chord[1]) / (length * length);
            centre = [centre[0] - along * chord[0], centre[1] - along * chord[1]];
        }
        let mm = s.unit[arc.u];
        let letter = |axis: usize| b'I' + (self.program.letters[axis] - b'X');
        let own = |l: u8| s.words.iter().find(|w| w.letter == l).and_then(|w| w.value).map(|v| v.1);
        let most = goal::most(JointKind::Prismatic, mm);
        let style = |l: u8| {
            own(l)
                .or_else(|| own(letter(arc.u)))
                .or_else(|| own(letter(arc.v)))
                .map_or(self.style(s, arc.u), |st| Style { plus: false, ..st })
        };
        // as few digits as hold it
        let decimals = |l: u8, v: f64| {
            let off = |d: u8| (v - (v * 10f64.powi(d.into())).round() / 10f64.powi(d.into())).abs() * mm;
            let own = style(l).decimals;
            (own..most).find(|&d| off(d) < CENTRE_MM).unwrap_or(own.max(most))
        };
        let ccw = arc.sweep > 0.0;
        let axes = [arc.u, arc.v];
        let (words, made) = match form {
            Centre::Radius => {
                let r = (from[0] - centre[0]).hypot(from[1] - centre[1]).max(0.5 * length) / mm;
                let r = if turn > PI { -r } else { r };
                let text = number::write(r, style(b'R'), decimals(b'R', r));
                let back = text.parse::<f64>().unwrap_or(r) * mm;
                (vec![(b'R', text)], Arc::of_radius(axes, from, to, back, ccw))
            }
            Centre::Relative | Centre::Absolute => {
                let zero = |k: usize| if form == Centre::Relative { from[k] } else { s.shift[axes[k]] };
                let word = |k: usize| {
                    let l = letter(axes[k]);
                    let v = (centre[k] - zero(k)) / mm;
                    (l, number::write(v, style(l), decimals(l, v)))
                };
                let words = vec![word(0), word(1)];
                let back = |k: usize| zero(k) + words[k].1.parse::<f64>().unwrap_or(0.0) * mm;
                let made = Arc::about(axes, from, to, [back(0), back(1)], ccw);
                (words, made)
            }
        };
        // what a control will make of it
        let holds = made.is_ok_and(|m| {
            (m.sweep.abs() - turn).abs() < 0.05 && (m.radius[0] - arc.radius[0]).abs() < 0.05 * arc.radius[0] + 1e-3
        });
        if holds {
            Ok(words)
        } else {
            Err(self.refused(step, "no arc in the format's digits holds what is wanted here"))
        }
    }

    pub(super) fn centre_words(&self, s: &Statement, _arc: &Arc, words: &[(u8, String)]) -> String {
        let word = |(l, text): &(u8, String)| self.cased(s, (*l as char).to_string()) + text;
        words.iter().map(word).collect::<Vec<_>>().join(" ")
    }

    pub(super) fn replace_centre(&mut self, s: &Statement, words: &[(u8, String)]) {
        let mut added = String::new();
        for (letter, text) in words {
            match s.words.iter().find(|w| w.letter == *letter) {
                Some(w) => {
                    let same = w.value.map(|v| v.0) == text.parse::<f64>().ok();
                    if !same {
                        self.patches.push(Patch::new(0, w.number.clone(), text.as_bytes()));
                    }
                }
                None if text.parse::<f64>().is_ok_and(|v| v == 0.0) => {}
                None => added.push_str(&format!(" {}{text}", self.cased(s, (*letter as char).to_string()))),
            }
        }
        if !added.is_empty() {
            let last = s.words.iter().rfind(|w| b"IJKR".contains(&w.letter));
            let at = last.map_or(0, |w| w.span.end);
            self.patches.push(Patch::new(0, at..at, added));
        }
    }
}
