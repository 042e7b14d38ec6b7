//! Start, serve, drain: the service's life.

use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum_server::Handle;
use hyper_util::rt::TokioTimer;
use thiserror::Error;
use tokio::signal::unix::{SignalKind, signal};
use tokio::task::JoinHandle;

use super::{CommandFault, logs};
use crate::config::{ConfigFault, Settings};
use crate::http::{AppState, connections::Cap, router};
use crate::jobs::{Compensator, Cost, CutterContactCompensator, OpenFault, Sources};
use crate::store::{DirectoryLock, LockFault, NetworkMount, network_mount};

/// Why the service could not start.
#[derive(Debug, Error)]
pub enum StartFault {
    /// The settings cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigFault),
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}")]
    Listen {
        /// The address asked for.
        address: SocketAddr,
        /// What the system said.
        source: std::io::Error,
    },
    /// The data directory cannot be used.
    #[error("the data directory {path} cannot be used: {source}")]
    DataDirectory {
        /// The directory.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The data directory lies on another computer.
    #[error(
        "the data directory {} lies on the network file system {} ({}), where the database would be damaged; \
         name a directory on a local disk with --data-dir",
        path.display(), mount.at.display(), mount.kind
    )]
    NetworkFileSystem {
        /// The directory.
        path: PathBuf,
        /// What it lies on.
        mount: NetworkMount,
    },
    /// Another process uses the data directory.
    #[error(transparent)]
    Lock(#[from] LockFault),
    /// Database or files cannot be used.
    #[error(transparent)]
    Open(#[from] OpenFault),
    /// The service that was asked is not ready.
    #[error("the service at {address} is not ready: {answer}")]
    NotReady {
        /// Where it was asked.
        address: SocketAddr,
        /// First line of its answer, or why there is none.
        answer: String,
    },
    /// A command did not do what it was asked.
    #[error(transparent)]
    Command(#[from] CommandFault),
    /// The process could not be set up.
    #[error("the process could not be set up: {0}")]
    Process(std::io::Error),
}

impl StartFault {
    /// Status that the process ends with.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Command(fault) => fault.exit_code(),
            _ => 1,
        }
    }
}

/// A service that listens.
#[derive(Debug)]
pub struct Running {
    /// Where it listens.
    pub address: SocketAddr,
    /// The state its handlers share.
    pub state: AppState,
    handle: Handle<SocketAddr>,
    task: JoinHandle<std::io::Result<()>>,
    drain: Duration,
    lock: DirectoryLock,
}

/// Opens the data directory and listens. The caller owns the runtime.
///
/// # Errors
/// An address in use, a data directory that cannot be used or is in use, a database that cannot be migrated.
pub async fn start(
    settings: Settings,
    sources: Sources,
    compensator: Arc<dyn Compensator>,
) -> Result<Running, StartFault> {
    let path = settings.data_dir.clone();
    let unusable = |source| StartFault::DataDirectory { path: path.clone(), source };
    std::fs::create_dir_all(&path).map_err(unusable)?;
    let whole = path.canonicalize().map_err(unusable)?;
    // Systems without this table are not asked.
    let mounts = std::fs::read_to_string("/proc/self/mounts").unwrap_or_default();
    if let Some(mount) = network_mount(&mounts, &whole) {
        return Err(StartFault::NetworkFileSystem { path, mount });
    }
    let lock = DirectoryLock::take(&path)?;
    let address = settings.listen;
    let listener = TcpListener::bind(address).map_err(|source| StartFault::Listen { address, source })?;
    listener.set_nonblocking(true).map_err(StartFault::Process)?;
    let address = listener.local_addr().map_err(StartFault::Process)?;
    let drain = Duration::from_secs_f64(settings.drain_timeout_s);
    let state = AppState::open(settings, sources, compensator).await?;
    let handle = Handle::new();
    let mut server = axum_server::from_tcp(listener)
        .map_err(StartFault::Process)?
        .acceptor(Cap::new(state.settings.max_connections))
        .handle(handle.clone());
    let header_timeout = Duration::from_secs_f64(state.settings.header_timeout_s);
    server.http_builder().http1().timer(TokioTimer::new()).header_read_timeout(header_timeout);
    server
        .http_builder()
        .http2()
        .timer(TokioTimer::new())
        .keep_alive_interval(header_timeout)
        .keep_alive_timeout(header_timeout)
        .max_concurrent_streams(64);
    let task = tokio::spawn(server.serve(router(state.clone()).into_make_service()));
    Ok(Running { address, state, handle, task, drain, lock })
}

impl Running {
    /// Stops listening, lets requests under way finish within the drain time, closes the database.
    ///
    /// # Errors
    /// The server ended with a fault of its own.
    pub async fn stop(self) -> std::io::Result<()> {
        self.state.begin_draining();
        self.handle.graceful_shutdown(Some(self.drain));
        let served = self.task.await.map_err(std::io::Error::other);
        self.state.store.close().await;
        drop(self.lock);
        served?
    }
}

/// Runs until SIGTERM or SIGINT, then drains.
///
/// # Errors
/// The service could not start, or ended by a fault.
pub(super) fn until_stopped(settings: Settings) -> Result<(), StartFault> {
    logs::open(&settings);
    let drain = Duration::from_secs_f64(settings.drain_timeout_s);
    let runtime =
        tokio::runtime::Builder::new_multi_thread().enable_all().build().map_err(StartFault::Process)?;
    let ended = runtime.block_on(async {
        let mut terminate = signal(SignalKind::terminate()).map_err(StartFault::Process)?;
        let mut interrupt = signal(SignalKind::interrupt()).map_err(StartFault::Process)?;
        let data_dir = settings.data_dir.clone();
        let budget = Cost::budget_within(settings.max_cost_s);
        let compensator = Arc::new(CutterContactCompensator { budget });
        let running = start(settings, Sources::real(), compensator).await?;
        announce(running.address, &data_dir);
        tokio::select! {
            _ = terminate.recv() => tracing::info!("told to stop by SIGTERM"),
            _ = interrupt.recv() => tracing::info!("told to stop by SIGINT"),
        }
        running.stop().await.map_err(StartFault::Process)
    });
    // A computation that does not poll its stop in time is left behind; the process does not wait for it.
    runtime.shutdown_timeout(drain.min(Duration::from_secs(2)));
    tracing::info!("stopped");
    ended
}

#[expect(clippy::print_stdout, reason = "the first lines a person sees, not a log")]
fn announce(address: SocketAddr, data_dir: &std::path::Path) {
    println!("trunnion {} listens on http://{address}", env!("CARGO_PKG_VERSION"));
    println!("documentation: http://{address}/docs    data: {}", data_dir.display());
}
