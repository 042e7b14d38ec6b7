//! Wear entries: they are added and withdrawn, but never changed.

use std::collections::{BTreeMap, BTreeSet};

use super::audit::{Actor, Change, audit};
use super::error::Doing;
use super::keys::{Answer, keep_key, unless_key_taken};
use super::sql::Tx;
use super::{Cursor, KeyUse, Page, Store, StoreError};
use crate::wire::{
    AuditAction, MAX_WEAR_EDGES, MAX_WEAR_ENTRIES, WearEntry, WearQuantity, Withdrawal, path_segment,
};

/// Why entries were not stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WearConflict {
    /// The cutter has entries of the other quantity.
    OtherQuantity {
        /// Index of the cutter's first entry among those posted.
        index: usize,
    },
    /// The cutter already has an entry with the same edge, parts and time.
    AlreadyThere {
        /// Index of the entry among those posted.
        index: usize,
        /// Id of the existing entry.
        id: String,
    },
    /// The cutter would exceed the largest number of entries.
    TooMany {
        /// Index of the first entry over the limit among those posted.
        index: usize,
    },
    /// The cutter would exceed the largest number of edges.
    TooManyEdges {
        /// Index of the first entry of the first edge over the limit among those posted.
        index: usize,
    },
}

/// The result of storing posted entries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AddedWear {
    /// They are stored.
    Stored,
    /// The key was used in the meantime; nothing is stored.
    KeyTaken,
    /// They conflict with stored entries; nothing is stored.
    Refused(Vec<WearConflict>),
}

/// Largest number of conflicts that are reported.
const MOST_CONFLICTS: usize = 100;

row! {
    /// The entries of one edge.
    struct EdgeCount {
        edge: String,
        count: i64,
    }
}

row! {
    struct StoredEntry {
        seq: i64,
        id: String,
        machine_id: String,
        tool_id: String,
        cutter_id: String,
        edge: String,
        quantity: String,
        parts_cut: i64,
        wear_um: f64,
        standard_uncertainty_um: Option<f64>,
        measured_at: String,
        created_at: String,
        note: Option<String>,
        withdrawn_at: Option<String>,
        reason: Option<String>,
    }
}

impl StoredEntry {
    fn read(self) -> WearEntry {
        let is = |quantity: WearQuantity| (self.quantity == quantity.as_str()).then_some(self.wear_um);
        let withdrawn = self.withdrawn_at.zip(self.reason);
        WearEntry {
            radius_wear_um: is(WearQuantity::Radius),
            flank_wear_um: is(WearQuantity::Flank),
            id: self.id,
            machine_id: self.machine_id,
            tool_id: self.tool_id,
            cutter_id: self.cutter_id,
            edge: (!self.edge.is_empty()).then_some(self.edge),
            measured_at: self.measured_at,
            created_at: self.created_at,
            // The column contains only values between 0 and 1e9.
            parts_cut: u32::try_from(self.parts_cut).unwrap_or_default(),
            standard_uncertainty_um: self.standard_uncertainty_um,
            note: self.note,
            withdrawn: withdrawn.map(|(withdrawn_at, reason)| Withdrawal { withdrawn_at, reason }),
        }
    }
}

impl Store {
    /// One entry of a tool.
    ///
    /// # Errors
    /// The database failed.
    pub async fn wear_entry(
        &self,
        machine_id: &str,
        tool_id: &str,
        id: &str,
    ) -> Result<Option<WearEntry>, StoreError> {
        let row = sql!(
            self.db,
            optional(StoredEntry),
            r#"SELECT seq, id, machine_id, tool_id, cutter_id, edge, quantity, parts_cut, wear_um,
                   standard_uncertainty_um, measured_at, created_at, note, withdrawn_at AS "withdrawn_at?",
                   reason AS "reason?"
               FROM wear_entries LEFT JOIN wear_withdrawals ON entry_seq = seq
               WHERE id = $1 AND machine_id = $2 AND tool_id = $3"#,
            id,
            machine_id,
            tool_id
        )
        .doing("reading a wear entry")?;
        Ok(row.map(StoredEntry::read))
    }

    /// A page of the entries of a tool, or of one of its cutters, newest stored first; withdrawn entries are
    /// included.
    ///
    /// # Errors
    /// The database failed.
    pub async fn wear_entries(
        &self,
        machine_id: &str,
        tool_id: &str,
        cutter_id: Option<&str>,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Page<WearEntry>, StoreError> {
        let (before, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let rows = sql!(
            self.db,
            all(StoredEntry),
            r#"SELECT seq, id, machine_id, tool_id, cutter_id, edge, quantity, parts_cut, wear_um,
                   standard_uncertainty_um, measured_at, created_at, note, withdrawn_at AS "withdrawn_at?",
                   reason AS "reason?"
               FROM wear_entries LEFT JOIN wear_withdrawals ON entry_seq = seq
               WHERE machine_id = $1 AND tool_id = $2 AND seq < $3 AND (CAST($4 AS TEXT) IS NULL OR cutter_id = $4)
               ORDER BY seq DESC LIMIT $5"#,
            machine_id,
            tool_id,
            before,
            cutter_id,
            count
        )
        .doing("listing wear entries")?;
        Ok(Page::cut(rows.into_iter().map(|row| (row.seq, row.read())).collect(), limit))
    }

    /// The cutter of a tool's newest entry that is not withdrawn.
    ///
    /// # Errors
    /// The database failed.
    pub async fn newest_cutter(&self, machine_id: &str, tool_id: &str) -> Result<Option<String>, StoreError> {
        sql!(
            self.db,
            optional(_),
            "SELECT cutter_id FROM wear_entries WHERE machine_id = $1 AND tool_id = $2
               AND NOT EXISTS (SELECT 1 FROM wear_withdrawals WHERE entry_seq = seq)
             ORDER BY seq DESC LIMIT 1",
            machine_id,
            tool_id
        )
        .doing("reading the newest cutter")
    }

    /// The entries of a cutter that are not withdrawn, by edge, then by parts.
    ///
    /// # Errors
    /// The database failed.
    pub async fn wear_of_cutter(
        &self,
        machine_id: &str,
        tool_id: &str,
        cutter_id: &str,
    ) -> Result<Vec<WearEntry>, StoreError> {
        let rows = sql!(
            self.db,
            all(StoredEntry),
            r#"SELECT seq, id, machine_id, tool_id, cutter_id, edge, quantity, parts_cut, wear_um,
                   standard_uncertainty_um, measured_at, created_at, note, NULL AS "withdrawn_at?: _",
                   NULL AS "reason?: _"
               FROM wear_entries
               WHERE machine_id = $1 AND tool_id = $2 AND cutter_id = $3
                 AND NOT EXISTS (SELECT 1 FROM wear_withdrawals WHERE entry_seq = seq)
               ORDER BY edge, parts_cut, measured_at, seq"#,
            machine_id,
            tool_id,
            cutter_id
        )
        .doing("reading the wear of a cutter")?;
        Ok(rows.into_iter().map(StoredEntry::read).collect())
    }

    /// For every edge of a cutter: the entry that was measured last and is not withdrawn, and after it the entry with
    /// the most wear if that is another one. The entries may belong to any tool of the machine; they are ordered by
    /// tool, then by edge. An entry without an edge is of the whole cutter and comes first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn newest_and_most_wear(
        &self,
        machine_id: &str,
        cutter_id: &str,
    ) -> Result<Vec<WearEntry>, StoreError> {
        let rows = sql!(
            self.db,
            all(StoredEntry),
            r#"SELECT seq, id, machine_id, tool_id, cutter_id, edge, quantity, parts_cut, wear_um,
                   standard_uncertainty_um, measured_at, created_at, note, NULL AS "withdrawn_at?: _",
                   NULL AS "reason?: _"
               FROM wear_entries
               WHERE seq IN (SELECT known FROM (
                   SELECT seq AS known,
                       ROW_NUMBER() OVER (PARTITION BY tool_id, edge ORDER BY measured_at DESC, seq DESC) AS age,
                       ROW_NUMBER() OVER (
                           PARTITION BY tool_id, edge ORDER BY wear_um DESC, measured_at DESC, seq DESC) AS place
                   FROM wear_entries
                   WHERE machine_id = $1 AND cutter_id = $2
                     AND NOT EXISTS (SELECT 1 FROM wear_withdrawals WHERE entry_seq = seq)
               ) AS places WHERE age = 1 OR place = 1)
               ORDER BY tool_id, edge, measured_at DESC, seq DESC"#,
            machine_id,
            cutter_id
        )
        .doing("reading the newest wear of a cutter's edges")?;
        Ok(rows.into_iter().map(StoredEntry::read).collect())
    }

    /// The entries of one request, in its order, as first answered.
    ///
    /// # Errors
    /// The database failed.
    pub(super) async fn wear_posted_with(&self, first: &str) -> Result<Vec<WearEntry>, StoreError> {
        let rows = sql!(
            self.db,
            all(StoredEntry),
            r#"SELECT seq, id, machine_id, tool_id, cutter_id, edge, quantity, parts_cut, wear_um,
                   standard_uncertainty_um, measured_at, created_at, note, NULL AS "withdrawn_at?: _",
                   NULL AS "reason?: _"
               FROM wear_entries WHERE posted_with = $1 ORDER BY seq"#,
            first
        )
        .doing("reading posted wear entries")?;
        Ok(rows.into_iter().map(StoredEntry::read).collect())
    }

    /// Stores the entries of one request, all of them or none, with its idempotency key.
    ///
    /// # Errors
    /// The database failed.
    pub async fn add_wear_entries(
        &self,
        entries: &[WearEntry],
        used: Option<&KeyUse>,
        actor: &Actor,
    ) -> Result<AddedWear, StoreError> {
        let (entries, used, actor) = (entries.to_vec(), used.cloned(), actor.clone());
        let added = self
            .write("storing wear entries", |tx| {
                Box::pin(async move {
                    let mut refused = against_cutters(tx, &entries).await?;
                    for (index, entry) in entries.iter().enumerate() {
                        if refused.len() >= MOST_CONFLICTS {
                            break;
                        }
                        let there = twin(tx, entry).await?;
                        refused.extend(there.map(|id| WearConflict::AlreadyThere { index, id }));
                    }
                    let Some(first) = entries.first().filter(|_| refused.is_empty()) else {
                        return Ok(refused);
                    };
                    for entry in &entries {
                        insert(tx, entry, &first.id).await?;
                    }
                    let WearEntry { id, machine_id, tool_id, created_at, .. } = first;
                    let action = AuditAction::WearEntriesCreated;
                    let change = about(action, created_at, (machine_id, tool_id, id));
                    audit(tx, &actor, change).await?;
                    let answer = Answer::Wear(&first.id);
                    keep_key(tx, used.as_ref(), answer, &first.created_at).await?;
                    Ok(refused)
                })
            })
            .await;
        match added {
            Ok(refused) if refused.is_empty() => Ok(AddedWear::Stored),
            Ok(refused) => Ok(AddedWear::Refused(refused)),
            Err(fault) => unless_key_taken(Err(fault)).map(|_taken| AddedWear::KeyTaken),
        }
    }

    /// Withdraws an entry; a withdrawn entry stays as it is. Returns the entry afterwards, if there is one.
    ///
    /// # Errors
    /// The database failed.
    pub async fn withdraw_wear_entry(
        &self,
        machine_id: &str,
        tool_id: &str,
        id: &str,
        withdrawal: &Withdrawal,
        actor: &Actor,
    ) -> Result<Option<WearEntry>, StoreError> {
        let (machine, tool, entry) = (machine_id.to_owned(), tool_id.to_owned(), id.to_owned());
        let Withdrawal { withdrawn_at, reason } = withdrawal.clone();
        let actor = actor.clone();
        self.write("withdrawing a wear entry", |tx| {
            Box::pin(async move {
                let withdrawn = sql!(
                    tx,
                    execute,
                    "INSERT INTO wear_withdrawals (entry_seq, withdrawn_at, reason)
                     SELECT seq, $1, $2 FROM wear_entries WHERE id = $3 AND machine_id = $4 AND tool_id = $5
                       AND NOT EXISTS (SELECT 1 FROM wear_withdrawals WHERE entry_seq = seq)",
                    withdrawn_at,
                    reason,
                    entry,
                    machine,
                    tool
                )?;
                if withdrawn == 0 {
                    return Ok(());
                }
                let action = AuditAction::WearEntryWithdrawn;
                let change = about(action, &withdrawn_at, (&machine, &tool, &entry));
                audit(tx, &actor, change).await
            })
        })
        .await?;
        self.wear_entry(machine_id, tool_id, id).await
    }
}

fn about<'a>(action: AuditAction, at: &'a str, entry: (&'a str, &str, &str)) -> Change<'a> {
    let (machine_id, tool_id, id) = entry;
    let resource = format!("/v1/machines/{machine_id}/tools/{}/wear-entries/{id}", path_segment(tool_id));
    Change { at, action, machine_id: Some(machine_id), resource, revisions: (None, None) }
}

/// The entry that is not withdrawn and has the same cutter, edge, parts and time as this one.
async fn twin(tx: &mut Tx<'_>, entry: &WearEntry) -> Result<Option<String>, sqlx::Error> {
    let WearEntry { machine_id, tool_id, cutter_id, measured_at, parts_cut, .. } = entry;
    let edge = entry.edge.as_deref().unwrap_or_default();
    sql!(
        tx,
        optional(_),
        "SELECT id FROM wear_entries WHERE machine_id = $1 AND tool_id = $2 AND cutter_id = $3 AND edge = $4
           AND parts_cut = $5 AND measured_at = $6
           AND NOT EXISTS (SELECT 1 FROM wear_withdrawals WHERE entry_seq = seq) LIMIT 1",
        machine_id,
        tool_id,
        cutter_id,
        edge,
        i64::from(*parts_cut),
        measured_at
    )
}

/// Conflicts with the stored entries of a cutter: the other quantity, and the first entry and the first edge over the
/// limit.
async fn against_cutters(tx: &mut Tx<'_>, entries: &[WearEntry]) -> Result<Vec<WearConflict>, sqlx::Error> {
    let mut cutters: BTreeMap<&str, Vec<(usize, &WearEntry)>> = BTreeMap::new();
    for (index, entry) in entries.iter().enumerate() {
        cutters.entry(&entry.cutter_id).or_default().push((index, entry));
    }
    let mut conflicts = Vec::new();
    for (cutter_id, posted) in cutters {
        let Some((_, WearEntry { machine_id, tool_id, .. })) = posted.first() else { continue };
        let quantity = posted.first().map_or("", |(_, entry)| entry.wear().0.as_str());
        let other: Option<String> = sql!(
            tx,
            optional(_),
            "SELECT id FROM wear_entries WHERE machine_id = $1 AND tool_id = $2 AND cutter_id = $3 AND quantity <> $4
               AND NOT EXISTS (SELECT 1 FROM wear_withdrawals WHERE entry_seq = seq) LIMIT 1",
            machine_id,
            tool_id,
            cutter_id,
            quantity
        )?;
        let first = posted.first().filter(|_| other.is_some());
        conflicts.extend(first.map(|(index, _)| WearConflict::OtherQuantity { index: *index }));
        let there = sql!(
            tx,
            all(EdgeCount),
            "SELECT edge, COUNT(*) AS \"count!\" FROM wear_entries
             WHERE machine_id = $1 AND tool_id = $2 AND cutter_id = $3 GROUP BY edge",
            machine_id,
            tool_id,
            cutter_id
        )?;
        let mut edges: BTreeSet<String> = there.iter().map(|row| row.edge.clone()).collect();
        let kept: i64 = there.iter().map(|row| row.count).sum();
        let room = MAX_WEAR_ENTRIES.saturating_sub(usize::try_from(kept).unwrap_or(usize::MAX));
        conflicts.extend(posted.get(room).map(|(index, _)| WearConflict::TooMany { index: *index }));
        let one_too_many = posted.iter().find(|(_, entry)| {
            edges.insert(entry.edge.clone().unwrap_or_default());
            edges.len() > MAX_WEAR_EDGES
        });
        conflicts.extend(one_too_many.map(|(index, _)| WearConflict::TooManyEdges { index: *index }));
    }
    Ok(conflicts)
}

async fn insert(tx: &mut Tx<'_>, entry: &WearEntry, posted_with: &str) -> Result<(), sqlx::Error> {
    let (quantity, wear_um) = entry.wear();
    let (edge, quantity) = (entry.edge.as_deref().unwrap_or_default(), quantity.as_str());
    sql!(
        tx,
        execute,
        "INSERT INTO wear_entries (id, machine_id, tool_id, cutter_id, edge, quantity, parts_cut, wear_um,
             standard_uncertainty_um, measured_at, created_at, note, posted_with)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13)",
        entry.id,
        entry.machine_id,
        entry.tool_id,
        entry.cutter_id,
        edge,
        quantity,
        i64::from(entry.parts_cut),
        wear_um,
        entry.standard_uncertainty_um,
        entry.measured_at,
        entry.created_at,
        entry.note,
        posted_with
    )?;
    Ok(())
}
