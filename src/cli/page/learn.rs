//! Page of `learn`: errors of the learned and of the nominal kinematics.

use crate::learn::{Kind, LETTERS, Rmse, TrainingResult};
use crate::report::{HistogramRun, HistogramView, Method, Page, Role, Run, TableView, Tile, Tone};
use crate::robot::Robot;

/// Where the method is from.
const PAPER: &str = "Model Learning with Backlash Compensation for a Tendon-Driven Surgical Robot";

pub fn of_training(robot: &Robot, lesson: &TrainingResult) -> Page {
    let l = &lesson.learned;
    let e = &l.evidence;
    let mut page = super::start("learn", "Learned kinematics", robot);
    for log in &e.logs {
        page.file("log", log.name.clone(), log.sha256.clone());
    }
    for program in &e.programs {
        page.file("desired commands", program.name.clone(), program.sha256.clone());
    }
    let mean = |d: &[f64]| d.iter().sum::<f64>() / d.len().max(1) as f64 * 1e3;
    let ours = mean(&lesson.distances_m);
    let nominal = lesson.nominal.as_ref().map(|n| mean(&n.distances_m));
    let tone = match nominal {
        Some(n) if ours < 0.5 * n => Tone::Good,
        Some(n) if ours >= n => Tone::Bad,
        _ => Tone::Plain,
    };
    let rows = if e.test_rows > 0 { "test rows" } else { "rows learned from" };
    let beside = nominal.map_or(String::new(), |n| format!("; the error of the nominal kinematics is {n:.3} mm"));
    page.verdict(tone, format!("The learned TCP is {ours:.3} mm from the measured one on average ({rows}){beside}."));
    page.tile(Tile::number("mean distance", ours, 3, "mm"));
    page.tile(Tile::text("rows learned from", e.train_rows.to_string(), ""));
    page.tile(Tile::text("rows tested on", e.test_rows.to_string(), ""));
    let run = |name: &str, role, distances: &[f64]| HistogramRun {
        run: Run::new(name, role),
        values: distances.iter().map(|d| d * 1e3).collect(),
        p95: None,
    };
    let mut runs = Vec::new();
    runs.extend(lesson.nominal.as_ref().map(|n| run("nominal", Role::Before, &n.distances_m)));
    runs.push(run("learned", Role::After, &lesson.distances_m));
    let view = HistogramView { quantity: "distance from the measured TCP".into(), unit: "mm".into(), runs };
    page.section("How far off", "Over the coordinates that were learned.", view);
    let how =
        "Root mean square errors. The nominal kinematics are placed in the frame that fits the training rows best.";
    page.section("Errors in the manner of Table II", how, errors(lesson));
    if !lesson.notes.is_empty() {
        page.section("", "", lesson.notes.iter().map(ToString::to_string).collect::<Vec<_>>());
    }
    let text = match l.kind {
        Kind::Plain => {
            "One network with one hidden layer of sigmoid neurons for each coordinate, trained on positions alone."
        }
        Kind::Augmented => {
            "One network with one hidden layer of sigmoid neurons for each coordinate, trained on positions and, through its exact derivative, on velocities (weights 0.001 and 1)."
        }
    };
    page.section("", "", vec![Method::new("Learned forward kinematics", text, PAPER)]);
    page
}

/// Root mean square errors of each coordinate.
fn errors(lesson: &TrainingResult) -> TableView {
    let (l, e) = (&lesson.learned, &lesson.learned.evidence);
    let mut rows = Vec::new();
    for (k, &c) in l.coordinates.iter().enumerate() {
        let mut row = |who: &str, train: &[Rmse], test: &[Rmse]| {
            let p = |all: &[Rmse]| all.get(k).map_or("–".into(), |r| format!("{:.4}", r.position_m * 1e3));
            let v =
                |all: &[Rmse]| all.get(k).and_then(|r| r.speed_m_s).map_or("–".into(), |v| format!("{:.4}", v * 1e3));
            rows.push(vec![LETTERS[c].into(), who.into(), p(train), p(test), v(train), v(test)]);
        };
        row("learned", &e.train, &e.test);
        if let Some(n) = &lesson.nominal {
            row("nominal", &n.train, &n.test);
        }
    }
    let columns = [
        ("coordinate", false),
        ("kinematics", false),
        ("position, train, mm", true),
        ("position, test, mm", true),
        ("velocity, train, mm/s", true),
        ("velocity, test, mm/s", true),
    ];
    TableView::new(&columns, rows)
}
