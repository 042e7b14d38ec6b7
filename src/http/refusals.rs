//! The refusals of an operation, as responses of its description. Only tests make the description.

#[cfg(test)]
use std::collections::BTreeMap;

#[cfg(test)]
use http::StatusCode;
#[cfg(test)]
use utoipa::openapi::header::HeaderBuilder;
#[cfg(test)]
use utoipa::openapi::response::ResponseBuilder;
#[cfg(test)]
use utoipa::openapi::schema::Type;
#[cfg(test)]
use utoipa::openapi::{ContentBuilder, ObjectBuilder, Ref, RefOr, Response};

#[cfg(test)]
use super::problem::{PROBLEM_JSON, ProblemType};

/// Refusals that every operation has, whatever it does.
#[cfg(test)]
pub(super) const OF_EVERY_OPERATION: [ProblemType; 9] = [
    ProblemType::UrlTooLong,
    ProblemType::TooManyRequests,
    ProblemType::Quota,
    ProblemType::HeaderTooLarge,
    ProblemType::Internal,
    ProblemType::StoredFileDamaged,
    ProblemType::StorageUnavailable,
    ProblemType::TimedOut,
    ProblemType::MemoryBudget,
];

/// Responses of an operation with refusals of its own.
#[cfg(test)]
pub(super) fn responses_of_operation(own: &[ProblemType]) -> BTreeMap<String, RefOr<Response>> {
    responses(&[own, &OF_EVERY_OPERATION].concat())
}

/// Responses by status; several kinds with one status share a response that names them all.
#[cfg(test)]
pub(super) fn responses(kinds: &[ProblemType]) -> BTreeMap<String, RefOr<Response>> {
    let mut by_status: BTreeMap<String, Vec<ProblemType>> = BTreeMap::new();
    for kind in kinds {
        by_status.entry(kind.status().as_str().to_owned()).or_default().push(*kind);
    }
    by_status.into_iter().map(|(status, kinds)| (status, response(&kinds).into())).collect()
}

#[cfg(test)]
fn response(kinds: &[ProblemType]) -> Response {
    let titles: Vec<_> = kinds.iter().map(|kind| format!("{} (`{}`)", kind.title(), kind.code())).collect();
    // The schema has the example.
    let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
    let response = ResponseBuilder::new().description(titles.join("; ")).content(PROBLEM_JSON, content);
    match kinds.first().map(|kind| kind.status()) {
        Some(StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS) => {
            let seconds = ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(0.0));
            let header = HeaderBuilder::new()
                .schema(Some(seconds))
                .description(Some("Seconds to wait before the next attempt"));
            response.header("Retry-After", header.build()).build()
        }
        _ => response.build(),
    }
}

/// Declares a type for the refusals of one operation in its description.
macro_rules! refusals {
    ($name:ident: $($kind:ident),+ $(,)?) => {
        /// The refusals of the operation.
        #[cfg(test)]
        struct $name;

        #[cfg(test)]
        impl utoipa::IntoResponses for $name {
            fn responses() -> std::collections::BTreeMap<
                String,
                utoipa::openapi::RefOr<utoipa::openapi::response::Response>,
            > {
                use $crate::http::problem::ProblemType;
                $crate::http::refusals::responses_of_operation(&[$(ProblemType::$kind),+])
            }
        }
    };
}
pub(super) use refusals;
