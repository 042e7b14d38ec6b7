//! The audit log.

mod list_audit;

use super::described::{Described, routes};

/// The routes of this resource.
pub(super) fn router() -> Described {
    Described::default().routes(routes!(list_audit::list_audit_entries))
}
