//! An effect as a list of named numbers, in file units, and how it is written in a truth and in a model file.

use serde_json::{Map, Value, json};

#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    pub name: String,
    /// Joint, `A2.a`, `A6<-A5`, `tool`, `tcp` or `log`.
    pub target: String,
    pub values: Vec<(String, f64)>,
    /// Of `backlash_position`: position and half gap, deg or mm; of `hysteresis`, where it has elements: presliding and half width.
    pub knots: Vec<[f64; 2]>,
    /// Of `vibration`.
    pub direction: Option<[f64; 3]>,
}

/// Parameters that are a size: multiplying them multiplies the effect.
const SIZES: [&str; 16] = [
    "lag_s",
    "spike_deg",
    "spike_mm",
    "scale_ppm",
    "amplitude_deg",
    "amplitude_mm",
    "amplitude_um",
    "half_gap_deg",
    "half_gap_mm",
    "half_width_deg",
    "half_width_mm",
    "offset_deg",
    "offset_mm",
    "ratio",
    "offset_s",
    "x_mm",
];
const MORE_SIZES: [&str; 16] = [
    "gradient_k_per_m",
    "x_um",
    "y_um",
    "z_um",
    "x_rad_per_nm",
    "y_rad_per_nm",
    "per_hour_mm",
    "per_hour_deg",
    "y_mm",
    "z_mm",
    "delta_mm",
    "delta_deg",
    "slope_deg_per_mm_s",
    "slope_mm_per_mm_s",
    "compliance_deg_per_nm",
    "compliance_mm_per_n",
];

pub fn is_size(key: &str) -> bool {
    SIZES.contains(&key) || MORE_SIZES.contains(&key)
}

impl Effect {
    pub fn new(name: &str, target: &str, values: &[(&str, f64)]) -> Effect {
        Effect {
            name: name.into(),
            target: target.into(),
            values: values.iter().map(|&(k, v)| (k.to_string(), v)).collect(),
            knots: Vec::new(),
            direction: None,
        }
    }

    /// A value by its whole key, 0 where it is not given.
    pub fn get(&self, key: &str) -> f64 {
        self.values.iter().find(|(k, _)| k == key).map_or(0.0, |(_, v)| *v)
    }

    /// A value by the key without its unit (`half_gap` for `half_gap_deg` or `half_gap_mm`).
    pub fn of(&self, stem: &str) -> f64 {
        ["_deg", "_mm"].iter().map(|x| self.get(&format!("{stem}{x}"))).find(|v| *v != 0.0).unwrap_or(0.0)
    }

    /// A hysteresis of several elements.
    pub fn has_elements(&self) -> bool {
        self.name == "hysteresis" && !self.knots.is_empty()
    }

    /// The same effect, so many times as large.
    pub fn scaled(&self, factor: f64) -> Effect {
        let mut e = self.clone();
        for (k, v) in &mut e.values {
            // how a gear is driven is no size of its play
            if is_size(k) && !(k == "ratio" && self.name == "coupled_play") {
                *v *= factor;
            }
        }
        for knot in &mut e.knots {
            knot[1] *= factor;
        }
        e
    }

    /// Numbers cut to six significant digits, as the files print them.
    pub fn printed(&self) -> Effect {
        let cut = |v: f64| format!("{v:.5e}").parse().unwrap_or(v);
        let mut e = self.clone();
        for (_, v) in &mut e.values {
            *v = cut(*v);
        }
        for knot in &mut e.knots {
            *knot = knot.map(cut);
        }
        e
    }

    /// As in `truth.json`.
    pub fn json(&self) -> Map<String, Value> {
        let mut m = Map::new();
        m.insert("effect".into(), json!(self.name));
        m.insert("target".into(), json!(self.target));
        if let Some((_, from)) = self.target.split_once("<-") {
            m.insert("from".into(), json!(from));
        }
        for (k, v) in &self.values {
            m.insert(k.clone(), json!(v));
        }
        if self.has_elements() {
            let elements: Vec<[f64; 2]> = self.knots.iter().map(|[presliding, half]| [*half, *presliding]).collect();
            m.insert("elements".into(), json!(elements));
        } else if !self.knots.is_empty() {
            m.insert("knots".into(), json!(self.knots));
        }
        if let Some(d) = self.direction {
            m.insert("direction".into(), json!(d));
        }
        m
    }

    /// Reads an effect of a `truth.json`, of a diagnosis, or of a model file turned into JSON.
    pub fn parse(v: &Value) -> Effect {
        let text = |key: &str| v.get(key).and_then(Value::as_str).map(String::from);
        let name = text("effect").unwrap_or_default();
        let target = text("target").or_else(|| text("joint")).unwrap_or_else(|| match name.as_str() {
            "tool_error" => "tool".into(),
            "time_offset" | "tracker_scale" | "tracker_frame" | "tracker_refraction" => "log".into(),
            "base_tilt" => "base".into(),
            _ => "tcp".into(),
        });
        let skip = ["mdb_multiple", "mdb_conditional"];
        let values = v.as_object().map(|o| {
            o.iter()
                .filter(|(k, _)| !skip.contains(&k.as_str()))
                .filter_map(|(k, v)| Some((k.clone(), v.as_f64()?)))
                .collect()
        });
        let pair = |k: &Value| Some([k.get(0)?.as_f64()?, k.get(1)?.as_f64()?]);
        let knots = v.get("knots").and_then(Value::as_array).map(|a| a.iter().filter_map(pair).collect());
        let turned = |k: &Value| pair(k).map(|[half, presliding]| [presliding, half]);
        let elements = v.get("elements").and_then(Value::as_array).map(|a| a.iter().filter_map(turned).collect());
        let direction =
            v.get("direction").and_then(|d| Some([d.get(0)?.as_f64()?, d.get(1)?.as_f64()?, d.get(2)?.as_f64()?]));
        Effect {
            name,
            target,
            values: values.unwrap_or_default(),
            knots: knots.or(elements).unwrap_or_default(),
            direction,
        }
    }

    /// One line of a model file's `effects`.
    pub fn yaml(&self) -> String {
        let mut s = format!("{{effect: {}", self.name);
        match self.target.as_str() {
            "tool" | "tcp" | "log" | "base" => {}
            t if t.contains("<-") || t.contains('.') => s += &format!(", target: \"{t}\""),
            t => s += &format!(", joint: \"{t}\""),
        }
        for (k, v) in &self.values {
            s += &format!(", {k}: {v}");
        }
        s + "}"
    }
}
