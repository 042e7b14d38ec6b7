//! Environment variables that begin as the settings do, but are no settings: a name that was mistyped, and names that
//! others set.

use std::collections::BTreeSet;

use super::{ConfigFault, ENVIRONMENT};

/// How every variable of this program begins.
const PREFIX: &str = "TRUNNION_";
/// The variable that names the settings file.
const SETTINGS_FILE: &str = "CONFIG";
/// Up to this length of a name, one letter may differ; two may differ in longer names.
const SHORT: usize = 6;
/// From this length on, the beginning of a name counts as that name.
const BEGINNING: usize = 4;

/// Warnings about variables that begin as settings do, but are no settings.
///
/// # Errors
/// A name is nearly that of a setting: the setting would silently keep its default.
pub fn unknown_variables(
    variables: impl IntoIterator<Item = (String, String)>,
) -> Result<Vec<String>, ConfigFault> {
    // Sorted, so that the warnings have one order.
    let (mut strange, mut linked) = (BTreeSet::new(), BTreeSet::new());
    for (name, value) in variables {
        let Some(rest) = name.strip_prefix(PREFIX) else { continue };
        if is_known(rest) {
            continue;
        }
        if is_service_link(rest, &value) {
            linked.insert(name);
        } else if let Some(known) = nearest(rest) {
            return Err(ConfigFault::Mistyped { given: name, known: format!("{PREFIX}{known}") });
        } else {
            strange.insert(name);
        }
    }
    let ignored = |name| format!("the environment variable {name} is no setting and is ignored");
    let mut warnings: Vec<String> = strange.into_iter().map(ignored).collect();
    if !linked.is_empty() {
        let names = linked.into_iter().collect::<Vec<_>>().join(", ");
        warnings.push(format!(
            "Kubernetes has set environment variables for a service whose name begins with trunnion; they are no \
             settings and are ignored: {names}. Set enableServiceLinks: false in the pod's spec"
        ));
    }
    Ok(warnings)
}

/// The names of all settings as variables, without their common beginning.
fn settings() -> impl Iterator<Item = &'static str> {
    ENVIRONMENT.iter().filter_map(|(_, name)| name.strip_prefix(PREFIX)).chain([SETTINGS_FILE])
}

fn is_known(rest: &str) -> bool {
    settings().any(|known| known == rest)
}

/// Whether Kubernetes sets this variable for a service: `…_SERVICE_HOST`, `…_SERVICE_PORT`, `…_SERVICE_PORT_NAME`,
/// `…_PORT` with an address, `…_PORT_8080_TCP` and the parts of that address. The service may have a longer name than
/// `trunnion`.
fn is_service_link(rest: &str, value: &str) -> bool {
    let rest = format!("_{rest}");
    if rest.ends_with("_SERVICE_HOST") || rest.ends_with("_SERVICE_PORT") || rest.contains("_SERVICE_PORT_") {
        return true;
    }
    if rest.ends_with("_PORT") && value.contains("://") {
        return true;
    }
    let protocols = ["_TCP", "_UDP", "_SCTP"];
    let address = ["_PROTO", "_PORT", "_ADDR"].iter().find_map(|part| rest.strip_suffix(part));
    let address = address.unwrap_or(&rest);
    let port = protocols.iter().find_map(|protocol| address.strip_suffix(protocol));
    let number = port.and_then(|port| port.rsplit_once("_PORT_")).map(|(_, number)| number);
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

/// The setting that was probably meant: the only one that begins with this name, or the nearest in letters.
fn nearest(given: &str) -> Option<&'static str> {
    let given = given.to_ascii_uppercase();
    let mut beginning = settings().filter(|known| given.len() >= BEGINNING && known.starts_with(&given));
    if let (Some(only), None) = (beginning.next(), beginning.next()) {
        return Some(only);
    }
    let near = settings().map(|known| (distance(&given, known), known));
    let allowed = |known: &str| if known.len() <= SHORT { 1 } else { 2 };
    near.filter(|(distance, known)| *distance <= allowed(known)).min().map(|(_, known)| known)
}

/// The number of letters to add, remove, replace or exchange with their neighbour (optimal string alignment).
fn distance(a: &str, b: &str) -> usize {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, y) in b.iter().enumerate() {
            let at = |row: &[usize], place: usize| row.get(place).copied().unwrap_or(usize::MAX - 1);
            let mut least = at(&last, j) + usize::from(x != y);
            least = least.min(at(&last, j + 1) + 1).min(at(&row, j) + 1);
            let exchanged = i > 0 && j > 0 && a.get(i - 1) == Some(y) && b.get(j - 1) == Some(x);
            if exchanged {
                least = least.min(at(&before, j - 1) + 1);
            }
            row.push(least);
        }
        before = std::mem::replace(&mut last, row);
    }
    last.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(variables: &[(&str, &str)]) -> Result<Vec<String>, String> {
        let variables = variables.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        unknown_variables(variables).map_err(|fault| fault.to_string())
    }

    #[test]
    fn distances_count_letters() {
        for (a, b, expected) in [
            ("", "", 0),
            ("LISTEN", "LISTEN", 0),
            ("LISTEN", "LISTNE", 1),
            ("DATADIR", "DATA_DIR", 1),
            ("DATA_DRI", "DATADIR", 2),
            ("ABC", "", 3),
            ("", "ABC", 3),
            ("KITTEN", "SITTING", 3),
        ] {
            assert_eq!(distance(a, b), expected, "{a} {b}");
        }
    }

    #[test]
    fn settings_and_variables_of_others_are_left_alone() {
        let mut all: Vec<(&str, &str)> = ENVIRONMENT.iter().map(|(_, name)| (*name, "1")).collect();
        all.extend([("TRUNNION_CONFIG", "x"), ("PATH", "/bin"), ("TRUNNIONS_LISTEN", "1")]);
        assert_eq!(told(&all), Ok(Vec::new()));
    }

    #[test]
    fn a_mistyped_setting_is_refused_with_its_name() {
        for (given, known) in [
            ("TRUNNION_DATADIR", "TRUNNION_DATA_DIR"),
            ("TRUNNION__LISTEN", "TRUNNION_LISTEN"),
            ("TRUNNION_LISTNE", "TRUNNION_LISTEN"),
            ("TRUNNION_MAX_BODY", "TRUNNION_MAX_BODY_BYTES"),
            ("TRUNNION_MAX_COST", "TRUNNION_MAX_COST_S"),
            ("TRUNNION_TLS_CERT", "TRUNNION_TLS_CERTIFICATE"),
            ("TRUNNION_LOGFORMAT", "TRUNNION_LOG_FORMAT"),
            ("TRUNNION_LOGS", "TRUNNION_LOG"),
            ("TRUNNION_CONFG", "TRUNNION_CONFIG"),
            ("TRUNNION_insecure", "TRUNNION_INSECURE"),
        ] {
            let fault = told(&[(given, "x")]).unwrap_err();
            assert!(fault.contains(given) && fault.contains(&format!("did you mean {known}?")), "{fault}");
        }
    }

    #[test]
    fn no_setting_is_near_another() {
        let all: Vec<_> = settings().collect();
        for one in &all {
            for other in all.iter().filter(|other| *other != one) {
                assert!(distance(one, other) > 1, "{one} {other}");
            }
        }
    }

    #[test]
    fn unknown_variables_are_named_and_those_of_kubernetes_together() {
        let warnings = told(&[
            ("TRUNNION_URL", "http://mill:8080"),
            ("TRUNNION_PORT", "tcp://10.0.0.7:8080"),
            ("TRUNNION_PORT_8080_TCP", "tcp://10.0.0.7:8080"),
            ("TRUNNION_PORT_8080_TCP_ADDR", "10.0.0.7"),
            ("TRUNNION_PORT_8080_TCP_PORT", "8080"),
            ("TRUNNION_PORT_8080_TCP_PROTO", "tcp"),
            ("TRUNNION_SERVICE_HOST", "10.0.0.7"),
            ("TRUNNION_SERVICE_PORT", "8080"),
            ("TRUNNION_SERVICE_PORT_HTTP", "8080"),
            ("TRUNNION_DB_PORT_53_UDP", "udp://10.0.0.8:53"),
        ])
        .unwrap();
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(warnings[0].contains("TRUNNION_URL is no setting"), "{warnings:?}");
        assert_eq!(warnings[1].matches("TRUNNION_").count(), 9, "{warnings:?}");
        assert!(warnings[1].contains("enableServiceLinks: false"), "{warnings:?}");
    }

    #[test]
    fn a_port_that_a_person_sets_is_no_link_of_kubernetes() {
        let warnings = told(&[("TRUNNION_PORT", "9000")]).unwrap();
        assert!(warnings[0].contains("TRUNNION_PORT is no setting"), "{warnings:?}");
    }
}
