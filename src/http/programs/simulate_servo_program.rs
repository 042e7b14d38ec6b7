//! Simulates the servo drives along a program.

use axum::extract::{Request, State};
use axum::response::Response;

use super::answer::SVG;
use super::arrival::operate;
use super::several::ProgramFile;
use crate::description::{ToSchema, operation};
use crate::http::AppState;
use crate::http::extract::Path;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::ServoProgramParameters;

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, KeyReused,
    BodyTooLarge, UnsupportedMediaType, InvalidRequest, ProgramFault, UnitUnknown, UnreachablePose, UnstableLoop, TooCostly, Busy
);

/// Media types of the answer.
const OFFERS: &[&str] = &["application/json", SVG];

/// A program with its parameters in one multipart body.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes the multipart body")]
struct ServoProgramForm {
    /// The parameters. Without them, or with `{}`, they are in the query.
    parameters: Option<ServoProgramParameters>,
    /// The program.
    #[schema(value_type = String, format = Binary)]
    program: Vec<u8>,
    /// Files that the program calls, each under the name that the calls use.
    subprogram: Option<Vec<ProgramFile>>,
    /// Main program, if `program` is a zip archive of several files.
    main: Option<String>,
}

/// Simulate the servo drives along a program
///
/// Contour error of tool tip and tool axis along the program's motions at feed, with the machine's kinematics and the
/// drives of its profile. The answer is the report; with `Accept: image/svg+xml` it is a plot of the contour error
/// over time. The result is stored as a job.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/servo-simulation",
    tag = "servo",
    operation_id = "simulate_servo_program",
    params(
        ("machine_id" = String, Path, description = "The machine", example = "example-ac-table"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request returns the same answer"),
    ),
    request_body(
        content(
            (String = "text/plain", example = json!(crate::http::programs::EXAMPLE_PROGRAM)),
            (ServoProgramForm = "multipart/form-data", example = json!({
                "parameters": {"work_offset_mm": [12.0, -7.0, 35.0]},
                "program": crate::http::programs::EXAMPLE_PROGRAM,
            })),
        ),
        description = "The program as text/*, application/octet-stream or without a type, or a multipart form",
    ),
    responses(
        (status = 200, description = "The report or its plot, as Accept asks",
            content((crate::wire::ServoReport = "application/json"), (String = "image/svg+xml")),
            headers(
                ("Location" = String, description = "The job"),
                ("ETag" = String, description = "Tag of the answer"),
            )),
        Refusals,
    )
)]
pub(super) async fn simulate_servo_program(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    operate::<ServoProgramParameters>(&app, machine_id, request, OFFERS).await
}
