//! Schemas in the form that strict readers and client generators need: one name for each thing, no part that forbids
//! what another part adds, alternatives that one member distinguishes, no unused schemas.

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

/// The path of the schemas in the document.
pub(super) const SCHEMAS: &str = "#/components/schemas/";

/// Every operation of a job and the schema of its parameters.
const JOBS: &[(&str, &str)] = &[
    ("cc-compensation", "CcParameters"),
    ("wear-compensation", "WearParameters"),
    ("compensation", "CompensationParameters"),
    ("verification", "VerificationParameters"),
    ("servo-simulation", "ServoProgramParameters"),
    ("posting", "PostingParameters"),
];

/// Corrects all schemas.
pub(super) fn mend(schemas: &mut Map<String, Value>) {
    name_items(schemas);
    merge_parts(schemas);
    name_alternatives(schemas);
    jobs_by_operation(schemas);
    null_once(schemas);
    for job in ["Job", "EndedJob"] {
        if let Some(problem) = member(schemas, job, "problem") {
            let choices = json!([reference("Problem"), {"type": "null"}]);
            *problem = json!({ "description": "Why it failed.", "oneOf": choices });
        }
    }
}

/// States the upper bound of an unsigned 32-bit number: readers take its format, `int32`, for half of that range.
pub(super) fn bound_unsigned(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(bound_unsigned),
        Value::Object(members) => {
            let is_of = |name: &str, wanted: Value| members.get(name) == Some(&wanted);
            if is_of("format", json!("int32"))
                && is_of("minimum", json!(0))
                && !members.contains_key("maximum")
            {
                members.insert("format".to_owned(), json!("int64"));
                members.insert("maximum".to_owned(), json!(u32::MAX));
            }
            members.values_mut().for_each(bound_unsigned);
        }
        _ => {}
    }
}

/// A reference to a schema.
pub(super) fn reference(name: &str) -> Value {
    json!({ "$ref": format!("{SCHEMAS}{name}") })
}

/// The schema that a reference names.
pub(super) fn resolved<'a>(schema: &'a Value, schemas: &'a Map<String, Value>) -> &'a Value {
    let name = schema.get("$ref").and_then(Value::as_str).and_then(|path| path.strip_prefix(SCHEMAS));
    name.and_then(|name| schemas.get(name)).unwrap_or(schema)
}

fn member<'a>(schemas: &'a mut Map<String, Value>, name: &str, property: &str) -> Option<&'a mut Value> {
    schemas.get_mut(name)?.get_mut("properties")?.get_mut(property)
}

/// Names the items of a list where they were written out again.
fn name_items(schemas: &mut Map<String, Value>) {
    let lists: Vec<String> = schemas.keys().filter(|name| name.starts_with("Listed_")).cloned().collect();
    for list in lists {
        let item = list.trim_start_matches("Listed_");
        if schemas.contains_key(item)
            && let Some(items) = member(schemas, &list, "items").and_then(|items| items.get_mut("items"))
        {
            *items = reference(item);
        }
    }
}

/// Replaces the parts of an object by one object: a part that allows no other members would forbid those of the next
/// part.
fn merge_parts(schemas: &mut Map<String, Value>) {
    let merged: Vec<(String, Value)> =
        schemas.iter().filter_map(|(name, schema)| Some((name.clone(), whole(schema, schemas)?))).collect();
    schemas.extend(merged);
}

/// The object that `allOf` makes; `None` if it is not an object.
fn whole(schema: &Value, schemas: &Map<String, Value>) -> Option<Value> {
    let (mut properties, mut required) = (Map::new(), Vec::new());
    for part in schema.get("allOf")?.as_array()? {
        // An optional part is written as "part or null".
        let optional = part.get("oneOf").and_then(Value::as_array);
        let named = optional.and_then(|all| all.iter().find(|one| one.get("$ref").is_some())).unwrap_or(part);
        let part = resolved(named, schemas);
        let part = whole(part, schemas).unwrap_or_else(|| part.clone());
        properties.extend(part.get("properties")?.as_object()?.clone());
        if optional.is_none() {
            required.extend(part.get("required").and_then(Value::as_array).into_iter().flatten().cloned());
        }
    }
    let description = schema.get("description").cloned().unwrap_or_default();
    let mut whole = json!({ "type": "object", "description": description, "properties": properties });
    if !required.is_empty() {
        whole["required"] = Value::Array(required);
    }
    Some(whole)
}

/// Gives names to alternatives that are written out and that a member distinguishes.
fn name_alternatives(schemas: &mut Map<String, Value>) {
    let mut named = Map::new();
    for (name, schema) in schemas.iter_mut() {
        let Some(parts) = schema.get_mut("oneOf").and_then(Value::as_array_mut) else { continue };
        let Some(tag) = common_tag(parts) else { continue };
        for part in parts {
            let Some(word) = only_word(part, &tag).map(str::to_owned) else { continue };
            let part_name = format!("{}{}", name.trim_end_matches("Doc"), pascal(&word));
            named.insert(part_name.clone(), std::mem::replace(part, reference(&part_name)));
        }
    }
    schemas.extend(named);
}

/// The member that has one fixed word in each of the alternatives.
pub(super) fn common_tag(parts: &[Value]) -> Option<String> {
    let first = parts.first()?.get("properties")?.as_object()?;
    first.keys().find(|name| parts.iter().all(|part| only_word(part, name).is_some())).cloned()
}

pub(super) fn only_word<'a>(part: &'a Value, member: &str) -> Option<&'a str> {
    match part.get("properties")?.get(member)?.get("enum")?.as_array()?.as_slice() {
        [word] => word.as_str(),
        _ => None,
    }
}

/// `cc-compensation` as `CcCompensation`.
pub(super) fn pascal(word: &str) -> String {
    let parts = word.split(|letter: char| !letter.is_ascii_alphanumeric()).filter_map(|part| {
        let mut letters = part.chars();
        letters.next().map(|first| first.to_ascii_uppercase().to_string() + letters.as_str())
    });
    parts.collect()
}

/// "Value or null" becomes the value if the value may already be null: `oneOf` requires that exactly one choice fits.
fn null_once(schemas: &mut Map<String, Value>) {
    let takes_null: BTreeSet<String> = schemas
        .iter()
        .filter(|(_, schema)| fits_null(schema))
        .map(|(name, _)| format!("{SCHEMAS}{name}"))
        .collect();
    let properties = schemas.values_mut().filter_map(|schema| schema.get_mut("properties")?.as_object_mut());
    for property in properties.flat_map(|properties| properties.values_mut()) {
        let one = property.get("oneOf").and_then(Value::as_array).and_then(|choices| {
            choices.iter().find(|one| {
                one.get("$ref").and_then(Value::as_str).is_some_and(|name| takes_null.contains(name))
            })
        });
        if let Some(one) = one.cloned() {
            *property = one;
        }
    }
}

/// Whether a schema itself allows null.
fn fits_null(schema: &Value) -> bool {
    match schema.get("type") {
        Some(Value::String(kind)) => kind == "null",
        Some(Value::Array(kinds)) => kinds.iter().any(|kind| kind == "null"),
        _ => {
            schema.get("oneOf").and_then(Value::as_array).is_some_and(|choices| choices.iter().any(fits_null))
        }
    }
}

/// A job request has the parameters of its operation.
fn jobs_by_operation(schemas: &mut Map<String, Value>) {
    let Some(base) = schemas.get("JobRequest").cloned() else { return };
    let mut choices = Vec::new();
    for (operation, parameters) in JOBS {
        let name = format!("{}Job", pascal(operation));
        let mut request = base.clone();
        if let Some(properties) = request.get_mut("properties").and_then(Value::as_object_mut) {
            properties.insert(
                "operation".to_owned(),
                json!({ "type": "string", "enum": [operation], "description": "The operation to compute." }),
            );
            let mut fitting = reference(parameters);
            if let Some(fitting) = fitting.as_object_mut() {
                fitting.insert(
                    "description".to_owned(),
                    json!("Parameters, the same as at the operation's own endpoint."),
                );
            }
            properties.insert("parameters".to_owned(), fitting);
        }
        choices.push(reference(&name));
        schemas.insert(name, request);
    }
    let description = base.get("description").cloned().unwrap_or_default();
    let request = json!({ "description": description, "oneOf": choices });
    schemas.insert("JobRequest".to_owned(), request);
}

/// Removes schemas that the rest of the document does not refer to.
pub(super) fn prune(rest: &Value, schemas: &mut Map<String, Value>) {
    let used = reachable(rest, schemas);
    schemas.retain(|name, _| used.contains(name));
}

/// The names of all schemas that a part of the document refers to, also through others.
pub(super) fn reachable(part: &Value, schemas: &Map<String, Value>) -> BTreeSet<String> {
    let mut used = BTreeSet::new();
    let mut open = Vec::new();
    named_in(part, &mut open);
    while let Some(name) = open.pop() {
        if let Some(schema) = schemas.get(&name)
            && used.insert(name)
        {
            named_in(schema, &mut open);
        }
    }
    used
}

/// The names of all schemas that a value refers to.
fn named_in(value: &Value, names: &mut Vec<String>) {
    match value {
        Value::String(text) => names.extend(text.strip_prefix(SCHEMAS).map(str::to_owned)),
        Value::Array(items) => items.iter().for_each(|item| named_in(item, names)),
        Value::Object(members) => members.values().for_each(|item| named_in(item, names)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_allows_no_other_members_does_not_exclude_its_siblings() {
        let mut schemas = Map::new();
        schemas.insert(
            "Part".into(),
            json!({ "properties": {"a": {}}, "required": ["a"], "additionalProperties": false }),
        );
        let own = json!({ "properties": {"b": {}}, "required": ["b"] });
        schemas.insert("Whole".into(), json!({ "allOf": [reference("Part"), own] }));
        let perhaps = json!({ "oneOf": [reference("Part"), {"type": "null"}] });
        schemas.insert("Perhaps".into(), json!({ "allOf": [perhaps, own] }));
        mend(&mut schemas);
        for (name, required) in [("Whole", json!(["a", "b"])), ("Perhaps", json!(["b"]))] {
            assert_eq!(schemas[name]["properties"], json!({ "a": {}, "b": {} }));
            assert_eq!(schemas[name]["required"], required);
            assert_eq!(schemas[name].get("additionalProperties"), None);
        }
    }

    #[test]
    fn what_may_be_null_is_not_told_so_twice() {
        let mut schemas = Map::new();
        schemas
            .insert("Answers".into(), json!({ "oneOf": [{"type": ["number", "null"]}, {"type": "array"}] }));
        let twice = json!({ "oneOf": [reference("Answers"), {"type": "null"}] });
        let once = json!({ "oneOf": [reference("Other"), {"type": "null"}] });
        schemas.insert("Whole".into(), json!({ "properties": {"a": twice, "b": once} }));
        mend(&mut schemas);
        assert_eq!(schemas["Whole"]["properties"], json!({ "a": reference("Answers"), "b": once }));
    }

    #[test]
    fn every_operation_of_a_job_has_its_parameters() {
        let document = super::super::tests::document();
        let schemas = document["components"]["schemas"].as_object().unwrap();
        let mut words: Vec<&str> =
            schemas["JobOperation"]["enum"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        let mut told: Vec<&str> = JOBS.iter().map(|(operation, _)| *operation).collect();
        words.sort_unstable();
        told.sort_unstable();
        assert_eq!(words, told);
        for (_, parameters) in JOBS {
            assert!(schemas[*parameters].is_object(), "{parameters}");
        }
    }
}
