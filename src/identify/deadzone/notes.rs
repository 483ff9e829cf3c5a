//! What a reader of the sweeps should know.

use super::JointSweeps;
use super::motion::Stretch;
use crate::gaps::note::deadzone::{NoDeadzone, Remark};
use crate::numerics::robust::range;
use crate::robot::{JointKind, Robot};

/// Deadzones that begin nearer to each other than this share of the half gap begin at one place.
const ONE_PLACE: f64 = 0.1;

impl NoDeadzone {
    /// Why sweeps show none.
    pub(super) fn of(out: &JointSweeps, kind: JointKind, stretches: &[&Stretch]) -> Self {
        let stroke =
            stretches.iter().flat_map(|s| s.turns.windows(2).map(|w| (w[1].p - w[0].p).abs())).fold(0.0, f64::max);
        let turns = out.turns;
        match () {
            () if turns == 1 => Self::TurnsOnce,
            () if out.inside + out.not_crossed >= turns => Self::AllInside { turns, kind, stroke },
            () if out.unseen + out.unfitted >= out.too_short => Self::FewRows { turns },
            () => Self::TooShort { turns, radius_m: out.radius_m, kind, stroke },
        }
    }
}

/// What a reader of a joint's figures should know.
pub(super) fn notes(robot: &Robot, found: &JointSweeps) -> Vec<Remark> {
    let kind = robot.axis(found.axis).kind;
    let mut notes = Vec::new();
    let deadzones = found.deadzones.len();
    let [from, to] = range(found.deadzones.iter().map(|d| 0.5 * (d.from + d.to)));
    let mut places: Vec<f64> = found.deadzones.iter().map(|d| d.from).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| (*a - *b).abs() < ONE_PLACE * found.map.half_gap.abs());
    if places.len() <= 2 {
        notes.push(Remark::DoesNotGrow { deadzones, kind, places });
    } else if found.map.varies_p_value.is_none() {
        notes.push(Remark::TooFew { deadzones });
    }
    if !found.map.knots.is_empty() {
        notes.push(Remark::Mapped { kind, from, to });
    }
    if found.map.scatter > 1.0 {
        notes.push(Remark::Scatter { factor: found.map.scatter });
    }
    if found.unseen + found.unfitted > 0 {
        notes.push(Remark::TurnsLeftOut { turns: found.unseen + found.unfitted });
    }
    if found.outliers > 0 {
        notes.push(Remark::RowsLeftOut { rows: found.outliers });
    }
    if found.map.ci95[1] < 0.0 {
        notes.push(Remark::Negative);
    }
    notes
}
