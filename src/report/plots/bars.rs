//! Horizontal bars: several runs side by side, and a waterfall of what each step takes away.

use super::axes::{Scale, Ticks, extent, from_zero, usable};
use super::{dropped_note, legend, nothing, role_class};
use crate::report::figures::{BarsView, WaterfallView};
use crate::report::number::{number, px};
use maud::{Markup, html};

const WIDTH: f64 = 540.0;
const BAR: f64 = 13.0;
/// Width of a letter of a label, about, px.
const LETTER: f64 = 7.2;
/// Longest label, letters.
const LABEL: usize = 32;
/// Rows beyond this are not drawn but counted.
const ROWS: usize = 60;

/// Room for the labels on the left.
fn label_room<'a>(labels: impl Iterator<Item = &'a str>) -> f64 {
    (12.0 + LETTER * labels.map(|l| l.chars().count().min(LABEL)).max().unwrap_or(0) as f64).max(30.0)
}

/// A label that fits into the space.
fn cut(label: &str) -> String {
    if label.chars().count() <= LABEL {
        label.to_owned()
    } else {
        label.chars().take(LABEL - 1).chain(['…']).collect()
    }
}

fn grid(scale: &Scale, ticks: &Ticks, [top, bottom]: [f64; 2], title: &str) -> Markup {
    html! {
        @for &v in &ticks.values {
            line.grid.zero[v == 0.0] x1=(px(scale.at(v))) x2=(px(scale.at(v))) y1=(px(top)) y2=(px(bottom)) {}
            text.tick x=(px(scale.at(v))) y=(px(bottom + 16.0)) text-anchor="middle" { (ticks.label(v)) }
        }
        text.title x=(px(WIDTH - 4.0)) y=(px(bottom + 34.0)) text-anchor="end" { (title) }
    }
}

/// Bars in groups.
pub fn bars(view: &BarsView) -> Markup {
    let range = extent(view.rows.iter().flat_map(|r| r.values.iter().flatten().copied()));
    if range.is_none() {
        return nothing("there is no value to compare");
    }
    let rows = &view.rows[..view.rows.len().min(ROWS)];
    let left = label_room(rows.iter().map(|r| r.label.as_str()));
    let scale = Scale::new(from_zero(range), [left, WIDTH - 46.0]);
    let ticks = Ticks::new([scale.lo, scale.hi], 6);
    let group = BAR * view.runs.len().max(1) as f64 + 10.0;
    let bottom = group * rows.len() as f64 + 6.0;
    let dropped = view.rows.iter().flat_map(|r| r.values.iter().flatten()).filter(|v| !usable(**v)).count();
    html! {
        @if view.runs.len() > 1 { (legend(&view.runs, &[])) }
        figure.single {
            svg role="img" aria-label=(format!("{} in {}, compared", view.quantity, view.unit)) viewBox=(format!("0 0 {} {}", px(WIDTH), px(bottom + 40.0))) {
                (grid(&scale, &ticks, [2.0, bottom], &format!("{}, {}", view.quantity, view.unit)))
                @for (i, row) in rows.iter().enumerate() {
                    @let top = 6.0 + group * i as f64;
                    text.label x=(px(left - 8.0)) y=(px(top + (group - 10.0) / 2.0 + 4.0)) text-anchor="end" { (cut(&row.label)) }
                    @for (k, (value, run)) in row.values.iter().zip(&view.runs).enumerate() {
                        @if let Some(v) = value.filter(|v| usable(*v)) {
                            @let y = top + BAR * k as f64;
                            @let ends = [scale.at(0.0), scale.at(v)];
                            rect.bar.(role_class(run.role)) x=(px(ends[0].min(ends[1]))) y=(px(y + 1.0)) width=(px((ends[1] - ends[0]).abs().max(0.5))) height=(px(BAR - 2.0)) {
                                title { (row.label) ", " (run.name) ": " (number(v, 1)) " " (view.unit) }
                            }
                            text.value x=(px(ends[0].max(ends[1]) + 5.0)) y=(px(y + BAR - 2.5)) { (value_label(v)) }
                        }
                    }
                }
            }
            @if view.rows.len() > ROWS { p.dropped { "The first " (ROWS) " of " (view.rows.len()) " rows are drawn." } }
            (dropped_note(dropped))
        }
    }
}

/// A waterfall.
pub fn waterfall(view: &WaterfallView) -> Markup {
    let start = std::iter::once(&view.start);
    let all: Vec<&(String, f64)> = start.chain(&view.steps).filter(|(_, v)| usable(*v)).take(ROWS).collect();
    let dropped = (1 + view.steps.len()).min(ROWS).saturating_sub(all.len());
    let floor = view.floor.as_ref().filter(|(_, v)| usable(*v));
    let Some(last) = all.last() else {
        return nothing("no step has a finite value");
    };
    let left = label_room(all.iter().map(|(l, _)| l.as_str()).chain(["what is left"]));
    let range = extent(all.iter().map(|(_, v)| *v).chain(floor.map(|(_, v)| *v)));
    let scale = Scale::new(from_zero(range), [left, WIDTH - 70.0]);
    let ticks = Ticks::new([scale.lo, scale.hi], 6);
    let row = BAR + 13.0;
    // the name of the floor stands above the bars
    let top = if floor.is_some() { 22.0 } else { 6.0 };
    let bottom = row * (all.len() + 1) as f64 + top;
    let zero = scale.at(0.0);
    let bar = |i: usize, class: &str, a: f64, b: f64| {
        let y = top + row * i as f64;
        html! { rect.bar.(class) x=(px(a.min(b))) y=(px(y + 3.0)) width=(px((b - a).abs().max(0.5))) height=(px(BAR + 2.0)) {} }
    };
    let words = |i: usize, label: &str, x: f64, value: String| {
        let y = top + row * i as f64 + BAR + 1.0;
        html! {
            text.label x=(px(left - 8.0)) y=(px(y)) text-anchor="end" { (cut(label)) }
            text.value x=(px(x + 5.0)) y=(px(y)) { (value) }
        }
    };
    html! {
        figure.single {
            svg role="img" aria-label=(format!("{} in {}, step by step", view.quantity, view.unit)) viewBox=(format!("0 0 {} {}", px(WIDTH), px(bottom + 40.0))) {
                (grid(&scale, &ticks, [top - 4.0, bottom], &format!("{}, {}", view.quantity, view.unit)))
                @if let Some((name, v)) = floor {
                    line.floor x1=(px(scale.at(*v))) x2=(px(scale.at(*v))) y1="4" y2=(px(bottom)) {}
                    text.note x=(px(scale.at(*v) + 5.0)) y="13" { (name) " " (value_label(*v)) }
                }
                (bar(0, "before", zero, scale.at(all[0].1)))
                (words(0, &all[0].0, scale.at(all[0].1), value_label(all[0].1)))
                @for (i, pair) in all.windows(2).enumerate() {
                    @let (a, b) = (scale.at(pair[0].1), scale.at(pair[1].1));
                    line.link x1=(px(a)) x2=(px(a)) y1=(px(top + row * i as f64 + BAR + 5.0)) y2=(px(top + row * (i + 1) as f64 + 3.0)) {}
                    (bar(i + 1, if b > a { "rise" } else { "fall" }, a, b))
                    (words(i + 1, &pair[1].0, a.max(b), value_change(pair[1].1 - pair[0].1)))
                }
                (bar(all.len(), "after", zero, scale.at(last.1)))
                (words(all.len(), "what is left", scale.at(last.1).max(floor.map_or(0.0, |_| zero)), value_label(last.1)))
            }
            (dropped_note(dropped))
        }
    }
}

fn value_label(v: f64) -> String {
    number(v, if v.abs() < 10.0 { 1 } else { 0 })
}

fn value_change(v: f64) -> String {
    if v > 0.0 { format!("+{}", value_label(v)) } else { value_label(v) }
}
