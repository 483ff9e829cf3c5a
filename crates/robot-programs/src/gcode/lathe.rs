//! Lathes: how X words count, and whose feed F is. [`signs`](super::signs) has what shows that a program is one of a lathe.
//!
//! X of a lathe is mostly a diameter: the axis moves by half of what a word says. R, I, J and K of an arc stay radii. Fanuc, Series 16/18
//! for lathe, operator's manual B-62754EN/01, table 9.4(a). Which it is, a parameter of the control says (Fanuc 1006#3), or words: G7 and
//! G8 (LinuxCNC), DIAMON, DIAMOF and DIAM90 (Siemens). Assumes that programs without a word of lathes, and those with Y moves, have the
//! places of the axis.
//!
//! G98 and G99 are feeds per minute and per turn on lathes, and levels of return on mills.

use super::across::Across;
use super::lex::{Block, has_axes, names};
use super::read::Reader;
use super::reason::{After, Elsewhere};
use crate::axes::JointKind;
use crate::script::Break;

impl Reader<'_> {
    /// Way of an axis, in mm, by one mm of its word.
    pub(super) fn across_factor(&self, axis: usize) -> f64 {
        if self.is_across(axis) { self.across.map_or(1.0, |across| across.factor(self.absolute)) } else { 1.0 }
    }

    /// X of a lathe.
    pub(super) fn is_across(&self, axis: usize) -> bool {
        self.letters.get(axis) == Some(&b'X') && self.robot.axis(axis).kind == JointKind::Prismatic
    }

    /// The plane of arcs of a lathe with X and Z alone, where no word names another: no other has both axes.
    pub(super) fn plane_of_lathe(&self) -> Option<[u8; 3]> {
        let has = |letter: u8| self.letters.contains(&letter);
        let others =
            [170, 190].iter().any(|c| self.survey.codes.contains(c)) || self.survey.hidden || self.survey.has_y;
        let alone = has(b'X') && has(b'Z') && !has(b'Y');
        (alone && self.survey.diameters && !others).then_some([b'Z', b'X', b'Y'])
    }

    /// X words count otherwise from here on.
    pub(super) fn count_across(&mut self, k: usize, across: Across) {
        if self.across.is_some_and(|before| before != across) {
            self.end(k, Break::Frame, After::Across);
        }
        self.across = Some(across);
    }

    /// A block whose X may be a diameter or the place of the axis: it stays, and where its axes come to is not known. `false`: it is none.
    pub(super) fn leaves_across(&mut self, k: usize, block: &Block) -> bool {
        if self.across.is_some() || !(0..self.letters.len()).any(|a| self.is_across(a)) {
            return false;
        }
        let arc = matches!(self.motion, Some(20 | 30)) && self.plane.is_some_and(|[u, v, _]| [u, v].contains(&b'X'));
        if !arc && !names(block, b"X") {
            return false;
        }
        self.script.diameter_unstated = true;
        if arc {
            self.keep_start_of_arc(After::Arc);
        }
        let straight = matches!(self.motion, Some(0 | 10)) && self.absolute == Some(true);
        let axes = self.axes_named(block).filter(|_| straight);
        self.goes_elsewhere(k, axes, Elsewhere::Across);
        true
    }

    /// G98 and G99 of a lathe: feed per minute and per turn. Beside G95 they may be levels of return.
    pub(super) fn feed_of_lathe(&mut self, c: u32) {
        let per_minute = c == 980 && !self.survey.codes.contains(&950);
        self.feed_mode = if per_minute { 94 } else { 95 };
        self.feed = None;
    }

    /// G92 with a feed cuts a thread on lathes.
    pub(super) fn cuts_thread(&self, block: &Block, c: u32) -> bool {
        c == 920 && self.survey.diameters && has_axes(block) && names(block, b"F")
    }

    /// Control may come from elsewhere: what words of the text may have changed is not certain.
    pub(super) fn join_lathe(&mut self) {
        if self.survey.across.iter().any(|other| Some(*other) != self.across) {
            self.across = None;
        }
        if self.survey.diameters && !self.survey.single(&[940, 950, 980, 990]) {
            self.feed_mode = 95;
        }
    }

    /// The state of X words and of the feed in which a control begins the program.
    pub(super) fn begin_lathe(&mut self) {
        let unstated = if self.survey.diameters { None } else { Some(Across::Radius) };
        self.across = self.robot.control.diameter.map(Across::of_control).or(unstated);
        if self.survey.diameters {
            // feeds of a turn are usual there
            self.feed_mode = 95;
        }
    }
}
