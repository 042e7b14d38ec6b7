//! The regions found: the first ones individually, all of them in sums.

use std::collections::BTreeMap;

use super::parameters::SingularityAction;
use super::report::{
    LeftReason, RegionFigures, RegionTreatment, RegionsLeft, SingularRegion, SingularityReport,
};
use crate::program::Dialect;
use crate::units::Angle;

/// The number of a region that is still to be read back.
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
}

/// The figures of the regions in the written program: the first regions individually, all of them in sums.
#[derive(Debug, Default)]
pub(super) struct RegionFiguresWritten {
    kept: Vec<WrittenRegion>,
    after: RegionFigures,
    axis_spent_rad: f64,
}

/// The figures of one region in the written program.
#[derive(Debug, Clone, Default)]
struct WrittenRegion {
    after: Option<RegionFigures>,
    axis_spent_rad: f64,
}

impl Regions {
    /// Adds a region. Its figures as written come later.
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

    pub(super) fn report(
        self,
        written: RegionFiguresWritten,
        dialect: Dialect,
        action: SingularityAction,
    ) -> SingularityReport {
        let RegionFiguresWritten { kept: written, after, axis_spent_rad } = written;
        let regions = self.kept.into_iter().zip(written.into_iter().map(Some).chain(std::iter::repeat(None)));
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
            regions: regions.map(|(region, written)| joined(region, &written.unwrap_or_default())).collect(),
            regions_treated: self.treated,
            left: left.collect(),
            nearest: self.nearest,
            fastest: self.fastest,
            before: self.before,
            after,
            blocks_changed: 0,
            blocks_inserted: 0,
            feeds_restored: 0,
            axis_spent: Angle::from_rad(axis_spent_rad),
            warnings: Vec::new(),
        }
    }
}

/// A region together with its figures in the written program.
fn joined(region: SingularRegion, written: &WrittenRegion) -> SingularRegion {
    let is_changed = !matches!(region.treatment, RegionTreatment::Left(_) | RegionTreatment::Reported);
    let treatment = match region.treatment {
        RegionTreatment::Smoothed { changed, .. } => {
            RegionTreatment::Smoothed { changed, axis_spent: Angle::from_rad(written.axis_spent_rad) }
        }
        other => other,
    };
    SingularRegion { after: written.after.filter(|_| is_changed), treatment, ..region }
}

impl RegionFiguresWritten {
    /// Adds the figures of one motion, or of a part of one, in the written program.
    pub(super) fn take(&mut self, number: RegionNumber, figures: &RegionFigures) {
        self.after.take(figures);
        if let Some(region) = self.region(number) {
            region.after.get_or_insert_default().take(figures);
        }
    }

    /// Records the angle between the written and the programmed tool axis at a point of the written program.
    pub(super) fn spent(&mut self, number: RegionNumber, spent_rad: f64) {
        self.axis_spent_rad = self.axis_spent_rad.max(spent_rad);
        if let Some(region) = self.region(number) {
            region.axis_spent_rad = region.axis_spent_rad.max(spent_rad);
        }
    }

    fn region(&mut self, number: RegionNumber) -> Option<&mut WrittenRegion> {
        let index = usize::try_from(number).ok().filter(|index| *index < SingularityReport::MAX_REGIONS)?;
        if self.kept.len() <= index {
            self.kept.resize(index + 1, WrittenRegion::default());
        }
        self.kept.get_mut(index)
    }
}
