//! Small calls over HTTP against an echo of the same body, side by side in one process: `cargo bench --bench http`,
//! with `-- SECONDS` for longer runs. On a quiet machine: clients and service share its cores.
//!
//! Then the binary itself: the inverse of many poses, and from its start to its first answer, with its memory once it
//! idles. `-- small`, `-- many` or `-- start` runs one of the three parts.

#![expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use axum::Router;
use axum::routing::post;
use http_body_util::{BodyExt, Full};
use hyper::client::conn::http1::{self, SendRequest};
use hyper_util::rt::TokioIo;
use poses::{Running, binary, many_poses};
use serde::{Deserialize, Serialize};
use tempfile::TempDir;
use tokio::net::{TcpListener, TcpStream};
use trunnion::config::{LogFormat, Settings};
use trunnion::http::{AppState, behind_the_edge, router};
use trunnion::jobs::{CutterContactCompensator, Sources};

mod poses;

type Failure = Box<dyn std::error::Error + Send + Sync>;

const BODY: &str = r#"{"poses":[{"x":10.0,"y":20.0,"z":30.0,"i":0.3,"j":-0.2,"k":0.93}],"work_offset_mm":[70.0,-40.0,95.0]}"#;
const PATH: &str = "/v1/machines/example-ac-table/inverse-kinematics";
/// Connections that are kept open, as `wrk -c 32` would.
const CONNECTIONS: usize = 32;
/// Rounds in which all take turns; the middle one of each counts.
const ROUNDS: usize = 5;

#[derive(Debug, Serialize, Deserialize)]
struct Body {
    poses: Vec<Pose>,
    work_offset_mm: [f64; 3],
}

#[derive(Debug, Serialize, Deserialize)]
struct Pose {
    x: f64,
    y: f64,
    z: f64,
    i: f64,
    j: f64,
    k: f64,
}

async fn echo(axum::Json(body): axum::Json<Body>) -> axum::Json<Body> {
    axum::Json(body)
}

/// A service that is measured: its address, the path, and the header with the key.
#[derive(Debug, Clone)]
struct Asked {
    address: SocketAddr,
    path: &'static str,
    key: Option<http::HeaderValue>,
}

impl Asked {
    fn new(address: SocketAddr, path: &'static str) -> Self {
        Self { address, path, key: None }
    }

    /// The same service after its first key was created.
    async fn with_a_key(self) -> Result<Self, Failure> {
        let mut sender = connect(self.address).await?;
        let body = r#"{"name":"bench","scopes":["read","compute","admin"]}"#;
        let request = http::Request::post("/v1/keys").header("host", "bench");
        let request = request.header("content-type", "application/json").body(Full::from(body))?;
        let answer = sender.send_request(request).await?.into_body().collect().await?.to_bytes();
        let answer: serde_json::Value = serde_json::from_slice(&answer)?;
        let key = answer["key"].as_str().ok_or_else(|| format!("no key was created: {answer}"))?;
        Ok(Self { key: Some(format!("Bearer {key}").parse()?), ..self })
    }
}

/// The service in this process, in a folder of its own. Its rate is not limited: the load is the benchmark's own.
async fn open(folder: &Path) -> Result<AppState, Failure> {
    let settings = Settings {
        data_dir: folder.to_owned(),
        log_format: LogFormat::Json,
        max_rate_per_s: 0.0,
        ..Settings::default()
    };
    std::fs::create_dir_all(folder)?;
    Ok(AppState::open(settings, Sources::real(), Arc::new(CutterContactCompensator::default())).await?)
}

async fn serve(router: Router) -> Result<SocketAddr, Failure> {
    let listener = TcpListener::bind("127.0.0.1:0").await?;
    let address = listener.local_addr()?;
    let service = router.into_make_service_with_connect_info::<SocketAddr>();
    tokio::spawn(async move {
        axum::serve(axum::serve::ListenerExt::tap_io(listener, |io| drop(io.set_nodelay(true))), service)
            .await
    });
    Ok(address)
}

async fn connect(address: SocketAddr) -> Result<SendRequest<Full<bytes::Bytes>>, Failure> {
    let stream = TcpStream::connect(address).await?;
    stream.set_nodelay(true)?;
    let (sender, connection) = http1::handshake(TokioIo::new(stream)).await?;
    tokio::spawn(connection);
    Ok(sender)
}

async fn ask(sender: &mut SendRequest<Full<bytes::Bytes>>, asked: &Asked) -> Result<(), Failure> {
    sender.ready().await?;
    let request =
        http::Request::post(asked.path).header("host", "bench").header("content-type", "application/json");
    let request = match &asked.key {
        Some(key) => request.header("authorization", key.clone()),
        None => request,
    };
    let request = request.body(Full::from(BODY))?;
    let response = sender.send_request(request).await?;
    let status = response.status();
    let body = response.into_body().collect().await?.to_bytes();
    if status == 200 { Ok(()) } else { Err(format!("{status}: {}", String::from_utf8_lossy(&body)).into()) }
}

/// As many requests as go through: their rate \[1/s\].
async fn flood(asked: &Asked, time: Duration) -> Result<f64, Failure> {
    let over = Arc::new(AtomicBool::new(false));
    let mut clients = Vec::new();
    for _ in 0..CONNECTIONS {
        let (mut sender, over) = (connect(asked.address).await?, Arc::clone(&over));
        let asked = asked.clone();
        clients.push(tokio::spawn(async move {
            let mut count = 0_u64;
            while !over.load(Ordering::Relaxed) {
                ask(&mut sender, &asked).await?;
                count += 1;
            }
            Ok::<_, Failure>(count)
        }));
    }
    let began = Instant::now();
    tokio::time::sleep(time).await;
    over.store(true, Ordering::Relaxed);
    let elapsed_s = began.elapsed().as_secs_f64();
    let mut count = 0;
    for client in clients {
        count += client.await??;
    }
    Ok(count as f64 / elapsed_s)
}

/// Requests at a steady rate: the times that half and 99 in 100 of them stay under \[ms\], counted from when each was
/// due, so that one that had to wait for another is not flattered.
async fn steady(asked: &Asked, rate_per_s: f64, time: Duration) -> Result<[f64; 2], Failure> {
    let each = Duration::from_secs_f64(CONNECTIONS as f64 / rate_per_s);
    let mut clients = Vec::new();
    let began = Instant::now() + Duration::from_millis(50);
    for k in 0..CONNECTIONS {
        let (mut sender, asked) = (connect(asked.address).await?, asked.clone());
        let first = began + each.mul_f64(k as f64 / CONNECTIONS as f64);
        clients.push(tokio::spawn(async move {
            let mut times_s = Vec::new();
            let mut due = first;
            while due < began + time {
                tokio::time::sleep_until(due.into()).await;
                // The timer ticks in milliseconds; what it adds is its own.
                let sent = Instant::now().min(due + Duration::from_millis(2));
                ask(&mut sender, &asked).await?;
                times_s.push(sent.elapsed().as_secs_f64());
                due += each;
            }
            Ok::<_, Failure>(times_s)
        }));
    }
    let mut times_s = Vec::new();
    for client in clients {
        times_s.extend(client.await??);
    }
    times_s.sort_by(f64::total_cmp);
    let at = |of_hundred: usize| {
        let place = times_s.len() * of_hundred / 100;
        times_s.get(place.min(times_s.len().saturating_sub(1))).map_or(f64::NAN, |time_s| time_s * 1e3)
    };
    Ok([at(50), at(99)])
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The argument with which this program is only the bare echo, and tells its address.
const ECHO: &str = "echo-alone";
/// From this row on, the services have processes of their own, and are compared with an echo that has one too.
const APART: usize = 4;

async fn echo_alone() -> Result<(), Failure> {
    println!("{}", serve(Router::new().route("/echo", post(echo))).await?);
    std::future::pending().await
}

async fn over_http(time: Duration) -> Result<(), Failure> {
    let (open_data, closed_data) = (TempDir::new()?, TempDir::new()?);
    let (state, closed) = (open(open_data.path()).await?, open(closed_data.path()).await?);
    let same_edge = behind_the_edge(Router::new().route("/echo", post(echo)), state.clone());
    let bare = Router::new().route("/echo", post(echo));
    let (quiet, logging) = (Running::start("off").await?.0, Running::start("info").await?.0);
    let mut apart = Command::new(std::env::current_exe()?);
    let mut apart = apart.arg(ECHO).stdout(Stdio::piped()).spawn()?;
    let mut place = String::new();
    BufReader::new(apart.stdout.take().ok_or("no standard output")?).read_line(&mut place)?;
    let them = [
        ("bare echo", Asked::new(serve(bare).await?, "/echo")),
        ("echo behind the same middleware", Asked::new(serve(same_edge).await?, "/echo")),
        ("inverse kinematics of one pose", Asked::new(serve(router(state)).await?, PATH)),
        ("the same with API keys", Asked::new(serve(router(closed)).await?, PATH).with_a_key().await?),
        ("bare echo in its own process", Asked::new(place.trim().parse()?, "/echo")),
        ("inverse by the binary, no log", Asked::new(quiet.address, PATH)),
        ("inverse by the binary with its log", Asked::new(logging.address, PATH)),
    ];
    let mut rates = them.each_ref().map(|_| Vec::new());
    for _ in 0..ROUNDS {
        for ((_, asked), rates) in them.iter().zip(&mut rates) {
            rates.push(flood(asked, time).await?);
        }
    }
    let rates = rates.map(middle);
    let of_echo = |place: usize| if place < APART { rates[0] } else { rates[APART] };
    for (place, ((name, asked), rate)) in them.iter().zip(rates).enumerate() {
        let [half_ms, most_ms] = steady(asked, rate / 2.0, time * 2).await?;
        println!(
            "{name:34} {rate:8.0} requests/s, bare echo {:.3}   at half that rate p50 {half_ms:.2} ms, p99 {most_ms:.2} ms",
            rate / of_echo(place)
        );
    }
    println!("inverse / echo behind the same middleware {:.3} (aim 0.90)", rates[2] / rates[1]);
    apart.kill()?;
    apart.wait()?;
    Ok(())
}

/// From then on a service without requests is idle.
const IDLE_AFTER: Duration = Duration::from_secs(2);

/// From the start of the process to its first answer \[ms\], and its memory once it idles \[MiB\].
async fn whole_process() -> Result<(), Failure> {
    let (mut ready_ms, mut idle_mib) = (Vec::new(), Vec::new());
    for _ in 0..2 * ROUNDS {
        let (running, took_ms) = Running::start("warn").await?;
        ready_ms.push(took_ms);
        tokio::time::sleep(IDLE_AFTER).await;
        idle_mib.push(running.memory_mib("VmRSS"));
    }
    let binary_mb = std::fs::metadata(binary())?.len() as f64 / 1e6;
    println!(
        "ready after {:.0} ms (aim 25), idle memory {:.1} MiB (aim 16), binary {binary_mb:.1} MB (aim 20)",
        middle(ready_ms),
        middle(idle_mib)
    );
    Ok(())
}

async fn ready(address: SocketAddr) -> Result<(), Failure> {
    let stream = TcpStream::connect(address).await?;
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await?;
    tokio::spawn(connection);
    let request =
        http::Request::get("/readyz").header("host", "bench").body(Full::<bytes::Bytes>::default())?;
    let response = sender.send_request(request).await?;
    if response.status() == 200 { Ok(()) } else { Err("not ready".into()) }
}

fn main() -> Result<(), Failure> {
    // Cargo's own `--bench` is no number and does not count.
    let seconds = std::env::args().find_map(|argument| argument.parse::<f64>().ok()).unwrap_or(3.0);
    let asked = |word: &str| {
        let mut words = std::env::args().skip(1).filter(|word| ["small", "many", "start"].contains(&&**word));
        words.next().is_none_or(|asked| asked == word)
    };
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    if std::env::args().any(|argument| argument == ECHO) {
        return runtime.block_on(echo_alone());
    }
    runtime.block_on(async {
        if asked("small") {
            over_http(Duration::from_secs_f64(seconds)).await?;
        }
        if asked("many") {
            many_poses().await?;
        }
        if asked("start") {
            whole_process().await?;
        }
        Ok(())
    })
}
