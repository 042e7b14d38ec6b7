//! Parameters of a compensation in one pass.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::compensation::check_max_feed;
use super::statements::program_parameters;
use super::{
    CcParameters, Contact, Correction, Fault, FaultList, LengthInControl, Milling, Output, SingularRegions,
    SingularityAction, StampForm, SurfaceReading, ToolDoc, WearFrom, WearParameters, WearSource,
    WearTableDoc,
};

/// The step for a worn cutter; its members mean what they do in a wear compensation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WearStep {
    /// The cutter the program was made for; that of the machine's tool table when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal_tool: Option<ToolDoc>,
    /// The cutter as measured; this, `wear_table`, or `from` with `cutter_id`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actual_tool: Option<ToolDoc>,
    /// Where the wear comes from, in place of `actual_tool`: both cutters are then the tool table's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<WearFrom>,
    /// With `from`: which cutter is in the holder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "1", max_length = 100)]
    pub cutter_id: Option<String>,
    /// Wear along the corner, for end milling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear_table: Option<WearTableDoc>,
    /// Which part of the cutter makes the surface.
    #[serde(default)]
    pub milling: Milling,
    /// Which length the control has; `nominal` where both lengths are given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_in_control: Option<LengthInControl>,
    /// Where the cutter contact comes from; the tip is none here.
    #[serde(default)]
    pub contact: Contact,
    /// Where the feed turns by more than this, an assumed contact (`feed-plane`) belongs to another pass.
    #[serde(default = "CcParameters::default_pass_break_deg")]
    #[schema(default = 15.0)]
    pub pass_break_deg: f64,
    /// As `tool_number` beside it, which holds for every step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_number: Option<u32>,
}

/// The step for the cutter-contact path; its members mean what they do in a cc compensation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CcStep {
    /// Cutter radius R the program was made for; that of the step `wear` when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_radius_mm: Option<f64>,
    /// Corner radius r; as the cutter radius (a ball) when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_radius_mm: Option<f64>,
    /// Largest distance of the CC path from its line.
    #[serde(default = "CcParameters::default_tolerance_um")]
    #[schema(default = 10.0)]
    pub tolerance_um: f64,
    /// Where the cutter contact comes from.
    #[serde(default)]
    pub contact: Contact,
    /// Where the feed turns by more than this, an assumed contact (`feed-plane`) belongs to another pass.
    #[serde(default = "CcParameters::default_pass_break_deg")]
    #[schema(default = 15.0)]
    pub pass_break_deg: f64,
    /// How a deviating block is corrected.
    #[serde(default)]
    pub correction: Correction,
    /// Which blocks the answer has.
    #[serde(default)]
    pub output: Output,
}

program_parameters! {
/// What a compensation in one pass is asked to do: at least one of `wear`, `location_errors`, `cc`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CompensationParameters {
    /// Move the program for a worn cutter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear: Option<WearStep>,
    /// The program was posted for the nominal machine: post it anew for the calibrated one.
    #[serde(default)]
    pub location_errors: bool,
    /// Compensate the cutter-contact path between the ends of blocks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cc: Option<CcStep>,
    /// Whether the written program is run through the drives, where the machine has any, so that the error budget has
    /// what they leave.
    #[serde(default = "yes")]
    #[schema(default = true)]
    pub servo_lag: bool,
    /// Millimetres of one unit of the uploaded surface: 25.4 for inches; 1 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_unit_mm: Option<f64>,
    /// How far facets of the uploaded surface may stand off the smooth one that they stand for; 10 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chordal_tolerance_um: Option<f64>,
    /// A cutter touches the uploaded surface where it is no farther above or inside its facets; 100 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_gap_um: Option<f64>,
    /// The fastest F that is written: a block whose parts would need more stays as it is. The machine's `max_feed_mm_per_min`
    /// when absent, and where that is not stated ten times the programmed feed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 12_000.0)]
    pub max_feed_mm_per_min: Option<f64>,
    /// Whether a program that leaves changed says so in a comment.
    #[serde(default)]
    #[schema(default = "comment")]
    pub stamp: StampForm,
    /// Do the steps `cc` and `singularity` again to a program that bears their stamp. Steps that move ends are never repeated.
    #[serde(default)]
    #[schema(default = false)]
    pub allow_repeated: bool,
    /// What is done about singular regions, before every other step.
    #[serde(default)]
    pub singularity: SingularityAction,
    /// How they are found and treated.
    #[serde(default)]
    pub singular_regions: SingularRegions,
}
}

/// Whether a step with this contact looks at the part's surface, where one came with the program.
#[must_use]
pub const fn looks_at(contact: Contact, has_part: bool) -> bool {
    has_part && matches!(contact, Contact::Auto | Contact::Surface)
}

const fn yes() -> bool {
    true
}

impl WearStep {
    fn check_source(&self, faults: &mut FaultList) {
        let (pointer, detail) = match (self.from.is_some(), self.cutter_id.is_some()) {
            (true, false) => ("/wear/cutter_id", "missing: the cutter whose wear entries count"),
            (false, true) => {
                ("/wear/from", "missing: entries, for the machine's wear entries of this cutter")
            }
            _ => return,
        };
        faults.push(|| Fault::new(pointer, detail));
    }
}

impl CompensationParameters {
    /// How an uploaded surface is read.
    #[must_use]
    pub fn surface_reading(&self) -> SurfaceReading {
        SurfaceReading {
            unit_mm: self.surface_unit_mm,
            chordal_tolerance_um: self.chordal_tolerance_um,
            contact_gap_um: self.contact_gap_um,
        }
    }

    /// The smallest tolerance that is asked for (µm), for the estimate of the work.
    #[must_use]
    pub fn tolerance_um(&self) -> f64 {
        self.cc.as_ref().map_or_else(CcParameters::default_tolerance_um, |step| step.tolerance_um)
    }

    /// The number of the tool that is meant, wherever it is stated.
    #[must_use]
    pub fn tool(&self) -> Option<u32> {
        self.tool_number.or(self.wear.as_ref().and_then(|step| step.tool_number))
    }

    /// The step for a worn cutter as parameters of a wear compensation, what the steps share apart.
    #[must_use]
    pub fn wear_alone(&self) -> Option<WearParameters> {
        self.wear.clone().map(|step| WearParameters {
            actual_tool: step.actual_tool,
            wear: step.from.zip(step.cutter_id).map(|(from, cutter_id)| WearSource { from, cutter_id }),
            wear_table: step.wear_table,
            milling: step.milling,
            length_in_control: step.length_in_control,
            contact: step.contact,
            pass_break_deg: step.pass_break_deg,
            ..WearParameters::of(step.nominal_tool)
        })
    }

    /// The step for the contact's path as parameters of a cc compensation, what the steps share apart.
    #[must_use]
    pub fn cc_alone(&self) -> Option<CcParameters> {
        let step = self.cc.clone()?;
        let nominal =
            self.wear.as_ref().and_then(|wear| wear.nominal_tool).filter(|_| step.tool_radius_mm.is_none());
        Some(CcParameters {
            tool_radius_mm: step.tool_radius_mm.or(nominal.map(|tool| tool.radius_mm)),
            corner_radius_mm: step.corner_radius_mm.or(nominal.and_then(|tool| tool.corner_radius_mm)),
            tolerance_um: step.tolerance_um,
            contact: step.contact,
            pass_break_deg: step.pass_break_deg,
            correction: step.correction,
            output: step.output,
            ..CcParameters::default()
        })
    }

    /// Collects what is wrong with what the steps share.
    fn check_shared(&self, has_part: bool, faults: &mut FaultList) {
        self.surface_reading().check(has_part, faults);
        self.singular_regions.check(faults);
        check_max_feed(self.max_feed_mm_per_min, faults);
        self.statements().check(faults);
        if self.wear.is_none() && !self.location_errors && self.cc.is_none() {
            faults.push(|| Fault::new("", "nothing is asked for: name wear, location_errors or cc"));
        }
        if let Some(step) = &self.wear {
            step.check_source(faults);
            if step.tool_number.zip(self.tool_number).is_some_and(|(step, all)| step != all) {
                let detail = "another one than tool_number beside the step: one tool is meant for all steps";
                faults.push(|| Fault::new("/wear/tool_number", detail));
            }
        }
        let contacts =
            [self.wear.as_ref().map(|step| step.contact), self.cc.as_ref().map(|step| step.contact)];
        if has_part && !contacts.into_iter().flatten().any(|contact| looks_at(contact, has_part)) {
            let detail = "a surface came with the program, but no step looks at it";
            faults.push(|| Fault::new("", detail));
        }
    }

    /// Every bad value, with its pointer; `has_part` says whether the part's surface came with the program.
    ///
    /// # Errors
    /// They are there.
    pub fn check(&self, has_part: bool) -> Result<(), Vec<Fault>> {
        let mut faults = FaultList::default();
        self.check_shared(has_part, &mut faults);
        let wear = self.wear_alone().map(|step| step.to_core(looks_at(step.contact, has_part)).map(|_| ()));
        let cc = self.cc_alone().map(|step| step.check(looks_at(step.contact, has_part)).map(|_| ()));
        for (name, found) in [("/wear", wear), ("/cc", cc)] {
            for fault in found.and_then(Result::err).into_iter().flatten() {
                // Here the step is the source itself.
                let own = fault.pointer.strip_prefix("/wear").filter(|rest| rest.starts_with('/'));
                let pointer = own.unwrap_or(&fault.pointer);
                faults.push(|| Fault { pointer: format!("{name}{pointer}"), ..fault.clone() });
            }
        }
        faults.into_result()
    }
}
