//! Programs and results as rows of the database, in parts, for several services that share no disk. Threads that compute
//! read and write them, so every function here waits for its answer (`docs/scale-out.md`).

use std::fmt;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::time::Duration;

use sqlx::postgres::{PgConnectOptions, PgPool};
use sqlx::{Connection, Error};
use tokio::runtime::Handle;

use super::error::Doing;
use super::postgres::pool;
use super::presence::Presence;
use super::{BlobFault, StoreError};

/// Connections for files: a long upload does not hold up the rows.
const CONNECTIONS: u32 = 4;
/// Bytes of a part.
const PART_BYTES: usize = 1 << 20;
/// Parts stored in one transaction.
const PARTS_AT_ONCE: i64 = 16;
/// Longest time for the parts of one transaction, and for one part that is read.
const PARTS_WITHIN: Duration = Duration::from_secs(40);
/// How often a file is kept again if it was removed while it was being kept.
const ATTEMPTS: usize = 3;
/// How long the end of the service waits for connections that are in use.
const CLOSED_WITHIN: Duration = Duration::from_secs(2);

/// The files of a database.
#[derive(Clone)]
pub(super) struct FileRows {
    connections: PgPool,
    presence: Presence,
    runtime: Handle,
}

impl fmt::Debug for FileRows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("FileRows")
    }
}

impl FileRows {
    /// The files of the database at this address.
    ///
    /// # Errors
    /// The server does not answer.
    pub(super) async fn connect(options: PgConnectOptions, presence: Presence) -> Result<Self, StoreError> {
        let connections = pool(options, CONNECTIONS, &presence).await?;
        Ok(Self { connections, presence, runtime: Handle::current() })
    }

    /// Waits for an answer on a thread that may wait.
    fn answer<T>(
        &self,
        doing: &'static str,
        call: impl Future<Output = Result<T, Error>>,
    ) -> Result<T, BlobFault> {
        let answered = self.runtime.block_on(self.presence.within(PARTS_WITHIN, call));
        answered.doing(doing).map_err(BlobFault::Rows)
    }

    /// Keeps the bytes of a file. They are there, and nobody removes them within a day, when this returns. Blocks.
    ///
    /// # Errors
    /// The file cannot be read, or the database failed.
    pub(super) fn keep(&self, sha256: &str, file: &File, length: u64) -> Result<(), BlobFault> {
        let rows = i64::try_from(length).unwrap_or(i64::MAX);
        for _ in 0..ATTEMPTS {
            if self.answer("keeping a file", self.touch(sha256))? {
                return Ok(());
            }
            let object = self.answer("keeping a file", self.begin(sha256, rows))?;
            let mut first = 0;
            loop {
                let parts = parts(file, first).map_err(|source| BlobFault::File {
                    doing: "reading a file that is to be kept,",
                    path: sha256.into(),
                    source,
                })?;
                if parts.is_empty() {
                    break;
                }
                self.answer("keeping a part of a file", self.add(&object, first, &parts))?;
                first += PARTS_AT_ONCE;
            }
            if self.answer("keeping a file", self.end(&object, sha256))? {
                return Ok(());
            }
            // Another service has kept the same bytes meanwhile.
            self.answer("removing a file that was kept twice", self.remove(&object))?;
        }
        Err(BlobFault::Rows(StoreError::Busy(Error::PoolTimedOut)))
    }

    /// Reads a file from its first byte to its last, part by part. `false` if it is not kept. Blocks.
    ///
    /// # Errors
    /// The database failed, or `each` did.
    pub(super) fn read(
        &self,
        sha256: &str,
        mut each: impl FnMut(&[u8]) -> Result<(), BlobFault>,
    ) -> Result<bool, BlobFault> {
        let doing = "reading a file";
        let Some(object) = self.answer(doing, self.whole(sha256))? else { return Ok(false) };
        for part in 0.. {
            match self.answer(doing, self.part(&object, part))? {
                Some(bytes) => each(&bytes)?,
                None => break,
            }
        }
        Ok(true)
    }

    /// Closes the connections.
    pub(super) async fn close(&self) {
        let _in_time = tokio::time::timeout(CLOSED_WITHIN, self.connections.close()).await;
    }

    /// Whether the file is kept already; it is then kept for another day.
    async fn touch(&self, sha256: &str) -> Result<bool, Error> {
        let mut connection = self.connections.acquire().await?;
        let touched: u64 = postgres!(
            &mut *connection,
            execute,
            "UPDATE files SET kept_at = clock_timestamp() WHERE sha256 = $1 AND whole = 1",
            sha256
        )?;
        Ok(touched > 0)
    }

    /// A new object without parts.
    async fn begin(&self, sha256: &str, length: i64) -> Result<String, Error> {
        let mut connection = self.connections.acquire().await?;
        let object: Result<String, Error> = postgres!(
            &mut *connection,
            one(_),
            "INSERT INTO files (object_key, sha256, length)
             VALUES (CAST($1 AS TEXT) || '-' || CAST(gen_random_uuid() AS TEXT), $1, $2) RETURNING object_key",
            sha256,
            length
        );
        object
    }

    /// Some parts, the first of which has this number.
    async fn add(&self, object: &str, first: i64, parts: &[Vec<u8>]) -> Result<(), Error> {
        let mut connection = self.connections.acquire().await?;
        let mut transaction = connection.begin().await?;
        for (number, bytes) in (first..).zip(parts) {
            let bytes = bytes.as_slice();
            let done: Result<u64, Error> = postgres!(
                &mut *transaction,
                execute,
                "INSERT INTO file_parts (object_key, part, bytes) VALUES ($1, $2, $3)",
                object,
                number,
                bytes
            );
            done?;
        }
        transaction.commit().await
    }

    /// Whether the object is whole and stands for its digest from now on; `false` if another one does.
    async fn end(&self, object: &str, sha256: &str) -> Result<bool, Error> {
        let mut connection = self.connections.acquire().await?;
        let done: Result<u64, Error> = postgres!(
            &mut *connection,
            execute,
            "UPDATE files SET whole = 1, kept_at = clock_timestamp() WHERE object_key = $1
                 AND NOT EXISTS (SELECT 1 FROM files o WHERE o.sha256 = $2 AND o.whole = 1)",
            object,
            sha256
        );
        match done {
            Ok(ended) => Ok(ended > 0),
            // The other one was stored between the question and the answer.
            Err(Error::Database(fault)) if fault.is_unique_violation() => Ok(false),
            Err(fault) => Err(fault),
        }
    }

    async fn remove(&self, object: &str) -> Result<(), Error> {
        let mut connection = self.connections.acquire().await?;
        let done: Result<u64, Error> =
            postgres!(&mut *connection, execute, "DELETE FROM files WHERE object_key = $1", object);
        done.map(drop)
    }

    /// The object that stands for a digest.
    async fn whole(&self, sha256: &str) -> Result<Option<String>, Error> {
        let mut connection = self.connections.acquire().await?;
        let object: Result<Option<String>, Error> = postgres!(
            &mut *connection,
            optional(_),
            "SELECT object_key FROM files WHERE sha256 = $1 AND whole = 1",
            sha256
        );
        object
    }

    async fn part(&self, object: &str, number: i64) -> Result<Option<Vec<u8>>, Error> {
        let mut connection = self.connections.acquire().await?;
        let bytes: Result<Option<Vec<u8>>, Error> = postgres!(
            &mut *connection,
            optional(_),
            "SELECT bytes FROM file_parts WHERE object_key = $1 AND part = $2",
            object,
            number
        );
        bytes
    }
}

/// The parts of a file that one transaction stores, from this one on.
fn parts(file: &File, first: i64) -> io::Result<Vec<Vec<u8>>> {
    let mut at = u64::try_from(first).unwrap_or(0) * PART_BYTES as u64;
    let mut parts = Vec::new();
    for _ in 0..PARTS_AT_ONCE {
        let mut part = vec![0; PART_BYTES];
        let mut filled = 0;
        while let Some(rest) = part.get_mut(filled..).filter(|rest| !rest.is_empty()) {
            match file.read_at(rest, at) {
                Ok(0) => break,
                Ok(read) => {
                    filled += read;
                    at += read as u64;
                }
                Err(fault) if fault.kind() == io::ErrorKind::Interrupted => {}
                Err(fault) => return Err(fault),
            }
        }
        part.truncate(filled);
        if filled > 0 {
            parts.push(part);
        }
        if filled < PART_BYTES {
            break;
        }
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_file_are_its_bytes_whatever_its_length() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("file");
        let most = usize::try_from(PARTS_AT_ONCE).unwrap() * PART_BYTES;
        for length in [0, 1, PART_BYTES - 1, PART_BYTES, PART_BYTES + 1, most, most + 1] {
            let bytes: Vec<u8> = (0..=250_u8).cycle().take(length).collect();
            std::fs::write(&path, &bytes).unwrap();
            let (file, mut read, mut first) = (File::open(&path).unwrap(), Vec::new(), 0);
            loop {
                let some = parts(&file, first).unwrap();
                if some.is_empty() {
                    break;
                }
                assert!(some.iter().all(|part| part.len() <= PART_BYTES));
                read.extend(some.concat());
                first += PARTS_AT_ONCE;
            }
            assert!(read == bytes, "{length}");
        }
    }
}
