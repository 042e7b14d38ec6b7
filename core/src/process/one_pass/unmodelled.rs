//! Sources that an error budget does not include, gathered from the program and the steps.

use super::error_budget::{NotModelled, NotModelledKind};
use super::parameters::CompensationParameters;
use crate::motion::{Interpolation, MotionKind};
use crate::process::contact_path::CcReport;
use crate::process::fault::{LeftOut, Warning, WarningKind};
use crate::process::move_ends::WearReport;
use crate::process::pipeline::MotionChange;

/// Number of motions, and the first line.
#[derive(Debug, Clone, Copy, Default)]
struct Count {
    count: u64,
    first_line: Option<u64>,
}

impl Count {
    fn add(&mut self, count: u64, line: Option<u64>) {
        self.count += count;
        self.first_line = match (self.first_line, line) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }

    fn of(warnings: &[Warning], kinds: &[WarningKind]) -> Self {
        let mut sum = Self::default();
        for warning in warnings.iter().filter(|warning| kinds.contains(&warning.kind)) {
            sum.add(warning.count, warning.line);
        }
        sum
    }

    /// The larger of two counts of the same motions.
    fn larger(self, other: Self) -> Self {
        if other.count > self.count { other } else { self }
    }
}

/// Motions that are not modelled, by kind.
#[derive(Debug, Default)]
pub(super) struct Unmodelled {
    arcs: Count,
    rapids: Count,
}

impl Unmodelled {
    pub(super) fn see(&mut self, change: &MotionChange) {
        match change.kind {
            MotionKind::Arc => self.arcs.add(1, Some(change.line)),
            MotionKind::Rapid => self.rapids.add(1, Some(change.line)),
            MotionKind::Linear | MotionKind::Opaque => {}
        }
    }

    /// Everything that was not modelled. `lags`: motions left out by the drives, if these were
    /// simulated.
    pub(super) fn list(
        &self,
        parameters: &CompensationParameters,
        moving: Option<&WearReport>,
        cc: Option<&CcReport>,
        lags: Option<Vec<LeftOut>>,
    ) -> Vec<NotModelled> {
        use NotModelledKind as Kind;
        let always = [
            (Kind::Thermal, true),
            (Kind::Deflection, true),
            (Kind::Holder, true),
            (Kind::ErrorMotions, true),
            (Kind::Scallop, true),
            (Kind::ProgramChords, true),
            (Kind::LocationErrors, !parameters.location_errors),
            (Kind::Wear, parameters.wear.is_none()),
            (Kind::Interpolation, cc.is_none()),
            (Kind::Drives, parameters.servo.is_none()),
            (Kind::ServoRefused, parameters.servo.is_some() && lags.is_none()),
            (Kind::ControlCalibration, uses_tip_of_control(moving, cc)),
        ];
        let mut list: Vec<NotModelled> = always
            .into_iter()
            .filter(|(_, holds)| *holds)
            .map(|(kind, _)| NotModelled { kind, count: None, first_line: None })
            .collect();
        let moved = moving.map_or(&[][..], |report| &report.warnings);
        let judged = cc.map_or(&[][..], |report| &report.warnings);
        let both = |kinds: &[WarningKind]| Count::of(moved, kinds).larger(Count::of(judged, kinds));
        let mut left_out = Count::default();
        for entry in lags.unwrap_or_default() {
            left_out.add(entry.count, Some(entry.first_line));
        }
        let counted = [
            (Kind::ContactAssumed, both(&[WarningKind::ContactAssumed])),
            (
                Kind::ContactUnknown,
                both(&[WarningKind::NoContact, WarningKind::NoContactAtEnd, WarningKind::ContactSwings]),
            ),
            (Kind::Arcs, self.arcs),
            (Kind::Rapids, self.rapids),
            (
                Kind::NotFollowed,
                both(&[
                    WarningKind::NotFollowed,
                    WarningKind::MayRollOver,
                    WarningKind::WorkOffsetChanged,
                    WarningKind::PositionUnknown,
                ]),
            ),
            (Kind::ServoLeftOut, left_out),
        ];
        let counted = counted.into_iter().filter(|(_, count)| count.count > 0);
        list.extend(counted.map(|(kind, count)| NotModelled {
            kind,
            count: Some(count.count),
            first_line: count.first_line,
        }));
        list
    }
}

/// Whether the control itself places the tip: under tool-centre-point control, or in a tilted plane with location errors.
fn uses_tip_of_control(moving: Option<&WearReport>, cc: Option<&CcReport>) -> bool {
    let is_warned = |report: &WearReport| {
        report.warnings.iter().any(|warning| warning.kind == WarningKind::ControlCalibrated)
    };
    moving.is_some_and(|report| report.interpolation == Interpolation::Tcp || is_warned(report))
        || cc.is_some_and(|report| report.interpolation == Interpolation::Tcp)
}
