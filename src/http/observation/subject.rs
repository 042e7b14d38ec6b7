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
    /// From this path, which matched this pattern.
    pub(in crate::http) fn of(pattern: &str, path: &'a str) -> Self {
        let mut found = Self::default();
        let mut before = "";
        if !pattern.contains('{') {
            return found;
        }
        // The texts are short: a search for the next byte in wide steps takes longer than looking at each.
        let is_slash = |letter: char| letter == '/';
        for (place, segment) in pattern.split(is_slash).zip(path.split(is_slash)) {
            match place {
                "{machine_id}" => found.machine_id = plain(segment),
                "{id}" | "{job_id}" if before == "jobs" => found.job_id = plain(segment),
                _ => {}
            }
            before = place;
        }
        found
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
        assert_eq!(Subject::of("/healthz", "/healthz"), Subject::default());
        assert_eq!(Subject::job_of_location("/v1/jobs/17"), Some("17"));
        assert_eq!(Subject::job_of_location("/v1/machines/17"), None);
    }
}
