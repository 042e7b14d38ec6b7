//! Counts of requests: one series for each operation, method and status, and no others. All series exist from the
//! start, so that no request of a client makes memory grow.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use http::{Method, StatusCode};

use crate::meter::{Counter, Times};

/// Name for requests that belong to no operation.
pub(super) const UNMATCHED: &str = "unmatched";

/// The methods that are distinguished if no operation matches.
const METHODS: [&str; 8] = ["GET", "HEAD", "POST", "PUT", "DELETE", "PATCH", "OPTIONS", "other"];

/// The statuses that are distinguished; every other status counts as the last.
pub(super) const STATUSES: [u16; 32] = [
    101, 200, 201, 202, 204, 206, 301, 302, 303, 304, 307, 308, 400, 401, 403, 404, 405, 406, 408, 409, 410,
    412, 413, 414, 415, 416, 422, 428, 429, 431, 500, 503,
];

/// The counts of one operation with one method.
#[derive(Debug)]
pub(in crate::http) struct Series {
    /// Id of the operation.
    pub(in crate::http) operation: Box<str>,
    /// The request's method.
    pub(in crate::http) method: &'static str,
    /// Counts by status; the last entry is for any other status.
    pub(super) answered: [Counter; STATUSES.len() + 1],
    /// From the header of a request to the header of its answer.
    pub(in crate::http) times: Times,
}

impl Series {
    fn new(operation: &str, method: &'static str) -> Self {
        let answered = std::array::from_fn(|_| Counter::new());
        Self { operation: operation.into(), method, answered, times: Times::new() }
    }

    /// One more answer.
    pub(in crate::http) fn count(&self, status: StatusCode) {
        let place = STATUSES.iter().position(|known| *known == status.as_u16()).unwrap_or(STATUSES.len());
        if let Some(counter) = self.answered.get(place) {
            counter.add(1);
        }
    }
}

/// Every series, found by the pattern of the path and the method.
#[derive(Debug)]
pub(in crate::http) struct Operations {
    series: Vec<Series>,
    /// For each path: the indices in `series` of its methods.
    paths: HashMap<Box<str>, Vec<usize>, RandomState>,
}

impl Operations {
    /// The series of these operations: method, pattern of the path, id. A GET operation also answers HEAD.
    pub(in crate::http) fn new<'a>(
        operations: impl Iterator<Item = (&'static str, &'a str, &'a str)>,
    ) -> Self {
        let mut series: Vec<Series> = METHODS.iter().map(|method| Series::new(UNMATCHED, method)).collect();
        let mut paths: HashMap<Box<str>, Vec<usize>, RandomState> = HashMap::default();
        for (method, path, id) in operations {
            let methods: &[&'static str] = if method == "GET" { &["GET", "HEAD"] } else { &[method] };
            for method in methods {
                let same = series.iter().position(|known| &*known.operation == id && known.method == *method);
                paths.entry(path.into()).or_default().push(same.unwrap_or(series.len()));
                if same.is_none() {
                    series.push(Series::new(id, method));
                }
            }
        }
        Self { series, paths }
    }

    /// The series in which a request counts.
    pub(in crate::http) fn of(&self, path: Option<&str>, method: &Method) -> Option<&Series> {
        let met = path.and_then(|path| self.paths.get(path)).and_then(|places| {
            let mut all = places.iter().filter_map(|place| self.series.get(*place));
            all.find(|series| series.method == method.as_str())
        });
        met.or_else(|| {
            let place = METHODS.iter().position(|known| *known == method.as_str());
            self.series.get(place.unwrap_or(METHODS.len() - 1))
        })
    }

    /// All series.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Series> {
        self.series.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_operation_meets_counts_by_known_methods_only() {
        let all = Operations::new([("GET", "/a/{id}", "get_a"), ("PUT", "/a/{id}", "put_a")].into_iter());
        let of = |path, method: &str| {
            let series = all.of(path, &method.parse().unwrap()).unwrap();
            (&*series.operation, series.method)
        };
        assert_eq!(of(Some("/a/{id}"), "GET"), ("get_a", "GET"));
        assert_eq!(of(Some("/a/{id}"), "HEAD"), ("get_a", "HEAD"));
        assert_eq!(of(Some("/a/{id}"), "PUT"), ("put_a", "PUT"));
        assert_eq!(of(Some("/a/{id}"), "DELETE"), (UNMATCHED, "DELETE"));
        assert_eq!(of(None, "GET"), (UNMATCHED, "GET"));
        assert_eq!(of(None, "BREW"), (UNMATCHED, "other"));
    }

    #[test]
    fn every_status_counts_somewhere() {
        let series = Series::new("x", "GET");
        for status in 100..=999 {
            series.count(StatusCode::from_u16(status).unwrap());
        }
        let counts: Vec<u64> = series.answered.iter().map(Counter::get).collect();
        assert!(counts.iter().take(STATUSES.len()).all(|count| *count == 1));
        assert_eq!(counts.iter().sum::<u64>(), 900);
    }
}
