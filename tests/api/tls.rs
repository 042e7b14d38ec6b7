//! TLS by certificate files.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::Arc;

use rcgen::{CertifiedKey, generate_simple_self_signed};
use reqwest::StatusCode;
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore, crypto::ring};

use crate::process::{address, binary};
use crate::support::spawn_with;

/// A certificate for this computer, in files.
struct Files {
    certificate: PathBuf,
    key: PathBuf,
    der: CertificateDer<'static>,
    _folder: TempDir,
}

fn files() -> Files {
    let folder = TempDir::new().unwrap();
    let names = vec!["localhost".to_owned(), "127.0.0.1".to_owned()];
    let CertifiedKey { cert, signing_key } = generate_simple_self_signed(names).unwrap();
    let (certificate, key) = (folder.path().join("chain.pem"), folder.path().join("key.pem"));
    std::fs::write(&certificate, cert.pem()).unwrap();
    std::fs::write(&key, signing_key.serialize_pem()).unwrap();
    std::fs::set_permissions(&key, Permissions::from_mode(0o600)).unwrap();
    Files { certificate, key, der: cert.der().clone(), _folder: folder }
}

/// A client that trusts this certificate and offers these protocols.
async fn connected(
    address: &str,
    trusted: &CertificateDer<'static>,
    offers: &[&[u8]],
) -> TlsStream<TcpStream> {
    try_connected(address, trusted, offers).await.unwrap()
}

async fn try_connected(
    address: &str,
    trusted: &CertificateDer<'static>,
    offers: &[&[u8]],
) -> std::io::Result<TlsStream<TcpStream>> {
    let mut roots = RootCertStore::empty();
    roots.add(trusted.clone()).unwrap();
    let mut config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_root_certificates(roots)
        .with_no_client_auth();
    config.alpn_protocols = offers.iter().map(|offer| offer.to_vec()).collect();
    let stream = TcpStream::connect(address).await?;
    TlsConnector::from(Arc::new(config)).connect(ServerName::try_from("localhost").unwrap(), stream).await
}

/// All that comes until the other side closes.
async fn rest(mut stream: impl AsyncReadExt + Unpin) -> String {
    let mut answer = Vec::new();
    // A peer may close without a last word.
    let _end = stream.read_to_end(&mut answer).await;
    String::from_utf8_lossy(&answer).into_owned()
}

#[tokio::test]
async fn it_speaks_tls_with_http_1_and_2_and_nothing_else() {
    let files = files();
    let app = spawn_with(|settings| {
        settings.tls_certificate = Some(files.certificate.clone());
        settings.tls_key = Some(files.key.clone());
    })
    .await;
    let address = app.base.strip_prefix("http://").unwrap();
    let mut one = connected(address, &files.der, &[b"http/1.1"]).await;
    assert_eq!(one.get_ref().1.alpn_protocol(), Some(&b"http/1.1"[..]));
    one.write_all(b"GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").await.unwrap();
    assert!(rest(one).await.starts_with("HTTP/1.1 200 "));
    let mut two = connected(address, &files.der, &[b"h2", b"http/1.1"]).await;
    assert_eq!(two.get_ref().1.alpn_protocol(), Some(&b"h2"[..]));
    // The preface and an empty SETTINGS frame (RFC 9113 §3.4); the answer begins with a SETTINGS frame, of type 4.
    two.write_all(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0").await.unwrap();
    let mut head = [0; 9];
    two.read_exact(&mut head).await.unwrap();
    assert_eq!(head[3], 4, "{head:?}");
    let mut plain = TcpStream::connect(address).await.unwrap();
    plain.write_all(b"GET /readyz HTTP/1.1\r\nHost: localhost\r\n\r\n").await.unwrap();
    assert!(!rest(plain).await.contains("HTTP/1.1"));
    assert!(try_connected(address, &self::files().der, &[]).await.is_err());
}

#[tokio::test]
async fn stalled_handshakes_and_headers_are_closed_and_connections_are_capped() {
    let files = files();
    let app = spawn_with(|settings| {
        settings.tls_certificate = Some(files.certificate.clone());
        settings.tls_key = Some(files.key.clone());
        // Long enough for a second client to come meanwhile, on a machine that has much else to do.
        settings.header_timeout_s = 2.0;
        settings.max_connections = 1;
    })
    .await;
    let address = app.base.strip_prefix("http://").unwrap();
    // A handshake that never begins holds the only place, until it is closed.
    let silent = TcpStream::connect(address).await.unwrap();
    assert!(try_connected(address, &files.der, &[]).await.is_err());
    assert_eq!(rest(silent).await, "");
    // The place comes back a moment after the other side has seen the end.
    let mut stalled = loop {
        if let Ok(stream) = try_connected(address, &files.der, &[]).await {
            break stream;
        }
    };
    stalled.write_all(b"GET /readyz HTTP/1.1\r\nHost: loc").await.unwrap();
    assert!(!rest(stalled).await.contains(" 200 "));
    drop(app);
}

#[test]
fn files_that_cannot_be_used_refuse_the_start_with_the_reason() {
    let (good, other, data) = (files(), files(), TempDir::new().unwrap());
    let path = |path: &PathBuf| path.to_str().unwrap().to_owned();
    let (chain, key) = (path(&good.certificate), path(&good.key));
    let missing = path(&data.path().join("none.pem"));
    for (certificate, key, said) in [
        (&missing, &key, "none.pem"),
        (&chain, &missing, "none.pem"),
        (&key, &key, "contains no certificate"),
        (&chain, &chain, "private key"),
        (&chain, &path(&other.key), "cannot be used"),
    ] {
        let arguments = ["--listen", "127.0.0.1:0", "--tls-certificate", certificate, "--tls-key", key];
        let output = binary(&data).args(arguments).stderr(Stdio::piped()).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.contains(said), "{said}: {text}");
        assert!(output.stdout.is_empty());
    }
    for half in [["--tls-certificate", &chain], ["--tls-key", &key]] {
        let output = binary(&data).args(half).stderr(Stdio::piped()).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.contains("is missing"), "{text}");
    }
}

#[tokio::test]
async fn a_container_asks_over_tls_whether_it_is_healthy() {
    let (good, other, data) = (files(), files(), TempDir::new().unwrap());
    let with = |command: &mut Command, files: &Files| {
        command.env("TRUNNION_TLS_CERTIFICATE", &files.certificate).env("TRUNNION_TLS_KEY", &files.key);
    };
    let mut serve = binary(&data);
    with(&mut serve, &good);
    let mut child = serve.args(["--listen", "127.0.0.1:0"]).spawn().unwrap();
    let address = address(&mut child);
    let check = |files: Option<&Files>| {
        let mut command = binary(&data);
        if let Some(files) = files {
            with(&mut command, files);
        }
        command.args(["healthcheck", "--listen", &address]).status().unwrap().success()
    };
    assert!(check(Some(&good)));
    assert!(!check(Some(&other)) && !check(None));
    let refused = reqwest::get(format!("http://{address}/readyz")).await;
    assert!(refused.map_or(true, |answer| answer.status() != StatusCode::OK));
    let told = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(told.success());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
