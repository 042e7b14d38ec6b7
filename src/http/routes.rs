//! Merges the routes of the resources, and the description that they make.

use serde_json::Value;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;

use super::described::Routes;
use super::openapi::{Base, completed, published};
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

/// The description of the interface, made from the routes. The binary serves the committed one, which is equal.
#[must_use]
pub fn document() -> Value {
    let resources = [
        machines::describe,
        tools::describe,
        kinematics::describe,
        programs::describe,
        servo::describe,
        wear::describe,
        calibrations::describe,
        jobs::describe,
        webhooks::describe,
        keys::describe,
        audit::describe,
        service::describe,
    ];
    let base = OpenApiRouter::with_openapi(Base::openapi());
    let described = resources.into_iter().fold(base, |all, describe| describe(all));
    published(&completed(described.into_openapi()))
}

/// One line for each operation: method, path, id.
#[must_use]
pub fn operations() -> String {
    let routes = routes();
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
        let (document, routes) = (document(), routes());
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
