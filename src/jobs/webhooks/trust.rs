//! Whose certificates are trusted: the system's, and those of a file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustls::crypto::ring;
use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::{Error as PemFault, PemObject};
use rustls::{ClientConfig, RootCertStore};
use thiserror::Error;
use tokio::sync::OnceCell;

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

/// Whose certificates are trusted.
#[derive(Debug, Default)]
pub(super) struct Trust {
    own: Vec<CertificateDer<'static>>,
    /// The system's are read when TLS is spoken for the first time.
    client: OnceCell<Arc<ClientConfig>>,
}

impl Trust {
    /// The system's certificates and those of `file`.
    ///
    /// # Errors
    /// The file cannot be read, or holds none.
    pub(super) fn with(file: Option<&Path>) -> Result<Self, TrustFault> {
        let Some(path) = file else { return Ok(Self::default()) };
        let unreadable = |source| TrustFault::Unreadable { path: path.to_owned(), source };
        let read = CertificateDer::pem_file_iter(path).map_err(unreadable)?;
        let own = read.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
        if own.is_empty() {
            return Err(TrustFault::Empty(path.to_owned()));
        }
        Ok(Self { own, client: OnceCell::new() })
    }

    /// What TLS is spoken with.
    ///
    /// # Errors
    /// The provider does not speak TLS, which it does.
    pub(super) async fn client(&self) -> Result<Arc<ClientConfig>, rustls::Error> {
        let made = self.client.get_or_try_init(|| async {
            let found = tokio::task::spawn_blocking(rustls_native_certs::load_native_certs).await;
            let mut roots = RootCertStore::empty();
            match found {
                Ok(found) => {
                    for fault in &found.errors {
                        tracing::warn!(error = %fault, "some of the system's certificates cannot be read");
                    }
                    let _kept_and_left_out = roots.add_parsable_certificates(found.certs);
                }
                Err(fault) => tracing::error!(error = %fault, "the system's certificates cannot be read"),
            }
            let _kept_and_left_out = roots.add_parsable_certificates(self.own.iter().cloned());
            let mut config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
                .with_safe_default_protocol_versions()?
                .with_root_certificates(roots)
                .with_no_client_auth();
            config.alpn_protocols = vec![b"http/1.1".to_vec()];
            Ok(Arc::new(config))
        });
        made.await.cloned()
    }
}
