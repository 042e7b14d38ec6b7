//! Who asks for what is being done: known from the request to whatever is done for it, without being handed on by every function
//! in between.

use tokio::task::futures::TaskLocalFuture;

use crate::shares::Who;

tokio::task_local! {
    static ASKER: Who;
}

/// Does something for a caller.
pub fn asked_by<F: Future>(who: Who, work: F) -> TaskLocalFuture<Who, F> {
    ASKER.scope(who, work)
}

/// Who asks for what this task does; the service itself, where nobody does.
#[must_use]
pub fn asker() -> Who {
    ASKER.try_with(Clone::clone).unwrap_or(Who::Service)
}
