//! TLS: the service's certificate, and a client that trusts only this certificate.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use rustls::crypto::{CryptoProvider, ring, verify_tls12_signature, verify_tls13_signature};
use rustls::pki_types::pem::{Error as PemFault, PemObject};
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName, UnixTime};
use rustls::{ClientConfig, DigitallySignedStruct, DistinguishedName, Error, ServerConfig, SignatureScheme};
use thiserror::Error as ThisError;

use super::rights::Rights;
use crate::jobs::TlsTime;

/// Why the service cannot use TLS.
#[derive(Debug, ThisError)]
pub enum TlsFault {
    /// The certificate file cannot be read.
    #[error("the certificate {} cannot be read: {source}", path.display())]
    Certificate {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: PemFault,
    },
    /// The file contains no certificate.
    #[error("{} contains no certificate", path.display())]
    NoCertificate {
        /// The file.
        path: PathBuf,
    },
    /// The key file cannot be read.
    #[error("the private key {} cannot be read: {source}", path.display())]
    Key {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: PemFault,
    },
    /// Other users have access to the key.
    #[error(
        "the private key {} has the mode {mode:03o}, so others can read or change it: chmod 600 {}",
        path.display(), path.display()
    )]
    KeyOpen {
        /// The file.
        path: PathBuf,
        /// Its mode.
        mode: u32,
    },
    /// The two do not belong together, or their kind is not supported.
    #[error("certificate {} and key {} cannot be used: {source}", certificate.display(), key.display())]
    Refused {
        /// The certificate's file.
        certificate: PathBuf,
        /// The key's file.
        key: PathBuf,
        /// The reason.
        source: Error,
    },
}

/// The configuration with which the service answers a handshake.
///
/// # Errors
/// The files cannot be read or do not belong together, or other users can read or change the key.
pub(super) fn server(certificate: &Path, key: &Path) -> Result<Arc<ServerConfig>, TlsFault> {
    let chain = chain(certificate)?;
    if let Some(rights) = Rights::of(key).filter(|rights| rights.all_read() || rights.others_write()) {
        return Err(TlsFault::KeyOpen { path: key.to_owned(), mode: rights.mode });
    }
    let secret =
        PrivateKeyDer::from_pem_file(key).map_err(|source| TlsFault::Key { path: key.to_owned(), source })?;
    let refused =
        |source| TlsFault::Refused { certificate: certificate.to_owned(), key: key.to_owned(), source };
    let mut config =
        ServerConfig::builder_with_details(Arc::new(ring::default_provider()), Arc::new(TlsTime))
            .with_safe_default_protocol_versions()
            .map_err(refused)?
            .with_no_client_auth()
            .with_single_cert(chain, secret)
            .map_err(refused)?;
    config.alpn_protocols = vec![b"h2".to_vec(), b"http/1.1".to_vec()];
    Ok(Arc::new(config))
}

/// A client that trusts every server with the key of this certificate, whatever its name and its expiry.
///
/// # Errors
/// The file cannot be read.
pub(super) fn client(certificate: &Path) -> Result<Arc<ClientConfig>, TlsFault> {
    let trusted = chain(certificate)?.swap_remove(0);
    let provider = Arc::new(ring::default_provider());
    let refused =
        |source| TlsFault::Refused { certificate: certificate.to_owned(), key: PathBuf::new(), source };
    let config = ClientConfig::builder_with_details(Arc::clone(&provider), Arc::new(TlsTime))
        .with_safe_default_protocol_versions()
        .map_err(refused)?
        .dangerous()
        .with_custom_certificate_verifier(Arc::new(ThisOne { trusted, provider }))
        .with_no_client_auth();
    Ok(Arc::new(config))
}

/// The certificates of a file, at least one.
fn chain(path: &Path) -> Result<Vec<CertificateDer<'static>>, TlsFault> {
    let unreadable = |source| TlsFault::Certificate { path: path.to_owned(), source };
    let read = CertificateDer::pem_file_iter(path).map_err(unreadable)?;
    let chain = read.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
    if chain.is_empty() { Err(TlsFault::NoCertificate { path: path.to_owned() }) } else { Ok(chain) }
}

/// Trusts exactly one certificate: the one in the service's settings.
#[derive(Debug)]
struct ThisOne {
    trusted: CertificateDer<'static>,
    provider: Arc<CryptoProvider>,
}

impl ServerCertVerifier for ThisOne {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        _intermediates: &[CertificateDer<'_>],
        _server_name: &ServerName<'_>,
        _ocsp_response: &[u8],
        _now: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        if *end_entity == self.trusted {
            Ok(ServerCertVerified::assertion())
        } else {
            Err(Error::General("the service uses another certificate than its settings name".to_owned()))
        }
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        cert: &CertificateDer<'_>,
        dss: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        verify_tls12_signature(message, cert, dss, &self.provider.signature_verification_algorithms)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        cert: &CertificateDer<'_>,
        dss: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        verify_tls13_signature(message, cert, dss, &self.provider.signature_verification_algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }

    fn root_hint_subjects(&self) -> Option<&[DistinguishedName]> {
        None
    }
}
