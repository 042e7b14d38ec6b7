//! Merges the routes of the resources.

use super::described::Routes;
use super::{
    audit, calibrations, jobs, keys, kinematics, machines, programs, service, servo, tools, wear, webhooks,
};

/// Every described route.
pub(super) fn routes() -> Routes {
    Routes::default()
        .merge(machines::routes())
        .merge(tools::routes())
        .merge(kinematics::routes())
        .merge(programs::routes())
        .merge(servo::routes())
        .merge(wear::routes())
        .merge(calibrations::routes())
        .merge(jobs::routes())
        .merge(webhooks::routes())
        .merge(keys::routes())
        .merge(audit::routes())
        .merge(service::routes())
}
