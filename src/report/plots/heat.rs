//! Colours for a quantity, and what is drawn with them: strips over time, paths in space.
//!
//! Colours: cividis (Nunez, Anderton and Renslow, "Optimizing colormaps with consideration for color vision deficiency", 2018),
//! dark for nothing, yellow for much, even in lightness; in [`LEVELS`] steps, so that neighbours of one colour are one shape.
//! A strip shows of each pixel column the root mean square; values beyond the scale have its last colour.

use super::axes::{Scale, Ticks, extent, usable};
use super::joints::Joints;
use super::path3d::{Camera, ISOMETRIC, triad};
use super::{dropped_note, nothing};
use crate::report::diagnosis::{HeatPath, HeatPathView, Lane, StripLog, StripsView};
use crate::report::number::{number, px, significant};
use maud::{Markup, html};
use std::fmt::Write;

const STOPS: [[u8; 3]; 10] = [
    [0x00, 0x20, 0x4d],
    [0x00, 0x33, 0x6f],
    [0x39, 0x48, 0x6b],
    [0x57, 0x5c, 0x6d],
    [0x70, 0x71, 0x73],
    [0x8a, 0x87, 0x79],
    [0xa6, 0x9d, 0x75],
    [0xc4, 0xb5, 0x6c],
    [0xe4, 0xcf, 0x5b],
    [0xff, 0xea, 0x46],
];
/// Steps of colour.
pub const LEVELS: usize = 32;
/// Share of the first lane's values that the scale holds.
const HELD: f64 = 0.98;

/// Values in colours: from 0 to `top`, or by their logarithm from `bottom` to `top`.
#[derive(Debug, Clone, Copy)]
pub struct Colours {
    bottom: Option<f64>,
    top: f64,
}

impl Colours {
    /// A scale that holds most of the values, and at least a given one; its end is a round number.
    pub fn of(values: impl Iterator<Item = f64>, at_least: f64) -> Self {
        let mut all: Vec<f64> = values.filter(|v| usable(*v)).collect();
        all.sort_by(f64::total_cmp);
        let most = all.get(((all.len() as f64 * HELD) as usize).min(all.len().saturating_sub(1))).copied();
        let least = if usable(at_least) { at_least } else { 0.0 };
        let far = most.unwrap_or(0.0).max(least);
        if far <= 0.0 {
            return Self { bottom: None, top: 1.0 };
        }
        let step = Ticks::new([0.0, far], 5).step();
        Self { bottom: None, top: (far / step * 0.999).ceil() * step }
    }

    /// A scale of whole decades, at least two.
    pub fn by_decades(values: impl Iterator<Item = f64>) -> Self {
        let Some([lo, hi]) = extent(values.filter(|v| *v > 0.0)) else { return Self { bottom: None, top: 1.0 } };
        let (low, high) = (lo.log10().floor(), hi.log10().ceil());
        Self { bottom: Some(10f64.powf(low)), top: 10f64.powf(high.max(low + 2.0)) }
    }

    /// Place of a value between the ends of the scale.
    fn share(&self, v: f64) -> f64 {
        let share = match self.bottom {
            None => v / self.top,
            Some(bottom) => (v.max(bottom) / bottom).log10() / (self.top / bottom).log10(),
        };
        share.clamp(0.0, 1.0)
    }

    pub fn level(&self, v: f64) -> usize {
        (self.share(v) * (LEVELS - 1) as f64).round() as usize
    }

    /// Values and words below the key.
    fn ticks(&self) -> Vec<(f64, String)> {
        match self.bottom {
            None => {
                let ticks = Ticks::new([0.0, self.top], 4);
                ticks.values.iter().map(|&v| (v, ticks.label(v))).collect()
            }
            Some(bottom) => {
                let decades = (self.top / bottom).log10().round() as i32;
                let every = decades / 5 + 1;
                let at = (0..=decades).step_by(every as usize).map(|k| bottom * 10f64.powi(k));
                at.map(|v| {
                    (
                        v,
                        if (0.001..1e5).contains(&v) {
                            format!("{:.*}", (-v.log10()).ceil().max(0.0) as usize, v)
                        } else {
                            format!("{v:.0e}")
                        },
                    )
                })
                .collect()
            }
        }
    }

    /// As `#rrggbb`.
    pub fn hex(level: usize) -> String {
        let [r, g, b] = Self::rgb(level);
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    fn rgb(level: usize) -> [u8; 3] {
        let at = level.min(LEVELS - 1) as f64 / (LEVELS - 1) as f64 * (STOPS.len() - 1) as f64;
        let low = (at.floor() as usize).min(STOPS.len() - 2);
        let (a, b, f) = (STOPS[low], STOPS[low + 1], at - low as f64);
        [0, 1, 2].map(|k| (f64::from(a[k]) + f * (f64::from(b[k]) - f64::from(a[k]))).round() as u8)
    }

    /// Whether black is read better on it than white.
    pub fn is_light(level: usize) -> bool {
        let [r, g, b] = Self::rgb(level).map(f64::from);
        0.299 * r + 0.587 * g + 0.114 * b > 125.0
    }

    /// The key: a bar of all colours with ticks.
    pub fn key(&self, quantity: &str, unit: &str) -> Markup {
        const WIDTH: f64 = 256.0;
        let ticks = self.ticks();
        let last = ticks.len().saturating_sub(1);
        html! {
            div.heat-key {
                span { (quantity) ", " (unit) }
                svg viewBox="0 0 300 30" role="img" aria-label=(format!("{quantity}: dark is little, yellow is {} {unit} and more", significant(self.top))) {
                    @for k in 0..LEVELS {
                        rect x=(px(10.0 + WIDTH / LEVELS as f64 * k as f64)) y="0" width=(px(WIDTH / LEVELS as f64 + 0.4)) height="11" style=(format!("fill:{}", Self::hex(k))) {}
                    }
                    @for (k, (v, label)) in ticks.iter().enumerate() {
                        text.tick x=(px(10.0 + WIDTH * self.share(*v))) y="26" text-anchor="middle" { (label) @if k == last { "+" } }
                    }
                }
            }
        }
    }
}

const WIDTH: f64 = 900.0;
const LEFT: f64 = 172.0;
const RIGHT: f64 = 12.0;
const LANE: f64 = 26.0;
const BETWEEN: f64 = 8.0;
/// Room for marks above a lane.
const MARKS: f64 = 14.0;
/// Marks beyond this in one lane are counted only.
const MOST_MARKS: usize = 120;
/// Longest name of a lane, letters.
const NAME: usize = 25;

/// Strips of all logs.
pub fn strips(view: &StripsView, joints: &Joints) -> Markup {
    let first = view.logs.iter().filter_map(|l| l.lanes.first().map(|lane| columns(l, lane)));
    let values: Vec<f64> = first.flatten().flatten().collect();
    if values.is_empty() {
        return nothing("no log has a measured value");
    }
    let colours = Colours::of(values.into_iter(), view.at_least);
    let named = view.logs.iter().flat_map(|l| &l.lanes).flat_map(|l| &l.marks).map(|m| m.joint.as_str());
    html! {
        div.legends { (colours.key(&view.quantity, &view.unit)) (joints.legend(named)) }
        @for log in &view.logs { (strip(view, log, &colours, joints)) }
    }
}

fn x_scale(log: &StripLog) -> Option<Scale> {
    let [lo, hi] = extent(log.x.iter().copied())?;
    let hi = if hi > lo { hi } else { lo + 1.0 };
    Some(Scale::new([lo, hi], [LEFT, WIDTH - RIGHT]))
}

/// Root mean square of each pixel column; a column without a value takes that of the one before, up to a short gap.
fn columns(log: &StripLog, lane: &Lane) -> Vec<Option<f64>> {
    let Some(scale) = x_scale(log) else { return Vec::new() };
    let count = (WIDTH - RIGHT - LEFT) as usize;
    let mut sums = vec![(0.0, 0usize); count];
    for (x, v) in log.x.iter().zip(&lane.values).filter(|(x, v)| usable(**x) && usable(**v)) {
        let at = ((scale.at(*x) - LEFT).max(0.0) as usize).min(count - 1);
        sums[at].0 += v * v;
        sums[at].1 += 1;
    }
    // few samples are wide
    let reach = count.div_ceil(log.x.len().max(1)) + 2;
    let mut last: Option<(f64, usize)> = None;
    (0..count)
        .map(|k| {
            if sums[k].1 > 0 {
                last = Some(((sums[k].0 / sums[k].1 as f64).sqrt(), k));
            }
            last.filter(|(_, at)| k - at <= reach).map(|l| l.0)
        })
        .collect()
}

fn strip(view: &StripsView, log: &StripLog, colours: &Colours, joints: &Joints) -> Markup {
    let Some(scale) = x_scale(log) else { return nothing("the log is empty") };
    let mut y = 4.0;
    let lanes: Vec<(f64, &Lane)> = log
        .lanes
        .iter()
        .map(|lane| {
            y += if lane.marks.is_empty() { 0.0 } else { MARKS };
            let top = y;
            y += LANE + BETWEEN;
            (top, lane)
        })
        .collect();
    let floor = y - BETWEEN + 4.0;
    let ticks = Ticks::new([scale.lo, scale.hi], 10);
    let dropped = log.lanes.iter().flat_map(|l| &l.values).filter(|v| !usable(**v)).count();
    html! {
        figure.strip {
            @if !log.name.is_empty() { figcaption { (log.name) } }
            div.scroll { svg role="img" aria-label=(format!("{} in {} over {}, as colours: {}", view.quantity, view.unit, log.x_title, log.name)) viewBox=(format!("0 0 {} {}", px(WIDTH), px(floor + 42.0))) {
                @for (top, lane) in &lanes {
                    text.label x=(px(LEFT - 10.0)) y=(px(top + LANE / 2.0 + 4.0)) text-anchor="end" { (cut(&lane.name)) }
                    rect.empty x=(px(LEFT)) y=(px(*top)) width=(px(WIDTH - RIGHT - LEFT)) height=(px(LANE)) {}
                    g shape-rendering="crispEdges" { @for (level, d) in shapes(&columns(log, lane), *top, colours) {
                        path style=(format!("fill:{}", Colours::hex(level))) d=(d) {}
                    } }
                    (marks(lane, *top, &scale, joints))
                }
                line.axis x1=(px(LEFT)) x2=(px(WIDTH - RIGHT)) y1=(px(floor)) y2=(px(floor)) {}
                @for &v in &ticks.values {
                    line.axis x1=(px(scale.at(v))) x2=(px(scale.at(v))) y1=(px(floor)) y2=(px(floor + 4.0)) {}
                    text.tick x=(px(scale.at(v))) y=(px(floor + 17.0)) text-anchor="middle" { (ticks.label(v)) }
                }
                text.title x=(px(WIDTH - RIGHT)) y=(px(floor + 34.0)) text-anchor="end" { (log.x_title) }
            } }
            (dropped_note(dropped))
        }
    }
}

fn cut(name: &str) -> String {
    if name.chars().count() <= NAME { name.into() } else { name.chars().take(NAME - 1).chain(['…']).collect() }
}

/// Path data of each colour that a lane has.
fn shapes(columns: &[Option<f64>], top: f64, colours: &Colours) -> Vec<(usize, String)> {
    let mut by_level = vec![String::new(); LEVELS];
    let mut k = 0;
    while k < columns.len() {
        let level = columns[k].map(|v| colours.level(v));
        let end = (k..columns.len()).find(|&i| columns[i].map(|v| colours.level(v)) != level).unwrap_or(columns.len());
        if let Some(level) = level {
            let _ =
                write!(by_level[level], "M{} {}h{}v{}h-{}z", px(LEFT + k as f64), px(top), end - k, px(LANE), end - k);
        }
        k = end;
    }
    by_level.into_iter().enumerate().filter(|(_, d)| !d.is_empty()).collect()
}

fn marks(lane: &Lane, top: f64, scale: &Scale, joints: &Joints) -> Markup {
    let seen: Vec<_> = lane.marks.iter().filter(|m| usable(m.x) && scale.holds(m.x)).collect();
    let more = seen.len().saturating_sub(MOST_MARKS);
    html! {
        @for m in seen.iter().take(MOST_MARKS) {
            @let x = scale.at(m.x);
            (joints.glyph(&m.joint, x, top - 6.0, 2.6))
            line.notch x1=(px(x)) x2=(px(x)) y1=(px(top - 2.5)) y2=(px(top + 4.0)) {}
        }
        @if more > 0 { text.mark-name x=(px(WIDTH - RIGHT)) y=(px(top - 4.0)) text-anchor="end" { (more) " more" } }
    }
}

const SPACE: [f64; 2] = [520.0, 440.0];
/// Segments into which a path is cut.
const SEGMENTS: usize = 700;
/// Largest drawing of a path, px from the upper left corner.
const ROOM: [f64; 4] = [24.0, 14.0, 496.0, 372.0];

/// Paths coloured by a quantity, side by side.
pub fn path(view: &HeatPathView, joints: &Joints) -> Markup {
    let camera = Camera::new(ISOMETRIC[0], ISOMETRIC[1]);
    let at = |p: &[f64; 3]| [camera.across(p), -camera.upwards(p)];
    let flat: Vec<[f64; 2]> =
        view.panels.iter().flat_map(|p| &p.at_mm).filter(|p| p.iter().all(|v| usable(*v))).map(at).collect();
    let (Some(xs), Some(ys)) = (extent(flat.iter().map(|p| p[0])), extent(flat.iter().map(|p| p[1]))) else {
        return nothing("no point of the path is a finite number");
    };
    let size = |e: [f64; 2]| (e[1] - e[0]).max(1e-6);
    let px_per_mm = ((ROOM[2] - ROOM[0]) / size(xs)).min((ROOM[3] - ROOM[1]) / size(ys));
    let middle = [0.5 * (xs[0] + xs[1]), 0.5 * (ys[0] + ys[1])];
    let place = |p: &[f64; 3]| {
        let q = at(p);
        [
            0.5 * (ROOM[0] + ROOM[2]) + px_per_mm * (q[0] - middle[0]),
            0.5 * (ROOM[1] + ROOM[3]) + px_per_mm * (q[1] - middle[1]),
        ]
    };
    let cuts: Vec<Vec<Segment>> = view.panels.iter().map(|p| segments(p, &place)).collect();
    let colours = Colours::of(cuts.iter().take(1).flatten().map(|s| s.2), view.at_least);
    let named = view.panels.iter().flat_map(|p| &p.marks).map(|m| m.joint.as_str());
    html! {
        div.legends { (colours.key(&view.quantity, &view.unit)) (joints.legend(named)) }
        div.panels { @for (panel, cut) in view.panels.iter().zip(&cuts) {
            figure.panel {
                figcaption { (panel.title) }
                svg role="img" aria-label=(format!("Path in space, {}, coloured by {} in {}", panel.title, view.quantity, view.unit)) viewBox=(format!("0 0 {} {}", px(SPACE[0]), px(SPACE[1]))) {
                    @for level in 0..LEVELS {
                        @let d = level_path(cut, level, &colours);
                        @if !d.is_empty() { path.heat.dot[panel.dots] style=(format!("stroke:{}", Colours::hex(level))) d=(d) {} }
                    }
                    @for m in panel.marks.iter().filter(|m| m.at_mm.iter().all(|v| usable(*v))).take(MOST_MARKS) {
                        @let p = place(&m.at_mm);
                        (joints.glyph(&m.joint, p[0], p[1], 3.4))
                    }
                    (triad(&camera))
                    (scale_bar(px_per_mm))
                }
            }
        } }
    }
}

/// A piece of a path: its ends, px, and its value.
type Segment = ([f64; 2], [f64; 2], f64);

fn segments(path: &HeatPath, place: &impl Fn(&[f64; 3]) -> [f64; 2]) -> Vec<Segment> {
    let good: Vec<(&[f64; 3], f64)> = path
        .at_mm
        .iter()
        .zip(&path.values)
        .filter(|(p, v)| p.iter().all(|c| usable(*c)) && usable(**v))
        .map(|(p, v)| (p, *v))
        .collect();
    let per = if path.dots { 1 } else { good.len().div_ceil(SEGMENTS).max(1) };
    let starts: Vec<usize> = (0..good.len()).step_by(per).collect();
    starts
        .iter()
        .map(|&k| {
            let end = (k + per).min(good.len());
            let square = good[k..end].iter().map(|g| g.1 * g.1).sum::<f64>() / (end - k) as f64;
            let to = if path.dots { k } else { end.min(good.len() - 1) };
            (place(good[k].0), place(good[to].0), square.sqrt())
        })
        .collect()
}

fn level_path(segments: &[Segment], level: usize, colours: &Colours) -> String {
    let mut d = String::new();
    let mut last: Option<[f64; 2]> = None;
    for (a, b, v) in segments {
        if colours.level(*v) != level {
            last = None;
            continue;
        }
        if last.is_none_or(|l| l != *a) {
            let _ = write!(d, "M{} {}", px(a[0]), px(a[1]));
        }
        let _ = if a == b { write!(d, "h0") } else { write!(d, "L{} {}", px(b[0]), px(b[1])) };
        last = Some(*b);
    }
    d
}

fn scale_bar(px_per_mm: f64) -> Markup {
    let most = 150.0 / px_per_mm;
    let power = 10f64.powf(most.log10().floor());
    let length = [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|l| *l <= most).unwrap_or(power);
    let (left, y) = (330.0, 424.0);
    let right = left + length * px_per_mm;
    let decimals = (-length.log10().floor()).max(0.0) as usize;
    html! {
        g.scalebars {
            path d=(format!("M{} {}v8M{} {}H{}M{} {}v8", px(left), px(y - 4.0), px(left), px(y), px(right), px(right), px(y - 4.0))) {}
            text x=(px(right + 8.0)) y=(px(y + 4.0)) { (number(length, decimals)) " mm" }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_from_dark_to_light_and_their_end_is_round() {
        let c = Colours::of((0..1000).map(f64::from), 0.0);
        assert!(c.top >= 980.0 && c.top <= 1200.0, "{}", c.top);
        assert_eq!((c.level(-1.0), c.level(1e9)), (0, LEVELS - 1));
        assert!(!Colours::is_light(0) && Colours::is_light(LEVELS - 1));
        assert_eq!(Colours::hex(0), "#00204d");
        assert_eq!(Colours::of(std::iter::empty(), 0.0).top, 1.0);
    }

    #[test]
    fn a_lane_covers_its_columns_once_and_leaves_a_lost_stretch_empty() {
        let lane = Lane { values: vec![1.0; 400], ..Lane::default() };
        let x = (0..400).map(|i| f64::from(if i < 200 { i } else { i + 2000 })).collect();
        let log = StripLog { x, lanes: vec![lane], ..StripLog::default() };
        let c = columns(&log, &log.lanes[0]);
        assert!(c.iter().any(Option::is_none) && c.first().is_some_and(Option::is_some));
        assert_eq!(shapes(&c, 0.0, &Colours::of([1.0].into_iter(), 0.0)).len(), 1);
    }
}
