//! Members that several schemas have alike are described once.
//!
//! A member that says the same as the schema it refers to says nothing. A number, a text or a list that several
//! schemas have under one name, with one description, is a schema of its own with that name.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};

use super::parts;
use super::schemas::{SCHEMAS, pascal, reference, resolved};

/// A member that fewer schemas have is not worth a schema of its own.
const LEAST_USES: usize = 3;
/// A schema of its own has to save more than this \[bytes\].
const LEAST_SAVED: usize = 100;

/// Corrects the members of all schemas.
pub(super) fn share(document: &mut Value) {
    let Some(Value::Object(schemas)) = document.pointer_mut("/components/schemas") else { return };
    let described: BTreeMap<String, Value> = schemas
        .iter()
        .filter_map(|(name, schema)| Some((format!("{SCHEMAS}{name}"), schema.get("description")?.clone())))
        .collect();
    schemas.values_mut().for_each(|schema| say_once(schema, &described));
    parts::compose(schemas);
    let found = repeated(schemas);
    for properties in schemas.values_mut().filter_map(properties_mut) {
        for (member, schema) in properties {
            if found.get(&pascal(member)).is_some_and(|shared| shared == schema) {
                *schema = reference(&pascal(member));
            }
        }
    }
    let whole = found.into_iter().map(|(name, schema)| (name, in_full(schema, schemas))).collect::<Vec<_>>();
    schemas.extend(whole);
}

fn properties_mut(schema: &mut Value) -> Option<&mut Map<String, Value>> {
    schema.get_mut("properties").and_then(Value::as_object_mut)
}

/// Leaves out the words beside a reference that its schema has too.
fn say_once(value: &mut Value, described: &BTreeMap<String, Value>) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| say_once(item, described)),
        Value::Object(members) => {
            let words = members.get("$ref").and_then(Value::as_str).and_then(|path| described.get(path));
            if words.is_some() && words == members.get("description") {
                members.remove("description");
            }
            members.values_mut().for_each(|member| say_once(member, described));
        }
        _ => {}
    }
}

/// Members that are worth a schema of their own, by its name.
fn repeated(schemas: &Map<String, Value>) -> BTreeMap<String, Value> {
    let mut uses: BTreeMap<(String, String), (usize, &Value)> = BTreeMap::new();
    for properties in schemas.values().filter_map(|schema| schema.get("properties")?.as_object()) {
        for (member, schema) in properties.iter().filter(|(_, schema)| may_be_shared(schema, schemas)) {
            uses.entry((member.clone(), schema.to_string())).or_insert((0, schema)).0 += 1;
        }
    }
    // Of two forms of one name, the one that saves most has it.
    let mut order: Vec<_> = uses
        .iter()
        .map(|((member, text), (count, schema))| {
            let cost = reference(&pascal(member)).to_string().len();
            let saved = (count * text.len()).saturating_sub(count * cost + text.len() + member.len());
            (saved, *count, member, *schema)
        })
        .filter(|(saved, count, ..)| *saved > LEAST_SAVED && *count >= LEAST_USES)
        .collect();
    order.sort_by_key(|(saved, _, member, _)| (std::cmp::Reverse(*saved), *member));
    let mut taken: BTreeSet<String> = schemas.keys().cloned().collect();
    let mut found = BTreeMap::new();
    for (.., member, schema) in order {
        if taken.insert(pascal(member)) {
            found.insert(pascal(member), schema.clone());
        }
    }
    found
}

/// Whether a member may refer to a schema of its own: a described number, text or list. Objects, lists of words and
/// what is null at times have their names already, and pages in a browser fill a form's field in with its own example.
fn may_be_shared(schema: &Value, schemas: &Map<String, Value>) -> bool {
    let kinds = resolved(schema, schemas).get("type").map(Value::to_string).unwrap_or_default();
    let is_list = kinds.contains("\"array\"");
    let is_plain = ["number", "integer", "string", "boolean"].iter().any(|kind| kinds.contains(kind));
    let has = |key: &str| schema.get(key).is_some();
    let own = is_list || (is_plain && !has("$ref"));
    own && has("description")
        && !has("enum")
        && !has("example")
        && schema.get("format") != Some(&json!("binary"))
}

/// The schema with the list that it refers to.
fn in_full(schema: Value, schemas: &Map<String, Value>) -> Value {
    let mut whole = resolved(&schema, schemas).clone();
    if let (Value::Object(whole), Value::Object(own)) = (&mut whole, schema) {
        whole.extend(own.into_iter().filter(|(key, _)| key != "$ref"));
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_member_of_several_schemas_is_described_once() {
        let words = "The length of the tool. ".repeat(4);
        let length = json!({ "type": "number", "description": words });
        let offset = json!({ "$ref": format!("{SCHEMAS}Vector"), "description": words });
        let start = json!({ "$ref": format!("{SCHEMAS}Start"), "description": "Where the axes are." });
        let whole = json!({ "properties": {"length_mm": length, "offset_mm": offset, "start": start} });
        let other = json!({ "properties": {"length_mm": {"type": "number", "description": "Of the edge."}} });
        let vector = json!({ "type": "array", "items": {"type": "number"} });
        let mut document = json!({ "components": {"schemas": {
            "A": whole, "B": whole, "C": whole, "D": other, "Vector": vector,
            "Start": {"type": "object", "description": "Where the axes are."}
        }} });
        share(&mut document);
        let schemas = &document["components"]["schemas"];
        for name in ["A", "B", "C"] {
            let expected = json!({
                "length_mm": reference("LengthMm"), "offset_mm": reference("OffsetMm"), "start": reference("Start")
            });
            assert_eq!(schemas[name]["properties"], expected);
        }
        assert_eq!(schemas["LengthMm"], length);
        assert_eq!(
            schemas["OffsetMm"],
            json!({ "type": "array", "items": {"type": "number"}, "description": words })
        );
        assert_eq!(schemas["D"], other);
    }

    #[test]
    fn a_short_member_and_one_that_a_form_fills_in_stay_where_they_are() {
        let words = "A name that is long enough to be worth it. ".repeat(4);
        let filled = json!({ "type": "string", "description": words, "example": "" });
        let whole = json!({ "properties": {"main": filled, "count": {"type": "integer", "description": "How many."}} });
        let before = json!({ "components": {"schemas": {"A": whole, "B": whole, "C": whole}} });
        let mut document = before.clone();
        share(&mut document);
        assert_eq!(document, before);
    }
}
