//! What is told of a job's end, how it went to tell it, and the secret that signs it.

use std::fmt;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::JobDocument;

/// The event that tells a job's end, as it is sent: `type`, `timestamp` and, as `data`, the job without its progress.
///
/// # Errors
/// None that is known: a job always prints.
pub fn job_event(job: &JobDocument) -> Result<Vec<u8>, serde_json::Error> {
    #[derive(Serialize)]
    struct Event<'a> {
        r#type: String,
        timestamp: &'a str,
        data: serde_json::Value,
    }
    let mut data = serde_json::to_value(job)?;
    if let Some(members) = data.as_object_mut() {
        members.remove("progress");
    }
    let timestamp = job.finished_at.as_deref().unwrap_or(&job.created_at);
    serde_json::to_vec(&Event { r#type: event_type(job), timestamp, data })
}

/// The word for what happened to a job, such as `job.succeeded`.
#[must_use]
pub fn event_type(job: &JobDocument) -> String {
    format!("job.{}", job.state.as_str())
}

/// The id under which a job's end is told, however often: a job ends once.
#[must_use]
pub fn webhook_id(job_id: &str) -> String {
    format!("msg_{job_id}")
}

/// Where the delivery of an end stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DeliveryState {
    /// There will be another attempt.
    Waiting,
    /// The receiver has taken it.
    Delivered,
    /// Every attempt failed, or the receiver wants no more of them.
    GivenUp,
}

/// Declares the outcomes with their words.
macro_rules! outcomes {
    ($($name:ident = $word:literal, $doc:literal;)+) => {
        /// What came of an attempt.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "kebab-case")]
        pub enum DeliveryOutcome {
            $(#[doc = $doc] $name,)+
        }

        impl DeliveryOutcome {
            /// Every outcome.
            pub const ALL: [Self; 7] = [$(Self::$name,)+];

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

outcomes! {
    Delivered = "delivered", "The receiver answered 2xx.";
    Refused = "refused", "The receiver answered another status; redirections are not followed.";
    Gone = "gone", "The receiver answered 410: it wants no more of this, and there is no other attempt.";
    TimedOut = "timed-out", "The receiver did not answer in time.";
    Unreachable = "unreachable", "There is no such name, no connection, or it broke off.";
    AddressRefused = "address-refused", "The address is not one that may be called.";
    TlsFailed = "tls-failed", "The receiver's certificate is not trusted, or it does not speak TLS.";
}

/// One attempt to tell a job's end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct DeliveryAttempt {
    /// When it began.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub started_at: String,
    /// How long it took (ms); null where the receiver did not answer and the key lacks the scope `admin`.
    #[schema(example = 42, minimum = 0)]
    pub duration_ms: Option<i64>,
    /// What the receiver answered; null where it did not.
    #[schema(example = 503)]
    pub status: Option<u16>,
    /// What came of it. Without the scope `admin` every attempt that met no answer is `unreachable`.
    pub outcome: DeliveryOutcome,
    /// The same in words.
    #[schema(example = "the receiver answered 503")]
    pub detail: String,
}

/// What is said of every attempt without an answer to whom its cause is not told.
const NO_ANSWER: &str = "no answer; the service's log and keys with the scope `admin` tell why";

impl DeliveryOutcome {
    /// The same for whom the network of the service is no concern: an answer as it was, and without one `unreachable`.
    #[must_use]
    pub const fn without_cause(self) -> Self {
        match self {
            Self::Delivered | Self::Refused | Self::Gone => self,
            Self::TimedOut | Self::Unreachable | Self::AddressRefused | Self::TlsFailed => Self::Unreachable,
        }
    }
}

impl DeliveryAttempt {
    /// The attempt as it is shown to whom the network of the service is no concern: an answer as it was, and where there was
    /// none, nothing of the cause. Whether a name is known, an address refused, a port open or a certificate trusted would tell
    /// what stands in that network.
    #[must_use]
    pub fn without_cause(self) -> Self {
        match self.outcome.without_cause() {
            DeliveryOutcome::Unreachable => Self {
                started_at: self.started_at,
                duration_ms: None,
                status: None,
                outcome: DeliveryOutcome::Unreachable,
                detail: NO_ANSWER.to_owned(),
            },
            _answered => self,
        }
    }
}

/// How the delivery of a job's end goes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = Delivery)]
pub struct DeliveryDocument {
    /// The header `webhook-id` of every attempt.
    #[schema(example = "msg_0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub webhook_id: String,
    /// What is told: `job.succeeded`, `job.failed` or `job.cancelled`.
    #[schema(example = "job.succeeded")]
    pub event: String,
    /// Where it stands.
    pub state: DeliveryState,
    /// Attempts made since it was last asked for.
    #[schema(example = 1, minimum = 0)]
    pub attempts: i64,
    /// When the next attempt is made; null where there is none.
    #[schema(example = "2026-03-14T09:26:58.701Z")]
    pub next_attempt_at: Option<String>,
}

/// The delivery of a job's end, with a page of the attempts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Deliveries {
    /// How it goes; null where the job was posted without `callback_url` or has not ended.
    pub delivery: Option<DeliveryDocument>,
    /// The attempts, newest first; of earlier rounds too.
    pub items: Vec<DeliveryAttempt>,
    /// For the next page; null at the end.
    pub next_cursor: Option<String>,
}

/// A secret that signs. It is shown to whoever may see it and never printed otherwise.
#[derive(Clone, PartialEq, Eq, Serialize)]
pub struct WebhookSecret(pub String);

impl fmt::Debug for WebhookSecret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("WebhookSecret(hidden)")
    }
}

/// What deliveries are signed with.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = WebhookSecrets)]
pub struct WebhookSecretDocument {
    /// The secret, as libraries for Standard Webhooks take it.
    #[schema(value_type = String, example = "whsec_C2FVsBQIhrscChlQIMV+b5sSYspob7oDAAAAAAAAAAA=")]
    pub secret: WebhookSecret,
    /// When it was made.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub created_at: String,
    /// Secrets before it that still sign beside it, newest first.
    pub previous: Vec<PreviousSecret>,
}

/// A secret that signs beside the newest for a while.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct PreviousSecret {
    /// When it was made.
    #[schema(example = "2026-01-02T08:00:00.000Z")]
    pub created_at: String,
    /// Until when it signs.
    #[schema(example = "2026-03-15T09:26:53.589Z")]
    pub signs_until: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_outcome_has_its_word() {
        for outcome in DeliveryOutcome::ALL {
            assert_eq!(serde_json::to_value(outcome).unwrap(), outcome.as_str());
        }
    }

    #[test]
    fn attempts_without_an_answer_look_alike() {
        let attempt = |outcome: DeliveryOutcome| DeliveryAttempt {
            started_at: "2026-03-14T09:26:53.589Z".to_owned(),
            duration_ms: Some(outcome as i64),
            status: None,
            outcome,
            detail: format!("{outcome:?}"),
        };
        let mut shown: Vec<_> =
            DeliveryOutcome::ALL.map(|outcome| attempt(outcome).without_cause()).into_iter().collect();
        let alike = shown.split_off(3);
        assert!(alike.iter().all(|one| *one == alike[0] && one.outcome == DeliveryOutcome::Unreachable));
        let answered = [DeliveryOutcome::Delivered, DeliveryOutcome::Refused, DeliveryOutcome::Gone];
        assert_eq!(shown, answered.map(attempt));
    }

    #[test]
    fn a_secret_is_not_printed() {
        let secret = WebhookSecret("whsec_abc".to_owned());
        assert!(!format!("{secret:?}").contains("abc"));
    }
}
