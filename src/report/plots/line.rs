//! Series of points to path data, thinned to what the eye can see.
//!
//! Thinning: of the neighbours that fall on one pixel column (or one slice of an angle) the first, the lowest, the highest
//! and the last stay, in their order, so that a spike of one sample is never lost. A value that cannot be drawn breaks the
//! line, as a lost reflector does.

use super::axes::{Frame, usable};
use crate::report::number::px;
use std::fmt::Write;

/// Points of a series as far as both values reach, `None` where one cannot be drawn; and how many of those there are.
pub fn points(x: &[f64], y: &[f64]) -> (Vec<Option<[f64; 2]>>, usize) {
    let out: Vec<_> = x.iter().zip(y).map(|(&x, &y)| (usable(x) && usable(y)).then_some([x, y])).collect();
    let dropped = out.iter().filter(|p| p.is_none()).count();
    (out, dropped)
}

/// Keeps of each run of neighbours with one `slot` the first, the lowest and highest by `height`, and the last.
pub fn thin<P: Copy>(points: &[Option<P>], slot: impl Fn(&P) -> i64, height: impl Fn(&P) -> f64) -> Vec<Option<P>> {
    let mut out = Vec::new();
    let mut i = 0;
    while i < points.len() {
        let Some(first) = points[i] else {
            if out.last().is_some_and(Option::is_some) {
                out.push(None);
            }
            i += 1;
            continue;
        };
        let here = slot(&first);
        let end =
            points[i..].iter().position(|p| p.as_ref().is_none_or(|p| slot(p) != here)).map_or(points.len(), |k| i + k);
        let (mut low, mut high) = (i, i);
        for k in i..end {
            let h = |k: usize| points[k].as_ref().map_or(0.0, &height);
            low = if h(k) < h(low) { k } else { low };
            high = if h(k) > h(high) { k } else { high };
        }
        let mut keep = [i, low.min(high), low.max(high), end - 1].to_vec();
        keep.dedup();
        out.extend(keep.into_iter().map(|k| points[k]));
        i = end;
    }
    out
}

/// Path data of a line through pixels; `None` lifts the pen.
pub fn path(points: impl IntoIterator<Item = Option<[f64; 2]>>) -> String {
    let mut d = String::new();
    let mut down = false;
    for p in points {
        match p {
            Some([x, y]) => {
                let _ = write!(d, "{}{} {}", if down { 'L' } else { 'M' }, px(x), px(y));
                down = true;
            }
            None => down = false,
        }
    }
    d
}

/// Path data of dots at pixels: strokes of no length with round ends.
pub fn dots(points: impl IntoIterator<Item = [f64; 2]>) -> String {
    let mut d = String::new();
    for [x, y] in points {
        let _ = write!(d, "M{} {}h0", px(x), px(y));
    }
    d
}

/// A series in a frame, thinned, in pixels.
pub fn in_frame(frame: &Frame, points: &[Option<[f64; 2]>]) -> Vec<Option<[f64; 2]>> {
    let seen: Vec<Option<[f64; 2]>> = points.iter().map(|p| p.filter(|[x, _]| frame.x.holds(*x))).collect();
    let thinned = thin(&seen, |[x, _]| frame.x.at(*x).floor() as i64, |[_, y]| *y);
    thinned.into_iter().map(|p| p.map(|[x, y]| [frame.x.at(x), frame.y.at(y)])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_a_spike_of_one_sample_and_the_ends() {
        let y: Vec<f64> = (0..10_000).map(|i| if i == 4321 { 9.0 } else { 0.0 }).collect();
        let x: Vec<f64> = (0..10_000).map(f64::from).collect();
        let (p, dropped) = points(&x, &y);
        let thin = thin(&p, |[x, _]| (*x / 100.0) as i64, |[_, y]| *y);
        assert_eq!(dropped, 0);
        assert!(thin.len() <= 400, "{}", thin.len());
        assert!(thin.contains(&Some([4321.0, 9.0])));
        assert_eq!((thin[0], thin[thin.len() - 1]), (Some([0.0, 0.0]), Some([9999.0, 0.0])));
    }

    #[test]
    fn a_value_that_is_not_finite_lifts_the_pen() {
        let (p, dropped) = points(&[0.0, 1.0, 2.0, 3.0], &[0.0, f64::NAN, f64::INFINITY, 1.0]);
        assert_eq!(dropped, 2);
        assert_eq!(path(thin(&p, |[x, _]| *x as i64, |[_, y]| *y)), "M0 0M3 1");
    }
}
