//! Parameters of a compensation in one pass.

use serde::{Deserialize, Serialize};

use super::cc_compensation::check_max_feed;
use super::statements::program_parameters;
use super::{
    CcParameters, Contact, Correction, Fault, FaultList, LengthInControl, Milling, Output, SingularRegions,
    SingularityAction, StampForm, SurfaceReading, ToolDoc, WearFrom, WearParameters, WearSource,
    WearTableDoc,
};
use crate::description::ToSchema;

/// The step for a worn cutter; its members mean the same as in a wear compensation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WearStep {
    /// The cutter that the program was made for. If it is absent, the machine's tool table gives it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal_tool: Option<ToolDoc>,
    /// The cutter as measured. Give `actual_tool`, `wear_table`, or `from` with `cutter_id`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actual_tool: Option<ToolDoc>,
    /// Source of the wear, instead of `actual_tool`; the tool table then gives both cutters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<WearFrom>,
    /// With `from`: id of the cutter in the holder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "1", max_length = 100)]
    pub cutter_id: Option<String>,
    /// Wear along the corner; for end milling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear_table: Option<WearTableDoc>,
    /// Part of the cutter that makes the surface.
    #[serde(default)]
    pub milling: Milling,
    /// Length that the control has; default `nominal` if both lengths are given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_in_control: Option<LengthInControl>,
    /// Where the cutter contact comes from; `tip` is not possible here.
    #[serde(default)]
    pub contact: Contact,
    /// For an assumed contact (`feed-plane`): a new pass begins if the feed direction turns by more than this.
    #[serde(default = "CcParameters::default_pass_break_deg")]
    #[schema(default = 15.0)]
    pub pass_break_deg: f64,
    /// The same as `tool_number` outside this step, which is valid for all steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_number: Option<u32>,
}

/// The step for the cutter-contact path; its members mean the same as in a cc compensation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CcStep {
    /// Cutter radius R that the program was made for. The step `wear` gives it too; a cutter other than
    /// `wear.nominal_tool` is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_radius_mm: Option<f64>,
    /// Corner radius r; default the cutter radius (a ball).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_radius_mm: Option<f64>,
    /// Largest allowed distance of the CC path from its line.
    #[serde(default = "CcParameters::default_tolerance_um")]
    #[schema(default = 10.0)]
    pub tolerance_um: f64,
    /// Where the cutter contact comes from.
    #[serde(default)]
    pub contact: Contact,
    /// For an assumed contact (`feed-plane`): a new pass begins if the feed direction turns by more than this.
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
/// Parameters of a compensation in one pass: at least one of `wear`, `location_errors`, `cc`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CompensationParameters {
    /// Move the program for a worn cutter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear: Option<WearStep>,
    /// True: the program was made for the nominal machine; its words are computed again for the calibrated machine.
    #[serde(default)]
    pub location_errors: bool,
    /// Compensate the cutter-contact path between the ends of blocks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cc: Option<CcStep>,
    /// Whether the written program is simulated with the machine's drives, if it has any. The error budget
    /// then contains the error of the drives.
    #[serde(default = "yes")]
    #[schema(default = true)]
    pub servo_lag: bool,
    /// Millimetres in one unit of the uploaded surface: 25.4 for inches; default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_unit_mm: Option<f64>,
    /// Largest distance of the uploaded facets from the smooth surface; default 10.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chordal_tolerance_um: Option<f64>,
    /// The cutter touches the uploaded surface if it is at most this far from the facets; default 100.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_gap_um: Option<f64>,
    /// Largest F that the service writes; a block whose parts need a larger F stays as it is. Default: the machine's
    /// `max_feed_mm_per_min`, else ten times the programmed feed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 12_000.0)]
    pub max_feed_mm_per_min: Option<f64>,
    /// Whether a changed program gets a comment that says so.
    #[serde(default)]
    #[schema(default = "comment")]
    pub stamp: StampForm,
    /// Apply the steps `cc` and `singularity` again to a program that already has their stamp, or is an earlier
    /// answer of theirs. A program that was smoothed before is not smoothed again. Steps that move ends are never
    /// repeated.
    #[serde(default)]
    #[schema(default = false)]
    pub allow_repeated: bool,
    /// Write the loops and calls of the program out and compensate the result, one program without them. Else motions
    /// after a call are left unchanged, and a program with loops is refused.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schema(default = false)]
    pub flatten: bool,
    /// Treatment of singular regions, before all other steps.
    #[serde(default)]
    pub singularity: SingularityAction,
    /// How singular regions are found and treated.
    #[serde(default)]
    pub singular_regions: SingularRegions,
}
}

/// Whether a step with this contact uses the part's surface, if one came with the program.
#[must_use]
pub const fn looks_at(contact: Contact, has_part: bool) -> bool {
    has_part && matches!(contact, Contact::Auto | Contact::Surface)
}

const fn yes() -> bool {
    true
}

/// Radii that differ by less are the same \[mm\].
const SAME_RADIUS_MM: f64 = 1e-9;

impl CcStep {
    /// Whether the step states another cutter than this one. `radius_mm` is its own radius.
    fn is_other_cutter(&self, radius_mm: f64, nominal: &ToolDoc) -> bool {
        let own = [radius_mm, self.corner_radius_mm.unwrap_or(radius_mm)];
        let other = [nominal.radius_mm, nominal.corner_radius_mm.unwrap_or(nominal.radius_mm)];
        own.iter().zip(other).any(|(own, other)| (own - other).abs() > SAME_RADIUS_MM)
    }
}

impl WearStep {
    fn check_source(&self, faults: &mut FaultList) {
        let (pointer, detail) = match (self.from.is_some(), self.cutter_id.is_some()) {
            (true, false) => ("/wear/cutter_id", "missing: the id of the cutter whose wear entries are used"),
            (false, true) => {
                ("/wear/from", "missing: give `entries` to take the machine's wear entries of this cutter")
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

    /// The smallest requested tolerance (µm), for the estimate of the work.
    #[must_use]
    pub fn tolerance_um(&self) -> f64 {
        self.cc.as_ref().map_or_else(CcParameters::default_tolerance_um, |step| step.tolerance_um)
    }

    /// The number of the requested tool, from whichever step states it.
    #[must_use]
    pub fn tool(&self) -> Option<u32> {
        self.tool_number.or(self.wear.as_ref().and_then(|step| step.tool_number))
    }

    /// The step for a worn cutter as parameters of a wear compensation, without what all steps share.
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

    /// The step for the contact path as parameters of a cc compensation, without what all steps share.
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

    /// Reports faults in what all steps share.
    fn check_shared(&self, has_part: bool, faults: &mut FaultList) {
        self.surface_reading().check(has_part, faults);
        self.singular_regions.check(faults);
        check_max_feed(self.max_feed_mm_per_min, faults);
        self.statements().check(faults);
        if self.wear.is_none() && !self.location_errors && self.cc.is_none() {
            faults.push(|| Fault::new("", "no step is given: name wear, location_errors or cc"));
        }
        if let Some(step) = &self.wear {
            step.check_source(faults);
            if let (Some(nominal), Some(cc)) = (step.nominal_tool, &self.cc)
                && cc.tool_radius_mm.is_some_and(|radius_mm| cc.is_other_cutter(radius_mm, &nominal))
            {
                let detail = "another cutter than wear.nominal_tool, which gives the cutter of all steps; leave out cc.tool_radius_mm and cc.corner_radius_mm";
                faults.push(|| Fault::new("/cc/tool_radius_mm", detail));
            }
            if step.tool_number.zip(self.tool_number).is_some_and(|(step, all)| step != all) {
                let detail = "differs from tool_number outside the step; state one tool for all steps";
                faults.push(|| Fault::new("/wear/tool_number", detail));
            }
        }
        let contacts =
            [self.wear.as_ref().map(|step| step.contact), self.cc.as_ref().map(|step| step.contact)];
        if has_part && !contacts.into_iter().flatten().any(|contact| looks_at(contact, has_part)) {
            let detail =
                "a surface came with the program, but no step uses it; remove it or set contact to surface";
            faults.push(|| Fault::new("", detail));
        }
    }

    /// Checks all values. `has_part` says whether the part's surface came with the program.
    ///
    /// # Errors
    /// Every bad value, with its pointer.
    pub fn check(&self, has_part: bool) -> Result<(), Vec<Fault>> {
        let mut faults = FaultList::default();
        self.check_shared(has_part, &mut faults);
        let wear = self.wear_alone().map(|step| step.to_core(looks_at(step.contact, has_part)).map(|_| ()));
        let cc = self.cc_alone().map(|step| step.check(looks_at(step.contact, has_part)).map(|_| ()));
        for (name, found) in [("/wear", wear), ("/cc", cc)] {
            for fault in found.and_then(Result::err).into_iter().flatten() {
                // Here the step itself is the source.
                let own = fault.pointer.strip_prefix("/wear").filter(|rest| rest.starts_with('/'));
                let pointer = own.unwrap_or(&fault.pointer);
                faults.push(|| Fault { pointer: format!("{name}{pointer}"), ..fault.clone() });
            }
        }
        faults.into_result()
    }
}
