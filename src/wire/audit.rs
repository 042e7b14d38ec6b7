//! The audit log as it is read.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

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
    MachineCreated = "machine-created", "A machine was stored that was not there.";
    MachineReplaced = "machine-replaced", "A machine got a new revision.";
    MachineDeleted = "machine-deleted", "A machine was taken out of the list.";
    ToolCreated = "tool-created", "A tool was stored that was not in its machine's table.";
    ToolReplaced = "tool-replaced", "A tool got a new revision.";
    ToolDeleted = "tool-deleted", "A tool was taken out of its machine's table, or its machine was deleted.";
    CalibrationCreated = "calibration-created", "A calibration run was stored.";
    CalibrationApplied = "calibration-applied", "A run's errors became those of the machine.";
    WearEntriesCreated = "wear-entries-created", "Measured wear was stored.";
    WearEntryWithdrawn = "wear-entry-withdrawn", "A wear entry was withdrawn.";
    JobCreated = "job-created", "A job was accepted.";
    JobCancelled = "job-cancelled", "A job was cancelled.";
    JobRemoved = "job-removed", "A job that ended long ago was removed.";
    DeliveryRequested = "delivery-requested", "A job's end was to be told once more.";
    WebhookSecretCreated = "webhook-secret-created", "The first secret that signs webhooks was made.";
    WebhookSecretRotated = "webhook-secret-rotated", "A new secret signs webhooks.";
    KeyCreated = "key-created", "An API key was made.";
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

/// One change of what is stored.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct AuditEntry {
    /// Counts up with every change; gaps mean nothing.
    #[schema(example = 42)]
    pub seq: i64,
    /// When.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub at: String,
    /// Where it came from.
    pub origin: AuditOrigin,
    /// The key of the request; null where the service was open, and off HTTP.
    #[schema(example = "5f1c2d4e9a07")]
    pub key_id: Option<String>,
    /// What was done.
    pub action: AuditAction,
    /// Method of the request.
    #[schema(example = "PUT")]
    pub method: Option<String>,
    /// Path template of the request.
    #[schema(example = "/v1/machines/{machine_id}")]
    pub route: Option<String>,
    /// `X-Request-Id` of the answer, which the log lines carry too.
    pub request_id: Option<String>,
    /// The machine that it is about.
    #[schema(example = "example-ac-table")]
    pub machine_id: Option<String>,
    /// Address of what was changed.
    #[schema(example = "/v1/machines/example-ac-table")]
    pub resource: String,
    /// Revision of the machine before, or of the tool that `resource` names; null where there was none, or where the change has
    /// no revisions.
    #[schema(example = 3)]
    pub revision_before: Option<i64>,
    /// Revision of the machine, or of the tool, after.
    #[schema(example = 4)]
    pub revision_after: Option<i64>,
    /// SHA-256 of this entry and of the one before it (`docs/security.md`): the entries are a chain.
    #[schema(example = "8f434346648f6b96df89dda901c5176b10a6d83961dd3c1ac88b59b2dc327aa4")]
    pub sha256: String,
}
