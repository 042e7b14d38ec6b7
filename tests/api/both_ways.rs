//! Every parameter of an operation on a program is taken in the query and in the form, and means the same in both.

use reqwest::Response;
use serde_json::{Map, Value, json};

use crate::support::{App, description, program_form, spawn};

/// The work offset, which most results depend on.
const OFFSET: (&str, &str) = ("work_offset_mm", "0,0,0");
/// The operations on programs, and the parameters that each cannot do without.
pub(crate) const OPERATIONS: [(&str, &[(&str, &str)]); 7] = [
    ("cc-compensation", &[("tool_radius_mm", "5"), ("contact", "tip"), OFFSET]),
    (
        "wear-compensation",
        &[
            ("nominal_tool.radius_mm", "5"),
            ("actual_tool.radius_mm", "4.98"),
            ("contact", "feed-plane"),
            OFFSET,
        ],
    ),
    ("compensation", &[("location_errors", "true"), ("cc.tool_radius_mm", "5"), OFFSET]),
    ("servo-simulation", &[OFFSET]),
    ("posting", &[]),
    (
        "verification",
        &[
            ("surface.kind", "plane"),
            ("surface.length_mm", "40"),
            ("surface.width_mm", "30"),
            ("tool.radius_mm", "5"),
            ("samples", "100"),
            OFFSET,
        ],
    ),
    ("interpretation", &[]),
];
const MILLED: &str = "G21 G90 G54\nG1 X0 Y0 Z20 A0 C0 F500\nX1 A0.5 C1\nX2 A1 C2\nM30\n";
const CUTTER_LOCATIONS: &str =
    "UNITS/MM\nMULTAX/ON\nFEDRAT/500,MMPM\nGOTO/0,0,20,0,0,1\nGOTO/1,0,20,0,0,1\nFINI\n";
/// Members of an answer that differ from one call to the next.
const OF_ONE_CALL: [&str; 6] = ["job_id", "created_at", "computed_at", "instance", "request_id", "detail"];

/// A schema, or the one that it refers to.
fn resolved<'d>(description: &'d Value, schema: &'d Value) -> &'d Value {
    let reference = schema["$ref"].as_str().map(|reference| reference.trim_start_matches('#'));
    reference.map_or(schema, |reference| resolved(description, description.pointer(reference).unwrap()))
}

/// A value that fits the schema: its example, its last word, or the least of its kind.
fn value(description: &Value, schema: &Value) -> Value {
    let schema = resolved(description, schema);
    let words = schema["enum"].as_array().and_then(|words| words.last());
    if let Some(given) = Some(&schema["example"]).filter(|example| !example.is_null()).or(words) {
        return given.clone();
    }
    match schema["type"].as_str().or(schema["type"][0].as_str()) {
        Some("boolean") => json!(true),
        Some("integer") => json!(schema["minimum"].as_u64().unwrap_or(1).max(1)),
        Some("number") => json!(1.5),
        Some("array") => json!(vec![1.5; usize::try_from(schema["minItems"].as_u64().unwrap_or(2)).unwrap()]),
        Some("string") => json!("1"),
        other => unreachable!("no value for {other:?}: {schema}"),
    }
}

/// The value as it is written in an address.
fn in_address(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(items) => items.iter().map(in_address).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    }
}

/// Puts a value at a dotted name.
fn put(document: &mut Map<String, Value>, name: &str, value: Value) {
    match name.split_once('.') {
        None => drop(document.insert(name.to_owned(), value)),
        Some((member, rest)) => {
            let inner = document.entry(member).or_insert_with(|| json!({}));
            put(inner.as_object_mut().unwrap(), rest, value);
        }
    }
}

/// Status and body, without what belongs to one call.
async fn answer(response: Response) -> (u16, Value) {
    let status = response.status().as_u16();
    let mut body: Value = response.json().await.unwrap();
    without_calls(&mut body);
    (status, body)
}

fn without_calls(value: &mut Value) {
    match value {
        Value::Object(members) => {
            members.retain(|name, _| !OF_ONE_CALL.contains(&name.as_str()));
            members.values_mut().for_each(without_calls);
        }
        Value::Array(items) => items.iter_mut().for_each(without_calls),
        _ => {}
    }
}

async fn both(app: &App, operation: &str, parameters: &[(String, Value, Value)]) -> [(u16, Value); 2] {
    let program = if operation == "posting" { CUTTER_LOCATIONS } else { MILLED };
    let url = app.url(&format!("/v1/machines/example-ac-table/{operation}"));
    let query: Vec<_> = parameters.iter().map(|(name, written, _)| (name, in_address(written))).collect();
    let mut document = Map::new();
    for (name, _, value) in parameters {
        put(&mut document, name, value.clone());
    }
    let request = || app.client.post(&url).header("accept", "application/json");
    let as_query = request().query(&query).header("content-type", "text/plain").body(program).send();
    let as_form = request().multipart(program_form(&Value::Object(document), program, "part.nc")).send();
    [answer(as_query.await.unwrap()).await, answer(as_form.await.unwrap()).await]
}

#[tokio::test]
async fn every_parameter_of_every_operation_means_the_same_in_the_query_and_in_the_form() {
    let (app, description) = (spawn().await, description());
    let (mut tried, mut done) = (0, 0);
    for (operation, needed) in OPERATIONS {
        let path = format!("/v1/machines/{{machine_id}}/{operation}");
        let listed = description["paths"][&path]["post"]["parameters"].as_array().unwrap();
        let schema_of = |name: &str| {
            let listed =
                listed.iter().find(|parameter| parameter["in"] == "query" && parameter["name"] == name);
            &listed.expect("a parameter of the description")["schema"]
        };
        let typed = |name: &str, written: &str| {
            let kind = &resolved(&description, schema_of(name))["type"];
            let value = match kind.as_str() {
                Some("string") => json!(written),
                Some("array") => serde_json::from_str(&format!("[{written}]")).unwrap(),
                _ => serde_json::from_str(written).unwrap_or_else(|_| json!(written)),
            };
            (name.to_owned(), json!(written), value)
        };
        let needed: Vec<_> = needed.iter().map(|(name, written)| typed(name, written)).collect();
        for parameter in listed.iter().filter(|parameter| parameter["in"] == "query") {
            let name = parameter["name"].as_str().unwrap();
            let chosen = value(&description, &parameter["schema"]);
            let mut parameters: Vec<_> = needed.iter().filter(|(known, ..)| known != name).cloned().collect();
            parameters.push((name.to_owned(), chosen.clone(), chosen.clone()));
            let [in_query, in_form] = both(&app, operation, &parameters).await;
            assert_eq!(in_query, in_form, "{operation} {name}={chosen}");
            let (status, body) = in_query;
            assert!(matches!(status, 200 | 409 | 422), "{operation} {name}={chosen}: {status} {body}");
            tried += 1;
            done += u32::from(status == 200);
        }
        let unknown = vec![("no_such_mm".to_owned(), json!("1"), json!(1))];
        let [in_query, in_form] = both(&app, operation, &[needed, unknown].concat()).await;
        assert_eq!(in_query, in_form, "{operation}");
        assert_eq!((in_query.0, &in_query.1["errors"][0]["pointer"]), (422, &json!("/no_such_mm")));
    }
    // Most values fit the program: a test of refusals alone would say little.
    assert!(tried > 200 && done * 10 > tried * 6, "{done} of {tried}");
}
