//! Scallop heights: the request has single numbers or arrays, and the answer has the same form.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::{Answers, Fault, FaultList, Numbers};
use crate::description::ToSchema;
use crate::machine::{Tool, ToolFault};
use crate::units::{Angle, Length};
use crate::wear::{CutterPass, LEAD_RANGE_DEG, PassFault, ScallopQuantity, Surface};

/// Form of the surface across the feed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum SurfaceKind {
    /// The surface bulges toward the tool.
    Convex,
    /// The surface is hollow; its radius is not smaller than the tool's.
    Concave,
    /// The surface has no curvature.
    Flat,
}

impl SurfaceKind {
    /// The surface with this radius of curvature.
    #[must_use]
    pub fn with_radius(self, radius: Length) -> Surface {
        match self {
            Self::Flat => Surface::Flat,
            Self::Convex => Surface::Convex { radius },
            Self::Concave => Surface::Concave { radius },
        }
    }

    /// The word in the contract.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Convex => "convex",
            Self::Concave => "concave",
        }
    }
}

/// Neighbouring passes of a cutter. Every number may be an array: all arrays have the same length, and a
/// single number is used for every element.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ScallopRequest {
    /// Chord between neighbouring contact points on the surface.
    pub stepover_mm: Numbers,
    /// Radius of the ball, or of the cutter.
    pub tool_radius_mm: Numbers,
    /// Corner radius of a bull-nose cutter, 0 for a flat cutter; if it is absent, the cutter is a ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_radius_mm: Option<Numbers>,
    /// Inclination of the tool axis in the feed direction; needed if the cutter is not a ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lead_deg: Option<Numbers>,
    /// Form of the surface across the feed.
    pub surface: SurfaceKind,
    /// Radius of the surface's normal curvature across the feed; leave it out for a flat surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_radius_mm: Option<Numbers>,
    /// Allowed height. If it is given, the answer also has the largest step-over and the smallest tool.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allowed_scallop_um: Option<Numbers>,
}

/// The scallop that the passes leave.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ScallopAnswer {
    /// Height of the scallop between neighbouring passes, above the surface.
    pub scallop_height_um: Answers,
    /// Radius with which the cutter cuts across the feed; only if a corner radius was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_radius_mm: Option<Answers>,
    /// Largest step-over that keeps the allowed height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_stepover_mm: Option<Answers>,
    /// Smallest cutter radius that keeps the allowed height at this step-over, with the same corner radius
    /// and lead angle; null if no cutter does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_tool_radius_mm: Option<Answers>,
}

/// The members with their names in the contract.
const STEPOVER: &str = "stepover_mm";
const TOOL_RADIUS: &str = "tool_radius_mm";
const CORNER_RADIUS: &str = "corner_radius_mm";
const LEAD: &str = "lead_deg";
const SURFACE_RADIUS: &str = "surface_radius_mm";
const ALLOWED: &str = "allowed_scallop_um";

/// Ranges that are accepted: lengths from a nanometre, and surface radii up to a practically flat surface.
/// \[mm\]
const STEPOVER_RANGE_MM: [f64; 2] = [0.0, 1e6];
const SURFACE_RANGE_MM: [f64; 2] = [1e-6, 1e9];
/// Accepted values of the allowed height \[µm\].
const ALLOWED_RANGE_UM: [f64; 2] = [0.0, 1e9];

/// One element of a request.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element {
    pub(super) pass: CutterPass,
    pub(super) stepover: Length,
}

impl ScallopRequest {
    /// The number of elements; 1 without arrays.
    #[must_use]
    pub fn count(&self) -> usize {
        self.members().filter_map(|(_, numbers)| numbers.count()).max().unwrap_or(1)
    }

    fn members(&self) -> impl Iterator<Item = (&'static str, &Numbers)> {
        let always = [(STEPOVER, &self.stepover_mm), (TOOL_RADIUS, &self.tool_radius_mm)];
        let perhaps = [
            (CORNER_RADIUS, &self.corner_radius_mm),
            (LEAD, &self.lead_deg),
            (SURFACE_RADIUS, &self.surface_radius_mm),
            (ALLOWED, &self.allowed_scallop_um),
        ];
        always
            .into_iter()
            .chain(perhaps.into_iter().filter_map(|(name, numbers)| Some((name, numbers.as_ref()?))))
    }

    /// Computes every height, and the largest step-overs and smallest tools if a height is allowed. `stop` is
    /// called from time to time.
    ///
    /// # Errors
    /// Every bad element; no fault if it was stopped.
    pub fn solve(&self, stop: &dyn Fn() -> ControlFlow<()>) -> Result<Option<ScallopAnswer>, Vec<Fault>> {
        let mut faults = FaultList::default();
        self.check_form(&mut faults);
        if !faults.is_empty() {
            return Err(faults.into_result().err().unwrap_or_default());
        }
        self.check_ranges(&mut faults);
        let count = self.count();
        let [mut heights, mut radii, mut stepovers, mut tools] = [const { Vec::new() }; 4];
        let (corners, allowed) = (self.corner_radius_mm.is_some(), self.allowed_scallop_um.is_some());
        let mut said = false;
        for index in 0..count {
            if index % 4096 == 0 && stop().is_break() {
                return Ok(None);
            }
            if !self.is_in_range(index) {
                continue;
            }
            match self.element(index).and_then(|element| self.answer(index, &element)) {
                Ok([height, radius, stepover, tool]) => {
                    heights.push(height);
                    if corners {
                        radii.push(radius);
                    }
                    if allowed {
                        stepovers.push(stepover);
                        tools.push(tool);
                    }
                }
                Err((members, detail)) => {
                    let pointer = self.pointer(members, index);
                    // A bad single number is bad for every element: it is reported once.
                    let single = !pointer.ends_with(&format!("/{index}"));
                    if !(single && said) {
                        said |= single;
                        faults.push(|| Fault::new(pointer, detail));
                    }
                }
            }
        }
        faults.into_result()?;
        let many = self.members().any(|(_, numbers)| numbers.count().is_some());
        Ok(Some(ScallopAnswer {
            scallop_height_um: Answers::of(many, heights),
            effective_radius_mm: corners.then(|| Answers::of(many, radii)),
            max_stepover_mm: allowed.then(|| Answers::of(many, stepovers)),
            min_tool_radius_mm: allowed.then(|| Answers::of(many, tools)),
        }))
    }

    /// Checks that arrays have one length, and that a curved surface has a radius and a flat one has none.
    fn check_form(&self, faults: &mut FaultList) {
        let count = self.count();
        let longest = self.members().find(|(_, numbers)| numbers.count() == Some(count));
        for (name, numbers) in self.members() {
            if let (Some(own), Some((other, _))) = (numbers.count(), longest)
                && own != count
            {
                faults.push(|| {
                    Fault::new(
                        format!("/{name}"),
                        format!("{own} numbers, but {other} has {count}; arrays need the same length"),
                    )
                });
            }
        }
        match (self.surface, &self.surface_radius_mm) {
            (SurfaceKind::Flat, Some(_)) => {
                faults.push(|| Fault::new(format!("/{SURFACE_RADIUS}"), "a flat surface has no radius"));
            }
            (SurfaceKind::Convex | SurfaceKind::Concave, None) => {
                let detail = format!("missing: a {} surface has a radius", self.surface.name());
                faults.push(|| Fault::new(format!("/{SURFACE_RADIUS}"), detail));
            }
            _ => {}
        }
    }

    /// Checks every number as written, each in its own range.
    fn check_ranges(&self, faults: &mut FaultList) {
        for (name, numbers) in self.members() {
            let [min, max] = range(name);
            for (index, number) in numbers.written().iter().enumerate() {
                let pointer = || match numbers {
                    Numbers::One(_) => format!("/{name}"),
                    Numbers::Many(_) => format!("/{name}/{index}"),
                };
                faults.check_range(pointer, *number, min, max);
            }
        }
    }

    fn is_in_range(&self, index: usize) -> bool {
        self.members().all(|(name, numbers)| {
            let [min, max] = range(name);
            (min..=max).contains(&numbers.at(index))
        })
    }

    /// The location of a fault: the first of these members that is an array, else the first.
    fn pointer(&self, members: &[&'static str], index: usize) -> String {
        let is_array = |name: &&&str| {
            self.members().any(|(member, numbers)| member == **name && numbers.count().is_some())
        };
        match members.iter().find(is_array) {
            Some(name) => format!("/{name}/{index}"),
            None => format!("/{}", members.first().copied().unwrap_or_default()),
        }
    }

    /// One complete element.
    pub(super) fn element(&self, index: usize) -> Result<Element, Blame> {
        let at = |numbers: &Option<Numbers>| numbers.as_ref().map(|numbers: &Numbers| numbers.at(index));
        let radius_mm = self.tool_radius_mm.at(index);
        let corner_mm = at(&self.corner_radius_mm).unwrap_or(radius_mm);
        let tool =
            Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_mm)).map_err(
                |fault| match fault {
                    ToolFault::Radius { .. } => (&[TOOL_RADIUS][..], fault.to_string()),
                    ToolFault::CornerRadius { .. } => (&[CORNER_RADIUS, TOOL_RADIUS][..], fault.to_string()),
                },
            )?;
        let lead_deg = match at(&self.lead_deg) {
            Some(lead_deg) => lead_deg,
            None if tool.is_ball() => LEAD_RANGE_DEG[1],
            None => {
                return Err((
                    &[LEAD],
                    "missing: a cutter that is not a ball needs its lead angle".to_owned(),
                ));
            }
        };
        let surface =
            self.surface.with_radius(Length::from_mm(at(&self.surface_radius_mm).unwrap_or_default()));
        let pass = CutterPass { tool, lead: Angle::from_deg(lead_deg), surface };
        Ok(Element { pass, stepover: Length::from_mm(self.stepover_mm.at(index)) })
    }

    /// Height \[µm\], effective radius \[mm\], largest step-over \[mm\], smallest tool radius \[mm\].
    fn answer(&self, index: usize, element: &Element) -> Result<[Option<f64>; 4], Blame> {
        let Element { pass, stepover } = element;
        let height = pass.height(*stepover).map_err(blame)?;
        let radius = pass.effective_radius().map_err(|fault| blame(fault.into()))?;
        let mut answer = [Some(height.um()), Some(radius.mm()), None, None];
        if let Some(allowed_um) = &self.allowed_scallop_um {
            let allowed = Length::from_um(allowed_um.at(index));
            answer[2] = Some(pass.largest_stepover(allowed).map_err(blame)?.mm());
            answer[3] = pass.smallest_cutter(allowed, *stepover).map_err(blame)?.map(Length::mm);
        }
        Ok(answer)
    }
}

/// The members to blame, most likely first, and the fault.
pub(super) type Blame = (&'static [&'static str], String);

fn blame(fault: PassFault) -> Blame {
    let members: &[&str] = match fault {
        PassFault::Lead(_) => &[LEAD, TOOL_RADIUS, CORNER_RADIUS],
        PassFault::WiderThanCutter { .. } => &[STEPOVER, TOOL_RADIUS],
        PassFault::Scallop(fault) => match fault.quantity() {
            ScallopQuantity::Stepover => &[STEPOVER, TOOL_RADIUS, SURFACE_RADIUS, CORNER_RADIUS, LEAD],
            ScallopQuantity::ToolRadius => &[TOOL_RADIUS, SURFACE_RADIUS, CORNER_RADIUS, LEAD],
            ScallopQuantity::SurfaceRadius => &[SURFACE_RADIUS],
            ScallopQuantity::AllowedHeight => &[ALLOWED],
        },
    };
    (members, fault.to_string())
}

fn range(name: &str) -> [f64; 2] {
    match name {
        STEPOVER => STEPOVER_RANGE_MM,
        TOOL_RADIUS => [Tool::MIN_RADIUS_MM, Tool::MAX_RADIUS_MM],
        CORNER_RADIUS => [0.0, Tool::MAX_RADIUS_MM],
        LEAD => [0.0, LEAD_RANGE_DEG[1]],
        SURFACE_RADIUS => SURFACE_RANGE_MM,
        _ => ALLOWED_RANGE_UM,
    }
}
