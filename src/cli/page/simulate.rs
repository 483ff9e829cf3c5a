//! Page of `simulate`: what was run on which machine.

use crate::effects::{Effect, EffectInstance, catalogue};
use crate::error::counted;
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
    page.verdict(
        Tone::Plain,
        format!("{} predicted with {}.", counted(written.rows, "row"), counted(model.effects.len(), "effect")),
    );
    page.tile(Tile::text("rows", written.rows.to_string(), ""));
    let row = |e: &EffectInstance| {
        let parameters: Vec<String> = match &e.effect {
            Effect::Backlash(b) if b.half_gap.constant().is_none() => {
                let kind = e.axis().map(|a| robot.axis(a).kind);
                let largest = kind.map_or(b.half_gap.largest(), |k| k.to_edge(b.half_gap.largest()));
                vec![format!("largest half gap {} {}", short(largest), kind.map_or("", |k| k.unit()))]
            }
            effect => e
                .keys(robot)
                .iter()
                .zip(effect.values())
                .map(|((key, factor), value)| format!("{key} {}", short(value * factor)))
                .collect(),
        };
        vec![
            e.effect.name().into(),
            e.target_text(robot),
            parameters.join(", "),
            catalogue::of(e.effect.name()).adds.into(),
        ]
    };
    let columns = ["effect", "target", "parameters", "what it does"].map(|c| (c.to_string(), false)).to_vec();
    page.section("The machine", "", TableView { columns, rows: model.effects.iter().map(row).collect() });
    if !written.notes.is_empty() {
        page.section("", "", written.notes.clone());
    }
    page.section("", "", vec![method::PLAY, method::STICTION]);
    page
}

/// A number with six digits at most.
fn short(v: f64) -> String {
    let digits = if v == 0.0 { 0 } else { (5 - v.abs().log10().floor() as i32).clamp(0, 9) as usize };
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
