//! Returns the motions that the service understands in a program.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Request, State};
use axum::response::{IntoResponse, Response};
use http::HeaderValue;
use http::header::{CONTENT_DISPOSITION, CONTENT_LENGTH, CONTENT_TYPE};
use tokio_util::io::ReaderStream;

use super::answer::{CSV, stem};
use super::several::ProgramFile;
use super::upload::{Part, Upload, take};
use crate::description::{ToSchema, operation};
use crate::http::AppState;
use crate::http::current_machine::current_machine;
use crate::http::extract::Path;
use crate::http::file_body::CHUNK;
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::jobs::{InterpretationForm, interpret};
use crate::wire::InterpretationParameters;

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, ProgramFault, UnitUnknown, TooCostly, ResultTooLarge, Busy
);

/// Media types of the answer.
const OFFERS: &[&str] = &["application/json", CSV];

/// A program with its parameters in one multipart body.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes the multipart body")]
struct InterpretationUpload {
    /// The parameters. Without them, or with `{}`, they are in the query.
    parameters: Option<InterpretationParameters>,
    /// The program.
    #[schema(value_type = String, format = Binary)]
    program: Vec<u8>,
    /// Files that the program calls, each under the name that the calls use.
    subprogram: Option<Vec<ProgramFile>>,
    /// Main program, if `program` is a zip archive of several files.
    main: Option<String>,
}

/// Interpret a program
///
/// Returns every motion that the service understands: the words at its end, the position of the tip and the direction
/// of the tool in the workpiece, feed, tool and work offset. It also returns the motions that a compensation leaves
/// unchanged, with the reason. Nothing is changed or stored. With `Accept: text/csv` the answer is a table of the
/// motions.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/interpretation",
    tag = "programs",
    operation_id = "interpret_program",
    params(("machine_id" = String, Path, description = "The machine", example = "example-ac-table")),
    request_body(
        content(
            (String = "text/plain", example = "G90 G21 G94\nG54\nT5 M6\nG0 X10.000 Y0.000 Z5.000 A0.000 C0.000\nG1 X20.000 A25.000 C60.000 F1000\nM30\n"),
            (InterpretationUpload = "multipart/form-data", example = json!({
                "parameters": {"work_offset_mm": [0.0, 0.0, 0.0]},
                "program": "G90 G21 G94\nG54\nT5 M6\nG0 X10.000 Y0.000 Z5.000 A0.000 C0.000\nG1 X20.000 A25.000 C60.000 F1000\nM30\n",
            })),
        ),
        description = "The program as text/*, application/octet-stream or without a type, or a multipart form",
    ),
    responses(
        (status = 200, description = "The interpretation, or the motions as a table, as Accept asks",
            headers(("Trunnion-Motions-Left-Alone" = i64, description = "Number of motions that the service does not understand; the table leaves them out")),
            content((crate::wire::InterpretationAnswer = "application/json"), (String = "text/csv"))),
        Refusals,
    )
)]
pub(super) async fn interpret_program(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    let kind = choose(request.headers(), OFFERS)?;
    let form = if kind == CSV { InterpretationForm::Table } else { InterpretationForm::Json };
    let (parts, body) = request.into_parts();
    let on = current_machine(&app, &machine_id).await?;
    let Upload { program, file_name, parameters, .. }: Upload<InterpretationParameters> =
        take(&app, &parts, body, Part::Unseen).await?;
    let on = Arc::unwrap_or_clone(on);
    let (answer, left_alone) =
        Box::pin(interpret(&app.compute, &app.spool, &app.means(), on, parameters, program, form)).await?;
    let file = tokio::fs::File::open(answer.path()).await?;
    let mut response = Body::from_stream(ReaderStream::with_capacity(file, CHUNK)).into_response();
    let headers = response.headers_mut();
    headers
        .insert(CONTENT_TYPE, HeaderValue::from_static(if kind == CSV { CSV } else { "application/json" }));
    headers.insert("Trunnion-Motions-Left-Alone", HeaderValue::from(left_alone));
    headers.insert(CONTENT_LENGTH, HeaderValue::from(answer.length()));
    if kind == CSV {
        let disposition = format!("attachment; filename=\"{}-interpretation.csv\"", stem(&file_name));
        if let Ok(value) = HeaderValue::try_from(disposition) {
            headers.insert(CONTENT_DISPOSITION, value);
        }
    }
    Ok(response)
}
