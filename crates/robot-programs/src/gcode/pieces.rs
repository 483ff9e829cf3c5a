//! Arcs with edits: pieces between the given points.
//!
//! A piece whose ends carry the same offset is the old arc, moved. Where the offset changes, a short piece becomes a straight one,
//! and one that is not short an arc whose centre lies on the middle perpendicular of its new ends. The last piece is always an
//! arc, so that the modal motion after it stays. What was written is read as a control would read it before it is taken.

use super::arc::{Arc, Centre, NoArc};
use super::reason::Reason;
use super::statements::{Statement, most};
use super::write::{SAME, Writer, Written};
use crate::axes::JointKind;
use crate::script::number::{self, Style};
use crate::script::{EditRef, Patch};
use std::f64::consts::{PI, TAU};

/// Rounding of a centre that needs no further digit, mm.
const CENTRE_MM: f64 = 1e-6;
/// Turn by which an arc whose centre words stay may differ, rad.
const MOST_OTHER_TURN: f64 = 0.1;
/// Ends of an arc that move differently: turns beyond this hold no other centre.
const MOST_TURN: f64 = TAU - 0.35;
/// Turn by which a small arc whose ends move differently may differ, rad.
const MOST_SMALL_TURN: f64 = 0.5;
/// Ends of less than half a turn stand apart by this many times what rounding makes, or a control may read a full circle.
const APART: f64 = 3.0;

/// A part of an arc, and where its ends come to stand.
struct Piece {
    from: [f64; 2],
    to: [f64; 2],
    /// Of the arc.
    shares: [f64; 2],
    /// Of its ends from the arc.
    offsets: [[f64; 2]; 2],
    /// What rounding alone makes of two equal offsets, mm.
    noise: f64,
}

impl Piece {
    fn turn(&self, arc: &Arc) -> f64 {
        (self.shares[1] - self.shares[0]).max(0.0) * arc.sweep.abs()
    }

    fn chord(&self) -> [f64; 2] {
        [0, 1].map(|k| self.to[k] - self.from[k])
    }

    /// How far the offsets of its ends differ.
    fn differ(&self) -> f64 {
        let [a, b] = self.offsets;
        (b[0] - a[0]).hypot(b[1] - a[1])
    }

    /// Both ends would come to stand on one place.
    fn closes(&self, arc: &Arc) -> bool {
        let chord = self.chord();
        self.turn(arc) < PI && chord[0].hypot(chord[1]) < APART * self.noise
    }

    /// How far `made` runs beside the arc and its offsets.
    fn beside(&self, arc: &Arc, made: &Arc) -> f64 {
        const PARTS: u32 = 16;
        let at = |k: u32| {
            let t = f64::from(k) / f64::from(PARTS);
            let between = |[a, b]: [f64; 2]| a + t * (b - a);
            let (own, p) = (arc.at(between(self.shares)), made.at(t));
            let off = |i: usize| p[i] - own[i] - between([self.offsets[0][i], self.offsets[1][i]]);
            off(0).hypot(off(1))
        };
        (1..PARTS).map(at).fold(0.0, f64::max)
    }
}

/// The block of an arc that is written in pieces.
struct ArcBlock<'a> {
    step: usize,
    s: &'a Statement,
    arc: &'a Arc,
    form: Centre,
    /// What rounding alone makes of two equal offsets, mm.
    noise: f64,
}

/// An end of a piece: its share of the arc, and its offset from the arc there, mm.
#[derive(Clone, Copy)]
struct End {
    share: f64,
    offset: [f64; 2],
}

impl ArcBlock<'_> {
    /// Places in the plane of the arc.
    fn in_plane(&self, places: &[Option<f64>]) -> [f64; 2] {
        [self.arc.u, self.arc.v].map(|k| places[k].unwrap_or(0.0))
    }

    /// The end at a share of the arc that comes to stand at `places`.
    fn end(&self, share: f64, places: &[Option<f64>]) -> End {
        let (own, p) = (self.arc.at(share), self.in_plane(places));
        End { share, offset: [p[0] - own[0], p[1] - own[1]] }
    }

    /// The piece between two ends, as they are written.
    fn piece(&self, ends: [End; 2], written: [&[Option<f64>]; 2]) -> Piece {
        let [from, to] = written.map(|places| self.in_plane(places));
        Piece { from, to, shares: ends.map(|e| e.share), offsets: ends.map(|e| e.offset), noise: self.noise }
    }
}

impl Writer<'_> {
    /// An arc: pieces between the given points.
    pub(super) fn arc(
        &mut self,
        step: usize,
        s: &Statement,
        edit: Option<EditRef>,
        goal: &[Option<f64>],
        arc: &Arc,
        form: Centre,
    ) -> Written {
        let block = ArcBlock { step, s, arc, form, noise: self.arc_noise(s, [arc.u, arc.v]) };
        let points = edit.map(|e| e.before).unwrap_or_default();
        let mut reached = block.end(0.0, &self.now);
        let last = block.end(1.0, goal);
        let mut bounds = vec![reached.offset, last.offset];
        for p in points.iter().filter(|p| p.of_way) {
            bounds.push(block.end(p.share, &self.wanted(step, s, &p.q)?).offset);
        }
        let mut straight = false;
        for p in points {
            let want = self.wanted(step, s, &p.q)?;
            let end = block.end(p.share, &want);
            let after = (reached.share - 1e-9..=1.0).contains(&p.share);
            if !after || !is_within(&bounds, end.offset, block.noise) {
                let by = end.offset[0].hypot(end.offset[1]);
                return Err(self.refused(step, Reason::BesideArc((by * 1e4).round() / 1e4)));
            }
            straight = self.insert_piece(&block, reached, end, &want)?;
            reached = end;
        }
        self.last_piece(&block, reached, last, goal, !points.is_empty())?;
        if straight && s.motion_word.is_none() {
            self.name_motion(s);
        }
        Ok(())
    }

    /// A new block before that of the arc: a piece to a new point; whether it is straight, as a short one is.
    fn insert_piece(&mut self, block: &ArcBlock, from: End, to: End, want: &[Option<f64>]) -> Written<bool> {
        let ArcBlock { step, s, arc, form, noise } = *block;
        let leg = self.leg(s, want, false);
        let piece = block.piece([from, to], [&self.now, &leg.to]);
        let (turn, differ) = (piece.turn(arc), piece.differ());
        let sagitta = arc.radius[0] * (1.0 - (0.5 * turn.min(PI)).cos());
        let short = if differ > noise { differ } else { 0.3 * noise };
        let straight = sagitta <= short || piece.closes(arc);
        if straight {
            self.insert(s, &leg, 1, None);
        } else {
            let centre = self.centre(step, s, arc, form, &piece)?;
            self.insert(s, &leg, s.motion, Some(self.centre_words(s, &centre)));
        }
        self.now = leg.to;
        Ok(straight)
    }

    /// The arc's own block, which becomes the piece to its goal; `cut`: others stand before it.
    fn last_piece(&mut self, block: &ArcBlock, from: End, to: End, goal: &[Option<f64>], cut: bool) -> Written {
        let ArcBlock { step, s, arc, form, noise } = *block;
        let leg = self.leg(s, goal, true);
        let piece = block.piece([from, to], [&self.now, &leg.to]);
        let moved = from.offset[0].hypot(from.offset[1]) > SAME.max(1e-7);
        let other = cut || piece.differ() > noise || (moved && form == Centre::Absolute);
        // the centre's words stay where a control still finds one radius, and the same turn
        if other || !self.keeps(s, arc, form, &piece) {
            if piece.closes(arc) {
                return Err(self.refused(step, Reason::ArcCloses));
            }
            let centre = self.centre(step, s, arc, form, &piece)?;
            self.replace_centre(s, &centre);
        }
        self.replace(s, leg.words);
        self.now = leg.to;
        Ok(())
    }

    /// Writes the motion word of a block that took it from the block before.
    fn name_motion(&mut self, s: &Statement) {
        let at = s.words.iter().find(|w| w.letter != b'N').map_or(0, |w| w.span().start);
        self.patches.push(Patch::new(0, at..at, format!("{} ", self.motion(s, s.motion))));
    }

    /// What rounding alone makes of two equal offsets of an arc, mm.
    fn arc_noise(&self, s: &Statement, axes: [usize; 2]) -> f64 {
        let digit = axes.map(|a| self.edits.digit.get(a).copied().unwrap_or(0.0) / self.program.si[a]);
        let coarse = axes.map(|a| number::last_digit(self.style(s, a).decimals) * s.unit[a]);
        1.5 * digit[0].max(digit[1]).max(1e-6).min(coarse[0].max(coarse[1]).max(1e-6)) + 1e-6
    }

    /// Whether the centre words of the block do for its arc where its ends move alike.
    fn keeps(&self, s: &Statement, arc: &Arc, form: Centre, piece: &Piece) -> bool {
        let (axes, ccw) = ([arc.u, arc.v], arc.sweep > 0.0);
        let read = match form {
            Centre::Absolute => return true,
            Centre::Relative => {
                let start = arc.at(0.0);
                let centre = [0, 1].map(|k| piece.from[k] + arc.centre[k] - start[k]);
                Arc::about(axes, piece.from, piece.to, centre, ccw)
            }
            Centre::Radius => {
                let r = s.words.iter().find(|w| w.letter == b'R').and_then(|w| w.value).map_or(0.0, |v| v.0);
                Arc::of_radius(axes, piece.from, piece.to, r * s.arc_unit(axes), ccw)
            }
        };
        read.is_ok_and(|r| (r.sweep - arc.sweep).abs() < MOST_OTHER_TURN)
    }

    /// Centre words (I, J, K or R) of a piece: letter and text.
    fn centre(&self, step: usize, s: &Statement, arc: &Arc, form: Centre, piece: &Piece) -> Written<Vec<(u8, String)>> {
        let (chord, turn, differ) = (piece.chord(), piece.turn(arc), piece.differ());
        let length = chord[0].hypot(chord[1]);
        if differ > piece.noise && turn > MOST_TURN {
            return Err(self.refused(step, Reason::WholeCircle));
        }
        let own = [0, 1].map(|k| arc.centre[k] + 0.5 * (piece.offsets[0][k] + piece.offsets[1][k]));
        // onto the middle perpendicular: both ends get the same radius
        let middle = [0, 1].map(|k| 0.5 * (piece.from[k] + piece.to[k]));
        let along = || ((own[0] - middle[0]) * chord[0] + (own[1] - middle[1]) * chord[1]) / (length * length);
        let centre = if length > 0.05 * arc.radius[0] { [0, 1].map(|k| own[k] - along() * chord[k]) } else { own };
        let (words, made) = self.centre_at(s, arc, form, piece, centre);
        // what a control will make of it
        let holds = |m: &Arc| {
            (m.sweep.abs() - turn).abs() < 0.05 && (m.radius[0] - arc.radius[0]).abs() < 0.05 * arc.radius[0] + 1e-3
        };
        if made.is_ok_and(|m| holds(&m)) {
            return Ok(words);
        }
        // An arc not much larger than the change: the same turn between the new ends, with another radius. It is the old piece,
        // turned and stretched, and runs beside it by what the offsets differ.
        if length > SAME && turn < MOST_TURN {
            let aside = 0.5 / (0.5 * turn).tan() * arc.sweep.signum();
            let centre = [middle[0] - aside * chord[1], middle[1] + aside * chord[0]];
            let (words, made) = self.centre_at(s, arc, form, piece, centre);
            let near = |m: &Arc| {
                (m.sweep.abs() - turn).abs() < MOST_SMALL_TURN
                    && piece.beside(arc, m) <= 2.0 * differ + piece.noise.max(1e-3)
            };
            if made.is_ok_and(|m| near(&m)) {
                return Ok(words);
            }
        }
        Err(self.refused(step, Reason::DigitsTooCoarse))
    }

    /// Words of a centre, and what a control makes of them.
    fn centre_at(
        &self,
        s: &Statement,
        arc: &Arc,
        form: Centre,
        piece: &Piece,
        centre: [f64; 2],
    ) -> (Vec<(u8, String)>, std::result::Result<Arc, NoArc>) {
        let (from, to, turn, chord) = (piece.from, piece.to, piece.turn(arc), piece.chord());
        let length = chord[0].hypot(chord[1]);
        let mm = s.arc_unit([arc.u, arc.v]);
        let letter = |axis: usize| b'I' + (self.program.letters[axis] - b'X');
        let own = |l: u8| s.words.iter().find(|w| w.letter == l).and_then(|w| w.value).map(|v| v.1);
        let most = most(JointKind::Prismatic, mm);
        let style = |l: u8| {
            own(l)
                .or_else(|| own(letter(arc.u)))
                .or_else(|| own(letter(arc.v)))
                .map_or(self.style(s, arc.u), |st| Style { plus: false, ..st })
        };
        // as few digits as hold it
        let decimals = |l: u8, v: f64| {
            let off = |d: u8| (v - number::rounded(v, d)).abs() * mm;
            let own = style(l).decimals;
            (own..most).find(|&d| off(d) < CENTRE_MM).unwrap_or(own.max(most))
        };
        let ccw = arc.sweep > 0.0;
        let axes = [arc.u, arc.v];
        match form {
            Centre::Radius => {
                let r = (from[0] - centre[0]).hypot(from[1] - centre[1]).max(0.5 * length) / mm;
                let r = if turn > PI { -r } else { r };
                let digits = decimals(b'R', r);
                let back = number::rounded(r, digits) * mm;
                let text = number::write(r, style(b'R'), digits);
                (vec![(b'R', text)], Arc::of_radius(axes, from, to, back, ccw))
            }
            Centre::Relative | Centre::Absolute => {
                let zero = |k: usize| if form == Centre::Relative { from[k] } else { s.shift[axes[k]] };
                let words = [0, 1].map(|k| {
                    let l = letter(axes[k]);
                    let v = (centre[k] - zero(k)) / mm;
                    (l, v, decimals(l, v))
                });
                let back = |k: usize| zero(k) + number::rounded(words[k].1, words[k].2) * mm;
                let made = Arc::about(axes, from, to, [back(0), back(1)], ccw);
                (words.map(|(l, v, digits)| (l, number::write(v, style(l), digits))).to_vec(), made)
            }
        }
    }

    pub(super) fn centre_words(&self, s: &Statement, words: &[(u8, String)]) -> String {
        let word = |(l, text): &(u8, String)| self.cased(s, (*l as char).to_string()) + text;
        words.iter().map(word).collect::<Vec<_>>().join(" ")
    }

    pub(super) fn replace_centre(&mut self, s: &Statement, words: &[(u8, String)]) {
        let mut added = String::new();
        for (letter, text) in words {
            let new = number::read(text.as_bytes()).map(|v| v.0);
            match s.words.iter().find(|w| w.letter == *letter) {
                Some(w) if w.value.map(|v| v.0) == new => {}
                Some(w) => self.patches.push(Patch::new(0, w.number(), text.as_bytes())),
                None if new == Some(0.0) => {}
                None => added.push_str(&format!(" {}{text}", self.cased(s, (*letter as char).to_string()))),
            }
        }
        if !added.is_empty() {
            let last = s.words.iter().rfind(|w| b"IJKR".contains(&w.letter));
            let at = last.map_or(0, |w| w.span().end);
            self.patches.push(Patch::new(0, at..at, added));
        }
    }
}

/// An offset lies among others, nearer than a fifth of what they differ by: a sampled arc is not quite round.
fn is_within(bounds: &[[f64; 2]], place: [f64; 2], noise: f64) -> bool {
    (0..2).all(|k| {
        let [lo, hi] = bounds.iter().fold([f64::MAX, f64::MIN], |[lo, hi], b| [lo.min(b[k]), hi.max(b[k])]);
        let slack = 2.0 * noise + 0.2 * (hi - lo);
        (lo - slack..=hi + slack).contains(&place[k])
    })
}
