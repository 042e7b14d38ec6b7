//! The audit log.

mod list_audit;

use super::described::resource;

resource! {
    list_audit::list_audit_entries,
}
