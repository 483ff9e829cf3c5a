//! Joint errors over time, command or travel: measured points, the model's line, reversals (Zhang (2023) figures 3 and 13).
//!
//! The panels of one joint share both scales, so that before and after compare by eye.

use super::axes::{Frame, Size, extent, spread, usable, widen};
use super::joints::{Joints, turning};
use super::{dropped_note, legend, line, nothing, role_class};
use crate::report::figures::{JointTraces, Run, TraceMark, TracePanel, TracesView};
use crate::report::number::px;
use maud::{Markup, html};

/// Marks beyond this in one panel are not drawn but counted.
const MARKS: usize = 200;
/// Fewer measured points than this are drawn larger.
const FEW: usize = 400;
/// Furthest that a mark's name stands aside, px.
const ASIDE: f64 = 24.0;
/// Width of a letter of a mark's name, about, px.
const LETTER: f64 = 7.2;

/// All rows.
pub fn draw(view: &TracesView, joints: &Joints) -> Markup {
    let panels = || view.joints.iter().flat_map(|j| &j.panels);
    if panels().all(|p| p.runs.iter().all(|r| r.x.is_empty() && r.model_x.is_empty())) {
        return nothing("the traces are empty");
    }
    let mut runs: Vec<&Run> = Vec::new();
    for r in panels().flat_map(|p| &p.runs).map(|r| &r.run) {
        if !runs.iter().any(|known| known.name == r.name) {
            runs.push(r);
        }
    }
    let has_model = !view.y_whole && panels().flat_map(|p| &p.runs).any(|r| !r.model_x.is_empty());
    let model: &[(&str, &str)] = if has_model { &[("model", "model")] } else { &[] };
    html! {
        div.legends {
            // whole positions are drawn as the model's line
            @if view.y_whole { (legend([], &runs.iter().map(|r| ("model", r.name.as_str())).collect::<Vec<_>>())) }
            @else { (legend(runs, model)) }
            (joints.legend(panels().flat_map(|p| &p.marks).map(|m| m.joint.as_str())))
        }
        @for joint in &view.joints { (row(view, joint, joints)) }
    }
}

fn row(view: &TracesView, joint: &JointTraces, joints: &Joints) -> Markup {
    let runs = || joint.panels.iter().flat_map(|p| &p.runs);
    let xs = extent(runs().flat_map(|r| r.x.iter().chain(&r.model_x)).copied());
    let ys = extent(runs().flat_map(|r| r.error_milli.iter().chain(&r.model_milli)).copied());
    let small = joint.panels.len() > 2;
    html! {
        div.row {
            h3 { (joint.joint) }
            @if let (Some(xs), Some(ys)) = (xs, ys) {
                div.panels.small[small] {
                    @for panel in &joint.panels {
                        @let size = if small { Size { top: 42.0, ..Size::SMALL } } else { Size::WIDE };
                        @let frame = Frame::new(size, widen(xs, 0.01), widen(ys, 0.06), view.x_unit == "deg");
                        @let frame = if view.x_unit == "points" { frame.counting() } else { frame };
                        (draw_panel(view, joint, panel, &frame, joints))
                    }
                }
            } @else { (nothing("no value of this joint is a finite number")) }
        }
    }
}

fn draw_panel(view: &TracesView, joint: &JointTraces, panel: &TracePanel, frame: &Frame, joints: &Joints) -> Markup {
    let quantity = if view.y_name.is_empty() { "error" } else { &view.y_name };
    let unit = if view.y_whole { joints.unit(&joint.joint) } else { joints.milli_unit(&joint.joint) };
    let label = format!("{} of joint {}, {}, over {}", quantity, joint.joint, panel.title, view.x_name);
    let mut dropped = 0;
    let drawn: Vec<_> = panel
        .runs
        .iter()
        .map(|r| {
            let (measured, lost) = line::points(&r.x, &r.error_milli);
            let (model, lost_model) = line::points(&r.model_x, &r.model_milli);
            dropped += lost + lost_model;
            let kept: Vec<[f64; 2]> = line::in_frame(frame, &measured).into_iter().flatten().collect();
            let few = kept.len() < FEW;
            (role_class(r.run.role), few, line::dots(kept), line::path(line::in_frame(frame, &model)))
        })
        .collect();
    html! {
        figure.panel {
            @if !panel.title.is_empty() { figcaption { (panel.title) } }
            svg role="img" aria-label=(label) viewBox=(frame.size.view_box()) {
                (frame.axes(&format!("{}, {}", view.x_name, view.x_unit), &format!("{quantity}, {unit}")))
                (marks(&panel.marks, &joint.joint, frame, joints))
                @for (class, few, dots, _) in &drawn {
                    @if !dots.is_empty() { path.dots.few[*few].(class) d=(dots) {} }
                }
                @for (class, _, _, model) in &drawn { @if !model.is_empty() { path.model.(class) d=(model) {} } }
            }
            (dropped_note(dropped))
        }
    }
}

/// Reversals: a line through the plot, the joint's mark and name above it; the panel's own joint stronger.
fn marks(all: &[TraceMark], own: &str, frame: &Frame, joints: &Joints) -> Markup {
    let mut seen: Vec<&TraceMark> = all.iter().filter(|m| usable(m.x) && frame.x.holds(m.x)).collect();
    seen.sort_by(|a, b| a.x.total_cmp(&b.x));
    let more = seen.len().saturating_sub(MARKS);
    seen.truncate(MARKS);
    let at: Vec<f64> = seen.iter().map(|m| frame.x.at(m.x)).collect();
    let letters = seen.iter().map(|m| m.joint.chars().count()).max().unwrap_or(0) + 1;
    let width = 5.0 + LETTER * letters as f64;
    let room = [frame.x.from_px + width / 2.0 - 5.0, frame.x.to_px - width / 2.0 + 5.0];
    let names = spread(&at, width, room);
    // a name that would stand far from its mark says more wrong than right
    let near = at.iter().zip(&names).all(|(a, n)| (a - n).abs() <= ASIDE);
    let named = near && (seen.len() as f64 - 1.0) * width <= room[1] - room[0];
    let top = frame.size.top;
    html! {
        @for ((m, &x), &name_x) in seen.iter().zip(&at).zip(&names) {
            line.mark.own[m.joint == own].(joints.class(&m.joint)) x1=(px(x)) x2=(px(x)) y1=(px(top)) y2=(px(frame.y.from_px)) {}
            (joints.glyph(&m.joint, x, top - 2.0, if named { 3.6 } else { 2.4 }))
            @if named { text.mark-name x=(px(name_x)) y=(px(top - 9.0)) text-anchor="middle" { (turning(&m.joint, m.sense)) } }
        }
        @if more > 0 {
            text.mark-name x=(px(frame.x.to_px)) y="12" text-anchor="end" { (more) " further reversals not drawn" }
        }
    }
}
