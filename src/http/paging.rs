//! Pages of lists.

use axum::response::{IntoResponse, Response};
use http::header::CONTENT_TYPE;
use http::{HeaderName, HeaderValue};
use serde::{Deserialize, Serialize};

use super::problem::{Problem, ProblemType};
use crate::description::{IntoParams, ToSchema};
use crate::store::{Cursor, Page};
use crate::wire::{Fault, FaultList};

/// Which page of a list.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields, default)]
#[into_params(parameter_in = Query)]
pub(super) struct PageQuery {
    /// Number of items.
    #[param(minimum = 1, maximum = 200, default = 50)]
    limit: Option<u64>,
    /// `next_cursor` of the previous page.
    cursor: Option<String>,
}

/// Largest number of items on a page.
const MAX_LIMIT: u32 = 200;
/// Default number of items on a page.
const DEFAULT_LIMIT: u32 = 50;

impl PageQuery {
    /// The page of these two parameters.
    pub(super) fn new(limit: Option<u64>, cursor: Option<String>) -> Self {
        Self { limit, cursor }
    }

    /// The number of items, and the cursor to begin at.
    pub(super) fn read(&self) -> Result<(u32, Option<Cursor>), Problem> {
        let mut faults = FaultList::default();
        let limit = match self.limit.map(u32::try_from) {
            None => DEFAULT_LIMIT,
            Some(Ok(limit)) if (1..=MAX_LIMIT).contains(&limit) => limit,
            Some(_) => {
                faults.push(|| Fault::new("/limit", format!("limit is not between 1 and {MAX_LIMIT}")));
                DEFAULT_LIMIT
            }
        };
        let cursor = self.cursor.as_deref().map(str::parse).transpose();
        if let Err(fault) = cursor {
            faults.push(|| Fault::new("/cursor", crate::store::CursorFault::to_string(&fault)));
        }
        faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
        Ok((limit, cursor.unwrap_or_default()))
    }
}

/// Media type of a table.
pub(super) const CSV: &str = "text/csv";
/// Cursor of the next page of a table; missing on the last page.
pub(super) const NEXT_CURSOR: HeaderName = HeaderName::from_static("trunnion-next-cursor");

/// One page of a list as a table. A table has no member for the cursor of the next page, so a header has it.
pub(super) fn table_page(table: Vec<u8>, next: Option<Cursor>) -> Response {
    let mut response = ([(CONTENT_TYPE, CSV)], table).into_response();
    if let Some(cursor) = next.and_then(|cursor| HeaderValue::try_from(cursor.to_string()).ok()) {
        response.headers_mut().insert(NEXT_CURSOR, cursor);
    }
    response
}

/// One page of a list, newest first.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Listed<T> {
    /// The items.
    items: Vec<T>,
    /// Cursor of the next page; null on the last page.
    next_cursor: Option<String>,
}

impl<T> Listed<T> {
    /// The page with its items in their wire form.
    pub(super) fn new<R>(page: Page<R>, form: impl FnMut(R) -> T) -> Self {
        let next_cursor = page.next.map(|cursor| cursor.to_string());
        Self { items: page.items.into_iter().map(form).collect(), next_cursor }
    }
}
