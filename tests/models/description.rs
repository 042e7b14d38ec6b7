//! The description as its readers see it: with what its operations share written out at each of them.

use serde_json::Value;

/// The description with every reference replaced, except those to schemas.
#[must_use]
pub(crate) fn in_full(document: &Value) -> Value {
    let mut whole = document.clone();
    for part in ["paths", "webhooks"] {
        whole[part] = written_out(&document[part], document);
    }
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
