//! Routes and their descriptions, from one list of handlers.
//!
//! A route knows its names. Its description is made apart from it, for the file that the binary then contains: a start
//! makes none, and the binary has none of the code that does.

use axum::Router;
use axum::routing::{MethodFilter, MethodRouter};
use http::Method;

use super::AppState;

/// Routes, and what the metrics know of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Routes {
    router: Router<AppState>,
    names: Vec<Names>,
}

/// The HTTP method, the pattern of the path, and the id of the operation, which is its handler's name.
type Names = (&'static str, &'static str, &'static str);

/// The HTTP method and the pattern of the path of a handler's route.
pub(super) type Route = (&'static str, &'static str);

impl Routes {
    /// Adds the route of a handler. [`resource`] knows its names.
    pub(super) fn add<S>(mut self, (method, path): Route, id: &'static str, handler: S) -> Self
    where
        S: FnOnce(MethodFilter) -> MethodRouter<AppState>,
    {
        // Every method that a handler can have is one of the router's.
        let filter = Method::from_bytes(method.as_bytes()).ok().and_then(|method| method.try_into().ok());
        let handler = handler(filter.unwrap_or(MethodFilter::GET));
        self.router = self.router.route(path, handler);
        self.names.push((method, path, id));
        self
    }

    /// Adds the routes of another resource.
    pub(super) fn merge(mut self, other: Self) -> Self {
        self.names.extend(other.names);
        Self { router: self.router.merge(other.router), names: self.names }
    }

    /// Every operation: method, pattern of the path, id.
    pub(super) fn operations(&self) -> impl Iterator<Item = Names> {
        self.names.iter().copied()
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
            $(let routes = pastey::paste! {
                routes.add($module::[<ROUTE_OF_ $handler:upper>], stringify!($handler), |method| {
                    axum::routing::on(method, $module::$handler)
                })
            };)+
            $($(let routes = routes.merge($nested::routes());)+)?
            routes
        }

        /// Adds the descriptions of these routes.
        #[cfg(test)]
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
