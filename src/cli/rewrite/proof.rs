//! What the rewritten program does on the machine that its offsets rest on: the verdict of `assess program`.
//!
//! With a model the machine is that model. With a compensator that has evidence it is the robot with the compensator's own
//! gaps and friction (a measured response, too: stictions that build up, gap, hystereses): the verdict then says whether the
//! offsets do on this program what they are meant to do (chords between far points, offsets that fade over too few points,
//! steps at the wrong place show here).

use super::Args;
use super::job::Source;
use crate::assess::program::document::{MovesShown, ReversalShown};
use crate::assess::program::{self, Assessment, Figures, Note, ReversalError, Verdict, document};
use crate::cli::page::rewrite::Shown;
use crate::compensator::Predicted;
use crate::error::is_stdio;
use crate::io::input;
use crate::model::Model;
use crate::numerics::robust::median_of;
use crate::rewrite::batch::Texts;
use crate::rewrite::job::Job;
use crate::rewrite::outcome::{self, Outcome, Ready};
use crate::rewrite::script::path::Reading;
use crate::rewrite::summary::{BeforeAfter, PathErrors};
use crate::robot::Robot;
use crate::simulate;
use serde::Serialize;
use std::path::Path;

/// Points of a program up to which the verdict is worked out: it runs the program three times.
const MOST_POINTS: u64 = 20_000;

/// Growth of the largest path error that lost motion and its compensation cannot cause: a step that comes too late or too early doubles
/// the error, a misread frame or start multiplies it by hundreds.
const ASTRAY_TIMES: f64 = 10.0;
/// Least error before the change that this growth refers to, m: a program in which hardly any joint reverses has almost none.
const ASTRAY_FROM_M: f64 = 100e-6;

/// Growth of the rms path error from which on a program is refused: a machine of which one knows the gaps to a tenth or so, and on which
/// the ways between points may differ, does not tell smaller growth from none for certain.
const HARMFUL: f64 = 1.5;

/// The verdict, or why there is none.
pub(super) enum Proof {
    Proven(Box<Proven>),
    None(String),
}

/// Where the error grows in a program that is called worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Concern {
    /// On the way between targets that get no worse.
    Between,
    /// After one reversal, in a path that is better otherwise.
    AfterReversal,
    /// At one place, in a path whose rms falls.
    AtPlace,
    /// All along: nobody should run it.
    Grows,
}

/// A verdict and what it rests on.
pub(super) struct Proven {
    verdict: Verdict,
    figures: Figures,
    /// How much of a vendor program is in it.
    moves: Option<MovesShown>,
    /// The reversal after which the error grows most, as people and as documents show it.
    worst: Option<(String, ReversalShown)>,
    /// Path error to expect of the robot itself, m rms, and why in words.
    expected: Option<(f64, String)>,
    /// Error after each reversal.
    reversals: Vec<ReversalError>,
    notes: Vec<Note>,
}

/// The path error to expect of the robot itself: the machine of the verdict has the very gaps of the compensator, and `identify` predicts
/// what is left beside them (scatter from one reversal to the next, what no log tells), as a share of the error before.
fn expected(predicted: &[Predicted], figures: &Figures) -> Option<(f64, String)> {
    let share = |p: &Predicted| p.after_m / p.before_m;
    let mut shares: Vec<f64> = predicted.iter().filter(|p| p.before_m > 0.0).map(share).collect();
    let usual = median_of(&mut shares)?;
    let nearest = predicted.iter().min_by(|a, b| (share(a) - usual).abs().total_cmp(&(share(b) - usual).abs()))?;
    let rms_m = figures.rms_m[1].hypot(usual * figures.rms_m[0]);
    let (before, after) = (nearest.before_m * 1e6, nearest.after_m * 1e6);
    Some((rms_m, format!("`identify` predicts that {after:.1} of {before:.1} um are left on {}", nearest.log)))
}

/// A pipe gives its text once.
fn can_be_read_again(input: &Path) -> bool {
    !is_stdio(input) && input.is_file()
}

/// Works out the verdict on a program that is about to be put in place in a file.
pub(super) fn of(args: &Args, source: &Source, job: &Job, ready: &mut Ready) -> Option<Proof> {
    let outcome = &ready.outcome;
    outcome.output.as_ref()?;
    if outcome.unchanged || outcome.refusal.is_some() || !can_be_read_again(&args.input) {
        return None;
    }
    if source.machine.is_some() && !ready.is_regular() {
        return Some(Proof::None("the program goes to standard output or a pipe".into()));
    }
    of_texts(args, source, job, (&args.input, outcome.points), &mut || ready.texts())
}

/// The same of the program at `original`, of so many points, and of what is written instead.
pub(super) fn of_texts(
    args: &Args,
    source: &Source,
    job: &Job,
    (original, points): (&Path, u64),
    texts: &mut dyn FnMut() -> crate::error::Result<Texts>,
) -> Option<Proof> {
    let Some(model) = source.machine.as_ref() else {
        let counted = source.compensator.is_measured() && source.compensator.counts_points();
        return counted.then(|| Proof::None("its friction is counted in points, which describes no machine".into()));
    };
    if points > MOST_POINTS {
        return Some(Proof::None(format!("more than {MOST_POINTS} points; `assess program` compares them")));
    }
    let speed = args.speed_mm_s.map(|v| v * 1e-3).or(source.compensator.evidence.tcp_speed_m_s);
    let options = program::Options {
        speed_m_s: speed.unwrap_or(simulate::Options::default().speed_m_s),
        at_speed: args.speed_mm_s.is_some(),
    };
    let reading =
        Reading { robot: &source.robot, frames: &job.choices.frames, tcp_speed_m_s: speed, format: job.format };
    let assessed = input::read(original).and_then(|bytes| {
        let before = reading.load(original, bytes)?;
        let after = reading.written(original, texts()?)?;
        // the joints come from the sides that the offsets of the first targets are for
        let model = Model { initial_gap_side: job.options.initial_direction.clone(), ..model.clone() };
        program::assess(&model, &program::Source::Program(&before), &program::Source::Program(&after), &options)
    });
    Some(match assessed {
        Ok(a) => Proof::Proven(Box::new(Proven::of(&a, &source.robot, &source.compensator.evidence.predicted))),
        Err(e) => Proof::None(crate::error::one_line(&e.to_string())),
    })
}

/// The verdict of a dry run: the program is rewritten once more in a separate folder, which goes away.
pub(super) fn of_plan(args: &Args, source: &Source, job: &Job, planned: &Outcome) -> Option<Proof> {
    let whole = !planned.unchanged && planned.refusal.is_none() && can_be_read_again(&args.input);
    if !whole || source.machine.is_none() || planned.points > MOST_POINTS {
        return None;
    }
    let folder = match tempfile::Builder::new().prefix("lostmotion-plan-").tempdir() {
        Ok(folder) => folder,
        Err(e) => return Some(Proof::None(format!("no temporary folder: {e}"))),
    };
    let name = args.input.file_name()?;
    match job.prepare(&args.input, outcome::Target::File(&folder.path().join(name)), &|_| {}) {
        Ok(mut ready) => of(args, source, job, &mut ready),
        Err(e) => Some(Proof::None(crate::error::one_line(&e.to_string()))),
    }
}

impl Proven {
    fn of(assessed: &Assessment, robot: &Robot, predicted: &[Predicted]) -> Self {
        let worst = assessed.worst_reversal().map(|r| {
            let joint = robot.axis(r.axis);
            let at = joint.kind.to_user_unit(r.command);
            let words = format!(
                "{} at {at:.3} {}: {:.1} -> {:.1} um",
                joint.name,
                joint.kind.unit(),
                r.before_m * 1e6,
                r.after_m * 1e6
            );
            (words, document::reversal(r, robot))
        });
        Self {
            verdict: assessed.verdict,
            figures: assessed.figures,
            moves: assessed.moves.map(MovesShown::of),
            worst,
            expected: expected(predicted, &assessed.figures),
            reversals: assessed.reversals.clone(),
            notes: assessed.notes.clone(),
        }
    }

    /// What of a verdict `worse` concerns the user.
    fn concern(&self) -> Option<Concern> {
        let f = &self.figures;
        let falls = f.rms_m[1] < f.rms_m[0];
        if self.verdict != Verdict::Worse {
            return None;
        }
        Some(match f.at_targets {
            Some(targets) if targets.verdict() != Verdict::Worse => Concern::Between,
            _ if falls && f.largest_m[1] <= f.largest_m[0] => Concern::AfterReversal,
            _ if falls => Concern::AtPlace,
            _ => Concern::Grows,
        })
    }

    /// Parts of the program that are not in the verdict, and what was assumed.
    fn limits(&self) -> String {
        // the first move of a program always starts where nobody knows
        let partly = self.moves.filter(|m| m.in_verdict + 1 < m.all);
        let expected = self.expected.as_ref();
        let expected =
            expected.map(|(rms_m, why)| format!("expect about {:.1} um rms from the robot itself: {why}", rms_m * 1e6));
        let lines = partly.map(|m| m.text()).into_iter().chain(expected).chain(self.notes.iter().map(Note::to_string));
        lines.map(|line| format!("  about the verdict: {line}\n")).collect()
    }
}

/// `path_error` of the document: the figures and the verdict, or why there are none.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub(super) enum PathError {
    Known {
        #[serde(flatten)]
        figures: Box<document::FiguresShown>,
        verdict: &'static str,
        /// How much of a vendor program is in the verdict.
        #[serde(skip_serializing_if = "Option::is_none")]
        moves: Option<MovesShown>,
        /// The reversal after which the error grows most.
        worst_reversal: Option<Box<ReversalShown>>,
        /// Path error to expect of the robot itself, um rms.
        #[serde(skip_serializing_if = "Option::is_none")]
        expected_rms_um: Option<f64>,
        notes: Vec<Note>,
    },
    Unknown {
        /// Null.
        verdict: (),
        reason: String,
    },
}

impl Proof {
    /// For standard error.
    ///
    /// `vendor`: the program is none of joint rows, so its path is not made denser. `clocked`: its cycle time stands in the summary already.
    pub(super) fn words(&self, of_model: bool, vendor: bool, clocked: bool) -> String {
        let machine = machine(of_model);
        match self {
            Self::None(why) => format!("  verdict: not computed ({why})\n"),
            Self::Proven(proven) => {
                let f = &proven.figures;
                let um = |v: f64| v * 1e6;
                let line = format!("  verdict on {machine}: {}\n", f.sentence());
                let cycle = || {
                    let [before, after] = f.cycle_s;
                    format!(
                        "  cycle time on it {before:.1} s before, {after:.1} s after (corners not cut, without waiting)\n"
                    )
                };
                let line = line + &if clocked { String::new() } else { cycle() } + &proven.limits();
                let at = proven.worst.as_ref().map_or(String::new(), |(words, _)| format!(" ({words})"));
                let denser = if vendor { "" } else { "more points near the reversals (--refine cubic or cartesian), " };
                let mended =
                    format!("{denser}a step nearer to the reversal (--step-fraction), or a smaller --gain, may help");
                match proven.concern() {
                    Some(Concern::Between) => format!(
                        "{line}  the error does not grow at the targets, but it grows on the path between them{at}: if only the targets matter (spot work, picking), run the program; if the path matters, check this place before you run it (`assess program` shows where): {mended}\n"
                    ),
                    Some(Concern::AfterReversal) => {
                        let grows = um(f.worst_reversal_growth_m);
                        format!(
                            "{line}  the error is smaller overall, but {grows:.1} um larger after one reversal{at}: check this place before you run the program (`assess program` shows where); {mended}\n"
                        )
                    }
                    Some(Concern::AtPlace) => format!(
                        "{line}  the error is smaller overall, but larger at one place{at}: check this place before you run the program (`assess program` shows where); {mended}\n"
                    ),
                    Some(Concern::Grows) => format!("{line}  do not run this program: {mended}\n"),
                    None => line,
                }
            }
        }
    }

    /// Why the program must not be written: it leaves the path of the given one, or its error grows; `aside`: it goes over points of
    /// approach, which are no error.
    pub(super) fn refused(&self, program: &str, aside: bool) -> Option<String> {
        self.astray(program).or_else(|| self.harmful(program).filter(|_| !aside))
    }

    /// Why the program must not be written: on the machine of the verdict its path error grows at every measure, and by half or more.
    fn harmful(&self, program: &str) -> Option<String> {
        let Self::Proven(proven) = self else { return None };
        let [before, after] = proven.figures.rms_m.map(|v| v * 1e6);
        (proven.concern() == Some(Concern::Grows) && after > HARMFUL * before).then(|| {
            format!(
                "{program}: the path error would grow from {before:.1} to {after:.1} um rms; nothing was written (--force writes the program \
                 to another file)"
            )
        })
    }

    /// The rewritten program leaves the path of the given one.
    fn astray(&self, program: &str) -> Option<String> {
        let Self::Proven(proven) = self else { return None };
        let [before, after] = proven.figures.largest_m;
        (after > ASTRAY_TIMES * before.max(ASTRAY_FROM_M)).then(|| {
            format!(
                "{program}: the rewritten program leaves the path by {:.1} mm (the given one by {:.3} mm), which no compensation \
                 explains; nothing was written. Please check frames, tools and the robot file (--force writes the program to another file)",
                after * 1e3,
                before * 1e3
            )
        })
    }

    /// For `--json`.
    pub(super) fn document(&self) -> PathError {
        match self {
            Self::None(why) => PathError::Unknown { verdict: (), reason: why.to_string() },
            Self::Proven(p) => PathError::Known {
                figures: Box::new(document::figures(&p.figures)),
                verdict: p.verdict.text(),
                moves: p.moves,
                worst_reversal: p.worst.as_ref().map(|(_, shown)| Box::new(shown.clone())),
                expected_rms_um: p.expected.as_ref().map(|e| e.0 * 1e6),
                notes: p.notes.clone(),
            },
        }
    }

    /// For the line of a program of a folder.
    pub(super) fn of_line(&self) -> PathErrors {
        match self {
            Self::None(why) => PathErrors {
                verdict: None,
                rms_um: None,
                largest_um: None,
                reason: Some(why.to_string()),
                worse: false,
            },
            Self::Proven(p) => {
                let um = |pair: [f64; 2]| {
                    let [before, after] = pair.map(|v| (v * 1e7).round() / 10.0);
                    Some(BeforeAfter { before, after })
                };
                PathErrors {
                    verdict: Some(p.verdict.text()),
                    rms_um: um(p.figures.rms_m),
                    largest_um: um(p.figures.largest_m),
                    reason: None,
                    worse: p.verdict == Verdict::Worse,
                }
            }
        }
    }

    /// For the page.
    pub(super) fn shown(&self, of_model: bool) -> Option<Shown<'_>> {
        match self {
            Self::Proven(p) => Some(Shown {
                machine: machine(of_model),
                figures: &p.figures,
                expected_m: p.expected.as_ref().map(|e| e.0),
                measured: of_model || p.expected.is_some(),
                reversals: &p.reversals,
            }),
            Self::None(_) => None,
        }
    }
}

/// The machine of a verdict.
fn machine(of_model: bool) -> &'static str {
    if of_model { "the model's machine" } else { "a machine with the compensator's gaps and friction" }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn proof(largest_m: [f64; 2]) -> Proof {
        let figures = Figures {
            rms_m: [1e-6; 2],
            mean_m: [1e-6; 2],
            largest_m,
            cycle_s: [1.0; 2],
            points: [5, 6],
            stops: [1; 2],
            worst_reversal_growth_m: 0.0,
            at_targets: None,
        };
        let (verdict, reversals, notes) = (Verdict::Worse, Vec::new(), Vec::new());
        Proof::Proven(Box::new(Proven { verdict, figures, moves: None, worst: None, expected: None, reversals, notes }))
    }

    #[test]
    fn a_program_that_leaves_its_path_is_refused() {
        // a new point that went without its base
        let why = proof([120e-6, 49.5e-3]).astray("weld.src").unwrap();
        assert!(why.contains("weld.src") && why.contains("49.5 mm") && why.contains("nothing was written"), "{why}");
        assert!(proof([2e-6, 1.1e-3]).astray("weld.src").is_some());
    }

    #[test]
    fn a_program_whose_error_grows_all_along_is_refused_and_one_that_is_worse_at_one_place_is_not() {
        let of = |rms_m: [f64; 2], largest_m: [f64; 2]| {
            let Proof::Proven(mut p) = proof(largest_m) else { return None };
            p.figures.rms_m = rms_m;
            Proof::Proven(p).refused("weave.json", false)
        };
        let why = of([154e-6, 241e-6], [315e-6, 543e-6]).unwrap();
        assert!(why.contains("weave.json") && why.contains("154.0 to 241.0 um") && why.contains("--force"), "{why}");
        assert_eq!(of([154e-6, 41e-6], [315e-6, 543e-6]), None);
        assert_eq!(of([154e-6, 41e-6], [315e-6, 300e-6]), None);
    }

    #[test]
    fn steps_at_the_wrong_place_are_a_verdict_and_no_refusal() {
        for largest_m in [[90e-6, 220e-6], [1e-6, 0.9e-3], [0.5e-3, 4.9e-3], [134e-6, 92e-6]] {
            assert_eq!(proof(largest_m).astray("weld.src"), None, "{largest_m:?}");
        }
        assert_eq!(Proof::None("more than 20000 points".into()).astray("weld.src"), None);
    }
}
