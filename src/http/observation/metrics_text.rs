//! All counts in the text format that Prometheus reads.

use std::fmt::Write;

use super::operations::{Operations, STATUSES};
use crate::http::security_log::SecurityLog;
use crate::jobs::{CalibrationReading, DeliveriesReading, QueueReading};
use crate::meter::{self, CLASSES_S, Counter, Times};
use crate::store::{DiskSpace, SoundnessReading};
use crate::wire::{DeliveryOutcome, JobState};

/// Values that are read from other parts at the time of the request.
#[derive(Debug, Clone, Default)]
pub(in crate::http) struct Readings {
    /// Requests whose client left before the answer.
    pub(in crate::http) abandoned: u64,
    /// Memory of the process, if the system reports it \[bytes\].
    pub(in crate::http) resident_bytes: Option<u64>,
    /// Time since the service started \[s\].
    pub(in crate::http) uptime_s: f64,
    /// Posted jobs that wait and run, if the store answers.
    pub(in crate::http) queue: Option<QueueReading>,
    /// Space for stored data, if the file system answers.
    pub(in crate::http) disk: Option<DiskSpace>,
    /// Webhooks that wait, if the store answers.
    pub(in crate::http) deliveries: Option<DeliveriesReading>,
    /// How old calibrations are, if the store answers.
    pub(in crate::http) calibrations: Option<Calibrations>,
    /// Known damage of stored data.
    pub(in crate::http) soundness: SoundnessReading,
}

/// How old the calibrations of the machines are that the caller reaches.
#[derive(Debug, Clone, Default)]
pub(in crate::http) struct Calibrations {
    /// The machines.
    pub(in crate::http) machines: Vec<CalibrationReading>,
    /// Whether there are more machines than are measured.
    pub(in crate::http) is_cut: bool,
}

/// The whole text. Series that never counted anything are left out.
pub(in crate::http) fn metrics_text(
    operations: &Operations,
    readings: &Readings,
    security: &SecurityLog,
) -> String {
    let mut text = Text(String::with_capacity(16 << 10));
    let build = format!("trunnion_build_info{{version=\"{}\"}}", env!("CARGO_PKG_VERSION"));
    text.family("trunnion_build_info", "gauge", "The running version.");
    text.sample(&build, 1);
    text.single("trunnion_uptime_seconds", "gauge", "Time since the service started.", readings.uptime_s);
    if let Some(bytes) = readings.resident_bytes {
        text.single("process_resident_memory_bytes", "gauge", "Memory of the process.", bytes);
    }
    if let Some(QueueReading { queued, running, oldest_s }) = readings.queue {
        text.single("trunnion_jobs_queued", "gauge", "Posted jobs that are waiting.", queued);
        text.single("trunnion_jobs_running", "gauge", "Posted jobs that are being computed.", running);
        let help = "Time since when the oldest waiting job has been waiting.";
        text.single("trunnion_jobs_oldest_queued_seconds", "gauge", help, oldest_s);
    }
    jobs_and_disk(&mut text, readings);
    if let Some(DeliveriesReading { waiting, oldest_s }) = readings.deliveries {
        text.single("trunnion_webhooks_waiting", "gauge", "Webhooks that are waiting for delivery.", waiting);
        let help = "Time since when the oldest waiting webhook has been waiting.";
        text.single("trunnion_webhooks_oldest_waiting_seconds", "gauge", help, oldest_s);
    }
    let attempts = "trunnion_webhook_attempts_total";
    text.family(attempts, "counter", "Attempts to deliver webhooks.");
    let shown = |(outcome, _): &(&DeliveryOutcome, _)| outcome.without_cause() == **outcome;
    for (outcome, count) in DeliveryOutcome::ALL.iter().zip(&meter::WEBHOOK_ATTEMPTS).filter(shown) {
        text.sample(&format!("{attempts}{{outcome=\"{}\"}}", outcome.as_str()), count.get());
    }
    requests(&mut text, operations);
    refusals(&mut text, security);
    soundness(&mut text, &readings.soundness);
    if let Some(read) = &readings.calibrations {
        calibrations(&mut text, read);
    }
    for (name, kind, help, value) in [
        (
            "trunnion_http_requests_in_flight",
            "gauge",
            "Requests whose answer has not begun.",
            meter::IN_FLIGHT.get(),
        ),
        (
            "trunnion_http_requests_abandoned_total",
            "counter",
            "Requests whose client left before the answer.",
            signed(readings.abandoned),
        ),
        ("trunnion_connections", "gauge", "Open connections.", meter::CONNECTIONS.get()),
        (
            "trunnion_received_bytes_total",
            "counter",
            "Bytes received over the network.",
            signed(meter::BYTES_IN.get()),
        ),
        (
            "trunnion_sent_bytes_total",
            "counter",
            "Bytes sent over the network.",
            signed(meter::BYTES_OUT.get()),
        ),
        ("trunnion_computations_running", "gauge", "Computations that are running.", meter::COMPUTING.get()),
        (
            "trunnion_computations_waiting",
            "gauge",
            "Computations that are waiting for their turn.",
            meter::WAITING.get(),
        ),
        (
            "trunnion_damaged_reads_total",
            "counter",
            "Reads of stored data that was found damaged.",
            signed(meter::DAMAGED_FILES_MET.get()),
        ),
        (
            "trunnion_poses_total",
            "counter",
            "Poses turned into axis words and back.",
            signed(meter::POSES.get()),
        ),
        (
            "trunnion_program_blocks_total",
            "counter",
            "Program blocks that were processed.",
            signed(meter::PROGRAM_BLOCKS.get()),
        ),
    ] {
        text.single(name, kind, help, value);
    }
    for (name, help, times) in [
        ("trunnion_store_read_duration_seconds", "Reads of the database.", &meter::STORE_READS),
        (
            "trunnion_store_write_duration_seconds",
            "Write transactions of the database, including the time they waited.",
            &meter::STORE_WRITES,
        ),
    ] {
        text.family(name, "histogram", help);
        text.histogram(name, "", times);
    }
    text.0
}

/// How jobs ended, and the space for what they store.
fn jobs_and_disk(text: &mut Text, readings: &Readings) {
    let ends = "trunnion_jobs_ended_total";
    text.family(ends, "counter", "Posted jobs that ended.");
    for (state, count) in JobState::ENDS.iter().zip(&meter::JOBS_ENDED) {
        text.sample(&format!("{ends}{{state=\"{}\"}}", state.as_str()), count.get());
    }
    if let Some(DiskSpace { size_bytes, free_bytes }) = readings.disk {
        let help = "Size of the file system of the data directory.";
        text.single("trunnion_data_size_bytes", "gauge", help, size_bytes);
        let help = "Free space on the file system of the data directory.";
        text.single("trunnion_data_free_bytes", "gauge", help, free_bytes);
    }
}

/// Requests that were not admitted.
fn refusals(text: &mut Text, security: &SecurityLog) {
    let (refusals, unwritten) = security.counts();
    let refused = "trunnion_refusals_total";
    text.family(refused, "counter", "Requests that were not admitted.");
    for (reason, count) in refusals {
        text.sample(&format!("{refused}{{reason=\"{}\"}}", reason.as_str()), count);
    }
    let help = "Refusals that are missing from the security log.";
    text.single("trunnion_refusals_unwritten_total", "counter", help, unwritten);
}

/// Known damage.
fn soundness(text: &mut Text, soundness: &SoundnessReading) {
    let help = "Stored files and reports that are known to be damaged.";
    text.single("trunnion_stored_files_damaged", "gauge", help, soundness.damaged);
    let help = "Findings of the last scrub in the database.";
    text.single("trunnion_scrub_findings", "gauge", help, soundness.findings);
    if let Some(at_s) = soundness.scrubbed_at_s {
        let help = "Time when all stored data was last read completely.";
        text.single("trunnion_scrub_last_timestamp_seconds", "gauge", help, at_s);
    }
}

/// Ages of calibrations, by machine.
fn calibrations(text: &mut Text, read: &Calibrations) {
    let mut family = |name: &str, help: &str, value: &dyn Fn(&CalibrationReading) -> Option<String>| {
        text.family(name, "gauge", help);
        for machine in &read.machines {
            if let Some(value) = value(machine) {
                text.sample(&format!("{name}{{machine_id=\"{}\"}}", machine.machine_id), value);
            }
        }
    };
    let days = |days: f64| format!("{days:.4}");
    let help = "Time since the newest measurement of a calibration run.";
    family("trunnion_calibration_age_days", help, &|machine| machine.age_days.map(days));
    let help = "Time until the next calibration is due; negative if it is overdue.";
    family("trunnion_calibration_due_in_days", help, &|machine| machine.due_in_days.map(days));
    let help = "1 for a machine that states a period of calibrations and was never calibrated.";
    family("trunnion_calibration_missing", help, &|machine| machine.is_missing.then(|| "1".to_owned()));
    let help = "1 if there are more machines than these series cover.";
    text.single("trunnion_calibration_machines_cut", "gauge", help, u8::from(read.is_cut));
}

fn requests(text: &mut Text, operations: &Operations) {
    let total = "trunnion_http_requests_total";
    text.family(total, "counter", "Requests that were answered.");
    for series in operations.iter() {
        let (operation, method) = (&series.operation, series.method);
        let statuses = STATUSES.iter().map(ToString::to_string).chain(["other".to_owned()]);
        for (status, count) in
            statuses.zip(series.answered.iter().map(Counter::get)).filter(|(_, count)| *count > 0)
        {
            let name =
                format!("{total}{{operation=\"{operation}\",method=\"{method}\",status=\"{status}\"}}");
            text.sample(&name, count);
        }
    }
    let duration = "trunnion_http_request_duration_seconds";
    text.family(duration, "histogram", "Time from the header of a request to the header of its answer.");
    for series in operations.iter() {
        let labels = format!("operation=\"{}\",method=\"{}\"", series.operation, series.method);
        text.histogram(duration, &labels, &series.times);
    }
}

fn signed(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

struct Text(String);

impl Text {
    fn family(&mut self, name: &str, kind: &str, help: &str) {
        // Writing into a string cannot fail.
        let _written = writeln!(self.0, "# HELP {name} {help}\n# TYPE {name} {kind}");
    }

    fn sample(&mut self, name: &str, value: impl std::fmt::Display) {
        let _written = writeln!(self.0, "{name} {value}");
    }

    fn single(&mut self, name: &str, kind: &str, help: &str, value: impl std::fmt::Display) {
        self.family(name, kind, help);
        self.sample(name, value);
    }

    fn histogram(&mut self, name: &str, labels: &str, times: &Times) {
        let (counts, sum_s) = times.read();
        let total: u64 = counts.iter().sum();
        if total == 0 {
            return;
        }
        let comma = if labels.is_empty() { "" } else { "," };
        let mut so_far = 0;
        for (end_s, count) in CLASSES_S.iter().zip(counts) {
            so_far += count;
            let _written = writeln!(self.0, "{name}_bucket{{{labels}{comma}le=\"{end_s}\"}} {so_far}");
        }
        let _written = writeln!(self.0, "{name}_bucket{{{labels}{comma}le=\"+Inf\"}} {total}");
        let braced = if labels.is_empty() { String::new() } else { format!("{{{labels}}}") };
        let _written = writeln!(self.0, "{name}_sum{braced} {sum_s}\n{name}_count{braced} {total}");
    }
}
