//! How far into a stroke every gap before an output is surely closed.
//!
//! Method: flanks are fitted to the far part of the strokes; where the lost motion that they give is smaller than the way that was left
//! out, the guess holds, and a quarter more than that lost motion is left out from then on. A lag that the fit knows
//! nothing of makes the lost motion look larger, and the way that is left out longer: the safe side.

use super::flanks::{Flanks, Missing, Pair, fit};
use super::strokes::Strokes;
use crate::gaps::note::screw::Short;

/// Parts of a stroke that are left out at first, in the order tried, and by how much that must exceed the lost motion.
const TRIES: [(f64, f64); 3] = [(0.5, 1.1), (0.75, 1.1), (0.9, 1.02)];
/// Way left out, over the lost motion.
const BEYOND: f64 = 1.25;
/// Output per input below which the output does not follow.
const STANDS: f64 = 0.2;
/// Strokes of a direction that should be long enough.
const STROKES: usize = 3;
/// Way (m or rad) over which an output that does not follow is no matter of a gap: twice the catalogue's largest half gap.
const NO_GAP: [f64; 2] = [0.2, 0.02];

/// Way into a stroke from which on rows count for `output`.
pub fn reach(cmd: &[Option<f64>], output: &[Option<f64>], strokes: &Strokes, revolute: bool) -> Result<f64, Short> {
    let mut way = f64::INFINITY;
    for dir in [1, -1] {
        let mut lengths: Vec<f64> =
            strokes.length.iter().zip(&strokes.dir).filter(|(_, d)| **d == dir).map(|(l, _)| *l).collect();
        lengths.sort_by(|a, b| b.total_cmp(a));
        let Some(&long) = lengths.get(STROKES.min(lengths.len()).saturating_sub(1)) else { return Err(Short::OneWay) };
        way = way.min(long);
    }
    let from = |part: f64| Pair { t_s: &[], input: cmd, output, strokes, from: part * way, with_lag: false };
    let mut last: Result<Flanks, Missing> = Err(Missing::TooShort);
    for (part, above) in TRIES {
        last = fit(&from(part));
        let Ok(found) = &last else { continue };
        let m = found.slope.value;
        if (STANDS..=1.0 / STANDS).contains(&m) && above * found.total.value.abs() <= part * way {
            let unsure = found.total.ci95[1] - found.total.value;
            return Ok((BEYOND * found.total.value.abs() + unsure).min(part * way));
        }
    }
    let hardly = || Short::HardlyCrossed { way, longest: strokes.longest() };
    // the whole of the strokes tells whether the output moves at all
    let Ok(all) = fit(&Pair { from: 0.0, ..from(0.0) }) else {
        return Err(if last.is_err() { Short::Rows } else { hardly() });
    };
    let m = all.slope.value;
    let no_gap = NO_GAP[usize::from(!revolute)];
    Err(if m.abs() >= STANDS && !(STANDS..=1.0 / STANDS).contains(&m) {
        Short::Slope(m)
    } else if m.abs() < STANDS && way > no_gap {
        if m.abs() > 1e-4 && all.slope.excludes(0.0) && all.slope.ci95[1] - m < 0.1 * m.abs() {
            Short::Slope(m)
        } else {
            Short::Dead { way }
        }
    } else if m.abs() < STANDS {
        Short::NeverCrossed { way }
    } else {
        hardly()
    })
}
