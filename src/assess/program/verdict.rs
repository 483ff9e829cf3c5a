//! Better, unchanged or worse: one function for `assess program` and `rewrite`.
//!
//! Worse: the largest error, the rms, or the largest error after any reversal grows by more than rounding and simulation
//! explain. Better: the rms falls and nothing grows. A program whose largest error grows is never better.
//!
//! The same is computed for the targets of a vendor program alone ([`AtTargets`]). Of both answers the worse one is that of the program:
//! worse where either is, else better where either is. Where they differ, the sentence reports both.

use super::{ReversalError, Run};

/// Growth of the rms or the largest error that means nothing: share, and m.
const SHARE: f64 = 0.01;
const LEAST_M: f64 = 0.5e-6;
/// An rms that falls by less than is printed has not fallen, m: the path of a joint that moves to and fro alone is never left.
const LEAST_FALL_M: f64 = 0.05e-6;
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

/// The figures that a verdict is based on; pairs are before and after, m or s.
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
    /// At the targets of a vendor program, where it has some that stand apart.
    pub at_targets: Option<AtTargets>,
}

/// Errors at the targets of a vendor program, before and after, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtTargets {
    pub targets: usize,
    pub rms_m: [f64; 2],
    pub largest_m: [f64; 2],
}

impl AtTargets {
    /// Of the error of each target, before and after, m; `None` of no target.
    pub fn of(errors_m: &[[f64; 2]]) -> Option<Self> {
        let column = |k: usize| errors_m.iter().map(move |e| e[k]);
        let rms = |k: usize| (column(k).map(|e| e * e).sum::<f64>() / errors_m.len() as f64).sqrt();
        let largest = |k: usize| column(k).fold(0.0, f64::max);
        let (rms_m, largest_m) = ([rms(0), rms(1)], [largest(0), largest(1)]);
        (!errors_m.is_empty()).then_some(Self { targets: errors_m.len(), rms_m, largest_m })
    }

    /// The verdict on the targets alone.
    pub fn verdict(&self) -> Verdict {
        change(self.rms_m, self.largest_m)
    }
}

impl Figures {
    pub fn of(before: &Run, after: &Run, reversals: &[ReversalError], at_targets: Option<AtTargets>) -> Self {
        Self {
            rms_m: [before.rms_m, after.rms_m],
            mean_m: [before.mean_m, after.mean_m],
            largest_m: [before.largest_m, after.largest_m],
            cycle_s: [before.cycle_s, after.cycle_s],
            points: [before.points, after.points],
            stops: [before.stops, after.stops],
            worst_reversal_growth_m: reversals.iter().map(|r| r.after_m - r.before_m).fold(0.0, f64::max),
            at_targets,
        }
    }

    /// The verdict on the whole way, targets and what lies between them.
    pub fn on_the_way(&self) -> Verdict {
        if self.worst_reversal_growth_m > REVERSAL_M { Verdict::Worse } else { change(self.rms_m, self.largest_m) }
    }

    /// Verdict and errors in words, without a full stop.
    pub fn sentence(&self) -> String {
        let um = |[before, after]: [f64; 2]| format!("{:.1} -> {:.1} um", before * 1e6, after * 1e6);
        let path = format!("rms {}, largest {}", um(self.rms_m), um(self.largest_m));
        let (way, all) = (self.on_the_way(), judge(self));
        let Some(at) = &self.at_targets else { return format!("{}: path error {path}", all.text()) };
        let targets = format!("rms {}, largest {}", um(at.rms_m), um(at.largest_m));
        let grade = |v: Verdict| match v {
            Verdict::Better => "better",
            Verdict::Unchanged => "no better",
            Verdict::Worse => "worse",
        };
        // the path as a whole may gain where one place of it loses
        let one_place = way == Verdict::Worse && change(self.rms_m, self.largest_m) != Verdict::Worse;
        let on_the_way = |between: &str| match one_place {
            true => format!(
                "worse after one reversal on the way{between} ({:.1} um more there; {path})",
                self.worst_reversal_growth_m * 1e6
            ),
            false => format!("{} on the way{between} ({path})", grade(way)),
        };
        match at.verdict() {
            same if same == way && !one_place => format!("{}: path error {path}; at the targets {targets}", all.text()),
            // the word of the whole program comes first
            here if here == all => {
                format!("{} at the targets ({targets}), {}", grade(here), on_the_way(" between them"))
            }
            here => format!("{}, {} at the targets ({targets})", on_the_way(""), grade(here)),
        }
    }
}

/// What became of an error, by its rms and its largest, before and after.
fn change(rms_m: [f64; 2], largest_m: [f64; 2]) -> Verdict {
    let grows = |[before, after]: [f64; 2]| after > before * (1.0 + SHARE) + LEAST_M;
    let falls = |[before, after]: [f64; 2]| before - after > (before * SHARE).max(LEAST_FALL_M);
    if grows(largest_m) || grows(rms_m) {
        Verdict::Worse
    } else if falls(rms_m) {
        Verdict::Better
    } else {
        Verdict::Unchanged
    }
}

/// The verdict on the figures.
pub fn judge(f: &Figures) -> Verdict {
    let both = [Some(f.on_the_way()), f.at_targets.as_ref().map(AtTargets::verdict)];
    let any = |v: Verdict| both.contains(&Some(v));
    [Verdict::Worse, Verdict::Better].into_iter().find(|v| any(*v)).unwrap_or(Verdict::Unchanged)
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
            at_targets: None,
        }
    }

    #[test]
    fn a_smaller_rms_does_not_excuse_a_larger_peak_or_a_reversal_that_grew() {
        assert_eq!(judge(&figures([50e-6, 10e-6], [100e-6, 40e-6], 0.0)), Verdict::Better);
        assert_eq!(judge(&figures([50e-6, 10e-6], [100e-6, 103e-6], 0.0)), Verdict::Worse);
        assert_eq!(judge(&figures([50e-6, 10e-6], [100e-6, 40e-6], 6e-6)), Verdict::Worse);
        assert_eq!(judge(&figures([50e-6, 50e-6], [100e-6, 100e-6], 0.0)), Verdict::Unchanged);
        assert_eq!(judge(&figures([50e-6, 60e-6], [100e-6, 100e-6], 0.0)), Verdict::Worse);
        assert_eq!(judge(&figures([0.02e-6, 0.001e-6], [0.04e-6, 0.002e-6], 0.0)), Verdict::Unchanged);
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
            at_targets: None,
        };
        assert_eq!(judge(&coarse), Verdict::Worse);
    }

    #[test]
    fn targets_and_the_way_between_them_have_a_word_each() {
        let with = |targets: [f64; 2], way: [f64; 2]| {
            let at_targets = AtTargets::of(&[targets, targets.map(|e| 0.5 * e)]);
            let f = Figures { at_targets, ..figures(way, way, 0.0) };
            (judge(&f), f.sentence())
        };
        let (verdict, words) = with([72e-6, 9e-6], [80e-6, 79.9e-6]);
        assert_eq!(verdict, Verdict::Better);
        let targets = "rms 56.9 -> 7.1 um, largest 72.0 -> 9.0 um";
        let way = "rms 80.0 -> 79.9 um, largest 80.0 -> 79.9 um";
        assert_eq!(words, format!("better at the targets ({targets}), no better on the way between them ({way})"));
        let (verdict, words) = with([72e-6, 9e-6], [80e-6, 120e-6]);
        assert_eq!(verdict, Verdict::Worse);
        assert!(
            words.starts_with("worse on the way (rms 80.0 -> 120.0 um,") && words.contains("better at the targets"),
            "{words}"
        );
        let (verdict, words) = with([9e-6, 20e-6], [80e-6, 30e-6]);
        assert_eq!(verdict, Verdict::Worse);
        assert!(words.starts_with("worse at the targets ("), "{words}");
        let (verdict, words) = with([72e-6, 9e-6], [80e-6, 8e-6]);
        assert!(verdict == Verdict::Better && words.starts_with("better: path error rms 80.0 -> 8.0 um"), "{words}");
        assert!(words.ends_with(&format!("at the targets {targets}")), "{words}");
    }
}
