//! The time of the next attempt after a failed one.

use crate::store::sha256_hex;

/// By what share a pause may become longer: receivers that failed together are not called together again.
const MOST_LONGER: f64 = 0.1;

/// The pause after this many attempts \[s\]; `None` if there is no further attempt.
pub(super) fn pause_s(pauses_s: &[f64], attempts: i64, job_id: &str) -> Option<f64> {
    let index = usize::try_from(attempts.checked_sub(1)?).ok()?;
    let pause_s = *pauses_s.get(index)?;
    Some(pause_s * (1.0 + MOST_LONGER * share(&format!("{job_id} {attempts}"))))
}

/// The longest possible pause \[s\]: a longer one was written under another clock.
pub(super) fn longest_s(pauses_s: &[f64]) -> f64 {
    pauses_s.iter().copied().fold(0.0, f64::max) * (1.0 + MOST_LONGER)
}

/// A number from 0 to 1 that depends only on the text.
fn share(text: &str) -> f64 {
    let digest = sha256_hex(text.as_bytes());
    let first = digest.get(..4).and_then(|word| u16::from_str_radix(word, 16).ok()).unwrap_or_default();
    f64::from(first) / f64::from(u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_come_in_their_order_a_little_longer_and_end() {
        let pauses = [5.0, 300.0];
        for job in ["one", "two", "three"] {
            let first = pause_s(&pauses, 1, job).unwrap();
            assert!((5.0..=5.5).contains(&first), "{first}");
            let second = pause_s(&pauses, 2, job).unwrap();
            assert!((300.0..=330.0).contains(&second) && second <= longest_s(&pauses), "{second}");
            assert_eq!(pause_s(&pauses, 3, job), None);
            assert_eq!(pause_s(&pauses, 1, job), Some(first));
        }
        assert_ne!(pause_s(&pauses, 1, "one"), pause_s(&pauses, 1, "two"));
        assert_eq!((pause_s(&[], 1, "one"), pause_s(&pauses, 0, "one")), (None, None));
        assert!(longest_s(&[]).abs() < f64::EPSILON);
    }
}
