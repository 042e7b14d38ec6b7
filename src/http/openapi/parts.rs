//! Members that several schemas have in common are a part of them: `allOf`. A schema that allows no other members says
//! so of all its members together: `unevaluatedProperties`.

use serde_json::{Map, Value, json};

use super::schemas::reference;

/// The name of a part, what it is, and the schemas that have it. A part that is a schema itself keeps its own words.
///
/// A part comes before the parts of its own.
const PARTS: &[(&str, &str, &[&str])] = &[
    ("ApiKey", "", &["NewApiKey"]),
    ("CcFindings", "", &["CcReport"]),
    ("WearFindings", "", &["WearReport"]),
    (
        "SourceFindings",
        "Findings about the program that was read.",
        &["CcFindings", "CompensationReport", "WearFindings"],
    ),
    (
        "ReportInputs",
        "The data that a report was computed from.",
        &[
            "CcReport",
            "CompensationReport",
            "PostingReport",
            "ServoReport",
            "VerificationReport",
            "WearReport",
        ],
    ),
    (
        "MachineMembers",
        "The members of a machine that a request states.",
        &["MachineDocument", "MachineProfile"],
    ),
    ("ToolMembers", "The members of a tool that a request states.", &["Tool", "ToolDocument"]),
    ("JobRecord", "Members of every job.", &["EndedJob", "Job"]),
    (
        "JobOrder",
        "Members of every request for a job.",
        &[
            "CcCompensationJob",
            "CompensationJob",
            "PostingJob",
            "ServoSimulationJob",
            "VerificationJob",
            "WearCompensationJob",
        ],
    ),
    (
        "ProgramStatements",
        "Statements of a request about its program.",
        &[
            "CcParameters",
            "CompensationParameters",
            "InterpretationParameters",
            "ServoProgramParameters",
            "VerificationParameters",
            "WearParameters",
        ],
    ),
    (
        "CompensationStatements",
        "Statements of a request for any compensation.",
        &["CcParameters", "CompensationParameters", "WearParameters"],
    ),
    ("ContactPathStatements", "Compensation of the CC path.", &["CcParameters", "CcStep"]),
    ("WornCutterStatements", "Statements of a request about a worn cutter.", &["WearParameters", "WearStep"]),
    (
        "ServoStatements",
        "Statements of a request about the drives and the path.",
        &["MatchingRequest", "SimulationRequest", "SweepRequest"],
    ),
];

/// Takes the parts out of the schemas that have them.
pub(super) fn compose(schemas: &mut Map<String, Value>) {
    for (name, words, wholes) in PARTS {
        let part = match schemas.get(*name) {
            Some(part) => part.clone(),
            None => common(words, wholes, schemas),
        };
        let has_members =
            part.get("properties").and_then(Value::as_object).is_some_and(|all| !all.is_empty());
        if !has_members || !wholes.iter().all(|whole| schemas.contains_key(*whole)) {
            continue;
        }
        for whole in *wholes {
            if let Some(schema) = schemas.remove(*whole) {
                schemas.insert((*whole).to_owned(), without(schema, name, &part));
            }
        }
        schemas.insert((*name).to_owned(), part);
    }
    schemas.values_mut().for_each(own_part);
}

/// Makes the members that a schema has beside its parts the last part: some generators of clients take a schema with
/// one part for that part.
fn own_part(schema: &mut Value) {
    let Some(members) = schema.as_object_mut().filter(|members| members.contains_key("allOf")) else {
        return;
    };
    let mut own = json!({});
    for key in ["properties", "required"] {
        if let Some(value) = members.remove(key) {
            own["type"] = json!("object");
            own[key] = value;
        }
    }
    if let Some(parts) = members.get_mut("allOf").and_then(Value::as_array_mut) {
        // Strict readers refuse an empty part, and a generator makes a type without members of an object without any.
        let is_empty = own == json!({});
        parts.push(if is_empty { json!({ "minProperties": 0 }) } else { own });
    }
}

/// The part that several schemas have in common: members that are the same in each of them. An object that is written
/// out stays: a generator of clients makes a type of it in the part, and then makes it again for the whole.
fn common(words: &str, wholes: &[&str], schemas: &Map<String, Value>) -> Value {
    let of = |whole: &str, key: &str| schemas.get(whole).and_then(|schema| schema.get(key));
    let mut properties =
        wholes.first().and_then(|first| of(first, "properties")?.as_object().cloned()).unwrap_or_default();
    properties.retain(|member, schema| {
        let is_written_out = schema.get("type") == Some(&json!("object"));
        let is_same =
            |whole: &&str| of(whole, "properties").and_then(|all| all.get(member)) == Some(&*schema);
        let is_required = |whole: &&str| {
            of(whole, "required")
                .and_then(Value::as_array)
                .is_some_and(|all| all.iter().any(|one| one == member))
        };
        let required = wholes.iter().filter(|whole| is_required(whole)).count();
        !is_written_out && wholes.iter().all(is_same) && (required == 0 || required == wholes.len())
    });
    let required =
        wholes.first().and_then(|first| of(first, "required")?.as_array().cloned()).unwrap_or_default();
    let required: Vec<Value> = required
        .into_iter()
        .filter(|member| member.as_str().is_some_and(|member| properties.contains_key(member)))
        .collect();
    let mut part = json!({ "type": "object", "description": words, "properties": properties });
    if !required.is_empty() {
        part["required"] = json!(required);
    }
    part
}

/// A schema that refers to a part in the place of its members.
fn without(mut schema: Value, name: &str, part: &Value) -> Value {
    let Some(members) = schema.as_object_mut() else { return schema };
    if let (Some(Value::Object(own)), Some(Value::Object(base))) =
        (members.get_mut("properties"), part.get("properties"))
    {
        own.retain(|member, schema| base.get(member) != Some(schema));
    }
    if let (Some(Value::Array(own)), Some(Value::Array(base))) =
        (members.get_mut("required"), part.get("required"))
    {
        own.retain(|member| !base.contains(member));
    }
    members.retain(|key, value| match key.as_str() {
        "properties" => value.as_object().is_some_and(|all| !all.is_empty()),
        "required" => value.as_array().is_some_and(|all| !all.is_empty()),
        _ => true,
    });
    if members.get("additionalProperties") == Some(&Value::Bool(false)) {
        members.remove("additionalProperties");
        members.insert("unevaluatedProperties".to_owned(), json!(false));
    }
    if let Some(Value::Array(parts)) = members.get_mut("allOf") {
        parts.push(reference(name));
    } else {
        members.insert("allOf".to_owned(), json!([reference(name)]));
    }
    schema
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_schemas_have_in_common_is_their_part() {
        let shared = json!({ "type": "string", "description": "The name." });
        let length = json!({ "type": "number" });
        let tool = json!({
            "type": "object", "additionalProperties": false, "required": ["name"],
            "properties": {"name": shared, "length_mm": length}
        });
        let stored = json!({
            "type": "object", "required": ["name", "revision"],
            "properties": {"name": shared, "length_mm": length, "revision": {"type": "integer"}}
        });
        let mut schemas = Map::new();
        schemas.insert("Tool".into(), tool.clone());
        schemas.insert("ToolDocument".into(), stored);
        compose(&mut schemas);
        assert_eq!(schemas["ToolMembers"]["properties"], tool["properties"]);
        assert_eq!(schemas["ToolMembers"]["required"], json!(["name"]));
        let parts = json!([reference("ToolMembers"), {"minProperties": 0}]);
        assert_eq!(
            schemas["Tool"],
            json!({ "type": "object", "unevaluatedProperties": false, "allOf": parts })
        );
        let own = json!({ "type": "object", "required": ["revision"], "properties": {"revision": {"type": "integer"}} });
        let parts = json!([reference("ToolMembers"), own]);
        assert_eq!(schemas["ToolDocument"], json!({ "type": "object", "allOf": parts }));
        assert_eq!(schemas.len(), 3);
    }

    #[test]
    fn every_part_is_in_the_description_and_nothing_of_it_is_said_again() {
        let document = super::super::tests::made();
        let schemas = &document["components"]["schemas"];
        for (name, _, wholes) in PARTS {
            for whole in *wholes {
                let parts = schemas[*whole]["allOf"].as_array().cloned().unwrap_or_default();
                assert!(parts.contains(&reference(name)), "{whole} does not have {name}");
                let own = parts.last().and_then(|own| own["properties"].as_object());
                for member in own.into_iter().flatten().map(|(member, _)| member) {
                    assert!(schemas[*name]["properties"].get(member).is_none(), "{whole} repeats {member}");
                }
            }
        }
    }
}
