//! Small calls over HTTP against an echo of the same body, side by side in one process: `cargo bench --bench http`,
//! with `-- SECONDS` for longer runs. On a quiet machine: clients and service share its cores.
//!
//! What is said last is of the binary itself: from its start to its first answer, and its memory once it idles.

#![expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]

use std::net::SocketAddr;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use axum::Router;
use axum::routing::post;
use http_body_util::{BodyExt, Full};
use hyper::client::conn::http1::{self, SendRequest};
use hyper_util::rt::TokioIo;
use serde::{Deserialize, Serialize};
use tempfile::TempDir;
use tokio::net::{TcpListener, TcpStream};
use trunnion::config::{LogFormat, Settings};
use trunnion::http::{AppState, behind_the_edge, router};
use trunnion::jobs::{CutterContactCompensator, Sources};

type Failure = Box<dyn std::error::Error + Send + Sync>;

const BODY: &str = r#"{"poses":[{"x":10.0,"y":20.0,"z":30.0,"i":0.3,"j":-0.2,"k":0.93}],"work_offset_mm":[70.0,-40.0,95.0]}"#;
const PATH: &str = "/v1/machines/example-ac-table/inverse-kinematics";
/// Connections that are kept open, as `wrk -c 32` would.
const CONNECTIONS: usize = 32;
/// Rounds in which the three take turns; the middle one of each counts.
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

async fn ask(sender: &mut SendRequest<Full<bytes::Bytes>>, path: &str) -> Result<(), Failure> {
    sender.ready().await?;
    let request = http::Request::post(path)
        .header("host", "bench")
        .header("content-type", "application/json")
        .body(Full::from(BODY))?;
    let response = sender.send_request(request).await?;
    let status = response.status();
    let body = response.into_body().collect().await?.to_bytes();
    if status == 200 { Ok(()) } else { Err(format!("{status}: {}", String::from_utf8_lossy(&body)).into()) }
}

/// As many requests as go through: their rate \[1/s\].
async fn flood(address: SocketAddr, path: &'static str, time: Duration) -> Result<f64, Failure> {
    let over = Arc::new(AtomicBool::new(false));
    let mut clients = Vec::new();
    for _ in 0..CONNECTIONS {
        let (mut sender, over) = (connect(address).await?, Arc::clone(&over));
        clients.push(tokio::spawn(async move {
            let mut count = 0_u64;
            while !over.load(Ordering::Relaxed) {
                ask(&mut sender, path).await?;
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
async fn steady(
    address: SocketAddr,
    path: &'static str,
    rate_per_s: f64,
    time: Duration,
) -> Result<[f64; 2], Failure> {
    let each = Duration::from_secs_f64(CONNECTIONS as f64 / rate_per_s);
    let mut clients = Vec::new();
    let began = Instant::now() + Duration::from_millis(50);
    for k in 0..CONNECTIONS {
        let mut sender = connect(address).await?;
        let first = began + each.mul_f64(k as f64 / CONNECTIONS as f64);
        clients.push(tokio::spawn(async move {
            let mut times_s = Vec::new();
            let mut due = first;
            while due < began + time {
                tokio::time::sleep_until(due.into()).await;
                // The timer ticks in milliseconds; what it adds is its own.
                let sent = Instant::now().min(due + Duration::from_millis(2));
                ask(&mut sender, path).await?;
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

async fn over_http(time: Duration) -> Result<(), Failure> {
    let data = TempDir::new()?;
    let settings =
        Settings { data_dir: data.path().to_owned(), log_format: LogFormat::Json, ..Settings::default() };
    std::fs::create_dir_all(&settings.data_dir)?;
    let state =
        AppState::open(settings, Sources::real(), Arc::new(CutterContactCompensator::default())).await?;
    let same_edge = behind_the_edge(Router::new().route("/echo", post(echo)), state.clone());
    let bare = Router::new().route("/echo", post(echo));
    let them = [
        ("inverse kinematics of one pose", serve(router(state)).await?, PATH),
        ("echo behind the same middleware", serve(same_edge).await?, "/echo"),
        ("bare echo", serve(bare).await?, "/echo"),
    ];
    let mut rates = [const { Vec::new() }; 3];
    for _ in 0..ROUNDS {
        for ((_, address, path), rates) in them.iter().zip(&mut rates) {
            rates.push(flood(*address, path, time).await?);
        }
    }
    let rates = rates.map(middle);
    for ((name, address, path), rate) in them.iter().zip(rates) {
        let [half_ms, most_ms] = steady(*address, path, rate / 2.0, time * 2).await?;
        println!(
            "{name:34} {rate:8.0} requests/s   at half that rate p50 {half_ms:.2} ms, p99 {most_ms:.2} ms"
        );
    }
    println!("inverse / echo behind the same middleware {:.3} (aim 0.90)", rates[0] / rates[1]);
    println!("inverse / bare echo {:.3} (aim 0.70)", rates[0] / rates[2]);
    Ok(())
}

/// From the start of the process to its first answer \[ms\], and its memory then and after some requests \[MiB\].
async fn whole_process() -> Result<(), Failure> {
    let (mut ready_ms, mut idle_mib) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let data = TempDir::new()?;
        let address = std::net::TcpListener::bind("127.0.0.1:0")?.local_addr()?;
        let began = Instant::now();
        let mut child = Command::new(env!("CARGO_BIN_EXE_trunnion"))
            .args(["--listen", &address.to_string(), "--log", "warn", "--data-dir"])
            .arg(data.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()?;
        while ready(address).await.is_err() {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        ready_ms.push(began.elapsed().as_secs_f64() * 1e3);
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let resident =
            status.lines().find_map(|line| line.strip_prefix("VmRSS:")?.trim().strip_suffix(" kB"));
        idle_mib.extend(resident.and_then(|text| text.trim().parse::<f64>().ok()).map(|kib| kib / 1024.0));
        child.kill()?;
        child.wait()?;
    }
    println!(
        "ready after {:.0} ms (aim 150), idle memory {:.1} MiB (aim 30)",
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
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
    runtime.block_on(async {
        over_http(Duration::from_secs_f64(seconds)).await?;
        whole_process().await
    })
}
