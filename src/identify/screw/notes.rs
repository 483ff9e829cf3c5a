//! What a reader of the figures should know.

use super::flanks::{Flanks, Repeats};
use super::series::{Output, Series, TrainGap};
use crate::gaps::note::screw::Remark;
use crate::robot::{Joint, JointKind};

/// Slopes farther from 1 than this are hardly a screw's lead error.
pub const LEAD: f64 = 0.05;
/// A slope this near to 1 is not reported.
const PPM: f64 = 1e-5;
/// What columns of a drive should be.
pub const SCALE: &str = "the scale of the joint: check unit and sign of the column, `lead_mm_per_rev` in the robot file, or give a gear ratio as `scale` in a column map";

/// What one gap's figures are based on.
pub fn flanks(found: &Flanks, gap: TrainGap, kind: JointKind) -> Vec<Remark> {
    let mut notes = Vec::new();
    if found.repeats == Repeats::Pieces {
        let [up, down] = found.strokes;
        notes.push(Remark::FewStrokes { gap, up, down });
    }
    if found.dropped > 0 {
        notes.push(Remark::RowsLeftOut { gap, dropped: found.dropped, rows: found.rows + found.dropped });
    }
    if let Some(per_s) = found.total_per_lag {
        notes.push(Remark::LagLooksLikeGap { gap, kind, per_s });
    }
    if found.total.ci95[1] < 0.0 {
        notes.push(Remark::Negative { gap });
    }
    let slope = found.slope.value;
    if (slope - 1.0).abs() > LEAD {
        notes.push(Remark::OffScale { gap, slope });
    }
    notes
}

/// What concerns the joint as a whole.
pub fn of_series(series: &Series, joint: &Joint) -> Vec<Remark> {
    let (mut notes, kind) = (Vec::new(), joint.kind);
    if series.both.is_some() && series.coupling.is_none() && series.nut.is_none() {
        let unit = if joint.lead_m_per_rev.is_some() { "deg" } else { kind.unit() };
        notes.push(Remark::NotSeparated { column: format!("screw_{}_{unit}", joint.name) });
    }
    if let Some(both) = &series.both {
        let slope = both.slope.value;
        if both.slope.excludes(1.0) && (slope - 1.0).abs() > PPM && (slope - 1.0).abs() <= LEAD {
            notes.push(Remark::LeadError { slope });
        }
        notes.extend(about_zero(series, both, kind));
    }
    if let (Some(a), Some(b), Some(sum)) = (&series.coupling, &series.nut, &series.both) {
        let off = a.total.value + b.total.value - sum.total.value;
        let unsure = [a, b, sum].map(|g| g.total.ci95[1] - g.total.value).iter().sum::<f64>();
        if off.abs() > unsure {
            notes.push(Remark::SumDiffers { kind, off });
        }
    }
    notes
}

/// Whether the flanks mean something each, or their difference alone does.
fn about_zero(series: &Series, both: &Flanks, kind: JointKind) -> Option<Remark> {
    let zero = series.shares_zero(TrainGap::Both, both);
    if series.output == Some(Output::Tracker) {
        Some(Remark::TrackerWithoutZero)
    } else if !zero && (both.middle.ci95[1] - both.middle.value > both.total.value || series.leans_on_slope(both)) {
        Some(Remark::ZeroTooFar)
    } else if !zero {
        Some(Remark::OtherZero { kind, c_l: both.c_l.value, c_r: both.c_r.value })
    } else {
        None
    }
}
