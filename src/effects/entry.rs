//! An effect as it stands in a model file: `{effect: backlash, joint: A1, half_gap_deg: 0.0028}`.
//!
//! Angles are degrees, lengths millimetres (`_um` micrometres), by the kind of the joint. A joint is named by `joint: A1`, a coupling by
//! `target: A6<-A5` (or `joint: A6, from: A5`), a DH parameter by `target: A2.a`; tool, TCP and log need no name. A key
//! that the effect does not have, and a value that it cannot have, is refused with its line.

use super::fields::{Fields, one_line, shown};
use super::*;
use crate::error::{Error, Result};
use crate::io::names;
use crate::io::yaml::Document;
use crate::robot::Robot;
use serde_yaml::{Mapping, Value};

/// Reads one entry of `effects:`.
pub fn read(entry: &Value, robot: &Robot, doc: &Document) -> Result<EffectInstance> {
    read_with(catalogue::ALL, entry, robot, doc)
}

/// The same with another catalogue: one that has further effects.
pub fn read_with(
    catalogue: &[&'static EffectInfo],
    entry: &Value,
    robot: &Robot,
    doc: &Document,
) -> Result<EffectInstance> {
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
    let named = match map.remove("joint") {
        None => map.remove("target"),
        Some(joint) => match map.remove("target") {
            Some(target) if target != joint => {
                let found = format!("joint `{}` and target `{}` in {effect}", shown(&joint), shown(&target));
                return Err(Error::bad(doc.place(&[&effect, "target"]), found, "one of the two"));
            }
            _ => Some(joint),
        },
    };
    let named = match named {
        None => None,
        Some(Value::String(name)) => Some(name),
        Some(other) => {
            let found = format!("joint {} in {effect}", one_line(&other));
            return Err(Error::bad(doc.place(&[&effect, "joint"]), found, "the name of a joint"));
        }
    };
    let written = named.clone().unwrap_or_default();
    let mut fields = Fields { map, doc, robot, effect, named: written, target: Target::Log };
    let Some(info) = catalogue.iter().find(|e| e.name == fields.effect) else {
        let found = format!("effect `{}`", fields.effect);
        let all = catalogue.iter().map(|e| e.name);
        let nearest = all.min_by_key(|name| names::edits(name, &fields.effect)).unwrap_or_default();
        return Err(fields.bad("effect", found, &format!("an effect of docs/effects.md; the nearest is `{nearest}`")));
    };
    fields.target = target(info.acts_on, &mut fields, named)?;
    let target = fields.target;
    let effect = (info.read)(&mut fields)?;
    fields.finish()?;
    Ok(EffectInstance { target, effect })
}

/// The target that an entry names, of the kind that its effect has.
fn target(kind: ActsOn, f: &mut Fields, named: Option<String>) -> Result<Target> {
    match kind {
        ActsOn::Joint => {
            let name = name_of_joint(f, named)?;
            Ok(Target::Joint(axis_of(f, "joint", &name)?))
        }
        ActsOn::Coupling => coupling(f, named),
        ActsOn::DhParameter(allowed) => dh_parameter(f, named, allowed),
        ActsOn::JointOrDhParameter(allowed) => match named {
            Some(name) if name.contains('.') && f.robot.axis_named(&name).is_none() => {
                dh_parameter(f, Some(name), allowed)
            }
            named => target(ActsOn::Joint, f, named),
        },
        ActsOn::JointOrTcp => match named {
            Some(name) if !name.eq_ignore_ascii_case("tcp") => target(ActsOn::Joint, f, Some(name)),
            named => the_only(f, named, Target::Tcp, "tcp"),
        },
        ActsOn::Base => the_only(f, named, Target::Base, "base"),
        ActsOn::Tool => the_only(f, named, Target::Tool, "tool"),
        ActsOn::Tcp => the_only(f, named, Target::Tcp, "tcp"),
        ActsOn::Log => the_only(f, named, Target::Log, "log"),
    }
}

fn name_of_joint(fields: &Fields, named: Option<String>) -> Result<String> {
    named.ok_or_else(|| {
        let place = fields.doc.place(&[&fields.effect]);
        Error::bad(place, format!("{} without `joint`", fields.effect), "`joint: NAME`")
    })
}

fn axis_of(fields: &Fields, key: &str, name: &str) -> Result<usize> {
    let robot = fields.robot;
    robot
        .axis_named(name)
        .ok_or_else(|| fields.bad(key, format!("joint `{name}`"), &format!("one of {}", robot.axis_names().join(", "))))
}

fn coupling(f: &mut Fields, named: Option<String>) -> Result<Target> {
    let name = name_of_joint(f, named)?;
    let (to, arrow) = match name.split_once("<-") {
        Some((to, from)) => (to.trim().to_string(), Some(from.trim().to_string())),
        None => (name, None),
    };
    let from = match f.take("from") {
        None => None,
        Some(Value::String(s)) => Some(s),
        Some(other) => return Err(f.bad("from", format!("from: {}", one_line(&other)), "the name of a joint")),
    };
    let from = match (arrow, from) {
        (Some(a), Some(b)) if !a.eq_ignore_ascii_case(&b) => {
            return Err(f.bad("from", format!("from `{b}`"), &format!("`{a}`, as in the target")));
        }
        (Some(a), _) | (None, Some(a)) => a,
        (None, None) => return Err(f.bad("", "no `from`", "`target: A6<-A5`, or `from: A5`")),
    };
    let (to, from) = (axis_of(f, "target", &to)?, axis_of(f, "from", &from)?);
    if to == from {
        return Err(f.bad("target", "a joint coupled with itself", "two joints (for one: encoder_scale)"));
    }
    Ok(Target::Coupled { to, from })
}

fn dh_parameter(f: &Fields, named: Option<String>, allowed: &[DhParameter]) -> Result<Target> {
    let ways: Vec<String> = allowed.iter().skip(1).map(|p| format!("`.{}`", p.text())).collect();
    let first = allowed.first().map_or("", |p| p.text());
    let expected = match ways.split_last() {
        Some((last, [])) => format!("`target: JOINT.{first}` or {last}"),
        Some((last, more)) => format!("`target: JOINT.{first}`, {} or {last}", more.join(", ")),
        None => format!("`target: JOINT.{first}`"),
    };
    let Some(name) = named else {
        return Err(f.bad("", "no `target`", &expected));
    };
    let Some((joint, parameter)) = name.rsplit_once('.') else {
        return Err(f.bad("", format!("target `{name}`"), &expected));
    };
    let Some(&parameter) = allowed.iter().find(|p| p.text() == parameter) else {
        return Err(f.bad("", format!("target `{name}`"), &expected));
    };
    let Some(joint) = f.robot.joints.iter().position(|j| j.name.eq_ignore_ascii_case(joint)) else {
        let names: Vec<&str> = f.robot.joints.iter().map(|j| j.name.as_str()).collect();
        return Err(f.bad("", format!("joint `{joint}`"), &format!("one of {}", names.join(", "))));
    };
    Ok(Target::Link { joint, parameter })
}

/// Tool, TCP and log: there is one of each, so a name is not needed.
fn the_only(f: &Fields, named: Option<String>, target: Target, text: &str) -> Result<Target> {
    match named {
        Some(name) if !name.eq_ignore_ascii_case(text) => {
            Err(f.bad("", format!("target `{name}`"), &format!("none, or `target: {text}`")))
        }
        _ => Ok(target),
    }
}

/// The entry of an effect, in the units of the edges.
pub fn write(placed: &EffectInstance, robot: &Robot) -> Value {
    let mut map = Mapping::new();
    let mut put = |k: &str, v: Value| {
        map.insert(Value::String(k.into()), v);
    };
    put("effect", placed.effect.name().into());
    match placed.target {
        Target::Joint(axis) => put("joint", robot.axis(axis).name.clone().into()),
        Target::Coupled { from, .. } => {
            put("target", placed.target_text(robot).into());
            put("from", robot.axis(from).name.clone().into());
        }
        Target::Link { .. } => put("target", placed.target_text(robot).into()),
        Target::Base | Target::Tool | Target::Tcp | Target::Log => {}
    }
    placed.effect.write(&placed.site(robot), &mut map);
    Value::Mapping(map)
}
