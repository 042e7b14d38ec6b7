//! Waiting, with a time limit.

use std::pin::pin;
use std::task::Poll;
use std::time::Duration;

use tokio::task::unconstrained;

/// The result of `future`, or `None` if it takes longer than `limit`. The limit begins when the future first has to wait.
/// Most requests never wait, so they need no timer.
pub(super) async fn within<F: Future>(limit: Duration, future: F) -> Option<F::Output> {
    let mut future = pin!(future);
    let mut timer = None;
    std::future::poll_fn(|context| {
        if let Poll::Ready(result) = future.as_mut().poll(context) {
            return Poll::Ready(Some(result));
        }
        // A future that uses up its task's turn at every poll must not keep the timer from ending it.
        let timer = timer.get_or_insert_with(|| Box::pin(unconstrained(tokio::time::sleep(limit))));
        timer.as_mut().poll(context).map(|()| None)
    })
    .await
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uses up its task's turn at every poll.
    async fn greedy() -> u8 {
        loop {
            tokio::task::consume_budget().await;
        }
    }

    #[tokio::test]
    async fn what_is_ready_is_taken_and_what_takes_longer_is_left() {
        let (moment, long) = (Duration::from_millis(20), Duration::from_mins(1));
        assert_eq!(within(Duration::ZERO, async { 7 }).await, Some(7));
        assert_eq!(within(long, tokio::time::sleep(moment)).await, Some(()));
        let began = std::time::Instant::now();
        assert_eq!(within(moment, std::future::pending::<()>()).await, None);
        assert!(began.elapsed() >= moment);
        assert_eq!(within(moment, greedy()).await, None);
    }
}
