//! The audit log as a chain: every entry has the digest of its content and of the entry before it. So an entry cannot
//! be changed, removed or inserted without changing every digest after it.
//!
//! The digest of an entry is the SHA-256 of a JSON array without blanks, in UTF-8: the word `trunnion-audit-1`, the
//! digest of the entry before it (64 zeros for the first), `seq`, `at`, `origin`, `key_id`, `action`, `method`,
//! `route`, `request_id`, `machine_id`, `resource`, `revision_before`, `revision_after`. A missing value is `null`.
//! Only the characters `"`, `\` and those below U+0020 are escaped: in their short form if JSON has one, else as
//! `\u00xx` in lower case.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::sql::{On, Tx};
use super::{Sha256Hex, sha256_hex};

/// Name of the form of the digested data.
const FORM: &str = "trunnion-audit-1";
/// The digest before the first entry.
pub(super) const BEFORE_THE_FIRST: &str = "0000000000000000000000000000000000000000000000000000000000000000";
/// Entries read at a time.
const AT_ONCE: i64 = 1000;
/// Largest number of breaks that are reported one by one.
const MAX_TOLD: usize = 20;

/// The last entry of the audit log. A copy that is kept elsewhere shows later whether anything before it was changed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AuditHead {
    /// Number of the entry.
    pub seq: i64,
    /// Digest of the entry.
    pub sha256: Sha256Hex,
}

impl fmt::Display for AuditHead {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.seq, self.sha256)
    }
}

/// The text is not a head of an audit log.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("not SEQ:DIGEST, a number and 64 hexadecimal digits such as 42:0a1b…")]
pub struct NoHead;

impl FromStr for AuditHead {
    type Err = NoHead;

    fn from_str(text: &str) -> Result<Self, NoHead> {
        let (seq, sha256) = text.trim().split_once(':').ok_or(NoHead)?;
        let is_digest = sha256.len() == 64 && sha256.bytes().all(|byte| byte.is_ascii_hexdigit());
        let seq = seq.parse().ok().filter(|seq| *seq > 0 && is_digest).ok_or(NoHead)?;
        Ok(Self { seq, sha256: sha256.to_ascii_lowercase() })
    }
}

/// A fault of a chain.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ChainFault {
    /// An entry has no digest.
    #[error("entry {seq} of the audit log has no digest")]
    NoDigest {
        /// Number of the entry.
        seq: i64,
    },
    /// An entry's digest differs from that of its content and of the entry before it.
    #[error(
        "entry {seq} of the audit log was changed after it was written, or an entry before it was removed"
    )]
    Broken {
        /// Number of the entry.
        seq: i64,
    },
    /// Entries at the end are missing.
    #[error("the audit log ends at entry {found}, but the database has counted up to {counted}")]
    Cut {
        /// The last entry.
        found: i64,
        /// The last number that was given.
        counted: i64,
    },
    /// The entry that was recorded elsewhere is missing.
    #[error("the audit log has no entry {seq}, but this entry was recorded elsewhere")]
    HeadMissing {
        /// Number of the entry.
        seq: i64,
    },
    /// The entry has another digest than the recorded one.
    #[error(
        "entry {seq} of the audit log has the digest {found}, but {expected} was recorded elsewhere: this entry or one before it was rewritten"
    )]
    HeadOther {
        /// Number of the entry.
        seq: i64,
        /// Its digest in this database.
        found: Sha256Hex,
        /// Its recorded digest.
        expected: Sha256Hex,
    },
}

/// The findings about a chain.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AuditChain {
    /// Its last entry; `None` without entries.
    pub head: Option<AuditHead>,
    /// Number of entries.
    pub length: u64,
    /// The first faults.
    pub faults: Vec<ChainFault>,
}

row! {
    /// The digested data of an entry.
    #[derive(Debug, Clone)]
    pub(super) struct ChainedEntry {
        pub(super) seq: i64,
        pub(super) at: String,
        pub(super) origin: String,
        pub(super) key_id: Option<String>,
        pub(super) action: String,
        pub(super) method: Option<String>,
        pub(super) route: Option<String>,
        pub(super) request_id: Option<String>,
        pub(super) machine_id: Option<String>,
        pub(super) resource: String,
        pub(super) revision_before: Option<i64>,
        pub(super) revision_after: Option<i64>,
        /// The stored digest.
        pub(super) sha256: Option<Sha256Hex>,
    }
}

impl ChainedEntry {
    /// The digest of this entry after an entry with the digest `previous`.
    pub(super) fn digest(&self, previous: &str) -> Sha256Hex {
        let content = (
            FORM,
            previous,
            self.seq,
            &self.at,
            &self.origin,
            &self.key_id,
            &self.action,
            &self.method,
            &self.route,
            &self.request_id,
            &self.machine_id,
            &self.resource,
            self.revision_before,
            self.revision_after,
        );
        // Strings and whole numbers can always be printed.
        sha256_hex(&serde_json::to_vec(&content).unwrap_or_default())
    }
}

row! {
    /// Number and digest of an entry.
    pub(super) struct StoredHead {
        pub(super) seq: i64,
        pub(super) sha256: Option<Sha256Hex>,
    }
}

/// Number and digest of the last entry.
pub(super) async fn last_entry(tx: &mut Tx<'_>) -> Result<Option<StoredHead>, sqlx::Error> {
    sql!(tx, optional(StoredHead), "SELECT seq, sha256 FROM audit ORDER BY seq DESC LIMIT 1")
}

/// Gives every entry its digest if none has one yet: they were written by a version without digests.
pub(super) async fn chain_old_entries(tx: &mut Tx<'_>) -> Result<u64, sqlx::Error> {
    let chained: bool =
        sql!(tx, one(_), r#"SELECT EXISTS (SELECT 1 FROM audit WHERE sha256 IS NOT NULL) AS "chained!: _""#)?;
    if chained {
        return Ok(0);
    }
    let (mut previous, mut seq, mut count) = (BEFORE_THE_FIRST.to_owned(), 0, 0);
    loop {
        let entries = page(tx, seq).await?;
        let Some(last) = entries.last() else { return Ok(count) };
        seq = last.seq;
        for entry in &entries {
            previous = entry.digest(&previous);
            sql!(tx, execute, "UPDATE audit SET sha256 = $1 WHERE seq = $2", previous, entry.seq)?;
            count += 1;
        }
    }
}

async fn page(tx: &mut Tx<'_>, after: i64) -> Result<Vec<ChainedEntry>, sqlx::Error> {
    sql!(
        tx,
        all(ChainedEntry),
        "SELECT seq, at, origin, key_id, action, method, route, request_id, machine_id, resource, revision_before,
             revision_after, sha256
         FROM audit WHERE seq > $1 ORDER BY seq LIMIT $2",
        after,
        AT_ONCE
    )
}

/// The last number that was given to an entry, if the database counts them itself.
async fn counted(tx: &mut Tx<'_>) -> Result<Option<i64>, sqlx::Error> {
    match tx.on() {
        On::Sqlite(connection) => {
            sqlx::query_scalar("SELECT seq FROM sqlite_sequence WHERE name = 'audit'")
                .fetch_optional(connection)
                .await
        }
        // Its identity column counts entries that were rolled back too.
        On::Postgres(_) => Ok(None),
    }
}

/// Computes every digest again, and compares one entry with a recorded head if there is one.
pub(super) async fn examine_chain(
    tx: &mut Tx<'_>,
    known: Option<&AuditHead>,
) -> Result<AuditChain, sqlx::Error> {
    let mut chain = AuditChain::default();
    let (mut previous, mut seq, mut of_known) = (BEFORE_THE_FIRST.to_owned(), i64::MIN, None);
    // Read before the entries: an entry that is written meanwhile is not a fault.
    let counted = counted(tx).await?;
    loop {
        let entries = page(tx, seq).await?;
        let Some(last) = entries.last() else { break };
        seq = last.seq;
        for entry in entries {
            let digest = entry.digest(&previous);
            if known.is_some_and(|known| known.seq == entry.seq) {
                of_known = Some(digest.clone());
            }
            let fault = match entry.sha256 {
                None => Some(ChainFault::NoDigest { seq: entry.seq }),
                Some(ref stored) if *stored != digest => Some(ChainFault::Broken { seq: entry.seq }),
                Some(_) => None,
            };
            chain.faults.extend(fault.filter(|_| chain.faults.len() < MAX_TOLD));
            // The entries after a break are checked against the stored digests: each break is reported once.
            previous = entry.sha256.unwrap_or(digest);
            chain.length += 1;
            chain.head = Some(AuditHead { seq: entry.seq, sha256: previous.clone() });
        }
    }
    let found = chain.head.as_ref().map_or(0, |head| head.seq);
    if let Some(counted) = counted.filter(|counted| *counted > found) {
        chain.faults.push(ChainFault::Cut { found, counted });
    }
    if let Some(AuditHead { seq, sha256 }) = known.cloned() {
        match of_known {
            None => chain.faults.push(ChainFault::HeadMissing { seq }),
            Some(found) if found != sha256 => {
                chain.faults.push(ChainFault::HeadOther { seq, found, expected: sha256 });
            }
            Some(_) => {}
        }
    }
    Ok(chain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_the_documented_text() {
        let entry = ChainedEntry {
            seq: 7,
            at: "2026-03-14T09:26:53.589Z".to_owned(),
            origin: "http".to_owned(),
            key_id: None,
            action: "machine-replaced".to_owned(),
            method: Some("PUT".to_owned()),
            route: Some("/v1/machines/{machine_id}".to_owned()),
            request_id: Some("a \"quoted\" ü\u{1f}\n".to_owned()),
            machine_id: Some("shop".to_owned()),
            resource: "/v1/machines/shop".to_owned(),
            revision_before: Some(1),
            revision_after: Some(2),
            sha256: None,
        };
        let text = format!(
            "[\"trunnion-audit-1\",\"{BEFORE_THE_FIRST}\",7,\"2026-03-14T09:26:53.589Z\",\"http\",null,\"machine-replaced\",\
             \"PUT\",\"/v1/machines/{{machine_id}}\",\"a \\\"quoted\\\" ü\\u001f\\n\",\"shop\",\"/v1/machines/shop\",1,2]"
        );
        assert_eq!(entry.digest(BEFORE_THE_FIRST), sha256_hex(text.as_bytes()));
        assert_ne!(entry.digest(&"1".repeat(64)), entry.digest(BEFORE_THE_FIRST));
    }

    #[test]
    fn a_head_is_read_as_it_is_written() {
        let head = AuditHead { seq: 42, sha256: sha256_hex(b"x") };
        assert_eq!(head.to_string().parse(), Ok(head));
        for text in ["", "42", "42:", "x:00", "0:00", &format!("42:{}", "g".repeat(64))] {
            assert_eq!(text.parse::<AuditHead>(), Err(NoHead), "{text}");
        }
    }
}
