//! Distribution of an error, before and after (Zhang (2023) figure 12): share of the samples a bin, outlines over each other.

use super::axes::{Frame, Size, Ticks, extent, from_zero, usable, widen};
use super::{dropped_note, legend, nothing, role_class};
use crate::report::figures::{HistogramRun, HistogramView};
use crate::report::number::{number, px};
use maud::{Markup, html};
use std::fmt::Write;

/// About this many bins.
const BINS: usize = 40;

/// The chart.
pub fn draw(view: &HistogramView) -> Markup {
    let Some(range) = extent(view.runs.iter().flat_map(|r| r.values.iter().copied())) else {
        return nothing("there is no value to count");
    };
    // errors start at zero; other quantities where they start
    let range = if range[0] >= 0.0 { [0.0, widen(range, 0.0)[1].max(range[1])] } else { widen(range, 0.02) };
    let step = Ticks::new(range, BINS).step();
    let first = (range[0] / step).floor();
    let n = ((range[1] / step - first).floor() as usize + 1).min(4 * BINS);
    let shares: Vec<Vec<f64>> = view.runs.iter().map(|r| count(r, step, first, n)).collect();
    let highest = extent(shares.iter().flatten().copied());
    let x_range = [first * step, (first + n as f64) * step];
    let size = Size { height: 280.0, top: 30.0, ..Size::WIDE };
    let frame = Frame::new(size, x_range, from_zero(highest), false);
    let dropped = view.runs.iter().flat_map(|r| &r.values).filter(|v| !usable(**v)).count();
    // the smallest on the highest line, so that no line crosses the words of another
    let mut quantiles: Vec<(&HistogramRun, f64)> =
        (view.runs.iter()).filter_map(|r| r.p95.filter(|p| usable(*p) && frame.x.holds(*p)).map(|p| (r, p))).collect();
    quantiles.sort_by(|a, b| a.1.total_cmp(&b.1));
    html! {
        (legend(view.runs.iter().map(|r| &r.run), &[]))
        figure.single {
            svg role="img" aria-label=(format!("Histogram of the {}", view.quantity)) viewBox=(size.view_box()) {
                (frame.axes(&format!("{}, {}", view.quantity, view.unit), "share of the samples, %"))
                @for (run, shares) in view.runs.iter().zip(&shares) {
                    @let d = outline(&frame, shares, step, first);
                    path.hist.(role_class(run.run.role)) d=(d) {}
                }
                @for (k, (run, p)) in quantiles.iter().enumerate() { (quantile(&frame, run, *p, k, &view.unit)) }
            }
            (dropped_note(dropped))
        }
    }
}

fn count(run: &HistogramRun, step: f64, first: f64, n: usize) -> Vec<f64> {
    let mut counts = vec![0usize; n];
    let mut all = 0usize;
    for v in run.values.iter().filter(|v| usable(**v)) {
        let k = ((v / step - first).floor().max(0.0) as usize).min(n - 1);
        counts[k] += 1;
        all += 1;
    }
    counts.into_iter().map(|c| 100.0 * c as f64 / all.max(1) as f64).collect()
}

fn outline(frame: &Frame, shares: &[f64], step: f64, first: f64) -> String {
    let mut d = format!("M{} {}", px(frame.x.at(first * step)), px(frame.y.from_px));
    for (k, share) in shares.iter().enumerate() {
        let right = frame.x.at((first + k as f64 + 1.0) * step);
        let _ = write!(d, "V{}H{}", px(frame.y.at(*share)), px(right));
    }
    let _ = write!(d, "V{}Z", px(frame.y.from_px));
    d
}

/// A line at the 95 % quantile with its words beside it, each run on its own line.
fn quantile(frame: &Frame, run: &HistogramRun, p: f64, k: usize, unit: &str) -> Markup {
    let x = frame.x.at(p);
    let right = x > frame.x.to_px - 190.0;
    let y = frame.size.top + 6.0 + 16.0 * k as f64;
    html! {
        line.quantile.(role_class(run.run.role)) x1=(px(x)) x2=(px(x)) y1=(px(y - 10.0)) y2=(px(frame.y.from_px)) {}
        text.note x=(px(if right { x - 5.0 } else { x + 5.0 })) y=(px(y)) text-anchor=(if right { "end" } else { "start" }) {
            (run.run.name) ": 95\u{202f}% below " (number(p, 0)) " " (unit)
        }
    }
}
