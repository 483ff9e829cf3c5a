//! The result as a table for people.

use super::Found;
use crate::effects::GapCurve;
use crate::robot::Robot;
use comfy_table::{CellAlignment, Table, presets};

/// A short table, one line a joint, then the registration and the notes.
pub fn table(found: &Found, robot: &Robot) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header(["joint", "places x cycles", "half gap", "95 % interval", "", "varies (p)", "schedule"]);
    for (gap, test) in found.gaps.joints.iter().zip(&found.joints) {
        let joint = robot.axis(gap.axis);
        let edge = |v: f64| format!("{:.5}", joint.kind.to_user_unit(v) + 0.0);
        let cycles = test.summary.angles.iter().map(|a| a.cycles.len()).max().unwrap_or(0);
        table.add_row([
            joint.name.clone(),
            format!("{} x {cycles}", test.summary.angles.len()),
            edge(gap.half_gap),
            format!("{} .. {}", edge(gap.ci95[0]), edge(gap.ci95[1])),
            if gap.significant { joint.kind.unit().into() } else { format!("{}, not significant", joint.kind.unit()) },
            match gap.varies_p_value {
                Some(p) if test.summary.varies() => format!("yes ({p:.1e})"),
                Some(p) => format!("no ({p:.2})"),
                None => "not tested".into(),
            },
            match &gap.schedule {
                None => "constant".into(),
                Some(GapCurve::Constant(_)) => "constant".into(),
                Some(GapCurve::Polynomial { coefficients, .. }) => {
                    format!("polynomial, degree {}", coefficients.len() - 1)
                }
                Some(c @ GapCurve::Pchip(p)) => {
                    format!("{} knots, {} to {}", p.knots().len(), edge(c.smallest()), edge(c.largest()))
                }
            },
        ]);
    }
    for column in [1, 2, 3] {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    let mut text =
        if found.gaps.joints.is_empty() { "no gap found\n".into() } else { format!("{}\n", table.trim_fmt()) };
    if let Some(f) = &found.frame {
        let how = if f.given { "given" } else { "found" };
        text += &format!(
            "registration {how}: {} points, residual {:.1} um; {} samples, residual {:.1} um per coordinate\n",
            f.points,
            f.points_rms_m * 1e6,
            f.found.samples,
            f.found.rms_m * 1e6
        );
    }
    text
}
