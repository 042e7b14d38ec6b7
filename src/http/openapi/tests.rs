//! The description of the interface: equal to the committed one, and whole. `BLESS=1` writes it anew.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;

use super::{Base, completed, published};
use crate::http::routes::routes;
use crate::http::{
    audit, calibrations, jobs, keys, kinematics, machines, programs, service, servo, tools, wear, webhooks,
};

/// The description of the interface, made from the routes. The binary has the committed one, which is equal.
pub(super) fn document() -> Value {
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

#[test]
fn the_committed_description_is_that_of_the_routes() {
    golden("trunnion.json", &(serde_json::to_string_pretty(&document()).unwrap() + "\n"));
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
        assert!(operation.to_string().contains("\"example\""), "{name} has no example");
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
            if status.starts_with(['4', '5']) {
                let schema = &response["content"]["application/problem+json"]["schema"]["$ref"];
                assert_eq!(schema, "#/components/schemas/Problem", "{name} {status}");
            }
        }
        for status in ["500", "503"] {
            assert!(!operation["responses"][status].is_null(), "{name} has no {status}");
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
fn every_reference_resolves() {
    let document = document();
    let text = document.to_string();
    let mut count = 0;
    for part in text.split("\"$ref\":\"#/components/schemas/").skip(1) {
        let name = part.split('"').next().unwrap();
        assert!(document["components"]["schemas"][name].is_object(), "{name} is not there");
        count += 1;
    }
    assert!(count > 50, "only {count} references");
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
                | ("SetupErrorDoc", "e_xs" | "e_ys")
                | ("EccentricitiesDoc", "before" | "after_linear" | "after_all")
        )
}

/// Whether a schema is a number, or an array of numbers, perhaps null.
fn is_number(schema: &Value) -> bool {
    let typed = |value: &Value| {
        value == "number" || value.as_array().is_some_and(|all| all.contains(&"number".into()))
    };
    let fixed = schema["$ref"].as_str().is_some_and(|name| name.contains("/Numbers"));
    typed(&schema["type"])
        || fixed
        || (schema["items"].is_object() && is_number(&schema["items"]))
        || schema["oneOf"].as_array().into_iter().flatten().any(is_number)
}

/// Every number among the properties of a schema, at any depth, with the name of its schema.
fn check_numbers(name: &str, schema: &Value, seen: &mut usize) {
    for (property, body) in schema["properties"].as_object().into_iter().flatten() {
        if is_number(body) {
            *seen += 1;
            let named =
                UNITS.iter().any(|unit| property.ends_with(unit)) || BARE.contains(&property.as_str());
            assert!(named || carried(name, property), "{name}.{property} has no unit");
        }
    }
    match schema {
        Value::Object(members) => members.iter().for_each(|(key, value)| check_numbers(key, value, seen)),
        Value::Array(items) => items.iter().for_each(|value| check_numbers(name, value, seen)),
        _ => {}
    }
}

#[test]
fn every_number_carries_its_unit() {
    let mut seen = 0;
    for (name, schema) in document()["components"]["schemas"].as_object().unwrap() {
        check_numbers(name, schema, &mut seen);
    }
    assert!(seen > 40, "only {seen} numbers");
    assert!(is_number(
        &serde_json::json!({"oneOf": [{"type": "null"}, {"$ref": "#/components/schemas/Numbers2"}]})
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
                let objects = ["position_gain_scale.", "work_offsets_mm."];
                let is_member = objects.iter().any(|object| parameter_name.starts_with(object));
                assert!(named || is_member, "{name}: {parameter_name}");
            }
        }
    }
}
