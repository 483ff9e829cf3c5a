//! What a reader of the figures should know, in words.

use super::flanks::{Flanks, Missing, Repeats};
use super::reach::Short;
use super::series::{Output, Series, TrainGap};
use super::start::Start;
use super::strokes::Strokes;
use crate::error::counted;
use crate::robot::Joint;

/// Slopes farther from 1 than this are hardly a screw's lead error.
pub const LEAD: f64 = 0.05;
/// A slope this near to 1 is not reported.
const PPM: f64 = 1e-5;
/// What columns of a drive should be.
pub const SCALE: &str = "the scale of the joint: check unit and sign of the column, `lead_mm_per_rev` in the robot file, or give a gear ratio as `scale` in a column map";

/// A joint value with its unit.
pub fn shown(v: f64, joint: &Joint) -> String {
    format!("{:.4} {}", joint.kind.to_user_unit(v) + 0.0, joint.kind.unit())
}

/// Why the gaps before a sensor cannot be seen.
pub fn short(what: &str, why: Short, joint: &Joint, strokes: &Strokes) -> String {
    let way = |v: f64| shown(v, joint);
    match why {
        Short::OneWay => {
            format!("{what}: the joint moves in one direction only: strokes up and down are needed")
        }
        Short::NeverCrossed { way: w } => format!(
            "{what} stands still over strokes of {}: no stroke crossed the gap, so it is larger than that; make longer strokes",
            way(w)
        ),
        Short::HardlyCrossed { way: w } => format!(
            "{what} moves, but its strokes of {} end too soon after the gap: make them at least twice as long (longest: {})",
            way(w),
            way(strokes.longest())
        ),
        Short::Dead { way: w } => format!(
            "{what} stands still over strokes of {}, and no gap is so wide: check that this is the sensor of this joint and that it works",
            way(w)
        ),
        Short::Slope(m) => format!("{what} of {} moves by {m:.5} per command", joint.name),
        Short::Rows => format!("{what}: too few rows in the far half of the strokes"),
    }
}

pub fn missing(why: Missing) -> &'static str {
    match why {
        Missing::TooShort => "too few rows beyond the gap in one of the directions",
        Missing::Singular => "its input hardly moves beyond the gap",
    }
}

/// What one gap's figures are based on.
pub fn flanks(found: &Flanks, what: &str, joint: &Joint, notes: &mut Vec<String>) {
    let mut note = |text: String| notes.push(format!("{}: {text}", joint.name));
    if found.repeats == Repeats::Pieces {
        note(format!(
            "{what} gap: {} up and {} down: its interval contains the noise within them but not the repeatability; make at least three of each",
            counted(found.strokes[0], "stroke"),
            found.strokes[1]
        ));
    }
    if found.dropped > 0 {
        note(format!(
            "{what} gap: {} of {} left out as gross errors",
            found.dropped,
            counted(found.rows + found.dropped, "row")
        ));
    }
    if let Some(per) = found.total_per_lag {
        note(format!(
            "{what} gap: at a single speed a lag looks like a gap: each millisecond of lag would add {}; let the joint stand still at the ends of its strokes, or move at two speeds, or log the encoder",
            shown(per * 1e-3, joint)
        ));
    }
    if found.total.ci95[1] < 0.0 {
        let swapped = if what == "total" { "" } else { " (are `enc` and `screw`, or `screw` and `meas`, swapped?)" };
        note(format!(
            "{what} gap is negative, so it is not a gap: the output leads its input; check the signs, the order and the clocks of the columns{swapped}"
        ));
    }
    let m = found.slope;
    if (m.value - 1.0).abs() > LEAD {
        note(format!(
            "{what}: slope {:.4}: does the lead or the scale of the sensor differ from the robot file?",
            m.value
        ));
    }
}

/// Where the log began.
pub fn start(start: Start, from: f64, joint: &Joint) -> String {
    let side = |d: i8| if d > 0 { "upwards" } else { "downwards" };
    let left = format!("the first {} are left out like those after every reversal", shown(from, joint));
    match start {
        Start::Move(d) => format!("preloaded: the log begins with a short move {}, which closes the gaps", side(d)),
        Start::Flank(d) => format!("the log begins on the flank of movement {}, as after a preload", side(d)),
        Start::Inside(p) => format!(
            "no preload: the log begins inside the gap, about {:.0} % of it from the flank of upward movement; {left}",
            p * 100.0
        ),
        Start::Unknown => format!("no preload before the first stroke: the side on which it starts is unknown; {left}"),
    }
}

/// What concerns the joint as a whole.
pub fn of_series(series: &Series, joint: &Joint, notes: &mut Vec<String>) {
    let name = &joint.name;
    if series.both.is_some() && series.coupling.is_none() && series.nut.is_none() {
        notes.push(format!(
            "{name}: no sensor between coupling and nut (`screw_{name}_{}`): the two gaps cannot be separated, so only their sum is reported",
            if joint.lead_m_per_rev.is_some() { "deg" } else { joint.kind.unit() }
        ));
    }
    if let Some(both) = &series.both {
        if both.slope.excludes(1.0) && (both.slope.value - 1.0).abs() > PPM && (both.slope.value - 1.0).abs() <= LEAD {
            notes.push(format!(
                "{name}: slope {:.6}: the joint moves {:+.0} ppm of its command too far; correct the lead or scale in the controller; offsets at reversals cannot correct it",
                both.slope.value,
                (both.slope.value - 1.0) * 1e6
            ));
        }
        let zero = series.shares_zero(TrainGap::Both, both);
        if series.output == Some(Output::Tracker) {
            notes.push(format!("{name}: the tracker has no zero, so only the difference of c_l and c_r is known"));
        } else if !zero && both.middle.ci95[1] - both.middle.value > both.total.value {
            notes.push(format!(
                "{name}: only the difference of c_l and c_r is known, because the zero lies too far outside the strokes"
            ));
        } else if !zero {
            notes.push(format!(
                "{name}: both flanks lie on one side of zero (c_l {}, c_r {}): the zero of the sensor differs from that of the command; the gap is split evenly",
                shown(both.c_l.value, joint),
                shown(both.c_r.value, joint)
            ));
        }
    }
    if let (Some(a), Some(b), Some(sum)) = (&series.coupling, &series.nut, &series.both) {
        let off = a.total.value + b.total.value - sum.total.value;
        let unsure = [a, b, sum].map(|g| g.total.ci95[1] - g.total.value).iter().sum::<f64>();
        if off.abs() > unsure {
            notes.push(format!(
                "{name}: the sum of coupling and nut differs from the gap over both by {}: does the screw column have the scale of the joint?",
                shown(off, joint)
            ));
        }
    }
}
