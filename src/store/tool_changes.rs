//! Changes of a machine's tool table: a tool is stored, replaced or deleted.

use super::audit::{Actor, Change, audit};
use super::sql::Tx;
use super::{Expected, RevisionHead, Stale, Store, StoreError, ToolRevision, sha256_hex};
use crate::wire::{AuditAction, TableTool, ToolDocument, path_segment, tool_name_key};

/// A tool that is about to be stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewTool {
    /// The machine.
    pub machine_id: String,
    /// The tool's id, chosen by the client.
    pub tool_id: String,
    /// The tool, normalised.
    pub tool: TableTool,
    /// The present time.
    pub created_at: String,
}

/// The result of a put.
#[derive(Debug, Clone, PartialEq)]
pub enum PutTool {
    /// A new tool.
    Created(ToolRevision),
    /// A new revision, or the same one when the tool is the same.
    Replaced(ToolRevision),
}

/// Why a tool was not stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ToolRefusal {
    /// The caller's condition is not met.
    Stale(Stale),
    /// The machine does not exist.
    NoMachine,
    /// Other tools of the machine already have this number or name.
    Taken {
        /// The tool that has the number.
        number: Option<String>,
        /// The tool that has the name.
        name: Option<String>,
    },
    /// The machine has the largest allowed number of tools.
    Full {
        /// Number of tools that it has.
        tools: u32,
    },
}

impl Store {
    /// Stores a tool: a new one, a new revision, or nothing if it is the current one. A machine has at most `most`
    /// tools.
    ///
    /// # Errors
    /// The database failed; inside, the reason why nothing was stored.
    pub async fn put_tool(
        &self,
        new: NewTool,
        expected: Option<Expected>,
        most: u32,
        actor: &Actor,
    ) -> Result<Result<PutTool, ToolRefusal>, StoreError> {
        let text = serde_json::to_string(&new.tool).map_err(|source| {
            let key = format!("{} tool {:?}", new.machine_id, new.tool_id);
            StoreError::Unreadable { what: "tool", key, source }
        })?;
        let (sha256, actor) = (sha256_hex(text.as_bytes()), actor.clone());
        self.write("storing a tool", |tx| {
            Box::pin(async move {
                let found = head_of(tx, &new.machine_id, &new.tool_id).await?;
                let Some(found) = found else { return Ok(Err(ToolRefusal::NoMachine)) };
                if let Some((current, created_at)) = &found.current {
                    if let Err(stale) = current.admits(expected.as_ref()) {
                        return Ok(Err(ToolRefusal::Stale(stale)));
                    }
                    // A tool that was altered in the database is stored again.
                    if current.sha256 == sha256 && found.is_sound {
                        let revision = current.revision;
                        return Ok(Ok(PutTool::Replaced(stored(new, revision, created_at.clone(), sha256))));
                    }
                } else if expected.is_some_and(|expected| expected != Expected::Nothing) {
                    return Ok(Err(ToolRefusal::Stale(Stale::Missing)));
                }
                if let Some(refusal) = against_the_others(tx, &new).await? {
                    return Ok(Err(refusal));
                }
                let before = found.current.map(|(current, _)| current.revision);
                if before.is_none()
                    && let Some(tools) = as_many_as(tx, &new.machine_id, most).await?
                {
                    return Ok(Err(ToolRefusal::Full { tools }));
                }
                let revision = found.last_revision.unwrap_or(0) + 1;
                insert(tx, &new, revision, &text, &sha256).await?;
                let action =
                    if before.is_none() { AuditAction::ToolCreated } else { AuditAction::ToolReplaced };
                let revisions = (before, Some(revision));
                let change = change(&new.created_at, action, &new.machine_id, &new.tool_id, revisions);
                audit(tx, &actor, change).await?;
                let created_at = new.created_at.clone();
                let stored = stored(new, revision, created_at, sha256);
                Ok(Ok(if before.is_none() { PutTool::Created(stored) } else { PutTool::Replaced(stored) }))
            })
        })
        .await
    }

    /// Deletes a tool from its machine's table. Its revisions stay for the reports that name them, and so do its wear
    /// entries.
    ///
    /// # Errors
    /// The database failed; the inner error is the condition that is not met.
    pub async fn delete_tool(
        &self,
        machine_id: &str,
        tool_id: &str,
        expected: Option<Expected>,
        now: &str,
        actor: &Actor,
    ) -> Result<Result<(), Stale>, StoreError> {
        let (machine_id, tool_id) = (machine_id.to_owned(), tool_id.to_owned());
        let (at, actor) = (now.to_owned(), actor.clone());
        self.write("deleting a tool", |tx| {
            Box::pin(async move {
                let found = head_of(tx, &machine_id, &tool_id).await?;
                let Some((current, _)) = found.and_then(|found| found.current) else {
                    return Ok(Err(Stale::Missing));
                };
                if let Err(stale) = current.admits(expected.as_ref()) {
                    return Ok(Err(stale));
                }
                sql!(
                    tx,
                    execute,
                    "UPDATE tools SET deleted = 1 WHERE machine_id = $1 AND tool_id = $2",
                    machine_id,
                    tool_id
                )?;
                let revisions = (Some(current.revision), None);
                let change = change(&at, AuditAction::ToolDeleted, &machine_id, &tool_id, revisions);
                audit(tx, &actor, change).await?;
                Ok(Ok(()))
            })
        })
        .await
    }
}

/// Deletes every tool of a machine, inside the transaction that deletes the machine.
pub(super) async fn delete_tools_of(
    tx: &mut Tx<'_>,
    machine_id: &str,
    at: &str,
    actor: &Actor,
) -> Result<(), sqlx::Error> {
    let tools = sql!(
        tx,
        all(LiveTool),
        "SELECT tool_id, last_revision FROM tools WHERE machine_id = $1 AND deleted = 0 ORDER BY tool_id",
        machine_id
    )?;
    for tool in tools {
        let revisions = (Some(tool.last_revision), None);
        let change = change(at, AuditAction::ToolDeleted, machine_id, &tool.tool_id, revisions);
        audit(tx, actor, change).await?;
    }
    sql!(tx, execute, "UPDATE tools SET deleted = 1 WHERE machine_id = $1 AND deleted = 0", machine_id)?;
    Ok(())
}

row! {
    /// A tool that is deleted with its machine.
    struct LiveTool {
        tool_id: String,
        last_revision: i64,
    }
}

row! {
    /// The last revision of a tool, which may be deleted.
    struct ToolHead {
        deleted: i64,
        last_revision: i64,
        document: String,
        sha256: String,
        created_at: String,
    }
}

/// The stored state of a machine's `tool_id`.
struct Found {
    /// The last revision, whether or not the tool is deleted.
    last_revision: Option<i64>,
    /// The current revision, and when it was stored; `None` for a deleted tool.
    current: Option<(RevisionHead, String)>,
    /// Whether the last revision is undamaged.
    is_sound: bool,
}

/// The stored state of this `tool_id`; `None` if there is no such machine.
async fn head_of(tx: &mut Tx<'_>, machine_id: &str, tool_id: &str) -> Result<Option<Found>, sqlx::Error> {
    let machine: Option<i64> =
        sql!(tx, optional(_), "SELECT seq FROM machines WHERE machine_id = $1 AND deleted = 0", machine_id)?;
    if machine.is_none() {
        return Ok(None);
    }
    let row = sql!(
        tx,
        optional(ToolHead),
        "SELECT t.deleted, t.last_revision, r.document, r.sha256, r.created_at FROM tools t
         JOIN tool_revisions r ON r.machine_id = t.machine_id AND r.tool_id = t.tool_id
           AND r.revision = t.last_revision
         WHERE t.machine_id = $1 AND t.tool_id = $2",
        machine_id,
        tool_id
    )?;
    let Some(row) = row else {
        return Ok(Some(Found { last_revision: None, current: None, is_sound: true }));
    };
    let is_sound = sha256_hex(row.document.as_bytes()) == row.sha256;
    let head = RevisionHead { revision: row.last_revision, sha256: row.sha256 };
    let current = (row.deleted == 0).then_some((head, row.created_at));
    Ok(Some(Found { last_revision: Some(row.last_revision), current, is_sound }))
}

/// The other tools of the machine with the same number or name.
async fn against_the_others(tx: &mut Tx<'_>, new: &NewTool) -> Result<Option<ToolRefusal>, sqlx::Error> {
    let NewTool { machine_id, tool_id, tool, .. } = new;
    let name_key = tool.name.as_deref().map(tool_name_key);
    let number = sql!(
        tx,
        optional(_),
        "SELECT tool_id FROM tools WHERE machine_id = $1 AND number = $2 AND deleted = 0 AND tool_id <> $3",
        machine_id,
        tool.number.map(i64::from),
        tool_id
    )?;
    let name = sql!(
        tx,
        optional(_),
        "SELECT tool_id FROM tools WHERE machine_id = $1 AND name_key = $2 AND deleted = 0 AND tool_id <> $3",
        machine_id,
        name_key,
        tool_id
    )?;
    let is_taken = number.is_some() || name.is_some();
    Ok(is_taken.then_some(ToolRefusal::Taken { number, name }))
}

/// The number of a machine's tools, if it is `most` or more.
async fn as_many_as(tx: &mut Tx<'_>, machine_id: &str, most: u32) -> Result<Option<u32>, sqlx::Error> {
    let tools: i64 = sql!(
        tx,
        one(_),
        "SELECT COUNT(*) AS \"count!\" FROM tools WHERE machine_id = $1 AND deleted = 0",
        machine_id
    )?;
    let tools = u32::try_from(tools).unwrap_or(u32::MAX);
    Ok((tools >= most).then_some(tools))
}

/// Writes a revision and makes it the current one.
async fn insert(
    tx: &mut Tx<'_>,
    new: &NewTool,
    revision: i64,
    text: &str,
    sha256: &str,
) -> Result<(), sqlx::Error> {
    let NewTool { machine_id, tool_id, tool, created_at } = new;
    let name_key = tool.name.as_deref().map(tool_name_key);
    sql!(
        tx,
        execute,
        "INSERT INTO tools (machine_id, tool_id, last_revision, number, name_key) VALUES ($1, $2, $3, $4, $5)
         ON CONFLICT (machine_id, tool_id) DO UPDATE SET last_revision = excluded.last_revision,
             number = excluded.number, name_key = excluded.name_key, deleted = 0",
        machine_id,
        tool_id,
        revision,
        tool.number.map(i64::from),
        name_key
    )?;
    sql!(
        tx,
        execute,
        "INSERT INTO tool_revisions (machine_id, tool_id, revision, document, sha256, created_at)
         VALUES ($1, $2, $3, $4, $5, $6)",
        machine_id,
        tool_id,
        revision,
        text,
        sha256,
        created_at
    )?;
    Ok(())
}

fn stored(new: NewTool, revision: i64, created_at: String, sha256: String) -> ToolRevision {
    let NewTool { machine_id, tool_id, tool, .. } = new;
    ToolRevision { document: ToolDocument { machine_id, tool_id, revision, created_at, tool }, sha256 }
}

fn change<'a>(
    at: &'a str,
    action: AuditAction,
    machine_id: &'a str,
    tool_id: &str,
    revisions: (Option<i64>, Option<i64>),
) -> Change<'a> {
    let resource = format!("/v1/machines/{machine_id}/tools/{}", path_segment(tool_id));
    Change { at, action, machine_id: Some(machine_id), resource, revisions }
}
