//! The keys of one entry of a model file, taken one by one; what is left over at the end is unknown.

use super::{Site, Target};
use crate::error::{Error, Result};
use crate::io::{names, yaml::Document};
use crate::robot::Robot;
use nalgebra::Vector3;
use serde_yaml::{Mapping, Value};

/// The keys of one entry, with the place where it stands for messages.
pub struct Fields<'a> {
    pub(super) map: Mapping,
    pub(super) doc: &'a Document<'a>,
    pub(super) robot: &'a Robot,
    pub(super) effect: String,
    /// The target as it is written; empty where there is none.
    pub(super) named: String,
    pub(super) target: Target,
}

impl<'a> Fields<'a> {
    /// The target and its units.
    pub fn site(&self) -> Site<'a> {
        Site { robot: self.robot, target: self.target }
    }

    /// The target as it is written.
    pub fn named(&self) -> &str {
        &self.named
    }

    /// A refusal: what was found at `key`, what was expected.
    pub fn bad(&self, key: &str, found: impl Into<String>, expected: &str) -> Error {
        let mut needles: Vec<&str> = vec![&self.effect];
        needles.extend([self.named.as_str(), key].iter().filter(|n| !n.is_empty()));
        let of = if self.named.is_empty() { self.effect.clone() } else { format!("{} of {}", self.effect, self.named) };
        Error::bad(self.doc.place(&needles), format!("{} in {of}", found.into()), expected)
    }

    /// The key is there.
    pub fn has(&self, key: &str) -> bool {
        self.map.contains_key(key)
    }

    /// The value of a key as it stands.
    pub fn take(&mut self, key: &str) -> Option<Value> {
        self.map.remove(key)
    }

    /// A finite number of `least` or more; `-inf`: any.
    pub fn number(&mut self, key: &str, least: f64) -> Result<Option<f64>> {
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

    /// A finite number of `least` or more that must be there.
    pub fn needed(&mut self, key: &str, least: f64) -> Result<f64> {
        match self.number(key, least)? {
            Some(x) => Ok(x),
            None => {
                let there = self.map.keys().filter_map(Value::as_str).find(|k| names::almost(k, key));
                let found = there.map_or(format!("no `{key}`"), |there| format!("`{there}` and no `{key}`"));
                Err(self.bad(key, found, &format!("`{key}`")))
            }
        }
    }

    /// A finite number of either sign.
    pub fn any(&mut self, key: &str) -> Result<f64> {
        self.needed(key, f64::NEG_INFINITY)
    }

    /// A finite number above 0.
    pub fn above_0(&mut self, key: &str) -> Result<f64> {
        self.needed(key, f64::MIN_POSITIVE)
    }

    /// A number in the joint's unit (`name_deg`, `name_mm`), as SI.
    pub fn length(&mut self, name: &str, least: f64) -> Result<f64> {
        let site = self.site();
        Ok(self.needed(&site.key(name), least)? * site.si_per_user_unit())
    }

    /// Degrees, 0 where the key is not there; as rad.
    pub fn phase_rad(&mut self) -> Result<f64> {
        Ok(self.number("phase_deg", f64::NEG_INFINITY)?.unwrap_or(0.0).to_radians())
    }

    /// Pairs of numbers.
    pub fn pairs(&mut self, key: &str, what: &str) -> Result<Vec<[f64; 2]>> {
        let Some(v) = self.take(key) else {
            return Err(self.bad(key, format!("no `{key}`"), &format!("`{key}: [[{what}], ...]`")));
        };
        serde_yaml::from_value(v.clone())
            .map_err(|_| self.bad(key, format!("{key}: {}", shown(&v)), &format!("pairs `[{what}]`")))
    }

    /// `x_mm, y_mm, z_mm` in m; one that is not there is 0, but not all three.
    pub fn xyz_m(&mut self) -> Result<Vector3<f64>> {
        let mut found = false;
        let mut v = Vector3::zeros();
        for (c, key) in v.iter_mut().zip(["x_mm", "y_mm", "z_mm"]) {
            if let Some(x) = self.number(key, f64::NEG_INFINITY)? {
                *c = x * 1e-3;
                found = true;
            }
        }
        if found { Ok(v) } else { Err(self.bad("", "no `x_mm`, `y_mm`, `z_mm`", "at least one of them")) }
    }

    /// A unit vector from `direction: [x, y, z]`.
    pub fn direction(&mut self) -> Result<Vector3<f64>> {
        let v = self.take("direction");
        let xyz: Option<[f64; 3]> = v.clone().and_then(|v| serde_yaml::from_value(v).ok());
        match xyz.map(Vector3::from) {
            Some(d) if d.iter().all(|x| x.is_finite()) && d.norm() > 0.0 && d.norm().is_finite() => Ok(d.normalize()),
            _ => {
                let found = v.map_or("no `direction`".into(), |v| format!("direction: {}", one_line(&v)));
                Err(self.bad("direction", found, "`direction: [x, y, z]` of a length above 0"))
            }
        }
    }

    pub(super) fn finish(self) -> Result<()> {
        match self.map.iter().next() {
            None => Ok(()),
            Some((k, _)) => {
                let key = shown(k);
                Err(self.bad(&key, format!("unknown key `{key}`"), "only the keys of this effect"))
            }
        }
    }
}

pub(super) fn shown(v: &Value) -> String {
    serde_yaml::to_string(v).map_or_else(|_| "?".into(), |s| s.trim().to_string())
}

pub(super) fn one_line(v: &Value) -> String {
    shown(v).replace('\n', " ")
}
