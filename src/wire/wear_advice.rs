//! Advice for a worn cutter.

use serde::{Deserialize, Serialize};

use super::{Fault, FaultList, Fixed, SurfaceKind, ToolDoc};
use crate::description::ToSchema;
use crate::units::{Angle, Length};
use crate::wear::{
    Advice, CutterWear, LEAD_RANGE_DEG, Outlook, PassFault, ScallopQuantity, Surface, WearAdvice,
    WearQuestion, advise,
};

/// A worn cutter in a program.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WearAdviceRequest {
    /// The cutter that the program was made for.
    pub nominal_tool: ToolDoc,
    /// The cutter as measured.
    pub actual_tool: ToolDoc,
    /// Step-over of the program: chord between neighbouring contact points on the surface.
    pub stepover_mm: f64,
    /// Form of the surface across the feed.
    pub surface: SurfaceKind,
    /// Radius of the surface's normal curvature across the feed; leave it out for a flat surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_radius_mm: Option<f64>,
    /// Inclination of the tool axis in the feed direction; needed if a cutter is not a ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lead_deg: Option<f64>,
    /// Smallest and largest angle between surface normal and tool axis in the program.
    #[serde(default = "any_contact")]
    #[schema(default = json!([0.0, 90.0]))]
    pub contact_angle_deg: Fixed<2>,
    /// Scallop height that is allowed above the surface.
    pub allowed_scallop_um: f64,
    /// Smallest step-over that is worth running; default nine tenths of `stepover_mm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_stepover_mm: Option<f64>,
}

fn any_contact() -> Fixed<2> {
    Fixed([0.0, 90.0])
}

/// The recommended action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AdviceKind {
    /// Run the program as it is.
    Keep,
    /// Compensate the program for the worn cutter, then run it.
    Compensate,
    /// Compensate, and make the program again with this step-over.
    ReduceStepover,
    /// Change the cutter.
    ChangeTool,
}

/// The scallop that one cutter leaves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = WearOutlook)]
pub struct OutlookDoc {
    /// Scallop at the program's step-over; null if neighbouring passes do not meet.
    pub scallop_height_um: Option<f64>,
    /// Largest step-over that keeps the allowed height.
    pub max_stepover_mm: f64,
}

/// Smallest and largest offset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = WearOffset)]
pub struct OffsetDoc {
    /// Smallest offset.
    pub min_um: f64,
    /// Largest offset.
    pub max_um: f64,
}

/// Advice, with the numbers that it is based on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WearAdviceAnswer {
    /// The cheapest action that keeps the allowed height.
    pub advice: AdviceKind,
    /// The advice in a sentence.
    pub detail: String,
    /// Step-over for the worn cutter; null if it must be changed.
    pub stepover_mm: Option<f64>,
    /// Largest residual of the unchanged program with the worn cutter, scallop included; null if the cutter
    /// cannot cut it.
    pub residual_before_um: Option<f64>,
    /// Largest residual if the advice is followed; after a tool change, the residual of the nominal cutter.
    pub residual_after_um: Option<f64>,
    /// Offset along the normal that compensation removes: + excess, − gouge.
    pub offset: OffsetDoc,
    /// The nominal cutter.
    pub nominal: OutlookDoc,
    /// The worn cutter; null if it gouges a concave surface.
    pub actual: Option<OutlookDoc>,
    /// Wear limit: the smallest cutter radius, with the worn corner radius, that keeps the height at the
    /// program's step-over. Null if no cutter does.
    pub min_tool_radius_mm: Option<f64>,
}

/// Ranges that are accepted.
const STEPOVER_RANGE_MM: [f64; 2] = [1e-6, 1e4];
const SURFACE_RANGE_MM: [f64; 2] = [1e-6, 1e9];
const ALLOWED_RANGE_UM: [f64; 2] = [1e-6, 1e6];
/// As a share of the step-over: with five and ten per cent of wear, P3's values stay above it; with twenty
/// per cent they do not.
const LEAST_SHARE: f64 = 0.9;

impl WearAdviceAnswer {
    /// Whether this advice asks for more, or asks for the same and leaves more.
    #[must_use]
    pub fn is_worse_than(&self, other: &Self) -> bool {
        let rank = |answer: &Self| match answer.advice {
            AdviceKind::Keep => 0,
            AdviceKind::Compensate => 1,
            AdviceKind::ReduceStepover => 2,
            AdviceKind::ChangeTool => 3,
        };
        // A missing residual means that the cutter cannot cut the surface.
        let left_um = |answer: &Self| answer.residual_before_um.unwrap_or(f64::INFINITY);
        (rank(self), left_um(self)) > (rank(other), left_um(other))
    }
}

impl WearAdviceRequest {
    /// Computes the advice.
    ///
    /// # Errors
    /// Every bad value; faults of the nominal cutter's cut.
    pub fn solve(&self) -> Result<WearAdviceAnswer, Vec<Fault>> {
        let mut faults = FaultList::default();
        let question = self.to_core(&mut faults);
        faults.into_result()?;
        // A request without faults has all members.
        let Some(question) = question else { return Err(Vec::new()) };
        let found = advise(&question).map_err(|fault| vec![blame(&fault)])?;
        Ok(answer(&question, &found))
    }

    fn to_core(self, faults: &mut FaultList) -> Option<WearQuestion> {
        let wear = ToolDoc::wear(&self.nominal_tool, &self.actual_tool, faults);
        let mut check = |name: &str, value: f64, [min, max]: [f64; 2]| {
            faults.check_range(|| format!("/{name}"), value, min, max);
        };
        check("stepover_mm", self.stepover_mm, STEPOVER_RANGE_MM);
        check("allowed_scallop_um", self.allowed_scallop_um, ALLOWED_RANGE_UM);
        if let Some(least_mm) = self.min_stepover_mm {
            check("min_stepover_mm", least_mm, [0.0, STEPOVER_RANGE_MM[1]]);
        }
        if let Some(radius_mm) = self.surface_radius_mm {
            check("surface_radius_mm", radius_mm, SURFACE_RANGE_MM);
        }
        if let Some(lead_deg) = self.lead_deg {
            check("lead_deg", lead_deg, [0.0, LEAD_RANGE_DEG[1]]);
        }
        let Fixed([from_deg, to_deg]) = self.contact_angle_deg;
        check("contact_angle_deg/0", from_deg, [0.0, 90.0]);
        check("contact_angle_deg/1", to_deg, [0.0, 90.0]);
        if from_deg > to_deg {
            let detail = format!("{from_deg} is above {to_deg}");
            faults.push(|| Fault::new("/contact_angle_deg", detail));
        }
        let surface = self.surface(faults);
        let lead_deg = self.lead_deg(wear.as_ref(), faults);
        Some(WearQuestion {
            wear: wear?,
            lead: Angle::from_deg(lead_deg?),
            surface: surface?,
            stepover: Length::from_mm(self.stepover_mm),
            allowed: Length::from_um(self.allowed_scallop_um),
            least_stepover: Length::from_mm(self.min_stepover_mm.unwrap_or(LEAST_SHARE * self.stepover_mm)),
            contact_angles: [from_deg, to_deg].map(Angle::from_deg),
        })
    }

    fn surface(&self, faults: &mut FaultList) -> Option<Surface> {
        let detail = match (self.surface, self.surface_radius_mm) {
            (SurfaceKind::Flat, Some(_)) => "a flat surface has no radius".to_owned(),
            (SurfaceKind::Flat, None) => return Some(Surface::Flat),
            (kind, Some(radius_mm)) => return Some(kind.with_radius(Length::from_mm(radius_mm))),
            (kind, None) => format!("missing: a {} surface has a radius", kind.name()),
        };
        faults.push(|| Fault::new("/surface_radius_mm", detail));
        None
    }

    fn lead_deg(&self, wear: Option<&CutterWear>, faults: &mut FaultList) -> Option<f64> {
        let balls = wear.is_none_or(|wear| wear.nominal.is_ball() && wear.actual.is_ball());
        if self.lead_deg.is_none() && !balls {
            let detail = "missing: a cutter that is not a ball needs its lead angle";
            faults.push(|| Fault::new("/lead_deg", detail));
            return None;
        }
        Some(self.lead_deg.unwrap_or(LEAD_RANGE_DEG[1]))
    }
}

/// The nominal cut is already not possible: blame its members, not those of the worn cutter.
fn blame(fault: &PassFault) -> Fault {
    let member = match fault {
        PassFault::Lead(_) => "/lead_deg",
        PassFault::WiderThanCutter { .. } => "/stepover_mm",
        PassFault::Scallop(fault) => match fault.quantity() {
            ScallopQuantity::Stepover => "/stepover_mm",
            ScallopQuantity::ToolRadius => "/nominal_tool/radius_mm",
            ScallopQuantity::SurfaceRadius => "/surface_radius_mm",
            ScallopQuantity::AllowedHeight => "/allowed_scallop_um",
        },
    };
    Fault::new(member, fault.to_string())
}

fn outlook(outlook: &Outlook) -> OutlookDoc {
    OutlookDoc {
        scallop_height_um: outlook.scallop.map(Length::um),
        max_stepover_mm: outlook.largest_stepover.mm(),
    }
}

fn answer(question: &WearQuestion, found: &WearAdvice) -> WearAdviceAnswer {
    let advice = match found.advice {
        Advice::Keep => AdviceKind::Keep,
        Advice::Compensate => AdviceKind::Compensate,
        Advice::ReduceStepover => AdviceKind::ReduceStepover,
        Advice::ChangeTool => AdviceKind::ChangeTool,
    };
    let [min_um, max_um] = found.offset.map(Length::um);
    WearAdviceAnswer {
        advice,
        detail: sentence(question, found),
        stepover_mm: found.stepover.map(Length::mm),
        residual_before_um: found.before.map(Length::um),
        residual_after_um: found.after.map(Length::um),
        offset: OffsetDoc { min_um, max_um },
        nominal: outlook(&found.nominal),
        actual: found.actual.as_ref().map(outlook),
        min_tool_radius_mm: found.smallest_cutter.map(Length::mm),
    }
}

fn sentence(question: &WearQuestion, found: &WearAdvice) -> String {
    let um = |length: Option<Length>| length.map_or(0.0, Length::um);
    let (allowed_um, before_um, after_um) = (question.allowed.um(), um(found.before), um(found.after));
    match found.advice {
        Advice::Keep => {
            format!("the program leaves {before_um:.1} µm as it is; {allowed_um:.1} µm are allowed")
        }
        Advice::Compensate => {
            format!("compensated, the program leaves {after_um:.1} µm instead of {before_um:.1} µm")
        }
        Advice::ReduceStepover => format!(
            "compensated, and with a step-over of {:.4} mm instead of {:.4} mm, the program leaves {after_um:.1} µm",
            found.stepover.unwrap_or_default().mm(),
            question.stepover.mm()
        ),
        Advice::ChangeTool => {
            let why = match &found.actual {
                None => "the worn cutter gouges this surface".to_owned(),
                Some(worn) => format!(
                    "the worn cutter would need a step-over of {:.4} mm, but less than {:.4} mm is not worth running",
                    worn.largest_stepover.mm(),
                    question.least_stepover.mm()
                ),
            };
            let new = if after_um > allowed_um {
                format!(
                    "; even the nominal cutter leaves {after_um:.1} µm, and keeps the height up to a step-over of {:.4} mm",
                    found.nominal.largest_stepover.mm()
                )
            } else {
                String::new()
            };
            why + &new
        }
    }
}
