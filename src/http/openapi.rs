//! The description of the interface, made from the routes themselves.

use utoipa::OpenApi;
use utoipa::openapi::{OpenApi as Document, PathItem};

use super::problem::ProblemDocument;

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
        (name = "service", description = "The service itself"),
    ),
)]
pub(super) struct Base;

/// The description with everything a strict reader asks for.
pub(super) fn completed(mut document: Document) -> Document {
    env!("CARGO_PKG_VERSION").clone_into(&mut document.info.version);
    document.servers = Some(vec![utoipa::openapi::Server::new("/")]);
    document
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

fn methods(item: &PathItem) -> impl Iterator<Item = (&'static str, &utoipa::openapi::path::Operation)> {
    let all = [("GET", &item.get), ("PUT", &item.put), ("POST", &item.post), ("DELETE", &item.delete)];
    all.into_iter().filter_map(|(method, operation)| operation.as_ref().map(|operation| (method, operation)))
}
