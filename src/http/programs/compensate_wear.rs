//! Compensates a program for a worn cutter.

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
use crate::wire::WearParameters;

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, KeyReused, AlreadyCompensated,
    BodyTooLarge, UnsupportedMediaType, InvalidRequest, ProgramFault, UnitUnknown, OutOfTravel, TooCostly,
    ResultTooLarge, Busy
);

/// Media types of the answer, the program first.
const OFFERS: &[&str] = &["text/plain", "application/octet-stream", "text/csv", "application/json", SVG];

/// A program with its parameters in one multipart body.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes the multipart body")]
struct WearProgramForm {
    /// The parameters. Without them, or with `{}`, they are in the query.
    parameters: Option<WearParameters>,
    /// The program.
    #[schema(value_type = String, format = Binary)]
    program: Vec<u8>,
    /// Files that the program calls, each under the name that the calls use.
    subprogram: Option<Vec<ProgramFile>>,
    /// Main program, if `program` is a zip archive of several files.
    main: Option<String>,
    /// The part's surface as STL, for `contact` `surface`.
    #[schema(value_type = Option<String>, format = Binary)]
    surface: Option<Vec<u8>>,
}

/// Compensate a program for a worn cutter
///
/// The end of every block is moved so that the worn or reground cutter touches the part where the nominal cutter
/// would. The tool axis and the rotary words stay the same. The answer is the program, with the same dialect and line
/// ends. With `Accept: application/json` it is the report, with `image/svg+xml` the plot before and after. The
/// program is written and verified before the first byte is sent, and stored as a job.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/wear-compensation",
    tag = "programs",
    operation_id = "compensate_wear_of_program",
    params(
        ("machine_id" = String, Path, description = "The machine", example = "example-ac-table"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request returns the same answer"),
    ),
    request_body(
        content(
            (String = "text/plain", example = json!(crate::http::programs::EXAMPLE_PROGRAM)),
            (WearProgramForm = "multipart/form-data", example = json!({
                "parameters": {
                    "nominal_tool": {"radius_mm": 5.0, "length_mm": 80.0},
                    "actual_tool": {"radius_mm": 4.75, "length_mm": 79.75},
                    "work_offset_mm": [12.0, -7.0, 35.0],
                    "allowed_scallop_um": 20.0, "stepover_mm": 0.85
                },
                "program": crate::http::programs::EXAMPLE_PROGRAM,
            })),
        ),
        description = "The program as text/*, application/octet-stream or without a type, or a multipart form",
    ),
    responses(
        (status = 200, description = "The program for the worn cutter, its report or its plot, as Accept asks",
            content((String = "text/plain"), (crate::wire::WearReport = "application/json"), (String = "image/svg+xml")),
            headers(
                ("Location" = String, description = "The job"),
                ("ETag" = String, description = "Tag of the answer"),
                ("Content-Disposition" = String, description = "File name of the program"),
                ("Trunnion-Motions-Checked" = i64, description = "Number of motions that were checked, moved or computed again: the largest count of one step. 0 means none"),
            )),
        Refusals,
    )
)]
pub(super) async fn compensate_wear_of_program(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    operate::<WearParameters>(&app, machine_id, request, OFFERS).await
}
