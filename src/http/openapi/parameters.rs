//! Parameters in the form in which they are sent: a query has dotted names instead of objects, and no header or
//! parameter is null.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::schemas::{reference, resolved};

/// Letters in the names of parameters for each axis.
const AXES: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];

/// Schemas of headers that the service reads.
const HEADERS: &[(&str, &str)] =
    &[("Idempotency-Key", "^[!-~]([ -~]{0,253}[!-~])?$"), ("If-Match", TAGS), ("If-None-Match", TAGS)];
/// `*`, or entity tags (RFC 9110 §8.8.3).
const TAGS: &str = r#"^(\*|(W/)?"[!#-~]*"(, (W/)?"[!#-~]*")*)$"#;

/// Converts the parameters of an operation to the form in which they are sent.
pub(super) fn mend(operation: &mut Map<String, Value>, schemas: &Map<String, Value>) {
    let named = of_the_form(operation, schemas);
    if !named.is_empty() {
        let parameters = operation.entry("parameters").or_insert_with(|| json!([]));
        parameters.as_array_mut().into_iter().for_each(|parameters| parameters.extend(named.clone()));
    }
    let Some(parameters) = operation.get_mut("parameters").and_then(Value::as_array_mut) else { return };
    let words = schemas_by_words(schemas);
    let mut mended = Vec::new();
    for parameter in parameters.drain(..) {
        flatten(parameter, schemas, &mut mended);
    }
    for parameter in &mut mended {
        let pattern = HEADERS.iter().find(|(name, _)| text(parameter, "name") == Some(name));
        if let Some(schema) = parameter.get_mut("schema") {
            without_null(schema);
            if let (Some((_, pattern)), Some(schema)) = (pattern, schema.as_object_mut()) {
                schema.insert("pattern".to_owned(), json!(pattern));
                schema.insert("minLength".to_owned(), json!(1));
            }
            if let Some(name) = schema.get("enum").and_then(|words_of| words.get(&words_of.to_string())) {
                let default = schema.get("default").cloned();
                *schema = reference(name);
                if let (Some(default), Some(schema)) = (default, schema.as_object_mut()) {
                    schema.insert("default".to_owned(), default);
                }
            }
        }
    }
    *parameters = mended;
    if operation.contains_key("requestBody") {
        leave_unfilled(operation);
    }
    take_examples_of_the_form(operation);
}

/// The query of an operation on a program: each parameter that the field `parameters` of its form has. None is
/// required, because the form may have them all.
fn of_the_form(operation: &Map<String, Value>, schemas: &Map<String, Value>) -> Vec<Value> {
    let form = operation
        .get("requestBody")
        .and_then(|body| body.pointer("/content/multipart~1form-data/schema"))
        .map(|schema| joined(schema, schemas));
    let field = form.as_ref().and_then(|form| form.pointer("/properties/parameters"));
    let document = field.map(|field| joined(field, schemas)).unwrap_or_default();
    let members = document.get("properties").and_then(Value::as_object);
    let parameter = |(name, schema): (&String, &Value)| {
        let mut schema = schema.clone();
        let description = taken_description(&mut schema).unwrap_or_default();
        json!({ "name": name, "in": "query", "required": false, "description": description, "schema": schema })
    };
    members.into_iter().flatten().map(parameter).collect()
}

/// Takes the description out of a schema. In a schema "value or null", the value has it.
fn taken_description(schema: &mut Value) -> Option<Value> {
    let members = schema.as_object_mut()?;
    if let Some(description) = members.remove("description") {
        return Some(description);
    }
    let choices = members.get_mut("oneOf")?.as_array_mut()?;
    let mut known: Vec<_> =
        choices.iter_mut().filter(|one| one.get("type") != Some(&json!("null"))).collect();
    match known.as_mut_slice() {
        [only] => only.as_object_mut()?.remove("description"),
        _ => None,
    }
}

/// A request by query gets the example of the form.
fn take_examples_of_the_form(operation: &mut Map<String, Value>) {
    let form = operation.get("requestBody").and_then(|body| body.pointer("/content/multipart~1form-data"));
    let example = form.and_then(|form| form.pointer("/example/parameters")).cloned().unwrap_or_default();
    let mut values = BTreeMap::new();
    dotted("", &example, &mut values);
    let parameters = operation.get_mut("parameters").and_then(Value::as_array_mut);
    for parameter in parameters.into_iter().flatten() {
        let value = text(parameter, "name").and_then(|name| values.remove(name));
        if let (Some(value), Some("query"), Some(parameter)) =
            (value, text(parameter, "in").map(str::to_owned).as_deref(), parameter.as_object_mut())
        {
            parameter.insert("example".to_owned(), value);
        }
    }
}

/// Every value of a document by its name in a query.
fn dotted(name: &str, value: &Value, into: &mut BTreeMap<String, Value>) {
    let Some(members) = value.as_object() else {
        into.insert(name.to_owned(), value.clone());
        return;
    };
    for (member, value) in members {
        let separator = if name.is_empty() { "" } else { "." };
        dotted(&format!("{name}{separator}{member}"), value, into);
    }
}

/// Takes defaults and examples out of the query of an operation with a body, and states the defaults in words.
/// Parameters come in the query or in the body, but not in both, and pages in a browser send every default and every
/// example that they know.
fn leave_unfilled(operation: &mut Map<String, Value>) {
    let parameters = operation.get_mut("parameters").and_then(Value::as_array_mut);
    let parameters = parameters.into_iter().flatten().filter(|one| text(one, "in") == Some("query"));
    for parameter in parameters.filter_map(Value::as_object_mut) {
        parameter.remove("example");
        let schema = parameter.get_mut("schema").and_then(Value::as_object_mut);
        let default = schema.and_then(|schema| {
            schema.remove("example");
            schema.remove("default")
        });
        if let Some(default) = default.filter(|default| !default.is_null()) {
            let description = parameter.get("description").and_then(Value::as_str).unwrap_or_default();
            let words = format!("{description} Default: {default}.");
            parameter.insert("description".to_owned(), Value::String(words));
        }
    }
}

/// Schemas that are a list of words, by that list.
fn schemas_by_words(schemas: &Map<String, Value>) -> BTreeMap<String, &str> {
    let listed =
        schemas.iter().filter_map(|(name, schema)| Some((schema.get("enum")?.to_string(), name.as_str())));
    listed.collect()
}

/// One parameter for each member of an object, at any depth.
fn flatten(parameter: Value, schemas: &Map<String, Value>, into: &mut Vec<Value>) {
    let schema = parameter.get("schema").cloned().unwrap_or_default();
    let schema = joined(&schema, schemas);
    let (Some("query"), Some(name)) = (text(&parameter, "in"), text(&parameter, "name")) else {
        into.push(parameter);
        return;
    };
    let needed = parameter.get("required") == Some(&Value::Bool(true));
    let members: Vec<(String, Value, bool)> =
        if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
            let required = schema.get("required").and_then(Value::as_array);
            let is_needed = |name: &str| required.is_some_and(|all| all.iter().any(|one| one == name));
            properties
                .iter()
                .map(|(member, schema)| (member.clone(), schema.clone(), needed && is_needed(member)))
                .collect()
        } else if let Some(one) = schema.get("additionalProperties").filter(|one| one.is_object()) {
            // For a map with other names, the example shows the usual ones.
            let names = schema.pointer("/propertyNames/examples").and_then(Value::as_array);
            let names = names.map(|names| names.iter().filter_map(Value::as_str).collect::<Vec<_>>());
            let names = names.unwrap_or_else(|| AXES.to_vec());
            names.into_iter().map(|name| (name.to_owned(), one.clone(), false)).collect()
        } else {
            let mut parameter = parameter;
            if let Some(parameter) = parameter.as_object_mut() {
                // Commas separate the elements of an array.
                if schema.get("type").is_some_and(|kind| kind.to_string().contains("\"array\"")) {
                    parameter.insert("style".to_owned(), json!("form"));
                    parameter.insert("explode".to_owned(), json!(false));
                }
                parameter.insert("schema".to_owned(), schema);
            }
            into.push(parameter);
            return;
        };
    for (member, mut schema, required) in members {
        let description = taken_description(&mut schema);
        let description = description.or_else(|| parameter.get("description").cloned()).unwrap_or_default();
        let part = json!({
            "name": format!("{name}.{member}"), "in": "query", "required": required, "description": description, "schema": schema
        });
        flatten(part, schemas, into);
    }
}

/// A schema with its references replaced: `allOf` with words and a default becomes one schema, "value or null"
/// becomes the value.
fn joined(schema: &Value, schemas: &Map<String, Value>) -> Value {
    let choice = |key: &str| schema.get(key).and_then(Value::as_array);
    let parts = if let Some(parts) = choice("allOf") {
        parts.iter().collect()
    } else if let Some(parts) = choice("oneOf") {
        let known: Vec<&Value> =
            parts.iter().filter(|part| part.get("type") != Some(&json!("null"))).collect();
        if known.len() == 1 { known } else { vec![schema] }
    } else {
        vec![resolved(schema, schemas)]
    };
    let mut whole = Map::new();
    for part in parts {
        let part = resolved(part, schemas).as_object().cloned().unwrap_or_default();
        for (key, value) in part {
            // The first part states the type; the type of a default alone would be invented.
            if key != "type" || !whole.contains_key("type") {
                whole.insert(key, value);
            }
        }
    }
    // A reference has its default beside it.
    if let (Some(default), true) = (schema.get("default"), schema.get("$ref").is_some()) {
        whole.insert("default".to_owned(), default.clone());
    }
    Value::Object(whole)
}

fn text<'a>(value: &'a Value, key: &str) -> Option<&'a str> {
    value.get(key).and_then(Value::as_str)
}

/// The same schema without null: a missing value is left out.
pub(super) fn without_null(schema: &mut Value) {
    if let Some(schema) = schema.as_object_mut().filter(|schema| schema.get("default") == Some(&Value::Null))
    {
        schema.remove("default");
    }
    if let Some(Value::Array(kinds)) = schema.get_mut("type") {
        kinds.retain(|kind| kind != "null");
        if let [only] = kinds.as_slice() {
            let only = only.clone();
            if let Some(schema) = schema.as_object_mut() {
                schema.insert("type".to_owned(), only);
            }
        }
    }
    if let Some(Value::Array(choices)) = schema.get_mut("oneOf") {
        choices.retain(|choice| choice.get("type") != Some(&json!("null")));
        if let [only] = choices.as_slice() {
            *schema = only.clone();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_in_the_query_is_a_parameter_for_each_member() {
        let inner = json!({ "type": "object", "required": ["r"], "properties": {"r": {"type": "number"}} });
        let map = json!({ "type": "object", "additionalProperties": {"type": ["number", "null"]} });
        let parameter = |name: &str, schema: Value| json!({ "name": name, "in": "query", "required": true, "schema": schema });
        let outer = json!({ "type": "object", "required": ["inner"], "properties": {"inner": inner} });
        let mut operation = Map::new();
        operation.insert("parameters".into(), json!([parameter("tool", outer), parameter("gain", map)]));
        mend(&mut operation, &Map::new());
        let parameters = operation["parameters"].as_array().unwrap();
        let names: Vec<_> = parameters.iter().map(|one| one["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["tool.inner.r", "gain.X", "gain.Y", "gain.Z", "gain.A", "gain.B", "gain.C"]);
        assert_eq!(parameters[0]["required"], true);
        assert!(
            parameters[1..]
                .iter()
                .all(|one| one["required"] == false && one["schema"] == json!({"type": "number"}))
        );
    }

    #[test]
    fn a_default_beside_words_keeps_the_words() {
        let schemas = json!({ "Word": {"type": "string", "enum": ["a", "b"]} });
        let parts = json!([{"type": "string", "enum": ["a", "b"]}, {"type": "object", "default": "a"}]);
        let mut operation = Map::new();
        operation
            .insert("parameters".into(), json!([{ "name": "w", "in": "query", "schema": {"allOf": parts} }]));
        mend(&mut operation, schemas.as_object().unwrap());
        let schema = &operation["parameters"][0]["schema"];
        assert_eq!(schema, &json!({ "$ref": "#/components/schemas/Word", "default": "a" }));
    }

    #[test]
    fn a_query_has_the_example_of_the_form_and_names_of_offsets() {
        let numbers = json!({"type": "array", "items": {"type": "number"}});
        let offsets = json!({"type": "object", "additionalProperties": numbers, "propertyNames": {"examples": ["G54", "G55"]}});
        let parameters = json!({"type": "object", "properties": {
            "offsets": {"oneOf": [{"$ref": "#/components/schemas/Offsets", "description": "Where."}, {"type": "null"}]},
            "word": {"$ref": "#/components/schemas/Word", "default": "a"}
        }});
        let schemas = json!({
            "Offsets": offsets, "Word": {"type": "string", "enum": ["a", "b"]},
            "Form": {"type": "object", "properties": {"parameters": parameters}}
        });
        let form = json!({"schema": {"$ref": "#/components/schemas/Form"}, "example": {"parameters": {"offsets": {"G55": [1, 2, 3]}}}});
        let mut operation = Map::new();
        operation.insert("requestBody".into(), json!({ "content": {"multipart/form-data": form} }));
        mend(&mut operation, schemas.as_object().unwrap());
        let found: Vec<_> = operation["parameters"]
            .as_array()
            .unwrap()
            .iter()
            .map(|one| {
                (one["name"].as_str().unwrap(), one["description"].as_str().unwrap(), one.get("example"))
            })
            .collect();
        let example = json!([1, 2, 3]);
        let expected = [
            ("offsets.G54", "Where.", None),
            ("offsets.G55", "Where.", Some(&example)),
            ("word", " Default: \"a\".", None),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn beside_a_body_a_default_is_told_in_words_and_nothing_is_filled_in() {
        let mut operation = Map::new();
        operation.insert("requestBody".into(), json!({ "content": {"application/json": {}} }));
        let schema = json!({ "type": "number", "default": 10.0, "example": 12.0 });
        operation.insert(
            "parameters".into(),
            json!([{ "name": "t", "in": "query", "description": "T.", "example": 12.0, "schema": schema }]),
        );
        mend(&mut operation, &Map::new());
        assert_eq!(operation["parameters"][0]["schema"], json!({ "type": "number" }));
        assert_eq!(operation["parameters"][0].get("example"), None);
        assert_eq!(operation["parameters"][0]["description"], "T. Default: 10.0.");
    }
}
