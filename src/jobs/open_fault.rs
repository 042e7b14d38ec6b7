//! Why the service cannot begin: its data directory, or the certificates of webhooks, cannot be used.

use std::path::PathBuf;

use rustls::pki_types::pem::Error as PemFault;
use thiserror::Error;

use crate::store::{BlobFault, StoreError};
use crate::wire::Fault;

/// Why a data directory cannot be used.
#[derive(Debug, Error)]
pub enum OpenFault {
    /// The database.
    #[error("the database cannot be used: {0}")]
    Store(#[from] StoreError),
    /// The files.
    #[error("the files cannot be used: {0}")]
    Blobs(#[from] BlobFault),
    /// The certificates for receivers of webhooks cannot be used.
    #[error(transparent)]
    Trust(#[from] TrustFault),
    /// The system provides no random numbers.
    #[error("the system provides no random numbers: {0}")]
    NoRandomness(getrandom::Error),
    /// The system gives no thread.
    #[error("the system gives no thread: {0}")]
    Thread(std::io::Error),
    /// The example profile is wrong: a fault of the service.
    #[error("the example machine has {} faults", .0.len())]
    Example(Vec<Fault>),
}

/// The file with certificates cannot be used.
#[derive(Debug, Error)]
pub enum TrustFault {
    /// It cannot be read.
    #[error("webhook_ca_file {} cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: PemFault,
    },
    /// It holds none.
    #[error("webhook_ca_file {} holds no certificate", .0.display())]
    Empty(PathBuf),
}
