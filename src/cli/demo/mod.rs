//! Loads an example into an empty data directory: a machine with its tools, calibration runs over ten months with one
//! of them applied, the wear of two cutters, and jobs with their programs and reports. Everything goes through the
//! operations of the interface, so it is what a client could have sent, and the audit log has it.

mod caller;
mod content;
mod measured_runs;

use std::fmt::Write;
use std::io;
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;
use thiserror::Error;

use self::caller::Caller;
use self::content::{CALIBRATION_APPLIED, FAILS, Job, MACHINE};
use super::serve::{Running, start};
use super::settings::say;
use super::{CommandFault, StartFault};
use crate::config::Settings;
use crate::jobs::{Cost, CutterContactCompensator, IssueFault, Sources};
use crate::store::{DATABASE_NAME, DatabaseFile, StoreError, content_of};

/// Why the example was not loaded.
#[derive(Debug, Error)]
pub enum DemoFault {
    /// The data directory is in use by people.
    #[error(
        "the data directory {} holds {count} rows in {table}; nothing was changed. Name an empty or new directory: \
         trunnion demo --data-dir ./demo", path.display()
    )]
    NotEmpty {
        /// The directory.
        path: PathBuf,
        /// The table with rows.
        table: &'static str,
        /// The number of its rows.
        count: u64,
    },
    /// The directory is no data directory, and has other files.
    #[error(
        "the directory {} holds {found:?} and no database of this service; nothing was changed. Name an empty or new \
         directory: trunnion demo --data-dir ./demo", path.display()
    )]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// Something in it.
        found: String,
    },
    /// The directory cannot be read.
    #[error("the directory {} cannot be read: {source}", path.display())]
    Unreadable {
        /// The directory.
        path: PathBuf,
        /// The fault.
        source: io::Error,
    },
    /// The database cannot be used.
    #[error("the database cannot be used: {0}")]
    Store(#[from] StoreError),
    /// No key for the example was created.
    #[error(transparent)]
    Issue(#[from] IssueFault),
    /// A request of the example was refused.
    #[error(
        "{method} {path} answered {status}: {detail}. The data directory has a part of the example; remove it before \
         you try again"
    )]
    Refused {
        /// The method.
        method: String,
        /// The path.
        path: String,
        /// The status.
        status: u16,
        /// The reason.
        detail: String,
    },
    /// A job of the example has another end than it must have.
    #[error(
        "the job {name} ended as {state}: {detail}. The data directory has a part of the example; remove it before you \
         try again"
    )]
    Job {
        /// Its name.
        name: &'static str,
        /// Its state.
        state: String,
        /// The reason.
        detail: String,
    },
    /// The example itself is not sound.
    #[error("the example cannot be made: {0}")]
    Content(String),
}

/// Rows that a data directory has before anybody used it.
const UNUSED: [(&str, u64); 6] = [
    ("jobs", 0),
    ("calibrations", 0),
    ("wear_entries", 0),
    ("tools", 0),
    ("machines", 1),
    ("machine_revisions", 1),
];

/// Loads the example and says what to look at.
pub(super) fn run(settings: Settings) -> Result<(), StartFault> {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    let runtime = runtime.map_err(StartFault::Process)?;
    let (listen, data_dir) = (settings.listen, settings.data_dir.clone());
    let text = runtime.block_on(async {
        if settings.database.is_none() {
            is_unused(&data_dir).await?;
        }
        // The service of the example listens for nobody.
        let here = (IpAddr::from(Ipv4Addr::LOCALHOST), 0).into();
        let settings = Settings { listen: here, tls_certificate: None, tls_key: None, ..settings };
        let budget = Cost::budget_within(settings.max_cost_s);
        let compensator = Arc::new(CutterContactCompensator { budget });
        let running = start(settings, Sources::real(), compensator).await?;
        let loaded = match is_unused_yet(&running, &data_dir).await {
            Ok(()) => load(&running).await,
            Err(fault) => Err(fault),
        };
        let has_keys = !matches!(running.guarding, super::Guarding::Loopback);
        running.stop().await.map_err(StartFault::Process)?;
        let base = format!("http://{listen}");
        Ok::<_, StartFault>(told(&loaded?, &data_dir, &base, has_keys))
    })?;
    Ok(say(text.trim_end())?)
}

/// Refuses a directory that people have used.
async fn is_unused(data_dir: &Path) -> Result<(), DemoFault> {
    let database = data_dir.join(DATABASE_NAME);
    if !database.is_file() {
        let path = data_dir.to_owned();
        return match content_of(data_dir) {
            Ok(None) => Ok(()),
            Ok(Some(found)) => Err(DemoFault::Foreign { path, found }),
            Err(fault) if fault.kind() == io::ErrorKind::NotFound => Ok(()),
            Err(source) => Err(DemoFault::Unreadable { path, source }),
        };
    }
    let mut file = DatabaseFile::open(&database).await?;
    let rows = file.row_counts().await;
    file.close().await;
    let rows = rows?;
    for (table, unused) in UNUSED {
        let count = rows.get(table).copied().unwrap_or_default();
        if count > unused {
            return Err(DemoFault::NotEmpty { path: data_dir.to_owned(), table, count });
        }
    }
    Ok(())
}

/// Refuses a database that people have used.
async fn is_unused_yet(running: &Running, data_dir: &Path) -> Result<(), DemoFault> {
    for (table, unused) in UNUSED {
        let count = running.state.store.row_count(table).await?;
        if count > unused {
            return Err(DemoFault::NotEmpty { path: data_dir.to_owned(), table, count });
        }
    }
    Ok(())
}

/// What was loaded.
struct Loaded {
    calibrations: Vec<String>,
    applied: String,
    jobs: Vec<(Job, String)>,
    wear_entries: usize,
    revision: i64,
}

async fn load(running: &Running) -> Result<Loaded, DemoFault> {
    let mut caller = Caller::admitted(running).await?;
    let loaded = loaded_by(&caller).await;
    caller.leave().await?;
    loaded
}

async fn loaded_by(caller: &Caller) -> Result<Loaded, DemoFault> {
    let base = format!("/v1/machines/{MACHINE}");
    let profile = content::profile()?;
    caller.put(&base, &profile).await?;
    for (tool, document) in content::tools() {
        caller.put(&format!("{base}/tools/{tool}"), &document).await?;
    }
    let mut calibrations = Vec::new();
    for run in measured_runs::runs(&profile)? {
        let made = caller.post(&format!("{base}/calibrations"), &run).await?;
        calibrations.push(text(&made, "id"));
    }
    let applied = calibrations.get(CALIBRATION_APPLIED).cloned().unwrap_or_default();
    let revised = caller.apply(&format!("{base}/calibrations/{applied}/apply")).await?;
    let revision = revised.get("revision").and_then(Value::as_i64).unwrap_or_default();
    let entries = content::wear_entries();
    let wear_entries = entries.as_array().map_or(0, Vec::len);
    caller.post(&format!("{base}/tools/T12/wear-entries"), &entries).await?;
    let mut jobs = Vec::new();
    for job in content::jobs() {
        let accepted = caller.post_job(&job).await?;
        jobs.push((job, text(&accepted, "id")));
    }
    for (job, id) in &jobs {
        let ended = caller.ended(id).await?;
        let expected = if job.name == FAILS { "failed" } else { "succeeded" };
        let state = text(&ended, "state");
        if state != expected {
            let detail = ended.pointer("/problem/detail").and_then(Value::as_str).unwrap_or_default();
            return Err(DemoFault::Job { name: job.name, state, detail: detail.to_owned() });
        }
    }
    Ok(Loaded { calibrations, applied, jobs, wear_entries, revision })
}

/// A member that is text.
fn text(document: &Value, name: &str) -> String {
    document.get(name).and_then(Value::as_str).unwrap_or_default().to_owned()
}

/// What was loaded, and where to look.
fn told(loaded: &Loaded, data_dir: &Path, base: &str, has_keys: bool) -> String {
    let Loaded { calibrations, applied, jobs, wear_entries, revision } = loaded;
    let machine = format!("{base}/v1/machines/{MACHINE}");
    let mut out = format!(
        "{} now holds the machine {MACHINE} (revision {revision}): {} calibration runs, one applied;\n\
         {wear_entries} wear entries of two cutters; {} jobs, one refused on purpose.\n\n\
         Start the service:\n  trunnion --data-dir {}\n\nOpen in a browser:\n",
        data_dir.display(),
        calibrations.len(),
        jobs.len(),
        data_dir.display(),
    );
    let mut link = |what: &str, url: String| {
        // Writing to a text cannot fail.
        let _always = writeln!(out, "  {what:<34} {url}");
    };
    link("first page", format!("{base}/"));
    link("calibration report", format!("{machine}/calibrations/{applied}"));
    for (job, id) in jobs {
        let end = if job.has_plot { "/plot" } else { "" };
        link(job.name, format!("{base}/v1/jobs/{id}{end}"));
    }
    let header = if has_keys { " -H 'Authorization: Bearer KEY'" } else { "" };
    let _always = write!(
        out,
        "\nDraw the histories:\n  \
         curl -s '{machine}/calibrations/trend?axis=A&error=e_y' -H 'Accept: image/svg+xml'{header} -o trend.svg\n  \
         curl -s '{machine}/tools/T12/wear-trend?limit_um=60' -H 'Accept: image/svg+xml'{header} -o wear.svg\n"
    );
    if has_keys {
        out.push_str("\nThe data directory has API keys, so a browser needs one too: use curl with the header above.\n");
    }
    out
}

impl From<DemoFault> for CommandFault {
    fn from(fault: DemoFault) -> Self {
        Self::Demo(fault)
    }
}

impl From<DemoFault> for StartFault {
    fn from(fault: DemoFault) -> Self {
        Self::Command(fault.into())
    }
}
