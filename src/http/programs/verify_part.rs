//! Cuts a part virtually and compares it with its nominal surface.

use axum::extract::{Request, State};
use axum::response::Response;

use super::answer::{CSV, SVG};
use super::arrival::operate;
use super::several::ProgramFile;
use crate::description::{ToSchema, operation};
use crate::http::AppState;
use crate::http::extract::Path;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::VerificationParameters;

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, KeyReused,
    BodyTooLarge, UnsupportedMediaType, InvalidRequest, ProgramFault, UnitUnknown, TooCostly,
    ResultTooLarge, Busy
);

/// Media types of the answer, the report first.
const OFFERS: &[&str] = &["application/json", SVG, CSV];

/// A program with its parameters and the part's surface in one multipart body.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes the multipart body")]
struct VerificationForm {
    /// The parameters. Without them, or with `{}`, they are in the query.
    parameters: Option<VerificationParameters>,
    /// The program.
    #[schema(value_type = String, format = Binary)]
    program: Vec<u8>,
    /// Files that the program calls, each under the name that the calls use.
    subprogram: Option<Vec<ProgramFile>>,
    /// Main program, if `program` is a zip archive of several files.
    main: Option<String>,
    /// The nominal surface as STL, binary or text; if this field is absent, it is in the parameters.
    #[schema(value_type = Option<String>, format = Binary)]
    surface: Option<Vec<u8>>,
}

/// Verify a program by virtual cutting
///
/// The cutter is swept along the program on the machine. The residual is measured along the normal at every sample of
/// the nominal surface: excess, gouges, uncut samples. The answer is the report. With `Accept: image/svg+xml` it is a
/// map of the residuals, with `text/csv` the table of all residuals. The result is stored as a job.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/verification",
    tag = "programs",
    operation_id = "verify_part",
    params(
        ("machine_id" = String, Path, description = "The machine", example = "example-ac-table"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request returns the same answer"),
    ),
    request_body(
        content(
            (String = "text/plain", example = "G90 G21 G94\nG0 X-25.000 Y0.000 Z5.000 A0.000 C0.000\nG1 Z0.000 F1000\nX25.000\nG0 Z50.000\nM30\n"),
            (VerificationForm = "multipart/form-data", example = json!({
                "parameters": {
                    "tool": {"radius_mm": 5.0},
                    "surface": {"kind": "plane", "length_mm": 40.0, "width_mm": 2.0},
                    "samples": 2000,
                    "work_offset_mm": [0.0, 0.0, 0.0]
                },
                "program": "G90 G21 G94\nG0 X-25.000 Y0.000 Z5.000 A0.000 C0.000\nG1 Z0.000 F1000\nX25.000\nG0 Z50.000\nM30\n",
            })),
        ),
        description = "The program as text/*, application/octet-stream or without a type, or a multipart form",
    ),
    responses(
        (status = 200, description = "The report, the map of the residuals, or the table of all residuals, as Accept asks",
            content((crate::wire::VerificationReport = "application/json"), (String = "image/svg+xml"), (String = "text/csv")),
            headers(
                ("Location" = String, description = "The job"),
                ("ETag" = String, description = "Tag of the answer"),
            )),
        Refusals,
    )
)]
pub(super) async fn verify_part(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    operate::<VerificationParameters>(&app, machine_id, request, OFFERS).await
}
