//! The machine and the job that a request concerns, as far as its path names them.

/// Longest id that is logged \[bytes\].
const LONGEST: usize = 64;

/// The machine and the job in a path, if its pattern has places for them.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(in crate::http) struct Subject<'a> {
    pub(in crate::http) machine_id: Option<&'a str>,
    pub(in crate::http) job_id: Option<&'a str>,
}

impl<'a> Subject<'a> {
    /// From this path, which matched this pattern. Only the first place of a pattern has such an id, and the text
    /// before it is the same in both.
    pub(in crate::http) fn of(pattern: &str, path: &'a str) -> Self {
        // Every request passes here. For so few bytes, a loop is faster than the library's search.
        let place = pattern.bytes().position(|byte| byte == b'{');
        let Some((before, name)) = place.and_then(|at| Some((pattern.get(..at)?, pattern.get(at + 1..)?)))
        else {
            return Self::default();
        };
        let id = || {
            let rest = path.get(before.len()..)?;
            plain(rest.get(..rest.bytes().position(|byte| byte == b'/').unwrap_or(rest.len()))?)
        };
        if name.starts_with("machine_id}") {
            Self { machine_id: id(), job_id: None }
        } else if before.ends_with("/jobs/") {
            Self { machine_id: None, job_id: id() }
        } else {
            Self::default()
        }
    }

    /// The job in the address of an answer's `Location`.
    pub(in crate::http) fn job_of_location(location: &'a str) -> Option<&'a str> {
        plain(location.strip_prefix("/v1/jobs/")?.split('/').next()?)
    }
}

/// Ids are plain text; any other text is not an id and does not enter the log.
fn plain(segment: &str) -> Option<&str> {
    let sound = !segment.is_empty()
        && segment.len() <= LONGEST
        && segment.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-');
    sound.then_some(segment)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_stand_where_the_pattern_has_them() {
        let found =
            Subject::of("/v1/machines/{machine_id}/calibrations/{id}", "/v1/machines/dmu-80/calibrations/17");
        assert_eq!(found, Subject { machine_id: Some("dmu-80"), job_id: None });
        let found = Subject::of("/v1/jobs/{id}/report", "/v1/jobs/0195a3f0/report");
        assert_eq!(found, Subject { machine_id: None, job_id: Some("0195a3f0") });
        assert_eq!(Subject::of("/v1/jobs/{id}", "/v1/jobs/a%0Ab"), Subject::default());
        assert_eq!(Subject::of("/v1/keys/{id}", "/v1/keys/0195a3f0"), Subject::default());
        assert_eq!(Subject::of("/healthz", "/healthz"), Subject::default());
        assert_eq!(Subject::job_of_location("/v1/jobs/17"), Some("17"));
        assert_eq!(Subject::job_of_location("/v1/machines/17"), None);
    }
}
