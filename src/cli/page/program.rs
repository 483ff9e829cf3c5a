//! Sections about a program before and after it was changed: errors along the path, at the reversals, their distribution.

use super::start;
use crate::assess::program::{Assessment, Note, ReversalError, Run as ProgramRun, Verdict};
use crate::report::{BarRow, BarsView, HistogramRun, HistogramView, Page, Role, Run, TableView, Tile, Tone};
use crate::robot::Robot;

/// Parts of the path of which the largest error is drawn.
const PARTS: usize = 40;

/// The whole page.
pub fn of_assessment(robot: &Robot, result: &Assessment) -> Page {
    let mut page = start("assess program", "Path error of a program before and after", robot);
    head(&mut page, result);
    let runs = vec![Run::new("before", Role::Before), Run::new("after", Role::After)];
    let end = result.before.reference_s.iter().copied().fold(0.0, f64::max);
    // digits that tell neighbouring parts apart
    let digits = (-(end / PARTS as f64).max(1e-9).log10()).ceil().clamp(0.0, 6.0) as usize;
    let rows = (0..PARTS)
        .map(|k| {
            let range = [k, k + 1].map(|i| end * i as f64 / PARTS as f64);
            let value = |run: &ProgramRun| {
                let on = run.reference_s.iter().zip(&run.errors_m).filter(|(t, _)| **t >= range[0] && **t <= range[1]);
                on.map(|(_, e)| e * 1e6).reduce(f64::max)
            };
            BarRow {
                label: format!("{:.digits$} to {:.digits$} s", range[0], range[1]),
                values: vec![value(&result.before), value(&result.after)],
            }
        })
        // between the known stretches of a program there is nothing
        .filter(|row| row.values.iter().any(Option::is_some))
        .collect();
    page.section(
        "Largest error along the program",
        "Distance of the TCP from the path without joint errors, over the time of the original program.",
        BarsView { quantity: "largest error".into(), unit: "µm".into(), runs: runs.clone(), rows },
    );
    let histogram = |run: &ProgramRun, name: &Run| HistogramRun {
        run: name.clone(),
        values: run.errors_m.iter().map(|e| e * 1e6).collect(),
        p95: None,
    };
    page.section(
        "Distribution of the error",
        "All rows of both runs.",
        HistogramView {
            quantity: "distance to the path".into(),
            unit: "µm".into(),
            runs: vec![histogram(&result.before, &runs[0]), histogram(&result.after, &runs[1])],
        },
    );
    page.section("Reversals", "Largest error from 0.1 s before to 4 s after each reversal.", reversals(robot, result));
    if !result.notes.is_empty() {
        page.section("Notes", "", result.notes.iter().map(Note::to_string).collect::<Vec<_>>());
    }
    page
}

fn head(page: &mut Page, result: &Assessment) {
    let f = &result.figures;
    let um = |v: f64| v * 1e6;
    let tone = match result.verdict {
        Verdict::Better => Tone::Good,
        Verdict::Unchanged => Tone::Mixed,
        Verdict::Worse => Tone::Bad,
    };
    let sentence = f.sentence().replace(" um", " µm").replace("->", "to");
    let mut letters = sentence.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    page.verdict(tone, format!("{first}{}.", letters.as_str()));
    let before = |v: f64| format!("before: {:.1} µm", um(v));
    page.tile(Tile::number("rms along the path", um(f.rms_m[1]), 1, "µm").with_detail(before(f.rms_m[0])));
    page.tile(Tile::number("largest error", um(f.largest_m[1]), 1, "µm").with_detail(before(f.largest_m[0])));
    if let Some(t) = &f.at_targets {
        let tile = Tile::number("largest at the targets", um(t.largest_m[1]), 1, "µm");
        page.tile(tile.with_detail(before(t.largest_m[0])));
    }
    page.tile(Tile::number("cycle time", f.cycle_s[1], 2, "s").with_detail(format!("before: {:.2} s", f.cycle_s[0])));
    page.tile(Tile::text("points", f.points[1].to_string(), "").with_detail(format!("before: {}", f.points[0])));
}

/// The error about each reversal.
fn reversals(robot: &Robot, result: &Assessment) -> TableView {
    let number = |v: f64| format!("{v:.1}");
    let row = |r: &ReversalError| {
        let joint = robot.axis(r.axis);
        vec![
            joint.name.clone(),
            number(r.at_s),
            format!("{:.4} {}", joint.kind.to_user_unit(r.command), joint.kind.unit()),
            if r.direction > 0 { "up" } else { "down" }.into(),
            number(r.before_m * 1e6),
            number(r.after_m * 1e6),
        ]
    };
    let columns = [
        ("joint", false),
        ("at s", true),
        ("command", true),
        ("turns", false),
        ("before, µm", true),
        ("after, µm", true),
    ];
    TableView::new(&columns, result.reversals.iter().map(row))
}
