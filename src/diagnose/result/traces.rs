//! What a page draws of a diagnosis: the gap along every log, joint by joint, and what the logs are blind to. SI.
//!
//! Method: the gap of a sample is the distance from the predicted to the measured TCP (root mean square over reflectors, or
//! over joints where only joints were measured), before with the frame alone, after with all that was found. What an effect
//! moves is the difference of the predictions with and without it. Along a joint the residual e is projected on the joint's
//! lever J: `e.J / |J|^2`, an angle; three coordinates cannot give six joints, so errors of other joints show there too, and
//! samples with a short lever are left out, and what was found on other joints is taken off. Medians over bins of position, for each
//! direction of travel. What may hide is every candidate at its smallest detectable size (4.13 standard uncertainties), as the rms that it
//! would move the TCP.

use crate::diagnose::candidates::Candidate;
use crate::diagnose::problem::forward::{LogData, Problem};
use crate::diagnose::problem::layout::{Group, Sensor};
use crate::diagnose::problem::residual::rms;
use crate::diagnose::result::document;
use crate::diagnose::search::outcome::Outcome;
use crate::diagnose::verdict;
use crate::effects::{AfterReversal, Track, catalogue};
use crate::numerics::parallel::ParMap;
use crate::numerics::robust::{quantile_of_sorted, range};
use nalgebra::Vector3;

/// Everything that is drawn.
#[derive(Debug, Clone)]
pub struct Traces {
    /// Gaps are in metres; else in rad or m of the joints that were measured.
    pub points: bool,
    pub logs: Vec<LogTrace>,
    pub joints: Vec<JointTrace>,
    pub hidden: Vec<Hidden>,
}

/// One log, sample by sample (or block by block, where it is long).
#[derive(Debug, Clone, Default)]
pub struct LogTrace {
    pub name: String,
    /// Settled poses: [`Self::at`] counts them.
    pub poses: bool,
    /// Time, s.
    pub at: Vec<f64>,
    pub before: Vec<f64>,
    pub after: Vec<f64>,
    /// What each found effect moves, in the order of the rounds.
    pub effects: Vec<EffectTrace>,
    /// Predicted TCP in the base frame, m; empty where none was measured.
    pub points_m: Vec<Vector3<f64>>,
}

/// One found effect along a log.
#[derive(Debug, Clone, Default)]
pub struct EffectTrace {
    pub moves: Vec<f64>,
    /// Times at which its joint turns (s, or number of the pose) and the new direction, where it acts after reversals.
    pub turns: Vec<(f64, i8)>,
}

/// Medians of the residual along a joint: after is what all that was found leaves, before what it leaves without that on this
/// joint (partial residuals: what was found on other joints does not show on this one).
#[derive(Debug, Clone)]
pub struct JointTrace {
    pub axis: usize,
    /// The joint itself was measured; else its part of the TCP's residual is taken along its lever.
    pub measured: bool,
    /// Something was found on it: before and after differ.
    pub own: bool,
    /// Up, then down.
    pub ways: [Way; 2],
}

/// Medians over bins of position, moving in one direction; rad or m.
#[derive(Debug, Clone, Default)]
pub struct Way {
    pub position: Vec<f64>,
    pub before: Vec<[f64; 3]>,
    pub after: Vec<[f64; 3]>,
}

/// Something that may hide in the logs.
#[derive(Debug, Clone)]
pub struct Hidden {
    pub effect: &'static str,
    pub target: String,
    /// It is among the found ones.
    pub found: bool,
    /// Keys and smallest detectable sizes in the units of the keys; empty where it cannot be seen at all.
    pub sizes: Vec<(String, f64)>,
    /// rms that the detectable size moves, m (rad for joints).
    pub moves: Option<f64>,
}

/// Levers below this part of a joint's longest one say nothing about its angle.
const SHORT_LEVER: f64 = 0.1;
/// Bins over the travel of a joint, at most, and samples in each, at least.
const BINS: usize = 80;
const PER_BIN: usize = 6;

/// The arrays of an outcome.
pub fn of(outcome: &Outcome) -> Traces {
    let p = &outcome.problem;
    let points = p.groups.iter().any(|g| g.sensor.is_length());
    let order: Vec<usize> = document::told_in_order(outcome).into_iter().map(|k| outcome.fit.free[k]).collect();
    let moved: Vec<(usize, Vec<f64>)> = order.par_map(|&i| {
        let placed = &outcome.fit.hypothesis.effects[i];
        let moved = p.difference(&outcome.fit.hypothesis, &outcome.fit.state, std::slice::from_ref(placed), &[], 1.0);
        (i, moved)
    });
    let logs = (0..p.logs.len()).map(|l| log_trace(outcome, l, points, &moved)).collect();
    let joints = (0..p.robot.dof())
        .par_map(|a| {
            let own: Vec<&Vec<f64>> = moved
                .iter()
                .filter(|(i, _)| outcome.fit.hypothesis.effects[*i].axis() == Some(a))
                .map(|m| &m.1)
                .collect();
            joint_trace(outcome, a, &own)
        })
        .into_iter()
        .flatten()
        .collect();
    Traces { points, logs, joints, hidden: hidden(outcome) }
}

/// Groups that tell the gap: reflectors, or joints where there are none.
fn telling(p: &Problem, log: usize, points: bool) -> impl Iterator<Item = &Group> {
    p.groups_of(log).filter(move |g| g.sensor.is_length() == points)
}

/// Root mean square length over the sensors of each sample, in the order of the rows.
fn lengths(p: &Problem, log: usize, points: bool, values: &[f64]) -> Vec<(usize, f64)> {
    let mut all: Vec<(usize, f64)> = Vec::new();
    for g in telling(p, log, points) {
        let (v, n) = (&values[g.range()], g.len());
        all.extend((0..n).map(|b| (g.middle(b), (0..g.dims).map(|c| v[c * n + b].powi(2)).sum::<f64>())));
    }
    all.sort_by_key(|s| s.0);
    let mut out = Vec::new();
    for same in all.chunk_by(|a, b| a.0 == b.0) {
        out.push((same[0].0, (same.iter().map(|s| s.1).sum::<f64>() / same.len() as f64).sqrt()));
    }
    out
}

fn log_trace(outcome: &Outcome, l: usize, points: bool, moved: &[(usize, Vec<f64>)]) -> LogTrace {
    let p = &outcome.problem;
    let log = &p.logs[l];
    let place = |row: usize| if log.log.poses { (row + 1) as f64 } else { log.trajectory.t_s()[row] };
    let values = |v: &[f64]| -> Vec<f64> { lengths(p, l, points, v).into_iter().map(|s| s.1).collect() };
    let before = lengths(p, l, points, &outcome.state_nuisance.residual);
    let tcp = outcome.fit.state.logs[l].points_m.first();
    LogTrace {
        name: log.log.name.clone(),
        poses: log.log.poses,
        at: before.iter().map(|s| place(s.0)).collect(),
        points_m: tcp.filter(|_| points).map_or(Vec::new(), |t| before.iter().map(|s| t[s.0]).collect()),
        before: before.into_iter().map(|s| s.1).collect(),
        after: values(&outcome.fit.state.residual),
        effects: moved.iter().map(|(i, m)| EffectTrace { moves: values(m), turns: turns(outcome, *i, log) }).collect(),
    }
}

/// Reversals of the joint of a found effect, where the effect acts after them.
fn turns(outcome: &Outcome, effect: usize, log: &LogData) -> Vec<(f64, i8)> {
    let placed = &outcome.fit.hypothesis.effects[effect];
    match placed.axis().filter(|_| after_reversals(placed.effect.name()) && !log.log.poses) {
        Some(axis) => log.trajectory.turns(axis).into_iter().map(|(t_s, _, dir)| (t_s, dir)).collect(),
        None => Vec::new(),
    }
}

/// Effects that show after the reversals of their joint.
pub fn after_reversals(effect: &str) -> bool {
    catalogue::find(effect).is_some_and(|e| e.special.after_reversal != AfterReversal::Nothing)
}

/// Position, direction, residual before and after of every sample that tells something about a joint.
fn joint_trace(outcome: &Outcome, axis: usize, own: &[&Vec<f64>]) -> Option<JointTrace> {
    let p = &outcome.problem;
    let after = &outcome.fit.state.residual;
    // the moves are predictions without less predictions with the effect: what is missed grows by their negative
    let mut before = after.clone();
    for moved in own {
        before.iter_mut().zip(*moved).for_each(|(b, m)| *b -= m);
    }
    let measured = p.groups.iter().any(|g| g.sensor == Sensor::Joint(axis));
    let mut samples: [Vec<[f64; 3]>; 2] = [Vec::new(), Vec::new()];
    for (l, log) in p.logs.iter().enumerate() {
        let command = log.trajectory.command(axis);
        let least = 1e-3 * p.robot.axis(axis).kind.si_per_user_unit();
        if log.trajectory.is_stationary(axis) || log.log.travel(axis) <= least {
            continue;
        }
        let track = Track::new(log.trajectory.t_s(), command, 1e-9);
        for g in p.groups_of(l) {
            let (n, at) = (g.len(), g.range());
            let (x, y) = (&before[at.clone()], &after[at]);
            let mut push = |row: usize, before: f64, after: f64| match track.dir[row] {
                1 => samples[0].push([command[row], before, after]),
                -1 => samples[1].push([command[row], before, after]),
                _ => {}
            };
            match g.sensor {
                Sensor::Joint(a) if a == axis => (0..n).for_each(|b| push(g.middle(b), x[b], y[b])),
                Sensor::Reading if !measured => {
                    let Some(reading) = &log.reading else { continue };
                    let jacobian = &outcome.fit.state.logs[l].jacobian[0][axis];
                    let lever = |b: usize| reading.seen(g.middle(b), &jacobian[g.middle(b)]);
                    let longest = (0..n).map(|b| lever(b).abs()).fold(0.0, f64::max);
                    for b in (0..n).filter(|b| lever(*b).abs() > SHORT_LEVER * longest) {
                        push(g.middle(b), x[b] / lever(b), y[b] / lever(b));
                    }
                }
                Sensor::Reflector(0) if !measured => {
                    let levers = &outcome.fit.state.logs[l].jacobian[0][axis];
                    let longest = levers.iter().map(Vector3::norm_squared).fold(0.0, f64::max);
                    for b in 0..n {
                        let row = g.middle(b);
                        let j = levers[row];
                        let square = j.norm_squared();
                        if square > SHORT_LEVER * SHORT_LEVER * longest {
                            let along = |v: &[f64]| Vector3::new(v[b], v[n + b], v[2 * n + b]).dot(&j) / square;
                            push(row, along(x), along(y));
                        }
                    }
                }
                _ => {}
            }
        }
    }
    let [up, down] = &samples;
    if up.is_empty() && down.is_empty() {
        return None;
    }
    let [lo, hi] = range(samples.iter().flatten().map(|s| s[0]));
    let ways = [medians(up, lo, hi), medians(down, lo, hi)];
    Some(JointTrace { axis, measured, own: !own.is_empty(), ways })
}

/// Quartiles over bins of position between `lo` and `hi`.
fn medians(samples: &[[f64; 3]], lo: f64, hi: f64) -> Way {
    let bins = (samples.len() / PER_BIN).clamp(1, BINS);
    let mut sorted: Vec<Vec<[f64; 3]>> = vec![Vec::new(); bins];
    for s in samples {
        let share = if hi > lo { (s[0] - lo) / (hi - lo) } else { 0.0 };
        sorted[((share * bins as f64) as usize).min(bins - 1)].push(*s);
    }
    let mut way = Way::default();
    let least = PER_BIN.min(samples.len());
    for bin in sorted.iter().filter(|b| !b.is_empty() && b.len() >= least / 2) {
        let quartiles = |k: usize| {
            let mut v: Vec<f64> = bin.iter().map(|s| s[k]).collect();
            v.sort_by(f64::total_cmp);
            [0.25, 0.5, 0.75].map(|q| quantile_of_sorted(&v, q).unwrap_or(f64::NAN))
        };
        way.position.push(quartiles(0)[1]);
        way.before.push(quartiles(1));
        way.after.push(quartiles(2));
    }
    way
}

/// Blind spots with what their detectable size moves, then the found effects of the same kinds.
fn hidden(outcome: &Outcome) -> Vec<Hidden> {
    let p = &outcome.problem;
    let mut all: Vec<Hidden> = verdict::blind_spots(outcome).par_map(|spot| {
        let c: &Candidate = spot.candidate;
        let Some(size) = &spot.size else {
            let target = c.target.clone();
            return Hidden { effect: c.effect, target, found: false, sizes: Vec::new(), moves: None };
        };
        let mut sizes = Vec::new();
        for placed in c.at(size) {
            let keys = placed.keys(&p.robot).into_iter().zip(placed.effect.values());
            sizes.extend(keys.map(|((key, factor), v)| (key, (v * factor).abs())));
        }
        // the coordinates of a vector count one by one: one of them alone would be seen
        let columns = c.columns(p, &outcome.fit.hypothesis, &outcome.fit.state);
        let moves = columns.iter().zip(size).map(|(v, s)| rms(p, v) * s.abs()).fold(0.0, f64::max);
        Hidden { effect: c.effect, target: c.target.clone(), found: false, sizes, moves: Some(moves) }
    });
    for (effect, target, _) in document::of_unseen_joints(outcome) {
        if !all.iter().any(|h| h.effect == effect && h.target == target) {
            all.push(Hidden { effect, target, found: false, sizes: Vec::new(), moves: None });
        }
    }
    for &i in &outcome.fit.free {
        let placed = &outcome.fit.hypothesis.effects[i];
        let (effect, target) = placed.named(&p.robot);
        all.push(Hidden { effect, target, found: true, sizes: Vec::new(), moves: None });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_stand_in_bins_of_position_and_ignore_a_wild_sample() {
        let samples: Vec<[f64; 3]> =
            (0..600).map(|i| [f64::from(i), if i == 300 { 1e6 } else { f64::from(i % 2) }, 0.5]).collect();
        let way = medians(&samples, 0.0, 599.0);
        assert_eq!(way.position.len(), BINS);
        assert!(way.position.windows(2).all(|w| w[0] < w[1]));
        assert!(way.before.iter().all(|q| q[1] >= 0.0 && q[1] <= 1.0), "{:?}", way.before);
        assert!(way.after.iter().all(|q| *q == [0.5; 3]));
    }

    #[test]
    fn a_handful_of_samples_is_one_bin() {
        let way = medians(&[[1.0, 2.0, 3.0], [1.0, 4.0, 5.0]], 1.0, 1.0);
        assert_eq!((way.position.len(), way.before[0][1], way.after[0][1]), (1, 3.0, 4.0));
    }
}
