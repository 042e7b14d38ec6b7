//! Advice for a worn cutter.

use http::HeaderMap;

use crate::description::operation;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::wire::{NoParameters, WearAdviceAnswer, WearAdviceRequest};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest
);

/// Advise on a worn cutter
///
/// The advice is to keep the program, to compensate it, to reduce the step-over, or to change the tool. It is the
/// cheapest action that keeps the allowed height. The answer has the predicted residual before and after.
#[operation(
    post,
    path = "/v1/wear-advice",
    tag = "wear",
    operation_id = "advise_wear",
    request_body(
        content((WearAdviceRequest = "application/json", examples(
            ("ball" = (summary = "A ball worn by five per cent", value = json!({
                "nominal_tool": {"radius_mm": 5.0}, "actual_tool": {"radius_mm": 4.75},
                "stepover_mm": 0.85, "surface": "flat", "allowed_scallop_um": 20.0
            }))),
            ("bull_nose" = (summary = "A bull-nose cutter, shorter too, on a known range of contacts", value = json!({
                "nominal_tool": {"radius_mm": 5.0, "corner_radius_mm": 1.0, "length_mm": 80.0},
                "actual_tool": {"radius_mm": 4.95, "corner_radius_mm": 0.95, "length_mm": 79.98},
                "stepover_mm": 1.2, "surface": "convex", "surface_radius_mm": 60.0, "lead_deg": 5.0,
                "contact_angle_deg": [5.0, 12.0], "allowed_scallop_um": 15.0, "min_stepover_mm": 1.0
            }))),
        ))),
    ),
    responses((status = 200, description = "Advice", body = WearAdviceAnswer), Refusals)
)]
pub(super) async fn advise_wear(
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
    Json(request): Json<WearAdviceRequest>,
) -> Result<Json<WearAdviceAnswer>, Problem> {
    choose(&headers, &["application/json"])?;
    let answer = request.solve().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    Ok(Json(answer))
}
