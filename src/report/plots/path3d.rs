//! The path in space (Zhang (2023) figures 2 c and 11 a): nominal and measured, the errors exaggerated, seen isometrically.
//!
//! Orthographic projection, viewer at 45 degrees of azimuth and 35.26 degrees of elevation. The scale leaves space for a
//! ball around all points, so the script may turn the view without cutting anything off; what it needs stands beside the
//! drawing as JSON.

use super::axes::{Ticks, extent, usable};
use super::joints::{Joints, all_short, turning};
use super::{dropped_note, legend, line, nothing, role_class};
use crate::report::figures::{PathMark, PathRun, PathView};
use crate::report::number::{number, px};
use maud::{Markup, PreEscaped, html};
use std::fmt::Write;

/// Azimuth and elevation of the viewer, deg.
pub(super) const ISOMETRIC: [f64; 2] = [AZIMUTH_DEG, ELEVATION_DEG];
const AZIMUTH_DEG: f64 = 45.0;
const ELEVATION_DEG: f64 = 35.264_389_682_754_654;
const SIZE: [f64; 2] = [520.0, 470.0];
const CENTRE: [f64; 2] = [260.0, 208.0];
/// Radius of the ball on the drawing, px.
const BALL: f64 = 200.0;
/// About this many points of a path are drawn.
const POINTS: usize = 700;
/// Reversals beyond this are not drawn; beyond the first of these they have no names.
const MARKS: usize = 300;
const NAMED: usize = 24;
/// Largest exaggeration that is taken.
const MOST: f64 = 1e6;
/// Height of a name and width of its letters, about, px.
const NAME: [f64; 2] = [14.0, 8.0];
/// Marks within this distance have their names together, px.
const TOGETHER: f64 = 16.0;
/// Names that stand together; of further ones the number.
const TOLD: usize = 3;
/// Where no name may stand: the axes of the base frame, and the scale bars. Left, top, right, bottom, px.
const TAKEN: [[f64; 4]; 2] = [[0.0, 365.0, 100.0, SIZE[1]], [280.0, 420.0, SIZE[0], SIZE[1]]];

type Point = [f64; 3];

/// A view direction: right, up and towards the viewer.
pub(super) struct Camera {
    right: Point,
    up: Point,
}

impl Camera {
    pub(super) fn new(azimuth_deg: f64, elevation_deg: f64) -> Self {
        let (sa, ca) = azimuth_deg.to_radians().sin_cos();
        let (se, ce) = elevation_deg.to_radians().sin_cos();
        Self { right: [-sa, ca, 0.0], up: [-ca * se, -sa * se, ce] }
    }

    /// Coordinates of a point in the picture, to the right and upwards.
    pub(super) fn across(&self, p: &Point) -> f64 {
        dot(p, &self.right)
    }

    pub(super) fn upwards(&self, p: &Point) -> f64 {
        dot(p, &self.up)
    }
}

/// The mapping of millimetres to the drawing.
struct Stage {
    camera: Camera,
    middle: Point,
    px_per_mm: f64,
}

impl Stage {
    fn at(&self, p: &Point) -> [f64; 2] {
        let d = [p[0] - self.middle[0], p[1] - self.middle[1], p[2] - self.middle[2]];
        [
            CENTRE[0] + self.px_per_mm * dot(&d, &self.camera.right),
            CENTRE[1] - self.px_per_mm * dot(&d, &self.camera.up),
        ]
    }
}

/// A run ready to be drawn: where it belongs, mm, and its error, µm.
type Thinned = Vec<Option<(Point, Point)>>;

/// The figure.
pub fn draw(view: &PathView, joints: &Joints) -> Markup {
    let sensible = view.exaggeration > 0.0 && view.exaggeration <= MOST;
    let exaggeration = if sensible { view.exaggeration } else { 400.0 };
    let mut dropped = view.nominal_mm.iter().filter(|p| !finite(p)).count();
    let nominal: Vec<Option<Point>> = stride(view.nominal_mm.iter().map(|p| finite(p).then_some(*p)).collect());
    let runs: Vec<Thinned> = view.runs.iter().map(|r| thinned(r, &mut dropped)).collect();
    let exaggerated = |r: &(Point, Point)| [0, 1, 2].map(|k| r.0[k] + exaggeration * r.1[k] * 1e-3);
    let every: Vec<Point> =
        nominal.iter().flatten().copied().chain(runs.iter().flatten().flatten().map(exaggerated)).collect();
    let Some(stage) = stage(&every) else {
        return nothing("the path has no finite point");
    };
    let marks: Vec<&PathMark> = view.marks.iter().filter(|m| finite(&m.at_mm)).take(MARKS).collect();
    let named = marks.len() <= NAMED && all_short(marks.iter().map(|m| m.joint.as_str()));
    let drawn: Vec<[f64; 2]> = every.iter().map(|p| stage.at(p)).collect();
    let names = place_names(&marks, &stage, &drawn);
    html! {
        div.space data-exaggeration=(number(exaggeration, 0)) {
            div.legends {
                @if !view.is_arm { (legend(view.runs.iter().map(|r| &r.run), &[("nominal", if view.runs.is_empty() { "path" } else { "nominal" })])) }
                (joints.legend(view.marks.iter().map(|m| m.joint.as_str())))
                @if view.marks.len() > marks.len() { p.dropped { (view.marks.len() - marks.len()) " further reversals are not drawn." } }
            }
            figure.single {
                svg role="img" aria-label=(label(view, exaggeration)) viewBox=(format!("0 0 {} {}", px(SIZE[0]), px(SIZE[1]))) {
                    path.nominal.arm[view.is_arm] data-line="nominal" d=(line::path(nominal.iter().map(|p| p.as_ref().map(|p| stage.at(p))))) {}
                    @for (k, (run, r)) in runs.iter().zip(&view.runs).enumerate() {
                        path.line.(role_class(r.run.role)) data-line=(k) d=(line::path(run.iter().map(|p| p.as_ref().map(|p| stage.at(&exaggerated(p)))))) {}
                    }
                    @for (m, name) in marks.iter().zip(&names) {
                        @let p = stage.at(&m.at_mm);
                        g.reversal transform=(format!("translate({} {})", px(p[0]), px(p[1]))) data-at=(json(&m.at_mm, 1)) {
                            title { (turning(&m.joint, m.sense)) }
                            (joints.glyph(&m.joint, 0.0, 0.0, 4.6))
                            @if let Some(name) = name.as_ref().filter(|_| named) {
                                text.mark-name x=(px(name.at[0] - p[0])) y=(px(name.at[1] - p[1] + 4.0)) text-anchor="middle" { (name.text) }
                            }
                        }
                    }
                    @if view.is_arm {
                        @for p in nominal.iter().flatten() {
                            @let at = stage.at(p);
                            g.elbow transform=(format!("translate({} {})", px(at[0]), px(at[1]))) data-at=(json(p, 1)) {
                                title { (position_text(p)) }
                                circle r="5.5" {}
                            }
                        }
                    }
                    (triad(&stage.camera))
                    (bars(stage.px_per_mm, (!view.runs.is_empty()).then_some(exaggeration)))
                }
                (controls((!view.runs.is_empty()).then_some(exaggeration)))
                (dropped_note(dropped))
            }
            script type="application/json" { (PreEscaped(data(&nominal, &runs, &stage))) }
        }
    }
}

/// What the drawing shows, for a reader who does not see it.
fn label(view: &PathView, exaggeration: f64) -> String {
    match (view.is_arm, view.runs.is_empty()) {
        (true, _) => "The arm in space, from the base to the TCP".into(),
        (false, true) => "The path in space".into(),
        _ => format!("Nominal and measured path in space, errors drawn {} times larger", number(exaggeration, 0)),
    }
}

/// `x 612.7, y 0.0, z 180.7 mm`.
fn position_text(p: &Point) -> String {
    format!("x {}, y {}, z {} mm", number(p[0], 1), number(p[1], 1), number(p[2], 1))
}

fn finite(p: &Point) -> bool {
    p.iter().all(|v| usable(*v))
}

fn dot(a: &Point, b: &Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Every so many points, and the last.
fn stride(points: Vec<Option<Point>>) -> Vec<Option<Point>> {
    let every = points.len().div_ceil(POINTS).max(1);
    let last = points.len().saturating_sub(1);
    points.into_iter().enumerate().filter(|(i, _)| i % every == 0 || *i == last).map(|(_, p)| p).collect()
}

/// Of each slice of a run the points that matter: first, smallest and largest error, last.
fn thinned(run: &PathRun, dropped: &mut usize) -> Thinned {
    let n = run.reference_mm.len().min(run.error_um.len());
    let per_slice = n.div_ceil(POINTS / 2).max(1);
    let points: Vec<Option<(usize, Point, Point)>> = (run.reference_mm.iter().zip(&run.error_um).enumerate())
        .map(|(i, (r, e))| (finite(r) && finite(e)).then_some((i, *r, *e)))
        .collect();
    *dropped += points.iter().filter(|p| p.is_none()).count();
    let kept = line::thin(&points, |(i, ..)| (i / per_slice) as i64, |(_, _, e)| dot(e, e));
    kept.into_iter().map(|p| p.map(|(_, r, e)| (r, e))).collect()
}

/// Scale and middle such that a ball around all points fits.
fn stage(points: &[Point]) -> Option<Stage> {
    let mut middle = [0.0; 3];
    for (k, m) in middle.iter_mut().enumerate() {
        let [lo, hi] = extent(points.iter().map(|p| p[k]))?;
        *m = 0.5 * (lo + hi);
    }
    let reach = |p: &Point| {
        let d = [p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]];
        dot(&d, &d).sqrt()
    };
    let radius = points.iter().map(reach).fold(0.0, f64::max);
    let px_per_mm = if radius > 1e-9 { BALL / radius } else { 1.0 };
    Some(Stage { camera: Camera::new(AZIMUTH_DEG, ELEVATION_DEG), middle, px_per_mm })
}

/// A name beside a mark.
struct MarkName {
    /// Its middle, px.
    at: [f64; 2],
    text: String,
}

impl MarkName {
    fn width(text: &str) -> f64 {
        6.0 + NAME[1] * text.chars().count() as f64
    }
}

/// The names that stand beside each mark: those of all marks that nearly coincide stand beside the first of them, each once, as joints
/// reverse together at the points of a program, and several turns of one path pass one place. Only the first ones are written out.
fn joined_names(marks: &[&PathMark], stage: &Stage) -> Vec<Option<String>> {
    let mut groups: Vec<([f64; 2], usize, Vec<String>)> = Vec::new();
    for (k, m) in marks.iter().enumerate().take(NAMED) {
        let (p, name) = (stage.at(&m.at_mm), turning(&m.joint, m.sense));
        match groups.iter_mut().find(|g| (p[0] - g.0[0]).hypot(p[1] - g.0[1]) < TOGETHER) {
            Some((.., names)) if names.contains(&name) => {}
            Some((.., names)) => names.push(name),
            None => groups.push((p, k, vec![name])),
        }
    }
    let mut out = vec![None; marks.len()];
    for (_, k, names) in groups {
        let more = names.len().saturating_sub(TOLD);
        let told = names.into_iter().take(TOLD).collect::<Vec<_>>().join(" ");
        out[k] = Some(if more > 0 { format!("{told} +{more}") } else { told });
    }
    out
}

/// Names stand outside their marks, or inside, where they hide least of what is drawn, within the drawing. One that would cover another
/// name is left out: the mark tells it under the pointer.
fn place_names(marks: &[&PathMark], stage: &Stage, drawn: &[[f64; 2]]) -> Vec<Option<MarkName>> {
    let mut placed: Vec<Option<MarkName>> = Vec::new();
    for (m, text) in marks.iter().zip(joined_names(marks, stage)) {
        let Some(text) = text else {
            placed.push(None);
            continue;
        };
        let p = stage.at(&m.at_mm);
        let (dx, dy) = (p[0] - CENTRE[0], p[1] - CENTRE[1]);
        let r = dx.hypot(dy);
        let [ux, uy] = if r > 1.0 { [dx / r, dy / r] } else { [0.0, -1.0] };
        let width = MarkName::width(&text);
        let covers = |c: &[f64; 2]| {
            let meets = |q: &MarkName| {
                (q.at[0] - c[0]).abs() < 0.5 * (width + MarkName::width(&q.text)) && (q.at[1] - c[1]).abs() < NAME[0]
            };
            !is_free(c, 0.5 * width) || placed.iter().flatten().any(meets)
        };
        let over =
            |q: &&[f64; 2], c: &[f64; 2]| (q[0] - c[0]).abs() < 0.6 * width && (q[1] - c[1]).abs() < 0.6 * NAME[0];
        let hidden = |c: &[f64; 2]| drawn.iter().filter(|q| over(q, c)).count();
        let along = [24.0, 36.0, 48.0, -26.0, -38.0].map(|far| [p[0] + far * ux, p[1] + far * uy]);
        let across = [24.0, -24.0].map(|far| [p[0] - far * uy, p[1] + far * ux]);
        let best = along.into_iter().chain(across).filter(|c| !covers(c)).min_by_key(hidden);
        placed.push(best.map(|at| MarkName { at, text }));
    }
    placed
}

/// Whether a name about `c` stands within the drawing and on nothing that is written there already.
fn is_free(c: &[f64; 2], half_width: f64) -> bool {
    let [left, right, top, bottom] = [c[0] - half_width, c[0] + half_width, c[1] - 0.5 * NAME[0], c[1] + 0.5 * NAME[0]];
    let within = left >= 0.0 && right <= SIZE[0] && top >= 0.0 && bottom <= SIZE[1];
    within && !TAKEN.iter().any(|t| left < t[2] && right > t[0] && top < t[3] && bottom > t[1])
}

/// The base frame's axes.
pub(super) fn triad(camera: &Camera) -> Markup {
    const FOOT: [f64; 2] = [46.0, 414.0];
    const LENGTH: f64 = 34.0;
    html! {
        g.triad data-foot=(format!("{},{},{}", FOOT[0], FOOT[1], LENGTH)) {
            @for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
                @let d = [camera.right[k], -camera.up[k]];
                @let tip = [FOOT[0] + LENGTH * d[0], FOOT[1] + LENGTH * d[1]];
                @let label = [FOOT[0] + (LENGTH + 11.0) * d[0], FOOT[1] + (LENGTH + 11.0) * d[1] + 4.0];
                line x1=(px(FOOT[0])) y1=(px(FOOT[1])) x2=(px(tip[0])) y2=(px(tip[1])) {}
                text x=(px(label[0])) y=(px(label[1])) text-anchor="middle" { (name) }
            }
        }
    }
}

/// Scale bars: for the path, and for the errors as they are drawn, where there are any.
fn bars(px_per_mm: f64, exaggeration: Option<f64>) -> Markup {
    let round = |most: f64| Ticks::new([0.0, most], 1).step();
    // the longest round length of at most 110 px
    let nice = |per_px: f64| {
        let most = 110.0 * per_px;
        let step = round(most);
        if step > most * 1.0001 {
            [0.5, 0.4, 0.2].map(|f| f * step).into_iter().find(|s| *s <= most).unwrap_or(0.1 * step)
        } else {
            step
        }
    };
    let path_mm = nice(1.0 / px_per_mm);
    let shown = |v: f64| super::super::number::significant(v).trim_end_matches(".00").to_owned();
    let what = if exaggeration.is_some() { "path " } else { "" };
    let mut rows = vec![(path_mm * px_per_mm, format!("{what}{} mm", shown(path_mm)), "path")];
    rows.extend(exaggeration.map(|e| {
        let error_um = nice(1e3 / (px_per_mm * e));
        (error_um * 1e-3 * e * px_per_mm, format!("error {} µm", shown(error_um)), "error")
    }));
    html! {
        g.scalebars data-scale=(format!("{px_per_mm:.6}")) {
            @for (k, (width, words, class)) in rows.iter().enumerate() {
                @let y = 432.0 + 24.0 * k as f64;
                @let left = 300.0;
                path.(class) d=(format!("M{} {}v8M{} {}H{}M{} {}v8", px(left), px(y - 4.0), px(left), px(y), px(left + width), px(left + width), px(y - 4.0))) {}
                text x=(px(left + width + 8.0)) y=(px(y + 4.0)) { (words) }
            }
        }
    }
}

/// Hidden until the script is there.
fn controls(exaggeration: Option<f64>) -> Markup {
    html! {
        div.controls hidden="hidden" {
            @if let Some(e) = exaggeration {
                label { "Errors drawn "
                    output { (number(e, 0)) }
                    " times larger "
                    input type="range" min="0" max=(number((2.0 * e).max(1.0), 0)) step="1" value=(number(e, 0)) aria-label="Exaggeration of the errors";
                }
            }
            button.view type="button" { "Isometric view" }
            button.nearer type="button" aria-label="Nearer" { "+" }
            button.farther type="button" aria-label="Farther" { "−" }
            span.hint { "Drag the drawing or use the arrow keys to turn it; drag with Shift to move it." }
        }
    }
}

fn json(p: &Point, decimals: usize) -> String {
    format!("[{:.decimals$},{:.decimals$},{:.decimals$}]", p[0], p[1], p[2])
}

/// What the script draws from: points relative to the middle, mm, and errors, µm; `null` lifts the pen.
fn data(nominal: &[Option<Point>], runs: &[Thinned], stage: &Stage) -> String {
    let relative = |p: &Point| json(&[p[0] - stage.middle[0], p[1] - stage.middle[1], p[2] - stage.middle[2]], 1);
    let mut out = format!(
        "{{\"scale\":{:.6},\"middle\":{},\"centre\":[{},{}],\"nominal\":[",
        stage.px_per_mm,
        json(&stage.middle, 3),
        CENTRE[0],
        CENTRE[1]
    );
    let list = |out: &mut String, items: Vec<String>| {
        let _ = write!(out, "{}]", items.join(","));
    };
    list(&mut out, nominal.iter().map(|p| p.as_ref().map_or("null".into(), relative)).collect());
    out.push_str(",\"runs\":[");
    let written = runs.iter().map(|run| {
        let items = run.iter().map(|p| match p {
            Some((r, e)) => format!("[{},{}]", relative(r), json(e, 0)),
            None => "null".into(),
        });
        format!("[{}]", items.collect::<Vec<_>>().join(","))
    });
    list(&mut out, written.collect());
    out.push('}');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two turns of a circle that touches the stage's edges: each reversal twice, at nearly the same place.
    #[test]
    fn names_stand_once_within_the_drawing_and_on_nothing_else() {
        let ball = |a: f64| [100.0 * a.cos(), 70.0 * a.sin(), 100.0 * (a + 0.3).sin()];
        let path: Vec<Point> = (0..400).map(|k| ball(f64::from(k) * 0.0157 * 2.0)).collect();
        let stage = stage(&path).unwrap();
        let drawn: Vec<[f64; 2]> = path.iter().map(|p| stage.at(p)).collect();
        let marks: Vec<PathMark> = (0..16)
            .map(|k| PathMark { joint: format!("A{}", k % 8), at_mm: ball(0.785 * f64::from(k) + 0.001), sense: 1 })
            .collect();
        let names = place_names(&marks.iter().collect::<Vec<_>>(), &stage, &drawn);
        assert_eq!(names.iter().flatten().count(), 8);
        apart(&names);
    }

    fn apart(names: &[Option<MarkName>]) {
        let names: Vec<&MarkName> = names.iter().flatten().collect();
        let half = |n: &MarkName| 0.5 * MarkName::width(&n.text);
        for (k, a) in names.iter().enumerate() {
            assert!(is_free(&a.at, half(a)), "{}", a.text);
            for b in &names[..k] {
                let meet = (a.at[0] - b.at[0]).abs() < half(a) + half(b) && (a.at[1] - b.at[1]).abs() < NAME[0];
                assert!(!meet, "{} on {}", a.text, b.text);
            }
        }
    }

    #[test]
    fn joints_that_reverse_at_one_point_have_one_name_together() {
        // points of a program, at each of which several joints reverse, some within a few millimetres of each other
        let points = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [100.0, 80.0, 0.0], [104.0, 82.0, 1.0]];
        let stage = stage(&points).unwrap();
        let drawn: Vec<[f64; 2]> = points.iter().map(|p| stage.at(p)).collect();
        let mark = |k: usize| PathMark {
            joint: format!("J{}", k % 5 + 1),
            at_mm: points[k / 5],
            sense: 1 - 2 * (k % 2) as i8,
        };
        let marks: Vec<PathMark> = (0..20).map(mark).collect();
        let names = place_names(&marks.iter().collect::<Vec<_>>(), &stage, &drawn);
        apart(&names);
        let texts: Vec<&str> = names.iter().flatten().map(|n| n.text.as_str()).collect();
        assert!(texts.len() == 3 && texts[0] == "J1\u{2191} J2\u{2193} J3\u{2191} +2", "{texts:?}");
    }
}
