//! The JSON Schemas of the channels' messages.

use cocarry::quantities::{Heading, QuantityKind};
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
        QuantityKind::Number(_) => json!({ "type": "number" }),
        QuantityKind::Count => json!({ "type": "integer" }),
        QuantityKind::Text => json!({ "type": "string" }),
        QuantityKind::Flag => json!({ "type": "boolean" }),
        QuantityKind::Numbers => json!({ "type": "array", "items": { "type": "number" } }),
        QuantityKind::Record(record) => schema(record()),
        QuantityKind::List(record) => json!({ "type": "array", "items": schema(record()) }),
    };
    schema["description"] = match heading.kind {
        QuantityKind::Number(unit) if !unit.is_empty() => format!("{} [{unit}]", heading.description).into(),
        _ => heading.description.into(),
    };
    schema
}
