//! Rows of a dwell: stretches in which no command moves, without their edges, and which of their rows are averaged.

use super::{DwellOptions, SETTLE_S};
use crate::log::Log;
use std::ops::Range;

/// A stretch under a mark that is this many times shorter than the longest one is the edge of a dwell.
const EDGE: usize = 3;

/// Maximal stretches without movement and with one trigger and cycle; each row of a pose log is one.
pub(super) fn stretches(log: &Log, still: &[f64]) -> Vec<Range<usize>> {
    let n = log.len();
    if log.poses {
        return (0..n).map(|i| i..i + 1).collect();
    }
    let mut out = Vec::new();
    let mut start = 0;
    for i in 1..=n {
        let same = i < n
            && log.cmd.iter().zip(still).all(|(c, &tol)| (c[i] - c[start]).abs() <= tol)
            && log.trigger.as_ref().is_none_or(|t| t[i] == t[start])
            && log.cycle.as_ref().is_none_or(|c| c[i] == c[start]);
        if !same {
            out.push(start..i);
            start = i;
        }
    }
    out
}

/// Leaves out the rows at the edges of a marked dwell in which the commands already move, or move still: stretches much
/// shorter than the longest one under the same mark are no separate dwells.
pub(super) fn without_edges(log: &Log, stretches: Vec<Range<usize>>, marked: bool) -> Vec<Range<usize>> {
    if !marked || log.poses {
        return stretches;
    }
    let mark = |row: usize| (log.trigger.as_ref().map(|t| t[row]), log.cycle.as_ref().map(|c| c[row]));
    let on = |row: usize| mark(row).0.map_or_else(|| mark(row).1.is_some_and(|c| c != 0), |t| t != 0);
    let mut longest: Vec<usize> = stretches.iter().map(Range::len).collect();
    let mut from = 0;
    for i in 1..=stretches.len() {
        let same =
            i < stretches.len() && on(stretches[i].start) && mark(stretches[i].start) == mark(stretches[from].start);
        if !same {
            let most = longest[from..i].iter().copied().max().unwrap_or(0);
            longest[from..i].fill(most);
            from = i;
        }
    }
    let kept = stretches.into_iter().zip(longest);
    kept.filter(|(rows, most)| !on(rows.start) || EDGE * rows.len() > *most).map(|(rows, _)| rows).collect()
}

/// The rows of a stretch that are averaged, or `None` where it is no dwell.
pub(super) fn averaged_rows(
    log: &Log,
    rows: &Range<usize>,
    marked: bool,
    options: &DwellOptions,
) -> Option<Range<usize>> {
    if log.poses {
        return Some(rows.clone());
    }
    if marked {
        let on = match (&log.trigger, &log.cycle) {
            (Some(t), _) => t[rows.start] != 0,
            (None, Some(c)) => c[rows.start] != 0,
            (None, None) => false,
        };
        return on.then(|| rows.clone());
    }
    let last = rows.end - 1;
    let length_s = log.t_s[last] - log.t_s[rows.start];
    if length_s < options.min_s {
        return None;
    }
    let settle_s = match options.settle_s {
        None => SETTLE_S.min(length_s / 3.0),
        Some(s) if s > length_s => return None,
        Some(s) => s,
    };
    let from_s = log.t_s[rows.start] + settle_s;
    let first = rows.start + log.t_s[rows.clone()].partition_point(|&t| t < from_s);
    Some(first.min(last)..rows.end)
}
