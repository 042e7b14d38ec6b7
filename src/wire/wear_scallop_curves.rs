//! Curves of scallop heights through the elements of a request.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::wear_scallop::Element;
use super::{ScallopAnswer, ScallopRequest};
use crate::description::ToSchema;
use crate::machine::Tool;
use crate::plot::ScallopCurve;
use crate::units::Length;
use crate::wear::{CutterPass, Surface};

/// The variable of a curve of scallop heights.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ScallopAxis {
    /// The step-over.
    #[default]
    Stepover,
    /// The tool radius.
    Radius,
}

/// Curves of one figure, and points of a curve \[count\].
const MAX_CURVES: usize = 6;
const CURVE_POINTS: u32 = 96;
const MAX_DOTS: usize = 400;
/// Most elements that a figure uses, evenly chosen \[count\].
const MAX_ELEMENTS: usize = 10_000;
/// A curve extends beyond the requested values by this share.
const BEYOND: f64 = 0.25;

impl ScallopRequest {
    /// Curves of the height \[µm\] through the elements of an answered request, with the elements as dots.
    /// Elements that differ only in the variable share a curve. If there are more curves than colours, they
    /// are chosen evenly. The number is the count of all curves.
    #[must_use]
    pub fn curves(&self, answer: &ScallopAnswer, axis: ScallopAxis) -> (Vec<ScallopCurve>, usize) {
        let step = self.count().div_ceil(MAX_ELEMENTS).max(1);
        let elements: Vec<(Element, f64)> = (0..self.count())
            .step_by(step)
            .filter_map(|index| Some((self.element(index).ok()?, answer.scallop_height_um.at(index)?)))
            .collect();
        let mut groups: Vec<([u64; 5], Vec<usize>)> = Vec::new();
        let mut places = BTreeMap::new();
        for (index, (element, _)) in elements.iter().enumerate() {
            let key = key(element, axis);
            let place = *places.entry(key).or_insert_with(|| {
                groups.push((key, Vec::new()));
                groups.len() - 1
            });
            if let Some((_, members)) = groups.get_mut(place) {
                members.push(index);
            }
        }
        let drawn = groups.len().min(MAX_CURVES);
        let chosen = (0..drawn)
            .filter_map(|k| groups.get(if drawn > 1 { k * (groups.len() - 1) / (drawn - 1) } else { 0 }));
        let curves = chosen
            .filter_map(|(_, members)| {
                let members: Vec<_> = members.iter().filter_map(|index| elements.get(*index)).collect();
                curve(&members, axis)
            })
            .collect();
        (curves, groups.len())
    }
}

/// The values that the elements of one curve have in common.
fn key(element: &Element, axis: ScallopAxis) -> [u64; 5] {
    let CutterPass { tool, lead, surface } = element.pass;
    let radius_mm = match surface {
        Surface::Flat => 0.0,
        Surface::Convex { radius } | Surface::Concave { radius } => radius.mm(),
    };
    // A ball stays a ball along its curve.
    let corner_mm = if tool.is_ball() { -1.0 } else { tool.corner_radius().mm() };
    let [tool_mm, stepover_mm] = match axis {
        ScallopAxis::Stepover => [tool.radius().mm(), 0.0],
        ScallopAxis::Radius => [0.0, element.stepover.mm()],
    };
    [tool_mm, corner_mm, lead.rad(), radius_mm, stepover_mm].map(f64::to_bits)
}

fn curve(members: &[&(Element, f64)], axis: ScallopAxis) -> Option<ScallopCurve> {
    let (first, _) = members.first()?;
    let place_mm = |element: &Element| match axis {
        ScallopAxis::Stepover => element.stepover.mm(),
        ScallopAxis::Radius => element.pass.tool.radius().mm(),
    };
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for (element, _) in members {
        least = least.min(place_mm(element));
        most = most.max(place_mm(element));
    }
    let from_mm = if axis == ScallopAxis::Stepover { 0.0 } else { least * (1.0 - BEYOND) };
    let to_mm = if most > 0.0 { most * (1.0 + BEYOND) } else { first.pass.tool.radius().mm() };
    let CutterPass { tool, lead, surface } = first.pass;
    let height_um = |place_mm: f64| {
        let place = Length::from_mm(place_mm);
        let height = match axis {
            ScallopAxis::Stepover => first.pass.height(place),
            ScallopAxis::Radius => {
                let corner = if tool.is_ball() { place } else { tool.corner_radius() };
                let tool = Tool::new(place, corner).ok()?;
                CutterPass { tool, lead, surface }.height(first.stepover)
            }
        };
        height.ok().map(Length::um)
    };
    // Points that cannot be cut are left out; they are at the ends.
    let line = (0..=CURVE_POINTS)
        .filter_map(|k| {
            let place_mm = from_mm + (to_mm - from_mm) * f64::from(k) / f64::from(CURVE_POINTS);
            Some((place_mm, height_um(place_mm)?))
        })
        .collect();
    let step = members.len().div_ceil(MAX_DOTS);
    let dots =
        members.iter().step_by(step.max(1)).map(|(element, height_um)| (place_mm(element), *height_um));
    Some(ScallopCurve { label: label(first, axis), line, dots: dots.collect() })
}

fn label(element: &Element, axis: ScallopAxis) -> String {
    let CutterPass { tool, lead, surface } = element.pass;
    let mut parts = match axis {
        ScallopAxis::Stepover => vec![format!("tool radius {} mm", tool.radius().mm())],
        ScallopAxis::Radius => vec![format!("step-over {} mm", element.stepover.mm())],
    };
    if !tool.is_ball() {
        parts.push(format!(
            "corner {} mm at {}°",
            tool.corner_radius().mm(),
            (lead.deg() * 1e3).round() / 1e3
        ));
    }
    if let Surface::Convex { radius } | Surface::Concave { radius } = surface {
        parts.push(format!("surface radius {} mm", radius.mm()));
    }
    parts.join(", ")
}
