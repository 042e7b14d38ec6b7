//! Removes files that several services keep together and that no job names. Their rows go first. A service that keeps
//! the same bytes meanwhile makes an object with another name.

use std::collections::BTreeSet;

use super::machines::as_array;
use super::{Blobs, Sha256Hex, Store, StoreError};

/// Files removed in one transaction: each may have thousands of parts.
const REMOVED_AT_ONCE: i64 = 20;

impl Store {
    /// The same files, kept where this database keeps them.
    #[must_use]
    #[cfg_attr(
        not(feature = "scale-out"),
        expect(clippy::cloned_instead_of_copied, reason = "no such value exists")
    )]
    pub fn keeping(&self, blobs: Blobs) -> Blobs {
        blobs.kept_in(self.files().cloned())
    }

    /// Removes files of the database that no job names, all or only some, and counts them. A file that was kept within a
    /// day stays: a service may be about to name it. Objects whose last part never came go too.
    ///
    /// # Errors
    /// The database failed.
    pub async fn remove_unnamed(&self, only: Option<&BTreeSet<Sha256Hex>>) -> Result<u64, StoreError> {
        #[cfg(feature = "scale-out")]
        if let Some(files) = self.files() {
            // Boxed, so that the futures of all callers keep their size.
            Box::pin(files.end_uploads()).await?;
        }
        let only = as_array(only);
        let mut removed = 0;
        loop {
            let only = only.clone();
            let some = self
                .write_apart("removing files that no job names", |tx| {
                    Box::pin(async move {
                        // Whoever names a file at this moment holds its row.
                        let found: Vec<String> = sql!(
                            tx,
                            all(_),
                            postgres "SELECT object_key FROM files f
                                WHERE kept_at < clock_timestamp() - INTERVAL '1 day' AND upload_id IS NULL
                                  AND (CAST($1 AS TEXT) IS NULL OR sha256 IN (SELECT value FROM json_each($1)))
                                  AND (whole = 0 OR NOT EXISTS (SELECT 1 FROM jobs WHERE input_sha256 = f.sha256)
                                      AND NOT EXISTS (SELECT 1 FROM jobs WHERE output_sha256 = f.sha256)
                                      AND NOT EXISTS (SELECT 1 FROM jobs WHERE surface_sha256 = f.sha256)
                                      AND NOT EXISTS (SELECT 1 FROM jobs WHERE changes_sha256 = f.sha256))
                                LIMIT $2 FOR UPDATE SKIP LOCKED",
                            only,
                            REMOVED_AT_ONCE
                        )?;
                        let found = serde_json::Value::from(found).to_string();
                        // Asked again, now that nobody else can name them.
                        let gone: Vec<String> = sql!(
                            tx,
                            all(_),
                            postgres "DELETE FROM files f
                                WHERE object_key IN (SELECT value FROM json_each(CAST($1 AS TEXT)))
                                  AND (whole = 0 OR NOT EXISTS (SELECT 1 FROM jobs WHERE input_sha256 = f.sha256)
                                      AND NOT EXISTS (SELECT 1 FROM jobs WHERE output_sha256 = f.sha256)
                                      AND NOT EXISTS (SELECT 1 FROM jobs WHERE surface_sha256 = f.sha256)
                                      AND NOT EXISTS (SELECT 1 FROM jobs WHERE changes_sha256 = f.sha256))
                                RETURNING object_key",
                            found
                        )?;
                        Ok(gone)
                    })
                })
                .await?;
            removed += some.len() as u64;
            if some.is_empty() {
                return Ok(removed);
            }
            #[cfg(feature = "scale-out")]
            if let Some(files) = self.files() {
                Box::pin(files.forget(&some)).await;
            }
        }
    }

    /// Removes objects of the bucket that no row names and that were made more than a day ago, and counts them. Without a
    /// bucket there are none.
    ///
    /// # Errors
    /// The database or the server of the bucket failed.
    #[cfg_attr(not(feature = "scale-out"), expect(clippy::unused_async, reason = "there is no bucket"))]
    pub async fn sweep_bucket(&self) -> Result<u64, StoreError> {
        #[cfg(feature = "scale-out")]
        if let Some(files) = self.files() {
            return Box::pin(files.sweep()).await;
        }
        Ok(0)
    }
}
