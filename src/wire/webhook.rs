//! The webhook about a job's end: the event, its delivery, and the secret that signs it.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::JobDocument;
use crate::description::ToSchema;

/// The event about a job's end as it is sent: `type`, `timestamp` and, as `data`, the job without its
/// progress.
///
/// # Errors
/// No case is known: a job can always be printed.
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

/// The id of the message about a job's end. It is the same for every attempt, because a job ends once.
#[must_use]
pub fn webhook_id(job_id: &str) -> String {
    format!("msg_{job_id}")
}

/// State of a delivery.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DeliveryState {
    /// There will be another attempt.
    Waiting,
    /// The receiver has accepted the message.
    Delivered,
    /// Every attempt failed, or the receiver wants no more attempts.
    GivenUp,
}

/// Declares the outcomes with their words.
macro_rules! outcomes {
    ($($name:ident = $word:literal, $doc:literal;)+) => {
        /// Result of an attempt.
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
    Gone = "gone", "The receiver answered 410: it wants no more messages, and there is no further attempt.";
    TimedOut = "timed-out", "The receiver did not answer in time.";
    Unreachable = "unreachable", "The name is unknown, no connection was made, or the connection broke.";
    AddressRefused = "address-refused", "The address is not allowed.";
    TlsFailed = "tls-failed", "The receiver's certificate is not trusted, or it does not speak TLS.";
}

/// One attempt to deliver the message about a job's end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct DeliveryAttempt {
    /// Time at which the attempt began.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub started_at: String,
    /// Duration of the attempt (ms); null if the receiver did not answer and the key lacks the scope `admin`.
    #[schema(example = 42, minimum = 0)]
    pub duration_ms: Option<i64>,
    /// Status that the receiver answered; null if it did not answer.
    #[schema(example = 503)]
    pub status: Option<u16>,
    /// Result of the attempt. For a key without the scope `admin`, every attempt without an answer is
    /// `unreachable`.
    pub outcome: DeliveryOutcome,
    /// The result in words.
    #[schema(example = "the receiver answered 503")]
    pub detail: String,
}

/// The text for an attempt without an answer, if the client may not see the cause.
const NO_ANSWER: &str = "no answer; the service's log and keys with the scope `admin` show why";

impl DeliveryOutcome {
    /// The outcome for a client that may not see the cause: an answer stays as it was; without an answer it
    /// is `unreachable`.
    #[must_use]
    pub const fn without_cause(self) -> Self {
        match self {
            Self::Delivered | Self::Refused | Self::Gone => self,
            Self::TimedOut | Self::Unreachable | Self::AddressRefused | Self::TlsFailed => Self::Unreachable,
        }
    }
}

impl DeliveryAttempt {
    /// The attempt for a client that must not learn about the service's network: an answer stays as it was;
    /// without an answer, the cause is hidden. The cause (unknown name, refused address, open port, untrusted
    /// certificate) would reveal what is in that network.
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

/// State of the delivery of a job's end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = Delivery)]
pub struct DeliveryDocument {
    /// The header `webhook-id` of every attempt.
    #[schema(example = "msg_0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub webhook_id: String,
    /// The event: `job.succeeded`, `job.failed` or `job.cancelled`.
    #[schema(example = "job.succeeded")]
    pub event: String,
    /// State of the delivery.
    pub state: DeliveryState,
    /// Number of attempts since the delivery was last requested.
    #[schema(example = 1, minimum = 0)]
    pub attempts: i64,
    /// Time of the next attempt; null if there is none.
    #[schema(example = "2026-03-14T09:26:58.701Z")]
    pub next_attempt_at: Option<String>,
}

/// The delivery of a job's end, with a page of the attempts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Deliveries {
    /// State of the delivery; null if the job has no `callback_url` or has not ended.
    pub delivery: Option<DeliveryDocument>,
    /// The attempts, newest first; attempts of earlier rounds are included.
    pub items: Vec<DeliveryAttempt>,
    /// Cursor of the next page; null on the last page.
    pub next_cursor: Option<String>,
}

/// A secret that signs webhooks. It is shown only to a client that may see it, and never printed otherwise.
#[derive(Clone, PartialEq, Eq, Serialize)]
pub struct WebhookSecret(pub String);

impl fmt::Debug for WebhookSecret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("WebhookSecret(hidden)")
    }
}

/// The secret that signs deliveries.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = WebhookSecrets)]
pub struct WebhookSecretDocument {
    /// The secret, as libraries for Standard Webhooks take it.
    #[schema(value_type = String, example = "whsec_C2FVsBQIhrscChlQIMV+b5sSYspob7oDAAAAAAAAAAA=")]
    pub secret: WebhookSecret,
    /// Time at which the secret was created.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub created_at: String,
    /// Earlier secrets that still sign too, newest first.
    pub previous: Vec<PreviousSecret>,
}

/// An earlier secret that still signs for some time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct PreviousSecret {
    /// Time at which the secret was created.
    #[schema(example = "2026-01-02T08:00:00.000Z")]
    pub created_at: String,
    /// Time until which it signs.
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
