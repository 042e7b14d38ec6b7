//! Scallop heights between neighbouring passes.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use http::header::CONTENT_TYPE;
use serde::Deserialize;

use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Json, Query, json_response};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::jobs::scallop_heights;
use crate::plot;
use crate::plot::ScallopFigure;
use crate::wire::{ScallopAnswer, ScallopAxis, ScallopRequest};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, TooCostly, Busy
);

/// The figure to draw if the answer is a figure.
#[derive(Debug, Clone, Copy, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct ScallopPlot {
    /// With `Accept: image/svg+xml`: the variable of the figure; default the step-over.
    #[param(inline)]
    plot: Option<ScallopAxis>,
}

const SVG: &str = "image/svg+xml";

/// Compute scallop heights
///
/// The height of the scallop between neighbouring passes of a ball, bull-nose or flat cutter on a convex, concave or
/// flat surface. With `allowed_scallop_um` the answer also has the largest step-over and the smallest tool that keep
/// this height. Any number may be an array. With `Accept: image/svg+xml` the answer is a figure.
#[operation(
    post,
    path = "/v1/scallop-height",
    tag = "wear",
    operation_id = "compute_scallop_height",
    params(ScallopPlot),
    request_body(
        content((ScallopRequest = "application/json", examples(
            ("one" = (summary = "One pass beside the other", value = json!({
                "stepover_mm": 0.1, "tool_radius_mm": 5.0, "surface": "convex", "surface_radius_mm": 10.0
            }))),
            ("many" = (summary = "A worn ball at several step-overs", value = json!({
                "stepover_mm": [0.2, 0.4, 0.8], "tool_radius_mm": 4.75, "surface": "concave",
                "surface_radius_mm": 40.0, "allowed_scallop_um": 20.0
            }))),
            ("bull_nose" = (summary = "A bull-nose cutter, inclined", value = json!({
                "stepover_mm": 1.0, "tool_radius_mm": 5.0, "corner_radius_mm": 1.0, "lead_deg": 10.0,
                "surface": "flat", "allowed_scallop_um": 5.0
            }))),
        ))),
    ),
    responses(
        (status = 200, description = "Heights", content((ScallopAnswer = "application/json"), (String = "image/svg+xml"))),
        Refusals,
    )
)]
pub(super) async fn compute_scallop_height(
    State(app): State<AppState>,
    Query(ScallopPlot { plot }): Query<ScallopPlot>,
    headers: HeaderMap,
    Json(request): Json<ScallopRequest>,
) -> Result<Response, Problem> {
    let drawn = choose(&headers, &["application/json", SVG])? == SVG;
    let limits = app.limits();
    let printed = app.compute.run(move |stop| {
        let answer = scallop_heights(&request, limits, stop)?;
        Ok::<_, Problem>(if drawn {
            Ok(figure(&request, &answer, plot.unwrap_or_default()))
        } else {
            Err(serde_json::to_vec(&answer))
        })
    });
    match printed.await?? {
        Ok(svg) => Ok(([(CONTENT_TYPE, SVG)], svg).into_response()),
        Err(json) => Ok(json_response(json.map_err(|fault| Problem::internal(&fault))?)),
    }
}

fn figure(request: &ScallopRequest, answer: &ScallopAnswer, axis: ScallopAxis) -> String {
    let (curves, count) = request.curves(answer, axis);
    let left_out = if curves.len() < count {
        format!(" ({} of {count} curves drawn)", curves.len())
    } else {
        String::new()
    };
    let title = format!("Scallop height on a {} surface{left_out}", request.surface.name());
    let place = match axis {
        ScallopAxis::Stepover => "step-over [mm]",
        ScallopAxis::Radius => "tool radius [mm]",
    };
    // Heights that vary from element to element are not one line.
    let allowed_um =
        request.allowed_scallop_um.as_ref().filter(|allowed| allowed.count().is_none()).map(|one| one.at(0));
    plot::scallop_heights(&ScallopFigure { title: &title, place, curves: &curves, allowed_um })
}
