//! The address of a database server. It may contain a password, which is never shown.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Parameters that an address may have.
const PARAMETERS: [&str; 10] = [
    "sslmode",
    "sslrootcert",
    "sslcert",
    "sslkey",
    "host",
    "port",
    "user",
    "dbname",
    "options",
    "statement-cache-capacity",
];

/// An address such as `postgres://trunnion@db.plant.example/trunnion`.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct DatabaseAddress(String);

impl DatabaseAddress {
    /// The address with its password, for the connection.
    #[must_use]
    pub fn with_password(&self) -> &str {
        &self.0
    }

    /// What is wrong with the address, without a word of it.
    #[must_use]
    pub fn fault(&self) -> Option<&'static str> {
        let scheme = ["postgres://", "postgresql://"].into_iter().find(|scheme| self.0.starts_with(scheme));
        let Some(rest) = scheme.and_then(|scheme| self.0.strip_prefix(scheme)) else {
            return Some("it does not begin with postgres://");
        };
        if rest.contains('#') {
            return Some("it contains a #; in a password write it as %23");
        }
        let (place, query) = rest.split_once('?').unwrap_or((rest, ""));
        let authority = place.split('/').next().unwrap_or("");
        if authority.matches('@').count() > 1 {
            return Some("it contains more than one @; in a password write it as %40");
        }
        let is_known = |pair: &str| {
            let name = pair.split('=').next().unwrap_or("").to_owned();
            name.is_empty() || PARAMETERS.contains(&name.as_str()) || name.starts_with("options[")
        };
        query.split('&').any(|pair| !is_known(pair)).then_some(
            "it has a parameter other than sslmode, sslrootcert, sslcert, sslkey, host, port, user, dbname, options \
             and statement-cache-capacity; give a password with database_password_file",
        )
    }
}

/// The address without user name, password and parameters.
impl fmt::Display for DatabaseAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.fault().is_some() {
            return f.write_str("(hidden)");
        }
        let rest = self.0.split_once("://").map_or("", |(_, rest)| rest);
        let place = rest.split('?').next().unwrap_or("");
        let (authority, database) = place.split_once('/').unwrap_or((place, ""));
        let server = authority.rsplit('@').next().unwrap_or("");
        write!(f, "postgres://{server}/{database}")
    }
}

impl fmt::Debug for DatabaseAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Every text is taken, so that no message quotes one that is refused; [`DatabaseAddress::fault`] says what is wrong.
impl FromStr for DatabaseAddress {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(text: &str) -> DatabaseAddress {
        DatabaseAddress(text.to_owned())
    }

    #[test]
    fn a_password_is_never_shown() {
        for text in [
            "postgres://trunnion:s3cret@db.plant/trunnion?sslmode=verify-full",
            "postgresql://trunnion:s3cret@db.plant:5433/trunnion",
            "postgres://trunnion:s3cret@db.plant/trunnion?password=s3cret",
            "postgres://trunnion:s3cret@s3cret@db.plant/trunnion",
            "postgres://trunnion:s3cret#@db.plant/trunnion",
            "mysql://trunnion:s3cret@db.plant/trunnion",
            "trunnion:s3cret@db.plant",
        ] {
            let address = address(text);
            assert!(!format!("{address} {address:?}").contains("s3cret"), "{text}: {address}");
        }
        let shown = address("postgres://trunnion:s3cret@db.plant:5433/trunnion?sslmode=require").to_string();
        assert_eq!(shown, "postgres://db.plant:5433/trunnion");
    }

    #[test]
    fn an_address_that_cannot_be_used_is_refused_without_a_word_of_it() {
        for text in [
            "postgres://db.plant/trunnion",
            "postgres://trunnion@%2Frun%2Fpostgresql/trunnion",
            "postgresql://trunnion:a%40b@127.0.0.1:5433/trunnion?sslmode=disable&options[search_path]=plant",
        ] {
            assert_eq!(address(text).fault(), None, "{text}");
        }
        for text in [
            "",
            "db.plant",
            "https://db.plant/trunnion",
            "postgres://a:b@c@d/trunnion",
            "postgres://a:b#c@d/trunnion",
            "postgres://db.plant/trunnion?passwrd=b",
        ] {
            assert!(address(text).fault().is_some(), "{text}");
        }
    }
}
