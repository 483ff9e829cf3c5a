//! Better, unchanged or worse: one function for `assess program` and `rewrite`.
//!
//! Worse: the largest error, the rms, or the largest error after any reversal grows by more than rounding and simulation
//! explain. Better: the rms falls and nothing grows. A program whose largest error grows is never better.

use super::{ReversalError, Run};

/// Growth of the rms or the largest error that means nothing: share, and m.
const SHARE: f64 = 0.01;
const LEAST_M: f64 = 0.5e-6;
/// Growth of a single reversal's error that is worse, m, where the largest error of the path does not grow.
pub const REVERSAL_M: f64 = 5e-6;

/// What the change does to the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Better,
    Unchanged,
    Worse,
}

impl Verdict {
    /// As it stands in documents.
    pub fn text(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Unchanged => "unchanged",
            Self::Worse => "worse",
        }
    }
}

/// The figures that a verdict rests on; pairs are before and after, m or s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    pub rms_m: [f64; 2],
    pub mean_m: [f64; 2],
    pub largest_m: [f64; 2],
    pub cycle_s: [f64; 2],
    pub points: [usize; 2],
    pub stops: [usize; 2],
    /// Most that the error after a single reversal grew.
    pub worst_reversal_growth_m: f64,
}

impl Figures {
    pub fn of(before: &Run, after: &Run, reversals: &[ReversalError]) -> Self {
        Self {
            rms_m: [before.rms_m, after.rms_m],
            mean_m: [before.mean_m, after.mean_m],
            largest_m: [before.largest_m, after.largest_m],
            cycle_s: [before.cycle_s, after.cycle_s],
            points: [before.points, after.points],
            stops: [before.stops, after.stops],
            worst_reversal_growth_m: reversals.iter().map(|r| r.after_m - r.before_m).fold(0.0, f64::max),
        }
    }
}

/// The verdict on the figures.
pub fn judge(f: &Figures) -> Verdict {
    let grows = |[before, after]: [f64; 2]| after > before * (1.0 + SHARE) + LEAST_M;
    let falls = |[before, after]: [f64; 2]| after < before * (1.0 - SHARE);
    if grows(f.largest_m) || grows(f.rms_m) || f.worst_reversal_growth_m > REVERSAL_M {
        Verdict::Worse
    } else if falls(f.rms_m) {
        Verdict::Better
    } else {
        Verdict::Unchanged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(rms: [f64; 2], largest: [f64; 2], reversal: f64) -> Figures {
        Figures {
            rms_m: rms,
            mean_m: rms,
            largest_m: largest,
            cycle_s: [1.0; 2],
            points: [2; 2],
            stops: [0; 2],
            worst_reversal_growth_m: reversal,
        }
    }

    #[test]
    fn a_smaller_rms_does_not_excuse_a_larger_peak_or_a_reversal_that_grew() {
        assert_eq!(judge(&figures([50e-6, 10e-6], [100e-6, 40e-6], 0.0)), Verdict::Better);
        assert_eq!(judge(&figures([50e-6, 10e-6], [100e-6, 103e-6], 0.0)), Verdict::Worse);
        assert_eq!(judge(&figures([50e-6, 10e-6], [100e-6, 40e-6], 6e-6)), Verdict::Worse);
        assert_eq!(judge(&figures([50e-6, 50e-6], [100e-6, 100e-6], 0.0)), Verdict::Unchanged);
        assert_eq!(judge(&figures([50e-6, 60e-6], [100e-6, 100e-6], 0.0)), Verdict::Worse);
    }

    #[test]
    fn a_program_whose_largest_error_grows_is_worse_however_small_its_mean_gets() {
        let coarse = Figures {
            rms_m: [70e-6, 40e-6],
            mean_m: [56e-6, 24e-6],
            largest_m: [119e-6, 181e-6],
            cycle_s: [60.0, 60.1],
            points: [40, 52],
            stops: [0, 0],
            worst_reversal_growth_m: 62e-6,
        };
        assert_eq!(judge(&coarse), Verdict::Worse);
    }
}
