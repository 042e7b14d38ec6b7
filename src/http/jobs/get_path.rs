//! Returns the path of a job's program with its errors before and after.

use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::header::{CONTENT_LENGTH, CONTENT_TYPE};
use http::{HeaderMap, HeaderValue};
use serde::Deserialize;
use tokio_util::io::ReaderStream;

use super::find;
use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Path, Query};
use crate::http::file_body::CHUNK;
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::programs::answer::{CSV, without_result};
use crate::http::refusals::refusals;
use crate::jobs::job_path;
use crate::wire::{Fault, JobState};

refusals!(
    Refusals: MalformedRequest, JobNotFound, ResultNotFound, JobNotSucceeded, NotAcceptable, RequestTimeout, InvalidRequest,
    ProgramFault, TooCostly, ResultTooLarge, Busy
);

const POSES: std::ops::RangeInclusive<usize> = 2..=100_000;
const USUAL_POSES: usize = 20_000;

/// The level of detail.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields, default)]
#[into_params(parameter_in = Query)]
pub(super) struct PathQuery {
    /// Largest number of poses. A longer path gets one row for 2, 4, 8 … rows.
    #[param(minimum = 2, maximum = 100_000, default = 20_000)]
    poses: Option<usize>,
}

/// Read the path of a job's program
///
/// One row for the end of every motion of the uploaded program, in its order: the words of the axes, the tip and the
/// tool axis in the workpiece on the nominal machine, and the error before and after. In a long program a row stands
/// for several motions: it has the end of the last one and the largest errors. An arc also
/// has rows along its course: one at least every 5 degrees, at most 20 000. The errors are those of the report's series; they are empty for rapids, and if the operation corrects nothing. Motions
/// whose place is not known are left out.
#[operation(
    get,
    path = "/v1/jobs/{id}/path",
    tag = "jobs",
    operation_id = "get_job_path",
    params(("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"), PathQuery),
    responses(
        (status = 200, description = "The table", body = String, content_type = "text/csv",
            headers(("Trunnion-Motions-Per-Pose" = i64, description = "Number of motions, or pieces of arcs, that a row stands for at most")),
            example = "line,kind,X,Y,Z,A,C,tip_x_mm,tip_y_mm,tip_z_mm,axis_i,axis_j,axis_k,before_um,after_um\n6,rapid,-20.9,-0.6,-4.6,-21.0,31.0,-21.6,5.7,-3.9,-0.184,0.307,0.934,,\n7,linear,-19.0,-1.3,-4.9,-21.8,28.8,-19.8,6.7,-3.9,-0.179,0.325,0.928,18.1,4.5\n"),
        Refusals,
    )
)]
pub(super) async fn get_job_path(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(PathQuery { poses }): Query<PathQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &[CSV])?;
    let most = poses.unwrap_or(USUAL_POSES);
    if !POSES.contains(&most) {
        let detail = format!("poses must be from {} to {}", POSES.start(), POSES.end());
        return Err(Problem::invalid(ProblemType::InvalidRequest, vec![Fault::new("/poses", detail)]));
    }
    let job = find(&app, &id).await?;
    if job.document.state != JobState::Succeeded {
        return Err(without_result(&job, "path"));
    }
    let (answer, together) =
        Box::pin(job_path(&app.compute, &app.spool, &app.store, &app.means(), &job, most)).await?;
    let file = tokio::fs::File::open(answer.path()).await?;
    let mut response = Body::from_stream(ReaderStream::with_capacity(file, CHUNK)).into_response();
    let given = response.headers_mut();
    given.insert(CONTENT_TYPE, HeaderValue::from_static(CSV));
    given.insert(CONTENT_LENGTH, HeaderValue::from(answer.length()));
    given.insert("Trunnion-Motions-Per-Pose", HeaderValue::from(together));
    Ok(response)
}
