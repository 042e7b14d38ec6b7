//! Faults of a server of PostgreSQL: which of them pass, and what callers are told of them.

use sqlx::Error;
use sqlx::postgres::PgDatabaseError;

use super::StorageFault;

/// What a fault is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PgFault {
    /// The server, or its disk.
    Storage(StorageFault),
    /// Somebody else has what the statement needs for too long.
    Busy,
    /// A text contains the character U+0000.
    Nul,
    /// The statement.
    Statement,
}

impl PgFault {
    /// The fault, if it comes from PostgreSQL or the way to it.
    pub(super) fn of(error: &Error) -> Option<Self> {
        match error {
            Error::Io(_) | Error::Tls(_) | Error::Protocol(_) => Some(Self::Storage(StorageFault::Away)),
            Error::Database(fault) => {
                fault.try_downcast_ref::<PgDatabaseError>().map(|fault| Self::of_state(fault.code()))
            }
            _ => None,
        }
    }

    /// The fault with this SQLSTATE, <https://www.postgresql.org/docs/current/errcodes-appendix.html>.
    fn of_state(state: &str) -> Self {
        match state {
            // statement_timeout and lock_timeout; serialization and deadlock; too many connections.
            "57014" | "55P03" | "40001" | "40P01" | "53300" | "53400" => Self::Busy,
            "53100" => Self::Storage(StorageFault::Full),
            "25006" => Self::Storage(StorageFault::ReadOnly),
            "53000" | "53200" | "58030" | "XX001" | "XX002" => Self::Storage(StorageFault::Failing),
            // character_not_in_repertoire, untranslatable_character
            "22021" | "22P05" => Self::Nul,
            // The server stops, crashed or starts; a transaction or session took too long; the connection is broken.
            "25P03" | "57P01" | "57P02" | "57P03" | "57P05" => Self::Storage(StorageFault::Away),
            _ => match state.get(..2) {
                // Connections, and the right to make one.
                Some("08" | "28" | "3D") => Self::Storage(StorageFault::Away),
                _ => Self::Statement,
            },
        }
    }
}

/// Why the server does not answer, in words that every caller may read: no address, no name.
pub(super) fn reason(error: &Error) -> String {
    match error {
        Error::Io(fault) => fault.to_string(),
        Error::Database(fault) => match fault.code().as_deref() {
            Some("57P03") => "it is starting or stopping".to_owned(),
            Some("53300") => "it has no connection left".to_owned(),
            code => format!("it refuses the connection (SQLSTATE {})", code.unwrap_or("unknown")),
        },
        Error::Tls(_) => "TLS could not be set up".to_owned(),
        _ => "the connection is broken".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_read_as_text_and_not_as_a_number_of_sqlite() {
        use PgFault::{Busy, Nul, Statement, Storage};
        for (state, expected) in [
            // Read as numbers, these would be busy, read-only and failing.
            ("22021", Nul),
            ("42501", Statement),
            ("21000", Statement),
            ("22026", Statement),
            ("23505", Statement),
            ("53100", Storage(StorageFault::Full)),
            ("25006", Storage(StorageFault::ReadOnly)),
            ("57P03", Storage(StorageFault::Away)),
            ("08006", Storage(StorageFault::Away)),
            ("28P01", Storage(StorageFault::Away)),
            ("55P03", Busy),
            ("57014", Busy),
        ] {
            assert_eq!(PgFault::of_state(state), expected, "{state}");
        }
    }
}
