//! An entry of a document whose key carries a unit that is known only at run time: `half_gap_deg` or `half_gap_mm`.

use serde::ser::{Serialize, SerializeMap, Serializer};

/// One entry `name_unit: value`; a field of this type is marked `#[serde(flatten)]` in its document.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyed<T> {
    key: String,
    value: T,
}

impl<T> Keyed<T> {
    /// The entry `name_unit: value`; the value is in that unit already.
    pub fn new(name: &str, unit: &str, value: T) -> Self {
        Self { key: format!("{name}_{unit}"), value }
    }
}

impl<T: Serialize> Serialize for Keyed<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1))?;
        map.serialize_entry(&self.key, &self.value)?;
        map.end()
    }
}

/// Its key depends on the joint, so the schema of a document that has one holds any further entry.
impl<T> schemars::JsonSchema for Keyed<T> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Keyed".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({"type": "object", "additionalProperties": true})
    }

    fn inline_schema() -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_stands_in_the_key_and_the_order_of_the_fields_is_kept() {
        #[derive(serde::Serialize)]
        struct Entry {
            joint: &'static str,
            #[serde(flatten)]
            gap: Keyed<f64>,
            cycles: u32,
        }
        let entry = Entry { joint: "A1", gap: Keyed::new("half_gap", "deg", 0.25), cycles: 4 };
        assert_eq!(serde_json::to_string(&entry).unwrap(), r#"{"joint":"A1","half_gap_deg":0.25,"cycles":4}"#);
    }
}
