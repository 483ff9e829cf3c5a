//! Scales and ticks that all plots share, and the frame of a chart in x and y.
//!
//! Ticks stand at multiples of 1, 2 or 5 times a power of ten. A range of one value is widened, an empty one has no ticks.

use crate::report::number::{number, px};
use maud::{Markup, html};

/// Beyond this a value cannot be drawn with others in one scale.
const LARGEST: f64 = 1e15;

/// Whether a value can be drawn.
pub fn usable(v: f64) -> bool {
    v.abs() < LARGEST
}

/// Smallest and largest of the values that can be drawn; none where there is none.
pub fn extent(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    values.into_iter().filter(|v| usable(*v)).fold(None, |e, v| match e {
        None => Some([v, v]),
        Some([lo, hi]) => Some([f64::min(lo, v), f64::max(hi, v)]),
    })
}

/// A range with a margin of `share` on both sides; one value is given a range around it.
pub fn widen(range: [f64; 2], share: f64) -> [f64; 2] {
    let [lo, hi] = range;
    let span = hi - lo;
    // a span that is lost in the digits of its ends counts as one value
    if span <= 1e-9 * lo.abs().max(hi.abs()) || span == 0.0 {
        let half = if lo == 0.0 { 1.0 } else { 0.5 * lo.abs() };
        return [lo - half, hi + half];
    }
    [lo - share * span, hi + share * span]
}

/// A range from zero, or from a smaller value, to the largest one, with a margin at the far end.
pub fn from_zero(range: Option<[f64; 2]>) -> [f64; 2] {
    let [lo, hi] = range.unwrap_or([0.0, 1.0]);
    let far = 1.06 * hi.max(0.0);
    [if lo < 0.0 { 1.06 * lo } else { 0.0 }, if far > 0.0 { far } else { 1.0 }]
}

/// A linear scale from values to pixels.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// Value at `from_px`.
    pub lo: f64,
    /// Value at `to_px`.
    pub hi: f64,
    /// Pixel of the value `lo`.
    pub from_px: f64,
    /// Pixel of the value `hi`.
    pub to_px: f64,
}

impl Scale {
    /// A scale that maps values from `lo` to `hi` to pixels.
    pub fn new([lo, hi]: [f64; 2], [from_px, to_px]: [f64; 2]) -> Self {
        Self { lo, hi, from_px, to_px }
    }

    /// Pixel of a value.
    pub fn at(&self, v: f64) -> f64 {
        self.from_px + (v - self.lo) / (self.hi - self.lo) * (self.to_px - self.from_px)
    }

    /// Whether `v` lies within the scale.
    pub fn holds(&self, v: f64) -> bool {
        v >= self.lo && v <= self.hi
    }
}

/// Ticks and how they are written.
#[derive(Debug, Clone)]
pub struct Ticks {
    /// Values at which ticks stand.
    pub values: Vec<f64>,
    step: f64,
}

impl Ticks {
    /// About `about` ticks within the range; a range without width has none.
    pub fn new([lo, hi]: [f64; 2], about: usize) -> Self {
        let rough = (hi - lo) / about.max(1) as f64;
        if rough <= 0.0 || !rough.is_finite() {
            return Self { values: Vec::new(), step: 1.0 };
        }
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough * 0.75).unwrap_or(rough);
        Self { values: Vec::new(), step }.spanning([lo, hi])
    }

    /// The same step over another range.
    pub fn spanning(&self, [lo, hi]: [f64; 2]) -> Self {
        let (first, last) = ((lo / self.step - 1e-6).ceil(), (hi / self.step + 1e-6).floor());
        let n = (last - first).clamp(-1.0, 50.0) as i64;
        Self { values: (0..=n).map(|k| (first + k as f64) * self.step).collect(), step: self.step }
    }

    /// Angles go by 15, 30, 45 or 90 where they span that much.
    pub fn degrees(range: [f64; 2], about: usize) -> Self {
        let rough = (range[1] - range[0]) / about.max(1) as f64;
        if !(8.0..=120.0).contains(&rough) {
            return Self::new(range, about);
        }
        let step = [10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 120.0].into_iter().find(|s| *s >= rough).unwrap_or(120.0);
        Self { values: Vec::new(), step }.spanning(range)
    }

    /// A tick as it is written.
    pub fn label(&self, v: f64) -> String {
        let largest = self.values.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        if self.step < 1e-5 || largest >= 1e7 {
            return if v == 0.0 { "0".into() } else { format!("{v:.3e}").replace('-', "\u{2212}") };
        }
        let decimals = (-(self.step * 1.0001).log10().floor()).max(0.0) as usize;
        number(v, decimals)
    }

    /// Distance of two ticks.
    pub fn step(&self) -> f64 {
        self.step
    }
}

/// Size of a chart in its own pixels and its margins.
#[derive(Debug, Clone, Copy)]
pub struct Size {
    /// Width of the picture, px.
    pub width: f64,
    /// Height of the picture, px.
    pub height: f64,
    /// Margin at the left, px.
    pub left: f64,
    /// Margin at the right, px.
    pub right: f64,
    /// Margin at the top, px.
    pub top: f64,
    /// Margin at the bottom, px.
    pub bottom: f64,
}

impl Size {
    /// Two in a row on a wide screen.
    pub const WIDE: Self = Self { width: 540.0, height: 250.0, left: 46.0, right: 10.0, top: 40.0, bottom: 40.0 };
    /// Three in a row.
    pub const SMALL: Self = Self { width: 360.0, height: 240.0, left: 42.0, right: 10.0, top: 26.0, bottom: 40.0 };

    /// Attribute `viewBox` of the SVG.
    pub fn view_box(&self) -> String {
        format!("0 0 {} {}", px(self.width), px(self.height))
    }
}

/// A chart's plane: its two scales and its ticks.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Size and margins.
    pub size: Size,
    /// Scale of the abscissa.
    pub x: Scale,
    /// Scale of the ordinate.
    pub y: Scale,
    /// Ticks of the abscissa.
    pub x_ticks: Ticks,
    /// Ticks of the ordinate.
    pub y_ticks: Ticks,
}

impl Frame {
    /// A frame for the ranges; `x_degrees` chooses ticks that suit angles.
    pub fn new(size: Size, x_range: [f64; 2], y_range: [f64; 2], x_degrees: bool) -> Self {
        let about = if size.width > 400.0 { 8 } else { 6 };
        let x_ticks = if x_degrees { Ticks::degrees(x_range, about) } else { Ticks::new(x_range, about) };
        Self {
            size,
            x: Scale::new(x_range, [size.left, size.width - size.right]),
            y: Scale::new(y_range, [size.height - size.bottom, size.top]),
            x_ticks,
            y_ticks: Ticks::new(y_range, 5),
        }
    }

    /// A frame whose x counts: ticks at whole numbers only.
    pub fn counting(mut self) -> Self {
        if self.x_ticks.step < 1.0 {
            self.x_ticks = Ticks { values: Vec::new(), step: 1.0 }.spanning([self.x.lo, self.x.hi]);
        }
        self
    }

    /// Values and pixels of both ends of x, then of y.
    fn plane(&self) -> String {
        let of = |s: &Scale| format!("{} {} {} {}", s.lo, s.hi, px(s.from_px), px(s.to_px));
        format!("{} {}", of(&self.x), of(&self.y))
    }

    /// Grid, tick labels and axis titles; what is drawn comes on top of it.
    pub fn axes(&self, x_title: &str, y_title: &str) -> Markup {
        let (left, right) = (self.x.from_px, self.x.to_px);
        let floor = self.y.from_px;
        html! {
            @for &v in &self.y_ticks.values {
                line.grid.zero[v == 0.0] x1=(px(left)) x2=(px(right)) y1=(px(self.y.at(v))) y2=(px(self.y.at(v))) {}
                text.tick x=(px(left - 6.0)) y=(px(self.y.at(v) + 4.0)) text-anchor="end" { (self.y_ticks.label(v)) }
            }
            line.axis x1=(px(left)) x2=(px(right)) y1=(px(floor)) y2=(px(floor)) {}
            @for &v in &self.x_ticks.values {
                line.axis x1=(px(self.x.at(v))) x2=(px(self.x.at(v))) y1=(px(floor)) y2=(px(floor + 4.0)) {}
                text.tick x=(px(self.x.at(v))) y=(px(floor + 17.0)) text-anchor="middle" { (self.x_ticks.label(v)) }
            }
            text.title x=(px(right)) y=(px(self.size.height - 6.0)) text-anchor="end" { (x_title) }
            text.title x="2" y="12" { (y_title) }
            // from here the script reads the value under the pointer
            g data-plane=(self.plane()) {}
        }
    }
}

/// Moves sorted positions apart to at least `gap` between neighbours, each as little as may be; `range` holds them all
/// where there is space.
pub fn spread(wanted: &[f64], gap: f64, range: [f64; 2]) -> Vec<f64> {
    // blocks that touch share their mean displacement (pool adjacent violators)
    let mut blocks: Vec<(f64, usize)> = Vec::new(); // (sum of wanted minus own index gaps, count)
    for (i, w) in wanted.iter().enumerate() {
        blocks.push((w - i as f64 * gap, 1));
        while let [.., (a, n), (b, m)] = blocks[..] {
            if a / n as f64 <= b / m as f64 {
                break;
            }
            blocks.truncate(blocks.len() - 2);
            blocks.push((a + b, n + m));
        }
    }
    let last = wanted.len().saturating_sub(1) as f64 * gap;
    let (lo, hi) = (range[0], (range[1] - last).max(range[0]));
    let means = blocks.iter().flat_map(|&(sum, n)| std::iter::repeat_n((sum / n as f64).clamp(lo, hi), n));
    means.enumerate().map(|(i, m)| m + i as f64 * gap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_stand_at_round_numbers_within_the_range() {
        let t = Ticks::new([-0.3, 10.2], 5);
        assert_eq!(t.values, [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(Ticks::new([0.0, 0.07], 5).label(0.02), "0.02");
        assert_eq!(Ticks::degrees([0.0, 360.0], 8).values.len(), 9);
        assert!(Ticks::new([1.0, 1.0], 5).values.is_empty());
        assert!(Ticks::new([0.0, f64::INFINITY], 5).values.is_empty());
    }

    #[test]
    fn an_extent_ignores_what_cannot_be_drawn() {
        assert_eq!(extent([f64::NAN, 3.0, f64::INFINITY, -1.0, 1e300]), Some([-1.0, 3.0]));
        assert_eq!(extent([f64::NAN]), None);
    }

    #[test]
    fn a_range_of_one_value_is_given_width() {
        for v in [0.0, 5.0, -5.0, 1e-12, 1e14] {
            let [lo, hi] = widen([v, v], 0.05);
            assert!(lo < v && v < hi, "{v}: {lo} {hi}");
        }
    }

    #[test]
    fn labels_that_crowd_are_moved_apart_and_stay_inside() {
        let s = spread(&[10.0, 11.0, 12.0, 90.0], 8.0, [0.0, 100.0]);
        assert!(s.windows(2).all(|w| w[1] - w[0] >= 8.0 - 1e-9), "{s:?}");
        assert!((s[1] - 11.0).abs() < 1e-9 && s[3] == 90.0, "{s:?}");
        let s = spread(&[99.0, 99.5], 8.0, [0.0, 100.0]);
        assert!(s[1] <= 100.0 + 1e-9, "{s:?}");
    }
}
