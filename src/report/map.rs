//! Tables whose cells are coloured by a quantity: what a log is blind to, where structure is left.

use super::diagnosis::{MapBlock, MapCell, MapView};
use super::plots::heat::Colours;
use super::plots::nothing;
use maud::{Markup, html};

/// Joints, effects: beyond this they are not shown.
const MOST: usize = 60;

/// All tables.
pub(super) fn draw(view: &MapView) -> Markup {
    let sizes = || {
        let cells = view.blocks.iter().flat_map(|b| &b.rows).flat_map(|r| &r.1);
        cells.filter_map(|c| if let MapCell::Size { colour, .. } = c { Some(*colour) } else { None })
    };
    let hatched = view.blocks.iter().flat_map(|b| &b.rows).flat_map(|r| &r.1).any(|c| *c == MapCell::Hatched);
    if view.blocks.iter().all(|b| b.rows.is_empty()) {
        return nothing("there is nothing to compare");
    }
    let colours = if view.by_decades { Colours::by_decades(sizes()) } else { Colours::of(sizes(), 0.0) };
    let key = !view.quantity.is_empty() && sizes().next().is_some();
    html! {
        div.legends {
            @if key { (colours.key(&view.quantity, &view.unit)) }
            @if hatched { ul.legend { li { span.swatch-hatched {} (view.hatched) } } }
        }
        @for block in &view.blocks { @if !block.rows.is_empty() { div.scroll { (table(block, &colours)) } } }
    }
}

fn table(block: &MapBlock, colours: &Colours) -> Markup {
    html! {
        table.map {
            thead { tr {
                th scope="col" { (block.corner) }
                @for (name, unit) in block.columns.iter().take(MOST) {
                    th scope="col" { (name) @if !unit.is_empty() { br; small { (unit) } } }
                }
            } }
            tbody { @for (name, cells) in block.rows.iter().take(MOST) {
                tr { th scope="row" { (name) } @for c in cells.iter().take(MOST) { (cell(c, colours)) } }
            } }
        }
    }
}

fn cell(c: &MapCell, colours: &Colours) -> Markup {
    match c {
        MapCell::Absent => html! { td {} },
        MapCell::Word(w) => html! { td.word { (w) } },
        MapCell::Hatched => html! { td.hatched {} },
        MapCell::Size { text, colour } => {
            let level = colours.level(*colour);
            html! { td.light[Colours::is_light(level)].coloured style=(format!("background:{}", Colours::hex(level))) { (text) } }
        }
    }
}
