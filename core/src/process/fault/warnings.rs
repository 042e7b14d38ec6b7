//! Warnings gathered while a program streams by: one per kind, with count, first and worst line.

use std::collections::BTreeMap;

use super::left_out::LeftOutReason;
use super::warning::{Warning, WarningKind};

#[derive(Debug, Default)]
pub(in crate::process) struct Warnings(BTreeMap<WarningKind, Warning>);

impl Warnings {
    /// Counts one occurrence.
    pub(in crate::process) fn add(&mut self, kind: WarningKind, line: Option<u64>) -> &mut Warning {
        let warning = self.0.entry(kind).or_insert(Warning {
            kind,
            count: 0,
            line,
            worst_line: None,
            max_distance_mm: None,
            min_time_s: None,
            reason: None,
        });
        warning.count += 1;
        warning
    }

    /// Counts one occurrence that has a distance.
    pub(in crate::process) fn add_distance(&mut self, kind: WarningKind, line: u64, distance_mm: f64) {
        let warning = self.add(kind, Some(line));
        if warning.max_distance_mm.is_none_or(|largest| distance_mm > largest) {
            warning.max_distance_mm = Some(distance_mm);
            warning.worst_line = Some(line);
        }
    }

    /// Counts one occurrence that has a time.
    pub(in crate::process) fn add_time(&mut self, kind: WarningKind, line: u64, time_s: f64) {
        let warning = self.add(kind, Some(line));
        if warning.min_time_s.is_none_or(|least| time_s < least) {
            warning.min_time_s = Some(time_s);
            warning.worst_line = Some(line);
        }
    }

    /// Why the first motion was left unchanged, and its line.
    pub(in crate::process) fn first_left(&self) -> Option<(LeftOutReason, u64)> {
        let of = |kind| self.0.get(&kind).and_then(|warning| Some((warning.line?, warning.reason)));
        let unknown =
            of(WarningKind::PositionUnknown).map(|(line, _)| (LeftOutReason::PositionUnknown, line));
        let followed = of(WarningKind::NotFollowed)
            .and_then(|(line, reason)| Some((LeftOutReason::NotFollowed(reason?), line)));
        [unknown, followed].into_iter().flatten().min_by_key(|(_, line)| *line)
    }

    pub(in crate::process) fn into_list(self) -> Vec<Warning> {
        self.0.into_values().collect()
    }
}
