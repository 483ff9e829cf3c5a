//! A program that has been rewritten is not rewritten again.
//!
//! Two checks. (1) Beside every file that it writes, `rewrite` leaves a note `FILE.lostmotion.json` with the SHA-256 of the
//! file; an input whose hash stands in a note of its folder is refused (the file itself may carry no mark: every byte that is
//! no motion target stays). (2) A file without its note is known by its reversals ([`looks_rewritten`]): behind nearly every
//! one a short segment carries the very step that this compensator would make. A ramp of several points hides it from (2).

use super::super::Options;
use crate::compensator::{Compensator, JointCompensator};
use crate::error::{Error, Place, Result, is_stdio};
use crate::io::output::write_whole;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

pub const SCHEMA: &str = "lostmotion/rewritten/1";
const ENDING: &str = ".lostmotion.json";

/// The note beside a rewritten file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    pub schema: String,
    /// Version of the program that wrote the file.
    pub version: String,
    /// Names without folders.
    pub input: String,
    pub output: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256_in: Option<String>,
    pub sha256_out: String,
    pub robot: Named,
    pub compensator: Named,
    pub options: Vec<String>,
    /// As in a summary line.
    #[serde(default)]
    pub moves: u64,
    #[serde(default)]
    pub editable: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edited_as_joints: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edited_as_poses: Option<u64>,
    #[serde(default)]
    pub reversals: u64,
    #[serde(default)]
    pub inserted: u64,
    /// The input's bytes, for `undo` ([`super::super::original`]); a large program is not kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub original: Option<String>,
    /// Further files of the program.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub companions: Vec<Companion>,
}

/// A file that belongs to a program, such as the `.dat` of a `.src`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Companion {
    pub input: String,
    pub output: String,
    pub sha256_in: String,
    pub sha256_out: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub original: Option<String>,
}

/// Name and SHA-256.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Named {
    pub name: String,
    pub sha256: String,
}

/// Where the note of a file stands.
pub fn note_path(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_os_string();
    name.push(ENDING);
    PathBuf::from(name)
}

/// Whether a name is that of a note.
pub fn is_note(file: &Path) -> bool {
    file.to_string_lossy().ends_with(ENDING)
}

/// Writes the note of `file`; `false`: standard output, a FIFO and the like have none.
pub fn leave_note(file: &Path, note: &Note) -> Result<bool> {
    if is_stdio(file) || std::fs::metadata(file).is_ok_and(|m| !m.is_file()) {
        return Ok(false);
    }
    let mut text = serde_json::to_string_pretty(note)
        .map_err(|e| Error::bad(Place::default(), e.to_string(), "values that JSON can hold"))?;
    text.push('\n');
    write_whole(&note_path(file), text.as_bytes())?;
    Ok(true)
}

/// Reads the note of a file; `None`: there is none, or it is none of ours.
pub fn read_note(file: &Path) -> Option<Note> {
    let note = serde_json::from_slice::<Note>(&std::fs::read(note_path(file)).ok()?).ok()?;
    (note.schema == SCHEMA).then_some(note)
}

/// One word for the SHA-256 of all files of a program: a program is known by all of them, as a change may stand in one alone.
pub fn together<'a>(hashes: impl Iterator<Item = &'a String>) -> String {
    hashes.map(String::as_str).collect::<Vec<_>>().join("+")
}

/// SHA-256 of the files that were rewritten, folder by folder, each folder read once.
#[derive(Debug, Default)]
pub struct Notes {
    folders: Mutex<HashMap<PathBuf, Arc<Vec<String>>>>,
}

impl Notes {
    /// As the notes in the folder of `input` have it.
    pub fn beside(&self, input: &Path) -> Arc<Vec<String>> {
        if is_stdio(input) {
            return Arc::default();
        }
        let folder = match input.parent() {
            Some(p) if !p.as_os_str().is_empty() => p,
            _ => Path::new("."),
        };
        // a thread that failed while it read leaves at most a folder unread
        let mut folders = self.folders.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = folders.get(folder) {
            return Arc::clone(known);
        }
        let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(|e| e.ok().map(|e| e.path()));
        let read = |p: PathBuf| serde_json::from_slice::<Note>(&std::fs::read(p).ok()?).ok();
        let notes = entries.filter(|p| is_note(p)).filter_map(read).filter(|n| n.schema == SCHEMA);
        let whole =
            |n: Note| together(std::iter::once(&n.sha256_out).chain(n.companions.iter().map(|c| &c.sha256_out)));
        let found: Arc<Vec<String>> = Arc::new(notes.map(whole).collect());
        folders.insert(folder.to_path_buf(), Arc::clone(&found));
        found
    }
}

const ALREADY: &str = "a program that has been rewritten already";

/// The refusal.
pub fn already(name: &str, how: &str) -> Error {
    Error::bad(
        Place::file(name),
        format!("{ALREADY} ({how})"),
        "the original program (--force rewrites it all the same)",
    )
}

/// Whether an error is this refusal.
pub fn is_already(e: &Error) -> bool {
    matches!(e, Error::BadInput(b) if b.found.starts_with(ALREADY))
}

/// Fewest reversals on which a judgement rests, and the share of them that must look made.
const LEAST_TURNS: usize = 4;
const SHARE: f64 = 0.8;
/// The step may differ by this share from the compensator's: rounding, a position-dependent gap, another gain.
const STEP_TOLERANCE: f64 = 0.15;
/// The segment that carries the step is at most this share of the one behind it (`--step-fraction` 0.1 makes it 0.11).
const SHORT: f64 = 0.35;
/// Its share of both differs by at most this from the fraction, or is about that of the nearest place on a long leg: corners
/// and turns of a program are short as well, but of their own length.
const FRACTION_TOLERANCE: f64 = 0.03;
const NEAREST: f64 = 0.02;
/// A step is a leap where it is more than this many times the steps before and behind it: smooth motion is slow at a reversal.
const LEAP: f64 = 3.0;

/// Whether the targets `q` look like an output of this compensator: counts the reversals of the compensated axes, and those
/// whose next segment is short and carries the compensator's step.
pub fn looks_rewritten(q: &[f64], axes: usize, compensator: &Compensator, options: &Options) -> bool {
    let rows = q.len().checked_div(axes).unwrap_or(0);
    let (mut turns, mut made) = (0, 0);
    for joint in compensator.joints.iter().filter(|j| j.axis < axes) {
        let Some([least, most]) = step(joint) else { continue };
        let a = joint.axis;
        let deadband = options.deadband.get(a).copied().unwrap_or(0.0);
        let p = |i: usize| q[i * axes + a];
        for i in 1..rows.saturating_sub(2) {
            let (before, after) = (p(i) - p(i - 1), p(i + 1) - p(i));
            if before * after >= 0.0 || before.abs().min(after.abs()) <= deadband {
                continue;
            }
            turns += 1;
            let behind = |k: usize| (i + k + 1 < rows).then(|| (p(i + k + 1) - p(i + k)).abs());
            let others = |i: usize| -> f64 {
                (0..axes).filter(|&k| k != a).map(|k| (q[(i + 1) * axes + k] - q[i * axes + k]).abs()).sum()
            };
            let (short, long) = (others(i), others(i + 1));
            let size = |own: f64, behind: f64| {
                own >= least * (1.0 - STEP_TOLERANCE) && own <= most * (1.0 + STEP_TOLERANCE) + SHORT * behind
            };
            let carries_step = behind(1).is_some_and(|behind| {
                let own = after.abs();
                let (part, rest) = if long > most { (short, long) } else { ((own - most).max(0.0), behind) };
                let share = part / (part + rest).max(f64::MIN_POSITIVE);
                let off = share - options.step_fraction;
                // points of a friction that fades cut the rest short
                let fits = off.abs() < FRACTION_TOLERANCE || share < NEAREST || joint.friction.is_some() && off > 0.0;
                size(own, behind) && part < SHORT * rest && fits
            });
            // a program with dense points has no short segments; there the step stands out among its neighbours, also
            // where a point that another joint or the path asked for cuts it in two
            let leaps = (1..=2).any(|k| {
                let Some(behind) = behind(k) else { return false };
                let own = (p(i + k) - p(i)).abs();
                size(own, behind) && own > LEAP * before.abs().max(behind)
            });
            if carries_step || leaps {
                made += 1;
            }
        }
    }
    turns >= LEAST_TURNS && made as f64 >= SHARE * turns as f64
}

/// Smallest and largest step at a reversal, rad or m; `None`: too small to be told from anything else.
fn step(joint: &JointCompensator) -> Option<[f64; 2]> {
    let gap = joint.backlash.as_ref().map_or([0.0, 0.0], |b| {
        [b.positive.smallest() + b.negative.smallest(), b.positive.largest() + b.negative.largest()]
    });
    let friction = joint.friction.map_or(0.0, |f| f.gain);
    if friction < 0.0 {
        return None; // it builds up; there is no step
    }
    let [least, most] = [gap[0], gap[1] + friction];
    (least > 0.0).then_some([least, most])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensator::{BacklashOffset, Evidence};
    use crate::effects::GapCurve;

    fn compensator(half_gap: f64) -> Compensator {
        let gap = GapCurve::Constant(half_gap);
        let backlash = Some(BacklashOffset { positive: gap.clone(), negative: gap });
        Compensator {
            robot_name: String::new(),
            robot_sha256: String::new(),
            joints: vec![JointCompensator { axis: 0, backlash, friction: None }],
            evidence: Evidence::default(),
        }
    }

    /// Two axes on a circle of 100 points a turn; with `half_gap`, as a rewrite leaves it.
    fn circle(half_gap: f64) -> Vec<f64> {
        arc(half_gap, 0.0628)
    }

    /// 1,000 points, `step` rad apart.
    fn arc(half_gap: f64, step: f64) -> Vec<f64> {
        let at = |i: f64| [(i * step + 0.01).cos(), (i * step + 0.01).sin()];
        let mut q = Vec::new();
        let mut dir = -1.0;
        for i in 0..1000 {
            let [x, y] = at(f64::from(i));
            let next = at(f64::from(i + 1));
            q.extend([x + dir * half_gap, y]);
            let to = (next[0] - x).signum();
            if to != dir {
                dir = to;
                if half_gap > 0.0 {
                    q.extend([x + 0.1 * (next[0] - x) + dir * half_gap, y + 0.1 * (next[1] - y)]);
                }
            }
        }
        q
    }

    #[test]
    fn a_rewritten_program_is_known_by_its_reversals() {
        let options = Options::new(2);
        assert!(looks_rewritten(&circle(5e-4), 2, &compensator(5e-4), &options));
        assert!(!looks_rewritten(&circle(0.0), 2, &compensator(5e-4), &options));
    }

    /// Face milling: straights of 30 mm along one axis, joined by half circles of 1.5 mm in front of each.
    #[test]
    fn turns_of_a_program_that_are_short_as_they_are_do_not_look_made() {
        let mut q = Vec::new();
        for k in 0..20 {
            let (x, sign) = (if k % 2 == 0 { 0.0 } else { 0.03 }, if k % 2 == 0 { 1.0 } else { -1.0 });
            let y = 0.003 * f64::from(k);
            q.extend([x - sign * 0.0015, y - 0.0015, x, y, x + sign * 0.03, y]);
        }
        assert!(!looks_rewritten(&q, 2, &compensator(2.2e-5), &Options::new(2)));
    }

    #[test]
    fn a_step_at_the_nearest_place_of_a_long_leg_is_known() {
        let (b, mut q) = (3.5e-4, Vec::new());
        for k in 0..20 {
            let (x, sign) = if k % 2 == 0 { (0.0, 1.0) } else { (0.5, -1.0) };
            q.extend([x - sign * b, 0.0, x + sign * (0.01 * 0.5 + b), 0.0]);
        }
        assert!(looks_rewritten(&q, 2, &compensator(b), &Options::new(2)));
    }

    #[test]
    fn where_points_are_dense_the_step_stands_out_among_its_neighbours() {
        let options = Options::new(2);
        assert!(looks_rewritten(&arc(5e-4, 0.014), 2, &compensator(5e-4), &options));
        assert!(!looks_rewritten(&arc(0.0, 0.014), 2, &compensator(5e-4), &options));
    }

    #[test]
    fn even_where_the_steps_of_the_program_are_as_large_as_the_gap_the_original_passes() {
        let q = circle(0.0);
        // the first segment behind a reversal is about half of 0.0628^2 / 2
        for gap in [2e-4, 5e-4, 1e-3, 2e-3] {
            assert!(!looks_rewritten(&q, 2, &compensator(gap), &Options::new(2)), "{gap}");
        }
    }
}
