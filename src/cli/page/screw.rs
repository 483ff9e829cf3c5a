//! Page of `identify screw`: the gaps of coupling and nut, and their loops over the joint's position (Gantry (2015) Figures 6 and 9).

use super::{milli, milli_unit, milli2};
use crate::gaps::Note;
use crate::identify::screw::flanks::Known;
use crate::identify::screw::loops::Loop;
use crate::identify::screw::{Found, Series};
use crate::report::{JointTraces, Page, Role, Run, TableView, Tile, Tone, TracePanel, TraceRun, TracesView, method};
use crate::robot::{Joint, JointKind, Robot};
use std::f64::consts::TAU;

/// The page.
pub fn of_screw(robot: &Robot, found: &Found) -> Page {
    let mut page = super::start("identify screw", "Gaps of coupling and nut in series", robot);
    for log in &found.gaps.logs {
        page.file("log", log.name.clone(), log.sha256.clone());
    }
    page.verdict(Tone::Plain, verdict(robot, found));
    for s in &found.series {
        for (gap, flanks) in s.found() {
            let unit = milli_unit(robot.axis(s.axis).kind);
            let [lo, hi] = milli2(robot, s.axis, flanks.total.ci95);
            let label = format!("gap of {}, {}", robot.axis(s.axis).name, gap.name());
            let tile = Tile::number(label, milli(robot, s.axis, flanks.total.value), 2, unit);
            page.tile(tile.with_detail(format!("95 %: {lo:.2} to {hi:.2}")));
        }
    }
    for (gap, what) in [
        ("coupling", "Screw against motor"),
        ("nut", "Carriage against screw"),
        ("total", "Carriage against motor: both gaps"),
    ] {
        loops(&mut page, robot, found, gap, what);
    }
    page.section(
        "Total gaps c_r - c_l, their sides and slopes",
        "With 95 % intervals, in thousandths of a degree (mdeg) or micrometres; as an angle: of the joint, or of the screw by its lead; fluctuation: rms about the flanks, noise and vibration.",
        table(robot, found),
    );
    if !found.gaps.notes.is_empty() {
        page.section("Notes", "", found.gaps.notes.iter().map(Note::to_string).collect::<Vec<_>>());
    }
    page.section("", "", vec![method::TWO_FLANKS, method::PLAY]);
    page
}

fn verdict(robot: &Robot, found: &Found) -> String {
    let names = |separate: bool| {
        let of = |s: &&Series| s.both.is_some() && separate == (s.coupling.is_some() && s.nut.is_some());
        found.series.iter().filter(of).map(|s| robot.axis(s.axis).name.as_str()).collect::<Vec<_>>().join(", ")
    };
    match (names(true), names(false)) {
        (a, b) if a.is_empty() && b.is_empty() => "No joint shows the gap between motor and carriage.".into(),
        (a, b) if b.is_empty() => format!("Coupling and nut are separated: {a}."),
        (a, b) if a.is_empty() => format!("The sum of both gaps is known, not its parts: {b}."),
        (a, b) => format!("Coupling and nut are separated: {a}. Only their sum is known: {b}."),
    }
}

fn table(robot: &Robot, found: &Found) -> TableView {
    let headings = [
        ("joint", false),
        ("gap", false),
        ("total", true),
        ("95 %", true),
        ("as an angle, deg", true),
        ("rad", true),
        ("c_l", true),
        ("c_r", true),
        ("slope m", true),
        ("strokes up + down", true),
        ("fluctuation", true),
    ];
    let mut rows = Vec::new();
    for s in &found.series {
        for (gap, f) in s.found() {
            let value = |v: f64| format!("{:.2}", milli(robot, s.axis, v) + 0.0);
            let angle = angle(robot.axis(s.axis), f.total.value);
            let zero = s.shares_zero(gap, f);
            let side = |k: Known| if zero { value(k.value) } else { "–".into() };
            rows.push(vec![
                robot.axis(s.axis).name.clone(),
                gap.name().into(),
                value(f.total.value),
                format!("{} to {}", value(f.total.ci95[0]), value(f.total.ci95[1])),
                angle.map_or("–".into(), |a| format!("{:.4}", a.to_degrees())),
                angle.map_or("–".into(), |a| format!("{a:.6}")),
                side(f.c_l),
                side(f.c_r),
                format!("{:.6}", f.slope.value),
                format!("{} + {}", f.strokes[0], f.strokes[1]),
                value(f.rms),
            ]);
        }
    }
    TableView::new(&headings, rows)
}

/// A gap as the angle of its joint, or of its screw, rad.
fn angle(joint: &Joint, gap: f64) -> Option<f64> {
    match joint.kind {
        JointKind::Revolute => Some(gap),
        JointKind::Prismatic => joint.lead_m_per_rev.map(|lead| gap / lead * TAU),
    }
}

/// Loops of one gap, a row a joint.
fn loops(page: &mut Page, robot: &Robot, found: &Found, gap: &str, what: &str) {
    let joints: Vec<JointTraces> = found
        .series
        .iter()
        .filter_map(|s| s.loops.iter().find(|l| l.gap == gap).map(|l| (s.axis, l)))
        .map(|(axis, l)| JointTraces { joint: robot.axis(axis).name.clone(), panels: vec![panel(robot, axis, l)] })
        .collect();
    let Some(unit) = found.series.first().map(|s| robot.axis(s.axis).kind.unit()) else { return };
    if joints.is_empty() {
        return;
    }
    page.section(
        what,
        "Output minus slope times input over the commanded position, relative to the middle of the gap. The line is the identified play: below while the joint moves up, above while it moves down.",
        TracesView { x_name: "command".into(), x_unit: unit.into(), y_name: "deviation".into(), y_whole: false, joints },
    );
}

fn panel(robot: &Robot, axis: usize, l: &Loop) -> TracePanel {
    let edge: Vec<f64> = l.command.iter().map(|v| robot.axis(axis).kind.to_user_unit(*v)).collect();
    let milli = |values: &[f64]| values.iter().map(|v| milli(robot, axis, *v)).collect();
    TracePanel {
        title: String::new(),
        runs: vec![TraceRun {
            run: Run::new("measured", Role::Before),
            x: edge.clone(),
            error_milli: milli(&l.measured),
            model_x: edge,
            model_milli: milli(&l.model),
        }],
        marks: Vec::new(),
    }
}
