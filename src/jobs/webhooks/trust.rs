//! Trusted certificates: those of the system and those of a file.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use rustls::crypto::ring;
use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject;
use rustls::{ClientConfig, RootCertStore};
use thiserror::Error;

use crate::jobs::{TlsTime, TrustFault};

/// The certificates of a `webhook_ca_file`.
///
/// # Errors
/// The file cannot be read, or contains none.
pub fn trusted_certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, TrustFault> {
    let unreadable = |source| TrustFault::Unreadable { path: file.to_owned(), source };
    let read = CertificateDer::pem_file_iter(file).map_err(unreadable)?;
    let certificates = read.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
    if certificates.is_empty() {
        return Err(TrustFault::Empty(file.to_owned()));
    }
    Ok(certificates)
}

/// No receiver can be trusted at present.
#[derive(Debug, Error)]
pub(super) enum NoTrust {
    /// Neither the system nor the file has a readable certificate.
    #[error("no trusted certificate could be read")]
    NoCertificate,
    /// The TLS provider failed; this does not happen.
    #[error(transparent)]
    Tls(#[from] rustls::Error),
}

/// The trusted certificates.
#[derive(Debug, Default)]
pub(super) struct Trust {
    own: Vec<CertificateDer<'static>>,
    /// The system's certificates are read at the first use of TLS, and again as long as none can be read.
    client: OnceLock<Arc<ClientConfig>>,
}

impl Trust {
    /// The system's certificates and those of `file`.
    ///
    /// # Errors
    /// The file cannot be read, or contains none.
    pub(super) fn with(file: Option<&Path>) -> Result<Self, TrustFault> {
        let own = file.map_or_else(|| Ok(Vec::new()), trusted_certificates)?;
        Ok(Self { own, client: OnceLock::new() })
    }

    /// The configuration of TLS.
    ///
    /// # Errors
    /// There is no trusted certificate.
    pub(super) async fn client(&self) -> Result<Arc<ClientConfig>, NoTrust> {
        if let Some(made) = self.client.get() {
            return Ok(Arc::clone(made));
        }
        let (found, is_settled) =
            match tokio::task::spawn_blocking(rustls_native_certs::load_native_certs).await {
                Ok(system) => {
                    for fault in &system.errors {
                        tracing::warn!(error = %fault, "some of the system's certificates cannot be read");
                    }
                    // Too many open files, or a certificate store that is being written: the next delivery reads it
                    // again.
                    let is_settled = system.errors.is_empty() || !system.certs.is_empty();
                    (system.certs, is_settled)
                }
                Err(fault) => {
                    tracing::error!(error = %fault, "the system's certificates cannot be read");
                    (Vec::new(), false)
                }
            };
        let made = Arc::new(self.trusting(found)?);
        if is_settled {
            // Another delivery may have read the same meanwhile.
            let _set = self.client.set(Arc::clone(&made));
        }
        Ok(made)
    }

    fn trusting(&self, system: Vec<CertificateDer<'static>>) -> Result<ClientConfig, NoTrust> {
        let mut roots = RootCertStore::empty();
        let _kept_and_left_out = roots.add_parsable_certificates(system);
        let _kept_and_left_out = roots.add_parsable_certificates(self.own.iter().cloned());
        if roots.is_empty() {
            return Err(NoTrust::NoCertificate);
        }
        let mut config =
            ClientConfig::builder_with_details(Arc::new(ring::default_provider()), Arc::new(TlsTime))
                .with_safe_default_protocol_versions()?
                .with_root_certificates(roots)
                .with_no_client_auth();
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_any_certificate_there_is_no_client_that_could_be_kept() {
        let trust = Trust::default();
        assert!(matches!(trust.trusting(Vec::new()), Err(NoTrust::NoCertificate)));
        assert!(trust.client.get().is_none());
    }
}
