//! The entry of one joint in a compensator file, read and written: `backlash` and `friction`.

use super::*;
use crate::compensator::response::{MOST_SPIKES, MOST_WINDUPS};
use crate::compensator::schedule::{self, tidy};
use crate::compensator::{BacklashOffset, FrictionOffset, FrictionShape, JointCompensator, Response, Spike, Windup};
use crate::effects::{Decay, GapCurve};
use crate::error::Result;
use crate::robot::Joint;
use serde_yaml::{Mapping, Value};

pub(in crate::compensator) fn write_joint(j: &JointCompensator, joint: &Joint) -> Mapping {
    let mut entry = Mapping::new();
    if let Some(b) = &j.backlash {
        entry.insert("backlash".into(), write_backlash(b, joint));
    }
    if let Some(f) = &j.friction {
        entry.insert("friction".into(), write_friction(f, joint));
    }
    entry
}

pub(in crate::compensator) fn read_joint(
    axis: usize,
    value: &Value,
    joint: &Joint,
    at: &Spot,
) -> Result<JointCompensator> {
    let map = at.mapping(value)?;
    at.only(map, &["backlash", "friction"])?;
    let backlash = match map.get("backlash") {
        None => None,
        Some(v) => Some(read_backlash(v, joint, &at.at("backlash"))?),
    };
    let friction = match map.get("friction") {
        None => None,
        Some(v) => Some(read_friction(v, joint, &at.at("friction"))?),
    };
    Ok(JointCompensator { axis, backlash, friction })
}

fn read_backlash(value: &Value, joint: &Joint, at: &Spot) -> Result<BacklashOffset> {
    let (unit, si) = (joint.kind.unit(), joint.kind.si_per_user_unit());
    let keys = [format!("half_gap_{unit}"), "schedule".into(), format!("positive_{unit}"), format!("negative_{unit}")];
    let sides = ["positive_schedule", "negative_schedule"];
    let map = at.mapping(value)?;
    let known: Vec<&str> = keys.iter().map(String::as_str).chain(sides).collect();
    at.only(map, &known)?;
    let curve = |number_key: &str, schedule_key: &str| -> Result<Option<GapCurve>> {
        let number = at.number(map, number_key, 0.0)?;
        match (number, map.get(schedule_key)) {
            (Some(_), Some(_)) => {
                Err(at.bad(format!("both `{number_key}` and `{schedule_key}`"), "one of the two".into()))
            }
            (Some(x), None) => Ok(Some(GapCurve::Constant(x * si))),
            (None, Some(v)) => match schedule::read(v, joint) {
                Ok(c) => Ok(Some(c)),
                Err((key, found, expected)) => {
                    let path = [&at.path[..], &[schedule_key, key.as_str()]].concat();
                    Err(Spot { doc: at.doc, path }.bad(found, expected))
                }
            },
            (None, None) => Ok(None),
        }
    };
    match (curve(&keys[0], "schedule")?, curve(&keys[2], sides[0])?, curve(&keys[3], sides[1])?) {
        (Some(c), None, None) => Ok(BacklashOffset::symmetric(c)),
        (None, Some(positive), Some(negative)) => Ok(BacklashOffset { positive, negative }),
        _ => Err(at.bad(
            "no gap, or two kinds of gap".into(),
            format!("`half_gap_{unit}`, or `schedule`, or both `positive_{unit}` and `negative_{unit}`"),
        )),
    }
}

fn write_backlash(b: &BacklashOffset, joint: &Joint) -> Value {
    let unit = joint.kind.unit();
    let mut map = Mapping::new();
    let mut put = |curve: &GapCurve, number_key: String, schedule_key: &str| match schedule::write(curve, joint) {
        Some(v) => map.insert(schedule_key.into(), v),
        None => map.insert(number_key.into(), tidy(joint.kind.to_user_unit(curve.at(0.0))).into()),
    };
    if b.positive == b.negative {
        put(&b.positive, format!("half_gap_{unit}"), "schedule");
    } else {
        put(&b.positive, format!("positive_{unit}"), "positive_schedule");
        put(&b.negative, format!("negative_{unit}"), "negative_schedule");
    }
    Value::Mapping(map)
}

fn read_friction(value: &Value, joint: &Joint, at: &Spot) -> Result<FrictionOffset> {
    let (unit, si) = (joint.kind.unit(), joint.kind.si_per_user_unit());
    let (gain_key, travel_key) = (format!("gain_{unit}"), format!("decay_{unit}"));
    let map = at.mapping(value)?;
    let response_key = "response";
    at.only(map, &[&gain_key, "decay_s", &travel_key, "exponent", "poses", response_key])?;
    if let Some(value) = map.get(response_key) {
        if map.len() > 2 || (map.len() == 2 && !map.contains_key(gain_key.as_str())) {
            return Err(at.bad("a response together with another decay".into(), "`response` alone".into()));
        }
        at.number(map, &gain_key, 0.0)?;
        return read_response(value, joint, &at.at(response_key)).map(FrictionOffset::of_response);
    }
    let above_zero = f64::MIN_POSITIVE;
    let gain = at.number(map, &gain_key, 0.0)?;
    let time = at.number(map, "decay_s", above_zero)?;
    let travel = at.number(map, &travel_key, above_zero)?;
    let exponent = at.number(map, "exponent", above_zero)?;
    let poses = at.number(map, "poses", 2.0)?;
    let Some(gain) = gain else {
        return Err(at.bad(format!("no `{gain_key}`"), format!("`{gain_key}` and its decay")));
    };
    let shape = match (time, travel, exponent, poses) {
        (Some(s), None, None, None) => FrictionShape::Decay(Decay::Time(s)),
        (None, Some(x), None, None) => FrictionShape::Decay(Decay::Travel(x * si)),
        (None, None, Some(exponent), Some(poses)) => {
            if poses.fract() != 0.0 || poses > f64::from(u32::MAX) {
                return Err(at.at("poses").bad(format!("poses: {poses}"), "a whole number of 2 or more".into()));
            }
            FrictionShape::Poses { exponent, poses: poses as u32 }
        }
        _ => {
            return Err(at.bad(
                "a gain without a decay, or with two of them".into(),
                format!("one of `decay_s`, `{travel_key}`, or both `exponent` and `poses`"),
            ));
        }
    };
    Ok(FrictionOffset { gain: gain * si, shape })
}

/// `response: {presliding_deg, windups: [[windup_deg, presliding_deg], ...], spikes: [[gain_deg, decay_s], ...]}`.
fn read_response(value: &Value, joint: &Joint, at: &Spot) -> Result<Response> {
    let (unit, si) = (joint.kind.unit(), joint.kind.si_per_user_unit());
    let presliding_key = format!("presliding_{unit}");
    let map = at.mapping(value)?;
    at.only(map, &[&presliding_key, "windups", "spikes"])?;
    let Some(presliding) = at.number(map, &presliding_key, f64::MIN_POSITIVE)? else {
        return Err(
            at.bad(format!("no `{presliding_key}`"), "the travel over which friction changes its direction".into())
        );
    };
    let pairs = |key: &str, most: usize, second: &str| -> Result<Vec<[f64; 2]>> {
        let read: Option<Vec<[f64; 2]>> = match map.get(key) {
            None => Some(Vec::new()),
            Some(v) => serde_yaml::from_value(v.clone()).ok(),
        };
        let sound =
            |p: &Vec<[f64; 2]>| p.len() <= most && p.iter().all(|[g, d]| g.is_finite() && d.is_finite() && *d > 0.0);
        read.filter(sound).ok_or_else(|| {
            let expected = format!("at most {most} pairs of a size in {unit} and a {second} above 0, finite");
            at.bad(format!("{key} that cannot be read"), expected)
        })
    };
    let mut windups = [Windup { half: 0.0, presliding }; MOST_WINDUPS];
    for (w, [half, over]) in windups.iter_mut().zip(pairs("windups", MOST_WINDUPS, "presliding")?) {
        *w = Windup { half: half * si, presliding: over * si };
    }
    let pairs = pairs("spikes", MOST_SPIKES, "decay_s")?;
    let mut spikes = [Spike { gain: 0.0, decay_s: 1.0 }; MOST_SPIKES];
    for (s, [gain, decay_s]) in spikes.iter_mut().zip(pairs) {
        *s = Spike { gain: gain * si, decay_s };
    }
    Ok(Response { presliding: presliding * si, windups, spikes })
}

fn write_friction(f: &FrictionOffset, joint: &Joint) -> Value {
    let unit = joint.kind.unit();
    let mut map = Mapping::new();
    map.insert(format!("gain_{unit}").into(), tidy(joint.kind.to_user_unit(f.gain)).into());
    match f.shape {
        FrictionShape::Decay(Decay::Time(s)) => {
            map.insert("decay_s".into(), tidy(s).into());
        }
        FrictionShape::Decay(Decay::Travel(x)) => {
            map.insert(format!("decay_{unit}").into(), tidy(joint.kind.to_user_unit(x)).into());
        }
        FrictionShape::Poses { exponent, poses } => {
            map.insert("exponent".into(), tidy(exponent).into());
            map.insert("poses".into(), poses.into());
        }
        FrictionShape::Response(r) => {
            let edge = |v: f64| Value::from(tidy(joint.kind.to_user_unit(v)));
            let mut response = Mapping::new();
            response.insert(format!("presliding_{unit}").into(), edge(r.presliding));
            let wound = r.windups.iter().filter(|w| w.half != 0.0);
            let pairs = wound.map(|w| Value::Sequence(vec![edge(w.half), edge(w.presliding)])).collect();
            response.insert("windups".into(), Value::Sequence(pairs));
            let used = r.spikes.iter().filter(|s| s.gain != 0.0);
            let pairs = used.map(|s| Value::Sequence(vec![edge(s.gain), tidy(s.decay_s).into()])).collect();
            response.insert("spikes".into(), Value::Sequence(pairs));
            map.insert("response".into(), Value::Mapping(response));
        }
    }
    Value::Mapping(map)
}
