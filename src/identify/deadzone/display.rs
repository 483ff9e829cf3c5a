//! The result as a table for people.

use super::Found;
use crate::effects::GapCurve;
use crate::robot::Robot;
use comfy_table::{CellAlignment, Table, presets};

/// A short table, one line a joint.
pub fn table(found: &Found, robot: &Robot) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    let header =
        ["joint", "turns", "deadzones", "mean size", "half gap", "95 % interval", "", "varies (p)", "schedule"];
    table.set_header([&header[..], &["noise um"]].concat());
    for (gap, sweeps) in found.gaps.joints.iter().zip(&found.joints) {
        let joint = robot.axis(gap.axis);
        let edge = |v: f64| format!("{:.5}", joint.kind.to_user_unit(v) + 0.0);
        let mean = sweeps.deadzones.iter().map(|d| d.size).sum::<f64>() / sweeps.deadzones.len().max(1) as f64;
        let unit = joint.kind.unit();
        table.add_row([
            joint.name.clone(),
            sweeps.turns.to_string(),
            sweeps.deadzones.len().to_string(),
            edge(mean),
            edge(gap.half_gap),
            format!("{} .. {}", edge(gap.ci95[0]), edge(gap.ci95[1])),
            if gap.significant { unit.into() } else { format!("{unit}, not significant") },
            match (gap.varies_p_value, &gap.schedule) {
                (Some(p), Some(_)) => format!("yes ({p:.1e})"),
                (Some(p), None) => format!("no ({p:.2})"),
                (None, _) => "not tested".into(),
            },
            match &gap.schedule {
                Some(c @ GapCurve::Pchip(p)) => {
                    format!("{} knots, {} to {}", p.knots().len(), edge(c.smallest()), edge(c.largest()))
                }
                _ => "constant".into(),
            },
            format!("{:.1}", sweeps.noise_m * 1e6),
        ]);
    }
    for column in [1, 2, 3, 4, 5, 9] {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("{}\n", table.trim_fmt())
}
