//! Reads the tools of machines and their revisions.

use super::error::Doing;
use super::{Cursor, Page, Store, StoreError};
use crate::wire::{TableTool, ToolDocument};

/// A tool of a machine's table at its current revision, as a job uses it.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredTool {
    /// The tool's id, chosen by the client.
    pub tool_id: String,
    /// Its current revision.
    pub revision: i64,
    /// The tool, normalised.
    pub document: TableTool,
}

/// One stored revision of a tool.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolRevision {
    /// The document.
    pub document: ToolDocument,
    /// SHA-256 of the normalised tool.
    pub sha256: String,
}

row! {
    struct ToolRow {
        machine_id: String,
        tool_id: String,
        revision: i64,
        document: String,
        sha256: String,
        created_at: String,
    }
}

row! {
    /// A tool of a machine's table, at one revision.
    struct TableRow {
        tool_id: String,
        revision: i64,
        document: String,
        sha256: String,
    }
}

row! {
    /// A tool in a list.
    struct ListedTool {
        seq: i64,
        tool_id: String,
        revision: i64,
        document: String,
        sha256: String,
        created_at: String,
    }
}

impl ToolRow {
    fn read(self, store: &Store) -> Result<ToolRevision, StoreError> {
        let Self { machine_id, tool_id, revision, document, sha256, created_at } = self;
        let tool = read_tool(store, (&machine_id, &tool_id, revision), &document, &sha256)?;
        Ok(ToolRevision {
            document: ToolDocument { machine_id, tool_id, revision, created_at, tool },
            sha256,
        })
    }
}

fn read_tool(
    store: &Store,
    (machine_id, tool_id, revision): (&str, &str, i64),
    text: &str,
    sha256: &str,
) -> Result<TableTool, StoreError> {
    let key = || format!("{tool_id:?} of machine {machine_id} revision {revision}");
    store.verify(|| format!("tool {}", key()), text, sha256)?;
    serde_json::from_str(text).map_err(|source| StoreError::Unreadable { what: "tool", key: key(), source })
}

impl Store {
    /// The whole table of a machine at the current revisions, ordered by the bytes of `tool_id`; empty if there is no
    /// such machine.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tools(&self, machine_id: &str) -> Result<Vec<StoredTool>, StoreError> {
        let rows = sql!(
            self.db,
            all(TableRow),
            "SELECT r.tool_id, r.revision, r.document, r.sha256 FROM tools t
             JOIN tool_revisions r ON r.machine_id = t.machine_id AND r.tool_id = t.tool_id
               AND r.revision = t.last_revision
             WHERE t.machine_id = $1 AND t.deleted = 0 ORDER BY t.tool_id",
            machine_id
        )
        .doing("reading the tools of a machine")?;
        let read = rows.into_iter().map(|row| {
            let document =
                read_tool(self, (machine_id, &row.tool_id, row.revision), &row.document, &row.sha256)?;
            Ok(StoredTool { tool_id: row.tool_id, revision: row.revision, document })
        });
        read.collect()
    }

    /// Tools of a machine at these revisions, including deleted tools, ordered by the bytes of `tool_id`.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tools_at(
        &self,
        machine_id: &str,
        revisions: &[(String, i64)],
    ) -> Result<Vec<StoredTool>, StoreError> {
        // Strings and whole numbers can always be printed.
        let wanted = serde_json::to_string(revisions).unwrap_or_default();
        let rows = sql!(
            self.db,
            all(TableRow),
            sqlite "SELECT r.tool_id, r.revision, r.document, r.sha256 FROM tool_revisions r
             JOIN json_each($2) w ON r.tool_id = json_extract(w.value, '$[0]')
               AND r.revision = json_extract(w.value, '$[1]')
             WHERE r.machine_id = $1 ORDER BY r.tool_id",
            postgres "SELECT r.tool_id, r.revision, r.document, r.sha256 FROM tool_revisions r
             JOIN json_each($2) w ON r.tool_id = CAST(w.value AS json) ->> 0
               AND r.revision = CAST(CAST(w.value AS json) ->> 1 AS BIGINT)
             WHERE r.machine_id = $1 ORDER BY r.tool_id",
            machine_id,
            wanted
        )
        .doing("reading the tools of a job")?;
        let read = rows.into_iter().map(|row| {
            let document =
                read_tool(self, (machine_id, &row.tool_id, row.revision), &row.document, &row.sha256)?;
            Ok(StoredTool { tool_id: row.tool_id, revision: row.revision, document })
        });
        read.collect()
    }

    /// The current revision of a tool.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tool(&self, machine_id: &str, tool_id: &str) -> Result<Option<ToolRevision>, StoreError> {
        let row = sql!(
            self.db,
            optional(ToolRow),
            "SELECT r.machine_id, r.tool_id, r.revision, r.document, r.sha256, r.created_at FROM tools t
             JOIN tool_revisions r ON r.machine_id = t.machine_id AND r.tool_id = t.tool_id
               AND r.revision = t.last_revision
             WHERE t.machine_id = $1 AND t.tool_id = $2 AND t.deleted = 0",
            machine_id,
            tool_id
        )
        .doing("reading a tool")?;
        row.map(|row| row.read(self)).transpose()
    }

    /// One revision of a tool; the tool may be deleted.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tool_revision(
        &self,
        machine_id: &str,
        tool_id: &str,
        revision: i64,
    ) -> Result<Option<ToolRevision>, StoreError> {
        let row = sql!(
            self.db,
            optional(ToolRow),
            "SELECT machine_id, tool_id, revision, document, sha256, created_at FROM tool_revisions
             WHERE machine_id = $1 AND tool_id = $2 AND revision = $3",
            machine_id,
            tool_id,
            revision
        )
        .doing("reading a tool revision")?;
        row.map(|row| row.read(self)).transpose()
    }

    /// A page of the tools of a machine at their current revisions, newest tool first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tools_page(
        &self,
        machine_id: &str,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Page<ToolRevision>, StoreError> {
        let (before, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let rows = sql!(
            self.db,
            all(ListedTool),
            "SELECT t.seq, r.tool_id, r.revision, r.document, r.sha256, r.created_at FROM tools t
             JOIN tool_revisions r ON r.machine_id = t.machine_id AND r.tool_id = t.tool_id
               AND r.revision = t.last_revision
             WHERE t.machine_id = $1 AND t.deleted = 0 AND t.seq < $2 ORDER BY t.seq DESC LIMIT $3",
            machine_id,
            before,
            count
        )
        .doing("listing tools")?;
        let read = rows.into_iter().map(|row| {
            let revision = ToolRow {
                machine_id: machine_id.to_owned(),
                tool_id: row.tool_id,
                revision: row.revision,
                document: row.document,
                sha256: row.sha256,
                created_at: row.created_at,
            };
            Ok((row.seq, revision.read(self)?))
        });
        Ok(Page::cut(read.collect::<Result<_, StoreError>>()?, limit))
    }

    /// A page of the revisions of a tool, newest first; `None` if there never was such a tool.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tool_revisions(
        &self,
        machine_id: &str,
        tool_id: &str,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Option<Page<ToolRevision>>, StoreError> {
        let (below, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let rows = sql!(
            self.db,
            all(ToolRow),
            "SELECT machine_id, tool_id, revision, document, sha256, created_at FROM tool_revisions
             WHERE machine_id = $1 AND tool_id = $2 AND revision < $3 ORDER BY revision DESC LIMIT $4",
            machine_id,
            tool_id,
            below,
            count
        )
        .doing("listing the revisions of a tool")?;
        if rows.is_empty() && before.is_none() {
            return Ok(None);
        }
        let read = rows.into_iter().map(|row| Ok((row.revision, row.read(self)?)));
        Ok(Some(Page::cut(read.collect::<Result<_, StoreError>>()?, limit)))
    }
}
