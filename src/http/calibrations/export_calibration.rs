//! Exports the calibrated axes to a control.

use std::num::NonZeroU16;

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use http::header::CONTENT_TYPE;
use serde::{Deserialize, Serialize};

use super::{find, measured_revision};
use crate::calibration::export::{LinuxCncFault, SiemensForm, linuxcnc, neutral, siemens};
use crate::description::{IntoParams, ToSchema, operation};
use crate::http::AppState;
use crate::http::extract::{Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::wire::Fault;

refusals!(
    Refusals: MalformedRequest, MachineNotFound, CalibrationNotFound, NotAcceptable, InvalidRequest,
    ControlDoesNotFit
);

/// The control or program that reads the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ExportFormat {
    /// Symbols of ISO 230-7, cascaded values and lines at full precision, as TOML.
    Iso230,
    /// HAL commands for the kinematics module that has these axes.
    Linuxcnc,
    /// Machine data of SINUMERIK's generic five-axis transformation.
    Siemens,
    /// The same vectors as a tool carrier.
    SiemensToolCarrier,
}

/// Format and options of the text.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct ExportQuery {
    /// The control or program that reads the text.
    #[param(inline, example = "iso230")]
    format: ExportFormat,
    /// With `linuxcnc`: radius at which the remaining error is given.
    #[param(default = 100.0)]
    radius_mm: Option<f64>,
    /// With `siemens-tool-carrier`: number of the tool carrier.
    #[param(value_type = Option<u16>, default = 1, minimum = 1)]
    tool_carrier: Option<NonZeroU16>,
}

/// Radius at which the error that a module cannot represent is given \[mm\].
const RADIUS_MM: f64 = 100.0;

/// Export a calibration run to a control
///
/// The machine with the errors of this run, as text. Each text states its sign convention, its sources, and the
/// errors that the control cannot represent.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/calibrations/{id}/export",
    tag = "calibrations",
    operation_id = "export_calibration",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("id" = String, Path, description = "The run", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ExportQuery,
    ),
    responses(
        (status = 200, description = "The text", body = String, content_type = "text/plain", example = "# location errors"),
        Refusals,
    )
)]
pub(super) async fn export_calibration(
    State(app): State<AppState>,
    Path((machine_id, id)): Path<(String, String)>,
    Query(query): Query<ExportQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["text/plain"])?;
    let run = find(&app, &machine_id, &id).await?;
    let measured = measured_revision(&app, &run).await?.document.profile;
    let applied = run
        .document
        .apply_to(&measured, &measured)
        .map_err(|_same_axes| Problem::internal(&"a profile does not fit itself"))?;
    let (_, machine) = applied
        .profile
        .into_machine()
        .map_err(|faults| Problem::invalid(ProblemType::ControlDoesNotFit, faults))?;
    let text = match query.format {
        ExportFormat::Iso230 => neutral(&machine),
        ExportFormat::Linuxcnc => {
            linuxcnc(&machine, query.radius_mm.unwrap_or(RADIUS_MM)).map_err(|faults| refused(&faults))?.text
        }
        ExportFormat::Siemens => siemens(&machine, SiemensForm::MachineData),
        ExportFormat::SiemensToolCarrier => {
            let number = query.tool_carrier.unwrap_or(NonZeroU16::MIN);
            siemens(&machine, SiemensForm::ToolCarrier(number))
        }
    };
    Ok(([(CONTENT_TYPE, "text/plain; charset=utf-8")], text).into_response())
}

/// A bad radius is a fault of the request; all other faults are limits of the control.
fn refused(faults: &[LinuxCncFault]) -> Problem {
    let of_radius = |fault: &LinuxCncFault| matches!(fault, LinuxCncFault::Radius { .. });
    let kind = if faults.iter().any(of_radius) {
        ProblemType::InvalidRequest
    } else {
        ProblemType::ControlDoesNotFit
    };
    let placed = |fault: &LinuxCncFault| {
        let pointer = if of_radius(fault) { "/radius_mm" } else { "/format" };
        Fault::new(pointer, fault.to_string())
    };
    Problem::invalid(kind, faults.iter().map(placed).collect())
}
