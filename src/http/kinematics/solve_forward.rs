//! Axis words to tool poses.

use std::io::Write;

use axum::extract::{FromRequest, Request, State};
use axum::response::Response;
use serde::Serialize;

use super::table::{self, CSV, feed, is_table, offers};
use crate::description::{IntoParams, ToSchema, operation};
use crate::http::AppState;
use crate::http::current_machine::current_machine;
use crate::http::extract::{Json, Path};
use crate::http::negotiate::choose;
use crate::http::printed::print_computed;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::memory::will_take;
use crate::jobs::{KinematicsFault, forward};
use crate::wire::{
    ForwardRequest, JointRows, JointWords, KinematicsOptions, LONGEST_NUMBER, Pose, read_query,
    write_in_pieces,
};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, TooCostly, ResultTooLarge, Busy
);

/// The options as query parameters, if the body is CSV.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
#[expect(dead_code, reason = "describes what the operation takes of the options of both directions")]
struct ForwardOptions {
    /// Origin of the workpiece in machine coordinates at zero pose.
    #[param(value_type = [f64], required = false, style = Form, explode = false, example = json!([0.0, 0.0, 0.0]))]
    work_offset_mm: Option<Vec<f64>>,
    /// Tool length, added along the zero-pose tool axis; it matters only for head axes.
    tool_length_mm: Option<f64>,
    /// Whether measured errors are applied.
    #[param(inline)]
    location_errors: Option<crate::wire::LocationErrors>,
}

/// Tool poses.
#[derive(Debug, Serialize, ToSchema)]
struct ForwardAnswer {
    /// Revision of the machine that was used.
    machine_revision: i64,
    /// Tool poses in the workpiece.
    poses: Vec<Pose>,
}

/// Turn axis words into tool poses
///
/// Request and answer are JSON, or `text/csv` with a header row. With CSV the options are query parameters.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/forward-kinematics",
    tag = "kinematics",
    operation_id = "solve_forward_kinematics",
    params(("machine_id" = String, Path, description = "The machine", example = "example-ac-table"), ForwardOptions),
    request_body(
        content(
            (ForwardRequest = "application/json", example = json!({"joints": [{"X": 10.0, "Y": 0.0, "Z": 5.0, "A": 30.0, "C": 45.0}]})),
            (String = "text/csv", example = "X,Y,Z,A,C\n10,0,5,30,45\n"),
        ),
        description = "Axis words",
    ),
    responses(
        (status = 200, description = "Tool poses", content((ForwardAnswer = "application/json"), (String = "text/csv"))),
        Refusals,
    )
)]
pub(super) async fn solve_forward_kinematics(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    let table = is_table(request.headers())?;
    let kind = choose(request.headers(), offers(table))?;
    let on = current_machine(&app, &machine_id).await?;
    let revision = on.revision;
    let (joints, options) = read(&app, table, request).await?;
    if options.selection.is_some() || options.start.is_some() {
        let fault = crate::wire::Fault::new(
            "/selection",
            "selection and start are only for inverse kinematics; remove them",
        );
        return Err(Problem::invalid(ProblemType::InvalidRequest, vec![fault]));
    }
    let limits = app.limits();
    let csv = kind == CSV;
    let header = Pose::CSV_HEADER.as_bytes();
    if csv {
        table::within(app.settings.max_result_bytes, table::most_bytes(header, joints.len()))?;
    }
    let most = if csv { table::most_bytes(header, joints.len()) } else { most_json_bytes(joints.len()) };
    will_take(joints.len() as u64 * size_of::<Pose>() as u64);
    let leaving = print_computed(&app, move |threads, stop, printed| {
        let (setup, _) = options.to_setup(&on.machine).map_err(KinematicsFault::Values)?;
        let poses = forward(&on.machine, &setup, &joints, limits, stop)?;
        drop(joints);
        printed.may_leave((), most);
        if csv {
            printed.write_all(header)?;
            write_in_pieces(poses.len(), threads, printed, &|rows, text| {
                poses.get(rows).unwrap_or_default().iter().for_each(|pose| pose.write_row(text));
            })?;
        } else {
            let document = ForwardAnswer { machine_revision: revision, poses };
            serde_json::to_writer(printed, &document).map_err(std::io::Error::from)?;
        }
        Ok(())
    });
    let leaving = leaving.await?;
    Ok(if csv { table::table(revision, leaving).0 } else { table::document(leaving) })
}

/// The largest length of a document with this many poses.
fn most_json_bytes(poses: usize) -> u64 {
    const POSE: u64 = r#"{"x":,"y":,"z":,"i":,"j":,"k":},"#.len() as u64 + 6 * LONGEST_NUMBER as u64;
    const AROUND: u64 = 100;
    (poses as u64).saturating_mul(POSE).saturating_add(AROUND)
}

async fn read(
    app: &AppState,
    table: bool,
    request: Request,
) -> Result<(Vec<JointWords>, KinematicsOptions), Problem> {
    let query = request.uri().query().unwrap_or_default().to_owned();
    if !table {
        table::no_options(&query)?;
        let Json(document) = Json::<ForwardRequest>::from_request(request, app).await?;
        let options = document.options();
        return Ok((document.joints, options));
    }
    let options = read_query(&query)?;
    let (parts, body) = request.into_parts();
    let mut rows = JointRows::new(app.settings.max_poses);
    feed(app, &parts, body, &mut rows).await?;
    Ok((rows.finish()?, options))
}
