//! On which side of its gap a joint stands when the log begins: the preload of Gantry (2015) Figure 4.
//!
//! The procedure moves below the start of the test and then towards it, so that the gap lies to one side only. A log that holds this
//! move begins with a short stroke that crosses the gap; a log that was started above it stands on a flank already. Else
//! the start's side is unknown: where the joint stood in its gap is reported as far as the rows show it, and the way up to the first
//! flank is left out like that after every reversal.

use super::flanks::Flanks;
use super::strokes::Strokes;
pub use crate::gaps::note::screw::Start;

/// A first stroke below this part of the longest is a preload.
const PRELOAD: f64 = 0.5;
/// Part of the gap that the first rows may have crossed.
const STILL: f64 = 0.15;
/// A place in the gap that is not known to this part of it is not known.
const UNSURE: f64 = 0.15;
/// Standard errors around a flank.
const NEAR: f64 = 3.0;

impl Start {
    /// Side of the flank, -1 or 1; `None`: not known.
    pub fn side(self) -> Option<i8> {
        match self {
            Self::Move(d) | Self::Flank(d) => Some(d),
            _ => None,
        }
    }
}

/// Reads the start of a log; `from` is the way into a stroke at which the gap is closed.
pub fn of(strokes: &Strokes, input: &[Option<f64>], output: &[Option<f64>], flanks: &Flanks, from: f64) -> Start {
    let first = strokes.length.first().copied().unwrap_or(0.0);
    if strokes.dir.len() > 1 && first >= from && first < PRELOAD * strokes.longest() {
        return Start::Move(strokes.dir[0]);
    }
    let (m, gap) = (flanks.slope.value, flanks.total.value);
    let still = (0..strokes.travel.len())
        .take_while(|&i| strokes.stroke[i] == 0 && strokes.travel[i] <= STILL * gap.abs())
        .filter_map(|i| Some(output[i]? / m - (input[i]? - flanks.c_r.value)))
        .collect::<Vec<f64>>();
    let n = still.len() as f64;
    let error = flanks.rms / n.sqrt();
    if still.is_empty() || error.is_nan() || error > UNSURE * gap {
        return Start::Unknown;
    }
    let place = still.iter().sum::<f64>() / n / gap;
    let near = (NEAR * error / gap).max(0.05);
    match place {
        p if p.abs() <= near => Start::Flank(1),
        p if (p - 1.0).abs() <= near => Start::Flank(-1),
        p => Start::Inside(p),
    }
}
