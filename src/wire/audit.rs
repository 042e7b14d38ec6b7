//! The audit log as clients read it.

use serde::{Deserialize, Serialize};

use crate::description::ToSchema;

use super::table_text::table_text;

/// Declares the actions with their words.
macro_rules! actions {
    ($($name:ident = $word:literal, $doc:literal;)+) => {
        /// What was done.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "kebab-case")]
        pub enum AuditAction {
            $(#[doc = $doc] $name,)+
        }

        impl AuditAction {
            /// Every action.
            pub const ALL: &'static [Self] = &[$(Self::$name,)+];

            /// The word on the wire.
            #[must_use]
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$name => $word,)+
                }
            }
        }
    };
}

actions! {
    MachineCreated = "machine-created", "A new machine was stored.";
    MachineReplaced = "machine-replaced", "A machine got a new revision.";
    MachineDeleted = "machine-deleted", "A machine was deleted.";
    ToolCreated = "tool-created", "A new tool was stored.";
    ToolReplaced = "tool-replaced", "A tool got a new revision.";
    ToolDeleted = "tool-deleted", "A tool was deleted, alone or together with its machine.";
    CalibrationCreated = "calibration-created", "A calibration run was stored.";
    CalibrationApplied = "calibration-applied", "The errors of a calibration run were applied to the machine.";
    WearEntriesCreated = "wear-entries-created", "Measured wear was stored.";
    WearEntryWithdrawn = "wear-entry-withdrawn", "A wear entry was withdrawn.";
    JobCreated = "job-created", "A job was accepted.";
    JobCancelled = "job-cancelled", "A job was cancelled.";
    JobRemoved = "job-removed", "An old job was removed after it ended.";
    DeliveryRequested = "delivery-requested", "A client asked for one more webhook about a job's end.";
    WebhookSecretCreated = "webhook-secret-created", "The first secret that signs webhooks was created.";
    WebhookSecretRotated = "webhook-secret-rotated", "A new secret signs webhooks.";
    KeyCreated = "key-created", "An API key was created.";
    KeyRevoked = "key-revoked", "An API key was revoked.";
}

/// Where a change came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AuditOrigin {
    /// A request.
    Http,
    /// The command line.
    CommandLine,
    /// The service itself.
    Service,
}

impl AuditOrigin {
    /// The word on the wire.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Http => "http",
            Self::CommandLine => "command-line",
            Self::Service => "service",
        }
    }
}

/// One change of the stored data.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct AuditEntry {
    /// Counts up with every change; gaps mean nothing.
    #[schema(example = 42)]
    pub seq: i64,
    /// Time of the change.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub at: String,
    /// Where the change came from.
    pub origin: AuditOrigin,
    /// The key of the request; null if the service needs no keys, or if the change did not come by HTTP.
    #[schema(example = "5f1c2d4e9a07")]
    pub key_id: Option<String>,
    /// What was done.
    pub action: AuditAction,
    /// HTTP method of the request.
    #[schema(example = "PUT")]
    pub method: Option<String>,
    /// Path template of the request.
    #[schema(example = "/v1/machines/{machine_id}")]
    pub route: Option<String>,
    /// `X-Request-Id` of the answer; the log lines have it too.
    pub request_id: Option<String>,
    /// The machine that the change concerns.
    #[schema(example = "example-ac-table")]
    pub machine_id: Option<String>,
    /// Address of the changed resource.
    #[schema(example = "/v1/machines/example-ac-table")]
    pub resource: String,
    /// Revision of the machine, or of the tool that `resource` names, before the change. Null if there was no
    /// revision before, or if the changed resource has no revisions.
    #[schema(example = 3)]
    pub revision_before: Option<i64>,
    /// Revision of the machine or tool after the change.
    #[schema(example = 4)]
    pub revision_after: Option<i64>,
    /// SHA-256 of this entry and of the entry before it: the entries form a chain (`docs/security.md`).
    #[schema(example = "8f434346648f6b96df89dda901c5176b10a6d83961dd3c1ac88b59b2dc327aa4")]
    pub sha256: String,
}

/// The entries as a table, with the names of their members.
///
/// # Errors
/// The table cannot be written; this does not happen in memory.
pub fn audit_table(entries: &[AuditEntry]) -> Result<Vec<u8>, csv::Error> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record([
        "seq",
        "at",
        "origin",
        "key_id",
        "action",
        "method",
        "route",
        "request_id",
        "machine_id",
        "resource",
        "revision_before",
        "revision_after",
        "sha256",
    ])?;
    let text = |text: &Option<String>| text.as_deref().map(table_text).unwrap_or_default().into_owned();
    let number = |number: Option<i64>| number.map(|number| number.to_string()).unwrap_or_default();
    for entry in entries {
        table.write_record([
            entry.seq.to_string(),
            entry.at.clone(),
            entry.origin.as_str().to_owned(),
            text(&entry.key_id),
            entry.action.as_str().to_owned(),
            text(&entry.method),
            text(&entry.route),
            text(&entry.request_id),
            text(&entry.machine_id),
            table_text(&entry.resource).into_owned(),
            number(entry.revision_before),
            number(entry.revision_after),
            entry.sha256.clone(),
        ])?;
    }
    table.into_inner().map_err(|fault| fault.into_error().into())
}
