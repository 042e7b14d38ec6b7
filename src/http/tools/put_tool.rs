//! Stores a tool: new, or as a new revision.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::header::LOCATION;
use http::{HeaderMap, StatusCode};

use crate::description::operation;
use crate::http::AppState;
use crate::http::author::By;
use crate::http::conditional::{expected, stale_tool, tagged, tool_tag};
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::store::{NewTool, PutTool, ToolRefusal};
use crate::wire::{Fault, FaultList, NoParameters, TableTool, check_name, path_segment};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, ToolNameTaken,
    ToolTableFull, PreconditionFailed, PreconditionRequired, BodyTooLarge, UnsupportedMediaType, InvalidRequest, Busy
);

/// Store a tool
///
/// A new id adds a tool to the machine's table (201). An existing tool gets a new revision (200) and needs `If-Match`
/// with the `ETag` of the revision that you read. An identical tool keeps the same revision. `If-None-Match: *`
/// refuses to replace a tool. Programs call a tool by its number or its name, so two tools of a machine cannot share
/// one; upper and lower case of names count as the same.
#[operation(
    put,
    path = "/v1/machines/{machine_id}/tools/{tool_id}",
    tag = "tools",
    operation_id = "put_tool",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client; its wear entries use the same id", example = "T12"),
        ("If-Match" = Option<String>, Header, description = "ETag of the revision to replace"),
        ("If-None-Match" = Option<String>, Header, description = "`*`: store only a new tool"),
    ),
    request_body(content = TableTool, description = "The tool", example = json!({
        "number": 12, "name": "BALL_10", "kind": "ball", "radius_mm": 5.0, "length_mm": 92.4
    })),
    responses(
        (status = 201, description = "The new tool", body = crate::wire::ToolDocument,
            headers(("ETag" = String, description = "Tag of the revision"), ("Location" = String, description = "The tool"))),
        (status = 200, description = "A new revision, or the same for an identical tool", body = crate::wire::ToolDocument,
            headers(("ETag" = String, description = "Tag of the revision"))),
        Refusals,
    )
)]
pub(super) async fn put_tool(
    State(app): State<AppState>,
    Path((machine_id, tool_id)): Path<(String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
    By(actor): By,
    Json(tool): Json<TableTool>,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    let expected = expected(&headers)?;
    let tool = checked(&tool_id, tool)?;
    let created_at = app.sources.timestamp();
    let new = NewTool { machine_id: machine_id.clone(), tool_id: tool_id.clone(), tool, created_at };
    let put = app.store.put_tool(new, expected, app.settings.max_tools_per_machine, &actor).await?;
    match put.map_err(|refusal| refused(refusal, &machine_id, &tool_id))? {
        PutTool::Created(stored) => {
            let place = format!("/v1/machines/{machine_id}/tools/{}", path_segment(&tool_id));
            Ok(tagged(&tool_tag(&stored), (StatusCode::CREATED, [(LOCATION, place)], Json(stored.document))))
        }
        PutTool::Replaced(stored) => Ok(tagged(&tool_tag(&stored), Json(stored.document).into_response())),
    }
}

/// The tool as it will be stored.
fn checked(tool_id: &str, tool: TableTool) -> Result<TableTool, Problem> {
    let mut faults = FaultList::default();
    check_name(|| "/tool_id".to_owned(), tool_id, &mut faults);
    let tool = tool.normalised(&mut faults);
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    Ok(tool)
}

fn refused(refusal: ToolRefusal, machine_id: &str, tool_id: &str) -> Problem {
    match refusal {
        ToolRefusal::Stale(reason) => stale_tool(reason, tool_id),
        ToolRefusal::NoMachine => Problem::machine_not_found(machine_id),
        ToolRefusal::Taken { number, name } => {
            let fault = |pointer: &str, other: String| {
                let detail = format!(
                    "tool {other:?} of this machine already has this {}",
                    pointer.trim_start_matches('/')
                );
                Fault::new(pointer, detail)
            };
            let number = number.map(|other| fault("/number", other));
            let name = name.map(|other| fault("/name", other));
            Problem::invalid(ProblemType::ToolNameTaken, number.into_iter().chain(name).collect())
        }
        ToolRefusal::Full { tools } => {
            let detail = format!(
                "machine {machine_id:?} has {tools} tools, which is the limit (max_tools_per_machine). Delete tools that are no longer used, or raise the limit"
            );
            Problem::new(ProblemType::ToolTableFull, detail)
        }
    }
}
