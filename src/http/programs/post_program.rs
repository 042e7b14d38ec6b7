//! Posts cutter location data to a machine.

use axum::extract::{Request, State};
use axum::response::Response;

use super::arrival::operate;
use crate::description::{ToSchema, operation};
use crate::http::AppState;
use crate::http::extract::Path;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::PostingParameters;

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, KeyReused,
    BodyTooLarge, UnsupportedMediaType, InvalidRequest, ProgramFault, UnitUnknown, OutOfTravel, TooCostly, Busy
);

/// Media types of the answer, the program first.
const OFFERS: &[&str] = &["text/plain", "application/octet-stream", "application/json"];

/// Cutter location data with its parameters in one multipart body.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes the multipart body")]
struct PostingForm {
    /// The parameters. Without them, or with `{}`, they are in the query.
    parameters: Option<PostingParameters>,
    /// The cutter location data.
    #[schema(value_type = String, format = Binary)]
    program: Vec<u8>,
}

/// Post cutter location data to a machine
///
/// APT points become an ISO program for the machine through the inverse kinematics: tool tips under G43.4, or axis
/// positions with inverse-time feed. The rotary solutions have the fewest rewinds and then the least travel. The
/// answer is the program; with `Accept: application/json` it is the report. Every block is read back and put through
/// the forward kinematics before the first byte is sent. The result is stored as a job. Post-processor statements
/// that the service understands become words, the others become comments. A change of the tool after a cut is
/// refused.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/posting",
    tag = "programs",
    operation_id = "post_program",
    params(
        ("machine_id" = String, Path, description = "The machine", example = "example-ac-table"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request returns the same answer"),
    ),
    request_body(
        content(
            (String = "text/plain", example = "PARTNO/FLANK\nUNITS/MM\nMULTAX/ON\nFEDRAT/1000.,MMPM\nRAPID\nGOTO/0.,0.,5.,0.173648,0.,0.984808\nGOTO/10.,4.,6.,0.207912,0.,0.978148\nGOTO/20.,8.,8.,0.258819,0.0,0.965926\nFINI\n"),
            (PostingForm = "multipart/form-data", example = json!({
                "parameters": {
                    "interpolation": "machine", "work_offset_mm": [0.0, 0.0, 0.0], "linear_decimals": 3, "rotary_decimals": 3
                },
                "program": "PARTNO/FLANK\nUNITS/MM\nMULTAX/ON\nFEDRAT/1000.,MMPM\nRAPID\nGOTO/0.,0.,5.,0.173648,0.,0.984808\nGOTO/10.,4.,6.,0.207912,0.,0.978148\nGOTO/20.,8.,8.,0.258819,0.0,0.965926\nFINI\n",
            })),
        ),
        description = "Cutter location data as text/*, application/octet-stream or without a type, or a multipart form",
    ),
    responses(
        (status = 200, description = "The posted program or its report, as Accept asks",
            content((String = "text/plain"), (crate::wire::PostingReport = "application/json")),
            headers(
                ("Location" = String, description = "The job"),
                ("ETag" = String, description = "Tag of the answer"),
                ("Content-Disposition" = String, description = "File name of the program"),
            )),
        Refusals,
    )
)]
pub(super) async fn post_program(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    operate::<PostingParameters>(&app, machine_id, request, OFFERS).await
}
