//! Many poses over HTTP: a table of a million and documents of ten thousand, against the binary itself. The client
//! only sends prepared bytes and counts the bytes of the answer.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs::File;
use std::net::SocketAddr;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use bytes::Bytes;
use http_body_util::{BodyExt, Full};
use tempfile::TempDir;

use crate::{Failure, PATH, connect, middle, ready};

/// Rounds of each row; the middle one counts.
const ROUNDS: usize = 7;
/// Connections that send documents at the same time.
const SENDERS: usize = 4;
/// Documents of a connection in one round.
const DOCUMENTS: usize = 12;

/// The binary of this build, or the one that `TRUNNION_BINARY` names, for a comparison.
pub(crate) fn binary() -> OsString {
    std::env::var_os("TRUNNION_BINARY").unwrap_or_else(|| env!("CARGO_BIN_EXE_trunnion").into())
}

/// A running service, and the folder of its data.
pub(crate) struct Running {
    child: Child,
    pub(crate) address: SocketAddr,
    _data: TempDir,
}

impl Running {
    /// Starts the binary and waits until it is ready. Also returns how long that took \[ms\].
    pub(crate) async fn start(log: &str) -> Result<(Self, f64), Failure> {
        let data = TempDir::new()?;
        let address = std::net::TcpListener::bind("127.0.0.1:0")?.local_addr()?;
        let began = Instant::now();
        let child = Command::new(binary())
            .args(["--listen", &address.to_string(), "--log", log, "--data-dir"])
            .arg(data.path())
            .env("TRUNNION_MAX_RATE_PER_S", "0")
            .stdout(Stdio::null())
            .stderr(File::create(data.path().join("log"))?)
            .spawn()?;
        let running = Self { child, address, _data: data };
        while ready(address).await.is_err() {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        Ok((running, began.elapsed().as_secs_f64() * 1e3))
    }

    /// A number of the process's status \[MiB\]: `VmRSS` for its memory now, `VmHWM` for the largest so far.
    pub(crate) fn memory_mib(&self, name: &str) -> f64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap_or_default();
        let found = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
        let kib = found.and_then(|text| text.trim().strip_suffix(" kB")?.trim().parse::<f64>().ok());
        kib.unwrap_or(f64::NAN) / 1024.0
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ended = self.child.kill().and_then(|()| self.child.wait());
    }
}

/// The values of a pose: a finishing path over a curved surface.
fn pose(n: usize) -> [f64; 6] {
    let s = n as f64 * 1e-3;
    let (tilt, azimuth) = (0.52 + 0.34 * (s * 1.3).sin(), 2.4 * (s * 0.37).sin());
    let [i, j, k] = [tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos()];
    [80.0 * s.cos(), 60.0 * (s * 0.7).sin(), 10.0 + 5.0 * (s * 0.1).sin(), i, j, k]
}

fn table(poses: usize) -> Bytes {
    let mut text = "x,y,z,i,j,k\n".to_owned();
    for n in 0..poses {
        let [x, y, z, i, j, k] = pose(n);
        let _never_fails = writeln!(text, "{x:.6},{y:.6},{z:.6},{i:.6},{j:.6},{k:.6}");
    }
    text.into()
}

fn document(poses: usize) -> Bytes {
    let mut text = "{\"poses\":[".to_owned();
    for n in 0..poses {
        let [x, y, z, i, j, k] = pose(n);
        let comma = if n == 0 { "" } else { "," };
        let _never_fails = write!(
            text,
            "{comma}{{\"x\":{x:.6},\"y\":{y:.6},\"z\":{z:.6},\"i\":{i:.6},\"j\":{j:.6},\"k\":{k:.6}}}"
        );
    }
    text += "],\"work_offset_mm\":[70,-40,95]}";
    text.into()
}

/// Sends this body `times` times, one after the other. Returns the bytes of the answers.
async fn send(address: SocketAddr, kind: &str, body: &Bytes, times: usize) -> Result<usize, Failure> {
    let mut sender = connect(address).await?;
    let mut length = 0;
    for _ in 0..times {
        sender.ready().await?;
        let request = http::Request::post(PATH).header("host", "bench").header("content-type", kind);
        let mut answer = sender.send_request(request.body(Full::from(body.clone()))?).await?;
        let status = answer.status();
        while let Some(frame) = answer.frame().await {
            let data = frame?.into_data().unwrap_or_default();
            length += data.len();
            if status != 200 {
                return Err(format!("{status}: {}", String::from_utf8_lossy(&data)).into());
            }
        }
    }
    Ok(length)
}

/// The rate of a table of poses \[M/s\], and the service's largest memory above idle \[MiB\].
async fn of_table(poses: usize) -> Result<[f64; 2], Failure> {
    let (running, _) = Running::start("warn").await?;
    let (body, idle_mib) = (table(poses), running.memory_mib("VmRSS"));
    let mut rates = Vec::new();
    for _ in 0..ROUNDS {
        let began = Instant::now();
        send(running.address, "text/csv", &body, 1).await?;
        rates.push(poses as f64 / began.elapsed().as_secs_f64() / 1e6);
    }
    Ok([middle(rates), running.memory_mib("VmHWM") - idle_mib])
}

/// The same for documents of ten thousand poses, sent by several connections at the same time.
async fn of_documents(senders: usize) -> Result<[f64; 2], Failure> {
    const POSES: usize = 10_000;
    let (running, _) = Running::start("warn").await?;
    let (body, idle_mib) = (document(POSES), running.memory_mib("VmRSS"));
    let mut rates = Vec::new();
    for _ in 0..ROUNDS {
        let began = Instant::now();
        let sent = (0..senders).map(|_| {
            let (address, body) = (running.address, body.clone());
            tokio::spawn(async move { send(address, "application/json", &body, DOCUMENTS).await })
        });
        for sent in sent.collect::<Vec<_>>() {
            sent.await??;
        }
        rates.push((senders * DOCUMENTS * POSES) as f64 / began.elapsed().as_secs_f64() / 1e6);
    }
    Ok([middle(rates), running.memory_mib("VmHWM") - idle_mib])
}

/// Prints a row for each size of table and each number of connections.
#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
pub(crate) async fn many_poses() -> Result<(), Failure> {
    for poses in [250_000, 500_000, 1_000_000, 2_000_000] {
        let [rate, peak_mib] = of_table(poses).await?;
        println!("inverse of {poses} poses, CSV: {rate:.2} M poses/s, {peak_mib:.0} MiB above idle at most");
    }
    for senders in [1, SENDERS] {
        let [rate, peak_mib] = of_documents(senders).await?;
        println!(
            "inverse of 10000 poses, JSON, {senders} connections: {rate:.2} M poses/s, {peak_mib:.0} MiB above idle at most"
        );
    }
    Ok(())
}
