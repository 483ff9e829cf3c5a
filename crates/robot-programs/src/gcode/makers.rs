//! Work frames and modes as single makers name them.
//!
//! | words | maker, manual |
//! | --- | --- |
//! | `G154 P1` to `P99`, G110 to G129 | Haas, "Programmable Offsets" (L20: "P1-P20 G110-G129 references auxiliary coordinates", "P1-P99 G154 P1-P99 reference auxiliary coordinate"); Haas, VF series, operator's manual 96-8000, June 1999, p. 164: "L20 Auxiliary work coordinate origin for G110-G129" |
//! | G500, G505 to G599 | Siemens, 840D, programming manual Fundamentals 6FC5298-7AB00-0BP1, p. 3-21: "G505 ...G599 Call the 6th to the 99th settable zero offset", "G500=zero frame", "Deactivation of settable zero offsets/frames (G54 to G599) until the next call" |
//! | G62 | Fanuc, Series 0i-PC, operator's manual B-64154EN/01, table 5.4: "Once specified, this function is valid until G61 or G64 is specified", "override is applied to the cutting feedrate" |
//! | `G05 P10000`, `G05 P0` | Fanuc, Series 30i, G code list of machining centers, G05 of group 00: "AI contour control (high-precision contour control compatible command)"; a mill programming manual of PowerRoute, p. 21: "G05 P10000 //Start high speed & high interpolation", "G05 P0 // high speed & high precision interpolation off" |
//!
//! G110 to G129 are other words on other controls (poles of polar coordinates, tool changes, measurements): they are work frames where the
//! text has other words of Haas, and is not one of a lathe. G112 is a polar interpolation on newer ones. Other numbers of `G05 P` run
//! cycles.

use super::codes::{code, is_work_frame};
use super::lex::{Block, Word, has_axes, names};
use super::survey::Survey;
use std::collections::BTreeSet;

/// Words that Haas controls alone have: G154, the smoothness G187.
pub(super) fn is_of_haas(c: u32) -> bool {
    matches!(c, 1540 | 1870)
}

/// G500 and G505 to G599, on a Siemens control.
pub(super) fn is_frame_of_siemens(c: u32) -> bool {
    c == 5000 || (5050..=5990).contains(&c) && c.is_multiple_of(10)
}

/// Switches a high speed mode of a control on or off.
///
/// `mode = ["N" number] "G5" "P" ("10000" | "0")`
pub(super) fn is_high_speed(block: &Block, c: u32) -> bool {
    let p = |w: &Word| w.letter == b'P' && w.value.is_some_and(|v| v.0 == 0.0 || v.0 == 10_000.0);
    let other = block.words.iter().any(|w| !b"NGP".contains(&w.letter) || w.letter == b'P' && !p(w));
    c == 50 && !other && block.words.iter().any(p)
}

/// A mode of the feed at corners.
///
/// `mode = "G61" | "G61.1" | "G62" | "G64"`
pub(super) fn is_corner_mode(block: &Block, c: u32) -> bool {
    // with axes it is a mirror on some controls
    matches!(c, 610 | 611 | 640) || c == 620 && !has_axes(block)
}

/// A further work frame of Haas: its number stands beside it.
///
/// `frame = "G154" "P" number`
pub(super) fn is_numbered_frame(block: &Block, c: u32) -> bool {
    let number = |w: &Word| w.value.is_some_and(|v| v.0.fract() == 0.0 && (1.0..100.0).contains(&v.0));
    c == 1540 && block.words.iter().any(|w| w.letter == b'P' && number(w)) && !names(block, b"T")
}

/// What is one of the first twenty of these frames on a mill of Haas: nothing beside it makes it another word.
///
/// `frame = ("G110" | "G111" | "G113" ... "G129") [("G0" | "G1" | "G2" | "G3") axis_word {axis_word}]`
pub(super) fn may_be_frame_of_haas(block: &Block, c: u32) -> bool {
    let of_hundred = (1100..=1290).contains(&c) && c.is_multiple_of(10) && c != 1120;
    let motion = |w: &Word| w.letter == b'G' && w.value.is_some_and(|v| [0, 10, 20, 30].contains(&code(v.0)));
    let other = block.words.iter().any(|w| b"TDHPQLE".contains(&w.letter));
    of_hundred && !other && (!has_axes(block) || block.words.iter().any(motion))
}

/// What a look over a text finds of such words.
#[derive(Debug, Default)]
pub(super) struct Makers {
    /// Words of Haas.
    haas: bool,
    /// What may be work frames of Haas, and what is one of Siemens.
    frames: [BTreeSet<u32>; 2],
}

impl Makers {
    pub(super) fn m_word(&mut self, m: f64) {
        self.haas |= m == 97.0;
    }

    /// Whether a G word is followed if the text is one of its maker.
    pub(super) fn g_word(&mut self, block: &Block, c: u32) -> bool {
        self.haas |= is_of_haas(c);
        let of_maker = [may_be_frame_of_haas(block, c), is_frame_of_siemens(c)];
        for (frames, _) in self.frames.iter_mut().zip(of_maker).filter(|(_, of)| *of) {
            frames.insert(c);
        }
        of_maker.contains(&true)
    }

    /// Takes the words for frames where the text is one of their maker, and else as what is not followed.
    pub(super) fn settle(self, survey: &mut Survey, unfollowed: &mut BTreeSet<u32>) {
        let lathe = survey.lathe || survey.diameters;
        survey.haas = self.haas && !lathe && !survey.siemens && !survey.printer;
        let [haas, siemens] = self.frames;
        let mut frames = survey.codes.contains(&1540);
        for (found, of_maker) in [(haas, survey.haas), (siemens, survey.siemens)] {
            frames |= of_maker && !found.is_empty();
            if !of_maker {
                // the end of a polar interpolation
                unfollowed.extend(found.into_iter().filter(|c| *c != 1130));
            }
        }
        if frames {
            // as those that a number chooses
            survey.codes.insert(541);
        }
    }
}

impl Survey {
    /// Whether a G word chooses a work frame.
    pub(super) fn names_frame(&self, block: &Block, c: u32) -> bool {
        is_work_frame(c)
            || is_numbered_frame(block, c)
            || self.haas && may_be_frame_of_haas(block, c)
            || self.siemens && is_frame_of_siemens(c)
    }
}

/// The work frame that such a word on line `k` chooses: `G54.1 P2` and `G54 P2` are others than `G54.1 P1`, G110 is `G154 P1`. A P that is
/// no number chooses a frame that is no other line's.
///
/// `frame = "G54" ["P" number] | ("G54.1" | "G154") "P" number | "G" number`
pub(super) fn work_frame(block: &Block, c: u32, k: usize) -> u32 {
    const NUMBERED: u32 = 100_000;
    const OF_HAAS: u32 = 10_000_000;
    const COMPUTED: u32 = 1 << 31;
    const MOST: f64 = 1e6;
    // words of settings that take no P; any other may have it: a dwell, a call, a cycle, a tolerance
    const WITHOUT: [u32; 25] = [
        0, 10, 170, 180, 190, 200, 210, 400, 430, 490, 500, 540, 550, 560, 570, 580, 590, 690, 700, 710, 800, 900, 910,
        940, 1540,
    ];
    let another = || {
        let takes = |w: &Word| w.value.is_none_or(|v| !WITHOUT.contains(&code(v.0)));
        block.words.iter().any(|w| w.letter == b'M' || w.letter == b'G' && takes(w))
    };
    let base = if c == 1540 { OF_HAAS } else { NUMBERED };
    match block.words.iter().find(|w| w.letter == b'P') {
        _ if (1100..=1290).contains(&c) => OF_HAAS + (c - 1100) / 10 + 1,
        Some(p) if c == 541 || c == 1540 || c == 540 && !another() => match p.value {
            Some((v, _)) if (0.0..MOST).contains(&v) && (c != 1540 || !another()) => base + v as u32,
            _ => COMPUTED + k as u32,
        },
        _ => c,
    }
}
