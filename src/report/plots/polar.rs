//! Errors around the circle (Zhang (2023) figure 11 b to d): total, in plane, out of plane, in µm over the circle's angle.
//!
//! The total starts from the middle; the two parts have signs, so their zero is a ring between the middle and the rim. The
//! each of three plots has its own scale.

use super::axes::{Scale, Ticks, extent, spread, usable};
use super::joints::{Joints, all_short, turning};
use super::{dropped_note, legend, line, nothing, role_class};
use crate::report::figures::{AngleMark, PolarRun, PolarView};
use crate::report::number::{number, px};
use maud::{Markup, html};

const CENTRE: [f64; 2] = [196.0, 174.0];
const RIM: f64 = 136.0;
/// Innermost ring of the parts with a sign, as a share of the rim.
const HUB: f64 = 0.12;
/// Slices of a turn into which samples are thinned.
const SLICES: f64 = 540.0;
/// Least distance of two ring labels, px.
const LABEL_GAP: f64 = 24.0;
/// Reversals beyond this are not named.
const NAMED: usize = 24;

type Part = fn(&PolarRun) -> &[f64];

/// The three plots.
pub fn draw(view: &PolarView, joints: &Joints) -> Markup {
    if view.runs.iter().all(|r| r.angle_deg.is_empty()) {
        return nothing("there is no sample of the circle");
    }
    let parts: [(&str, Part, bool); 3] = [
        ("Total error", |r| &r.total_um, false),
        ("In plane, outwards positive", |r| &r.in_plane_um, true),
        ("Out of plane", |r| &r.out_of_plane_um, true),
    ];
    html! {
        div.legends {
            (legend(view.runs.iter().map(|r| &r.run), &[]))
            (joints.legend(view.marks.iter().map(|m| m.joint.as_str())))
        }
        div.panels.small.polar { @for (name, part, signed) in parts { (plot(view, joints, name, part, signed)) } }
    }
}

fn plot(view: &PolarView, joints: &Joints, name: &str, part: Part, signed: bool) -> Markup {
    let Some(range) = extent(view.runs.iter().flat_map(|r| part(r).iter().copied())) else {
        return html! { figure.panel { figcaption { (name) } (nothing("no value is a finite number")) } };
    };
    let far = range[0].abs().max(range[1].abs());
    let far = if far > 0.0 { far } else { 1.0 };
    // the rim is the first ring beyond the largest value
    let ticks = Ticks::new(if signed { [-far, far] } else { [0.0, far] }, 4);
    let far = (far / ticks.step() * 0.999).ceil() * ticks.step();
    let scale = if signed { Scale::new([-far, far], [HUB * RIM, RIM]) } else { Scale::new([0.0, far], [0.0, RIM]) };
    let rings = ticks.spanning([scale.lo, scale.hi]);
    let mut dropped = 0;
    let lines: Vec<_> =
        view.runs.iter().map(|r| (role_class(r.run.role), path(r, part(r), &scale, &mut dropped))).collect();
    let quiet = quiet_angle(&view.marks);
    html! {
        figure.panel {
            figcaption { (name) }
            svg role="img" aria-label=(format!("{name} in micrometres over the angle of the circle, polar plot")) viewBox="0 0 392 348" {
                @for &v in rings.values.iter().filter(|v| scale.at(**v) > 1.0) {
                    circle.grid.zero[v == 0.0] cx=(px(CENTRE[0])) cy=(px(CENTRE[1])) r=(px(scale.at(v))) {}
                }
                @for k in 0..12 {
                    @let a = f64::from(k) * 30.0;
                    @let inner = at(a, if signed { HUB * RIM } else { 0.0 });
                    @let outer = at(a, RIM);
                    line.grid x1=(px(inner[0])) y1=(px(inner[1])) x2=(px(outer[0])) y2=(px(outer[1])) {}
                    @if k % 3 == 0 && apart(a, &view.marks) > 10.0 {
                        @let p = at(a, RIM + 11.0);
                        text.tick x=(px(p[0])) y=(px(p[1] + 4.0)) text-anchor="middle" { (k * 30) "°" }
                    }
                }
                (marks(&view.marks, joints))
                @for (class, d) in &lines { path.line.(class) d=(d) {} }
                @for v in labelled(&rings.values, &scale) {
                    @let p = at(quiet, scale.at(v));
                    text.ring x=(px(p[0])) y=(px(p[1] + 3.5)) text-anchor="middle" { (rings.label(v)) @if v == scale.hi { " µm" } }
                }
            }
            (dropped_note(dropped))
        }
    }
}

/// Point at an angle (degrees, anticlockwise from the right) and a radius.
fn at(deg: f64, r: f64) -> [f64; 2] {
    let (s, c) = deg.to_radians().sin_cos();
    [CENTRE[0] + r * c, CENTRE[1] - r * s]
}

/// The rings that have space for a label: rim, zero and hub first.
fn labelled(rings: &[f64], scale: &Scale) -> Vec<f64> {
    let first = rings.iter().rev().take(1).chain(rings.iter().filter(|v| **v == 0.0)).chain(rings.iter().take(1));
    let mut kept: Vec<f64> = Vec::new();
    for &v in first.chain(rings) {
        if scale.at(v) > 1.0 && kept.iter().all(|k| (scale.at(*k) - scale.at(v)).abs() >= LABEL_GAP) {
            kept.push(v);
        }
    }
    kept
}

/// Angle from `a` to the nearest reversal, deg.
fn apart(a: f64, marks: &[AngleMark]) -> f64 {
    let to_mark = marks.iter().filter(|m| usable(m.at_deg)).map(|m| {
        let d = (m.at_deg - a).rem_euclid(360.0);
        d.min(360.0 - d)
    });
    to_mark.fold(180.0, f64::min)
}

fn path(run: &PolarRun, error_um: &[f64], scale: &Scale, dropped: &mut usize) -> String {
    let (points, lost) = line::points(&run.angle_deg, error_um);
    *dropped += lost;
    let thinned = line::thin(&points, |[a, _]| (a / 360.0 * SLICES).floor() as i64, |[_, e]| *e);
    line::path(thinned.into_iter().map(|p| p.map(|[a, e]| at(a, scale.at(e)))))
}

/// The middle of the widest sector without a reversal, away from the angle labels: ring labels stand there.
fn quiet_angle(marks: &[AngleMark]) -> f64 {
    let free = |a: f64| apart(a, marks).min((a % 90.0).min(90.0 - a % 90.0).min(30.0) + 60.0);
    (0..24).map(|k| 7.5 + 15.0 * f64::from(k)).fold(22.5, |best, a| if free(a) > free(best) + 1e-9 { a } else { best })
}

/// Reversals: a spoke, the joint's mark on the rim, its name outside.
fn marks(all: &[AngleMark], joints: &Joints) -> Markup {
    let mut seen: Vec<(f64, &AngleMark)> =
        all.iter().filter(|m| usable(m.at_deg)).map(|m| (m.at_deg.rem_euclid(360.0), m)).take(360).collect();
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted: Vec<f64> = seen.iter().map(|s| s.0).collect();
    let letters = seen.iter().map(|s| s.1.joint.chars().count()).max().unwrap_or(0) + 1;
    let gap_deg = ((7.0 * letters as f64 + 4.0) / (RIM + 27.0)).to_degrees();
    let names = spread(&wanted, gap_deg, [-4.0, 364.0]);
    let named = seen.len() <= NAMED && all_short(seen.iter().map(|s| s.1.joint.as_str()));
    html! {
        @for ((deg, m), &name_deg) in seen.iter().zip(&names) {
            @let outer = at(*deg, RIM);
            @let name = at(name_deg, RIM + 27.0 + 16.0 * name_deg.to_radians().cos().abs());
            line.mark.own.(joints.class(&m.joint)) x1=(px(CENTRE[0])) y1=(px(CENTRE[1])) x2=(px(outer[0])) y2=(px(outer[1])) {}
            g {
                title { (turning(&m.joint, m.sense)) " at " (number(*deg, 1)) "°" }
                (joints.glyph(&m.joint, outer[0], outer[1], 4.2))
            }
            @if named { text.mark-name x=(px(name[0])) y=(px(name[1] + 4.0)) text-anchor="middle" { (turning(&m.joint, m.sense)) } }
        }
    }
}
