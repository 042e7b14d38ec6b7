//! Parameters of the compensation of a program for a worn cutter.

use serde::{Deserialize, Serialize};

use super::cc_compensation::{check_max_feed, check_pass_break};
use super::statements::program_parameters;
use super::{
    CcParameters, Contact, Dialect, Fault, FaultList, Fixed, StampForm, SurfaceKind, SurfaceReading, ToolDoc,
    WearAdviceAnswer, WearAdviceRequest, check_name,
};
use crate::description::ToSchema;
use crate::process::{self, ContactSource, CurvatureAcross, ProgramSetup, WornCutter};
use crate::units::{Angle, Length};
use crate::wear::{WearTable, WearTableFault};

/// Part of the cutter that makes the surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Milling {
    /// The end of the cutter.
    #[default]
    End,
    /// The flank of the cutter.
    Side,
}

/// Length that the control has while the written program runs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LengthInControl {
    /// The length of the nominal cutter; every point moves by the missing length of the worn cutter.
    #[default]
    Nominal,
    /// The length of the worn cutter; only head axes without tool centre point control need it.
    Measured,
}

/// Wear that varies along the corner: deviations over the contact angle, linear between the entries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = WearTable)]
pub struct WearTableDoc {
    /// Angles between surface normal and tool axis, rising from 0 to at most 90.
    #[schema(example = json!([0.0, 45.0, 90.0]))]
    pub contact_angle_deg: Vec<f64>,
    /// How far the cutter's surface is outside the nominal corner; negative for wear.
    #[schema(example = json!([-5.0, -30.0, -12.0]))]
    pub deviation_um: Vec<f64>,
}

/// Source of a cutter's wear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum WearFrom {
    /// The machine's wear entries: the newest entries of the named cutter that are not withdrawn.
    Entries,
}

/// The wear of a cutter in the machine's tool table, from its entries: actual radius = nominal radius − the
/// largest `radius_wear_um` of its edges. Entries never give a length.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WearSource {
    /// Source of the wear.
    pub from: WearFrom,
    /// Id of the cutter in the holder.
    #[schema(example = "1", max_length = 100)]
    pub cutter_id: String,
}

program_parameters! {
/// Parameters of the compensation for a worn cutter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WearParameters {
    /// The cutter that the program was made for. If it is absent, the machine's tool table gives it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal_tool: Option<ToolDoc>,
    /// The cutter as measured. Give `actual_tool`, `wear_table` or `wear`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actual_tool: Option<ToolDoc>,
    /// The wear from the machine's entries, instead of `actual_tool`; the tool table then gives both cutters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear: Option<WearSource>,
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
    /// Millimetres in one unit of the uploaded surface: 25.4 for inches; default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_unit_mm: Option<f64>,
    /// Largest distance of the uploaded facets from the smooth surface that they represent; default 10.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chordal_tolerance_um: Option<f64>,
    /// The cutter touches the uploaded surface if it is at most this far above or inside the facets; default
    /// 100.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_gap_um: Option<f64>,
    /// If the feed direction turns by more than this angle, a new pass begins for an assumed contact
    /// (`feed-plane`).
    #[serde(default = "CcParameters::default_pass_break_deg")]
    #[schema(default = 15.0)]
    pub pass_break_deg: f64,
    /// Largest F that the service writes; a block whose parts need a larger F stays as it is. If it is
    /// absent, the machine's `max_feed_mm_per_min` is used; without that, ten times the programmed feed.
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
    /// Write the loops and calls of the program out, and compensate the result: one program without loops and
    /// calls. Without it, motions after a call are left unchanged, and a program with loops is refused.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schema(default = false)]
    pub flatten: bool,
    /// For the advice in the report, with `stepover_mm`: the scallop height that is allowed above the
    /// surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allowed_scallop_um: Option<f64>,
    /// For the advice: step-over of the program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stepover_mm: Option<f64>,
    /// For the advice: form of the surface across the feed. Default: as measured from the uploaded surface,
    /// else flat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceKind>,
    /// For the advice: radius of the surface across the feed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_radius_mm: Option<f64>,
    /// For the advice: inclination of the tool axis in the feed direction, if a cutter is not a ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lead_deg: Option<f64>,
}
}

/// Most entries of a wear table.
const MAX_ENTRIES: usize = 1000;

impl WearParameters {
    /// The parameters of a program made for this cutter, with defaults for everything else.
    #[must_use]
    pub fn of(nominal_tool: Option<ToolDoc>) -> Self {
        Self {
            nominal_tool,
            actual_tool: None,
            wear: None,
            wear_table: None,
            milling: Milling::default(),
            length_in_control: None,
            contact: Contact::default(),
            surface_unit_mm: None,
            chordal_tolerance_um: None,
            contact_gap_um: None,
            pass_break_deg: CcParameters::default_pass_break_deg(),
            max_feed_mm_per_min: None,
            stamp: StampForm::default(),
            allow_repeated: false,
            flatten: false,
            allowed_scallop_um: None,
            stepover_mm: None,
            surface: None,
            surface_radius_mm: None,
            lead_deg: None,
            interpolation: None,
            unit: None,
            work_offset_mm: None,
            work_offsets_mm: None,
            radius_offsets_mm: None,
            tool_length_mm: None,
            tool_number: None,
            start: None,
            feed_mm_per_min: None,
            dialect: Dialect::default(),
        }
    }

    /// How an uploaded surface is read.
    #[must_use]
    pub fn surface_reading(&self) -> SurfaceReading {
        SurfaceReading {
            unit_mm: self.surface_unit_mm,
            chordal_tolerance_um: self.chordal_tolerance_um,
            contact_gap_um: self.contact_gap_um,
        }
    }

    /// The parameters in the core's terms, without the part and the set-up of the program; `has_part` says
    /// whether the part came with the program.
    ///
    /// # Errors
    /// Every bad value, with its pointer.
    pub fn to_core(&self, has_part: bool) -> Result<process::WearParameters, Vec<Fault>> {
        let mut faults = FaultList::default();
        let nominal = self.nominal_tool.and_then(|tool| tool.to_core("/nominal_tool", &mut faults));
        let worn = self.worn(&mut faults);
        let (shorter_by, length_in_control) = self.length(&mut faults);
        let contact = self.contact(&mut faults);
        self.surface_reading().check_with_contact(self.contact, has_part, &mut faults);
        check_pass_break("", self.pass_break_deg, &mut faults);
        check_max_feed(self.max_feed_mm_per_min, &mut faults);
        self.statements().check(&mut faults);
        self.check_advice(&mut faults);
        faults.into_result()?;
        Ok(process::WearParameters {
            milling: match self.milling {
                Milling::End => process::Milling::End,
                Milling::Side => process::Milling::Side,
            },
            shorter_by,
            length_in_control,
            contact,
            pass_break: Angle::from_deg(self.pass_break_deg),
            ..process::WearParameters::new(nominal, worn, ProgramSetup::default())
        })
    }

    /// The cutter that cuts; `None` if the machine's entries give it.
    fn worn(&self, faults: &mut FaultList) -> Option<WornCutter> {
        if let Some(source) = &self.wear {
            self.check_source(source, faults);
            return None;
        }
        match (&self.actual_tool, &self.wear_table) {
            (Some(tool), None) => {
                if let Some(nominal) = &self.nominal_tool {
                    ToolDoc::check_corners(nominal, tool, faults);
                }
                tool.to_core("/actual_tool", faults).map(WornCutter::Tool)
            }
            (None, Some(table)) => {
                if self.milling == Milling::Side {
                    let detail = "a wear table is for end milling; give the worn flank as actual_tool";
                    faults.push(|| Fault::new("/wear_table", detail));
                }
                table.to_core(faults).map(WornCutter::Table)
            }
            (Some(_), Some(_)) => {
                let detail = "give the worn cutter as actual_tool or as wear_table, not as both";
                faults.push(|| Fault::new("/wear_table", detail));
                None
            }
            (None, None) => {
                let detail = "missing: give the cutter as measured, a wear_table, or wear with a cutter_id that has wear entries";
                faults.push(|| Fault::new("/actual_tool", detail));
                None
            }
        }
    }

    fn check_source(&self, source: &WearSource, faults: &mut FaultList) {
        for (name, is_there) in [
            ("nominal_tool", self.nominal_tool.is_some()),
            ("actual_tool", self.actual_tool.is_some()),
            ("wear_table", self.wear_table.is_some()),
        ] {
            if is_there {
                let detail =
                    "wear from the entries takes both cutters from the machine; leave this member out";
                faults.push(|| Fault::new(format!("/{name}"), detail));
            }
        }
        check_name(|| "/wear/cutter_id".to_owned(), &source.cutter_id, faults);
    }

    /// ΔL and who knows it; without both lengths it is missing.
    fn length(&self, faults: &mut FaultList) -> (Length, process::LengthInControl) {
        let length_mm = |tool: Option<ToolDoc>| tool.and_then(|tool| tool.length_mm);
        let lengths = length_mm(self.nominal_tool).zip(length_mm(self.actual_tool));
        if lengths.is_none() && self.length_in_control.is_some() {
            let detail = "needs length_mm of both cutters; give both or leave this member out";
            faults.push(|| Fault::new("/length_in_control", detail));
        }
        let shorter_by = Length::from_mm(lengths.map_or(0.0, |(full, left)| full - left));
        let in_control = match self.length_in_control.unwrap_or_default() {
            LengthInControl::Nominal => process::LengthInControl::Nominal,
            LengthInControl::Measured => process::LengthInControl::Measured,
        };
        (shorter_by, in_control)
    }

    fn contact(&self, faults: &mut FaultList) -> ContactSource {
        let mut refuse = |detail: &'static str| {
            faults.push(|| Fault::new("/contact", detail));
            ContactSource::Auto
        };
        match self.contact {
            Contact::Auto => ContactSource::Auto,
            Contact::Program => ContactSource::Program,
            Contact::Normals => ContactSource::Normals,
            Contact::FeedPlane if self.milling == Milling::Side => {
                refuse("the feed direction does not say where a flank touches")
            }
            Contact::FeedPlane => ContactSource::FeedPlane,
            Contact::Tip => refuse("the tip does not say where a worn cutter touches"),
            Contact::Surface => ContactSource::Surface,
        }
    }

    fn check_advice(&self, faults: &mut FaultList) {
        let asked = self.allowed_scallop_um.is_some() || self.stepover_mm.is_some();
        for (name, given) in [
            ("surface", self.surface.is_some()),
            ("surface_radius_mm", self.surface_radius_mm.is_some()),
            ("lead_deg", self.lead_deg.is_some()),
        ] {
            if given && !asked {
                let detail = "is used only for the advice, which needs allowed_scallop_um and stepover_mm";
                faults.push(|| Fault::new(format!("/{name}"), detail));
            }
        }
        if !asked {
            return;
        }
        let missing = |name: &str| Fault::new(format!("/{name}"), "missing: the advice needs this member");
        for (name, given) in [
            ("allowed_scallop_um", self.allowed_scallop_um.is_some()),
            ("stepover_mm", self.stepover_mm.is_some()),
            ("nominal_tool", self.nominal_tool.is_some()),
            ("actual_tool", self.actual_tool.is_some()),
        ] {
            if !given && (name != "actual_tool" || self.wear_table.is_some() || self.wear.is_some()) {
                faults.push(|| missing(name));
            }
        }
        // The faults of the cutters have already been reported.
        if !faults.is_empty() {
            return;
        }
        if let Some(Err(found)) = self.advice_request([0.0, 90.0]).map(|request| request.solve()) {
            for fault in found {
                faults.push(|| fault);
            }
        }
    }

    fn advice_request(&self, contact_angle_deg: [f64; 2]) -> Option<WearAdviceRequest> {
        let mut actual_tool = self.actual_tool?;
        if self.length_in_control == Some(LengthInControl::Measured) {
            actual_tool.length_mm = None;
        }
        Some(WearAdviceRequest {
            nominal_tool: self.nominal_tool?,
            actual_tool,
            stepover_mm: self.stepover_mm?,
            surface: self.surface.unwrap_or(SurfaceKind::Flat),
            surface_radius_mm: self.surface_radius_mm,
            lead_deg: self.lead_deg,
            contact_angle_deg: Fixed(contact_angle_deg),
            allowed_scallop_um: self.allowed_scallop_um?,
            min_stepover_mm: None,
        })
    }

    /// The advice for the contacts of a program, if it was requested: for the stated surface, else for the
    /// worst measured curvature, else for a flat surface.
    #[must_use]
    pub fn advice(
        &self,
        contact_angles: Option<[Angle; 2]>,
        measured: Option<&CurvatureAcross>,
    ) -> Option<WearAdviceAnswer> {
        let [least, most] = contact_angles?.map(|angle| angle.deg().clamp(0.0, 90.0));
        let request = self.advice_request([least, most])?;
        let Some(measured) = measured.filter(|_| self.surface.is_none()) else { return request.solve().ok() };
        let curved = [(SurfaceKind::Convex, measured.convex), (SurfaceKind::Concave, measured.concave)]
            .into_iter()
            .filter_map(|(surface, found)| Some((surface, Some(found?.0.mm()))));
        let answers = curved.chain([(SurfaceKind::Flat, None)]).filter_map(|(surface, surface_radius_mm)| {
            WearAdviceRequest { surface, surface_radius_mm, ..request }.solve().ok()
        });
        answers.reduce(|worst, next| if next.is_worse_than(&worst) { next } else { worst })
    }
}

impl WearTableDoc {
    fn to_core(&self, faults: &mut FaultList) -> Option<WearTable> {
        let (angles, deviations) = (&self.contact_angle_deg, &self.deviation_um);
        if angles.len() != deviations.len() || angles.len() > MAX_ENTRIES {
            let detail = format!(
                "{} angles and {} deviations; give as many of each, at most {MAX_ENTRIES}",
                angles.len(),
                deviations.len()
            );
            faults.push(|| Fault::new("/wear_table", detail));
            return None;
        }
        let entries: Vec<_> = angles
            .iter()
            .zip(deviations)
            .map(|(angle_deg, deviation_um)| (Angle::from_deg(*angle_deg), Length::from_um(*deviation_um)))
            .collect();
        WearTable::new(&entries)
            .map_err(|fault| {
                let pointer = match fault {
                    WearTableFault::NoTip => "/wear_table/contact_angle_deg/0".to_owned(),
                    WearTableFault::Angle { index, .. } => format!("/wear_table/contact_angle_deg/{index}"),
                    WearTableFault::Deviation { index, .. } => format!("/wear_table/deviation_um/{index}"),
                };
                faults.push(|| Fault::new(pointer, fault.to_string()));
            })
            .ok()
    }
}
