//! The explanation of a problem, as a page for people.

use axum::response::Html;

use crate::description::operation;
use crate::http::extract::Path;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;

refusals!(Refusals: MalformedRequest, NotFound);

/// List all problems
///
/// A page with every `type` that a problem document can have.
#[operation(
    get,
    path = "/problems",
    tag = "service",
    operation_id = "list_problems",
    responses((status = 200, description = "A page", body = String, content_type = "text/html", example = "<!doctype html>"), Refusals)
)]
pub(super) async fn list_problems() -> Html<String> {
    let mut rows = String::new();
    for kind in ProblemType::ALL {
        let (status, code, title, _) = kind.entry();
        let row = [
            "<li><a href=\"/problems/",
            code,
            "\">",
            code,
            "</a> (",
            status.as_str(),
            ") — ",
            title,
            "</li>\n",
        ];
        rows.extend(row);
    }
    page("Problems", &format!("<ul>\n{rows}</ul>"))
}

/// Explain one problem
///
/// The page that a problem document's `type` refers to.
#[operation(
    get,
    path = "/problems/{code}",
    tag = "service",
    operation_id = "get_problem",
    params(("code" = String, Path, description = "Last part of the problem's type", example = "too-costly")),
    responses((status = 200, description = "A page", body = String, content_type = "text/html", example = "<!doctype html>"), Refusals)
)]
pub(super) async fn get_problem(Path(code): Path<String>) -> Result<Html<String>, Problem> {
    let kind = ProblemType::from_code(&code)
        .ok_or_else(|| Problem::new(ProblemType::NotFound, format!("there is no problem {code:?}")))?;
    let (status, code, title, doc) = kind.entry();
    let body = format!("<p>{doc}</p>\n<p>Status {status}, type <code>/problems/{code}</code></p>");
    Ok(page(title, &body))
}

fn page(title: &str, body: &str) -> Html<String> {
    Html(format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>{title}</title>\n<h1>{title}</h1>\n{body}\n</html>\n"
    ))
}
