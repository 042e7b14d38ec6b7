//! Signatures of Standard Webhooks 1.0.0: HMAC-SHA256 of `id.timestamp.body`.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ring::hmac;

use crate::store::WebhookSecretRow;
use crate::wire::WebhookSecret;

/// The prefix of every secret.
const PREFIX: &str = "whsec_";
/// How long a secret signs together with the next one \[s\].
pub const SECRET_OVERLAP_S: f64 = 86_400.0;
/// Random bytes of a secret; the standard asks for 24 to 64.
const SECRET_BYTES: usize = 32;
/// Most secrets that sign one request: the length of a header is limited.
const MOST_SIGNATURES: usize = 4;

/// A new random secret.
///
/// # Errors
/// The system provides no random numbers.
pub fn new_webhook_secret() -> Result<WebhookSecret, getrandom::Error> {
    let mut bytes = [0; SECRET_BYTES];
    getrandom::fill(&mut bytes)?;
    Ok(WebhookSecret(format!("{PREFIX}{}", STANDARD.encode(bytes))))
}

/// The secrets, newest first, that sign at this time.
pub fn signing_now<'a>(
    secrets: &'a [WebhookSecretRow],
    now: &'a str,
) -> impl Iterator<Item = &'a WebhookSecretRow> {
    let valid = secrets.iter().filter(move |row| row.signs_until.as_deref().is_none_or(|until| now < until));
    valid.take(MOST_SIGNATURES)
}

/// The header `webhook-signature`: one signature for each secret that signs at `now`, newest first; `None` if no
/// secret signs.
pub(super) fn signatures(
    secrets: &[WebhookSecretRow],
    now: &str,
    id: &str,
    timestamp_s: i64,
    body: &[u8],
) -> Option<String> {
    let signing = signing_now(secrets, now);
    let signed: Vec<String> =
        signing.filter_map(|row| signature(&row.secret, id, timestamp_s, body)).collect();
    if signed.is_empty() { None } else { Some(signed.join(" ")) }
}

fn signature(secret: &WebhookSecret, id: &str, timestamp_s: i64, body: &[u8]) -> Option<String> {
    let key = STANDARD.decode(secret.0.strip_prefix(PREFIX)?).ok()?;
    let mut context = hmac::Context::with_key(&hmac::Key::new(hmac::HMAC_SHA256, &key));
    context.update(format!("{id}.{timestamp_s}.").as_bytes());
    context.update(body);
    Some(format!("v1,{}", STANDARD.encode(context.sign())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(secret: &str, signs_until: Option<&str>) -> WebhookSecretRow {
        WebhookSecretRow {
            secret: WebhookSecret(secret.to_owned()),
            created_at: "2026-01-01T00:00:00.000Z".to_owned(),
            signs_until: signs_until.map(str::to_owned),
        }
    }

    const NOW: &str = "2026-01-02T00:00:00.000Z";
    /// Secret, id, time, body and signature as the standard's own libraries are tested.
    const SECRET: &str = "whsec_C2FVsBQIhrscChlQIMV+b5sSYspob7oD";
    const ID: &str = "msg_27UH4WbU6Z5A5EzD8u03UvzRbpk";
    const TIME_S: i64 = 1_649_367_553;
    const BODY: &[u8] = br#"{"email":"test@example.com","username":"test_user"}"#;
    const SIGNATURE: &str = "v1,tZ1I4/hDygAJgO5TYxiSd6Sd0kDW6hPenDe+bTa3Kkw=";

    #[test]
    fn the_signature_is_the_one_that_the_standard_gives() {
        let signed = signatures(&[row(SECRET, None)], NOW, ID, TIME_S, BODY);
        assert_eq!(signed.as_deref(), Some(SIGNATURE));
    }

    #[test]
    fn secrets_sign_side_by_side_until_they_end() {
        let other = new_webhook_secret().unwrap();
        let rows = |until| [row(&other.0, None), row(SECRET, Some(until))];
        let both = signatures(&rows("2026-01-02T00:00:00.001Z"), NOW, ID, TIME_S, BODY).unwrap();
        assert_eq!(both.split(' ').count(), 2);
        assert!(both.ends_with(SIGNATURE));
        let one = signatures(&rows(NOW), NOW, ID, TIME_S, BODY).unwrap();
        assert!(!one.contains(' ') && !one.contains(SIGNATURE));
        assert_eq!(signatures(&[], NOW, ID, TIME_S, BODY), None);
    }

    #[test]
    fn no_more_secrets_are_named_than_sign() {
        let rows: Vec<WebhookSecretRow> = (0..6)
            .map(|age| {
                row(&new_webhook_secret().unwrap().0, Some("2026-01-02T00:00:00.001Z").filter(|_| age > 0))
            })
            .collect();
        assert!(signing_now(&rows, NOW).eq(&rows[..MOST_SIGNATURES]));
        assert_eq!(signatures(&rows, NOW, ID, TIME_S, BODY).unwrap().split(' ').count(), MOST_SIGNATURES);
    }

    #[test]
    fn a_secret_is_long_and_new() {
        let [one, two] = [new_webhook_secret().unwrap(), new_webhook_secret().unwrap()];
        assert_ne!(one, two);
        let key = STANDARD.decode(one.0.strip_prefix("whsec_").unwrap()).unwrap();
        assert_eq!(key.len(), SECRET_BYTES);
    }
}
