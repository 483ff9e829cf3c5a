//! The few words of JSON Schema that a hand-written schema uses, as a type; keys that are not set are not written.

use indexmap::IndexMap;
use serde::Serialize;
use serde_json::Value;

/// A schema, or a part of one; empty, it holds anything.
#[derive(Debug, Clone, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Shape {
    #[serde(skip_serializing_if = "Option::is_none")]
    description: Option<String>,
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    kind: Option<&'static str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    required: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    additional_properties: Option<Further>,
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    properties: IndexMap<String, Shape>,
    #[serde(skip_serializing_if = "Option::is_none")]
    items: Option<Box<Shape>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    min_items: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_items: Option<usize>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    any_of: Vec<Shape>,
    #[serde(rename = "enum", skip_serializing_if = "Vec::is_empty")]
    one_of: Vec<Value>,
    #[serde(rename = "const", skip_serializing_if = "Option::is_none")]
    constant: Option<String>,
}

/// Keys of an object beside those that are named.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
enum Further {
    Allowed(bool),
    Are(Box<Shape>),
}

impl Shape {
    pub(super) fn typed(kind: &'static str) -> Self {
        Self { kind: Some(kind), ..Self::default() }
    }

    pub(super) fn any_object() -> Self {
        Self::typed("object")
    }

    pub(super) fn constant(text: &str) -> Self {
        Self { constant: Some(text.into()), ..Self::default() }
    }

    /// An object with any keys, each of this shape.
    pub(super) fn map_of(each: Self) -> Self {
        Self { additional_properties: Some(Further::Are(Box::new(each))), ..Self::any_object() }
    }

    pub(super) fn described(mut self, text: impl Into<String>) -> Self {
        self.description = Some(text.into());
        self
    }

    pub(super) fn requires(mut self, keys: &[&'static str]) -> Self {
        self.required = keys.to_vec();
        self
    }

    /// A list of exactly this many.
    pub(super) fn of_length(mut self, length: usize) -> Self {
        (self.min_items, self.max_items) = (Some(length), Some(length));
        self
    }

    pub(super) fn value(&self) -> Value {
        serde_json::to_value(self).unwrap_or_default()
    }
}

pub(super) fn text() -> Shape {
    Shape::typed("string")
}

pub(super) fn number() -> Shape {
    Shape::typed("number")
}

pub(super) fn list(of: Shape) -> Shape {
    Shape { items: Some(Box::new(of)), ..Shape::typed("array") }
}

pub(super) fn one_of<T: Into<Value>>(values: impl IntoIterator<Item = T>) -> Shape {
    Shape { one_of: values.into_iter().map(Into::into).collect(), ..Shape::default() }
}

/// One of several shapes.
pub(super) fn union(of: impl IntoIterator<Item = Shape>) -> Shape {
    Shape { any_of: of.into_iter().collect(), ..Shape::default() }
}

/// An object that may have further keys.
pub(super) fn open<K: Into<String>>(keys: impl IntoIterator<Item = (K, Shape)>) -> Shape {
    Shape { properties: keys.into_iter().map(|(k, s)| (k.into(), s)).collect(), ..Shape::any_object() }
}

/// An object that refuses further keys.
pub(super) fn object<K: Into<String>>(keys: impl IntoIterator<Item = (K, Shape)>) -> Shape {
    Shape { additional_properties: Some(Further::Allowed(false)), ..open(keys) }
}
