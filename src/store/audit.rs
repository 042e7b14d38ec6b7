//! The audit log: a row for every change, written in the transaction that makes the change.

use super::audit_chain::{BEFORE_THE_FIRST, ChainedEntry, StoredHead, last_entry};
use super::error::Doing;
use super::sql::Tx;
use super::{AuditHead, Cursor, Page, Store, StoreError};
use crate::wire::{AuditAction, AuditEntry, AuditOrigin};

/// The author of a change, and the means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Actor {
    /// Origin of the change.
    pub origin: AuditOrigin,
    /// The key of the request.
    pub key_id: Option<String>,
    /// HTTP method of the request.
    pub method: Option<String>,
    /// Path template of the request.
    pub route: Option<String>,
    /// Id of the request.
    pub request_id: Option<String>,
}

impl Actor {
    /// An author without a request.
    #[must_use]
    pub fn without_request(origin: AuditOrigin) -> Self {
        Self { origin, key_id: None, method: None, route: None, request_id: None }
    }
}

/// The change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Change<'a> {
    /// Time of the change.
    pub(super) at: &'a str,
    /// The action.
    pub(super) action: AuditAction,
    /// The machine that the change concerns.
    pub(super) machine_id: Option<&'a str>,
    /// Address of the changed resource.
    pub(super) resource: String,
    /// Revisions of the machine or the tool before and after, if the change makes or ends any.
    pub(super) revisions: (Option<i64>, Option<i64>),
}

/// Filter of the entries.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AuditFilter {
    /// Only entries about this machine.
    pub machine_id: Option<String>,
    /// Only entries with this key.
    pub key_id: Option<String>,
    /// Only entries with this action.
    pub action: Option<AuditAction>,
    /// Only entries at this time or later.
    pub from: Option<String>,
    /// Only entries at this time or earlier.
    pub to: Option<String>,
}

/// Writes a change into the log, inside the transaction that makes it, and chains it to the entry before it.
pub(super) async fn audit(tx: &mut Tx<'_>, actor: &Actor, change: Change<'_>) -> Result<(), sqlx::Error> {
    let Actor { origin, key_id, method, route, request_id } = actor;
    let Change { at, action, machine_id, resource, revisions: (before, after) } = change;
    let (origin, action) = (origin.as_str(), action.as_str());
    let last = last_entry(tx).await?;
    // Entries are never removed, so the number after the last one is free.
    let seq = last.as_ref().map_or(0, |last| last.seq) + 1;
    let previous = last.and_then(|last| last.sha256).unwrap_or_else(|| BEFORE_THE_FIRST.to_owned());
    let entry = ChainedEntry {
        seq,
        at: at.to_owned(),
        origin: origin.to_owned(),
        key_id: key_id.clone(),
        action: action.to_owned(),
        method: method.clone(),
        route: route.clone(),
        request_id: request_id.clone(),
        machine_id: machine_id.map(str::to_owned),
        resource: resource.clone(),
        revision_before: before,
        revision_after: after,
        sha256: None,
    };
    let sha256 = entry.digest(&previous);
    sql!(
        tx,
        execute,
        "INSERT INTO audit (seq, at, origin, key_id, action, method, route, request_id, machine_id, resource,
             revision_before, revision_after, sha256)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13)",
        seq,
        at,
        origin,
        key_id.as_deref(),
        action,
        method.as_deref(),
        route.as_deref(),
        request_id.as_deref(),
        machine_id,
        resource,
        before,
        after,
        sha256
    )?;
    Ok(())
}

impl Store {
    /// The last entry of the audit log.
    ///
    /// # Errors
    /// The database failed.
    pub async fn audit_head(&self) -> Result<Option<AuditHead>, StoreError> {
        let row =
            sql!(self.db, optional(StoredHead), "SELECT seq, sha256 FROM audit ORDER BY seq DESC LIMIT 1")
                .doing("reading the head of the audit log")?;
        Ok(row.map(|row| AuditHead { seq: row.seq, sha256: row.sha256.unwrap_or_default() }))
    }

    /// A page of the audit log, newest first.
    ///
    /// # Errors
    /// The database failed, or contains a word that this version does not know.
    pub async fn audit_entries(
        &self,
        filter: &AuditFilter,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Page<AuditEntry>, StoreError> {
        let (before, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let [machine_id, key_id, from, to] =
            [&filter.machine_id, &filter.key_id, &filter.from, &filter.to].map(Option::as_deref);
        let action = filter.action.map(AuditAction::as_str);
        /// The statement over the log in its order, or over the entries of a time.
        macro_rules! listed {
            ($seq:tt, $times:tt) => {
                sql!(
                    self.db,
                    all(ChainedEntry),
                    "SELECT seq AS \"seq!\", at, origin, key_id, action, method, route, request_id, machine_id,
                         resource, revision_before, revision_after, sha256 FROM audit
                     WHERE "
                        + $seq
                        + " < $1 AND (CAST($2 AS TEXT) IS NULL OR machine_id = $2)
                       AND (CAST($3 AS TEXT) IS NULL OR key_id = $3)
                       AND (CAST($4 AS TEXT) IS NULL OR action = $4) AND "
                        + $times
                        + " ORDER BY "
                        + $seq
                        + " DESC LIMIT $7",
                    before,
                    machine_id,
                    key_id,
                    action,
                    from,
                    to,
                    count
                )
            };
        }
        // Entries are in the order of their times, as long as no clock jumps: without a beginning, the log is read
        // from its end. With a beginning, the sign makes the database use the index over the times.
        let rows = if from.is_some() {
            listed!("+seq", "at >= $5 AND at <= COALESCE($6, '~')")
        } else {
            listed!(
                "seq",
                "(CAST($5 AS TEXT) IS NULL OR at >= $5) AND (CAST($6 AS TEXT) IS NULL OR at <= $6)"
            )
        }
        .doing("reading the audit log")?;
        let read = rows.into_iter().map(|row| {
            let word = |text: String| serde_json::Value::String(text);
            let unreadable = |source| {
                let key = row.seq.to_string();
                StoreError::Unreadable { what: "audit entry", key, source }
            };
            let entry = AuditEntry {
                seq: row.seq,
                at: row.at,
                origin: serde_json::from_value(word(row.origin)).map_err(unreadable)?,
                key_id: row.key_id,
                action: serde_json::from_value(word(row.action)).map_err(unreadable)?,
                method: row.method,
                route: row.route,
                request_id: row.request_id,
                machine_id: row.machine_id,
                resource: row.resource,
                revision_before: row.revision_before,
                revision_after: row.revision_after,
                sha256: row.sha256.unwrap_or_default(),
            };
            Ok((row.seq, entry))
        });
        Ok(Page::cut(read.collect::<Result<_, StoreError>>()?, limit))
    }
}
