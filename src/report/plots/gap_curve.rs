//! Half gap over position, one panel a joint (Zhang (2023) figure 5): mean and 95 % interval at each place, each cycle as a dot,
//! the schedule or the constant that is used, with its band. The same for lost motion over the time since a reversal.

use super::axes::{Frame, Scale, Size, extent, from_zero, usable, widen};
use super::joints::Joints;
use super::{dropped_note, line, nothing};
use crate::error::counted;
use crate::report::figures::{GapPointView, GapsOver, GapsView, JointGapView};
use crate::report::number::{interval, number, px};
use maud::{Markup, html};

/// All joints.
pub fn draw(view: &GapsView, joints: &Joints) -> Markup {
    if view.joints.is_empty() {
        return nothing("no joint was identified");
    }
    html! {
        div.legends {
            ul.legend {
                @let [interval, cycle, _, _] = words(view.over);
                li { span.swatch.interval {} (interval) }
                @if view.joints.iter().flat_map(|j| &j.points).any(|p| !p.per_cycle_milli.is_empty()) {
                    li { span.swatch.cycle {} (cycle) }
                }
                li { span.swatch.used {} "value that is used, with its 95 % band" }
            }
        }
        div.panels.small { @for joint in &view.joints { (panel(view.over, joint, joints)) } }
    }
}

/// What an interval, a dot and both axes stand for.
fn words(over: GapsOver) -> [&'static str; 4] {
    match over {
        GapsOver::Position => ["mean and 95 % interval", "one cycle", "position", "half gap"],
        GapsOver::SinceReversal => {
            ["mean of single reversals, twice their scatter", "one reversal", "since the reversal", "lost motion"]
        }
    }
}

/// The same in the unit that the page shows gaps in.
fn scaled(joint: &JointGapView, factor: f64) -> JointGapView {
    let mut joint = joint.clone();
    for p in &mut joint.points {
        p.half_gap_milli *= factor;
        p.ci95_milli.iter_mut().chain(&mut p.per_cycle_milli).for_each(|v| *v *= factor);
    }
    if let Some((value, ci95)) = &mut joint.constant_milli {
        *value *= factor;
        ci95.iter_mut().for_each(|v| *v *= factor);
    }
    if let Some(s) = &mut joint.schedule {
        s.half_gap_milli.iter_mut().chain(s.band_milli.iter_mut().flatten()).for_each(|v| *v *= factor);
    }
    joint
}

fn panel(over: GapsOver, joint: &JointGapView, joints: &Joints) -> Markup {
    let (factor, gap_unit, decimals) = joints.gaps(&joint.joint);
    let joint = &scaled(joint, factor);
    let points = || joint.points.iter();
    let schedule = || joint.schedule.iter();
    let xs = extent(points().map(|p| p.at_deg_mm).chain(schedule().flat_map(|s| s.at_deg_mm.iter().copied())));
    let constant = joint.constant_milli.iter().flat_map(|(v, ci)| [*v, ci[0], ci[1]]);
    let ys = extent(
        points()
            .flat_map(|p| p.per_cycle_milli.iter().chain(&p.ci95_milli).copied().chain([p.half_gap_milli]))
            .chain(
                schedule().flat_map(|s| s.half_gap_milli.iter().copied().chain(s.band_milli.iter().flatten().copied())),
            )
            .chain(constant),
    );
    let name = &joint.joint;
    let unit = if over == GapsOver::Position { joints.unit(name) } else { "s" };
    let [_, _, x_name, y_name] = words(over);
    let frame = Frame::new(
        Size { top: 24.0, height: 224.0, ..Size::SMALL },
        widen(xs.unwrap_or([0.0, 0.0]), 0.05),
        from_zero(ys),
        unit == "deg",
    );
    let bad = |p: &GapPointView| !(usable(p.at_deg_mm) && usable(p.half_gap_milli));
    let dropped =
        points().map(|p| usize::from(bad(p)) + p.per_cycle_milli.iter().filter(|v| !usable(**v)).count()).sum();
    html! {
        figure.panel {
            figcaption { strong { (name) } @if !joint.finding.is_empty() { " " (joint.finding) } }
            @if ys.is_none() { (nothing("no value of this joint is a finite number")) }
            @else {
                svg role="img" aria-label=(format!("{y_name} of joint {name}, {x_name}: {}", joint.finding)) viewBox=(frame.size.view_box()) {
                    (frame.axes(&format!("{x_name}, {unit}"), &format!("{y_name}, {gap_unit}")))
                    @if let Some((value, ci)) = joint.constant_milli { @if usable(value) { (constant_line(&frame, value, ci)) } }
                    @if let Some(s) = &joint.schedule { (schedule_line(&frame, s)) }
                    @for p in points().filter(|p| !bad(p)) { (point(&frame, p, unit, gap_unit, decimals)) }
                }
            }
            (dropped_note(dropped))
        }
    }
}

fn constant_line(frame: &Frame, value: f64, ci: [f64; 2]) -> Markup {
    let Scale { from_px: left, to_px: right, .. } = frame.x;
    let y = frame.y.at(value);
    html! {
        @if ci.iter().all(|v| usable(*v)) {
            rect.band x=(px(left)) width=(px(right - left)) y=(px(frame.y.at(ci[0].max(ci[1])))) height=(px((frame.y.at(ci[0]) - frame.y.at(ci[1])).abs())) {}
        }
        line.used x1=(px(left)) x2=(px(right)) y1=(px(y)) y2=(px(y)) {}
    }
}

fn schedule_line(frame: &Frame, s: &crate::report::figures::ScheduleView) -> Markup {
    let (mean, _) = line::points(&s.at_deg_mm, &s.half_gap_milli);
    let edge = |k: usize| {
        let edge: Vec<f64> = s.band_milli.iter().map(|b| b[k]).collect();
        line::in_frame(frame, &line::points(&s.at_deg_mm, &edge).0).into_iter().flatten().collect::<Vec<_>>()
    };
    let (low, high) = (edge(0), edge(1));
    let band = line::path(high.into_iter().chain(low.into_iter().rev()).map(Some));
    html! {
        @if !band.is_empty() { path.band d=(format!("{band}Z")) {} }
        path.used d=(line::path(line::in_frame(frame, &mean))) {}
    }
}

fn point(frame: &Frame, p: &GapPointView, unit: &str, gap_unit: &str, decimals: usize) -> Markup {
    let (x, y) = (frame.x.at(p.at_deg_mm), frame.y.at(p.half_gap_milli));
    let n = p.per_cycle_milli.len() as f64;
    // cycles stand side by side in their order, within 10 px
    let step = (9.0 / (n - 1.0).max(1.0)).min(2.4);
    let cycles = p.per_cycle_milli.iter().enumerate().filter(|(_, v)| usable(**v));
    let dots = line::dots(cycles.map(|(k, v)| [x + (k as f64 - (n - 1.0) / 2.0) * step, frame.y.at(*v)]));
    let hover_text = format!(
        "{} {unit}: {} {gap_unit} ({}){}",
        number(p.at_deg_mm, 1),
        number(p.half_gap_milli, decimals),
        interval(p.ci95_milli, decimals),
        if p.per_cycle_milli.is_empty() {
            String::new()
        } else {
            format!(", {}", counted(p.per_cycle_milli.len(), "cycle"))
        }
    );
    html! {
        @if !dots.is_empty() { path.cycles d=(dots) {} }
        g.mean {
            title { (hover_text) }
            @if p.ci95_milli.iter().all(|v| usable(*v)) {
                line x1=(px(x)) x2=(px(x)) y1=(px(frame.y.at(p.ci95_milli[0]))) y2=(px(frame.y.at(p.ci95_milli[1]))) {}
            }
            circle cx=(px(x)) cy=(px(y)) r="2.6" {}
        }
    }
}
