//! The description of the interface. Only tests make it; the binary has the committed one. It is made from the routes
//! and converted to a form that strict readers and client generators accept.

mod answers;
mod general_refusals;
mod members;
mod names;
mod parameters;
mod parts;
mod schemas;
mod shared;
mod tests;
mod values;

use serde_json::{Map, Value, json};
use utoipa::OpenApi;
use utoipa::openapi::path::Operation;
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme};
use utoipa::openapi::{OpenApi as Document, PathItem};

use super::access::{Need, needed};
use super::problem::{ProblemDocument, ProblemType};
use super::refusals::responses;
use super::webhooks::describe_messages;

/// The parts of the description that no route states.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "Trunnion",
        description = "Kinematics, NC program compensation, servo simulation, tool wear and calibration for five-axis machine tools. Lengths are in mm and angles in degrees unless a name states another unit; tool poses are x y z i j k, NC words X Y Z A B C. Every refusal is an RFC 9457 problem document. The examples of answers are real answers to the examples of requests, shortened: lists to one or two items, axes to two, long texts to their beginning, numbers to four digits, and without members that are null. In a request, leave out a member that has no value.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0"),
    ),
    components(schemas(ProblemDocument)),
    tags(
        (name = "machines", description = "Machine profiles as immutable revisions"),
        (name = "tools", description = "The tool table of a machine: number or name, radius, corner radius and length"),
        (name = "kinematics", description = "Tool poses to axis words and back"),
        (name = "programs", description = "Compensation, verification and posting of NC programs"),
        (name = "servo", description = "Effect of loop gains and feed on the part"),
        (name = "wear", description = "Scallops, wear entries, and advice for worn cutters"),
        (name = "calibrations", description = "Location errors of the rotary axes from measured runs"),
        (name = "jobs", description = "Computations, with their reports and programs"),
        (name = "webhooks", description = "Signed messages to your system when a job ends"),
        (name = "keys", description = "API keys and the audit log"),
        (name = "service", description = "The service itself"),
    ),
)]
pub(super) struct Base;

/// The description with the parts that the routes do not state.
pub(super) fn completed(mut document: Document) -> Document {
    env!("CARGO_PKG_VERSION").clone_into(&mut document.info.version);
    document.servers = Some(vec![utoipa::openapi::Server::new("/")]);
    guarded(&mut document);
    describe_messages(&mut document);
    document
}

/// The published description: `completed` in a form that strict readers and client generators accept, with the
/// service's own answers as examples.
pub(super) fn published(document: &Document) -> Value {
    let mut document = serde_json::to_value(document).unwrap_or_default();
    schemas::bound_unsigned(&mut document);
    let Some(Value::Object(mut schemas)) = document.pointer_mut("/components/schemas").map(Value::take)
    else {
        return document;
    };
    schemas::mend(&mut schemas);
    let answers = answers::all();
    for operation in operations_mut(&mut document) {
        parameters::mend(operation, &schemas);
        describe_forms(operation, &mut schemas);
        answers::insert(operation, &answers);
    }
    schemas::prune(&document, &mut schemas);
    if let Some(place) = document.pointer_mut("/components/schemas") {
        *place = Value::Object(schemas);
    }
    values::mend(&mut document);
    names::rename(&mut document);
    members::share(&mut document);
    shared::share(&mut document);
    document
}

/// A part of the document that is longer than a line has a line for each of its members \[bytes\].
const LINE: usize = 320;

/// The document as text: without blanks, so that it is short, and in lines, so that a change shows where it is.
fn in_lines(value: &Value, into: &mut String) {
    let whole = value.to_string();
    match value {
        Value::Object(members) if whole.len() > LINE => {
            into.push_str("{\n");
            for (index, (name, member)) in members.iter().enumerate() {
                into.push_str(if index == 0 { "" } else { ",\n" });
                into.push_str(&Value::from(name.as_str()).to_string());
                into.push(':');
                in_lines(member, into);
            }
            into.push_str("\n}");
        }
        Value::Array(items) if whole.len() > LINE => {
            into.push_str("[\n");
            for (index, item) in items.iter().enumerate() {
                into.push_str(if index == 0 { "" } else { ",\n" });
                in_lines(item, into);
            }
            into.push_str("\n]");
        }
        _ => into.push_str(&whole),
    }
}

fn operations_mut(document: &mut Value) -> impl Iterator<Item = &mut Map<String, Value>> {
    let paths = document.get_mut("paths").and_then(Value::as_object_mut);
    let items = paths.into_iter().flat_map(|paths| paths.values_mut().filter_map(Value::as_object_mut));
    items.flat_map(|item| item.values_mut().filter_map(Value::as_object_mut))
}

/// Whether a response with this status is a problem document.
fn is_refusal(status: &str) -> bool {
    status.starts_with(['4', '5']) || status == "default"
}

fn each_operation(document: &mut Value, mut visit: impl FnMut(&mut Map<String, Value>, &str)) {
    for operation in operations_mut(document) {
        let id = operation.get("operationId").and_then(Value::as_str).unwrap_or_default().to_owned();
        visit(operation, &id);
    }
}

/// Fields of a form are left out instead of null, have their own media types, and there are no other fields. Pages in
/// a browser fill a field in with its own example: the parameters are in the query there, with an input for each.
fn describe_forms(operation: &mut Map<String, Value>, schemas: &mut Map<String, Value>) {
    let contents = operation.get_mut("requestBody").and_then(|body| body.get_mut("content"));
    let Some(Value::Object(form)) = contents.and_then(|all| all.get_mut("multipart/form-data")) else {
        return;
    };
    let name = form.get("schema").and_then(|schema| schema.get("$ref")).and_then(Value::as_str);
    let name = name.and_then(|name| name.strip_prefix(schemas::SCHEMAS)).unwrap_or_default();
    let Some(Value::Object(schema)) = schemas.get_mut(name) else { return };
    schema.insert("additionalProperties".to_owned(), json!(false));
    let Some(Value::Object(fields)) = schema.get_mut("properties") else { return };
    let examples = form.get("example").cloned().unwrap_or_default();
    let mut encoding = Map::new();
    for (field, schema) in fields {
        parameters::without_null(schema);
        let is_file = schema.get("format").is_some_and(|format| format == "binary");
        let is_text = !is_file && schema.get("type").is_some_and(|kind| kind == "string");
        let kind = match (is_file, is_text) {
            (true, _) => "application/octet-stream, text/plain",
            (_, true) => "text/plain",
            _ => "application/json",
        };
        encoding.insert(field.clone(), json!({ "contentType": kind }));
        let example = match field.as_str() {
            "parameters" => Some(&json!({})),
            // The service takes an empty part for a part that is not there.
            _ if is_text => Some(&json!("")),
            _ => examples.get(field),
        };
        if let (false, Some(example), Some(schema)) = (is_file, example, schema.as_object_mut()) {
            schema.insert("example".to_owned(), example.clone());
        }
    }
    form.insert("encoding".to_owned(), Value::Object(encoding));
}

/// Name of the security scheme for API keys.
const SCHEME: &str = "api_key";

/// Adds to every operation the scope that it needs, and the answers to a caller without it.
fn guarded(document: &mut Document) {
    let words = "An API key, `trn_…`, with the scope that each operation names. A service for which no key was ever created is open and asks for none.";
    let bearer = HttpBuilder::new().scheme(HttpAuthScheme::Bearer).description(Some(words)).build();
    let components = document.components.get_or_insert_default();
    components.add_security_scheme(SCHEME, SecurityScheme::Http(bearer));
    for (path, item) in &mut document.paths.paths {
        for (method, operation) in methods_mut(item) {
            let Need::Scope(scope) = needed(method, path) else {
                operation.security = Some(Vec::new());
                continue;
            };
            operation.security = Some(vec![SecurityRequirement::new(SCHEME, [scope.as_str()])]);
            let mut kinds =
                vec![ProblemType::Unauthenticated, ProblemType::ScopeMissing, ProblemType::ForeignPage];
            if (method, path.as_str()) == ("PUT", "/v1/machines/{machine_id}") {
                kinds.push(ProblemType::MachineNotAllowed);
            }
            operation.responses.responses.extend(responses(&kinds));
        }
    }
}

fn methods_mut(item: &mut PathItem) -> impl Iterator<Item = (&'static str, &mut Operation)> {
    let PathItem { get, put, post, delete, .. } = item;
    let all = [("GET", get), ("PUT", put), ("POST", post), ("DELETE", delete)];
    all.into_iter().filter_map(|(method, operation)| operation.as_mut().map(|operation| (method, operation)))
}
