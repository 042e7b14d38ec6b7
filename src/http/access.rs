//! The scope that each operation needs. An operation that is not named here needs `admin`: a new operation is closed
//! until its scope is stated here.

use crate::wire::Scope;

/// The scope that an operation needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Need {
    /// No scope: it is open, with or without keys.
    Nothing,
    /// A key with this scope.
    Scope(Scope),
}

/// The need of the operation with this method and this path template.
pub(super) fn needed(method: &str, route: &str) -> Need {
    Need::Scope(match (method, route) {
        // Methods that these routes do not have get 405 for every caller.
        (_, open) if is_open(open) => return Need::Nothing,

        (_, "/v1/keys" | "/v1/keys/{id}" | "/v1/audit" | "/v1/webhooks/secret") => Scope::Admin,
        ("GET" | "HEAD", _) => Scope::Read,

        ("PUT" | "DELETE", "/v1/machines/{machine_id}" | "/v1/machines/{machine_id}/tools/{tool_id}") => {
            Scope::Machines
        }

        (
            "POST",
            "/v1/machines/{machine_id}/calibrations"
            | "/v1/machines/{machine_id}/calibrations/{id}/apply"
            | "/v1/machines/{machine_id}/tools/{tool_id}/wear-entries"
            | "/v1/machines/{machine_id}/tools/{tool_id}/wear-entries/{id}/withdraw",
        ) => Scope::Calibrations,

        (
            "POST",
            "/v1/machines/{machine_id}/forward-kinematics"
            | "/v1/machines/{machine_id}/inverse-kinematics"
            | "/v1/machines/{machine_id}/cc-compensation"
            | "/v1/machines/{machine_id}/wear-compensation"
            | "/v1/machines/{machine_id}/compensation"
            | "/v1/machines/{machine_id}/verification"
            | "/v1/machines/{machine_id}/servo-simulation"
            | "/v1/machines/{machine_id}/interpretation"
            | "/v1/machines/{machine_id}/posting"
            | "/v1/servo-simulations"
            | "/v1/servo-sweeps"
            | "/v1/servo-matching"
            | "/v1/scallop-height"
            | "/v1/wear-advice"
            | "/v1/jobs"
            | "/v1/job-batches"
            | "/v1/jobs/{id}/deliveries",
        )
        | ("DELETE", "/v1/jobs/{id}") => Scope::Compute,

        _ => Scope::Admin,
    })
}

/// Requests that a monitor, a container and a person without a key must be able to make.
fn is_open(route: &str) -> bool {
    const OPEN: &[&str] = &[
        "/",
        "/page/{name}",
        "/healthz",
        "/readyz",
        "/v1/version",
        "/openapi.json",
        "/problems",
        "/problems/{code}",
        "/docs",
    ];
    OPEN.contains(&route) || route.starts_with("/docs/")
}
