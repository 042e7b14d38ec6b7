//! How many jobs wait and run.

use super::error::Doing;
use super::{QueueRoom, Store, StoreError};
use crate::shares::NoShare;

row! {
    /// The number of waiting and running jobs.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct QueueDepth {
        /// Jobs that are waiting.
        pub queued: i64,
        /// Jobs that run.
        pub running: i64,
        /// Time since when the oldest waiting job has been waiting.
        pub oldest: Option<String>,
    }
}

row! {
    /// Waiting jobs, and those of one caller among them.
    pub(super) struct Waiting {
        pub(super) all: i64,
        pub(super) own: i64,
    }
}

impl Store {
    /// Whether one more job of a caller may wait.
    ///
    /// # Errors
    /// The database failed; the inner error says that it may not.
    pub async fn queue_room(&self, room: &QueueRoom, more: usize) -> Result<Result<(), NoShare>, StoreError> {
        let caller = room.caller.to_string();
        let waiting = sql!(
            self.db,
            one(Waiting),
            "SELECT count(*) AS \"all!\", count(*) FILTER (WHERE caller = $1) AS \"own!\"
             FROM jobs WHERE state = 'queued'",
            caller
        )
        .doing("measuring the queue")?;
        Ok(room.check(waiting.all, waiting.own, more))
    }

    /// The number of waiting and running jobs.
    ///
    /// # Errors
    /// The database failed.
    pub async fn queue_depth(&self) -> Result<QueueDepth, StoreError> {
        let row = sql!(
            self.db,
            one(QueueDepth),
            "SELECT (SELECT count(*) FROM jobs WHERE state = 'queued') AS \"queued!\",
                 (SELECT count(*) FROM jobs WHERE state = 'running') AS \"running!\",
                 (SELECT created_at FROM jobs WHERE state = 'queued' ORDER BY seq LIMIT 1) AS \"oldest\""
        )
        .doing("measuring the queue")?;
        Ok(QueueDepth { queued: row.queued, running: row.running, oldest: row.oldest })
    }
}
