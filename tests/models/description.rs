//! The description as its readers see it: with what its operations and schemas share written out at each of them.

use serde_json::{Value, json};

/// The description with every reference replaced, except those to schemas, and with the members of its parts in every
/// schema.
#[must_use]
pub(crate) fn in_full(document: &Value) -> Value {
    let mut whole = document.clone();
    for part in ["paths", "webhooks"] {
        whole[part] = written_out(&document[part], document);
    }
    if let Some(schemas) = whole["components"]["schemas"].as_object_mut() {
        schemas.values_mut().for_each(|schema| *schema = with_parts(schema, document));
    }
    whole
}

/// A schema with the members of its parts.
fn with_parts(schema: &Value, document: &Value) -> Value {
    let mut whole = schema.clone();
    let Some(parts) = whole.as_object_mut().and_then(|members| members.remove("allOf")) else { return whole };
    if let Some(open) = whole.as_object_mut().and_then(|members| members.remove("unevaluatedProperties")) {
        whole["additionalProperties"] = open;
    }
    let mut required: Vec<Value> = schema["required"].as_array().cloned().unwrap_or_default();
    for part in parts.as_array().into_iter().flatten() {
        let named = part["$ref"].as_str().and_then(|path| document.pointer(path.trim_start_matches('#')));
        let part = with_parts(named.unwrap_or(part), document);
        for (member, schema) in part["properties"].as_object().into_iter().flatten() {
            whole["properties"][member] = schema.clone();
        }
        required.extend(part["required"].as_array().cloned().unwrap_or_default());
    }
    whole["required"] = json!(required);
    whole
}

fn written_out(value: &Value, document: &Value) -> Value {
    if let Some(reference) = value["$ref"].as_str().filter(|path| !path.starts_with("#/components/schemas/"))
    {
        let shared = document.pointer(reference.trim_start_matches('#'));
        return written_out(shared.unwrap(), document);
    }
    match value {
        Value::Object(members) => {
            members.iter().map(|(name, member)| (name.clone(), written_out(member, document))).collect()
        }
        Value::Array(items) => items.iter().map(|item| written_out(item, document)).collect(),
        other => other.clone(),
    }
}
