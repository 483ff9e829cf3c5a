//! Tables of a page: numbers right-aligned with fixed decimals, a unit in every heading, headings with a scope.

use super::figures::*;
use super::number::{count, interval, number, p_value, percent, significant};
use super::plots::joints::{Joints, turning};
use super::plots::{nothing, role_class};
use maud::{Markup, html};

/// Rewritten places beyond this are counted only.
const PLACES: usize = 200;
/// Rows of other tables beyond this are counted only.
const ROWS: usize = 500;
/// A table with more rows scrolls within the page.
const TALL: usize = 30;

fn rest(shown: usize, all: usize) -> Markup {
    html! { @if all > shown { p.dropped { "The first " (count(shown as u64)) " of " (count(all as u64)) " rows are shown." } } }
}

/// Errors at the reversals, side by side.
pub(super) fn reversals(view: &ReversalsView, joints: &Joints) -> Markup {
    if view.rows.is_empty() || view.runs.is_empty() {
        return nothing("no joint reverses on this path");
    }
    let rows = &view.rows[..view.rows.len().min(ROWS)];
    let any = |k: usize, f: fn(&ReversalValue) -> bool| view.rows.iter().any(|r| r.values.get(k).is_some_and(f));
    let beyond: Vec<bool> = (0..view.runs.len()).map(|k| any(k, |v| v.beyond_nominal_um.is_some())).collect();
    let reduced: Vec<bool> = (0..view.runs.len()).map(|k| any(k, |v| v.reduction.is_some())).collect();
    let with_angle = view.rows.iter().any(|r| r.at_deg.is_some());
    html! {
        div.scroll { table {
            thead {
                tr {
                    th scope="col" rowspan="2" { "Reversal" }
                    @if with_angle { th.n scope="col" rowspan="2" { "Angle" br; small { "deg" } } }
                    @for (k, run) in view.runs.iter().enumerate() {
                        th.group scope="colgroup" colspan=(1 + usize::from(beyond[k]) + usize::from(reduced[k])) {
                            span.swatch.(role_class(run.role)) {} (run.name)
                        }
                    }
                }
                tr {
                    @for k in 0..view.runs.len() {
                        th.n.first scope="col" { "total" br; small { "µm" } }
                        @if beyond[k] { th.n scope="col" { "beyond nominal" br; small { "µm" } } }
                        @if reduced[k] { th.n scope="col" { "reduction" br; small { "of the total" } } }
                    }
                }
            }
            tbody {
                @for row in rows {
                    tr {
                        th.joint scope="row" { (joint_key(&row.joint, joints)) (turning(&row.joint, row.sense)) }
                        @if with_angle { td.n { (row.at_deg.map_or_else(|| "–".into(), |a| number(a, 1))) } }
                        @for k in 0..view.runs.len() {
                            @let v = row.values.get(k);
                            td.n.first { (v.map_or_else(|| "–".into(), |v| number(v.total_um, 0))) }
                            @if beyond[k] { td.n { (v.and_then(|v| v.beyond_nominal_um).map_or_else(|| "–".into(), |b| number(b, 0))) } }
                            @if reduced[k] { td.n { (v.and_then(|v| v.reduction).map_or_else(|| "–".into(), percent)) } }
                        }
                    }
                }
            }
        } }
        (rest(rows.len(), view.rows.len()))
    }
}

fn joint_key(name: &str, joints: &Joints) -> Markup {
    html! { svg.key viewBox="0 0 14 14" aria-hidden="true" { (joints.glyph(name, 7.0, 7.5, 4.5)) } }
}

/// Gaps and stiction of each joint.
pub(super) fn gaps(rows: &[GapRow], joints: &Joints) -> Markup {
    if rows.is_empty() {
        return nothing("no joint was identified");
    }
    let tcp = rows.iter().any(|r| r.tcp_um.is_some());
    let stiction = rows.iter().any(|r| r.stiction.is_some());
    let shown = &rows[..rows.len().min(ROWS)];
    html! {
        div.scroll { table {
            thead { tr {
                th scope="col" { "Joint" }
                th.n scope="col" { "Half gap" }
                th.n scope="col" { "95\u{202f}% interval" }
                th scope="col" { "Gap found" }
                th.n scope="col" { "Same everywhere" br; small { "p value" } }
                @if tcp { th.n scope="col" { "At the TCP" br; small { "µm" } } }
                @if stiction {
                    th.n.first scope="col" { "Stiction spike" }
                    th.n scope="col" { "95\u{202f}% interval" }
                    th.n scope="col" { "Decay" }
                    th.n scope="col" { "95\u{202f}% interval" }
                }
            } }
            tbody { @for r in shown {
                @let (factor, unit, decimals) = joints.gaps(&r.joint);
                @let span = |ends: [f64; 2]| interval(ends.map(|v| v * factor), decimals);
                tr {
                    th.joint scope="row" { (joint_key(&r.joint, joints)) (r.joint) }
                    td.n { (number(r.half_gap_milli * factor, decimals)) " " span.unit { (unit) } }
                    td.n { (span(r.ci95_milli)) }
                    td { (if r.significant { "yes" } else { "no: the interval contains zero" }) }
                    td.n { (r.varies_p_value.map_or_else(|| "–".into(), p_value)) }
                    @if tcp { td.n { (r.tcp_um.map_or_else(|| "–".into(), |t| number(t, 1))) } }
                    @if stiction {
                        @if let Some(s) = &r.stiction {
                            td.n.first { (number(s.spike_milli * factor, decimals)) " " span.unit { (unit) } }
                            td.n { (span(s.ci95_milli)) }
                            td.n { (significant(s.decay)) " " span.unit { (s.decay_unit) } }
                            td.n { (significant(s.decay_ci95[0])) " to " (significant(s.decay_ci95[1])) }
                        } @else { td.n.first { "–" } td.n { "–" } td.n { "–" } td.n { "–" } }
                    }
                }
            } }
        } }
        (rest(shown.len(), rows.len()))
    }
}

/// Offsets of a compensator.
pub(super) fn compensator(rows: &[CompensatorRow], joints: &Joints) -> Markup {
    if rows.is_empty() {
        return nothing("the compensator has no offsets");
    }
    let ends = |o: &Option<[f64; 2]>| match o {
        None => "–".to_owned(),
        Some([a, b]) if number(*a, 2) == number(*b, 2) => number(*a, 2),
        Some(e) => interval(*e, 2),
    };
    let shown = &rows[..rows.len().min(ROWS)];
    html! {
        div.scroll { table {
            thead { tr {
                th scope="col" { "Joint" }
                th.n scope="col" { "Offset moving up" }
                th.n scope="col" { "Offset moving down" }
                th scope="col" { "Over position" }
                th.n scope="col" { "Friction offset" }
                th scope="col" { "After a reversal" }
            } }
            tbody { @for r in shown {
                @let unit = joints.milli_unit(&r.joint);
                tr {
                    th.joint scope="row" { (joint_key(&r.joint, joints)) (r.joint) }
                    td.n { (ends(&r.positive_milli)) @if r.positive_milli.is_some() { " " span.unit { (unit) } } }
                    td.n { (ends(&r.negative_milli)) @if r.negative_milli.is_some() { " " span.unit { (unit) } } }
                    td { (or_dash(&r.kind)) }
                    td.n { @if let Some(g) = r.friction_gain_milli { (number(g, 2)) " " span.unit { (unit) } } @else { "–" } }
                    td { (or_dash(&r.friction_shape)) }
                }
            } }
        } }
        (rest(shown.len(), rows.len()))
    }
}

fn or_dash(text: &str) -> &str {
    if text.is_empty() { "–" } else { text }
}

/// Places of a program that were changed: the first of them and the count.
pub(super) fn places(view: &PlacesView, joints: &Joints) -> Markup {
    let shown = &view.places[..view.places.len().min(PLACES)];
    if shown.is_empty() {
        return html! { p { @if view.total == 0 { "No place was changed." } @else { (count(view.total)) " places were changed." } } };
    }
    html! {
        @if view.total > shown.len() as u64 {
            p.dropped { "The first " (count(shown.len() as u64)) " of " (count(view.total)) " places." }
        } @else { p.dropped { (count(view.total)) " places." } }
        div.scroll { table {
            thead { tr {
                th.n scope="col" { "Line" }
                th scope="col" { "Joint" }
                th scope="col" { "What" }
                th.n scope="col" { "Command" }
                th.n scope="col" { "Offset" }
            } }
            tbody { @for p in shown {
                tr {
                    td.n { (p.line.map_or_else(|| "–".into(), |l| l.to_string())) }
                    th.joint scope="row" { (joint_key(&p.joint, joints)) (p.joint) }
                    td { (p.what) }
                    td.n { (number(p.at_deg_mm, 4)) " " span.unit { (joints.unit(&p.joint)) } }
                    td.n { (number(p.offset_milli, 2)) " " span.unit { (joints.milli_unit(&p.joint)) } }
                }
            } }
        } }
    }
}

/// A table of words and written numbers.
pub(super) fn plain(view: &TableView) -> Markup {
    let shown = &view.rows[..view.rows.len().min(ROWS)];
    let right = |k: usize| view.columns.get(k).is_some_and(|c| c.1);
    html! {
        @if shown.is_empty() { (nothing("the table is empty")) }
        @else {
            div.scroll.tall[shown.len() > TALL] { table {
                thead { tr { @for (name, n) in &view.columns { th.n[*n] scope="col" { (name) } } } }
                tbody { @for row in shown { tr {
                    @for (k, cell) in row.iter().enumerate() {
                        @if k == 0 { th.n[right(k)] scope="row" { (cell) } } @else { td.n[right(k)] { (cell) } }
                    }
                } } }
            } }
            (rest(shown.len(), view.rows.len()))
        }
    }
}
