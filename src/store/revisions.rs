//! What machines and tools have in common as things that are stored in revisions: what a caller believes of the current one.

/// What the caller believes is stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Expected {
    /// Nothing; the thing is new.
    Nothing,
    /// Any revision.
    Any,
    /// One of these entity tags' `(revision, sha256 prefix)`.
    OneOf(Vec<(i64, String)>),
    /// Any revision but these.
    AnyBut(Vec<(i64, String)>),
}

/// Number and digest of a thing's current revision.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RevisionHead {
    /// Current revision.
    pub revision: i64,
    /// Its digest.
    pub sha256: String,
}

impl RevisionHead {
    /// Whether the caller's belief fits.
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
    /// The thing exists and the caller did not say which revision is meant.
    Unconditional,
    /// The thing is at another revision.
    Changed,
    /// The thing does not exist.
    Missing,
    /// The idempotency key was used in the meantime.
    KeyTaken,
}
