//! The description of the interface: equal to the committed one, and whole. `BLESS=1` writes it again.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Map, Value};
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;

use super::schemas::resolved;
use super::{Base, completed, in_lines, published};
use crate::http::routes::routes;
use crate::http::{
    audit, calibrations, jobs, keys, kinematics, machines, programs, service, servo, tools, wear, webhooks,
};

#[path = "../../../tests/models/description.rs"]
mod description;

/// The description of the interface, made from the routes. The binary has the committed one, which is equal.
pub(super) fn made() -> Value {
    let resources = [
        machines::describe,
        tools::describe,
        kinematics::describe,
        programs::describe,
        servo::describe,
        wear::describe,
        calibrations::describe,
        jobs::describe,
        webhooks::describe,
        keys::describe,
        audit::describe,
        service::describe,
    ];
    let base = OpenApiRouter::with_openapi(Base::openapi());
    let described = resources.into_iter().fold(base, |all, describe| describe(all));
    published(&completed(described.into_openapi()))
}

/// The description, with what operations and schemas share written out at each of them.
pub(super) fn document() -> Value {
    description::in_full(&made())
}

/// One line for each operation: method, path, id.
fn names() -> String {
    let routes = routes();
    let mut lines: Vec<String> =
        routes.operations().map(|(method, path, id)| format!("{method:6} {path:58} {id}")).collect();
    lines.sort_by(|a, b| a.get(7..).cmp(&b.get(7..)));
    lines.join("\n") + "\n"
}

fn operations(document: &Value) -> Vec<(String, &Value)> {
    let mut all = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            all.push((format!("{method} {path}"), operation));
        }
    }
    assert!(all.len() >= 20, "only {} operations", all.len());
    all
}

fn golden(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("openapi").join(name);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == text, "openapi/{name} is not up to date; write it anew with BLESS=1");
}

/// Most of the committed file, which is served as it is: a browser on a slow line shows it within a second \[bytes\]. A
/// member that does not fit needs a text or a part that others share (`parts.rs`, `shared.rs`).
const MOST: usize = 350_000;

#[test]
fn the_committed_description_is_that_of_the_routes() {
    let mut text = String::new();
    in_lines(&made(), &mut text);
    assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), made());
    golden("trunnion.json", &(text + "\n"));
    golden("operations.txt", &names());
}

#[test]
fn every_route_has_the_names_of_its_description() {
    let (document, routes) = (document(), routes());
    let mut count = 0;
    for (method, path, id) in routes.operations() {
        let operation = &document["paths"][path][method.to_lowercase()];
        assert_eq!(operation["operationId"], id, "{method} {path}");
        count += 1;
    }
    assert_eq!(count, operations(&document).len());
}

#[test]
fn it_is_openapi_3_1_with_a_licence() {
    let document = document();
    assert_eq!(document["openapi"], "3.1.0");
    assert_eq!(document["info"]["license"]["name"], "MIT OR Apache-2.0");
    assert!(!document["info"]["license"]["identifier"].as_str().unwrap_or_default().is_empty());
    assert_eq!(document["info"]["version"], env!("CARGO_PKG_VERSION"));
}

#[test]
fn every_operation_has_an_id_a_tag_a_description_and_an_example() {
    let document = document();
    let mut ids = BTreeSet::new();
    for (name, operation) in operations(&document) {
        let id = operation["operationId"].as_str().unwrap_or_default().to_owned();
        assert!(!id.is_empty(), "{name} has no id");
        assert!(ids.insert(id), "{name} repeats an id");
        assert_eq!(operation["tags"].as_array().map(Vec::len), Some(1), "{name}");
        assert!(operation["summary"].is_string(), "{name} has no summary");
        assert!(operation["description"].is_string(), "{name} has no description");
        assert!(operation.to_string().contains("\"example"), "{name} has no example");
    }
}

#[test]
fn every_response_is_described_and_every_refusal_is_a_problem_document() {
    let document = document();
    for (name, operation) in operations(&document) {
        for (status, response) in operation["responses"].as_object().unwrap() {
            assert!(
                response["description"].as_str().is_some_and(|text| !text.is_empty()),
                "{name} {status} is not described"
            );
            if status.starts_with(['4', '5', 'd']) {
                let schema = &response["content"]["application/problem+json"]["schema"]["$ref"];
                assert_eq!(schema, "#/components/schemas/Problem", "{name} {status}");
            }
        }
        let others = operation["responses"]["default"]["description"].as_str().unwrap_or_default();
        for status in ["422 ", "500 ", "503 "] {
            assert!(others.contains(status), "{name} has no {status}");
        }
    }
}

#[test]
fn every_post_that_stores_takes_an_idempotency_key() {
    // Nothing is stored by these; a withdrawal is the same however often it comes with its reason.
    let without = [
        "advise_wear",
        "compute_scallop_height",
        "interpret_program",
        "match_servo",
        "solve_forward_kinematics",
        "solve_inverse_kinematics",
        "sweep_servo",
        "withdraw_wear_entry",
    ];
    let document = document();
    let mut found = Vec::new();
    for (name, operation) in operations(&document).into_iter().filter(|(name, _)| name.starts_with("post ")) {
        let parameters = operation["parameters"].as_array().into_iter().flatten();
        if !parameters.clone().any(|one| one["name"] == "Idempotency-Key") {
            found.push(operation["operationId"].as_str().unwrap());
            assert!(!operation.to_string().contains("\"Location\""), "{name}");
        }
    }
    found.sort_unstable();
    assert_eq!(found, without);
}

#[test]
fn every_reference_resolves_and_everything_shared_is_used() {
    let document = made();
    let text = document.to_string();
    let mut used = BTreeSet::new();
    for part in text.split("\"#/").skip(1) {
        let path = format!("/{}", part.split('"').next().unwrap());
        assert!(document.pointer(&path).is_some_and(Value::is_object), "{path} is not there");
        used.insert(path);
    }
    assert!(used.len() > 250, "only {} references", used.len());
    for kind in ["examples", "headers", "parameters", "responses", "schemas"] {
        for name in document["components"][kind].as_object().unwrap().keys() {
            assert!(used.contains(&format!("/components/{kind}/{name}")), "nothing uses {kind}/{name}");
        }
    }
}

#[test]
fn the_description_is_short() {
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("openapi/trunnion.json");
    let bytes = std::fs::metadata(committed).unwrap().len();
    assert!(bytes < MOST as u64, "openapi/trunnion.json has {bytes} bytes, more than {MOST}");
}

#[test]
fn every_refusal_is_a_shared_response_and_nothing_shared_is_repeated() {
    let document = made();
    let mut written_out = BTreeSet::new();
    let mut once = |place: &str, name: &str, part: &Value| {
        let is_new = part["$ref"].is_string() || written_out.insert(format!("{name} {part}"));
        assert!(is_new, "{place}: other operations have the same {name} {part}");
    };
    for (name, operation) in operations(&document) {
        for (status, response) in operation["responses"].as_object().unwrap() {
            let reference = response["$ref"].as_str().unwrap_or_default();
            let is_refusal = status.starts_with(['4', '5']) || status == "default";
            assert_eq!(is_refusal, reference.starts_with("#/components/responses/"), "{name} {status}");
            for (header, part) in response["headers"].as_object().into_iter().flatten() {
                once(&name, header, part);
            }
        }
        for parameter in operation["parameters"].as_array().into_iter().flatten() {
            once(&name, "", parameter);
        }
    }
    assert!(written_out.len() > 50, "only {} parts", written_out.len());
}

#[test]
fn schemas_have_names_of_the_field() {
    let document = made();
    for name in document["components"]["schemas"].as_object().unwrap().keys() {
        let ours = ["BTreeMap", "HashMap", "Numbers2", "Numbers3", "Vec", "Option", "Fixed"];
        assert!(!ours.contains(&name.as_str()) && !name.ends_with("Doc") && !name.contains('_'), "{name}");
    }
}

/// Alternatives that no member distinguishes: what was asked for says which of them comes.
const WITHOUT_TAG: &[&str] = &[
    "AnyReport",
    "NumbersOrNull",
    "NumbersOrOne",
    "PathOrProgram",
    "WearEntriesAnswer",
    "WearEntriesRequest",
];

#[test]
fn alternatives_have_a_discriminator() {
    let document = document();
    let schemas = document["components"]["schemas"].as_object().unwrap();
    let mut found = 0;
    for (name, schema) in schemas {
        let Some(parts) = schema["oneOf"].as_array().filter(|_| !WITHOUT_TAG.contains(&name.as_str())) else {
            continue;
        };
        let mapping =
            schema["discriminator"]["mapping"].as_object().unwrap_or_else(|| unreachable!("{name}"));
        assert_eq!(mapping.len(), parts.len(), "{name}");
        let tag = schema["discriminator"]["propertyName"].as_str().unwrap();
        for (word, reference) in mapping {
            assert!(parts.iter().any(|part| part["$ref"] == *reference), "{name} {word}");
            let part = document.pointer(reference.as_str().unwrap().trim_start_matches('#')).unwrap();
            assert_eq!(part["properties"][tag]["enum"], serde_json::json!([word]), "{name} {word}");
        }
        found += 1;
    }
    assert!(found >= 2, "only {found}");
    assert!(WITHOUT_TAG.iter().all(|name| schemas[*name]["oneOf"].is_array()));
}

/// Names of all schemas that a part refers to, also through others.
fn reached(document: &Value, part: &Value, into: &mut BTreeSet<String>) {
    let text = part.to_string();
    for name in text.split("\"#/components/schemas/").skip(1).filter_map(|rest| rest.split('"').next()) {
        if into.insert(name.to_owned()) {
            reached(document, &document["components"]["schemas"][name], into);
        }
    }
}

fn takes_null(schema: &Value) -> bool {
    schema["type"].as_array().is_some_and(|kinds| kinds.iter().any(|kind| kind == "null"))
        || schema["oneOf"].as_array().is_some_and(|parts| parts.iter().any(|part| part["type"] == "null"))
}

#[test]
fn null_is_named_only_where_it_is_answered() {
    let document = document();
    let (mut asked, mut answered) = (BTreeSet::new(), BTreeSet::new());
    for (name, operation) in operations(&document) {
        reached(&document, &operation["requestBody"], &mut asked);
        reached(&document, &operation["responses"], &mut answered);
        for parameter in operation["parameters"].as_array().into_iter().flatten() {
            assert!(!takes_null(&parameter["schema"]), "{name} {parameter}");
        }
    }
    let mut count = 0;
    for schema in asked.difference(&answered) {
        let members = document["components"]["schemas"][schema]["properties"].as_object();
        for (member, body) in members.into_iter().flatten() {
            assert!(!takes_null(body), "{schema}.{member}: leave it out of a request");
            count += 1;
        }
    }
    assert!(count > 150, "only {count} members");
}

#[test]
fn moments_and_ids_have_their_format() {
    let document = document();
    let (mut moments, mut ids) = (0, 0);
    for (name, schema) in document["components"]["schemas"].as_object().unwrap() {
        for (member, body) in schema["properties"].as_object().into_iter().flatten() {
            if member.ends_with("_at") {
                assert_eq!(body["format"], "date-time", "{name}.{member}");
                moments += 1;
            }
            ids += u32::from(body["format"] == "uuid");
        }
    }
    for (name, operation) in operations(&document) {
        for parameter in operation["parameters"].as_array().into_iter().flatten() {
            let is_id = parameter["in"] == "path" && parameter["name"] == "id" && !name.contains("/keys/");
            assert!(!is_id || parameter["schema"]["format"] == "uuid", "{name}");
            ids += u32::from(is_id);
        }
    }
    assert!(moments > 20 && ids > 20, "{moments} moments, {ids} ids");
}

#[test]
fn pages_in_a_browser_begin_with_values_that_fit() {
    let document = document();
    for (name, operation) in operations(&document) {
        for parameter in operation["parameters"].as_array().into_iter().flatten() {
            let filled = !parameter["example"].is_null() || !parameter["schema"]["example"].is_null();
            let has_body = operation["requestBody"].is_object();
            let query = parameter["in"] == "query" && has_body;
            // Parameters of a program are in the query, and the form leaves them there.
            let form = &operation["requestBody"]["content"]["multipart/form-data"];
            let example = form["example"]["parameters"]
                .pointer(&format!("/{}", parameter["name"].as_str().unwrap().replace('.', "/")));
            if query {
                assert_eq!(filled, example.is_some(), "{name} {parameter}");
                assert!(parameter["schema"]["default"].is_null(), "{name} {parameter}");
            } else if parameter["in"] == "header" {
                assert!(!filled || parameter["example"] == "*", "{name} {parameter}");
            }
        }
        let form = operation["requestBody"]["content"]["multipart/form-data"]["schema"]["$ref"].as_str();
        let Some(form) = form.and_then(|path| document.pointer(path.trim_start_matches('#'))) else {
            continue;
        };
        let fields = form["properties"].as_object().unwrap();
        match fields.get("parameters") {
            Some(parameters) => assert_eq!(parameters["example"], serde_json::json!({}), "{name}"),
            None => assert!(fields["job"]["example"]["callback_url"].is_null(), "{name}"),
        }
    }
}

/// Units that a name may end in or carry.
const UNITS: &[&str] = &[
    "_mm",
    "_mm2",
    "_mm3",
    "_um",
    "_c",
    "_deg",
    "_urad",
    "_s",
    "_ms",
    "_days",
    "_hz",
    "_h",
    "_ohm",
    "_kg_m2",
    "_per_min",
    "_per_s",
    "_per_rad",
    "_per_a",
    "_per_part",
    "_s_per_rad",
    "_nm",
    "_per_s2",
    "_per_s3",
];

/// Numbers that have no unit, and coordinates that go bare.
const BARE: &[&str] = &[
    "x",
    "y",
    "z",
    "i",
    "j",
    "k",
    "X",
    "Y",
    "Z",
    "A",
    "B",
    "C",
    "conditioning",
    "progress",
    "direction",
    "damping_ratio",
    "gear_ratio",
    "velocity_feedforward",
    "acceleration_feedforward",
    "gain_margin",
    "least_gain",
    "least_gain_margin",
    "resonance_peak",
    "scale",
    "condition_number",
    "correlation",
    "rate_drift",
    "stages_per_stretch",
    "standstill_share",
    "standstill_of_age",
    "rate_ratios",
];

/// Objects that carry the unit of what is in them.
fn carried(schema: &str, property: &str) -> bool {
    matches!((schema, property), ("Squareness" | "squareness_urad", "e_c0y" | "e_b0z" | "e_a0z"))
        || (schema == "linear_limits_mm" || schema == "LinearLimits")
        // A limit says its unit beside it.
        || (schema == "Limit" && property == "value")
        // Directions of length one, and whole turns.
        || (schema == "InterpretedMotion" && matches!(property, "axis" | "normal" | "turns"))
        // Values whose unit stands in the name of the object that holds them: `errors.A.e_y_um`, `setup_error_um`,
        // `eccentricities_um`, and the member `unit` of a trend.
        || matches!(
            (schema, property),
            ("Estimate" | "TrendPoint", "value" | "standard_uncertainty")
                | ("Difference", "difference" | "standard_uncertainty")
                | ("SetupError", "e_xs" | "e_ys")
                | ("Eccentricities", "before" | "after_linear" | "after_all")
        )
}

/// Whether a schema is a number, or an array of numbers, perhaps null.
fn is_number(schema: &Value) -> bool {
    let typed = |value: &Value| {
        value == "number" || value.as_array().is_some_and(|all| all.contains(&"number".into()))
    };
    let fixed = schema["$ref"].as_str().is_some_and(|name| {
        ["/Pair", "/Vector"].iter().any(|end| name.ends_with(end)) || name.contains("/Numbers")
    });
    typed(&schema["type"])
        || fixed
        || (schema["items"].is_object() && is_number(&schema["items"]))
        || schema["oneOf"].as_array().into_iter().flatten().any(is_number)
}

/// Every number among the properties of a schema, at any depth, with the name of its schema.
fn check_numbers(name: &str, schema: &Value, schemas: &Map<String, Value>, seen: &mut usize) {
    for (property, body) in schema["properties"].as_object().into_iter().flatten() {
        // A member that several schemas have is a schema of its own.
        if is_number(body) || is_number(resolved(body, schemas)) {
            *seen += 1;
            let named =
                UNITS.iter().any(|unit| property.ends_with(unit)) || BARE.contains(&property.as_str());
            assert!(named || carried(name, property), "{name}.{property} has no unit");
        }
    }
    match schema {
        Value::Object(members) => {
            members.iter().for_each(|(key, value)| check_numbers(key, value, schemas, seen));
        }
        Value::Array(items) => items.iter().for_each(|value| check_numbers(name, value, schemas, seen)),
        _ => {}
    }
}

#[test]
fn every_number_carries_its_unit() {
    let mut seen = 0;
    let document = document();
    let schemas = document["components"]["schemas"].as_object().unwrap();
    for (name, schema) in schemas {
        check_numbers(name, schema, schemas, &mut seen);
    }
    assert!(seen > 40, "only {seen} numbers");
    assert!(is_number(
        &serde_json::json!({"oneOf": [{"type": "null"}, {"$ref": "#/components/schemas/Pair"}]})
    ));
}

#[test]
fn every_parameter_that_is_a_number_carries_its_unit() {
    let document = document();
    for (name, operation) in operations(&document) {
        for parameter in operation["parameters"].as_array().into_iter().flatten() {
            let parameter_name = parameter["name"].as_str().unwrap();
            if is_number(&parameter["schema"]) {
                let last = parameter_name.rsplit('.').next().unwrap();
                let named = UNITS.iter().any(|unit| last.ends_with(unit)) || BARE.contains(&last);
                // Factors by axis letter, and places by the names of work offsets: the object carries the unit.
                let objects = ["position_gain_scale.", "work_offsets_mm.", "radius_offsets_mm."];
                let is_member = objects.iter().any(|object| parameter_name.starts_with(object));
                assert!(named || is_member, "{name}: {parameter_name}");
            }
        }
    }
}
