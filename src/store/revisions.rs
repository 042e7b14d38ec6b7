//! The common part of machines and tools with revisions: the condition of a caller about the current revision.

/// The condition of a caller about the stored resource.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Expected {
    /// It must not exist.
    Nothing,
    /// Any revision.
    Any,
    /// One of these entity tags' `(revision, sha256 prefix)`.
    OneOf(Vec<(i64, String)>),
    /// Any revision except these.
    AnyBut(Vec<(i64, String)>),
}

/// Number and digest of the current revision.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RevisionHead {
    /// Current revision.
    pub revision: i64,
    /// Digest of the revision.
    pub sha256: String,
}

impl RevisionHead {
    /// Whether the caller's condition is met.
    pub(super) fn fits(&self, expected: &Expected) -> bool {
        let is_of = |tags: &[(i64, String)]| {
            tags.iter().any(|(revision, prefix)| {
                *revision == self.revision && self.sha256.starts_with(prefix.as_str())
            })
        };
        match expected {
            Expected::Nothing => false,
            Expected::Any => true,
            Expected::OneOf(tags) => is_of(tags),
            Expected::AnyBut(tags) => !is_of(tags),
        }
    }

    /// Whether the caller may replace or delete this revision.
    pub(super) fn admits(&self, expected: Option<&Expected>) -> Result<(), Stale> {
        match expected {
            None => Err(Stale::Unconditional),
            Some(expected) if !self.fits(expected) => Err(Stale::Changed),
            Some(_) => Ok(()),
        }
    }
}

/// Why nothing was changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stale {
    /// The resource exists, and the caller did not state which revision it means.
    Unconditional,
    /// The resource has another revision.
    Changed,
    /// The resource does not exist.
    Missing,
    /// The idempotency key was used in the meantime.
    KeyTaken,
}
