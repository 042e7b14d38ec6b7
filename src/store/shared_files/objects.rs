//! Files as objects in a bucket of S3. An object has a key of its own that is never used again: a digest and a
//! generation. Every call has a deadline. After a call to a server that does not answer, further ones are refused for a
//! moment, so that requests do not wait one after the other.

use std::error::Error as _;
use std::fmt;
use std::io;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bytes::Bytes;
use futures::stream::{BoxStream, StreamExt};
use object_store::aws::{AmazonS3, AmazonS3Builder, AmazonS3ConfigKey, AwsCredential};
use object_store::client::{HttpError, HttpErrorKind};
use object_store::multipart::{MultipartStore, PartId};
use object_store::path::Path;
use object_store::{
    BackoffConfig, ClientOptions, Error, ObjectMeta, ObjectStore, ObjectStoreExt, PutPayload, RetryConfig,
    StaticCredentialProvider,
};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::credentials::Credentials;
use crate::config::{Bucket, Settings};
use crate::store::StoreError;

/// Longest time until a connection is there.
const CONNECTED_WITHIN: Duration = Duration::from_secs(3);
/// Longest time of one request with its body.
const REQUEST_WITHIN: Duration = Duration::from_secs(20);
/// How long a request that failed is sent again.
const RETRIED_FOR: Duration = Duration::from_secs(8);
/// How often a request that failed is sent again.
const RETRIES: usize = 4;
/// Longest time of one call, with everything that is sent again.
const CALLED_WITHIN: Duration = Duration::from_secs(40);
/// Longest time of the question whether the server is there.
const CHECKED_WITHIN: Duration = Duration::from_secs(3);
/// How long an answer to that question is valid.
const HOLDS: Duration = Duration::from_secs(1);
/// How long nothing is asked of a server that did not answer.
const PAUSE: Duration = Duration::from_secs(1);
/// Parts that are sent and read at the same time: they are in memory.
const AT_ONCE: usize = 4;
/// The object that says whose files these are.
const MARK: &str = "database.id";
/// The reason if TLS fails.
const TLS_FAILED: &str = "its certificate is not trusted, or TLS fails in another way";
/// Longest part of a code of the server that is passed on \[characters\].
const MAX_CODE: usize = 40;

/// When the server was asked whether it is there, and what was wrong.
type Checked = Option<(Instant, Option<String>)>;

/// The objects of one database.
#[derive(Clone)]
pub(super) struct Objects {
    client: AmazonS3,
    bucket: Bucket,
    root: String,
    turns: Arc<Semaphore>,
    /// When the server did not answer, and why.
    away: Arc<Mutex<Option<(Instant, String)>>>,
    checked: Arc<tokio::sync::Mutex<Checked>>,
}

impl fmt::Debug for Objects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Objects({})", self.bucket)
    }
}

/// An object in a list.
pub(in crate::store) struct Listed {
    pub(in crate::store) key: String,
    pub(in crate::store) length: u64,
    /// When it was made, by the clock of its server \[s since 1970\].
    pub(in crate::store) made_s: i64,
}

impl Objects {
    /// The objects of the database with this name.
    ///
    /// # Errors
    /// The settings cannot be used.
    pub(super) fn of(bucket: &Bucket, settings: &Settings, database_id: &str) -> Result<Self, StoreError> {
        // The client takes the provider of the process; another one may be there already.
        let _there = rustls::crypto::ring::default_provider().install_default();
        // The usual variables: keys, roles, tokens of a pod, region. What decides here is not taken from them.
        let mut builder = AmazonS3Builder::from_env()
            .with_bucket_name(bucket.name())
            .with_virtual_hosted_style_request(false)
            .with_unsigned_payload(false)
            .with_skip_signature(false)
            .with_disable_bulk_delete(true)
            .with_retry(RetryConfig {
                backoff: BackoffConfig {
                    init_backoff: Duration::from_millis(100),
                    max_backoff: Duration::from_secs(2),
                    base: 2.0,
                },
                max_retries: RETRIES,
                retry_timeout: RETRIED_FOR,
            });
        if let Some(endpoint) = &settings.files_endpoint {
            builder = builder.with_endpoint(endpoint.trim_end_matches('/'));
        }
        if let Some(path) = &settings.files_credentials_file {
            let Credentials { key_id, secret, token } = Credentials::read(path)?;
            // All three at once: a token of the environment belongs to other keys.
            let keys = AwsCredential { key_id, secret_key: secret, token };
            builder = builder.with_credentials(Arc::new(StaticCredentialProvider::new(keys)));
        }
        let is_plain = builder
            .get_config_value(&AmazonS3ConfigKey::Endpoint)
            .is_some_and(|endpoint| endpoint.starts_with("http://"));
        let client = ClientOptions::new()
            .with_allow_http(is_plain)
            .with_connect_timeout(CONNECTED_WITHIN)
            .with_timeout(REQUEST_WITHIN)
            .with_http1_only();
        let doing = "reading the settings of the bucket";
        let unusable = |fault: Error| {
            // The fault may quote a variable.
            let is_http = matches!(fault, Error::Generic { store: "HTTP client", .. });
            let what = if is_http { "the certificates of this computer" } else { "the variables AWS_…" };
            StoreError::Objects { doing, reason: format!("{what} cannot be used") }
        };
        let client = builder.with_client_options(client).build().map_err(unusable)?;
        let slash = if bucket.prefix().is_empty() { "" } else { "/" };
        Ok(Self {
            client,
            bucket: bucket.clone(),
            root: format!("{}{slash}{database_id}", bucket.prefix()),
            turns: Arc::new(Semaphore::new(AT_ONCE)),
            away: Arc::default(),
            checked: Arc::default(),
        })
    }

    /// Makes sure that the bucket is the one of this database, and that objects can be made and removed there. `is_new`:
    /// the database has no files yet. `name` was never used before.
    ///
    /// # Errors
    /// The server refuses something, or the bucket does not have the files of this database.
    pub(super) async fn enter(&self, is_new: bool, name: &str) -> Result<(), StoreError> {
        let doing = "asking for the keys to the bucket";
        let keys = async { self.client.credentials().get_credential().await };
        self.call(doing, CALLED_WITHIN, keys).await?;
        let mark = self.mark();
        let doing = "looking for the files of this database in the bucket";
        if self.call(doing, CALLED_WITHIN, self.client.head(&mark)).await?.is_none() {
            if !is_new {
                let (bucket, mark) = (self.bucket.to_string(), mark.to_string());
                return Err(StoreError::NoObjects { bucket, mark });
            }
            let text = "Files of a trunnion service. It removes what its database does not name.\n";
            self.made("marking the bucket", self.client.put(&mark, PutPayload::from(text))).await?;
        }
        let trial = Path::from(format!("{}/trial-{name}", self.root));
        self.made("trying to write to the bucket", self.client.put(&trial, PutPayload::from("trial\n")))
            .await?;
        self.call("trying to remove from the bucket", CALLED_WITHIN, self.client.delete(&trial)).await?;
        Ok(())
    }

    /// Whether the server answers; the result is at most a second old.
    ///
    /// # Errors
    /// It does not, or the bucket does not have the files of this database.
    pub(super) async fn check(&self) -> Result<(), StoreError> {
        let doing = "looking whether the bucket is there";
        let mut checked = self.checked.lock().await;
        let fault = match &*checked {
            Some((at, fault)) if at.elapsed() < HOLDS => fault.clone(),
            _ => {
                let found = self.call(doing, CHECKED_WITHIN, self.client.head(&self.mark())).await;
                let fault = match found {
                    Ok(Some(_)) => None,
                    Ok(None) => Some(not_ours()),
                    Err(StoreError::Objects { reason, .. }) => Some(reason),
                    Err(other) => Some(other.to_string()),
                };
                *checked = Some((Instant::now(), fault.clone()));
                fault
            }
        };
        fault.map_or(Ok(()), |reason| Err(StoreError::Objects { doing, reason }))
    }

    /// A turn to have a part in memory.
    ///
    /// # Errors
    /// All turns are taken for too long.
    pub(super) async fn turn(&self) -> Result<OwnedSemaphorePermit, StoreError> {
        let turn = tokio::time::timeout(CALLED_WITHIN, Arc::clone(&self.turns).acquire_owned()).await;
        turn.ok().and_then(Result::ok).ok_or(StoreError::Busy(sqlx::Error::PoolTimedOut))
    }

    /// Makes an object.
    pub(super) async fn put(&self, object: &str, bytes: Vec<u8>) -> Result<(), StoreError> {
        let key = self.key(object);
        self.made("keeping a file", self.client.put(&key, bytes.into())).await.map(drop)
    }

    /// Begins an object of several parts; the answer is the name of the upload.
    pub(super) async fn begin(&self, object: &str) -> Result<String, StoreError> {
        self.made("beginning to keep a file", self.client.create_multipart(&self.key(object))).await
    }

    /// Adds the part with this number.
    pub(super) async fn add(
        &self,
        object: &str,
        upload: &String,
        number: usize,
        bytes: Vec<u8>,
    ) -> Result<PartId, StoreError> {
        let key = self.key(object);
        self.made("keeping a part of a file", self.client.put_part(&key, upload, number, bytes.into())).await
    }

    /// Makes the object of its parts. If an answer was lost and the question was sent again, the upload is not known any
    /// more: the length of the object tells.
    pub(super) async fn complete(
        &self,
        object: &str,
        upload: &String,
        parts: Vec<PartId>,
    ) -> Result<(), StoreError> {
        let key = self.key(object);
        let done = self.client.complete_multipart(&key, upload, parts);
        self.call("completing a file", CALLED_WITHIN, done).await.map(drop)
    }

    /// The length of an object \[bytes\]; `None` if it is not there, and the bucket is.
    pub(super) async fn length(&self, object: &str) -> Result<Option<u64>, StoreError> {
        let key = self.key(object);
        let found = self.found("asking for the length of a file", self.client.head(&key)).await?;
        Ok(found.map(|found| found.size))
    }

    /// Some bytes of an object; `None` if it is not there, and the bucket is.
    pub(super) async fn bytes(&self, object: &str, range: Range<u64>) -> Result<Option<Bytes>, StoreError> {
        let key = self.key(object);
        self.found("reading a file", self.client.get_range(&key, range)).await
    }

    /// Ends an upload without making an object. It is no fault if it has ended.
    pub(super) async fn abort(&self, object: &str, upload: &String) -> Result<(), StoreError> {
        let key = self.key(object);
        self.call("ending an upload", CALLED_WITHIN, self.client.abort_multipart(&key, upload))
            .await
            .map(drop)
    }

    /// Removes an object. It is no fault if it is not there.
    pub(super) async fn remove(&self, object: &str) -> Result<(), StoreError> {
        let key = self.key(object);
        self.call("removing a file", CALLED_WITHIN, self.client.delete(&key)).await.map(drop)
    }

    /// All objects, page by page as the server gives them.
    pub(super) fn list(&self) -> BoxStream<'_, Result<Listed, StoreError>> {
        let doing = "listing the files in the bucket";
        let found = self.client.list(Some(&Path::from(self.root.as_str())));
        let next = move |mut found: BoxStream<'static, Result<ObjectMeta, Error>>| async move {
            let listed = self.call(doing, CALLED_WITHIN, async { found.next().await.transpose() }).await;
            match listed {
                Ok(Some(Some(object))) => Some((Ok(object), found)),
                // The second is a bucket that is gone.
                Ok(Some(None)) => None,
                Ok(None) => Some((Err(StoreError::Objects { doing, reason: not_ours() }), found)),
                Err(fault) => Some((Err(fault), found)),
            }
        };
        let objects = futures::stream::unfold(found, next).filter_map(|object| async move {
            let object = match object {
                Ok(object) => object,
                Err(fault) => return Some(Err(fault)),
            };
            let key = object.location.filename().filter(|name| is_object(name))?.to_owned();
            Some(Ok(Listed { key, length: object.size, made_s: object.last_modified.timestamp() }))
        });
        objects.boxed()
    }

    fn mark(&self) -> Path {
        Path::from(format!("{}/{MARK}", self.root))
    }

    fn key(&self, object: &str) -> Path {
        Path::from(format!("{}/{}/{object}", self.root, object.get(..2).unwrap_or("00")))
    }

    /// The answer to a question that is never "not there", as long as the bucket is.
    async fn made<T>(
        &self,
        doing: &'static str,
        call: impl Future<Output = Result<T, Error>>,
    ) -> Result<T, StoreError> {
        let there = self.call(doing, CALLED_WITHIN, call).await?;
        there.ok_or_else(|| StoreError::Objects { doing, reason: not_ours() })
    }

    /// The answer about an object. A bucket that is gone, or another one in its place, is no missing object.
    async fn found<T>(
        &self,
        doing: &'static str,
        call: impl Future<Output = Result<T, Error>>,
    ) -> Result<Option<T>, StoreError> {
        let found = self.call(doing, CALLED_WITHIN, call).await?;
        if found.is_none() && self.call(doing, CALLED_WITHIN, self.client.head(&self.mark())).await?.is_none()
        {
            return Err(StoreError::Objects { doing, reason: not_ours() });
        }
        Ok(found)
    }

    /// The answer of the server; `None` if it says that there is nothing.
    async fn call<T>(
        &self,
        doing: &'static str,
        limit: Duration,
        call: impl Future<Output = Result<T, Error>>,
    ) -> Result<Option<T>, StoreError> {
        if let Some(reason) = self.pausing() {
            return Err(StoreError::Objects { doing, reason });
        }
        let (reason, is_away) = match tokio::time::timeout(limit, call).await {
            Ok(Ok(answer)) => return Ok(Some(answer)),
            Ok(Err(Error::NotFound { .. })) => return Ok(None),
            Ok(Err(fault)) => (reason(&fault), is_away(&fault)),
            Err(_late) => (format!("no answer within {} s", limit.as_secs()), true),
        };
        tracing::warn!(reason, "the server of the files fails while {doing}");
        if is_away {
            *self.away() = Some((Instant::now(), reason.clone()));
        }
        Err(StoreError::Objects { doing, reason })
    }

    fn pausing(&self) -> Option<String> {
        let away = self.away();
        away.as_ref().filter(|(at, _)| at.elapsed() < PAUSE).map(|(_, reason)| reason.clone())
    }

    fn away(&self) -> MutexGuard<'_, Option<(Instant, String)>> {
        self.away.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn not_ours() -> String {
    "the bucket is not there, or does not have the files of this database".to_owned()
}

/// Whether a name is that of an object of ours: a digest, `-`, and a generation.
fn is_object(name: &str) -> bool {
    let is_hex = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b'a'..=b'f'));
    name.split_once('-').is_some_and(|(sha256, generation)| {
        sha256.len() == 64 && is_hex(sha256) && generation.len() == 36 && is_hex(&generation.replace('-', ""))
    })
}

/// Whether the server did not answer, as opposed to a refusal.
fn is_away(fault: &Error) -> bool {
    http(fault).is_some() || code(fault, "status code: ", ' ').is_some_and(|status| status.starts_with('5'))
}

/// Why the server does not do what it should, in words that every caller may read: no address, no name, no key.
fn reason(fault: &Error) -> String {
    if let Some((kind, system)) = http(fault) {
        let what = match kind {
            HttpErrorKind::Connect => "the server of the files cannot be reached",
            HttpErrorKind::Timeout => "the server of the files does not answer in time",
            _ => "the connection to the server of the files is broken",
        };
        return system.map_or_else(|| what.to_owned(), |system| format!("{what}: {system}"));
    }
    let status = code(fault, "status code: ", ' ');
    match (code(fault, "<Code>", '<'), status) {
        (Some(code), _) => format!("the server of the files answers {code}"),
        (None, Some(status)) => format!("the server of the files answers with status {status}"),
        (None, None) => "the server of the files gave no answer that can be used".to_owned(),
    }
}

/// The kind of a fault on the way to the server, and what the system or TLS says.
fn http(fault: &Error) -> Option<(HttpErrorKind, Option<String>)> {
    let mut kind = None;
    let mut next = fault.source();
    while let Some(cause) = next {
        if let Some(http) = cause.downcast_ref::<HttpError>() {
            kind = Some(http.kind());
        }
        if let (Some(kind), Some(system)) = (kind, cause.downcast_ref::<io::Error>()) {
            return Some((kind, Some(said(system))));
        }
        next = cause.source();
    }
    Some((kind?, None))
}

/// The kind of a fault of the system, or that it is one of TLS, whose own words may name a host.
fn said(system: &io::Error) -> String {
    match system.get_ref() {
        Some(inner) if inner.is::<rustls::Error>() => TLS_FAILED.to_owned(),
        Some(inner) => inner.downcast_ref().map_or_else(|| system.kind().to_string(), said),
        None => system.kind().to_string(),
    }
}

/// A word of the text of a fault that has nothing but letters and digits.
fn code(fault: &Error, before: &str, after: char) -> Option<String> {
    let text = fault.to_string();
    let (_, rest) = text.split_once(before)?;
    let word = rest.split(after).next()?;
    let is_word =
        !word.is_empty() && word.len() <= MAX_CODE && word.bytes().all(|byte| byte.is_ascii_alphanumeric());
    is_word.then(|| word.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_digest_with_a_generation_is_an_object() {
        let sha256 = "0f".repeat(32);
        assert!(is_object(&format!("{sha256}-0190c3a5-1b2c-4d3e-8f40-5a6b7c8d9e0f")));
        for name in [
            "database.id",
            "trial-1",
            &sha256,
            &format!("{sha256}-1"),
            &format!("{}-0190c3a5-1b2c-4d3e-8f40-5a6b7c8d9e0f", "0G".repeat(32)),
        ] {
            assert!(!is_object(name), "{name}");
        }
    }

    #[test]
    fn a_fault_of_tls_is_found_within_others_and_named_without_its_words() {
        let refused = || io::Error::from(io::ErrorKind::ConnectionRefused);
        assert_eq!(said(&refused()), "connection refused");
        assert_eq!(said(&io::Error::other(refused())), "connection refused");
        let of_tls = io::Error::other(rustls::Error::General("s3.plant.example".to_owned()));
        assert_eq!(said(&io::Error::other(of_tls)), TLS_FAILED);
    }

    #[test]
    fn a_reason_has_the_code_of_the_server_and_nothing_else() {
        let of = |text: &str| Error::Generic { store: "S3", source: text.to_owned().into() };
        let refused = of(
            "Server returned non-2xx status code: 403 Forbidden: <Error><Code>AccessDenied</Code><Key>s3cret</Key></Error>",
        );
        assert_eq!(reason(&refused), "the server of the files answers AccessDenied");
        assert!(!is_away(&refused));
        let down = of("Server returned non-2xx status code: 503 Service Unavailable: <b>s3cret</b>");
        assert_eq!(reason(&down), "the server of the files answers with status 503");
        assert!(is_away(&down));
        assert!(!reason(&of("s3cret <Code>s3cret and more</Code>")).contains("s3cret"));
    }
}
