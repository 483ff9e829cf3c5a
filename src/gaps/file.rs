//! The document `lostmotion/gaps/1`, to and from [`Gaps`]: JSON on standard output, YAML in a file, the same content.
//!
//! Keys carry the unit of their joint: `half_gap_deg` of a revolute joint, `half_gap_mm` of a prismatic one. Figures are
//! written with ten significant digits. Reading takes either form (JSON is YAML), ignores keys that it does not know (fields
//! may be added), and refuses what cannot be used: another schema, another robot, an unknown joint, a missing or infinite
//! number.

use super::{GapPoint, Gaps, JointGap, LogRef, Registered, StictionFound};
use crate::effect::curve::Pchip;
use crate::effect::{Decay, GapCurve};
use crate::error::{Error, Place, Result};
use crate::io::{input, yaml, yaml::Document};
use crate::robot::file::FrameFile;
use crate::robot::{JointKind, Robot};
use serde_json::{Map, Value, json};
use std::path::Path;

pub const SCHEMA: &str = "lostmotion/gaps/1";

/// A number with ten significant digits; one that is not finite is null.
pub fn number(v: f64) -> Value {
    let rounded: f64 = format!("{v:.9e}").parse().unwrap_or(v);
    serde_json::Number::from_f64(rounded + 0.0).map_or(Value::Null, Value::Number)
}

/// Joint values (rad or m) in the unit of the edges.
pub fn at_edge(values: &[f64], kind: JointKind) -> Value {
    values.iter().map(|&v| number(kind.to_edge(v))).collect()
}

/// The document.
pub fn document(gaps: &Gaps, robot: &Robot) -> Value {
    let mut doc = Map::new();
    doc.insert("schema".into(), SCHEMA.into());
    doc.insert("robot".into(), json!({"name": gaps.robot_name, "sha256": gaps.robot_sha256}));
    doc.insert("logs".into(), gaps.logs.iter().map(|l| json!({"name": l.name, "sha256": l.sha256})).collect());
    doc.insert("registration".into(), gaps.registration.as_ref().map_or(Value::Null, registration));
    if let Some(v) = gaps.tcp_speed_m_s {
        doc.insert("tcp_speed_mm_s".into(), number(v * 1e3));
    }
    let points = gaps.points.iter().map(|p| {
        let joint = robot.axis(p.axis);
        let (kind, unit) = (joint.kind, joint.kind.unit());
        let mut m = Map::new();
        m.insert("joint".into(), joint.name.clone().into());
        m.insert(format!("at_{unit}"), number(kind.to_edge(p.at)));
        m.insert(format!("half_gap_{unit}"), number(kind.to_edge(p.half_gap)));
        m.insert("ci95".into(), at_edge(&p.ci95, kind));
        m.insert("cycles".into(), p.cycles.into());
        if !p.per_cycle.is_empty() {
            m.insert(format!("per_cycle_{unit}"), at_edge(&p.per_cycle, kind));
        }
        Value::Object(m)
    });
    doc.insert("points".into(), points.collect());
    let joints = gaps.joints.iter().map(|j| {
        let joint = robot.axis(j.axis);
        let (kind, unit) = (joint.kind, joint.kind.unit());
        let mut m = Map::new();
        m.insert("joint".into(), joint.name.clone().into());
        m.insert(format!("half_gap_{unit}"), number(kind.to_edge(j.half_gap)));
        m.insert("ci95".into(), at_edge(&j.ci95, kind));
        m.insert("significant".into(), j.significant.into());
        m.insert("schedule".into(), j.schedule.as_ref().map_or(Value::Null, |c| curve(c, kind)));
        m.insert("varies_p_value".into(), j.varies_p_value.map_or(Value::Null, number));
        m.insert("stiction".into(), j.stiction.as_ref().map_or(Value::Null, |s| stiction(s, kind)));
        if let Some(p) = j.stiction_p_value {
            m.insert("stiction_p_value".into(), number(p));
        }
        Value::Object(m)
    });
    doc.insert("joints".into(), joints.collect());
    doc.insert("notes".into(), gaps.notes.iter().cloned().collect());
    Value::Object(doc)
}

fn registration(r: &Registered) -> Value {
    let frame = FrameFile::from_isometry(&r.frame);
    let list = |values: [f64; 3], scale: f64| -> Value { values.iter().map(|v| number(v * scale)).collect() };
    let mut m = Map::new();
    m.insert("xyz_mm".into(), list(frame.xyz_mm, 1.0));
    m.insert("rpy_deg".into(), list(frame.rpy_deg, 1.0));
    m.insert("rms_um".into(), number(r.rms_m * 1e6));
    m.insert("samples".into(), r.samples.into());
    if r.sigma_m.iter().chain(&r.sigma_rad).any(|s| *s > 0.0) {
        m.insert("sigma_um".into(), list(r.sigma_m, 1e6));
        m.insert("sigma_deg".into(), list(r.sigma_rad, 1f64.to_degrees()));
    }
    Value::Object(m)
}

fn stiction(s: &StictionFound, kind: JointKind) -> Value {
    let unit = kind.unit();
    let mut m = Map::new();
    m.insert(format!("spike_{unit}"), number(kind.to_edge(s.spike)));
    m.insert("ci95".into(), at_edge(&s.ci95, kind));
    match s.decay {
        Decay::Time(t) => {
            m.insert("decay_s".into(), number(t));
            m.insert("decay_ci95".into(), s.decay_ci95.iter().map(|&v| number(v)).collect());
        }
        Decay::Travel(x) => {
            m.insert(format!("decay_{unit}"), number(kind.to_edge(x)));
            m.insert("decay_ci95".into(), at_edge(&s.decay_ci95, kind));
        }
    }
    Value::Object(m)
}

/// A gap curve: `{kind: pchip, knots: [[position, half gap], ...]}` or `{kind: polynomial, coefficients, range_deg}`, position
/// and gap both in deg (or mm).
pub fn curve(curve: &GapCurve, kind: JointKind) -> Value {
    match curve {
        GapCurve::Constant(b) => {
            json!({"kind": "constant", format!("half_gap_{}", kind.unit()): number(kind.to_edge(*b))})
        }
        GapCurve::Pchip(p) => {
            let knots: Value = p.knots().iter().map(|k| at_edge(k, kind)).collect();
            json!({"kind": "pchip", "knots": knots})
        }
        GapCurve::Polynomial { coefficients, range } => {
            let si = kind.si();
            let c: Value = coefficients.iter().enumerate().map(|(k, c)| number(c * si.powi(k as i32 - 1))).collect();
            json!({"kind": "polynomial", "coefficients": c, format!("range_{}", kind.unit()): at_edge(range, kind)})
        }
    }
}

/// One JSON document with a newline at its end.
pub fn to_json(doc: &Value) -> Result<String> {
    let text = serde_json::to_string_pretty(doc)
        .map_err(|e| Error::bad(Place::default(), e.to_string(), "values that JSON can hold"))?;
    Ok(text + "\n")
}

/// The same as YAML. A number like `5e-5` becomes `5.0e-05`: YAML 1.1 readers take the short form for text.
pub fn to_yaml(doc: &Value) -> Result<String> {
    let text = yaml::to_text(doc)?;
    let mut out = String::with_capacity(text.len());
    for line in text.lines() {
        let cut = line.rfind([' ']).map_or(0, |i| i + 1);
        let (head, last) = line.split_at(cut);
        out.push_str(head);
        match last.split_once(['e', 'E']) {
            Some((mantissa, exponent)) if mantissa.parse::<f64>().is_ok() && exponent.parse::<i32>().is_ok() => {
                let point = if mantissa.contains('.') { "" } else { ".0" };
                let (sign, digits) = match exponent.strip_prefix('-') {
                    Some(d) => ('-', d),
                    None => ('+', exponent.trim_start_matches('+')),
                };
                out.push_str(&format!("{mantissa}{point}e{sign}{digits:0>2}"));
            }
            _ => out.push_str(last),
        }
        out.push('\n');
    }
    Ok(out)
}

impl Gaps {
    /// Reads and checks a gaps file for a robot; `-` is standard input.
    pub fn load(path: &Path, robot: &Robot) -> Result<Self> {
        let (text, input) = input::read_text(path)?;
        Self::parse(&input.name, &text, robot)
    }

    /// Parses and checks the text of a gaps file; `name` stands in messages.
    pub fn parse(name: &str, text: &str, robot: &Robot) -> Result<Self> {
        let doc = Document { name, text };
        let root: Value = doc.parse("a gaps file (schema lostmotion/gaps/1)")?;
        let top = Node { doc: &doc, robot, value: &root, path: Vec::new() };
        doc.require_schema(&top.text("schema")?, SCHEMA)?;
        let robot_node = top.child("robot");
        let robot_name = robot_node.as_ref().map_or(Ok(String::new()), |r| r.text("name"))?;
        let robot_sha256 = match &robot_node {
            Some(r) if r.child("sha256").is_some() => r.text("sha256")?,
            _ => robot.fingerprint(),
        };
        if robot_sha256 != robot.fingerprint() {
            return Err(Error::bad(
                doc.place(&["sha256"]),
                format!("gaps of another robot, `{robot_name}` ({robot_sha256})"),
                format!("gaps of `{}` ({})", robot.name, robot.fingerprint()),
            ));
        }
        let logs = top
            .children("logs")?
            .iter()
            .map(|l| Ok(LogRef { name: l.text("name")?, sha256: l.text("sha256")? }))
            .collect::<Result<_>>()?;
        Ok(Self {
            robot_name,
            robot_sha256,
            logs,
            registration: top.child("registration").map(|r| r.registration()).transpose()?,
            points: top.children("points")?.iter().map(Node::point).collect::<Result<_>>()?,
            joints: top.children("joints")?.iter().map(Node::joint).collect::<Result<_>>()?,
            tcp_speed_m_s: top.optional("tcp_speed_mm_s")?.map(|v| v * 1e-3),
            notes: top.children("notes")?.iter().filter_map(|n| n.value.as_str().map(str::to_string)).collect(),
        })
    }
}

/// A value of the document and the way to it, for messages.
struct Node<'a> {
    doc: &'a Document<'a>,
    robot: &'a Robot,
    value: &'a Value,
    path: Vec<String>,
}

impl Node<'_> {
    fn bad(&self, key: &str, found: String, expected: &str) -> Error {
        let mut path = self.path.clone();
        path.push(key.into());
        Error::bad(self.doc.place(&[key]), format!("{found} at {}", path.join(".")), expected)
    }

    fn child(&self, key: &str) -> Option<Node<'_>> {
        let value = self.value.get(key).filter(|v| !v.is_null())?;
        let mut path = self.path.clone();
        path.push(key.into());
        Some(Node { doc: self.doc, robot: self.robot, value, path })
    }

    fn children(&self, key: &str) -> Result<Vec<Node<'_>>> {
        let Some(node) = self.child(key) else { return Ok(Vec::new()) };
        let Value::Array(list) = node.value else {
            return Err(self.bad(key, format!("`{}`", node.value), "a list"));
        };
        let numbered = |i: usize| {
            let mut path = self.path.clone();
            path.push(format!("{key}[{i}]"));
            path
        };
        let node = |(i, value)| Node { doc: self.doc, robot: self.robot, value, path: numbered(i) };
        Ok(list.iter().enumerate().map(node).collect())
    }

    fn text(&self, key: &str) -> Result<String> {
        match self.value.get(key) {
            Some(Value::String(s)) => Ok(s.clone()),
            Some(v) => Err(self.bad(key, format!("`{v}`"), "text")),
            None => Err(self.bad(key, format!("no `{key}`"), &format!("`{key}`"))),
        }
    }

    fn optional(&self, key: &str) -> Result<Option<f64>> {
        match self.value.get(key) {
            None | Some(Value::Null) => Ok(None),
            Some(v) => match v.as_f64() {
                Some(x) if x.is_finite() => Ok(Some(x)),
                _ => Err(self.bad(key, format!("`{v}`"), "a finite number")),
            },
        }
    }

    fn number(&self, key: &str) -> Result<f64> {
        self.optional(key)?.ok_or_else(|| self.bad(key, format!("no `{key}`"), &format!("`{key}`: a finite number")))
    }

    fn numbers(&self, key: &str) -> Result<Vec<f64>> {
        let Some(v) = self.value.get(key) else {
            return Err(self.bad(key, format!("no `{key}`"), "a list of numbers"));
        };
        let list: Option<Vec<f64>> =
            v.as_array().and_then(|a| a.iter().map(|x| x.as_f64().filter(|f| f.is_finite())).collect());
        list.ok_or_else(|| self.bad(key, format!("`{v}`"), "a list of finite numbers"))
    }

    fn array<const N: usize>(&self, key: &str) -> Result<[f64; N]> {
        let list = self.numbers(key)?;
        list.as_slice()
            .try_into()
            .map_err(|_| self.bad(key, format!("{} numbers", list.len()), &format!("{N} numbers")))
    }

    /// The joint that `joint` names: axis and kind.
    fn axis(&self) -> Result<(usize, JointKind)> {
        let name = self.text("joint")?;
        match self.robot.axis_named(&name) {
            Some(axis) => Ok((axis, self.robot.axis(axis).kind)),
            None => Err(self.bad(
                "joint",
                format!("joint `{name}`"),
                &format!("one of {}", self.robot.axis_names().join(", ")),
            )),
        }
    }

    fn registration(&self) -> Result<Registered> {
        let frame = FrameFile { xyz_mm: self.array("xyz_mm")?, rpy_deg: self.array("rpy_deg")? };
        let sigma = |key: &str, scale: f64| -> Result<[f64; 3]> {
            if self.child(key).is_some() { Ok(self.array::<3>(key)?.map(|v| v * scale)) } else { Ok([0.0; 3]) }
        };
        Ok(Registered {
            frame: frame.to_isometry(),
            rms_m: self.optional("rms_um")?.unwrap_or(0.0) * 1e-6,
            samples: self.optional("samples")?.unwrap_or(0.0).max(0.0) as usize,
            sigma_m: sigma("sigma_um", 1e-6)?,
            sigma_rad: sigma("sigma_deg", 1f64.to_radians())?,
        })
    }

    fn point(&self) -> Result<GapPoint> {
        let (axis, kind) = self.axis()?;
        let (unit, si) = (kind.unit(), kind.si());
        let per_cycle = format!("per_cycle_{unit}");
        Ok(GapPoint {
            axis,
            at: self.number(&format!("at_{unit}"))? * si,
            half_gap: self.number(&format!("half_gap_{unit}"))? * si,
            ci95: self.array::<2>("ci95")?.map(|v| v * si),
            cycles: self.optional("cycles")?.unwrap_or(0.0).max(0.0) as usize,
            per_cycle: match self.child(&per_cycle) {
                Some(_) => self.numbers(&per_cycle)?.iter().map(|v| v * si).collect(),
                None => Vec::new(),
            },
        })
    }

    fn joint(&self) -> Result<JointGap> {
        let (axis, kind) = self.axis()?;
        let (unit, si) = (kind.unit(), kind.si());
        let half_gap = self.number(&format!("half_gap_{unit}"))? * si;
        let ci95 = if self.child("ci95").is_some() { self.array::<2>("ci95")?.map(|v| v * si) } else { [half_gap; 2] };
        Ok(JointGap {
            axis,
            half_gap,
            ci95,
            significant: match self.value.get("significant") {
                Some(Value::Bool(b)) => *b,
                None | Some(Value::Null) => ci95[0] > 0.0 || ci95[1] < 0.0,
                Some(v) => return Err(self.bad("significant", format!("`{v}`"), "true or false")),
            },
            schedule: self.child("schedule").map(|s| s.curve(kind)).transpose()?,
            varies_p_value: self.optional("varies_p_value")?,
            stiction: self.child("stiction").map(|s| s.stiction(kind)).transpose()?,
            stiction_p_value: self.optional("stiction_p_value")?,
        })
    }

    fn curve(&self, kind: JointKind) -> Result<GapCurve> {
        let (unit, si) = (kind.unit(), kind.si());
        match self.text("kind")?.as_str() {
            "constant" => Ok(GapCurve::Constant(self.number(&format!("half_gap_{unit}"))? * si)),
            "pchip" => {
                let expected = "two or more pairs `[position, half gap]` with rising positions";
                let shown = || self.value.get("knots").map_or("no `knots`".into(), |v| format!("`{v}`"));
                let knots: Option<Vec<[f64; 2]>> =
                    self.value.get("knots").and_then(|v| serde_json::from_value(v.clone()).ok());
                knots
                    .map(|k| k.iter().map(|p| p.map(|v| v * si)).collect::<Vec<_>>())
                    .and_then(|k| Pchip::new(&k))
                    .map(GapCurve::Pchip)
                    .ok_or_else(|| self.bad("knots", shown(), expected))
            }
            "polynomial" => {
                let coefficients = self.numbers("coefficients")?;
                if coefficients.is_empty() {
                    return Err(self.bad("coefficients", "an empty list".into(), "one coefficient or more"));
                }
                let key = format!("range_{unit}");
                let range = if self.child(&key).is_some() {
                    self.array::<2>(&key)?.map(|v| v * si)
                } else {
                    [f64::MIN, f64::MAX]
                };
                if range[0] >= range[1] {
                    return Err(self.bad(&key, format!("[{}, {}]", range[0] / si, range[1] / si), "[lower, upper]"));
                }
                let coefficients = coefficients.iter().enumerate().map(|(k, c)| c * si.powi(1 - k as i32)).collect();
                Ok(GapCurve::Polynomial { coefficients, range })
            }
            other => Err(self.bad("kind", format!("kind `{other}`"), "`pchip`, `polynomial` or `constant`")),
        }
    }

    fn stiction(&self, kind: JointKind) -> Result<StictionFound> {
        let (unit, si) = (kind.unit(), kind.si());
        let spike = self.number(&format!("spike_{unit}"))? * si;
        let travel = format!("decay_{unit}");
        let (decay, scale) = match (self.optional("decay_s")?, self.optional(&travel)?) {
            (Some(s), None) if s > 0.0 => (Decay::Time(s), 1.0),
            (None, Some(x)) if x > 0.0 => (Decay::Travel(x * si), si),
            _ => {
                return Err(self.bad(
                    "decay_s",
                    "no decay above 0, or two".into(),
                    &format!("`decay_s` or `{travel}`"),
                ));
            }
        };
        let value = match decay {
            Decay::Time(v) | Decay::Travel(v) => v,
        };
        let interval = |key: &str, scale: f64, value: f64| -> Result<[f64; 2]> {
            if self.child(key).is_some() { Ok(self.array::<2>(key)?.map(|v| v * scale)) } else { Ok([value; 2]) }
        };
        Ok(StictionFound {
            spike,
            ci95: interval("ci95", si, spike)?,
            decay,
            decay_ci95: interval("decay_ci95", scale, value)?,
        })
    }
}
