//! The result as a table for people.

use super::Found;
use super::flanks::{Flanks, Known};
use super::series::{Series, TrainGap};
use crate::gaps::note::screw::shown;
use crate::robot::{Joint, Robot};
use comfy_table::{CellAlignment, Table, presets};

/// One line a gap.
pub fn table(found: &Found, robot: &Robot) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header(["joint", "gap", "total", "95 % interval", "c_l", "c_r", "slope m", "strokes", "fluctuation"]);
    for s in &found.series {
        let joint = robot.axis(s.axis);
        for (gap, flanks) in s.found() {
            table.add_row(row(s, joint, gap, flanks));
        }
        if let Some(least) = s.at_least {
            table.add_row(vec![joint.name.clone(), "both".into(), format!("> {}", shown(least, joint.kind))]);
        }
    }
    for column in 2..9 {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    if found.series.iter().all(|s| s.both.is_none() && s.coupling.is_none() && s.at_least.is_none()) {
        return "no gap found\n".into();
    }
    format!("{}\n", table.trim_fmt())
}

fn row(s: &Series, joint: &Joint, gap: TrainGap, f: &Flanks) -> Vec<String> {
    let edge = |v: f64| format!("{:.4}", joint.kind.to_user_unit(v) + 0.0);
    let zero = |k: Known| if s.shares_zero(gap, f) { edge(k.value) } else { "-".into() };
    let angle = match joint.lead_m_per_rev {
        Some(lead) if gap == TrainGap::Coupling => format!(" ({:.3} deg)", f.total.value / lead * 360.0),
        _ => String::new(),
    };
    let mark = match f.total.ci95 {
        [_, hi] if hi < 0.0 => ", negative: no gap",
        _ if f.significant() => "",
        _ => ", not significant",
    };
    vec![
        joint.name.clone(),
        gap.name().into(),
        format!("{} {}{angle}", edge(f.total.value), joint.kind.unit()),
        format!("{} .. {}{mark}", edge(f.total.ci95[0]), edge(f.total.ci95[1])),
        zero(f.c_l),
        zero(f.c_r),
        format!("{:.6}", f.slope.value),
        format!("{} + {}", f.strokes[0], f.strokes[1]),
        format!("{:.1} {}", joint.kind.to_user_unit(f.rms) * 1e3, joint.kind.pick(["mdeg", "um"])),
    ]
}
