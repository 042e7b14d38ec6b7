//! Routes with their descriptions. A route is ready at once; its description is made only when it is asked for, because
//! all of them take more time and memory than the rest of a start.

use axum::Router;
use axum::routing::MethodRouter;
use utoipa::openapi::{HttpMethod, OpenApi};
use utoipa_axum::router::{OpenApiRouter, UtoipaMethodRouter};

use super::AppState;

/// Described routes.
#[derive(Debug, Clone, Default)]
pub(super) struct Described {
    router: Router<AppState>,
    routes: Vec<RouteNames>,
}

/// A route before it is part of the router.
pub(super) struct Route {
    names: RouteNames,
    handler: MethodRouter<AppState>,
}

/// What the description and the metrics know of a route.
#[derive(Debug, Clone)]
pub(super) struct RouteNames {
    /// The HTTP method.
    pub(super) method: &'static str,
    /// The pattern of the path.
    pub(super) path: String,
    /// The id of the operation, which is its handler's name.
    pub(super) id: &'static str,
    describe: fn() -> UtoipaMethodRouter<AppState>,
}

impl Route {
    /// The route of a handler. [`routes`] knows all of this from the handler's name.
    pub(super) fn new(
        method: &HttpMethod,
        path: String,
        id: &'static str,
        handler: MethodRouter<AppState>,
        describe: fn() -> UtoipaMethodRouter<AppState>,
    ) -> Self {
        let method = match method {
            HttpMethod::Get => "GET",
            HttpMethod::Post => "POST",
            HttpMethod::Put => "PUT",
            HttpMethod::Delete => "DELETE",
            HttpMethod::Options => "OPTIONS",
            HttpMethod::Head => "HEAD",
            HttpMethod::Patch => "PATCH",
            HttpMethod::Trace => "TRACE",
        };
        Self { names: RouteNames { method, path, id, describe }, handler }
    }
}

impl Described {
    /// Adds these routes.
    pub(super) fn routes<const N: usize>(self, routes: [Route; N]) -> Self {
        routes.into_iter().fold(self, |mut all, Route { names, handler }| {
            all.router = all.router.route(&names.path, handler);
            all.routes.push(names);
            all
        })
    }

    /// Adds the routes of another resource.
    pub(super) fn merge(mut self, other: Self) -> Self {
        self.routes.extend(other.routes);
        Self { router: self.router.merge(other.router), routes: self.routes }
    }

    /// Every operation: method, pattern of the path, id.
    pub(super) fn operations(&self) -> impl Iterator<Item = (&'static str, &str, &str)> {
        self.routes.iter().map(|route| (route.method, route.path.as_str(), route.id))
    }

    /// The routes without their descriptions.
    pub(super) fn into_router(self) -> Router<AppState> {
        self.router
    }

    /// `base` with the descriptions of all routes.
    pub(super) fn describe(&self, base: OpenApi) -> OpenApi {
        let router = OpenApiRouter::with_openapi(base);
        self.routes.iter().fold(router, |router, route| router.routes((route.describe)())).into_openapi()
    }
}

/// The routes of these handlers, each `module::handler`.
macro_rules! routes {
    ($($module:ident :: $handler:ident),+ $(,)?) => {
        [$(pastey::paste! {{
            let methods = <$module::[<__path_ $handler>] as utoipa::Path>::methods();
            // Every handler has one method.
            let method = methods.into_iter().next().unwrap_or(utoipa::openapi::HttpMethod::Get);
            let filter = utoipa_axum::PathItemExt::to_method_filter(&method);
            $crate::http::described::Route::new(
                &method,
                <$module::[<__path_ $handler>] as utoipa::Path>::path(),
                stringify!($handler),
                axum::routing::on(filter, $module::$handler),
                || utoipa_axum::routes!($module::$handler),
            )
        }}),+]
    };
}
pub(super) use routes;
