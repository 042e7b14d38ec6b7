//! Programs and results for several services that share no disk. A row of the database names each, its bytes are rows
//! too or an object in a bucket. Threads that compute read and write them, so those functions wait for their answer
//! (`docs/scale-out.md`).

mod credentials;
mod in_rows;
mod objects;
mod statements;

use std::fmt;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::time::Duration;

use futures::StreamExt;
use sqlx::Error;
use sqlx::postgres::{PgConnectOptions, PgPool};
use tokio::runtime::Handle;

pub(super) use self::objects::Listed;
use self::objects::Objects;
use self::statements::Upload;
use super::error::Doing;
use super::postgres::pool;
use super::presence::Presence;
use super::{BlobFault, StoreError, Verifying};
use crate::config::{FilesIn, Settings};

/// Connections for files: a long upload does not hold up the rows.
const CONNECTIONS: u32 = 4;
/// Longest time for the parts of one transaction, and for one part that is read.
const PARTS_WITHIN: Duration = Duration::from_secs(40);
/// How often a file is kept again if it was removed while it was being kept.
const ATTEMPTS: usize = 3;
/// How long the end of the service waits for connections that are in use.
const CLOSED_WITHIN: Duration = Duration::from_secs(2);
/// Bytes of a part of an object, if the object does not have too many of them. S3 takes 5 MiB and more.
const PART_BYTES: u64 = 8 << 20;
/// Most parts of an object: S3 takes 10 000.
const MOST_PARTS: u64 = 9_000;
/// Bytes of an object that are read at once.
const READ_BYTES: u64 = 4 << 20;
/// Objects of a list that are compared with rows at once.
const LISTED_AT_ONCE: usize = 1000;

/// The files of a database.
#[derive(Clone)]
pub(super) struct SharedFiles {
    connections: PgPool,
    presence: Presence,
    runtime: Handle,
    bytes: Bytes,
}

/// Where the bytes are.
#[derive(Debug, Clone)]
enum Bytes {
    /// In rows.
    Rows,
    /// In objects.
    Objects(Objects),
}

impl fmt::Debug for SharedFiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SharedFiles({:?})", self.bytes)
    }
}

impl SharedFiles {
    /// The files of the database at this address and with this name, in this place.
    ///
    /// # Errors
    /// The server of the database does not answer, or the settings of the bucket cannot be used.
    pub(super) async fn connect(
        options: PgConnectOptions,
        presence: Presence,
        (place, settings): (&FilesIn, &Settings),
        database_id: &str,
    ) -> Result<Self, StoreError> {
        let bytes = match place {
            FilesIn::Objects(bucket) => Bytes::Objects(Objects::of(bucket, settings, database_id)?),
            FilesIn::Directory | FilesIn::Postgres => Bytes::Rows,
        };
        let connections = pool(options, CONNECTIONS, &presence).await?;
        Ok(Self { connections, presence, runtime: Handle::current(), bytes })
    }

    /// Makes sure that objects can be kept. `is_new`: the database has no files yet. `name` was never used before.
    ///
    /// # Errors
    /// The server of the bucket refuses something, or the bucket does not have the files of this database.
    pub(super) async fn enter(&self, is_new: bool, name: &str) -> Result<(), StoreError> {
        match &self.bytes {
            Bytes::Rows => Ok(()),
            Bytes::Objects(objects) => objects.enter(is_new, name).await,
        }
    }

    /// Whether the server of the bucket answers, if there is one.
    ///
    /// # Errors
    /// It does not.
    pub(super) async fn check(&self) -> Result<(), StoreError> {
        match &self.bytes {
            Bytes::Rows => Ok(()),
            Bytes::Objects(objects) => objects.check().await,
        }
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

    /// The same for a call that has a deadline of its own.
    fn wait<T>(&self, call: impl Future<Output = Result<T, StoreError>>) -> Result<T, BlobFault> {
        self.runtime.block_on(call).map_err(BlobFault::Rows)
    }

    /// Keeps the bytes of a file. They are there, and nobody removes them within a day, when this returns. Blocks.
    ///
    /// # Errors
    /// The file cannot be read, or the database or the server of the bucket failed. Nothing is kept then.
    pub(super) fn keep(&self, sha256: &str, file: &File, length: u64) -> Result<(), BlobFault> {
        let doing = "keeping a file";
        let rows = i64::try_from(length).unwrap_or(i64::MAX);
        for _ in 0..ATTEMPTS {
            let before = self.answer(doing, self.touch(sha256))?;
            if let Some(kept) = &before
                && kept.length == rows
                && self.length(&kept.object_key)? == Some(length)
            {
                return Ok(());
            }
            let object = self.answer(doing, self.begin(sha256, rows))?;
            let mut upload = None;
            let ended = self
                .store(&object, sha256, file, length, &mut upload)
                .and_then(|()| self.answer(doing, self.end(&object, sha256, before.as_ref())));
            match ended {
                Ok(true) => return Ok(()),
                // Another service has kept the same bytes meanwhile.
                Ok(false) => self.wait(self.discard(&object, upload.as_ref()))?,
                Err(fault) => {
                    // Else it goes after a day.
                    if let Err(left) = self.wait(self.discard(&object, upload.as_ref())) {
                        tracing::debug!(error = %left, "a file that was not kept is not removed yet");
                    }
                    return Err(fault);
                }
            }
        }
        Err(BlobFault::Rows(StoreError::Busy(Error::PoolTimedOut)))
    }

    /// Stores the bytes of an object that has a row, and says of the upload if there is one.
    fn store(
        &self,
        object: &str,
        sha256: &str,
        file: &File,
        length: u64,
        upload: &mut Option<String>,
    ) -> Result<(), BlobFault> {
        let unread = |source| BlobFault::File {
            doing: "reading a file that is to be kept,",
            path: sha256.into(),
            source,
        };
        let objects = match &self.bytes {
            Bytes::Rows => {
                let mut first = 0;
                loop {
                    let parts = in_rows::parts(file, first).map_err(unread)?;
                    if parts.is_empty() {
                        return Ok(());
                    }
                    let added = in_rows::add(&self.connections, object, first, &parts);
                    self.answer("keeping a part of a file", added)?;
                    first += in_rows::PARTS_AT_ONCE;
                }
            }
            Bytes::Objects(objects) => objects,
        };
        let size = PART_BYTES.max(length.div_ceil(MOST_PARTS));
        if length > size {
            let begun = upload.insert(self.wait(objects.begin(object))?);
            self.answer("noting an upload", self.note_upload(object, Some(begun)))?;
        }
        let (mut verifying, mut parts, mut at) = (Verifying::new(sha256), Vec::new(), 0);
        loop {
            let turn = self.wait(objects.turn())?;
            let bytes = filled(file, at, usize::try_from(size).unwrap_or(usize::MAX)).map_err(unread)?;
            verifying.take(&bytes);
            at += bytes.len() as u64;
            let is_last = at >= length || bytes.is_empty();
            if is_last && let Err(other) = verifying.clone().finish() {
                return Err(unread(io::Error::other(other)));
            }
            match upload.as_ref() {
                Some(upload) => parts.push(self.wait(objects.add(object, upload, parts.len(), bytes))?),
                None => self.wait(objects.put(object, bytes))?,
            }
            drop(turn);
            if is_last {
                break;
            }
        }
        if let Some(upload) = upload.as_ref() {
            self.wait(objects.complete(object, upload, parts))?;
        }
        match self.wait(objects.length(object))? {
            Some(found) if found == length => Ok(()),
            found => {
                let reason = format!("of {length} bytes the bucket has {}", found.unwrap_or(0));
                Err(BlobFault::Rows(StoreError::Objects { doing: "comparing a file that was kept", reason }))
            }
        }
    }

    /// The length of what is stored of an object \[bytes\]. Blocks.
    fn length(&self, object: &str) -> Result<Option<u64>, BlobFault> {
        match &self.bytes {
            Bytes::Rows => {
                let length = self
                    .answer("asking for the length of a file", in_rows::length(&self.connections, object))?;
                Ok(u64::try_from(length).ok())
            }
            Bytes::Objects(objects) => self.wait(objects.length(object)),
        }
    }

    /// Reads a file from its first byte to its last, part by part. `false` if it is not kept. Blocks.
    ///
    /// # Errors
    /// The database or the server of the bucket failed, or `each` did.
    pub(super) fn read(
        &self,
        sha256: &str,
        mut each: impl FnMut(&[u8]) -> Result<(), BlobFault>,
    ) -> Result<bool, BlobFault> {
        let doing = "reading a file";
        // The object may be removed before it is read, and another one may stand for the digest then.
        for _ in 0..ATTEMPTS {
            let Some(object) = self.answer(doing, self.whole(sha256))? else { return Ok(false) };
            if self.read_object(&object, &mut each)? {
                return Ok(true);
            }
            if self.answer(doing, self.whole(sha256))?.as_ref() == Some(&object) {
                return Ok(false);
            }
        }
        Ok(false)
    }

    /// Reads an object. `false` if it is not there; nothing was read then. Blocks.
    ///
    /// # Errors
    /// The same as [`Self::read`].
    fn read_object(
        &self,
        object: &str,
        each: &mut impl FnMut(&[u8]) -> Result<(), BlobFault>,
    ) -> Result<bool, BlobFault> {
        let objects = match &self.bytes {
            Bytes::Rows => {
                for part in 0.. {
                    match self.answer("reading a file", in_rows::part(&self.connections, object, part))? {
                        Some(bytes) => each(&bytes)?,
                        None => break,
                    }
                }
                return Ok(true);
            }
            Bytes::Objects(objects) => objects,
        };
        let Some(length) = self.wait(objects.length(object))? else { return Ok(false) };
        let mut at = 0;
        while at < length {
            let bytes = {
                let _turn = self.wait(objects.turn())?;
                self.wait(objects.bytes(object, at..length.min(at + READ_BYTES)))?
            };
            // What is gone or shorter than it was has another digest.
            let Some(bytes) = bytes.filter(|bytes| !bytes.is_empty()) else { break };
            each(&bytes)?;
            at += bytes.len() as u64;
        }
        Ok(true)
    }

    /// Whether all bytes of an object are there, and have this digest.
    ///
    /// # Errors
    /// The database or the server of the bucket failed.
    pub(super) async fn is_sound(&self, object: &str, sha256: &str) -> Result<bool, StoreError> {
        let (files, object, sha256) = (self.clone(), object.to_owned(), sha256.to_owned());
        let read = move || {
            let mut verifying = Verifying::new(&sha256);
            let mut take = |bytes: &[u8]| {
                verifying.take(bytes);
                Ok(())
            };
            files.read_object(&object, &mut take).map(|is_there| is_there && verifying.finish().is_ok())
        };
        match tokio::task::spawn_blocking(read).await.map_err(|fault| Error::Io(fault.into())) {
            Ok(Ok(is_sound)) => Ok(is_sound),
            Ok(Err(BlobFault::Rows(fault))) => Err(fault),
            // Nothing else can fail: no file of this computer is read.
            Ok(Err(other)) => Err(Error::Io(io::Error::other(other))).doing("examining files"),
            Err(fault) => Err(fault).doing("examining files"),
        }
    }

    /// All objects of the bucket with their lengths, if there is one.
    ///
    /// # Errors
    /// Its server does not answer.
    pub(super) async fn listed(&self) -> Result<Option<Vec<Listed>>, StoreError> {
        let Bytes::Objects(objects) = &self.bytes else { return Ok(None) };
        let mut listed = Vec::new();
        let mut found = objects.list();
        while let Some(object) = found.next().await {
            listed.push(object?);
        }
        Ok(Some(listed))
    }

    /// Removes objects whose rows are gone: nobody else knows their keys. What cannot be removed now goes with
    /// [`Self::sweep`].
    pub(super) async fn forget(&self, removed: &[String]) {
        let Bytes::Objects(objects) = &self.bytes else { return };
        for object in removed {
            if let Err(fault) = objects.remove(object).await {
                tracing::warn!(error = %fault, "a file is not removed from the bucket yet");
            }
        }
    }

    /// Ends uploads that began more than a day ago: their services have died. Their rows can go then, and not before: no
    /// list of the bucket names an upload.
    ///
    /// # Errors
    /// The database failed, or the server of the bucket does not answer: no row should go then, because its object would
    /// stay.
    pub(super) async fn end_uploads(&self) -> Result<(), StoreError> {
        let Bytes::Objects(objects) = &self.bytes else { return Ok(()) };
        objects.check().await?;
        let doing = "looking for uploads that have not ended";
        let begun = self.presence.within(PARTS_WITHIN, self.uploads()).await.doing(doing)?;
        for Upload { object_key, upload_id } in begun {
            objects.abort(&object_key, &upload_id).await?;
            let ended = self.presence.within(PARTS_WITHIN, self.note_upload(&object_key, None)).await;
            ended.doing("noting that an upload has ended")?;
        }
        Ok(())
    }

    /// Removes objects that no row names and that were made more than a day ago, and counts them. A row is there before
    /// its object, so nobody is about to name them.
    ///
    /// # Errors
    /// The database or the server of the bucket failed.
    pub(super) async fn sweep(&self) -> Result<u64, StoreError> {
        let Bytes::Objects(objects) = &self.bytes else { return Ok(0) };
        let doing = "looking for files that no row names";
        let ask = async { self.presence.within(PARTS_WITHIN, self.a_day_ago()).await.doing(doing) };
        let (a_day_ago_s, mut removed) = (ask.await?, 0);
        let mut pages = objects.list().chunks(LISTED_AT_ONCE);
        while let Some(page) = pages.next().await {
            let page = page.into_iter().collect::<Result<Vec<Listed>, StoreError>>()?;
            let old = page.into_iter().filter(|object| object.made_s < a_day_ago_s).map(|object| object.key);
            let old = serde_json::Value::from(old.collect::<Vec<_>>()).to_string();
            let nameless = self.presence.within(PARTS_WITHIN, self.nameless(&old)).await.doing(doing)?;
            for object in nameless {
                objects.remove(&object).await?;
                removed += 1;
            }
        }
        Ok(removed)
    }

    /// Removes an object that does not stand for its digest: its upload, its row, and then the object.
    async fn discard(&self, object: &str, upload: Option<&String>) -> Result<(), StoreError> {
        if let (Bytes::Objects(objects), Some(upload)) = (&self.bytes, upload) {
            objects.abort(object, upload).await?;
        }
        let gone = self.presence.within(PARTS_WITHIN, self.remove(object)).await;
        let gone = gone.doing("removing a file that was not kept")?;
        self.forget(&gone).await;
        Ok(())
    }

    /// Closes the connections.
    pub(super) async fn close(&self) {
        let _in_time = tokio::time::timeout(CLOSED_WITHIN, self.connections.close()).await;
    }
}

/// Bytes of a file from this place on: `length` bytes, or fewer if the file ends before.
fn filled(file: &File, mut at: u64, length: usize) -> io::Result<Vec<u8>> {
    let rest = file.metadata()?.len().saturating_sub(at);
    let mut part = vec![0; length.min(usize::try_from(rest).unwrap_or(length))];
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
    Ok(part)
}
