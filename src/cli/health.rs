//! Asks a running service whether it is ready.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpStream};
use std::path::Path;
use std::time::Duration;

use rustls::pki_types::ServerName;
use rustls::{ClientConnection, StreamOwned};

use super::{StartFault, tls};
use crate::config::Settings;

const PATIENCE: Duration = Duration::from_secs(2);
/// Longest first line read (bytes).
const LONGEST: u64 = 4096;

/// Whether the service with these settings is ready; if its address means all interfaces, the loopback
/// address is asked.
pub(super) fn check(settings: &Settings) -> Result<(), StartFault> {
    let mut address = settings.listen;
    match address.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => address.set_ip(Ipv4Addr::LOCALHOST.into()),
        IpAddr::V6(ip) if ip.is_unspecified() => address.set_ip(Ipv6Addr::LOCALHOST.into()),
        _ => {}
    }
    let asked = match (&settings.tls_certificate, &settings.tls_key) {
        (Some(certificate), Some(_)) => over_tls(address, certificate)?,
        _ => connection(address).and_then(|connection| ask(address, connection)),
    };
    let answer = asked.unwrap_or_else(|fault| fault.to_string());
    if answer.starts_with("HTTP/1.1 200 ") { Ok(()) } else { Err(StartFault::NotReady { address, answer }) }
}

fn connection(address: SocketAddr) -> std::io::Result<TcpStream> {
    let connection = TcpStream::connect_timeout(&address, PATIENCE)?;
    connection.set_read_timeout(Some(PATIENCE))?;
    Ok(connection)
}

fn over_tls(address: SocketAddr, certificate: &Path) -> Result<std::io::Result<String>, StartFault> {
    let config = tls::client(certificate)?;
    let name = ServerName::IpAddress(address.ip().into());
    let session = ClientConnection::new(config, name).map_err(std::io::Error::other);
    Ok(session.and_then(|session| ask(address, StreamOwned::new(session, connection(address)?))))
}

/// The first line of the answer.
fn ask(address: SocketAddr, mut connection: impl Read + Write) -> std::io::Result<String> {
    let request = format!("GET /readyz HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    connection.write_all(request.as_bytes())?;
    let mut line = String::new();
    BufReader::new(connection.take(LONGEST)).read_line(&mut line)?;
    Ok(line.trim_end().to_owned())
}
