//! An effect as it stands in a model file: `{effect: backlash, joint: A1, half_gap_deg: 0.0028}`.
//!
//! Angles are degrees, lengths millimetres (`_um` micrometres), by the kind of the joint. A joint is named by `joint: A1`, a coupling by
//! `target: A6<-A5` (or `joint: A6, from: A5`), a DH parameter by `target: A2.a`; tool, TCP and log need no name. A key
//! that the effect does not have, and a value that it cannot have, is refused with its line.

use super::curve::Pchip;
use super::*;
use crate::error::{Error, Result};
use crate::io::yaml::Document;
use crate::robot::{JointKind, Robot};
use nalgebra::Vector3;
use serde_yaml::{Mapping, Value};

/// The keys of one entry, taken one by one; what is left over at the end is unknown.
struct Fields<'a> {
    map: Mapping,
    doc: &'a Document<'a>,
    effect: String,
    target: String,
}

impl Fields<'_> {
    fn bad(&self, key: &str, found: String, expected: &str) -> Error {
        let mut needles: Vec<&str> = vec![&self.effect];
        needles.extend([self.target.as_str(), key].iter().filter(|n| !n.is_empty()));
        let of =
            if self.target.is_empty() { self.effect.clone() } else { format!("{} of {}", self.effect, self.target) };
        Error::bad(self.doc.place(&needles), format!("{found} in {of}"), expected)
    }

    fn take(&mut self, key: &str) -> Option<Value> {
        self.map.remove(key)
    }

    /// A finite number of `least` or more; `-inf`: any.
    fn number(&mut self, key: &str, least: f64) -> Result<Option<f64>> {
        let Some(v) = self.take(key) else { return Ok(None) };
        match v.as_f64() {
            Some(x) if x.is_finite() && x >= least => Ok(Some(x)),
            _ => {
                let expected = if least == f64::NEG_INFINITY {
                    "a finite number".to_string()
                } else if least == f64::MIN_POSITIVE {
                    "a finite number above 0".to_string()
                } else {
                    format!("a finite number of {least} or more")
                };
                Err(self.bad(key, format!("{key}: {}", shown(&v)), &expected))
            }
        }
    }

    fn needed(&mut self, key: &str, least: f64) -> Result<f64> {
        match self.number(key, least)? {
            Some(x) => Ok(x),
            None => Err(self.bad(key, format!("no `{key}`"), &format!("`{key}`"))),
        }
    }

    fn any(&mut self, key: &str) -> Result<f64> {
        self.needed(key, f64::NEG_INFINITY)
    }

    fn above_0(&mut self, key: &str) -> Result<f64> {
        self.needed(key, f64::MIN_POSITIVE)
    }

    fn knots(&mut self, key: &str) -> Result<Vec<[f64; 2]>> {
        let Some(v) = self.take(key) else {
            return Err(self.bad(key, format!("no `{key}`"), "`knots: [[position, half gap], ...]`"));
        };
        serde_yaml::from_value(v.clone())
            .map_err(|_| self.bad(key, format!("{key}: {}", shown(&v)), "pairs `[position, half gap]`"))
    }

    /// `x_mm, y_mm, z_mm` in m; one that is not there is 0, but not all three.
    fn xyz_m(&mut self) -> Result<Vector3<f64>> {
        let mut found = false;
        let mut v = Vector3::zeros();
        for (c, key) in v.iter_mut().zip(["x_mm", "y_mm", "z_mm"]) {
            if let Some(x) = self.number(key, f64::NEG_INFINITY)? {
                *c = x * 1e-3;
                found = true;
            }
        }
        if found { Ok(v) } else { Err(self.bad("", "no `x_mm`, `y_mm`, `z_mm`".into(), "at least one of them")) }
    }

    fn direction(&mut self) -> Result<Vector3<f64>> {
        let v = self.take("direction");
        let xyz: Option<[f64; 3]> = v.clone().and_then(|v| serde_yaml::from_value(v).ok());
        match xyz.map(Vector3::from) {
            Some(d) if d.iter().all(|x| x.is_finite()) && d.norm() > 0.0 && d.norm().is_finite() => Ok(d.normalize()),
            _ => {
                let found = v.map_or("no `direction`".into(), |v| format!("direction: {}", one_line_value(&v)));
                Err(self.bad("direction", found, "`direction: [x, y, z]` of a length above 0"))
            }
        }
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

fn one_line_value(v: &Value) -> String {
    shown(v).replace('\n', " ")
}

/// Reads one entry of `effects:`.
pub fn read(entry: &Value, robot: &Robot, doc: &Document) -> Result<EffectInstance> {
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
            let found = format!("joint {} in {effect}", one_line_value(&other));
            return Err(Error::bad(doc.place(&[&effect, "joint"]), found, "the name of a joint"));
        }
    };
    let fields = Fields { map, doc, effect, target: named.clone().unwrap_or_default() };
    let Some(card) = catalogue::find(&fields.effect) else {
        let found = format!("effect `{}`", fields.effect);
        let names: Vec<&str> = catalogue::CARDS.iter().map(|c| c.name).collect();
        return Err(fields.bad("effect", found, &format!("one of {}", names.join(", "))));
    };
    match card.stage {
        Stage::Servo | Stage::Gear => on_joint(fields, named, robot),
        Stage::Link if card.name == "axis_coupling" => coupled(fields, named, robot),
        Stage::Link => on_joint(fields, named, robot),
        Stage::Geometry if card.name == "link_error" => on_link(fields, named, robot),
        _ => on_machine(fields, named),
    }
}

fn name_of_joint(fields: &Fields, named: Option<String>) -> Result<String> {
    named.ok_or_else(|| {
        let place = fields.doc.place(&[&fields.effect]);
        Error::bad(place, format!("{} without `joint`", fields.effect), "`joint: NAME`")
    })
}

fn axis_of(fields: &Fields, key: &str, name: &str, robot: &Robot) -> Result<usize> {
    robot
        .axis_named(name)
        .ok_or_else(|| fields.bad(key, format!("joint `{name}`"), &format!("one of {}", robot.axis_names().join(", "))))
}

fn on_joint(mut f: Fields, named: Option<String>, robot: &Robot) -> Result<EffectInstance> {
    let name = name_of_joint(&f, named)?;
    let axis = axis_of(&f, "joint", &name, robot)?;
    let kind = robot.axis(axis).kind;
    let (unit, si) = (kind.unit(), kind.si());
    let key = |name: &str| format!("{name}_{unit}");
    let effect = match f.effect.as_str() {
        "servo_lag" => Effect::ServoLag(ServoLag { lag_s: f.needed("lag_s", 0.0)? }),
        "stiction" => {
            let spike = f.needed(&key("spike"), 0.0)? * si;
            let time = f.number("decay_s", f64::MIN_POSITIVE)?;
            let travel = f.number(&key("decay"), f64::MIN_POSITIVE)?;
            let decay = match (time, travel) {
                (Some(s), None) => Decay::Time(s),
                (None, Some(x)) => Decay::Travel(x * si),
                _ => {
                    let expected = format!("either `decay_s` or `decay_{unit}`");
                    return Err(f.bad("decay", "no decay, or two".into(), &expected));
                }
            };
            Effect::Stiction(Stiction { spike, decay })
        }
        "encoder_scale" => Effect::EncoderScale(EncoderScale { scale: f.any("scale_ppm")? * 1e-6 }),
        "transmission_error" => {
            if kind == JointKind::Prismatic && robot.axis(axis).lead_m_per_rev.is_none() {
                let found = format!("no `lead_mm_per_rev` of {name} in the robot file");
                return Err(f.bad("", found, "the lead of the screw: cycles count its turns"));
            }
            Effect::TransmissionError(TransmissionError {
                amplitude: f.needed(&key("amplitude"), 0.0)? * si,
                cycles_per_rev: f.above_0("cycles_per_rev")?,
                phase_rad: f.number("phase_deg", f64::NEG_INFINITY)?.unwrap_or(0.0).to_radians(),
            })
        }
        "backlash" => Effect::Backlash(Backlash::constant(f.needed(&key("half_gap"), 0.0)? * si)),
        "backlash_position" => {
            let knots: Vec<[f64; 2]> = f.knots("knots")?.iter().map(|k| k.map(|v| v * si)).collect();
            match Pchip::new(&knots) {
                Some(p) if knots.iter().all(|k| k[1] >= 0.0) => {
                    Effect::Backlash(Backlash { half_gap: GapCurve::Pchip(p) })
                }
                _ => {
                    return Err(f.bad(
                        "knots",
                        "knots that cannot be joined".into(),
                        "two or more, positions strictly rising, gaps of 0 or more",
                    ));
                }
            }
        }
        "backlash_speed" => Effect::BacklashSpeed(BacklashSpeed {
            half_gap: f.needed(&key("half_gap"), 0.0)? * si,
            slope: f.any(&format!("slope_{unit}_per_mm_s"))? * si * 1e3,
        }),
        "hysteresis" => Effect::Hysteresis(Hysteresis {
            half_width: f.needed(&key("half_width"), 0.0)? * si,
            presliding: f.above_0(&key("presliding"))? * si,
        }),
        "joint_zero_offset" => Effect::JointZeroOffset(JointZeroOffset { offset: f.any(&key("offset"))? * si }),
        // gravity_compliance
        _ => {
            let key = if kind == JointKind::Revolute { "compliance_deg_per_nm" } else { "compliance_mm_per_n" };
            Effect::GravityCompliance(GravityCompliance { compliance: f.any(key)? * si })
        }
    };
    f.finish()?;
    Ok(EffectInstance { target: Target::Joint(axis), effect })
}

fn coupled(mut f: Fields, named: Option<String>, robot: &Robot) -> Result<EffectInstance> {
    let name = name_of_joint(&f, named)?;
    let (to, arrow) = match name.split_once("<-") {
        Some((to, from)) => (to.trim().to_string(), Some(from.trim().to_string())),
        None => (name, None),
    };
    let from = match f.take("from") {
        None => None,
        Some(Value::String(s)) => Some(s),
        Some(other) => return Err(f.bad("from", format!("from: {}", one_line_value(&other)), "the name of a joint")),
    };
    let from = match (arrow, from) {
        (Some(a), Some(b)) if !a.eq_ignore_ascii_case(&b) => {
            return Err(f.bad("from", format!("from `{b}`"), &format!("`{a}`, as in the target")));
        }
        (Some(a), _) | (None, Some(a)) => a,
        (None, None) => return Err(f.bad("", "no `from`".into(), "`target: A6<-A5`, or `from: A5`")),
    };
    let (to, from) = (axis_of(&f, "target", &to, robot)?, axis_of(&f, "from", &from, robot)?);
    if to == from {
        return Err(f.bad("target", "a joint coupled with itself".into(), "two joints (for one: encoder_scale)"));
    }
    let scale = robot.axis(to).kind.si() / robot.axis(from).kind.si();
    let effect = Effect::AxisCoupling(AxisCoupling { ratio: f.any("ratio")? * scale });
    f.finish()?;
    Ok(EffectInstance { target: Target::Coupled { to, from }, effect })
}

fn on_link(mut f: Fields, named: Option<String>, robot: &Robot) -> Result<EffectInstance> {
    let expected = "`target: JOINT.a`, `.d` or `.alpha`";
    let Some(name) = named else {
        return Err(f.bad("", "no `target`".into(), expected));
    };
    let Some((joint, parameter)) = name.rsplit_once('.') else {
        return Err(f.bad("", format!("target `{name}`"), expected));
    };
    let parameter = match parameter {
        "a" => DhParameter::A,
        "d" => DhParameter::D,
        "alpha" => DhParameter::Alpha,
        _ => return Err(f.bad("", format!("target `{name}`"), expected)),
    };
    let Some(joint) = robot.joints.iter().position(|j| j.name.eq_ignore_ascii_case(joint)) else {
        let names: Vec<&str> = robot.joints.iter().map(|j| j.name.as_str()).collect();
        return Err(f.bad("", format!("joint `{joint}`"), &format!("one of {}", names.join(", "))));
    };
    let delta = match parameter {
        DhParameter::Alpha => f.any("delta_deg")?.to_radians(),
        _ => f.any("delta_mm")? * 1e-3,
    };
    f.finish()?;
    Ok(EffectInstance { target: Target::Link { joint, parameter }, effect: Effect::LinkError(LinkError { delta }) })
}

/// Tool, TCP and log: there is one of each, so a name is not needed.
fn on_machine(mut f: Fields, named: Option<String>) -> Result<EffectInstance> {
    let (target, text) = match f.effect.as_str() {
        "tool_error" => (Target::Tool, "tool"),
        "time_offset" => (Target::Log, "log"),
        _ => (Target::Tcp, "tcp"),
    };
    if let Some(name) = named
        && !name.eq_ignore_ascii_case(text)
    {
        return Err(f.bad("", format!("target `{name}`"), &format!("none, or `target: {text}`")));
    }
    let effect = match f.effect.as_str() {
        "tool_error" => Effect::ToolError(ToolError { offset_m: f.xyz_m()? }),
        "thermal_drift" => Effect::ThermalDrift(ThermalDrift { amplitude_m: f.xyz_m()?, tau_s: f.above_0("tau_s")? }),
        "vibration" => Effect::Vibration(Vibration {
            amplitude_m: f.needed("amplitude_um", 0.0)? * 1e-6,
            frequency_hz: f.above_0("frequency_hz")?,
            phase_rad: f.number("phase_deg", f64::NEG_INFINITY)?.unwrap_or(0.0).to_radians(),
            direction: f.direction()?,
        }),
        // time_offset
        _ => Effect::TimeOffset(TimeOffset { offset_s: f.any("offset_s")? }),
    };
    f.finish()?;
    Ok(EffectInstance { target, effect })
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
        Target::Tool | Target::Tcp | Target::Log => {}
    }
    match &placed.effect {
        Effect::Backlash(b) if b.half_gap.constant().is_none() => {
            if let Some(axis) = placed.axis() {
                put("knots", knots_at_edge(&b.half_gap, robot.axis(axis).kind));
            }
        }
        Effect::Vibration(v) => {
            put("amplitude_um", (v.amplitude_m * 1e6).into());
            put("frequency_hz", v.frequency_hz.into());
            put("phase_deg", v.phase_rad.to_degrees().into());
            put("direction", Value::Sequence(v.direction.iter().map(|&x| x.into()).collect()));
        }
        effect => {
            for ((key, factor), value) in placed.keys(robot).iter().zip(effect.values()) {
                put(key, (value * factor).into());
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
