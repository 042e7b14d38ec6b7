//! Faults of a server of PostgreSQL: which of them pass, and what callers are told of them.

use std::io;

use rustls::{CertificateError, Error as RustlsError};
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
            "53000" | "53200" | "58030" | "XX001" | "XX002" => Self::Storage(StorageFault::Failing),
            // character_not_in_repertoire, untranslatable_character
            "22021" | "22P05" => Self::Nul,
            // The server only reads: the address leads to a standby, or the server was set so. It stops, crashed or starts.
            // A transaction or session took too long. The connection is broken.
            "25006" | "25P03" | "57P01" | "57P02" | "57P03" | "57P05" => Self::Storage(StorageFault::Away),
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
        _ if tls_fault(error).is_some() => tls_fault(error).map_or("", TlsFault::words).to_owned(),
        Error::Io(fault) => fault.to_string(),
        Error::Database(fault) => match fault.code().as_deref() {
            Some("57P03") => "it is starting or stopping".to_owned(),
            Some("53300") => "it has no connection left".to_owned(),
            Some("25006") => "it only reads at present".to_owned(),
            code => format!("it refuses the connection (SQLSTATE {})", code.unwrap_or("unknown")),
        },
        _ => "the connection is broken".to_owned(),
    }
}

/// Whether a server refused a change because it only reads (`read_only_sql_transaction`).
pub(super) fn is_read_only(error: &Error) -> bool {
    matches!(error, Error::Database(fault) if fault.code().is_some_and(|code| code == "25006"))
}

/// Why a connection is not protected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TlsFault {
    /// The server offers no TLS.
    NotOffered,
    /// Its certificate is for another name.
    OtherName,
    /// Nobody who is trusted has signed it.
    UnknownAuthority,
    /// It is not valid at this time, by the clock of this computer.
    OtherTime,
    /// Another fault.
    Other,
}

impl TlsFault {
    fn words(self) -> &'static str {
        match self {
            Self::NotOffered => "it offers no TLS",
            Self::OtherName => "its certificate is for another name",
            Self::UnknownAuthority => "no authority that is trusted has signed its certificate",
            Self::OtherTime => "its certificate is not valid at this time",
            Self::Other => "TLS could not be set up",
        }
    }

    fn cure(self) -> &'static str {
        match self {
            Self::NotOffered => {
                "The server offers no TLS: set ssl = on there, or sslmode=disable in the address if nobody else can reach \
                 the network between"
            }
            Self::OtherName => {
                "The certificate of the server is for another name: use that name in the address, or make a certificate \
                 for this one"
            }
            Self::UnknownAuthority => {
                "No authority that is trusted has signed the certificate of the server: name the certificate of the \
                 authority in the address (sslrootcert=FILE)"
            }
            Self::OtherTime => {
                "The certificate of the server is not valid at this time: renew it, and check the clock of this computer"
            }
            Self::Other => "Check sslmode, sslrootcert, sslcert and sslkey in the address",
        }
    }
}

/// What is wrong with TLS, if that is the fault.
fn tls_fault(error: &Error) -> Option<TlsFault> {
    let (found, otherwise) = match error {
        Error::Tls(fault) if fault.to_string().contains("does not support TLS") => {
            return Some(TlsFault::NotOffered);
        }
        Error::Tls(fault) => (fault.downcast_ref::<RustlsError>(), Some(TlsFault::Other)),
        Error::Io(fault) => (fault.get_ref().and_then(|inner| inner.downcast_ref::<RustlsError>()), None),
        _ => return None,
    };
    let Some(found) = found else { return otherwise };
    Some(match found {
        RustlsError::InvalidCertificate(
            CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. },
        ) => TlsFault::OtherName,
        RustlsError::InvalidCertificate(CertificateError::UnknownIssuer) => TlsFault::UnknownAuthority,
        RustlsError::InvalidCertificate(
            CertificateError::Expired
            | CertificateError::ExpiredContext { .. }
            | CertificateError::NotValidYet
            | CertificateError::NotValidYetContext { .. },
        ) => TlsFault::OtherTime,
        _ => TlsFault::Other,
    })
}

/// What helps against a fault of the first connection.
pub(super) fn cure(error: &Error) -> &'static str {
    match (tls_fault(error), error) {
        (Some(fault), _) => fault.cure(),
        (None, Error::Io(fault)) if fault.kind() == io::ErrorKind::NotFound => {
            "Check the files and the socket that the address names"
        }
        _ => "Start the server, or change database in the settings",
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
            ("25006", Storage(StorageFault::Away)),
            ("57P03", Storage(StorageFault::Away)),
            ("08006", Storage(StorageFault::Away)),
            ("28P01", Storage(StorageFault::Away)),
            ("55P03", Busy),
            ("57014", Busy),
        ] {
            assert_eq!(PgFault::of_state(state), expected, "{state}");
        }
    }
    #[test]
    fn each_fault_of_tls_has_its_own_words_and_cure() {
        let refused = |fault| {
            Error::Io(io::Error::new(io::ErrorKind::InvalidData, RustlsError::InvalidCertificate(fault)))
        };
        let faults = [
            Error::Tls("server does not support TLS".into()),
            refused(CertificateError::NotValidForName),
            refused(CertificateError::UnknownIssuer),
            refused(CertificateError::Expired),
            Error::Tls("something else".into()),
            Error::Io(io::ErrorKind::ConnectionRefused.into()),
        ];
        let told: std::collections::BTreeSet<_> =
            faults.iter().map(|fault| (reason(fault), cure(fault))).collect();
        assert_eq!(told.len(), faults.len(), "{told:?}");
        assert_eq!(reason(&faults[2]), "no authority that is trusted has signed its certificate");
        assert!(cure(&faults[2]).contains("sslrootcert"));
    }
}
