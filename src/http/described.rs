//! Routes and their descriptions, from one list of handlers.
//!
//! A route knows its names. Its description is made apart from it, for the file that the binary then contains: a start
//! makes none, and the binary has none of the code that does.

use axum::Router;
use axum::routing::MethodRouter;
use utoipa::openapi::HttpMethod;

use super::AppState;

/// Routes, and what the metrics know of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Routes {
    router: Router<AppState>,
    names: Vec<Names>,
}

/// The HTTP method, the pattern of the path, and the id of the operation, which is its handler's name.
type Names = (&'static str, String, &'static str);

impl Routes {
    /// Adds the route of a handler. [`resource`] knows its names.
    pub(super) fn add(
        mut self,
        method: &HttpMethod,
        path: String,
        id: &'static str,
        handler: MethodRouter<AppState>,
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
        self.router = self.router.route(&path, handler);
        self.names.push((method, path, id));
        self
    }

    /// Adds the routes of another resource.
    pub(super) fn merge(mut self, other: Self) -> Self {
        self.names.extend(other.names);
        Self { router: self.router.merge(other.router), names: self.names }
    }

    /// Every operation: method, pattern of the path, id.
    pub(super) fn operations(&self) -> impl Iterator<Item = (&'static str, &str, &str)> {
        self.names.iter().map(|(method, path, id)| (*method, path.as_str(), *id))
    }

    /// The routes alone.
    pub(super) fn into_router(self) -> Router<AppState> {
        self.router
    }
}

/// Makes `routes()` and `describe()` of a resource from its handlers, each `module::handler`; after a semicolon come
/// resources that belong to it.
macro_rules! resource {
    ($($module:ident :: $handler:ident),+ $(,)? $(; $($nested:ident),+)?) => {
        /// The routes of this resource.
        pub(super) fn routes() -> $crate::http::described::Routes {
            let routes = $crate::http::described::Routes::default();
            $(let routes = pastey::paste! {{
                let methods = <$module::[<__path_ $handler>] as utoipa::Path>::methods();
                // Every handler has one method.
                let method = methods.into_iter().next().unwrap_or(utoipa::openapi::HttpMethod::Get);
                let filter = utoipa_axum::PathItemExt::to_method_filter(&method);
                let path = <$module::[<__path_ $handler>] as utoipa::Path>::path();
                routes.add(&method, path, stringify!($handler), axum::routing::on(filter, $module::$handler))
            }};)+
            $($(let routes = routes.merge($nested::routes());)+)?
            routes
        }

        /// Adds the descriptions of these routes.
        pub(super) fn describe(
            described: utoipa_axum::router::OpenApiRouter<$crate::http::AppState>,
        ) -> utoipa_axum::router::OpenApiRouter<$crate::http::AppState> {
            let described = described$(.routes(utoipa_axum::routes!($module::$handler)))+;
            $($(let described = $nested::describe(described);)+)?
            described
        }
    };
}
pub(super) use resource;
