//! Merges the routes of the resources, and the description that they make.

use serde_json::Value;
use utoipa::OpenApi;

use super::described::Described;
use super::openapi::{Base, completed, published};
use super::{
    audit, calibrations, jobs, keys, kinematics, machines, programs, service, servo, tools, wear, webhooks,
};

/// Every described route.
pub(super) fn described() -> Described {
    Described::default()
        .merge(machines::router())
        .merge(tools::router())
        .merge(kinematics::router())
        .merge(programs::router())
        .merge(servo::router())
        .merge(wear::router())
        .merge(calibrations::router())
        .merge(jobs::router())
        .merge(webhooks::router())
        .merge(keys::router())
        .merge(audit::router())
        .merge(service::router())
}

/// The description of the interface.
#[must_use]
pub fn document() -> Value {
    published(&completed(described().describe(Base::openapi())))
}

/// One line for each operation: method, path, id.
#[must_use]
pub fn operations() -> String {
    let routes = described();
    let mut lines: Vec<String> =
        routes.operations().map(|(method, path, id)| format!("{method:6} {path:58} {id}")).collect();
    lines.sort_by(|a, b| a.get(7..).cmp(&b.get(7..)));
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_route_has_the_names_of_its_description() {
        let (document, routes) = (document(), described());
        let mut count = 0;
        for (method, path, id) in routes.operations() {
            let operation = &document["paths"][path][method.to_lowercase()];
            assert_eq!(operation["operationId"], id, "{method} {path}");
            count += 1;
        }
        let described: usize =
            document["paths"].as_object().unwrap().values().map(|item| item.as_object().unwrap().len()).sum();
        assert_eq!(count, described);
    }
}
