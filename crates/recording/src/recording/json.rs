//! Records of quantities as JSON, and their JSON Schema.

use cocarry::quantities::{Heading, Kind, Record, Value as Quantity};
use serde_json::{Map, Value, json};

/// A record without what is missing.
pub(super) fn object(record: &Record) -> Value {
    let there = record.iter().filter(|(_, value)| !value.is_missing());
    there.map(|(key, value)| (key.to_owned(), json_of(value))).collect()
}

fn json_of(value: &Quantity) -> Value {
    match value {
        Quantity::Record(record) => object(record),
        Quantity::List(records) => records.iter().map(object).collect(),
        value => json!(value),
    }
}

/// The JSON Schema of a record with these headings. No property is required: missing values are left out.
pub(super) fn schema(headings: impl IntoIterator<Item = Heading>) -> Value {
    let properties: Map<String, Value> =
        headings.into_iter().map(|heading| (heading.key.to_owned(), property(&heading))).collect();
    json!({ "type": "object", "properties": properties })
}

/// One plain type, since Foxglove reads no others.
fn property(heading: &Heading) -> Value {
    let mut property = match heading.kind {
        Kind::Number(_) => json!({ "type": "number" }),
        Kind::Count => json!({ "type": "integer" }),
        Kind::Text => json!({ "type": "string" }),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Numbers => json!({ "type": "array", "items": { "type": "number" } }),
        Kind::Record(headings) => schema(headings()),
        Kind::List(headings) => json!({ "type": "array", "items": schema(headings()) }),
    };
    property["description"] = match heading.kind.unit() {
        "" => heading.description.into(),
        unit => format!("{} [{unit}]", heading.description).into(),
    };
    property
}
