//! Page of `rewrite`: what was done to a program.

use super::milli;
use crate::compensator::Compensator;
use crate::report::{Page, TableView, Tile, Tone};
use crate::rewrite::job::Outcome;
use crate::robot::Robot;

pub fn of_outcome(robot: &Robot, compensator: &Compensator, outcome: &Outcome) -> Page {
    let mut page = super::start("rewrite", "A program with its lost motion taken out", robot);
    page.file("program in", outcome.input.clone(), outcome.sha256_in.clone().unwrap_or_default());
    if let Some(out) = &outcome.output {
        page.file("program out", out.clone(), outcome.sha256_out.clone().unwrap_or_default());
    }
    let a = &outcome.account;
    match (&outcome.refusal, outcome.unchanged) {
        (Some(reason), _) => page.verdict(Tone::Bad, format!("Refused: {}", reason.lines().next().unwrap_or_default())),
        (None, true) => page.verdict(Tone::Plain, "Nothing to compensate: the output is the input, byte for byte."),
        (None, false) => {
            page.verdict(Tone::Good, format!("{} points read, {} added, every limit kept.", a.points, a.inserted))
        }
    };
    page.tile(Tile::text("reversals", a.reversals.iter().sum::<u64>().to_string(), ""));
    page.tile(Tile::text("points added", a.inserted.to_string(), ""));
    page.tile(Tile::number("largest change at the TCP", a.largest_change_m * 1e6, 1, "µm"));
    let per = |v: &[f64], k: usize| format!("{:.3}", milli(robot, k, v.get(k).copied().unwrap_or(0.0)));
    let rows = (0..robot.dof())
        .map(|k| {
            let reversals = a.reversals.get(k).copied().unwrap_or(0).to_string();
            let decimals = outcome.written.get(k).copied().flatten().map_or("as they were".into(), |d| d.to_string());
            let name = robot.axis(k).name.clone();
            vec![name, reversals, per(&a.largest_offset, k), per(&a.largest_left, k), decimals]
        })
        .collect();
    let head = ["joint", "reversals", "largest offset, mdeg or µm", "left at a reversal, mdeg or µm", "decimals"];
    let columns = head.iter().enumerate().map(|(i, h)| ((*h).to_string(), i > 0)).collect();
    page.section(
        "What was done",
        "\u{201c}Left\u{201d} is what the command must leave because it may not turn back while friction fades.",
        TableView { columns, rows },
    );
    super::compensator::sections(&mut page, robot, compensator);
    if let Some(reason) = &outcome.refusal {
        page.section("Why nothing was written", "", reason.lines().map(str::to_string).collect::<Vec<_>>());
    }
    page.section("", "", super::compensator::methods());
    page
}
