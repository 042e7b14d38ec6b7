//! The known damage, for readiness and metrics: found by a read, or by a scrub.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{DamagedFile, Sha256Hex};
use crate::meter;

/// Damaged items that are kept by name; further ones are only counted and logged.
const KEPT: usize = 1000;

/// The damage that was found and is not known to be repaired.
#[derive(Debug, Default)]
pub struct Soundness(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    damaged: BTreeMap<Sha256Hex, DamagedFile>,
    /// Findings of the last scrub, in words.
    findings: Vec<String>,
    /// End of the last scrub \[s since 1970\].
    scrubbed_at_s: Option<i64>,
}

/// The known damage in numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SoundnessReading {
    /// Files and reports that are known to be damaged.
    pub damaged: usize,
    /// Further findings of the last scrub.
    pub findings: usize,
    /// End of the last scrub \[s since 1970\]; `None` if no scrub has ended in this process.
    pub scrubbed_at_s: Option<i64>,
}

impl Soundness {
    /// Records a damaged item.
    pub fn damaged(&self, found: &DamagedFile) {
        meter::DAMAGED_FILES_MET.add(1);
        let mut known = self.known();
        if known.damaged.len() < KEPT || known.damaged.contains_key(&found.sha256) {
            let before = known.damaged.insert(found.sha256.clone(), found.clone());
            if before.as_ref() == Some(found) {
                return;
            }
        }
        drop(known);
        tracing::error!(sha256 = found.sha256, "{found}");
    }

    /// Records that it was found sound, or was written again.
    pub fn sound(&self, sha256: &str) {
        let mut known = self.known();
        if !known.damaged.is_empty() && known.damaged.remove(sha256).is_some() {
            tracing::info!(sha256, "a stored file that was damaged is sound again");
        }
    }

    /// A scrub has read everything: its findings replace everything that was known before.
    pub fn scrubbed(&self, damaged: &[DamagedFile], findings: Vec<String>, at_s: i64) {
        self.known().damaged.clear();
        for found in damaged {
            self.damaged(found);
        }
        let mut known = self.known();
        (known.findings, known.scrubbed_at_s) = (findings, Some(at_s));
    }

    /// The known damage.
    #[must_use]
    pub fn reading(&self) -> SoundnessReading {
        let Known { damaged, findings, scrubbed_at_s } = &*self.known();
        SoundnessReading { damaged: damaged.len(), findings: findings.len(), scrubbed_at_s: *scrubbed_at_s }
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Damage, StoredThing};
    use super::*;

    fn missing(number: usize) -> DamagedFile {
        DamagedFile { what: StoredThing::File, sha256: format!("{number:064}"), damage: Damage::Missing }
    }

    #[test]
    fn so_many_are_known_by_name_and_no_more() {
        let soundness = Soundness::default();
        for number in 0..KEPT + 5 {
            soundness.damaged(&missing(number));
        }
        assert_eq!(soundness.reading().damaged, KEPT);
        soundness.damaged(&missing(0));
        soundness.sound(&missing(0).sha256);
        // The first damaged item beyond the limit is not known by name.
        soundness.sound(&missing(KEPT).sha256);
        assert_eq!(soundness.reading().damaged, KEPT - 1);
        soundness.scrubbed(&[missing(3)], vec!["a finding".to_owned()], 77);
        let after = SoundnessReading { damaged: 1, findings: 1, scrubbed_at_s: Some(77) };
        assert_eq!(soundness.reading(), after);
    }
}
