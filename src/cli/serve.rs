//! Start, serve, drain: the service's life.

use std::io::Write;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use axum_server::tls_rustls::{RustlsAcceptor, RustlsConfig};
use axum_server::{Handle, Server};
use hyper_util::rt::TokioTimer;
use jiff::Timestamp;
use thiserror::Error;
use tokio::signal::unix::{SignalKind, signal};
use tokio::task::JoinHandle;

use super::refusal::json_line;
use super::rights::{believed, keep_private};
use super::{CommandFault, KeysFault, TlsFault, WebhooksFault, logs, tls};
use crate::config::{ConfigFault, LogFormat, Settings};
use crate::http::connections::Cap;
use crate::http::first_bytes::{FirstBytes, Patience};
use crate::http::observation::Exporter;
use crate::http::{AppState, router};
use crate::jobs::{Compensator, Cost, CutterContactCompensator, OpenFault, Sources, system_time};
use crate::shares::Share;
use crate::store::{DirectoryLock, LockFault, NetworkMount, make_directory, network_mount};

/// Why the service could not start.
#[derive(Debug, Error)]
pub enum StartFault {
    /// The settings cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigFault),
    /// The service cannot listen on the address.
    #[error("cannot listen on {address}: {source}")]
    Listen {
        /// The configured address.
        address: SocketAddr,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The data directory cannot be used.
    #[error("the data directory {path} cannot be used: {source}")]
    DataDirectory {
        /// The directory.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The data directory is on another computer.
    #[error(
        "the data directory {} is on the network file system {} ({}), where the database would be damaged; \
         name a directory on a local disk with --data-dir",
        path.display(), mount.at.display(), mount.kind
    )]
    NetworkFileSystem {
        /// The directory.
        path: PathBuf,
        /// The file system of the directory.
        mount: NetworkMount,
    },
    /// Another process uses the data directory.
    #[error(transparent)]
    Lock(#[from] LockFault),
    /// Database or files cannot be used.
    #[error(transparent)]
    Open(#[from] OpenFault),
    /// Another service has taken over the database.
    #[error(
        "this service has stopped, because it may not use the database any more: while it had no connection, another \
         service took the database over, or a newer version changed it. Nothing that this service acknowledged is lost. \
         Start only one service, or set files = postgres in all of them; after an update start the newer version"
    )]
    TakenOver,
    /// The clock of the computer is at a time before 1970.
    #[error(
        "the clock of this computer says {now}; HTTP and certificates cannot use times before 1970: \
         set the clock and start again"
    )]
    Clock {
        /// The time of the clock.
        now: Timestamp,
    },
    /// Other computers can reach the address, and there is no key.
    #[error(
        "other computers can reach {address}, but the data directory {dir} has no API key. Make the first key; it is \
         shown only once:\n\n    \
         trunnion keys create --name first --scopes read,compute,machines,calibrations,admin --data-dir {dir}\n\n\
         A container needs the same image and volume for it:\n\n    \
         docker run --rm -v VOLUME:/data IMAGE keys create --name first \
         --scopes read,compute,machines,calibrations,admin\n\n\
         Then start again. Or listen on 127.0.0.1, or give --insecure to serve everybody.",
        dir = data_dir.display()
    )]
    Unguarded {
        /// The configured address.
        address: SocketAddr,
        /// The data directory.
        data_dir: PathBuf,
    },
    /// The certificate or its key cannot be used.
    #[error(transparent)]
    Tls(#[from] TlsFault),
    /// A command about keys failed.
    #[error(transparent)]
    Keys(#[from] KeysFault),
    /// A command about webhooks failed.
    #[error(transparent)]
    Webhooks(#[from] WebhooksFault),
    /// The service that was asked is not ready.
    #[error("the service at {address} is not ready: {answer}")]
    NotReady {
        /// The address that was asked.
        address: SocketAddr,
        /// First line of the answer, or the reason why there is none.
        answer: String,
    },
    /// The settings ask for an export of spans, but this binary has none.
    #[error(
        "otlp_endpoint is {endpoint:?}, but this binary was built without the feature otlp; leave the setting empty, or \
         build with --features otlp"
    )]
    NoExport {
        /// The configured endpoint.
        endpoint: String,
    },
    /// The address of the collector cannot be used.
    #[error("otlp_endpoint {endpoint:?} cannot be used: {reason}")]
    Collector {
        /// The configured endpoint.
        endpoint: String,
        /// The reason.
        reason: String,
    },
    /// A command failed.
    #[error(transparent)]
    Command(#[from] CommandFault),
    /// The process could not be set up.
    #[error("the process could not be set up: {0}")]
    Process(std::io::Error),
}

impl StartFault {
    /// Exit status of the process: 1 if it checked and refuses, 2 if it could not do its work.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Command(fault) => fault.exit_code(),
            Self::Keys(fault) if fault.is_refusal() => 1,
            Self::NotReady { .. } => 1,
            _ => 2,
        }
    }
}

/// Smallest buffer for bytes of a connection that have arrived and were not taken yet \[bytes\].
const LEAST_BUFFER_BYTES: usize = 64 << 10;

/// Number of bytes that may arrive on an HTTP/2 connection before they are read, and on one of its streams
/// \[bytes\].
const CONNECTION_WINDOW_BYTES: u32 = 64 << 10;
const STREAM_WINDOW_BYTES: u32 = 64 << 10;
/// Number of requests that an HTTP/2 connection may have open at once. Each holds about 12 KiB until its
/// answer is taken, even if it is refused: a thousand connections stay within `max_memory_bytes`
/// (`tests/faults/memory.py`). A client with more requests waits, or opens another connection.
const STREAMS_OF_A_CONNECTION: u32 = 16;

/// Who is admitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Guarding {
    /// Every caller with a key. The number is the count of all keys, including revoked and expired keys.
    Keys(usize),
    /// Every program on this computer.
    Loopback,
    /// Every caller.
    Insecure,
}

/// A service that listens.
#[derive(Debug)]
pub struct Running {
    /// The address that it listens on.
    pub address: SocketAddr,
    /// Whether it uses TLS.
    pub tls: bool,
    /// Who is admitted; the first key created over HTTP changes it.
    pub guarding: Guarding,
    /// The state its handlers share.
    pub state: AppState,
    handle: Handle<SocketAddr>,
    task: JoinHandle<std::io::Result<()>>,
    drain: Duration,
    lock: DirectoryLock,
}

/// Checks that the header of an answer can hold the time.
fn can_be_sent(now: Timestamp) -> Result<(), StartFault> {
    if now < Timestamp::UNIX_EPOCH { Err(StartFault::Clock { now }) } else { Ok(()) }
}

/// Opens the data directory and listens. The caller owns the runtime.
///
/// # Errors
/// The address is in use, the data directory cannot be used or is in use, the database cannot be migrated, or
/// the clock is before 1970.
pub async fn start(
    settings: Settings,
    sources: Sources,
    compensator: Arc<dyn Compensator>,
) -> Result<Running, StartFault> {
    can_be_sent(system_time())?;
    let exporter = exporter(&settings.otlp_endpoint)?;
    let path = settings.data_dir.clone();
    make_directory(&path).map_err(|source| StartFault::DataDirectory { path: path.clone(), source })?;
    on_a_local_disk(&path)?;
    let tls = match (&settings.tls_certificate, &settings.tls_key) {
        (Some(certificate), Some(key)) => Some(RustlsConfig::from_config(tls::server(certificate, key)?)),
        _ => None,
    };
    let lock = DirectoryLock::take(&path)?;
    keep_private(&path);
    let address = settings.listen;
    let listener = TcpListener::bind(address).map_err(|source| StartFault::Listen { address, source })?;
    listener.set_nonblocking(true).map_err(StartFault::Process)?;
    let address = listener.local_addr().map_err(StartFault::Process)?;
    let drain = Duration::from_secs_f64(settings.drain_timeout_s);
    let state = AppState::open(settings, sources, compensator).await?;
    if let Some(exporter) = exporter {
        state.export_to(exporter);
    }
    let guarding = guarding(address, &state).await?;
    let handle = Handle::new();
    let server = axum_server::from_tcp(listener).map_err(StartFault::Process)?.handle(handle.clone());
    let header_timeout = Duration::from_secs_f64(state.settings.header_timeout_s);
    let answer_pause = Duration::from_secs_f64(state.settings.answer_pause_timeout_s);
    let share = Share(state.settings.max_share_per_caller);
    let cap = Cap::new(state.settings.max_connections, share, answer_pause);
    let patience = Patience { silence: header_timeout, answer_pause };
    // A header within the limits always fits; a far longer one is refused before it is completely in memory.
    let header_bytes = state.settings.max_url_bytes + state.settings.max_header_bytes;
    let headers =
        Headers { timeout: header_timeout, buffer_bytes: (2 * header_bytes).max(LEAST_BUFFER_BYTES) };
    let service = router(state.clone()).into_make_service_with_connect_info::<SocketAddr>();
    let speaks_tls = tls.is_some();
    let task = match tls {
        None => {
            let acceptor = FirstBytes::within(patience, cap);
            tokio::spawn(patient(server.acceptor(acceptor), headers).serve(service))
        }
        Some(config) => {
            let acceptor = RustlsAcceptor::new(config).handshake_timeout(header_timeout).acceptor(cap);
            let acceptor = FirstBytes::within(patience, acceptor);
            tokio::spawn(patient(server.acceptor(acceptor), headers).serve(service))
        }
    };
    Ok(Running { address, tls: speaks_tls, guarding, state, handle, task, drain, lock })
}

/// Refuses a directory on another computer, where the database would be damaged.
pub(super) fn on_a_local_disk(path: &Path) -> Result<(), StartFault> {
    let unusable = |source| StartFault::DataDirectory { path: path.to_owned(), source };
    let whole = path.canonicalize().map_err(unusable)?;
    // Systems without this table are not checked.
    let mounts = std::fs::read_to_string("/proc/self/mounts").unwrap_or_default();
    match network_mount(&mounts, &whole) {
        Some(mount) => Err(StartFault::NetworkFileSystem { path: path.to_owned(), mount }),
        None => Ok(()),
    }
}

/// Who will be admitted. It is a fault if everybody would be admitted and the settings do not allow that.
async fn guarding(address: SocketAddr, state: &AppState) -> Result<Guarding, StartFault> {
    let keys = state.store.every_api_key().await.map_err(OpenFault::from)?.len();
    if keys > 0 {
        Ok(Guarding::Keys(keys))
    } else if address.ip().to_canonical().is_loopback() {
        Ok(Guarding::Loopback)
    } else if state.settings.insecure {
        Ok(Guarding::Insecure)
    } else {
        Err(StartFault::Unguarded { address, data_dir: state.settings.data_dir.clone() })
    }
}

/// How long HTTP/1.1 waits for a header, and how much of a header both versions hold.
#[derive(Debug, Clone, Copy)]
struct Headers {
    timeout: Duration,
    buffer_bytes: usize,
}

/// The server with its timeouts.
fn patient<A>(mut server: Server<SocketAddr, A>, headers: Headers) -> Server<SocketAddr, A> {
    let Headers { timeout, buffer_bytes } = headers;
    server
        .http_builder()
        .http1()
        .timer(TokioTimer::new())
        .header_read_timeout(timeout)
        // The service's own header works with a clock before 1970 (`http::date`).
        .auto_date_header(false)
        .max_buf_size(buffer_bytes);
    server
        .http_builder()
        .http2()
        .auto_date_header(false)
        .max_concurrent_streams(STREAMS_OF_A_CONNECTION)
        .initial_connection_window_size(CONNECTION_WINDOW_BYTES)
        .initial_stream_window_size(STREAM_WINDOW_BYTES)
        .max_send_buf_size(STREAM_WINDOW_BYTES as usize)
        .max_header_list_size(u32::try_from(buffer_bytes).unwrap_or(u32::MAX));
    server
}

/// The exporter of spans, if one is configured.
fn exporter(endpoint: &str) -> Result<Option<Arc<dyn Exporter>>, StartFault> {
    if endpoint.is_empty() {
        return Ok(None);
    }
    #[cfg(feature = "otlp")]
    return super::otlp::exporter(endpoint).map(Some);
    #[cfg(not(feature = "otlp"))]
    Err(StartFault::NoExport { endpoint: endpoint.to_owned() })
}

impl Running {
    /// Stops listening, lets open requests and running jobs finish within the drain time, returns the
    /// unfinished jobs to the queue, and closes the database.
    ///
    /// # Errors
    /// The server ended with a fault of its own.
    pub async fn stop(self) -> std::io::Result<()> {
        self.state.begin_draining();
        self.handle.graceful_shutdown(Some(self.drain));
        let (served, ()) = tokio::join!(self.task, self.state.queue.stop(self.drain));
        let served = served.map_err(std::io::Error::other);
        if let Some(exporter) = self.state.exporter() {
            // It waits a moment for a collector on a thread of its own.
            drop(tokio::task::spawn_blocking(move || exporter.close()).await);
        }
        self.state.keeper.stop().await;
        self.state.store.close().await;
        drop(self.lock);
        served?
    }
}

/// Runs until SIGTERM or SIGINT, then drains.
///
/// # Errors
/// The service could not start, or ended with a fault.
pub(super) fn until_stopped(
    settings: Settings,
    config: Option<&Path>,
    warnings: &[String],
) -> Result<(), StartFault> {
    let _log = logs::open(&settings).map_err(StartFault::Process)?;
    for warning in warnings.iter().chain(&believed(&settings, config)) {
        tracing::warn!("{warning}");
    }
    let drain = Duration::from_secs_f64(settings.drain_timeout_s);
    let runtime =
        tokio::runtime::Builder::new_multi_thread().enable_all().build().map_err(StartFault::Process)?;
    let ended = runtime.block_on(async {
        let mut terminate = signal(SignalKind::terminate()).map_err(StartFault::Process)?;
        let mut interrupt = signal(SignalKind::interrupt()).map_err(StartFault::Process)?;
        let (data_dir, form) = (settings.data_dir.clone(), settings.log_format);
        let database = settings.database.clone();
        let budget = Cost::budget_within(settings.max_cost_s);
        let compensator = Arc::new(CutterContactCompensator { budget });
        let running = start(settings, Sources::real(), compensator).await?;
        if let Some(address) = database {
            tracing::info!(database = %address, "the database is on a server");
        }
        announce(&running, &data_dir, form);
        tokio::select! {
            _ = terminate.recv() => tracing::info!("stopping after SIGTERM"),
            _ = interrupt.recv() => tracing::info!("stopping after SIGINT"),
            () = running.state.store.taken_over() => {
                // What it computes belongs to the other service by now.
                let _stopped = running.stop().await;
                return Err(StartFault::TakenOver);
            }
        }
        running.stop().await.map_err(StartFault::Process)
    });
    // A computation that does not check its stop signal in time is left behind; the process does not wait for
    // it.
    runtime.shutdown_timeout(drain.min(Duration::from_millis(1500)));
    if ended.is_ok() {
        tracing::info!("stopped");
    }
    ended
}

/// The first lines for people; nothing depends on them. With a log of JSON they are one line of its form, because both
/// outputs of a container are one log.
fn announce(running: &Running, data_dir: &Path, form: LogFormat) {
    let (scheme, address) = (if running.tls { "https" } else { "http" }, running.address);
    let guarded = match running.guarding {
        Guarding::Keys(count) => format!("API keys: {count} exist, and every request needs one"),
        Guarding::Loopback => {
            "no API key exists: every program on this computer may do everything; create one with trunnion keys create"
                .to_owned()
        }
        Guarding::Insecure => {
            tracing::warn!(%address, "no API key exists: everybody who reaches the port may do everything");
            "INSECURE: no API key exists, and everybody who reaches the port may do everything".to_owned()
        }
    };
    let (version, data) = (env!("CARGO_PKG_VERSION"), data_dir.display());
    let url = format!("{scheme}://{address}");
    let lines = match form {
        LogFormat::Text => format!(
            "trunnion {version} listens on {url}\ndocumentation: {url}/docs    data: {data}\n{guarded}\n"
        ),
        LogFormat::Json => {
            let fields = serde_json::json!({
                "message": "listening", "version": version, "url": url, "documentation": format!("{url}/docs"),
                "data_dir": data.to_string(), "guarded": guarded,
            });
            json_line("INFO", &fields) + "\n"
        }
    };
    let _nobody_reads = std::io::stdout().write_all(lines.as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Scope;

    #[test]
    fn a_start_before_1970_is_refused() {
        assert!(can_be_sent(Timestamp::UNIX_EPOCH).is_ok());
        let fault = can_be_sent(Timestamp::from_second(-1).unwrap()).unwrap_err();
        assert!(fault.to_string().contains("set the clock"), "{fault}");
        assert_eq!(fault.exit_code(), 2);
    }

    #[test]
    fn a_start_without_a_key_is_refused_with_the_commands_that_make_one() {
        let address = SocketAddr::from(([0, 0, 0, 0], 8080));
        let text = StartFault::Unguarded { address, data_dir: PathBuf::from("/data") }.to_string();
        let scopes = Scope::ALL.map(Scope::as_str).join(",");
        assert_eq!(text.matches(&format!("--scopes {scopes}")).count(), 2, "{text}");
        assert!(text.contains("0.0.0.0:8080") && text.contains("--data-dir /data\n"), "{text}");
    }
}
