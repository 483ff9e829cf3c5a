//! The result as a `lostmotion/gaps/1` document: what `fit` reads under `joints`, and each gap by itself under `series`.

use super::Found;
use super::flanks::{Flanks, Known, Repeats};
use super::series::{Output, Series, TrainGap};
use super::start::Start;
use crate::gaps::document::document as plain;
use crate::gaps::file::{in_user_unit, keyed, number};
use crate::io::keyed::Keyed;
use crate::robot::{Joint, JointKind, Robot};
use serde::Serialize;
use serde_json::Value;
use std::f64::consts::TAU;

/// The gaps in series of one joint and log.
#[derive(Serialize)]
struct SeriesFields<'a> {
    joint: &'a str,
    log: Option<&'a str>,
    separated: bool,
    input: String,
    output: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lead_mm_per_rev: Option<Value>,
    preload: Preload,
    coupling: Option<GapFields>,
    nut: Option<GapFields>,
    both: Option<GapFields>,
    #[serde(flatten)]
    at_least: Option<Keyed<Value>>,
}

/// The side that the gap stood at when the log began, and how it is known.
#[derive(Serialize)]
struct Preload {
    side: Option<i8>,
    how: &'static str,
}

/// One gap, or two whose sum alone is known.
#[derive(Serialize)]
struct GapFields {
    #[serde(flatten)]
    total: Interval,
    #[serde(flatten)]
    half: Interval,
    #[serde(flatten)]
    left: Option<Interval>,
    #[serde(flatten)]
    right: Option<Interval>,
    significant: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    total_gap_deg: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    total_gap_rad: Option<Value>,
    slope: Value,
    slope_ci95: Vec<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    m_mm_per_rad: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lag_s: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lag_s_ci95: Option<Vec<Value>>,
    #[serde(flatten)]
    fluctuation_rms: Keyed<Value>,
    rows: usize,
    rows_dropped: usize,
    strokes: Strokes,
    intervals_from: &'static str,
}

/// A figure with its 95 % interval.
#[derive(Serialize)]
struct Interval {
    #[serde(flatten)]
    value: Keyed<Value>,
    #[serde(flatten)]
    ci95: Keyed<Value>,
}

impl Interval {
    fn new(name: &str, k: Known, kind: JointKind) -> Self {
        Self { value: keyed(name, k.value, kind), ci95: Keyed::new(name, "ci95", in_user_unit(&k.ci95, kind)) }
    }
}

#[derive(Serialize)]
struct Strokes {
    up: usize,
    down: usize,
}

/// The document.
pub fn document(found: &Found, robot: &Robot) -> Value {
    let mut doc = plain(&found.gaps, robot);
    doc["method"] = "screw".into();
    let all: Vec<SeriesFields> = found.series.iter().map(|s| series(s, robot, found)).collect();
    doc["series"] = serde_json::to_value(all).unwrap_or_default();
    // notes last
    if let Some(map) = doc.as_object_mut()
        && let Some(notes) = map.shift_remove("notes")
    {
        map.insert("notes".into(), notes);
    }
    doc
}

fn series<'a>(s: &Series, robot: &'a Robot, found: &'a Found) -> SeriesFields<'a> {
    let joint = robot.axis(s.axis);
    let name = &joint.name;
    let how = match s.start {
        Start::Move(_) => "move",
        Start::Flank(_) => "flank",
        Start::Inside(_) => "none: inside the gap",
        Start::Unknown => "none",
    };
    let of = |which: TrainGap| {
        let (_, flanks) = s.found().find(|found| found.0 == which)?;
        Some(gap(flanks, joint, s.shares_zero(which, flanks)))
    };
    SeriesFields {
        joint: name,
        log: found.gaps.logs.get(s.log).map(|l| l.name.as_str()),
        separated: s.coupling.is_some() && s.nut.is_some(),
        input: if s.encoder { format!("enc_{name}") } else { format!("cmd_{name}") },
        output: s.output.map(|o| match o {
            Output::Sensor => format!("meas_{name}"),
            Output::Tracker => "tracker".into(),
        }),
        lead_mm_per_rev: joint.lead_m_per_rev.map(|lead| number(lead * 1e3)),
        preload: Preload { side: s.start.side(), how },
        coupling: of(TrainGap::Coupling),
        nut: of(TrainGap::Nut),
        both: of(TrainGap::Both),
        at_least: s.at_least.map(|least| keyed("at_least", least, joint.kind)),
    }
}

fn gap(f: &Flanks, joint: &Joint, zero: bool) -> GapFields {
    let (kind, lead) = (joint.kind, joint.lead_m_per_rev);
    let numbers = |values: [f64; 2]| values.map(number).to_vec();
    let half = Known { value: 0.5 * f.total.value, ci95: f.total.ci95.map(|v| 0.5 * v) };
    GapFields {
        total: Interval::new("total_gap", f.total, kind),
        half: Interval::new("half_gap", half, kind),
        left: zero.then(|| Interval::new("c_l", f.c_l, kind)),
        right: zero.then(|| Interval::new("c_r", f.c_r, kind)),
        significant: f.significant(),
        total_gap_deg: lead.map(|lead| number(f.total.value / lead * 360.0)),
        total_gap_rad: lead.map(|lead| number(f.total.value / lead * TAU)),
        slope: number(f.slope.value),
        slope_ci95: numbers(f.slope.ci95),
        m_mm_per_rad: lead.map(|lead| number(f.slope.value * lead * 1e3 / TAU)),
        lag_s: f.lag_s.map(|lag| number(lag.value)),
        lag_s_ci95: f.lag_s.map(|lag| numbers(lag.ci95)),
        fluctuation_rms: keyed("fluctuation_rms", f.rms, kind),
        rows: f.rows,
        rows_dropped: f.dropped,
        strokes: Strokes { up: f.strokes[0], down: f.strokes[1] },
        intervals_from: if f.repeats == Repeats::Strokes { "strokes" } else { "pieces of strokes" },
    }
}
