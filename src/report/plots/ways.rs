//! A joint's error over its position, moving up and moving down: medians as lines, the middle half of the samples as bands.
//!
//! What is the same in both directions is geometry, compliance or gear ripple; what differs is lost motion or lag.

use super::axes::{Frame, Size, extent, widen};
use super::joints::Joints;
use super::{dropped_note, line, nothing};
use crate::report::diagnosis::{JointWays, WayView, WaysPanel, WaysView};
use maud::{Markup, html};

/// Four in a row on a wide screen.
const PANEL: Size = Size { width: 280.0, height: 190.0, left: 40.0, right: 8.0, top: 24.0, bottom: 38.0 };

/// All joints.
pub fn draw(view: &WaysView, joints: &Joints) -> Markup {
    if view.joints.iter().all(|j| every(j).next().is_none()) {
        return nothing("no joint moves");
    }
    html! {
        div.legends { ul.legend {
            li { span.swatch.up {} "moving up" }
            li { span.swatch.down {} "moving down" }
            li { span.swatch.half {} "middle half of the samples" }
        } }
        div.ways { @for joint in &view.joints { (row(joint, joints)) } }
    }
}

fn every(joint: &JointWays) -> impl Iterator<Item = (f64, [f64; 3])> + '_ {
    let both = joint.panels.iter().flat_map(|p| [&p.up, &p.down]);
    both.flat_map(|w| w.at_deg_mm.iter().copied().zip(w.quartiles_milli.iter().copied()))
}

fn row(joint: &JointWays, joints: &Joints) -> Markup {
    let xs = extent(every(joint).map(|e| e.0));
    let ys = extent(every(joint).flat_map(|e| e.1));
    html! {
        div.row {
            h3 { (joint.joint) }
            @if let (Some(xs), Some(ys)) = (xs, ys) {
                div.panels.small { @for panel in &joint.panels {
                    (draw_panel(joint, panel, &Frame::new(PANEL, widen(xs, 0.01), widen(ys, 0.06), joints.unit(&joint.joint) == "deg"), joints))
                } }
            } @else { (nothing("no value of this joint is a finite number")) }
        }
    }
}

fn draw_panel(joint: &JointWays, panel: &WaysPanel, frame: &Frame, joints: &Joints) -> Markup {
    let (unit, milli) = (joints.unit(&joint.joint), joints.milli_unit(&joint.joint));
    let mut dropped = 0;
    let drawn: Vec<_> = [("up", &panel.up), ("down", &panel.down)]
        .map(|(class, way)| {
            let middle: Vec<f64> = way.quartiles_milli.iter().map(|q| q[1]).collect();
            let (points, lost) = line::points(&way.at_deg_mm, &middle);
            dropped += lost;
            (class, band(way, frame), line::path(line::in_frame(frame, &points)))
        })
        .into();
    html! {
        figure.panel {
            figcaption { (panel.title) }
            svg role="img" aria-label=(format!("Error of joint {} over its position in both directions, {}", joint.joint, panel.title)) viewBox=(frame.size.view_box()) {
                (frame.axes(&format!("{}, {unit}", joint.joint), &format!("error, {milli}")))
                @for (class, band, _) in &drawn { @if !band.is_empty() { path.half.(class) d=(band) {} } }
                @for (class, _, d) in &drawn { @if !d.is_empty() { path.way.(class) d=(d) {} } }
            }
            (dropped_note(dropped))
        }
    }
}

/// Outline between the quartiles.
fn band(way: &WayView, frame: &Frame) -> String {
    let edge = |k: usize| {
        let y: Vec<f64> = way.quartiles_milli.iter().map(|q| q[k]).collect();
        let good = line::points(&way.at_deg_mm, &y).0;
        good.into_iter().flatten().map(|[x, y]| [frame.x.at(x), frame.y.at(y)]).collect::<Vec<_>>()
    };
    let (low, high) = (edge(0), edge(2));
    if low.len() < 2 {
        return String::new();
    }
    line::path(low.into_iter().chain(high.into_iter().rev()).map(Some)) + "z"
}
