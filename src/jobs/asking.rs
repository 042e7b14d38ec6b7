//! The caller of the present work. It is known from the request to everything that is done for it, without a
//! parameter in every function in between.

use tokio::task::futures::TaskLocalFuture;

use crate::shares::Who;

tokio::task_local! {
    static ASKER: Who;
}

/// Does work for a caller.
pub fn asked_by<F: Future>(who: Who, work: F) -> TaskLocalFuture<Who, F> {
    ASKER.scope(who, work)
}

/// The caller of this task. Tasks without a caller are the service's own.
#[must_use]
pub fn asker() -> Who {
    ASKER.try_with(Clone::clone).unwrap_or(Who::Service)
}
