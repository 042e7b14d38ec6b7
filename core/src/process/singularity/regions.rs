//! The regions found: the first ones by themselves, all of them in sums.

use std::collections::BTreeMap;

use super::report::{RegionFigures, RegionTreatment, RegionsLeft, SingularRegion, SingularityReport};
use super::{LeftReason, SingularityAction};
use crate::program::Dialect;
use crate::units::Angle;

/// A region that is still to be read back, by its number.
pub(super) type RegionNumber = u64;

#[derive(Debug, Default)]
pub(super) struct Regions {
    kept: Vec<SingularRegion>,
    found: u64,
    motions: u64,
    treated: u64,
    left: BTreeMap<LeftReason, (u64, u64)>,
    nearest: Option<(u64, Angle)>,
    fastest: Option<(u64, f64)>,
    before: RegionFigures,
    after: RegionFigures,
    pub(super) axis_spent_rad: f64,
}

impl Regions {
    /// Takes a region in; what is written of it comes later.
    pub(super) fn add(&mut self, region: SingularRegion) -> RegionNumber {
        let number = self.found;
        self.found += 1;
        self.motions += region.motions;
        self.before.take(&region.before);
        if self.nearest.is_none_or(|(_, least)| region.least_angle < least) {
            self.nearest = Some((region.first_line, region.least_angle));
        }
        if let Some(speed) = region.before.rotary_deg_per_s
            && self.fastest.is_none_or(|(_, most)| speed > most)
        {
            self.fastest = Some((region.first_line, speed));
        }
        let left = match region.treatment {
            RegionTreatment::Reported => None,
            RegionTreatment::Left(reason) => Some(reason),
            RegionTreatment::Densified { reason, .. } => {
                self.treated += 1;
                reason
            }
            RegionTreatment::Smoothed { .. } => {
                self.treated += 1;
                None
            }
        };
        if let Some(reason) = left {
            let entry = self.left.entry(reason).or_insert((0, region.first_line));
            entry.0 += 1;
        }
        if self.kept.len() < SingularityReport::MAX_REGIONS {
            self.kept.push(region);
        }
        number
    }

    /// Figures of one motion, or part of one, as it stands in the written program.
    pub(super) fn written(&mut self, number: RegionNumber, figures: &RegionFigures) {
        self.after.take(figures);
        if let Some(region) = self.region(number)
            && !matches!(region.treatment, RegionTreatment::Left(_) | RegionTreatment::Reported)
        {
            region.after.get_or_insert_default().take(figures);
        }
    }

    /// The tool axis is this far from the programmed one at a point of the written program.
    pub(super) fn spent(&mut self, number: RegionNumber, spent_rad: f64) {
        self.axis_spent_rad = self.axis_spent_rad.max(spent_rad);
        if let Some(SingularRegion { treatment: RegionTreatment::Smoothed { axis_spent, .. }, .. }) =
            self.region(number)
        {
            *axis_spent = Angle::from_rad(axis_spent.rad().max(spent_rad));
        }
    }

    fn region(&mut self, number: RegionNumber) -> Option<&mut SingularRegion> {
        self.kept.get_mut(usize::try_from(number).ok()?)
    }

    pub(super) fn report(self, dialect: Dialect, action: SingularityAction) -> SingularityReport {
        let left = self.left.into_iter();
        let left = left.map(|(reason, (count, first_line))| RegionsLeft { reason, count, first_line });
        SingularityReport {
            dialect,
            action,
            blocks_in: 0,
            blocks_out: 0,
            motions_checked: 0,
            motions_singular: self.motions,
            regions_found: self.found,
            regions: self.kept,
            regions_treated: self.treated,
            left: left.collect(),
            nearest: self.nearest,
            fastest: self.fastest,
            before: self.before,
            after: self.after,
            blocks_changed: 0,
            blocks_inserted: 0,
            feeds_restored: 0,
            axis_spent: Angle::from_rad(self.axis_spent_rad),
            warnings: Vec::new(),
        }
    }
}
