//! An effect as it stands in a model file: `{effect: backlash, joint: A1, half_gap_deg: 0.0028}`.

use super::{Backlash, Decay, Effect, GapCurve, Stiction, curve::Pchip};
use crate::error::{Error, Result};
use crate::io::yaml::Document;
use crate::robot::{JointKind, Robot};
use serde_yaml::{Mapping, Value};

/// Names that the catalogue knows, for messages.
pub const NAMES: &[&str] = &["backlash", "backlash_position", "stiction"];

/// An effect and the axis on which it acts.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    pub axis: usize,
    pub effect: Effect,
}

/// The keys of one entry, taken one by one; what is left over at the end is unknown.
struct Fields<'a> {
    map: Mapping,
    doc: &'a Document<'a>,
    effect: String,
    target: String,
}

impl Fields<'_> {
    fn bad(&self, key: &str, found: String, expected: &str) -> Error {
        Error::bad(
            self.doc.place(&[&self.effect, &self.target, key]),
            format!("{found} in {} of {}", self.effect, self.target),
            expected,
        )
    }

    fn take(&mut self, key: &str) -> Option<Value> {
        self.map.remove(key)
    }

    fn number(&mut self, key: &str, least: f64) -> Result<Option<f64>> {
        let Some(v) = self.take(key) else { return Ok(None) };
        match v.as_f64() {
            Some(x) if x.is_finite() && x >= least => Ok(Some(x)),
            _ => Err(self.bad(key, format!("{key}: {}", shown(&v)), &format!("a finite number of {least} or more"))),
        }
    }

    fn needed(&mut self, key: &str, least: f64) -> Result<f64> {
        match self.number(key, least)? {
            Some(x) => Ok(x),
            None => Err(self.bad(key, format!("no `{key}`"), &format!("`{key}`"))),
        }
    }

    fn knots(&mut self, key: &str) -> Result<Vec<[f64; 2]>> {
        let Some(v) = self.take(key) else {
            return Err(self.bad(key, format!("no `{key}`"), "`knots: [[position, half gap], ...]`"));
        };
        serde_yaml::from_value(v.clone())
            .map_err(|_| self.bad(key, format!("{key}: {}", shown(&v)), "pairs `[position, half gap]`"))
    }

    fn finish(self) -> Result<()> {
        match self.map.iter().next() {
            None => Ok(()),
            Some((k, _)) => {
                let key = shown(k);
                Err(self.bad(&key, format!("unknown key `{key}`"), "only the keys of this effect"))
            }
        }
    }
}

fn shown(v: &Value) -> String {
    serde_yaml::to_string(v).map_or_else(|_| "?".into(), |s| s.trim().to_string())
}

/// Reads one entry of `effects:`.
pub fn read(entry: &Value, robot: &Robot, doc: &Document) -> Result<Placed> {
    let Value::Mapping(map) = entry else {
        return Err(Error::bad(
            doc.place(&["effects"]),
            shown(entry),
            "an effect: `{effect: backlash, joint: A1, ...}`",
        ));
    };
    let mut map = map.clone();
    let text = |v: Option<Value>| v.and_then(|v| v.as_str().map(str::to_string));
    let Some(effect) = text(map.remove("effect")) else {
        return Err(Error::bad(doc.place(&["effects"]), "an entry without `effect`", "`effect: NAME`"));
    };
    let Some(target) = text(map.remove("joint").or_else(|| map.remove("target"))) else {
        return Err(Error::bad(doc.place(&[&effect]), format!("{effect} without `joint`"), "`joint: NAME`"));
    };
    let mut fields = Fields { map, doc, effect, target };
    if !NAMES.contains(&fields.effect.as_str()) {
        let found = format!("effect `{}`", fields.effect);
        return Err(fields.bad("effect", found, &format!("one of {}", NAMES.join(", "))));
    }
    let Some(axis) = robot.axis_named(&fields.target) else {
        let found = format!("joint `{}`", fields.target);
        return Err(fields.bad("joint", found, &format!("one of {}", robot.axis_names().join(", "))));
    };
    let kind = robot.axis(axis).kind;
    let (unit, si) = (kind.unit(), kind.si());
    let effect = match fields.effect.as_str() {
        "backlash" => Effect::Backlash(Backlash::constant(fields.needed(&format!("half_gap_{unit}"), 0.0)? * si)),
        "backlash_position" => {
            let knots: Vec<[f64; 2]> = fields.knots("knots")?.iter().map(|k| k.map(|v| v * si)).collect();
            match Pchip::new(&knots) {
                Some(p) if knots.iter().all(|k| k[1] >= 0.0) => {
                    Effect::Backlash(Backlash { half_gap: GapCurve::Pchip(p) })
                }
                _ => {
                    return Err(fields.bad(
                        "knots",
                        "knots that cannot be joined".into(),
                        "two or more, positions strictly rising, gaps of 0 or more",
                    ));
                }
            }
        }
        _ => {
            let spike = fields.needed(&format!("spike_{unit}"), 0.0)? * si;
            let time = fields.number("decay_s", f64::MIN_POSITIVE)?;
            let travel = fields.number(&format!("decay_{unit}"), f64::MIN_POSITIVE)?;
            let decay = match (time, travel) {
                (Some(s), None) => Decay::Time(s),
                (None, Some(x)) => Decay::Travel(x * si),
                _ => {
                    return Err(fields.bad(
                        "decay",
                        "no decay, or two".into(),
                        &format!("either `decay_s` or `decay_{unit}`"),
                    ));
                }
            };
            Effect::Stiction(Stiction { spike, decay })
        }
    };
    fields.finish()?;
    Ok(Placed { axis, effect })
}

/// The entry of an effect, in the units of the edges.
pub fn write(placed: &Placed, robot: &Robot) -> Value {
    let joint = robot.axis(placed.axis);
    let kind = joint.kind;
    let unit = kind.unit();
    let mut map = Mapping::new();
    let mut put = |k: String, v: Value| {
        map.insert(Value::String(k), v);
    };
    put("effect".into(), placed.effect.name().into());
    put("joint".into(), joint.name.clone().into());
    match &placed.effect {
        Effect::Backlash(b) => match b.half_gap.constant() {
            Some(gap) => put(format!("half_gap_{unit}"), kind.to_edge(gap).into()),
            None => put("knots".into(), knots_at_edge(&b.half_gap, kind)),
        },
        Effect::Stiction(s) => {
            put(format!("spike_{unit}"), kind.to_edge(s.spike).into());
            match s.decay {
                Decay::Time(t) => put("decay_s".into(), t.into()),
                Decay::Travel(x) => put(format!("decay_{unit}"), kind.to_edge(x).into()),
            }
        }
    }
    Value::Mapping(map)
}

/// Knots of a curve; a polynomial is sampled at 41 points of its range, which PCHIP joins again.
fn knots_at_edge(curve: &GapCurve, kind: JointKind) -> Value {
    let knots: Vec<[f64; 2]> = match curve {
        GapCurve::Pchip(p) => p.knots(),
        GapCurve::Polynomial { range: [lo, hi], .. } => {
            (0..=40).map(|k| lo + (hi - lo) * f64::from(k) / 40.0).map(|p| [p, curve.at(p)]).collect()
        }
        GapCurve::Constant(b) => vec![[0.0, *b], [1.0, *b]],
    };
    Value::Sequence(
        knots.iter().map(|k| Value::Sequence(k.iter().map(|&v| kind.to_edge(v).into()).collect())).collect(),
    )
}
