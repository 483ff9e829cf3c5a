//! Page of `simulate`: what was run on which machine.

use crate::error::counted;
use crate::log::Log;
use crate::model::Model;
use crate::report::{Page, Tile, Tone, method};

/// The input of a run.
pub struct From {
    pub name: String,
    pub sha256: String,
}

pub fn of_run(model: &Model, input: &From, rows: usize, notes: Vec<String>, log: Option<&Log>) -> Page {
    let robot = &model.robot;
    let mut page = super::start("simulate", "A predicted log", robot);
    page.file("input", input.name.clone(), input.sha256.clone());
    page.verdict(
        Tone::Plain,
        format!("{} predicted with {}.", counted(rows, "row"), counted(model.effects.len(), "effect")),
    );
    page.tile(Tile::text("rows", rows.to_string(), ""));
    if let Some(log) = log {
        super::show::figures_of_log(&mut page, robot, log);
    }
    if !model.effects.is_empty() {
        page.section("The machine", "", super::effects(model));
    }
    if !notes.is_empty() {
        page.section("", "", notes);
    }
    page.section("", "", vec![method::PLAY, method::STICTION]);
    page
}
