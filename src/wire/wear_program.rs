//! Parameters and report of the compensation of a program for a worn cutter.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::compensation::{check_max_feed, check_pass_break};
use super::statements::program_parameters;
use super::{
    CcParameters, Contact, DeviationSeries, DeviationSummary, Dialect, Fault, FaultList, Fixed,
    Interpolation, Provenance, ResolvedInputs, StampForm, SurfaceKind, SurfaceReading, ToolDoc, Warning,
    WearAdviceAnswer, WearAdviceRequest, check_name,
};
use crate::process::{self, ContactSource, CurvatureAcross, ProgramSetup, WornCutter};
use crate::units::{Angle, Length};
use crate::wear::{WearTable, WearTableFault};

/// Which part of the cutter makes the surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Milling {
    /// Its end.
    #[default]
    End,
    /// Its flank.
    Side,
}

/// Which length stands in the control while the written program runs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LengthInControl {
    /// That of the nominal cutter; every point moves by what the worn one is shorter.
    #[default]
    Nominal,
    /// That of the worn cutter; only head axes without tool centre point control have to be told.
    Measured,
}

/// Wear that differs along the corner: deviations over the contact angle, linear in between.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = WearTable)]
pub struct WearTableDoc {
    /// Angles between surface normal and tool axis, rising from 0 to at most 90.
    #[schema(example = json!([0.0, 45.0, 90.0]))]
    pub contact_angle_deg: Vec<f64>,
    /// How much farther out the cutter's surface lies than the nominal corner; negative where worn.
    #[schema(example = json!([-5.0, -30.0, -12.0]))]
    pub deviation_um: Vec<f64>,
}

/// Where the wear of a cutter comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum WearFrom {
    /// The machine's wear entries: of the cutter named the newest ones that were not withdrawn.
    Entries,
}

/// The wear of a cutter in the machine's tool table, by its entries: the actual radius is the nominal one less the most of
/// `radius_wear_um` over its edges. A length never follows from them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WearSource {
    /// Where the wear comes from.
    pub from: WearFrom,
    /// Which cutter is in the holder.
    #[schema(example = "1", max_length = 100)]
    pub cutter_id: String,
}

program_parameters! {
/// What the compensation for a worn cutter needs to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WearParameters {
    /// The cutter the program was made for; that of the machine's tool table when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal_tool: Option<ToolDoc>,
    /// The cutter as measured; this, `wear_table` or `wear`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actual_tool: Option<ToolDoc>,
    /// The wear by the machine's entries, in place of `actual_tool`: both cutters are then the tool table's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear: Option<WearSource>,
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
    /// Millimetres of one unit of the uploaded surface: 25.4 for inches; 1 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_unit_mm: Option<f64>,
    /// How far facets of the uploaded surface may stand off the smooth one that they stand for; 10 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chordal_tolerance_um: Option<f64>,
    /// A cutter touches the uploaded surface where it is no farther above or inside its facets; 100 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_gap_um: Option<f64>,
    /// Where the feed turns by more than this, an assumed contact (`feed-plane`) belongs to another pass.
    #[serde(default = "CcParameters::default_pass_break_deg")]
    #[schema(default = 15.0)]
    pub pass_break_deg: f64,
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
    /// For the advice in the report, with `stepover_mm`: height that may be left above the surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allowed_scallop_um: Option<f64>,
    /// For the advice: the program's step-over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stepover_mm: Option<f64>,
    /// For the advice: form of the surface across the feed; unless said as measured from the uploaded one, else flat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceKind>,
    /// For the advice: radius of the surface across the feed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_radius_mm: Option<f64>,
    /// For the advice: inclination of the tool axis in the feed direction, where a cutter is no ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lead_deg: Option<f64>,
}
}

/// Most entries of a wear table.
const MAX_ENTRIES: usize = 1000;

impl WearFindings {
    /// Motions that were looked at: those whose contact was found, or those that moved by the length alone where they are more.
    #[must_use]
    pub const fn motions_checked(&self) -> u64 {
        let contacts = self.contacts_kept + self.contacts_assumed;
        if contacts > self.motions_shifted { contacts } else { self.motions_shifted }
    }
}

impl WearParameters {
    /// Those of a program made for this cutter, everything else as where it is not stated.
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
            allowed_scallop_um: None,
            stepover_mm: None,
            surface: None,
            surface_radius_mm: None,
            lead_deg: None,
            interpolation: None,
            unit: None,
            work_offset_mm: None,
            work_offsets_mm: None,
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

    /// The parameters in the core's terms, the part and the program's set-up apart; `has_part` says whether the part came with the
    /// program.
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

    /// The cutter that cuts; `None` where the machine's entries say so.
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
                let detail = "the worn cutter is told by actual_tool or by wear_table, not by both";
                faults.push(|| Fault::new("/wear_table", detail));
                None
            }
            (None, None) => {
                let detail = "missing: the cutter as measured, a wear_table, or wear with the cutter_id of the machine's wear entries";
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
                let detail = "with wear from the entries both cutters are the machine's: leave it out";
                faults.push(|| Fault::new(format!("/{name}"), detail));
            }
        }
        check_name(|| "/wear/cutter_id".to_owned(), &source.cutter_id, faults);
    }

    /// ΔL and who knows of it: without both lengths there is none.
    fn length(&self, faults: &mut FaultList) -> (Length, process::LengthInControl) {
        let length_mm = |tool: Option<ToolDoc>| tool.and_then(|tool| tool.length_mm);
        let lengths = length_mm(self.nominal_tool).zip(length_mm(self.actual_tool));
        if lengths.is_none() && self.length_in_control.is_some() {
            let detail = "needs length_mm of both cutters";
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
                let detail = "only serves the advice, which needs allowed_scallop_um and stepover_mm";
                faults.push(|| Fault::new(format!("/{name}"), detail));
            }
        }
        if !asked {
            return;
        }
        let missing = |name: &str| Fault::new(format!("/{name}"), "missing: the advice needs it");
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
        // What is wrong with the cutters has been said.
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

    /// The advice for the contacts of a program, where it was asked for: for the surface as it was stated, else for
    /// the worst of the curvatures measured, else for a flat one.
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
                "{} angles and {} deviations; there are as many of both, and at most {MAX_ENTRIES}",
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

/// The tightest curvature of the part across the feed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CurvatureAcrossFeed)]
pub struct CurvatureDoc {
    /// Least radius where the part is convex; null where it nowhere is.
    pub convex_radius_mm: Option<f64>,
    /// Line of the upload that ends there.
    pub convex_line: Option<u64>,
    /// Least radius where it is concave; null where it nowhere is.
    pub concave_radius_mm: Option<f64>,
    /// Line of the upload that ends there.
    pub concave_line: Option<u64>,
}

impl From<&CurvatureAcross> for CurvatureDoc {
    fn from(core: &CurvatureAcross) -> Self {
        let radius_mm = |found: Option<(Length, u64)>| found.map(|(radius, _)| radius.mm());
        Self {
            convex_radius_mm: radius_mm(core.convex),
            convex_line: core.convex.map(|(_, line)| line),
            concave_radius_mm: radius_mm(core.concave),
            concave_line: core.concave.map(|(_, line)| line),
        }
    }
}

/// How much of a program an assumed contact says anything about: the motions at feed, and their length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AssumedContacts)]
pub struct AssumptionDoc {
    /// Straight motions at feed.
    pub cuts: u64,
    /// Of these, the ones at whose end a contact is assumed: what the cutter leaves there can be compensated at all.
    pub compensated: u64,
    /// The feed leaves the contact open: the tool plunges, or is fed across its axis, as along a wall or on a floor.
    pub open: u64,
    /// No rotary axis turns next to the point, and nothing is assumed.
    pub not_turning: u64,
    /// Way of the tip in all of these cuts.
    pub path_mm: f64,
    /// Way of the tip in those that are compensated.
    pub compensated_path_mm: f64,
}

impl From<&process::Assumption> for AssumptionDoc {
    fn from(core: &process::Assumption) -> Self {
        let process::Assumption { cuts, compensated, open, not_turning, path, path_compensated } = *core;
        Self {
            cuts,
            compensated,
            open,
            not_turning,
            path_mm: path.mm(),
            compensated_path_mm: path_compensated.mm(),
        }
    }
}

/// What the compensation for a worn cutter found and did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WearFindings {
    /// Form the text was read in.
    pub dialect: Dialect,
    /// What the control was taken to interpolate: `tcp` where the program switches it on or the parameter says so.
    pub interpolation: Interpolation,
    /// Where the cutter contact came from.
    pub contact: Contact,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks of the answer; more only by blocks with F alone before calls.
    pub blocks_out: u64,
    /// Blocks whose bytes changed.
    pub blocks_changed: u64,
    /// Motions at whose end a contact was found, and kept.
    pub contacts_kept: u64,
    /// Motions at whose end a contact was assumed from the feed, and the assumed one kept.
    #[serde(default)]
    pub contacts_assumed: u64,
    /// With an assumed contact: of how much of the program it says anything at all. Null with a stated one.
    #[serde(default)]
    pub assumption: Option<AssumptionDoc>,
    /// Motions that end elsewhere in the answer.
    pub motions_shifted: u64,
    /// Blocks whose F was lowered, so that none runs faster than the source's.
    pub feeds_lowered: u64,
    /// Blocks that only got the source's F word back, behind such ones.
    pub feeds_restored: u64,
    /// Largest shift of a tip.
    pub max_shift_um: f64,
    /// Line of the upload with it; null where nothing moved.
    pub max_shift_line: Option<u64>,
    /// Least and largest angle between surface normal and tool axis; null without a contact.
    pub contact_angle_deg: Option<Fixed<2>>,
    /// How tightly the uploaded surface is curved across the feed at the contacts; null without one.
    pub curvature: Option<CurvatureDoc>,
    /// What the worn cutter leaves along the normal with the program as it was, scallops apart.
    pub before: DeviationSummary,
    /// Distance of the worn cutter's contact from the nominal one's, from the text that was written. What rests on an assumed contact
    /// is as before.
    pub after: DeviationSummary,
    /// With an assumed contact: what `after` is if the assumption is right.
    #[serde(default)]
    pub after_if_assumed: Option<DeviationSummary>,
    /// Chords between contacts, summed.
    pub cc_path_length_mm: f64,
    /// Both along the path.
    pub series: DeviationSeries,
    /// What to do about the scallops, for the contacts of this program; null where it was not asked for.
    pub advice: Option<WearAdviceAnswer>,
    /// What the caller should know.
    pub warnings: Vec<Warning>,
}

/// The report of a compensation for a worn cutter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WearReport {
    /// What it was computed from.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// What it rests on beside its parameters.
    #[serde(default)]
    pub resolved: Option<ResolvedInputs>,
    /// What was found and done.
    #[serde(flatten)]
    pub findings: WearFindings,
}
