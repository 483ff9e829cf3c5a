//! A value of a gaps file with the way to it: text, numbers and lists by their keys, refused with file and line where they are wrong.

use crate::error::{Error, Place, Result};
use crate::io::{names, yaml::Document};
use crate::robot::{JointKind, Robot};
use serde_json::Value;

/// A value of the document and the way to it, for messages.
pub(super) struct Node<'a> {
    pub(super) doc: &'a Document<'a>,
    pub(super) robot: &'a Robot,
    pub(super) value: &'a Value,
    pub(super) path: Vec<String>,
}

impl Node<'_> {
    pub(super) fn bad(&self, key: &str, found: String, expected: &str) -> Error {
        let mut path = self.path.clone();
        path.push(key.into());
        Error::bad(self.place(key), format!("{found} at {}", path.join(".")), expected)
    }

    /// Refuses a key that is almost one of `known` (with `_UNIT` at its end: in the joint's unit): it would be passed over without a
    /// word. Other keys are fields of another version.
    pub(super) fn refuse_misspelt(&self, known: &[&str]) -> Result<()> {
        let Some(map) = self.value.as_object() else { return Ok(()) };
        let unit = self.axis().map_or("deg", |(_, kind)| kind.unit());
        let known: Vec<String> = known.iter().map(|k| k.replace("UNIT", unit)).collect();
        let meant = |key: &String| {
            let key = key.as_str();
            known.iter().find(|k| {
                !known.iter().any(|k| k == key) && names::almost(key, k) && self.value.get(k.as_str()).is_none()
            })
        };
        match map.keys().find_map(|key| Some((key, meant(key)?))) {
            None => Ok(()),
            Some((key, meant)) => Err(self.bad(key, format!("the unknown key `{key}`"), &format!("`{meant}`"))),
        }
    }

    /// Line of a key: within its item of its section.
    fn place(&self, key: &str) -> Place {
        let lines: Vec<&str> = self.doc.text.lines().collect();
        let has =
            |i: usize, key: &str| lines[i].contains(&format!("{key}:")) || lines[i].contains(&format!("{key}\":"));
        let whole = 0..lines.len();
        let item = self.path.first().and_then(|p| p.strip_suffix(']')?.split_once('['));
        let (mut from, mut to) = (whole.start, whole.end);
        if let Some((section, index)) = item
            && let Some(start) = whole.clone().find(|&i| has(i, section))
        {
            let mut items = (start..whole.end).filter(|&i| has(i, "joint"));
            from = items.nth(index.parse().unwrap_or(0)).unwrap_or(start);
            to = items.next().unwrap_or(whole.end);
        }
        let hit = (from..to).find(|&i| has(i, key)).or(item.map(|_| from));
        hit.map_or_else(|| self.doc.place(&[key]), |i| Place::line(self.doc.name, i as u64 + 1))
    }

    pub(super) fn child(&self, key: &str) -> Option<Node<'_>> {
        let value = self.value.get(key).filter(|v| !v.is_null())?;
        let mut path = self.path.clone();
        path.push(key.into());
        Some(Node { doc: self.doc, robot: self.robot, value, path })
    }

    pub(super) fn children(&self, key: &str) -> Result<Vec<Node<'_>>> {
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

    pub(super) fn text(&self, key: &str) -> Result<String> {
        match self.value.get(key) {
            Some(Value::String(s)) => Ok(s.clone()),
            Some(v) => Err(self.bad(key, format!("`{v}`"), "text")),
            None => Err(self.bad(key, format!("no `{key}`"), &format!("`{key}`"))),
        }
    }

    pub(super) fn optional(&self, key: &str) -> Result<Option<f64>> {
        match self.value.get(key) {
            None | Some(Value::Null) => Ok(None),
            Some(v) => match v.as_f64() {
                Some(x) if x.is_finite() => Ok(Some(x)),
                _ => Err(self.bad(key, format!("`{v}`"), "a finite number")),
            },
        }
    }

    pub(super) fn number(&self, key: &str) -> Result<f64> {
        self.optional(key)?.ok_or_else(|| {
            // YAML's .inf and .nan arrive as null
            let found = match (self.value.get(key), self.value.as_object()) {
                (Some(_), _) => "null, or a number that is not finite".into(),
                (None, Some(map)) if !map.is_empty() => {
                    format!(
                        "nothing (the keys there: {})",
                        map.keys().map(String::as_str).collect::<Vec<_>>().join(", ")
                    )
                }
                _ => "nothing".into(),
            };
            self.bad(key, found, &format!("`{key}`: a finite number"))
        })
    }

    pub(super) fn numbers(&self, key: &str) -> Result<Vec<f64>> {
        let Some(v) = self.value.get(key) else {
            return Err(self.bad(key, format!("no `{key}`"), "a list of numbers"));
        };
        let list: Option<Vec<f64>> =
            v.as_array().and_then(|a| a.iter().map(|x| x.as_f64().filter(|f| f.is_finite())).collect());
        list.ok_or_else(|| self.bad(key, format!("`{v}`"), "a list of finite numbers"))
    }

    pub(super) fn array<const N: usize>(&self, key: &str) -> Result<[f64; N]> {
        let list = self.numbers(key)?;
        list.as_slice()
            .try_into()
            .map_err(|_| self.bad(key, format!("{} numbers", list.len()), &format!("{N} numbers")))
    }

    /// The joint that `joint` names: axis and kind.
    pub(super) fn axis(&self) -> Result<(usize, JointKind)> {
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
}
