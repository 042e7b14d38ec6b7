//! Tool poses to axis words.

use std::ops::ControlFlow;

use axum::extract::{FromRequest, Request, State};
use axum::response::Response;
use http::{HeaderName, HeaderValue};

use super::table::{self, CSV, feed, is_table, offers};
use crate::http::AppState;
use crate::http::current_machine::current_machine;
use crate::http::extract::{Json, Path, json_response};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::jobs::{InverseAnswer, InverseTask, KinematicsFault};
use crate::process::Stop;
use crate::wire::{
    InverseRequest, JointColumns, KinematicsOptions, NoParameters, Pose, PoseRows, SolvedPoses, read_query,
};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, UnreachablePose, TooCostly, ResultTooLarge, Busy
);

/// Turn tool poses into axis words
///
/// JSON, or `text/csv` with a header row both ways; the options are then query parameters, `selection=all` adds a
/// `pose` column, and the header `Trunnion-Warnings` counts the warnings.
#[utoipa::path(
    post,
    path = "/v1/machines/{machine_id}/inverse-kinematics",
    tag = "kinematics",
    operation_id = "solve_inverse_kinematics",
    params(("machine_id" = String, Path, description = "The machine", example = "example-ac-table"), KinematicsOptions),
    request_body(
        content(
            (InverseRequest = "application/json", example = json!({"poses": [{"x": 10.0, "y": 0.0, "z": 5.0, "i": 0.0, "j": -0.5, "k": 0.866}]})),
            (String = "text/csv", example = "x,y,z,i,j,k\n10,0,5,0,-0.5,0.866\n"),
        ),
        description = "Tool poses in the workpiece; i j k need not be of unit length",
    ),
    responses(
        (status = 200, description = "Axis words", content((SolvedPoses = "application/json"), (String = "text/csv"))),
        Refusals,
    )
)]
pub(super) async fn solve_inverse_kinematics(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    let table = is_table(request.headers())?;
    let kind = choose(request.headers(), offers(table))?;
    let on = current_machine(&app, &machine_id).await?;
    let revision = on.revision;
    let (poses, options) = read(&app, table, request).await?;
    let limits = app.limits();
    let csv = kind == CSV;
    let (setup, start_words_deg) = options.to_setup(&on.machine).map_err(KinematicsFault::Values)?;
    let task = InverseTask::new(on, &setup, options.selection.unwrap_or_default(), start_words_deg);
    let trifling = task.is_trifling(poses.len());
    let solve = move |stop: &Stop<'_>| {
        let answer = task.solve(&poses, limits, stop)?;
        Ok::<_, KinematicsFault>(if csv {
            let columns = JointColumns::new(task.machine(), answer.ends.is_some());
            Err((answer, columns))
        } else {
            Ok(print(revision, answer))
        })
    };
    let solved = if trifling {
        solve(&|| ControlFlow::Continue(()))
    } else {
        // Boxed: the room it takes would be part of every small request's.
        Box::pin(app.compute.run(solve)).await?
    };
    match solved? {
        Ok(text) => {
            let text = text.map_err(|fault| Problem::internal(&fault))?;
            table::within(&app, text.len() as u64)?;
            Ok(json_response(text))
        }
        Err((answer, columns)) => rows(&app, revision, answer, columns),
    }
}

fn print(machine_revision: i64, answer: InverseAnswer) -> Result<Vec<u8>, serde_json::Error> {
    let InverseAnswer { joints, ends, warnings } = answer;
    SolvedPoses::new(machine_revision, joints, ends, warnings).to_json()
}

fn rows(
    app: &AppState,
    revision: i64,
    answer: InverseAnswer,
    columns: JointColumns,
) -> Result<Response, Problem> {
    let mut header = Vec::new();
    columns.write_header(&mut header);
    let InverseAnswer { joints, ends, warnings } = answer;
    table::within(app, table::most_bytes(&header, joints.len()))?;
    let mut pose = 0;
    let mut response = table::rows(revision, header, joints, move |text, row, words| {
        if let Some(ends) = &ends {
            while ends.get(pose).is_some_and(|end| *end <= row) {
                pose += 1;
            }
        }
        columns.write_row(text, pose, words);
    });
    let name = HeaderName::from_static("trunnion-warnings");
    response.headers_mut().insert(name, HeaderValue::from(warnings.len()));
    Ok(response)
}

async fn read(
    app: &AppState,
    table: bool,
    request: Request,
) -> Result<(Vec<Pose>, KinematicsOptions), Problem> {
    let query = request.uri().query().unwrap_or_default().to_owned();
    if !table {
        let NoParameters {} = read_query(&query)?;
        let Json(document) = Json::<InverseRequest>::from_request(request, app).await?;
        let options = document.options();
        return Ok((document.poses, options));
    }
    let options = read_query(&query)?;
    let (parts, body) = request.into_parts();
    let mut rows = PoseRows::new(app.settings.max_poses);
    feed(app, &parts, body, |chunk| rows.feed(chunk)).await?;
    Ok((rows.finish()?, options))
}
