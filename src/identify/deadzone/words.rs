//! What a reader of the sweeps should know, in words.

use super::JointSweeps;
use super::motion::Stretch;
use crate::error::counted;
use crate::robot::{JointKind, Robot};

/// Deadzones that begin nearer to each other than this share of the half gap begin at one place.
const ONE_PLACE: f64 = 0.1;

/// Why a joint has no deadzone; the words follow its name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum NoDeadzone {
    #[error("it never reverses")]
    NeverTurns,
    #[error("it reverses only once")]
    TurnsOnce,
    /// `stroke`: the longest, with its unit.
    #[error(
        "the tip does not move after any of the {turns} reversals (longest stroke {stroke}): the strokes are smaller than the gap"
    )]
    AllInside { turns: usize, stroke: String },
    #[error("too few tracker readings near its {0} reversals")]
    FewRows(usize),
    #[error(
        "after its {turns} reversals the tip moves too little compared with a rest radius of {radius_um:.0} um (longest stroke {stroke})"
    )]
    TooShort { turns: usize, radius_um: f64, stroke: String },
    #[error("the sizes of its deadzones have no mean")]
    NoMean,
}

impl NoDeadzone {
    /// Why sweeps show none.
    pub(super) fn of(out: &JointSweeps, kind: JointKind, stretches: &[&Stretch]) -> Self {
        let largest =
            stretches.iter().flat_map(|s| s.turns.windows(2).map(|w| (w[1].p - w[0].p).abs())).fold(0.0, f64::max);
        let stroke = format!("{:.4} {}", kind.to_user_unit(largest), kind.unit());
        let turns = out.turns;
        match () {
            () if turns == 1 => Self::TurnsOnce,
            () if out.inside + out.not_crossed >= turns => Self::AllInside { turns, stroke },
            () if out.unseen + out.unfitted >= out.too_short => Self::FewRows(turns),
            () => Self::TooShort { turns, radius_um: out.radius_m * 1e6, stroke },
        }
    }
}

/// What a reader of a joint's figures should know.
pub(super) fn notes(robot: &Robot, found: &JointSweeps) -> Vec<String> {
    let joint = robot.axis(found.axis);
    let (unit, edge) = (joint.kind.unit(), |v: f64| joint.kind.to_user_unit(v));
    let mut notes = Vec::new();
    let mut note = |text: String| notes.push(format!("{}: {text}", joint.name));
    let n = found.deadzones.len();
    let range = found
        .deadzones
        .iter()
        .map(|d| 0.5 * (d.from + d.to))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let mut places: Vec<f64> = found.deadzones.iter().map(|d| d.from).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() < ONE_PLACE * found.map.half_gap.abs());
    if places.len() <= 2 {
        let at: Vec<String> = places.iter().map(|p| format!("{:.3}", edge(*p))).collect();
        note(format!(
            "all deadzones ({n}) begin at {} {unit}: the sweep does not grow, so the gap at other positions is not known",
            at.join(" and ")
        ));
    } else if found.map.varies_p_value.is_none() {
        note(format!("{n} deadzones are too few to see whether the gap varies with position"));
    }
    if !found.map.knots.is_empty() {
        note(format!("the gap is mapped from {:.3} to {:.3} {unit} and constant beyond", edge(range.0), edge(range.1)));
    }
    if found.map.scatter > 1.0 {
        note(format!(
            "deadzones scatter {:.1} times as much as the tracker's noise explains; the intervals are widened by that: \
             friction, drift, a gap that depends on more than position, or noise that is correlated",
            found.map.scatter
        ));
    }
    if found.unseen + found.unfitted > 0 {
        note(format!(
            "{} left out: too few tracker readings near them",
            counted(found.unseen + found.unfitted, "turn")
        ));
    }
    if found.outliers > 0 {
        note(format!("{} left out as gross errors of the tracker", counted(found.outliers, "row")));
    }
    if found.map.ci95[1] < 0.0 {
        note(
            "the size is negative, as if the tip moved before its motor: check the clocks of commands and tracker"
                .into(),
        );
    }
    notes
}
