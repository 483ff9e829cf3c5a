//! What is to be distinguished: from the command line, or from a diagnosis.
//!
//! `backlash:A2,hysteresis:A2` names two alternatives; `+` joins effects of one alternative (`backlash:A2+backlash:A2` is two gaps in
//! series); `*` is every joint (`servo_lag:*`); sizes stand after the target (`backlash:A2:half_gap_deg=0.004`). `frame` (or
//! `nothing`) is the alternative without any effect: what the estimated frame can absorb.

use super::sizes::{self, Scale};
use crate::diagnose::Verdict;
use crate::diagnose::result::document::SCHEMA;
use crate::diagnose::search::across::ALL;
use crate::effects::{EffectInstance, catalogue, entry};
use crate::error::{Error, Place, Result};
use crate::io::yaml::Document;
use serde_yaml::{Mapping, Value};

/// One explanation: the effects that would have to be there.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// Name by which it is listed.
    pub name: String,
    /// Effects that would explain the log.
    pub effects: Vec<EffectInstance>,
}

/// Alternatives that a log could not tell apart, and what else is wrong with the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Set {
    /// Explanations that the log could not tell apart.
    pub alternatives: Vec<Alternative>,
    /// Further found effects: there in every alternative, refitted with it.
    pub common: Vec<EffectInstance>,
}

const EXPECTED: &str = "EFFECT:TARGET,EFFECT:TARGET with names of the catalogue, as backlash:A2,hysteresis:A2";

/// Reads alternatives, separated by commas, from the `text` of that name.
pub fn between(name: &str, text: &str, scale: &Scale) -> Result<Set> {
    let doc = Document { name, text };
    let mut alternatives: Vec<Alternative> = Vec::new();
    for part in text.split(',').map(str::trim) {
        let alternative = alternative(part, scale, &doc)?;
        if alternatives.iter().any(|r| r.name == alternative.name) {
            return Err(Error::setting("between", format!("`{part}` twice"), "every alternative once"));
        }
        alternatives.push(alternative);
    }
    if alternatives.len() < 2 {
        return Err(Error::setting("between", format!("`{text}`"), format!("two alternatives or more: {EXPECTED}")));
    }
    Ok(Set { alternatives, common: Vec::new() })
}

fn alternative(part: &str, scale: &Scale, doc: &Document) -> Result<Alternative> {
    if matches!(part, "frame" | "nothing") {
        return Ok(Alternative { name: part.into(), effects: Vec::new() });
    }
    let mut effects = Vec::new();
    let mut names = Vec::new();
    for one in part.split('+').map(str::trim) {
        let mut fields = one.split(':').map(str::trim);
        let name = fields.next().unwrap_or_default();
        if catalogue::find(name).is_none() {
            return Err(Error::bad(
                Place::file(doc.name),
                format!("effect `{name}`"),
                format!("one of {}", catalogue::names()),
            ));
        }
        let mut rest: Vec<&str> = fields.collect();
        let target = if rest.first().is_some_and(|t| !t.contains('=')) { rest.remove(0) } else { "" };
        let mut given = Mapping::new();
        for pair in rest {
            let Some((key, value)) = pair.split_once('=') else {
                return Err(Error::bad(Place::file(doc.name), format!("`{pair}` in `{one}`"), "key=value"));
            };
            let value: Value = serde_yaml::from_str(value.trim()).unwrap_or(Value::Null);
            given.insert(key.trim().into(), value);
        }
        let targets: Vec<String> = match target {
            "*" => scale.robot.axis_names().iter().map(|n| n.to_string()).collect(),
            t => vec![t.to_string()],
        };
        for t in &targets {
            effects.push(sizes::placed(name, t, &given, scale, doc)?);
        }
        names.push(if target.is_empty() { name.to_string() } else { format!("{name} {target}") });
    }
    Ok(Alternative { name: names.join(" + "), effects })
}

/// The effects that a diagnosis found.
fn effects(value: &serde_json::Value, name: &str, scale: &Scale, doc: &Document) -> Result<Vec<EffectInstance>> {
    let mut found = Vec::new();
    for e in value["effects"].as_array().into_iter().flatten() {
        let mut e = e.clone();
        // a document names the target beside the joint
        if let Some(map) = e.as_object_mut()
            && map.contains_key("joint")
        {
            map.shift_remove("target");
        }
        let yaml: Value = serde_json::from_value(e)
            .map_err(|e| Error::bad(Place::file(name), e.to_string(), "effects as in a model file"))?;
        found.push(entry::read(&yaml, scale.robot, doc)?);
    }
    Ok(found)
}

/// An alternative that the diagnosis did not name, with sizes typical of its kind.
fn first_guess(effect: &str, target: &str, scale: &Scale, doc: &Document) -> Result<Vec<EffectInstance>> {
    if catalogue::find(effect).is_none() {
        return Err(Error::bad(doc.place(&[effect]), format!("effect `{effect}` in a set"), "a name of the catalogue"));
    }
    let placed = |target: &str| sizes::placed(effect, target, &Mapping::new(), scale, doc);
    // the alternative of a clock offset: every joint by the same lag
    if target == ALL {
        return scale.robot.axis_names().into_iter().map(placed).collect();
    }
    Ok(vec![placed(target)?])
}

/// Reads the sets of a diagnosis document; `None` where it has none of two or more.
pub fn of_diagnosis(name: &str, text: &str, scale: &mut Scale) -> Result<Vec<Set>> {
    let doc = Document { name, text };
    let value: serde_json::Value = serde_json::from_str(text).map_err(|e| {
        Error::bad(
            Place::field(name, e.line() as u64, e.column() as u64),
            e.to_string(),
            format!("a diagnosis ({SCHEMA})"),
        )
    })?;
    doc.require_schema(value["schema"].as_str().unwrap_or("none"), SCHEMA)?;
    if serde_json::to_value(Verdict::BadData).is_ok_and(|bad| value["verdict"] == bad) {
        let reason = value["reason"].as_str().unwrap_or("its log cannot be right");
        let found = format!("a diagnosis of bad data: {reason}");
        return Err(Error::bad(Place::file(name), found, "a diagnosis of a log without such errors"));
    }
    let found = effects(&value, name, scale, &doc)?;
    let text_of = |p: &EffectInstance| (p.effect.name().to_string(), p.target_text(scale.robot));
    let names: Vec<(String, String)> = found.iter().map(text_of).collect();
    let mut sets = Vec::new();
    for round in value["rounds"].as_array().into_iter().flatten() {
        let members: Vec<(String, String)> = round["set"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|m| (m["effect"].as_str().unwrap_or("").into(), m["target"].as_str().unwrap_or("").into()))
            .collect();
        if members.len() < 2 {
            continue;
        }
        let own = names.iter().position(|n| *n == members[0]);
        scale.lost = vec![None; scale.robot.dof()];
        if let Some(p) = own.map(|k| &found[k])
            && let Some(axis) = p.axis()
        {
            scale.lost[axis] = sizes::lost_motion(&p.effect);
        }
        let alternatives = members
            .iter()
            .map(|(effect, target)| {
                let known = names.iter().position(|n| n.0 == *effect && n.1 == *target);
                let effects = match known {
                    Some(k) => vec![found[k].clone()],
                    None => first_guess(effect, target, scale, &doc)?,
                };
                Ok(Alternative { name: format!("{effect} {target}"), effects })
            })
            .collect::<Result<_>>()?;
        let common = found.iter().enumerate().filter(|(k, _)| Some(*k) != own).map(|(_, p)| p.clone()).collect();
        sets.push(Set { alternatives, common });
    }
    Ok(sets)
}
