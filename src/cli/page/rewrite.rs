//! Page of `rewrite`: what was done to a program.

use super::milli;
use crate::assess::program::{AtTargets, Figures, ReversalError, Verdict, judge};
use crate::compensator::Compensator;
use crate::error::counted;
use crate::report::{BarRow, BarsView, Page, Role, Run, TableView, Tile, Tone};
use crate::rewrite::outcome::{Outcome, Vendor};
use crate::rewrite::script::change::Change;
use crate::rewrite::script::coverage::Reason;
use crate::rewrite::summary::{BeforeAfter, Line, PathErrors, Status};
use crate::robot::Robot;

/// The verdict on the rewritten program, as a page shows it.
pub struct Shown<'a> {
    /// The machine on which both programs were run, in words.
    pub machine: &'static str,
    /// Errors before and after.
    pub figures: &'a Figures,
    /// Path error to expect of the robot itself, m rms.
    pub expected_m: Option<f64>,
    /// What the offsets leave on the robot itself is known: it is in `expected_m`, or in the model.
    pub measured: bool,
    /// Error after each reversal.
    pub reversals: &'a [ReversalError],
}

/// Page of one program.
pub fn of_outcome(robot: &Robot, compensator: &Compensator, outcome: &Outcome, proof: Option<&Shown>) -> Page {
    let mut page = super::start("rewrite", "Program with compensated lost motion", robot);
    page.file("program in", outcome.input.clone(), outcome.sha256_in.clone().unwrap_or_default());
    if let Some(out) = &outcome.output {
        page.file("program out", out.clone(), outcome.sha256_out.clone().unwrap_or_default());
    }
    let a = &outcome.stats;
    match (&outcome.refusal, outcome.unchanged) {
        (Some(reason), _) => page.verdict(Tone::Bad, format!("Refused: {}", reason.lines().next().unwrap_or_default())),
        (None, true) => page.verdict(Tone::Plain, "Nothing to compensate: the output equals the input, byte for byte."),
        (None, false) => {
            let added = if outcome.output.is_some() { "added" } else { "to be added" };
            let known = robot.axis_joints().any(|j| j.limits.is_some() || j.max_speed.is_some());
            let limits = if known { "every limit kept" } else { "no limits to check: the robot file contains none" };
            let (tone, path) = proof.map_or((Tone::Good, String::new()), answer);
            page.verdict(tone, format!("{path}{} points read, {} {added}, {limits}.", a.points, a.inserted))
        }
    };
    page.tile(Tile::text("reversals", a.reversals.iter().sum::<u64>().to_string(), ""));
    let added = if outcome.output.is_some() { "points added" } else { "points to be added" };
    page.tile(Tile::text(added, a.inserted.to_string(), ""));
    page.tile(Tile::number("largest change at the TCP", a.largest_change_m * 1e6, 1, "µm"));
    if let Some(proof) = proof.filter(|p| !p.reversals.is_empty()) {
        page.section(
            "Largest error at the TCP after the reversals of each joint",
            format!("Both programs run on {}; distance to the path without joint errors.", proof.machine),
            reversals(robot, proof.reversals),
        );
    }
    let per = |v: &[f64], k: usize| format!("{:.3}", milli(robot, k, v.get(k).copied().unwrap_or(0.0)));
    let rows = (0..robot.dof()).map(|k| {
        let reversals = a.reversals.get(k).copied().unwrap_or(0).to_string();
        let decimals = outcome.written.get(k).copied().flatten().map_or("as they were".into(), |d| d.to_string());
        let name = robot.axis(k).name.clone();
        vec![name, reversals, per(&a.largest_offset, k), per(&a.largest_left, k), decimals]
    });
    let head = [
        "joint",
        "compensated reversals",
        "largest offset, mdeg or µm",
        "remaining at a reversal, mdeg or µm",
        "decimals",
    ];
    page.section(
        "What was done",
        "What remains at a reversal: the part that the offset cannot take away, because the command must not reverse while the friction offset fades.",
        TableView::numbers_after(1, &head, rows),
    );
    if let Some(v) = &outcome.vendor {
        vendor(&mut page, v, robot);
    }
    super::compensator::sections(&mut page, robot, compensator);
    if let Some(reason) = &outcome.refusal {
        page.section("Why nothing was written", "", reason.lines().map(str::to_string).collect::<Vec<_>>());
    }
    page.section("", "", super::compensator::methods());
    page
}

/// The verdict in a sentence: on which machine, and what that says of the robot itself.
fn answer(proof: &Shown) -> (Tone, String) {
    let f = proof.figures;
    let only_on_the_way = f.at_targets.is_some_and(|t: AtTargets| t.verdict() != Verdict::Worse);
    let tone = match judge(f) {
        Verdict::Worse if !only_on_the_way => Tone::Bad,
        Verdict::Worse | Verdict::Unchanged => Tone::Mixed,
        Verdict::Better => Tone::Good,
    };
    let robot_itself = match proof.expected_m {
        Some(m) => format!(" Expect about {:.0} µm rms from the robot itself.", m * 1e6),
        None if proof.measured => String::new(),
        None => " Errors that the compensator does not know remain.".into(),
    };
    let stop = if tone == Tone::Bad { " Do not run this program." } else { "" };
    let mut sentence = f.sentence().replace(" -> ", "\u{a0}\u{2192}\u{a0}").replace(" um", "\u{a0}µm");
    if let Some(first) = sentence.get_mut(0..1) {
        first.make_ascii_uppercase();
    }
    (tone, format!("{sentence}, on {}.{robot_itself}{stop} ", proof.machine))
}

/// Largest error of each joint's reversals.
fn reversals(robot: &Robot, all: &[ReversalError]) -> BarsView {
    let row = |axis: usize| {
        let own = || all.iter().filter(move |r| r.axis == axis);
        let largest = |of: fn(&ReversalError) -> f64| own().map(|r| of(r) * 1e6).reduce(f64::max);
        let values = vec![largest(|r| r.before_m), largest(|r| r.after_m)];
        (own().count() > 0).then(|| BarRow { label: robot.axis(axis).name.clone(), values })
    };
    BarsView {
        quantity: "largest error".into(),
        unit: "µm".into(),
        runs: vec![Run::new("before", Role::Before), Run::new("after", Role::After)],
        rows: (0..robot.dof()).filter_map(row).collect(),
    }
}

/// Programs that a figure of a folder shows.
const DRAWN: usize = 40;

/// Page of a folder of programs; `what` was done with them, in a word.
pub fn of_folder(robot: &Robot, compensator: &Compensator, folder: &str, lines: &[Line], what: &str) -> Page {
    let mut page = super::start("rewrite", &format!("Programs of {folder}"), robot);
    let count = |s: Status| lines.iter().filter(|l| l.status == s).count();
    let done = count(Status::Written) + count(Status::WouldBeWritten);
    let (refused, failed) = (count(Status::Refused), count(Status::Failed));
    let judged = |verdict: &str| lines.iter().filter(|l| verdict_of(l) == Some(verdict)).count();
    let (better, worse) = (judged("better"), judged("worse"));
    let tone = match refused + failed {
        0 if worse == 0 => Tone::Good,
        n if n < lines.len() => Tone::Mixed,
        _ => Tone::Bad,
    };
    let verdicts = match better + worse + judged("unchanged") {
        0 => String::new(),
        n => {
            format!(" On a machine with the compensator's gaps and friction {better} of {n} get better, {worse} worse.")
        }
    };
    page.verdict(
        tone,
        format!(
            "{done} of {} {what}, {} unchanged, {refused} refused, {failed} failed.{verdicts}",
            counted(lines.len(), "program"),
            count(Status::Unchanged)
        ),
    );
    let sum = |f: fn(&Line) -> u64| lines.iter().map(f).sum::<u64>();
    page.tile(Tile::text("moves edited", format!("{} of {}", sum(|l| l.editable), sum(|l| l.moves)), ""));
    page.tile(Tile::text("reversals", sum(|l| l.reversals).to_string(), ""));
    page.tile(Tile::text("points added", sum(|l| l.inserted).to_string(), ""));
    folder_figures(&mut page, folder, lines);
    let stopped = lines.iter().filter(|l| matches!(l.status, Status::Refused | Status::Failed));
    let reasons: Vec<String> =
        stopped.map(|l| format!("{}: {}", l.input, l.reason.as_deref().unwrap_or("no reason"))).collect();
    if !reasons.is_empty() {
        page.section("Refused and failed", "", reasons);
    }
    page.section("Every program", "", every_program(lines));
    super::compensator::sections(&mut page, robot, compensator);
    page.section("", "", super::compensator::methods());
    page
}

fn verdict_of(line: &Line) -> Option<&'static str> {
    line.path_error.as_ref().and_then(|p| p.verdict)
}

/// Share of a program's moves that are edited, %.
fn edited(l: &Line) -> Option<f64> {
    (l.moves > 0).then(|| 100.0 * l.editable as f64 / l.moves as f64)
}

/// Path errors of the programs with the largest, where verdicts are known, and the share of moves of those with the least.
fn folder_figures(page: &mut Page, folder: &str, lines: &[Line]) {
    let label = |l: &Line| {
        let within = l.input.strip_prefix(folder).map(|n| n.trim_start_matches(['/', '\\'])).filter(|n| !n.is_empty());
        within.unwrap_or(&l.input).to_string()
    };
    let first = |n: usize, which: &str| match n.saturating_sub(DRAWN) {
        0 => String::new(),
        _ => format!("The {DRAWN} programs with the {which}."),
    };
    let rms = |l: &Line| l.path_error.as_ref().and_then(|p| p.rms_um);
    let mut errors: Vec<(&Line, BeforeAfter)> = lines.iter().filter_map(|l| Some((l, rms(l)?))).collect();
    errors.sort_by(|a, b| b.1.after.total_cmp(&a.1.after));
    if !errors.is_empty() {
        let row = |(l, rms): &(&Line, BeforeAfter)| BarRow {
            label: label(l),
            values: vec![Some(rms.before), Some(rms.after)],
        };
        let bars = BarsView {
            quantity: "rms path error".into(),
            unit: "µm".into(),
            runs: vec![Run::new("before", Role::Before), Run::new("after", Role::After)],
            rows: errors.iter().take(DRAWN).map(row).collect(),
        };
        page.section(
            "Path error on a machine with these gaps and friction",
            first(errors.len(), "largest errors after"),
            bars,
        );
    }
    let mut least: Vec<(&Line, f64)> = lines.iter().filter_map(|l| Some((l, edited(l)?))).collect();
    least.sort_by(|a, b| a.1.total_cmp(&b.1));
    if !least.is_empty() {
        let row = |(l, share): &(&Line, f64)| BarRow { label: label(l), values: vec![Some(*share)] };
        let bars = BarsView {
            quantity: "moves edited".into(),
            unit: "%".into(),
            runs: vec![Run::new("edited", Role::After)],
            rows: least.iter().take(DRAWN).map(row).collect(),
        };
        page.section("Share of the moves whose targets are edited", first(least.len(), "lowest share"), bars);
    }
}

/// The table of a folder; verdicts where they are known.
fn every_program(lines: &[Line]) -> TableView {
    let known = lines.iter().any(|l| l.path_error.is_some());
    let row = |l: &Line| {
        let status = match l.status {
            Status::Written => "written",
            Status::WouldBeWritten => "would be written",
            Status::Unchanged => "unchanged",
            Status::Refused => "refused",
            Status::Failed => "failed",
        };
        let share = edited(l).map_or("-".into(), |s| format!("{s:.0}"));
        let mut row = vec![l.input.clone(), status.into(), l.moves.to_string(), share];
        row.extend([l.reversals.to_string(), l.inserted.to_string()]);
        if known {
            let of = |figure: fn(&PathErrors) -> Option<BeforeAfter>| {
                let figure = l.path_error.as_ref().and_then(figure);
                figure.map_or("-".into(), |p| format!("{:.1} \u{2192} {:.1}", p.before, p.after))
            };
            row.extend([verdict_of(l).unwrap_or("-").into(), of(|p| p.rms_um), of(|p| p.largest_um)]);
        }
        row
    };
    let mut columns = vec![
        ("program", false),
        ("result", false),
        ("moves", true),
        ("edited, %", true),
        ("reversals", true),
        ("points added", true),
    ];
    if known {
        columns.extend([("verdict", false), ("rms, µm", true), ("largest, µm", true)]);
    }
    TableView::new(&columns, lines.iter().map(row))
}

/// Changes that a page lists.
const LISTED: usize = 500;

/// What of a vendor program can be edited, and what was.
fn vendor(page: &mut Page, v: &Vendor, robot: &Robot) {
    page.tile(Tile::text("format", v.title, ""));
    page.tile(Tile::text("moves edited", format!("{} of {}", v.coverage.editable, v.coverage.moves), ""));
    if !v.coverage.reasons.is_empty() {
        let row = |r: &Reason| vec![format!("{}{}", r.why, v.lost_at(r)), r.moves.to_string(), r.lines_text()];
        let headings = [("why", false), ("moves", true), ("where", false)];
        let table = TableView::new(&headings, v.coverage.reasons.iter().map(row));
        page.section("Moves that stay as they are", "", table);
    }
    let mut words: Vec<String> = Vec::new();
    for (why, lines) in v.lost_elsewhere() {
        let lines: Vec<String> = lines.iter().map(u64::to_string).collect();
        words.push(format!("directions are lost at {why}: line {}", lines.join(", ")));
    }
    words.extend(v.notes.iter().map(|n| format!("line {}: {}", n.place.line, n.text)));
    if !words.is_empty() {
        page.section("Remarks", "", words);
    }
    if !v.changes.is_empty() {
        let row = |c: &Change| {
            let unit = |n: &str| robot.axis_named(n).map_or("", |a| robot.axis(a).kind.unit());
            let joints: Vec<String> = c.joints.iter().map(|(n, x)| format!("{n} {x:+.6} {}", unit(n))).collect();
            let what = if c.added { "new point" } else { "changed" };
            vec![c.line.to_string(), what.into(), joints.join(", "), format!("{:.1}", c.tcp_um)]
        };
        let headings = [("line", true), ("what", false), ("joints", false), ("at the TCP, µm", true)];
        let more = v.changes_total.saturating_sub(LISTED);
        let note =
            if more > 0 { format!("The first {LISTED}; {more} more are in the JSON document.") } else { String::new() };
        page.section("Change by change", note, TableView::new(&headings, v.changes.iter().take(LISTED).map(row)));
    }
}
