//! Operations as users call them: a file in, a file out, with default parameters, on the command line and over HTTP.
//! The binary is measured from outside, so everything counts: the start, the survey, the work, the check, the list of
//! singular regions, digests, the stamp and the files.
//!
//! `cargo bench --bench operations` times every operation. A word after `--` selects rows whose name contains it.
//! `cargo bench --bench operations -- growth` times `cc-compensation` from 10⁵ to 10⁷ blocks and draws the figure of
//! docs/performance.md. `-- instructions` counts the instructions of every row and compares them with those of the
//! last release.

#![expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use futures::StreamExt;
use programs::{Form, write_program};
use serde_json::{Value, json};

mod growth;
mod instructions;
mod programs;

type Failure = Box<dyn std::error::Error>;

/// The service as it is built.
const TRUNNION: &str = env!("CARGO_BIN_EXE_trunnion");
/// Rounds in which the rows take turns. The middle one counts.
const ROUNDS: usize = 3;
/// Limit of programs and results \[bytes\].
const MOST_BYTES: &str = "4000000000";
/// How often the memory of a running command is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// A row of the table.
struct Row {
    operation: &'static str,
    form: Form,
    parameters: Value,
    blocks: u32,
    /// Whether the part's surface is sent with the program.
    has_part: bool,
}

impl Row {
    fn name(&self) -> String {
        format!("{}, {}", self.operation, self.form.name())
    }

    /// Whether the command line does not have the operation.
    fn is_only_over_http(&self) -> bool {
        self.operation == "interpretation"
    }
}

fn rows() -> Vec<Row> {
    let offset = json!([12, -7, 35]);
    let row =
        |operation, form, parameters, blocks| Row { operation, form, parameters, blocks, has_part: false };
    let forms = [
        Form::Iso,
        Form::ContactWords,
        Form::Siemens,
        Form::Heidenhain,
        Form::Okuma,
        Form::Table,
        Form::CutterLocations,
    ];
    let mut rows: Vec<Row> = forms
        .into_iter()
        .map(|form| {
            row("cc-compensation", form, json!({"tool_radius_mm": 5, "work_offset_mm": offset}), 1_000_000)
        })
        .collect();
    let worn = json!({"nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4.75}, "contact": "feed-plane"});
    let with = |mut parameters: Value, more: Value| {
        for (name, value) in more.as_object().into_iter().flatten() {
            parameters[name] = value.clone();
        }
        parameters
    };
    let placed = json!({"work_offset_mm": offset});
    rows.push(row("wear-compensation", Form::Iso, with(worn.clone(), placed.clone()), 300_000));
    rows.push(row(
        "compensation",
        Form::Iso,
        with(
            json!({"wear": worn, "cc": {"tool_radius_mm": 5, "contact": "tip"}, "location_errors": true}),
            placed.clone(),
        ),
        300_000,
    ));
    rows.push(row("posting", Form::CutterLocations, placed.clone(), 300_000));
    rows.push(row("servo-simulation", Form::Iso, placed.clone(), 30_000));
    rows.push(row("interpretation", Form::Iso, placed.clone(), 300_000));
    rows.push(Row {
        has_part: true,
        ..row("verification", Form::Iso, with(json!({"tool": {"radius_mm": 5}}), placed), 100_000)
    });
    rows
}

/// File name extension by which the service knows the form.
const fn extension(form: Form) -> &'static str {
    match form {
        Form::Iso | Form::ContactWords => "nc",
        Form::Siemens => "mpf",
        Form::Heidenhain => "h",
        Form::Okuma => "min",
        Form::Table => "csv",
        Form::CutterLocations => "apt",
    }
}

/// The times of a row [s], and its largest memory on the command line [MiB].
#[derive(Default)]
struct Times {
    one_core: Vec<f64>,
    all_cores: Vec<f64>,
    over_http: Vec<f64>,
    peak_mib: f64,
}

fn median(times: &[f64]) -> Option<f64> {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

fn main() -> Result<(), Failure> {
    let asked = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    let folder = tempfile::tempdir()?;
    let service = Service::start(folder.path())?;
    let profile = folder.path().join("machine.json");
    fs::write(&profile, service.profile()?.to_string())?;
    if asked.as_deref() == Some("growth") {
        drop(service);
        return growth::growth(folder.path(), &profile);
    }
    if asked.as_deref() == Some("instructions") {
        drop(service);
        return instructions::compare(folder.path(), &profile, &rows());
    }
    let rows: Vec<Row> = rows()
        .into_iter()
        .filter(|row| {
            asked.as_ref().is_none_or(|asked| row.name().to_lowercase().contains(&asked.to_lowercase()))
        })
        .collect();
    let part = folder.path().join("part.stl");
    fs::write(&part, wavy_plate())?;
    let mut times: Vec<Times> = rows.iter().map(|_| Times::default()).collect();
    for _ in 0..ROUNDS {
        for (row, times) in rows.iter().zip(&mut times) {
            let program = folder.path().join("program").with_extension(extension(row.form));
            write_program(&program, row.form, row.blocks)?;
            let call = Call { row, program: &program, profile: &profile, part: &part };
            for (cores, times_s) in [(Some("0"), &mut times.one_core), (None, &mut times.all_cores)] {
                if let Some((took_s, peak_mib)) = call.on_the_command_line(cores)? {
                    times_s.push(took_s);
                    times.peak_mib = times.peak_mib.max(peak_mib);
                }
            }
            times.over_http.push(call.over_http(&service)?);
        }
    }
    println!(
        "| operation | blocks | one core, M blocks/s | all cores | over HTTP, all cores | peak memory, MiB |"
    );
    println!("|---|---|---|---|---|---|");
    for (row, times) in rows.iter().zip(&times) {
        let rate = |seconds: &[f64]| {
            median(seconds)
                .map_or_else(|| "–".to_owned(), |s| format!("{:.2}", f64::from(row.blocks) / s / 1e6))
        };
        println!(
            "| {} | {} | {} | {} | {} | {:.0} |",
            row.name(),
            row.blocks,
            rate(&times.one_core),
            rate(&times.all_cores),
            rate(&times.over_http),
            times.peak_mib
        );
    }
    Ok(())
}

/// One call of an operation.
struct Call<'a> {
    row: &'a Row,
    program: &'a Path,
    profile: &'a Path,
    part: &'a Path,
}

impl Call<'_> {
    /// The command of this call, run by another one if `before` is not empty.
    fn command(&self, before: &[&str]) -> Command {
        let mut command = match before {
            [first, rest @ ..] => {
                let mut command = Command::new(first);
                command.args(rest).arg(TRUNNION);
                command
            }
            [] => Command::new(TRUNNION),
        };
        // The longest programs are longer than the default limits.
        command.env("TRUNNION_MAX_BODY_BYTES", MOST_BYTES).env("TRUNNION_MAX_RESULT_BYTES", MOST_BYTES);
        let report = self.program.with_extension("report");
        command.args(["compensate", "--machine"]).arg(self.profile);
        command.args(["--operation", self.row.operation, "--parameters", &self.row.parameters.to_string()]);
        command.arg("--report").arg(&report);
        if self.row.has_part {
            command.arg("--surface").arg(self.part);
        }
        command.arg(self.program);
        if !matches!(self.row.operation, "servo-simulation" | "verification") {
            command.arg(self.program.with_extension("out"));
        }
        command
    }

    /// The time from the start of the command to its end [s], and its largest memory [MiB]. `cores` are the ones it
    /// may use; `None` if the system cannot choose them.
    fn on_the_command_line(&self, cores: Option<&str>) -> Result<Option<(f64, f64)>, Failure> {
        if self.row.is_only_over_http() {
            return Ok(None);
        }
        let before: Vec<&str> = cores.map_or_else(Vec::new, |cores| vec!["taskset", "-c", cores]);
        let mut command = self.command(&before);
        let begun = Instant::now();
        let mut child = match command.stderr(Stdio::piped()).spawn() {
            Err(fault) if fault.kind() == io::ErrorKind::NotFound && cores.is_some() => return Ok(None),
            spawned => spawned?,
        };
        let mut peak_mib: f64 = 0.0;
        let status = loop {
            peak_mib = peak_mib.max(peak_memory_mib(child.id()));
            if let Some(status) = child.try_wait()? {
                break status;
            }
            std::thread::sleep(LOOK_EVERY);
        };
        let took_s = begun.elapsed().as_secs_f64();
        if !status.success() {
            let told = io::read_to_string(child.stderr.take().ok_or("no standard error")?)?;
            return Err(format!("{}: {told}", self.row.name()).into());
        }
        Ok(Some((took_s, peak_mib)))
    }

    /// The time from the first byte of the request to the last byte of the answer [s].
    fn over_http(&self, service: &Service) -> Result<f64, Failure> {
        let url = format!("{}/v1/machines/example-ac-table/{}", service.base, self.row.operation);
        let program = fs::read(self.program)?;
        let surface = if self.row.has_part { Some(fs::read(self.part)?) } else { None };
        let name = self.program.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let out = self.program.with_extension("http");
        let (parameters, url) = (self.row.parameters.to_string(), url.as_str());
        service.runtime.block_on(async {
            let mut form = reqwest::multipart::Form::new().text("parameters", parameters);
            if let Some(surface) = surface {
                form = form.part("surface", reqwest::multipart::Part::bytes(surface).file_name("part.stl"));
            }
            let form = form.part("program", reqwest::multipart::Part::bytes(program).file_name(name));
            let begun = Instant::now();
            let answer = service.client.post(url).multipart(form).send().await?;
            let (status, mut body) = (answer.status(), answer.bytes_stream());
            let mut file = File::create(&out)?;
            while let Some(chunk) = body.next().await {
                file.write_all(&chunk?)?;
            }
            if !status.is_success() {
                return Err(format!("{url}: {status} {}", fs::read_to_string(&out)?).into());
            }
            Ok(begun.elapsed().as_secs_f64())
        })
    }
}

/// Largest resident memory of a process so far [MiB]; 0 where the system does not say.
fn peak_memory_mib(process: u32) -> f64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let kib = line.and_then(|line| line.split_whitespace().nth(1)).and_then(|kib| kib.parse::<f64>().ok());
    kib.unwrap_or(0.0) / 1024.0
}

/// A running service with its own data directory.
struct Service {
    child: Child,
    base: String,
    client: reqwest::Client,
    runtime: tokio::runtime::Runtime,
}

impl Service {
    fn start(folder: &Path) -> Result<Self, Failure> {
        let mut child = Command::new(TRUNNION)
            .args(["--listen", "127.0.0.1:0", "--log-format", "json", "--data-dir"])
            .arg(folder.join("data"))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let told = BufReader::new(child.stdout.take().ok_or("no standard output")?);
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let mut base = None;
        for line in told.lines() {
            let line = line?;
            if let Some(at) = line.find("127.0.0.1:") {
                let port: String = line[at + 10..].chars().take_while(char::is_ascii_digit).collect();
                base = Some(format!("http://127.0.0.1:{port}"));
                break;
            }
        }
        let client = reqwest::Client::builder().no_proxy().build()?;
        Ok(Self { child, base: base.ok_or("the service did not start")?, client, runtime })
    }

    /// The profile of the example machine, with errors of location, for the command line.
    fn profile(&self) -> Result<Value, Failure> {
        let url = format!("{}/v1/machines/example-ac-table", self.base);
        self.runtime.block_on(async {
            let mut profile: Value = self.client.get(&url).send().await?.error_for_status()?.json().await?;
            if let Some(members) = profile.as_object_mut() {
                members.retain(|name, _| !matches!(name.as_str(), "machine_id" | "revision" | "created_at"));
            }
            profile["kinematics"]["rotary_axes"][0]["location_error"] =
                json!({"e_x_um": 12.0, "e_y_um": -21.0});
            let stored = self.client.put(&url).header("if-match", "*").json(&profile).send().await?;
            stored.error_for_status()?;
            Ok(profile)
        })
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ended = self.child.kill().and_then(|()| self.child.wait());
    }
}

/// A part of 80 000 facets below the program.
fn wavy_plate() -> Vec<u8> {
    const SQUARES: u16 = 200;
    const SIDE_MM: f32 = 0.5;
    let place = |i: u16, j: u16| {
        let (x, y) = (f32::from(i) * SIDE_MM + 30.0, f32::from(j) * SIDE_MM - 70.0);
        [x, y, 30.0 + (x / 9.0).sin() + (y / 7.0).cos()]
    };
    let mut facets = Vec::new();
    for (i, j) in (0..SQUARES).flat_map(|i| (0..SQUARES).map(move |j| (i, j))) {
        let [a, b, c, d] = [place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
        for corners in [[a, b, c], [a, c, d]] {
            facets.extend(
                [[0.0, 0.0, 1.0], corners[0], corners[1], corners[2]]
                    .as_flattened()
                    .iter()
                    .flat_map(|v| v.to_le_bytes()),
            );
            facets.extend([0, 0]);
        }
    }
    let count = 2 * u32::from(SQUARES) * u32::from(SQUARES);
    [&[0; 80], count.to_le_bytes().as_slice(), &facets].concat()
}
