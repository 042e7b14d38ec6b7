//! Machines and their revisions.

use std::collections::BTreeSet;

use sqlx::error::ErrorKind;

use super::audit::{Actor, Change, audit};
use super::error::Doing;
use super::keys::{Answer, keep_key};
use super::tool_changes::delete_tools_of;
use super::{Cursor, Expected, KeyUse, Page, RevisionHead, Stale, Store, StoreError, sha256_hex};
use crate::wire::{AuditAction, MachineDocument, MachineProfile};

/// One stored revision of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Revision {
    /// The document.
    pub document: MachineDocument,
    /// SHA-256 of the normalised profile.
    pub sha256: String,
    /// The calibration that its errors come from, if there is one.
    pub calibration_id: Option<String>,
}

impl Revision {
    /// Whether the caller's condition is met.
    #[must_use]
    pub fn fits(&self, expected: &Expected) -> bool {
        RevisionHead { revision: self.document.revision, sha256: self.sha256.clone() }.fits(expected)
    }
}

/// A profile that is about to be stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewRevision {
    /// The machine.
    pub machine_id: String,
    /// The profile, normalised.
    pub profile: MachineProfile,
    /// Digest of the profile.
    pub sha256: String,
    /// The calibration that its errors come from, if there is one.
    pub calibration_id: Option<String>,
    /// The present time.
    pub created_at: String,
}

/// The result of a put.
#[derive(Debug, Clone, PartialEq)]
pub enum PutOutcome {
    /// A new machine.
    Created(Revision),
    /// A new revision, or the same one when the profile is the same.
    Replaced(Revision),
}

row! {
    struct RevisionRow {
        machine_id: String,
        revision: i64,
        profile: String,
        sha256: String,
        created_at: String,
        calibration_id: Option<String>,
    }
}

row! {
    /// A machine in a list.
    struct ListedRevision {
        seq: i64,
        machine_id: String,
        revision: i64,
        profile: String,
        sha256: String,
        created_at: String,
        calibration_id: Option<String>,
    }
}

row! {
    /// The last revision of a machine, which may be deleted.
    struct CurrentRevision {
        deleted: i64,
        last_revision: i64,
        profile: String,
        sha256: String,
        created_at: String,
        calibration_id: Option<String>,
    }
}

row! {
    /// Number and digest of the last revision of a machine.
    struct CurrentHead {
        last_revision: i64,
        sha256: String,
    }
}

impl RevisionRow {
    fn read(self, store: &Store) -> Result<Revision, StoreError> {
        let Self { machine_id, revision, profile, sha256, created_at, calibration_id } = self;
        store.verify(|| format!("machine {machine_id} revision {revision}"), &profile, &sha256)?;
        let profile: MachineProfile = serde_json::from_str(&profile).map_err(|source| {
            let key = format!("{machine_id} revision {revision}");
            StoreError::Unreadable { what: "machine", key, source }
        })?;
        Ok(Revision {
            document: MachineDocument { machine_id, revision, created_at, profile },
            sha256,
            calibration_id,
        })
    }
}

impl Store {
    /// The current revision of a machine.
    ///
    /// # Errors
    /// The database failed.
    pub async fn machine(&self, machine_id: &str) -> Result<Option<Revision>, StoreError> {
        let row = sql!(
            self.db,
            optional(RevisionRow),
            "SELECT r.machine_id, r.revision, r.profile, r.sha256, r.created_at, r.calibration_id
             FROM machines m JOIN machine_revisions r ON r.machine_id = m.machine_id AND r.revision = m.last_revision
             WHERE m.machine_id = $1 AND m.deleted = 0",
            machine_id
        )
        .doing("reading a machine")?;
        row.map(|row| row.read(self)).transpose()
    }

    /// One revision of a machine; the machine may be deleted.
    ///
    /// # Errors
    /// The database failed.
    pub async fn machine_revision(
        &self,
        machine_id: &str,
        revision: i64,
    ) -> Result<Option<Revision>, StoreError> {
        let row = sql!(
            self.db,
            optional(RevisionRow),
            "SELECT machine_id, revision, profile, sha256, created_at, calibration_id FROM machine_revisions
             WHERE machine_id = $1 AND revision = $2",
            machine_id,
            revision
        )
        .doing("reading a machine revision")?;
        row.map(|row| row.read(self)).transpose()
    }

    /// A page of machines at their current revisions, newest machine first; only these machines, if there is a list.
    ///
    /// # Errors
    /// The database failed.
    pub async fn machines(
        &self,
        only: Option<&BTreeSet<String>>,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Page<Revision>, StoreError> {
        let only = as_array(only);
        let (before, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let rows = sql!(
            self.db,
            all(ListedRevision),
            "SELECT m.seq, r.machine_id, r.revision, r.profile, r.sha256, r.created_at, r.calibration_id
             FROM machines m JOIN machine_revisions r ON r.machine_id = m.machine_id AND r.revision = m.last_revision
             WHERE m.deleted = 0 AND m.seq < $1
               AND (CAST($2 AS TEXT) IS NULL OR m.machine_id IN (SELECT value FROM json_each($2)))
             ORDER BY m.seq DESC LIMIT $3",
            before,
            only,
            count
        )
        .doing("listing machines")?;
        let read = rows.into_iter().map(|row| {
            let (machine_id, profile, sha256) = (row.machine_id, row.profile, row.sha256);
            let revision = RevisionRow {
                machine_id,
                revision: row.revision,
                profile,
                sha256,
                created_at: row.created_at,
                calibration_id: row.calibration_id,
            };
            Ok((row.seq, revision.read(self)?))
        });
        Ok(Page::cut(read.collect::<Result<_, StoreError>>()?, limit))
    }

    /// A page of the revisions of a machine, newest first; `None` if there never was such a machine.
    ///
    /// # Errors
    /// The database failed.
    pub async fn machine_revisions(
        &self,
        machine_id: &str,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Option<Page<Revision>>, StoreError> {
        let (below, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let rows = sql!(
            self.db,
            all(RevisionRow),
            "SELECT machine_id, revision, profile, sha256, created_at, calibration_id FROM machine_revisions
             WHERE machine_id = $1 AND revision < $2 ORDER BY revision DESC LIMIT $3",
            machine_id,
            below,
            count
        )
        .doing("listing revisions")?;
        if rows.is_empty() && before.is_none() {
            return Ok(None);
        }
        let read = rows.into_iter().map(|row| Ok((row.revision, row.read(self)?)));
        Ok(Some(Page::cut(read.collect::<Result<_, StoreError>>()?, limit)))
    }

    /// Whether no machine was ever stored.
    ///
    /// # Errors
    /// The database failed.
    pub async fn has_no_machine_yet(&self) -> Result<bool, StoreError> {
        let count: i64 = sql!(self.db, one(_), "SELECT COUNT(*) AS \"count!\" FROM machines")
            .doing("counting machines")?;
        Ok(count == 0)
    }

    /// Stores a profile: a new machine, a new revision, or nothing if it is the current one.
    ///
    /// # Errors
    /// The database failed; the inner error is the condition that is not met.
    pub async fn put_machine(
        &self,
        new: NewRevision,
        expected: Option<Expected>,
        used: Option<&KeyUse>,
        actor: &Actor,
    ) -> Result<Result<PutOutcome, Stale>, StoreError> {
        let NewRevision { machine_id, profile, sha256, calibration_id, created_at } = new;
        let text = serde_json::to_string(&profile).map_err(|source| StoreError::Unreadable {
            what: "machine",
            key: machine_id.clone(),
            source,
        })?;
        let (id, digest, calibrated) = (machine_id.clone(), sha256.clone(), calibration_id);
        let (used, actor) = (used.cloned(), actor.clone());
        let put = self
            .write("storing a machine", |tx| {
                Box::pin(async move {
                    let current = sql!(
                        tx,
                        optional(CurrentRevision),
                        "SELECT m.deleted, m.last_revision, r.profile, r.sha256, r.created_at, r.calibration_id
                         FROM machines m
                         JOIN machine_revisions r ON r.machine_id = m.machine_id AND r.revision = m.last_revision
                         WHERE m.machine_id = $1",
                        id
                    )?;
                    let mut revision = 1;
                    let mut live = false;
                    if let Some(current) = current {
                        live = current.deleted == 0;
                        revision = current.last_revision + 1;
                        if live {
                            let head = RevisionHead { revision: current.last_revision, sha256: current.sha256 };
                            if let Err(stale) = head.admits(expected.as_ref()) {
                                return Ok(Err(stale));
                            }
                            // A profile that was altered in the database is stored again.
                            if head.sha256 == digest && sha256_hex(current.profile.as_bytes()) == digest {
                                let answer = Answer::Revision(&id, head.revision);
                                keep_key(tx, used.as_ref(), answer, &created_at).await?;
                                let stored = (current.created_at, current.calibration_id);
                                return Ok(Ok((false, head.revision, stored)));
                            }
                        }
                        sql!(
                            tx,
                            execute,
                            "UPDATE machines SET last_revision = $1, deleted = 0 WHERE machine_id = $2",
                            revision,
                            id
                        )?;
                    }
                    if !live && expected.is_some_and(|expected| expected != Expected::Nothing) {
                        return Err(sqlx::Error::RowNotFound);
                    }
                    if revision == 1 {
                        sql!(tx, execute, "INSERT INTO machines (machine_id, last_revision) VALUES ($1, 1)", id)?;
                    }
                    sql!(
                        tx,
                        execute,
                        "INSERT INTO machine_revisions (machine_id, revision, profile, sha256, created_at,
                             calibration_id)
                         VALUES ($1, $2, $3, $4, $5, $6)",
                        id,
                        revision,
                        text,
                        digest,
                        created_at,
                        calibrated
                    )?;
                    let before = live.then_some(revision - 1);
                    let change = put_change(&id, calibrated.as_deref(), &created_at, before, revision);
                    audit(tx, &actor, change).await?;
                    keep_key(tx, used.as_ref(), Answer::Revision(&id, revision), &created_at).await?;
                    Ok(Ok((!live, revision, (created_at, calibrated))))
                })
            })
            .await;
        let put = match put {
            Err(StoreError::Statement { source: sqlx::Error::RowNotFound, .. }) => {
                return Ok(Err(Stale::Missing));
            }
            // Machines and revisions are checked under the same lock, so only the key can already exist.
            Err(StoreError::Statement { source: sqlx::Error::Database(fault), .. })
                if fault.kind() == ErrorKind::UniqueViolation =>
            {
                return Ok(Err(Stale::KeyTaken));
            }
            other => other?,
        };
        Ok(put.map(|(created, revision, (created_at, calibration_id))| {
            let document = MachineDocument { machine_id, revision, created_at, profile };
            let stored = Revision { document, sha256, calibration_id };
            if created { PutOutcome::Created(stored) } else { PutOutcome::Replaced(stored) }
        }))
    }

    /// Deletes a machine and its tools. Their revisions stay for the jobs that name them.
    ///
    /// # Errors
    /// The database failed; the inner error is the condition that is not met.
    pub async fn delete_machine(
        &self,
        machine_id: &str,
        expected: Option<Expected>,
        now: &str,
        actor: &Actor,
    ) -> Result<Result<(), Stale>, StoreError> {
        let (id, at, actor) = (machine_id.to_owned(), now.to_owned(), actor.clone());
        self.write("deleting a machine", |tx| {
            Box::pin(async move {
                let current = sql!(
                    tx,
                    optional(CurrentHead),
                    "SELECT m.last_revision, r.sha256 FROM machines m
                     JOIN machine_revisions r ON r.machine_id = m.machine_id AND r.revision = m.last_revision
                     WHERE m.machine_id = $1 AND m.deleted = 0",
                    id
                )?;
                let Some(current) = current else { return Ok(Err(Stale::Missing)) };
                let head = RevisionHead { revision: current.last_revision, sha256: current.sha256 };
                if let Err(stale) = head.admits(expected.as_ref()) {
                    return Ok(Err(stale));
                }
                delete_tools_of(tx, &id, &at, &actor).await?;
                sql!(tx, execute, "UPDATE machines SET deleted = 1 WHERE machine_id = $1", id)?;
                let change = Change {
                    at: &at,
                    action: AuditAction::MachineDeleted,
                    machine_id: Some(&id),
                    resource: format!("/v1/machines/{id}"),
                    revisions: (Some(current.last_revision), None),
                };
                audit(tx, &actor, change).await?;
                Ok(Ok(()))
            })
        })
        .await
    }
}

/// A list of machines as the JSON array that a statement reads; null for all machines.
pub(super) fn as_array(machines: Option<&BTreeSet<String>>) -> Option<String> {
    machines.map(|machines| machines.iter().cloned().collect::<serde_json::Value>().to_string())
}

fn put_change<'a>(
    machine_id: &'a str,
    calibration_id: Option<&str>,
    at: &'a str,
    before: Option<i64>,
    after: i64,
) -> Change<'a> {
    let (action, below) = match (calibration_id, before) {
        (Some(calibration), _) => (AuditAction::CalibrationApplied, format!("/calibrations/{calibration}")),
        (None, None) => (AuditAction::MachineCreated, String::new()),
        (None, Some(_)) => (AuditAction::MachineReplaced, String::new()),
    };
    Change {
        at,
        action,
        machine_id: Some(machine_id),
        resource: format!("/v1/machines/{machine_id}{below}"),
        revisions: (before, Some(after)),
    }
}
