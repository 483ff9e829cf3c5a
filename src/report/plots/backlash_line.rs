//! Errors at poses reached from both sides, and the backlash over position with its fit (Slamani (2012) figures 3 to 10).

use super::axes::{Frame, Size, extent, usable, widen};
use super::{dropped_note, line, nothing};
use crate::report::bidirectional::*;
use crate::report::number::{interval, number, px};
use maud::{Markup, html};

/// Colours of states, as classes; they repeat beyond these.
const COLOURS: usize = 6;

/// One panel a state, one scale for all.
pub fn both_ways(view: &BothWaysView) -> Markup {
    let every = || view.panels.iter().flat_map(|p| p.forward.iter().chain(&p.backward));
    let xs = extent(every().map(|w| w.at_mm));
    let band = |w: &WayPoint| [w.mean_um - w.band_um, w.mean_um + w.band_um];
    let ys = extent(every().flat_map(|w| band(w).into_iter().chain(w.readings_um.iter().copied())));
    let (Some(xs), Some(ys)) = (xs, ys) else { return nothing("no error is a finite number") };
    let size = Size { top: 24.0, height: 230.0, ..Size::SMALL };
    html! {
        div.legends { ul.legend {
            li { span.swatch.up {} "forward: mean" }
            li { span.swatch.down {} "backward: mean" }
            li { span.swatch.half {} "± 3 standard deviations" }
            li { span.swatch.cycle {} "one reading" }
        } }
        div.panels.small { @for panel in &view.panels {
            figure.panel {
                figcaption { (panel.title) }
                (both_ways_svg(panel, &Frame::new(size, widen(xs, 0.04), widen(ys, 0.06), false)))
                (dropped_note(panel.forward.iter().chain(&panel.backward).filter(|w| !usable(w.mean_um)).count()))
            }
        } }
    }
}

fn both_ways_svg(panel: &BothWaysPanel, frame: &Frame) -> Markup {
    let ways = [("up", &panel.forward, -2.5), ("down", &panel.backward, 2.5)];
    html! {
        svg role="img" aria-label=(format!("Errors at poses in both directions, {}", panel.title)) viewBox=(frame.size.view_box()) {
            (frame.axes("position, mm", "error, µm"))
            @for (class, way, _) in &ways {
                @let outline = band(frame, way.iter().map(|w| (w.at_mm, [w.mean_um - w.band_um, w.mean_um + w.band_um])));
                @if !outline.is_empty() { path.half.(*class) d=(outline) {} }
            }
            @for (class, way, aside) in &ways {
                @let dots = way.iter().flat_map(|w| w.readings_um.iter().filter(|e| usable(**e)).map(|e| [frame.x.at(w.at_mm) + aside, frame.y.at(*e)]));
                path.dots.few.(*class) d=(line::dots(dots)) {}
                @let (x, y): (Vec<f64>, Vec<f64>) = way.iter().map(|w| (w.at_mm, w.mean_um)).unzip();
                path.way.(*class) d=(line::path(line::in_frame(frame, &line::points(&x, &y).0))) {}
            }
        }
    }
}

/// Outline between two edges; empty with fewer than two points.
fn band(frame: &Frame, edges: impl Iterator<Item = (f64, [f64; 2])>) -> String {
    let good = edges.filter(|(x, [lo, hi])| usable(*x) && usable(*lo) && usable(*hi));
    let (low, high): (Vec<_>, Vec<_>) =
        good.map(|(x, [lo, hi])| ([frame.x.at(x), frame.y.at(lo)], [frame.x.at(x), frame.y.at(hi)])).unzip();
    if low.len() < 2 {
        return String::new();
    }
    line::path(low.into_iter().chain(high.into_iter().rev()).map(Some)) + "z"
}

/// All states in one figure.
pub fn curves(view: &BacklashCurvesView) -> Markup {
    let Some(frame) = curves_frame(view) else { return nothing("no backlash is a finite number") };
    let dropped = view.states.iter().flat_map(|s| &s.points).filter(|p| !usable(p.backlash_um)).count();
    html! {
        div.legends { ul.legend {
            @for (k, s) in view.states.iter().enumerate() {
                li { span.swatch.(colour(k)) {} @if s.name.is_empty() { "backlash and its fit" } @else { (s.name) } }
            }
            li { span.swatch.half {} "95 % band of the fit; bars: 95 % of a pose" }
        } }
        figure.single {
            svg role="img" aria-label="Backlash over position with its fit" viewBox=(frame.size.view_box()) { (curves_content(view, &frame)) }
            (dropped_note(dropped))
        }
    }
}

/// The plane of the figure of all states; `None` where nothing can be drawn.
pub fn curves_frame(view: &BacklashCurvesView) -> Option<Frame> {
    let points = || view.states.iter().flat_map(|s| &s.points);
    let xs = extent(points().map(|p| p.at_mm).chain(view.states.iter().flat_map(|s| s.at_mm.iter().copied())))?;
    let of_points = points().flat_map(|p| p.ci95_um.into_iter().flatten().chain([p.backlash_um]));
    let of_fits = view.states.iter().flat_map(|s| s.fit_um.iter().copied());
    let [lo, hi] = extent(of_points.chain(of_fits))?;
    let size = Size { height: 300.0, top: 26.0, ..Size::WIDE };
    Some(Frame::new(size, widen(xs, 0.04), widen([lo.min(0.0), hi.max(0.0)], 0.06), false))
}

/// What stands in the figure of all states.
pub fn curves_content(view: &BacklashCurvesView, frame: &Frame) -> Markup {
    let n = view.states.len() as f64;
    html! {
        (frame.axes("position, mm", "backlash, forward minus backward, µm"))
        @for (k, s) in view.states.iter().enumerate() {
            @let outline = band(frame, s.at_mm.iter().copied().zip(s.band_um.iter().copied()));
            @if !outline.is_empty() { path.half.(colour(k)) d=(outline) {} }
            @if !s.fit_um.is_empty() {
                path.line.(colour(k)) d=(line::path(line::in_frame(frame, &line::points(&s.at_mm, &s.fit_um).0))) {}
            }
        }
        @for (k, s) in view.states.iter().enumerate() {
            @for p in s.points.iter().filter(|p| usable(p.at_mm) && usable(p.backlash_um)) {
                // states of one pose stand side by side
                @let x = frame.x.at(p.at_mm) + 5.0 * (k as f64 - (n - 1.0) / 2.0);
                g.mark.own.(colour(k)) {
                    title { (hover_text(s, p)) }
                    @if let Some(ci) = p.ci95_um { @if ci.iter().all(|v| usable(*v)) {
                        line x1=(px(x)) x2=(px(x)) y1=(px(frame.y.at(ci[0]))) y2=(px(frame.y.at(ci[1]))) {}
                    } }
                    circle.glyph.(colour(k)) cx=(px(x)) cy=(px(frame.y.at(p.backlash_um))) r="3" {}
                }
            }
        }
    }
}

fn hover_text(s: &BacklashCurve, p: &BacklashPoint) -> String {
    let name = if s.name.is_empty() { String::new() } else { format!("{}, ", s.name) };
    let ci = p.ci95_um.map_or(String::new(), |c| format!(" ({})", interval(c, 1)));
    format!("{name}{} mm: {} µm{ci}", number(p.at_mm, 1), number(p.backlash_um, 1))
}

/// Class of a state's colour.
fn colour(k: usize) -> String {
    format!("j{}", [5, 0, 1, 3, 2, 4][k % COLOURS])
}
