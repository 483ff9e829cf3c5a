//! Page of `simulate`: what was run on which machine.

use super::milli;
use crate::effect::{Decay, Effect};
use crate::model::Model;
use crate::report::{Page, TableView, Tile, Tone, method};
use crate::simulate::Written;

/// The input of a run.
pub struct From {
    pub name: String,
    pub sha256: String,
}

pub fn of_run(model: &Model, input: &From, written: &Written) -> Page {
    let robot = &model.robot;
    let mut page = super::start("simulate", "A predicted log", robot);
    page.file("input", input.name.clone(), input.sha256.clone());
    page.verdict(Tone::Plain, format!("{} rows predicted with {} effects.", written.rows, model.effects.len()));
    page.tile(Tile::text("rows", written.rows.to_string(), ""));
    let row = |e: &crate::effect::entry::Placed| {
        let (size, more) = match &e.effect {
            Effect::Backlash(b) => (b.half_gap.largest(), String::new()),
            Effect::Stiction(s) => (
                s.spike,
                match s.decay {
                    Decay::Time(t) => format!("decays over {t} s"),
                    Decay::Travel(x) => format!(
                        "decays over {:.4} {}",
                        robot.axis(e.axis).kind.to_edge(x),
                        robot.axis(e.axis).kind.unit()
                    ),
                },
            ),
        };
        vec![
            e.effect.name().into(),
            robot.axis(e.axis).name.clone(),
            format!("{:.3}", milli(robot, e.axis, size)),
            more,
        ]
    };
    let columns = vec![
        ("effect".into(), false),
        ("joint".into(), false),
        ("size, mdeg or µm".into(), true),
        ("decay".into(), false),
    ];
    page.section("The machine", "", TableView { columns, rows: model.effects.iter().map(row).collect() });
    if !written.notes.is_empty() {
        page.section("", "", written.notes.clone());
    }
    page.section("", "", vec![method::PLAY, method::STICTION]);
    page
}
