//! The JSON Schemas of the channels' messages.

use cocarry::quantities::{Heading, Kind};
use serde_json::{Map, Value, json};

/// The JSON Schema of a record with these headings. No property is required: missing values are left out.
pub(super) fn schema(headings: impl IntoIterator<Item = Heading>) -> Value {
    let property = |heading: Heading| (heading.name.to_owned(), of_value(&heading));
    let properties: Map<String, Value> = headings.into_iter().map(property).collect();
    json!({ "type": "object", "properties": properties })
}

/// The JSON Schema of a value: one plain type, since Foxglove reads no others.
fn of_value(heading: &Heading) -> Value {
    let mut schema = match heading.kind {
        Kind::Number(_) => json!({ "type": "number" }),
        Kind::Count => json!({ "type": "integer" }),
        Kind::Text => json!({ "type": "string" }),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Numbers => json!({ "type": "array", "items": { "type": "number" } }),
        Kind::Record(record) => schema(record()),
        Kind::List(record) => json!({ "type": "array", "items": schema(record()) }),
    };
    schema["description"] = match heading.kind {
        Kind::Number(unit) if !unit.is_empty() => format!("{} [{unit}]", heading.description).into(),
        _ => heading.description.into(),
    };
    schema
}
