//! The result as a `lostmotion/gaps/1` document: what `fit` reads under `joints`, and each gap by itself under `series`.

use super::flanks::{Flanks, Known, Repeats};
use super::start::Start;
use super::{Found, Output, Series};
use crate::gaps::file::{document as plain, in_user_unit, number};
use crate::robot::{Joint, Robot};
use serde_json::{Map, Value, json};
use std::f64::consts::TAU;

/// The document.
pub fn document(found: &Found, robot: &Robot) -> Value {
    let mut doc = plain(&found.gaps, robot);
    doc["method"] = "screw".into();
    doc["series"] = found.series.iter().map(|s| series(s, robot, found)).collect();
    // notes last
    if let Some(map) = doc.as_object_mut()
        && let Some(notes) = map.shift_remove("notes")
    {
        map.insert("notes".into(), notes);
    }
    doc
}

fn series(s: &Series, robot: &Robot, found: &Found) -> Value {
    let joint = robot.axis(s.axis);
    let unit = joint.kind.unit();
    let name = &joint.name;
    let mut m = Map::new();
    m.insert("joint".into(), name.clone().into());
    m.insert("log".into(), found.gaps.logs.get(s.log).map_or(Value::Null, |l| l.name.clone().into()));
    m.insert("separated".into(), (s.coupling.is_some() && s.nut.is_some()).into());
    m.insert("input".into(), if s.encoder { format!("enc_{name}") } else { format!("cmd_{name}") }.into());
    let output = match s.output {
        Some(Output::Sensor) => format!("meas_{name}").into(),
        Some(Output::Tracker) => "tracker".into(),
        None => Value::Null,
    };
    m.insert("output".into(), output);
    if let Some(lead) = joint.lead_m_per_rev {
        m.insert("lead_mm_per_rev".into(), number(lead * 1e3));
    }
    let how = match s.start {
        Start::Move(_) => "move",
        Start::Flank(_) => "flank",
        Start::Inside(_) => "none: inside the gap",
        Start::Unknown => "none",
    };
    m.insert("preload".into(), json!({"side": s.start.side(), "how": how}));
    for (key, flanks) in [("coupling", &s.coupling), ("nut", &s.nut), ("both", &s.both)] {
        m.insert(
            key.into(),
            flanks.as_ref().map_or(Value::Null, |f| gap(f, joint, s.shares_zero(f, key != "coupling"))),
        );
    }
    if let Some(least) = s.at_least {
        m.insert(format!("at_least_{unit}"), number(joint.kind.to_user_unit(least)));
    }
    Value::Object(m)
}

fn gap(f: &Flanks, joint: &Joint, zero: bool) -> Value {
    let (kind, unit) = (joint.kind, joint.kind.unit());
    let mut m = Map::new();
    let mut put = |key: &str, k: Known| {
        m.insert(format!("{key}_{unit}"), number(kind.to_user_unit(k.value)));
        m.insert(format!("{key}_ci95"), in_user_unit(&k.ci95, kind));
    };
    put("total_gap", f.total);
    put("half_gap", Known { value: 0.5 * f.total.value, ci95: f.total.ci95.map(|v| 0.5 * v) });
    if zero {
        put("c_l", f.c_l);
        put("c_r", f.c_r);
    }
    m.insert("significant".into(), f.significant().into());
    if let Some(lead) = joint.lead_m_per_rev {
        m.insert("total_gap_deg".into(), number(f.total.value / lead * 360.0));
        m.insert("total_gap_rad".into(), number(f.total.value / lead * TAU));
    }
    m.insert("slope".into(), number(f.slope.value));
    m.insert("slope_ci95".into(), f.slope.ci95.iter().map(|&v| number(v)).collect());
    if let Some(lead) = joint.lead_m_per_rev {
        m.insert("m_mm_per_rad".into(), number(f.slope.value * lead * 1e3 / TAU));
    }
    if let Some(lag) = f.lag_s {
        m.insert("lag_s".into(), number(lag.value));
        m.insert("lag_s_ci95".into(), lag.ci95.iter().map(|&v| number(v)).collect());
    }
    m.insert(format!("fluctuation_rms_{unit}"), number(kind.to_user_unit(f.rms)));
    m.insert("rows".into(), f.rows.into());
    m.insert("rows_dropped".into(), f.dropped.into());
    m.insert("strokes".into(), json!({"up": f.strokes[0], "down": f.strokes[1]}));
    let from = if f.repeats == Repeats::Strokes { "strokes" } else { "pieces of strokes" };
    m.insert("intervals_from".into(), from.into());
    Value::Object(m)
}
