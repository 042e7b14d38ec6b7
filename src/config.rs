//! Every setting: type, unit, default, environment name. A flag overrides the environment, and the
//! environment overrides the file.

mod allowed;
mod database_address;
mod environment;
mod files_in;

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use allowed::{AllowedReceiver, NoReceiver};
pub use database_address::DatabaseAddress;
pub use environment::unknown_variables;
pub use files_in::{Bucket, FilesIn, NoPlace};

/// Declares each setting once: the field, its type, its default, the name of its environment variable, and
/// further attributes of its flag.
macro_rules! settings {
    ($($(#[doc = $doc:literal])+ $name:ident: $type:ty = $default:expr, $env:literal $(, [$($arg:tt)+])?;)+) => {
        /// The service's settings, complete.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct Settings {
            $($(#[doc = $doc])+ pub $name: $type,)+
        }

        impl Default for Settings {
            fn default() -> Self {
                Self { $($name: $default,)+ }
            }
        }

        /// Settings of the command line or the environment; absent settings come from the file or the
        /// defaults.
        #[derive(Debug, Clone, Default, clap::Args)]
        pub struct Flags {
            $(
                $(#[doc = $doc])+
                #[arg(long, env = $env, global = true $(, $($arg)+)?)]
                pub $name: Option<$type>,
            )+
        }

        impl Flags {
            /// These settings with those of the command line and the environment in their places.
            fn over(&self, mut settings: Settings) -> Settings {
                $(if let Some(given) = &self.$name {
                    settings.$name.clone_from(given);
                })+
                settings
            }

            /// Whether the command line or the environment gives this setting.
            fn give(&self, name: &str) -> bool {
                match name {
                    $(stringify!($name) => self.$name.is_some(),)+
                    _ => false,
                }
            }
        }

        /// Name of each setting and of its environment variable.
        pub const ENVIRONMENT: &[(&str, &str)] = &[$((stringify!($name), $env),)+];

        /// Name and meaning of each setting.
        pub const MEANINGS: &[(&str, &str)] = &[$((stringify!($name), concat!($($doc),+)),)+];
    };
}

settings! {
    /// Address and port to listen on; port 0 lets the system choose
    listen: SocketAddr = SocketAddr::from(([127, 0, 0, 1], 8080)), "TRUNNION_LISTEN";
    /// Directory of the database, the programs and their results; created when missing
    data_dir: PathBuf = PathBuf::from("./data"), "TRUNNION_DATA_DIR";
    /// Address of a database on a server of PostgreSQL, such as `postgres://trunnion@db.plant.example/trunnion`; without
    /// it, the database is a file in the data directory. Only in a binary with the feature `scale-out`
    database: Option<DatabaseAddress> = None, "TRUNNION_DATABASE", [hide_env_values = true];
    /// File with the password of the database; it overrides a password in the address
    database_password_file: Option<PathBuf> = None, "TRUNNION_DATABASE_PASSWORD_FILE";
    /// Where programs and results are kept: `directory` is the data directory, `postgres` the database,
    /// `s3://BUCKET/PREFIX` a bucket of S3. Several services can share a database only with the last two; the data
    /// directory then has copies
    files: FilesIn = FilesIn::Directory, "TRUNNION_FILES";
    /// Address of the server of the bucket, such as `https://s3.plant.example:9000`; without it, the bucket is one of
    /// Amazon's in the region `AWS_REGION`
    files_endpoint: Option<String> = None, "TRUNNION_FILES_ENDPOINT";
    /// File with the keys to the bucket, in lines such as `aws_access_key_id = …`; without it, the usual variables such as
    /// `AWS_ACCESS_KEY_ID` count
    files_credentials_file: Option<PathBuf> = None, "TRUNNION_FILES_CREDENTIALS_FILE";
    /// Serve on an address that other computers can reach even though no API key exists
    insecure: bool = false, "TRUNNION_INSECURE", [num_args = 0..=1, require_equals = true, default_missing_value = "true"];
    /// File (PEM) with the certificate and its chain; together with `tls_key` it switches TLS on
    tls_certificate: Option<PathBuf> = None, "TRUNNION_TLS_CERTIFICATE";
    /// File (PEM) with the certificate's private key
    tls_key: Option<PathBuf> = None, "TRUNNION_TLS_KEY";
    /// Largest program or CSV body, after decompression (bytes)
    max_body_bytes: u64 = 256 << 20, "TRUNNION_MAX_BODY_BYTES";
    /// Largest surface that is uploaded with a program, after decompression (bytes)
    max_surface_bytes: u64 = 3 << 30, "TRUNNION_MAX_SURFACE_BYTES";
    /// Most memory for all uploaded surfaces together while they are in use (bytes)
    max_surface_memory_bytes: u64 = 3 << 30, "TRUNNION_MAX_SURFACE_MEMORY_BYTES";
    /// Most memory of the process for requests, their answers and itself; surfaces have their own limit
    /// (bytes)
    max_memory_bytes: u64 = 512 << 20, "TRUNNION_MAX_MEMORY_BYTES";
    /// Largest JSON body, after decompression (bytes)
    max_json_bytes: u64 = 32 << 20, "TRUNNION_MAX_JSON_BYTES";
    /// Largest document that comes with a program, in the form field `parameters` or `job` (bytes)
    max_parameters_bytes: u64 = 1 << 20, "TRUNNION_MAX_PARAMETERS_BYTES";
    /// Most poses, joints or samples in one request
    max_poses: usize = 2_000_000, "TRUNNION_MAX_POSES";
    /// Largest estimated cost of one computation (s of one core)
    max_cost_s: f64 = 120.0, "TRUNNION_MAX_COST_S";
    /// Computations that run at the same time; 0 takes the number of cores
    max_computations: usize = 0, "TRUNNION_MAX_COMPUTATIONS";
    /// Computations that may wait for their turn before the service answers 503
    max_waiting_computations: usize = 64, "TRUNNION_MAX_WAITING_COMPUTATIONS";
    /// Jobs that may wait in the queue before the service answers 503
    max_queued_jobs: usize = 1000, "TRUNNION_MAX_QUEUED_JOBS";
    /// Most tools in the table of one machine; every job stores the whole table at its acceptance
    max_tools_per_machine: u32 = 2000, "TRUNNION_MAX_TOOLS_PER_MACHINE";
    /// Clients that may follow the events of jobs at the same time
    max_event_streams: usize = 256, "TRUNNION_MAX_EVENT_STREAMS";
    /// How long a job is kept after its end (s); 0 keeps it for ever
    job_retention_s: f64 = 0.0, "TRUNNION_JOB_RETENTION_S";
    /// Receivers of webhooks that are allowed although they are not public: networks and names, separated by
    /// commas
    webhook_allow: Vec<AllowedReceiver> = Vec::new(), "TRUNNION_WEBHOOK_ALLOW", [value_delimiter = ','];
    /// File (PEM) with certificates that receivers of webhooks are trusted by, in addition to those of the
    /// system
    webhook_ca_file: Option<PathBuf> = None, "TRUNNION_WEBHOOK_CA_FILE";
    /// Longest time for one attempt to deliver a webhook (s)
    webhook_timeout_s: f64 = 15.0, "TRUNNION_WEBHOOK_TIMEOUT_S";
    /// Pauses after failed attempts, separated by commas; after one more attempt the webhook is given up (s)
    webhook_pauses_s: Vec<f64> = WEBHOOK_PAUSES_S.to_vec(), "TRUNNION_WEBHOOK_PAUSES_S", [value_delimiter = ','];
    /// Webhooks that are delivered at the same time
    max_deliveries: usize = 16, "TRUNNION_MAX_DELIVERIES";
    /// Webhooks that are delivered to one receiver at the same time
    max_deliveries_per_receiver: usize = 2, "TRUNNION_MAX_DELIVERIES_PER_RECEIVER";
    /// Most open connections; further connections are closed at once
    max_connections: usize = 1024, "TRUNNION_MAX_CONNECTIONS";
    /// Most bytes of all uploads and results that are not stored yet, and of long tables of poses (bytes)
    max_spool_bytes: u64 = 16 << 30, "TRUNNION_MAX_SPOOL_BYTES";
    /// Part of what other callers leave that one key (without keys: one address) may hold: queued jobs, computations,
    /// event streams, bytes of uploads, results and long tables of poses under way, and (by address) connections
    max_share_per_caller: f64 = 0.75, "TRUNNION_MAX_SHARE_PER_CALLER";
    /// Largest file or table that one request makes (bytes)
    max_result_bytes: u64 = 4 << 30, "TRUNNION_MAX_RESULT_BYTES";
    /// Longest path and query of a request (bytes)
    max_url_bytes: usize = 32 << 10, "TRUNNION_MAX_URL_BYTES";
    /// Longest header of a request, all its fields together (bytes)
    max_header_bytes: usize = 32 << 10, "TRUNNION_MAX_HEADER_BYTES";
    /// Requests per second that one key (without keys: one address) may send in the long run; 0 sets no limit
    /// (1/s)
    max_rate_per_s: f64 = 50_000.0, "TRUNNION_MAX_RATE_PER_S";
    /// Requests that one caller may send at once after a pause
    max_burst_requests: u32 = 100_000, "TRUNNION_MAX_BURST_REQUESTS";
    /// Longest time from a request's header to its answer (s)
    request_timeout_s: f64 = 300.0, "TRUNNION_REQUEST_TIMEOUT_S";
    /// Longest time for a request's header, and for an idle connection (s)
    header_timeout_s: f64 = 15.0, "TRUNNION_HEADER_TIMEOUT_S";
    /// Longest pause within a request's body (s)
    body_pause_timeout_s: f64 = 30.0, "TRUNNION_BODY_PAUSE_TIMEOUT_S";
    /// Longest time in which a client reads nothing of its answer (s)
    answer_pause_timeout_s: f64 = 30.0, "TRUNNION_ANSWER_PAUSE_TIMEOUT_S";
    /// Time that open requests get to finish when the service stops (s)
    drain_timeout_s: f64 = 5.0, "TRUNNION_DRAIN_TIMEOUT_S";
    /// How long an Idempotency-Key is remembered (s)
    idempotency_retention_s: f64 = 604_800.0, "TRUNNION_IDEMPOTENCY_RETENTION_S";
    /// Database connections for reading
    store_readers: u32 = 4, "TRUNNION_STORE_READERS";
    /// Time between two complete checks of the stored data for damage; 0 for none (s)
    scrub_interval_s: f64 = 604_800.0, "TRUNNION_SCRUB_INTERVAL_S";
    /// Bytes that such a check reads per second (bytes)
    scrub_bytes_per_s: u64 = 20 << 20, "TRUNNION_SCRUB_BYTES_PER_S";
    /// Log filter: a level, or `target=level`; several are separated by commas
    log: String = "info".to_owned(), "TRUNNION_LOG";
    /// Form of the log lines
    log_format: LogFormat = LogFormat::Text, "TRUNNION_LOG_FORMAT";
    /// Address to which the spans of requests are sent as OTLP over HTTP, such as `http://127.0.0.1:4318`;
    /// empty sends none
    otlp_endpoint: String = String::new(), "TRUNNION_OTLP_ENDPOINT";
}

/// The pauses of the example in Standard Webhooks: about three days in total.
const WEBHOOK_PAUSES_S: [f64; 9] =
    [5.0, 300.0, 1800.0, 7200.0, 18_000.0, 36_000.0, 50_400.0, 72_000.0, 86_400.0];
/// Most attempts for one webhook.
const MAX_WEBHOOK_PAUSES: f64 = 100.0;

/// Levels of the log.
const LOG_LEVELS: [&str; 6] = ["off", "error", "warn", "info", "debug", "trace"];

/// Whether a directive is a level, or a target with a level: any other word would be a target that does not
/// exist.
fn is_log_directive(directive: &str) -> bool {
    let is_level = |word: &str| LOG_LEVELS.iter().any(|level| word.eq_ignore_ascii_case(level));
    // The path of a module; the targets of this service and its libraries are such paths.
    let is_target = |word: &str| {
        word.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
            && word.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_:-.".contains(&byte))
    };
    match directive.split_once('=') {
        Some((target, level)) => is_target(target) && is_level(level),
        None => is_level(directive),
    }
}

/// Form of the log lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum LogFormat {
    /// One readable line per event.
    Text,
    /// One JSON object per event.
    Json,
}

/// Where a setting's value comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// No other source gives a value.
    Default,
    /// The settings file.
    File {
        /// Its path.
        path: PathBuf,
    },
    /// The command line, or the environment if the command line does not give it.
    FlagOrEnvironment {
        /// Name of the environment variable.
        variable: &'static str,
    },
}

/// Why the settings cannot be used.
#[derive(Debug, Error)]
pub enum ConfigFault {
    /// A file that cannot be read.
    #[error("the settings file {path} cannot be read: {source}")]
    Unreadable {
        /// The given path.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file that is not TOML, an unknown name or a value of the wrong type.
    #[error("line {line} of the settings file {path}: {what}")]
    NotSettings {
        /// The given path.
        path: PathBuf,
        /// The line.
        line: usize,
        /// What is wrong, without the text of the line: it may have a password.
        what: String,
    },
    /// The named settings file does not exist.
    #[error("there is no settings file {path}")]
    NoFile {
        /// The given path.
        path: PathBuf,
    },
    /// A variable whose name is nearly that of a setting.
    #[error("the environment variable {given} is no setting; did you mean {known}? Rename or unset it")]
    Mistyped {
        /// Name of the variable.
        given: String,
        /// Name of the setting's variable.
        known: String,
    },
    /// A certificate without its key, or a key without its certificate.
    #[error("TLS needs both tls_certificate and tls_key, but {missing} is missing")]
    HalfTls {
        /// Name of the setting that is missing.
        missing: &'static str,
    },
    /// Files in a database that is no server.
    #[error(
        "files = {files} needs a database on a server, but database is not set: set database, or leave files out"
    )]
    FilesWithoutDatabase {
        /// The setting.
        files: FilesIn,
    },
    /// The setting `files_endpoint` is no address.
    #[error("files_endpoint cannot be used: {why}")]
    Endpoint {
        /// What is wrong, without a word of the address.
        why: &'static str,
    },
    /// The setting `database` is not a valid address.
    #[error("database cannot be used: {why}")]
    Database {
        /// What is wrong, without a word of the address.
        why: &'static str,
    },
    /// A log filter that would log nothing.
    #[error(
        "log is {value:?}, but must be directives separated by commas: a level (off, error, warn, info, debug, trace), \
         or target=level"
    )]
    Log {
        /// The given value.
        value: String,
    },
    /// A number outside its range.
    #[error("{setting} is {value}, but must be between {min} and {max}")]
    OutOfRange {
        /// Name of the setting.
        setting: &'static str,
        /// The given value.
        value: f64,
        /// Smallest accepted value.
        min: f64,
        /// Largest accepted value.
        max: f64,
    },
}

/// Reads a settings file.
fn read_file<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, ConfigFault> {
    if !path.is_file() {
        return Err(ConfigFault::NoFile { path: path.to_owned() });
    }
    let text = std::fs::read_to_string(path)
        .map_err(|source| ConfigFault::Unreadable { path: path.to_owned(), source })?;
    toml::from_str(&text).map_err(|fault| {
        let before = fault.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        ConfigFault::NotSettings { path: path.to_owned(), line, what: fault.message().to_owned() }
    })
}

impl Settings {
    /// Joins the settings: flags and environment override the optional TOML `file`, which overrides the
    /// defaults.
    ///
    /// # Errors
    /// The file is missing or does not parse, it contains an unknown name, or a value is out of its range.
    pub fn load(flags: &Flags, file: Option<&PathBuf>) -> Result<Self, ConfigFault> {
        let of_file = match file {
            Some(path) => read_file(path)?,
            None => Self::default(),
        };
        let settings = flags.over(of_file);
        settings.check()?;
        Ok(settings)
    }

    /// Every setting with its value and its origin, in the order of the names.
    ///
    /// # Errors
    /// The same as [`Self::load`].
    pub fn with_origins(
        flags: &Flags,
        file: Option<&PathBuf>,
    ) -> Result<Vec<(&'static str, serde_json::Value, Origin)>, ConfigFault> {
        let settings = Self::load(flags, file)?;
        let in_file: toml::Table = file.map(|path| read_file(path)).transpose()?.unwrap_or_default();
        // Numbers and words can always be printed.
        let mut values = serde_json::to_value(&settings).unwrap_or_default();
        if let (Some(address), Some(members)) = (&settings.database, values.as_object_mut()) {
            members.insert("database".to_owned(), address.to_string().into());
        }
        let with_origin = |(name, variable): &(&'static str, &'static str)| {
            let origin = match file {
                _ if flags.give(name) => Origin::FlagOrEnvironment { variable },
                Some(path) if in_file.contains_key(*name) => Origin::File { path: path.clone() },
                _ => Origin::Default,
            };
            (*name, values.get(name).cloned().unwrap_or_default(), origin)
        };
        Ok(ENVIRONMENT.iter().map(with_origin).collect())
    }

    /// The number of computations that run at the same time.
    #[must_use]
    pub fn computations(&self) -> usize {
        match self.max_computations {
            0 => std::thread::available_parallelism().map_or(2, std::num::NonZero::get),
            given => given,
        }
    }

    fn check(&self) -> Result<(), ConfigFault> {
        let in_range = |setting, value: f64, min: f64, max: f64| {
            if (min..=max).contains(&value) {
                Ok(())
            } else {
                Err(ConfigFault::OutOfRange { setting, value, min, max })
            }
        };
        match (&self.tls_certificate, &self.tls_key) {
            (Some(_), None) => return Err(ConfigFault::HalfTls { missing: "tls_key" }),
            (None, Some(_)) => return Err(ConfigFault::HalfTls { missing: "tls_certificate" }),
            _ => {}
        }
        if let Some(why) = self.database.as_ref().and_then(DatabaseAddress::fault) {
            return Err(ConfigFault::Database { why });
        }
        if self.files.is_shared() && self.database.is_none() {
            return Err(ConfigFault::FilesWithoutDatabase { files: self.files.clone() });
        }
        if let Some(why) = self.files_endpoint.as_deref().and_then(files_in::endpoint_fault) {
            return Err(ConfigFault::Endpoint { why });
        }
        // A lenient reader takes a meaningless directive for a target that does not exist, and the log stays
        // empty.
        if !self.log.split(',').all(is_log_directive) {
            return Err(ConfigFault::Log { value: self.log.clone() });
        }
        in_range("max_body_bytes", self.max_body_bytes as f64, 1.0, 1e12)?;
        in_range("max_surface_bytes", self.max_surface_bytes as f64, 1.0, 1e12)?;
        in_range("max_surface_memory_bytes", self.max_surface_memory_bytes as f64, 1.0, 1e12)?;
        in_range("max_memory_bytes", self.max_memory_bytes as f64, 134_217_728.0, 1e13)?;
        in_range("max_json_bytes", self.max_json_bytes as f64, 1.0, 1e9)?;
        in_range("max_parameters_bytes", self.max_parameters_bytes as f64, 1.0, 1e9)?;
        in_range("max_poses", self.max_poses as f64, 1.0, 1e8)?;
        in_range("max_cost_s", self.max_cost_s, 1e-6, 1e6)?;
        in_range("max_computations", self.max_computations as f64, 0.0, 1024.0)?;
        in_range("max_waiting_computations", self.max_waiting_computations as f64, 0.0, 1e6)?;
        in_range("max_queued_jobs", self.max_queued_jobs as f64, 0.0, 100_000.0)?;
        in_range("max_tools_per_machine", f64::from(self.max_tools_per_machine), 0.0, 100_000.0)?;
        in_range("max_event_streams", self.max_event_streams as f64, 0.0, 1e6)?;
        in_range("job_retention_s", self.job_retention_s, 0.0, 1e10)?;
        in_range("webhook_timeout_s", self.webhook_timeout_s, 0.001, 3600.0)?;
        in_range("webhook_pauses_s", self.webhook_pauses_s.len() as f64, 0.0, MAX_WEBHOOK_PAUSES)?;
        for pause_s in &self.webhook_pauses_s {
            in_range("webhook_pauses_s", *pause_s, 0.0, 1e7)?;
        }
        in_range("max_deliveries", self.max_deliveries as f64, 1.0, 1000.0)?;
        in_range("max_deliveries_per_receiver", self.max_deliveries_per_receiver as f64, 1.0, 1000.0)?;
        in_range("max_connections", self.max_connections as f64, 1.0, 1e6)?;
        in_range("max_spool_bytes", self.max_spool_bytes as f64, 1.0, 1e15)?;
        in_range("max_share_per_caller", self.max_share_per_caller, 0.01, 1.0)?;
        in_range("max_result_bytes", self.max_result_bytes as f64, 1.0, 1e13)?;
        in_range("max_url_bytes", self.max_url_bytes as f64, 64.0, 65_000.0)?;
        in_range("max_header_bytes", self.max_header_bytes as f64, 1024.0, 1e6)?;
        in_range("max_rate_per_s", self.max_rate_per_s, 0.0, 1e9)?;
        in_range("max_burst_requests", f64::from(self.max_burst_requests), 1.0, 1e9)?;
        in_range("request_timeout_s", self.request_timeout_s, 0.001, 86_400.0)?;
        in_range("header_timeout_s", self.header_timeout_s, 0.001, 3600.0)?;
        in_range("body_pause_timeout_s", self.body_pause_timeout_s, 0.001, 3600.0)?;
        in_range("answer_pause_timeout_s", self.answer_pause_timeout_s, 0.001, 3600.0)?;
        in_range("drain_timeout_s", self.drain_timeout_s, 0.0, 3600.0)?;
        in_range("idempotency_retention_s", self.idempotency_retention_s, 1.0, 1e9)?;
        in_range("scrub_interval_s", self.scrub_interval_s, 0.0, 1e9)?;
        in_range("scrub_bytes_per_s", self.scrub_bytes_per_s as f64, 1024.0, 1e12)?;
        in_range("store_readers", f64::from(self.store_readers), 1.0, 256.0)
    }
}
