//! What the values of schemas mean: moments and ids have a format, alternatives a discriminator, and null is named only
//! where it means something.

use serde_json::{Map, Value, json};

use super::parameters::without_null;
use super::schemas::{common_tag, only_word, reachable, resolved};

/// Members that are a UUID. Ids of machines, tools and cutters are names, ids of keys are 12 digits.
const UUIDS: &[(&str, &str)] = &[
    ("AuditEntry", "request_id"),
    ("Calibration", "id"),
    ("CalibrationDifference", "from"),
    ("CalibrationDifference", "id"),
    ("EndedJob", "id"),
    ("Job", "id"),
    ("TrendPoint", "calibration_id"),
    ("WearEntry", "id"),
    ("WearTrendPoint", "id"),
];

/// Members that are a moment and whose names do not end in `_at`.
const MOMENTS: &[&str] = &["at", "signs_until", "timestamp"];

/// Answers that leave out a member without a value, as requests do.
const LEFT_OUT: &[&str] = &["MachineDocument", "MachineProfile", "Tool", "ToolDocument"];

/// Corrects all values.
pub(super) fn mend(document: &mut Value) {
    let mut requests = Vec::new();
    let mut answers = vec![document.get("webhooks").cloned().unwrap_or_default()];
    for operation in super::operations_mut(document) {
        requests.extend(
            ["requestBody", "parameters"].map(|part| operation.get(part).cloned().unwrap_or_default()),
        );
        answers.push(operation.get("responses").cloned().unwrap_or_default());
        formats_of_parameters(operation);
    }
    let Some(Value::Object(schemas)) = document.pointer_mut("/components/schemas") else { return };
    let answered = reachable(&Value::Array(answers), schemas);
    let asked = reachable(&Value::Array(requests), schemas);
    formats(schemas);
    discriminate(schemas);
    for name in asked.difference(&answered).map(String::as_str).chain(LEFT_OUT.iter().copied()) {
        leave_out_null(schemas, name);
    }
    for name in answered.difference(&asked).filter(|name| !LEFT_OUT.contains(&name.as_str())) {
        schemas.get_mut(name).into_iter().for_each(without_bounds);
    }
    // Bodies have whole examples. Those of single members stay where pages in a browser begin with them: in forms, and
    // in the document of a refusal, which has no other.
    for (name, schema) in schemas.iter_mut() {
        let properties = schema.get_mut("properties").and_then(Value::as_object_mut);
        let Some(properties) = properties
            .filter(|all| !all.contains_key("job") && !all.contains_key("program") && name != "Problem")
        else {
            continue;
        };
        for schema in properties.values_mut().filter_map(Value::as_object_mut) {
            schema.remove("example");
        }
    }
    brief(document);
}

fn properties_mut<'a>(
    schemas: &'a mut Map<String, Value>,
    name: &str,
) -> impl Iterator<Item = (&'a String, &'a mut Value)> {
    let properties = schemas.get_mut(name).and_then(|schema| schema.get_mut("properties")?.as_object_mut());
    properties.into_iter().flatten()
}

/// In a request, null is the same as a member that is left out.
fn leave_out_null(schemas: &mut Map<String, Value>, name: &str) {
    for (_, schema) in properties_mut(schemas, name) {
        let description = schema.get("description").cloned();
        without_null(schema);
        if let (Some(description), Some(schema)) = (description, schema.as_object_mut()) {
            schema.insert("description".to_owned(), description);
        }
    }
}

/// An answer needs no word that a number is not negative and fits its type: that bounds what is asked for.
fn without_bounds(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(without_bounds),
        Value::Object(members) => {
            if members.get("type").is_some_and(|kind| kind.to_string().contains("\"integer\"")) {
                members.retain(|key, bound| {
                    !(key == "minimum" && *bound == json!(0) || key == "maximum" && *bound == json!(u32::MAX))
                });
            }
            members.values_mut().for_each(without_bounds);
        }
        _ => {}
    }
}

/// Formats of moments and ids.
fn formats(schemas: &mut Map<String, Value>) {
    let names: Vec<String> = schemas.keys().cloned().collect();
    for name in names {
        for (member, schema) in properties_mut(schemas, &name) {
            let is_text = schema.get("type").is_some_and(|kind| kind.to_string().contains("\"string\""));
            if !is_text || schema.get("format").is_some() || schema.get("enum").is_some() {
                continue;
            }
            let format = if member.ends_with("_at") || MOMENTS.contains(&member.as_str()) {
                "date-time"
            } else if UUIDS.contains(&(name.as_str(), member.as_str())) {
                "uuid"
            } else {
                continue;
            };
            if let Some(schema) = schema.as_object_mut() {
                schema.insert("format".to_owned(), json!(format));
            }
        }
    }
}

/// A parameter whose example is a UUID is one.
fn formats_of_parameters(operation: &mut Map<String, Value>) {
    let parameters = operation.get_mut("parameters").and_then(Value::as_array_mut);
    for parameter in parameters.into_iter().flatten() {
        let example = parameter.get("example").and_then(Value::as_str).unwrap_or_default();
        if example.parse::<uuid::Uuid>().is_ok()
            && let Some(schema) = parameter.get_mut("schema").and_then(Value::as_object_mut)
        {
            schema.insert("format".to_owned(), json!("uuid"));
        }
    }
}

/// Alternatives that are distinguished by a member name it.
fn discriminate(schemas: &mut Map<String, Value>) {
    let mut found = Vec::new();
    for (name, schema) in schemas.iter() {
        let Some(parts) = schema.get("oneOf").and_then(Value::as_array) else { continue };
        let whole: Vec<Value> = parts.iter().map(|part| resolved(part, schemas).clone()).collect();
        let Some(tag) = common_tag(&whole) else { continue };
        let mut mapping = Map::new();
        for (part, whole) in parts.iter().zip(&whole) {
            if let (Some(word), Some(reference)) = (only_word(whole, &tag), part.get("$ref")) {
                mapping.insert(word.to_owned(), reference.clone());
            }
        }
        if mapping.len() == parts.len() {
            found.push((name.clone(), json!({ "propertyName": tag, "mapping": mapping })));
        }
    }
    for (name, discriminator) in found {
        if let Some(schema) = schemas.get_mut(&name).and_then(Value::as_object_mut) {
            schema.insert("discriminator".to_owned(), discriminator);
        }
    }
}

/// Leaves out what a reader takes for granted: a number in JSON is a double, a parameter is not required, and the name
/// of a member is a text.
fn brief(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(brief),
        Value::Object(members) => {
            let is_number = members.get("type").is_some_and(|kind| kind.to_string().contains("\"number\""));
            if is_number && members.get("format") == Some(&json!("double")) {
                members.remove("format");
            }
            if members.contains_key("in") && members.get("required") == Some(&Value::Bool(false)) {
                members.remove("required");
            }
            if members.get("propertyNames") == Some(&json!({ "type": "string" })) {
                members.remove("propertyNames");
            }
            // Examples are values, not schemas.
            let others = members.iter_mut().filter(|(name, _)| !name.starts_with("example"));
            others.for_each(|(_, member)| brief(member));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::super::schemas::SCHEMAS;
    use super::*;

    fn reference(name: &str) -> Value {
        json!({ "$ref": format!("{SCHEMAS}{name}") })
    }

    fn changed(schemas: &Value) -> Value {
        let mut document = json!({
            "paths": {"/a": {"post": {
                "requestBody": reference("Asked"), "responses": reference("Answered"),
                "parameters": [{"in": "path", "required": true, "example": "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60",
                    "schema": {"type": "string"}}, {"in": "query", "required": false, "schema": {}}],
            }}},
            "components": {"schemas": schemas}
        });
        mend(&mut document);
        document
    }

    #[test]
    fn null_stays_only_in_answers() {
        let maybe = json!({ "type": ["number", "null"], "format": "double" });
        let both = json!({ "properties": {"gap": maybe} });
        let asked = json!({ "properties": {"gap": maybe, "both": reference("Both")} });
        let answered = json!({ "properties": {"gap": maybe, "both": reference("Both")} });
        let document = changed(&json!({ "Asked": asked, "Answered": answered, "Both": both }));
        let gap = |name: &str| document["components"]["schemas"][name]["properties"]["gap"].clone();
        assert_eq!(gap("Asked"), json!({ "type": "number" }));
        assert_eq!([gap("Answered"), gap("Both")], [(); 2].map(|()| json!({ "type": ["number", "null"] })));
        assert_eq!(document["paths"]["/a"]["post"]["parameters"][0]["schema"]["format"], "uuid");
        assert_eq!(document["paths"]["/a"]["post"]["parameters"][1], json!({ "in": "query", "schema": {} }));
    }

    #[test]
    fn moments_and_ids_have_formats() {
        let text = json!({ "type": ["string", "null"] });
        let job = json!({ "properties": {"id": text, "ended_at": text, "machine_id": text} });
        let document = changed(&json!({ "Asked": {}, "Answered": {}, "Job": job }));
        let format =
            |name: &str| document["components"]["schemas"]["Job"]["properties"][name]["format"].clone();
        assert_eq!(
            ["id", "ended_at", "machine_id"].map(format),
            [json!("uuid"), json!("date-time"), Value::Null]
        );
    }

    #[test]
    fn alternatives_name_the_member_that_distinguishes_them() {
        let path = |kind: &str| json!({ "properties": {"kind": {"enum": [kind]}, "radius_mm": {}} });
        let any = json!({ "oneOf": [reference("Arc"), reference("Line")] });
        let document = changed(
            &json!({ "Asked": {}, "Answered": {}, "Any": any, "Arc": path("arc"), "Line": path("line") }),
        );
        let mapping = json!({ "arc": format!("{SCHEMAS}Arc"), "line": format!("{SCHEMAS}Line") });
        let discriminator = json!({ "propertyName": "kind", "mapping": mapping });
        assert_eq!(document["components"]["schemas"]["Any"]["discriminator"], discriminator);
    }
}
