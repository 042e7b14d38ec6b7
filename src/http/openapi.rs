//! The description of the interface, made from the routes themselves.

use utoipa::OpenApi;
use utoipa::openapi::path::Operation;
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme};
use utoipa::openapi::{OpenApi as Document, PathItem};

use super::access::{Need, needed};
use super::problem::{ProblemDocument, ProblemType};
use super::refusals::responses;
use super::webhooks::describe;

/// What no route says.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "Trunnion",
        description = "Kinematics, NC program compensation, servo simulation, tool wear and calibration for five-axis machine tools. Lengths are mm and angles degrees unless a name says otherwise; tool poses are x y z i j k, NC words X Y Z A B C. Every refusal is an RFC 9457 problem document.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0"),
    ),
    components(schemas(ProblemDocument)),
    tags(
        (name = "machines", description = "Machine profiles as immutable revisions"),
        (name = "kinematics", description = "Tool poses to axis words and back"),
        (name = "programs", description = "NC programs in, compensated programs out"),
        (name = "servo", description = "What loop gains and feed do to the part"),
        (name = "wear", description = "What a worn cutter leaves, and what to do about it"),
        (name = "calibrations", description = "Where the rotary axes really are, from measured runs"),
        (name = "jobs", description = "Everything that was computed, with its report and its program"),
        (name = "webhooks", description = "The ends of jobs, told to who posted them and signed"),
        (name = "keys", description = "Who may do what, and who did what"),
        (name = "service", description = "The service itself"),
    ),
)]
pub(super) struct Base;

/// The description with everything a strict reader asks for.
pub(super) fn completed(mut document: Document) -> Document {
    env!("CARGO_PKG_VERSION").clone_into(&mut document.info.version);
    document.servers = Some(vec![utoipa::openapi::Server::new("/")]);
    guarded(&mut document);
    describe(&mut document);
    document
}

/// Name of the way in which keys are sent.
const SCHEME: &str = "api_key";

/// Says of every operation which scope it needs, and what it answers who does not have it.
fn guarded(document: &mut Document) {
    let words = "An API key, `trn_…`, with the scope that each operation names. A service for which no key was ever made is open and asks for none.";
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

/// The description of the interface.
#[must_use]
pub fn document() -> Document {
    super::router::described().1
}

/// One line for each operation: method, path, id.
#[must_use]
pub fn operations() -> String {
    let document = document();
    let mut lines: Vec<String> =
        all(&document).map(|(method, path, id)| format!("{method:6} {path:58} {id}")).collect();
    lines.sort_by(|a, b| a.get(7..).cmp(&b.get(7..)));
    lines.join("\n") + "\n"
}

/// Every operation: method, pattern of the path, id.
pub(super) fn all(document: &Document) -> impl Iterator<Item = (&'static str, &str, &str)> {
    document.paths.paths.iter().flat_map(|(path, item)| {
        methods(item).map(|(method, operation)| {
            (method, path.as_str(), operation.operation_id.as_deref().unwrap_or("?"))
        })
    })
}

fn methods(item: &PathItem) -> impl Iterator<Item = (&'static str, &Operation)> {
    let all = [("GET", &item.get), ("PUT", &item.put), ("POST", &item.post), ("DELETE", &item.delete)];
    all.into_iter().filter_map(|(method, operation)| operation.as_ref().map(|operation| (method, operation)))
}

fn methods_mut(item: &mut PathItem) -> impl Iterator<Item = (&'static str, &mut Operation)> {
    let PathItem { get, put, post, delete, .. } = item;
    let all = [("GET", get), ("PUT", put), ("POST", post), ("DELETE", delete)];
    all.into_iter().filter_map(|(method, operation)| operation.as_mut().map(|operation| (method, operation)))
}
