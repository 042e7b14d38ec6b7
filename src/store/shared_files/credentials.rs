//! The keys to a bucket from a file, in the form of `~/.aws/credentials`.

use std::fmt;
use std::path::Path;

use crate::store::StoreError;
use crate::store::private::secret_in;

/// The only section that the file may have.
const SECTION: &str = "[default]";

/// The keys to a bucket.
#[derive(Default, PartialEq, Eq)]
pub(super) struct Credentials {
    pub(super) key_id: String,
    pub(super) secret: String,
    pub(super) token: Option<String>,
}

/// Nothing of them is shown.
impl fmt::Debug for Credentials {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Credentials")
    }
}

impl Credentials {
    /// Reads the file.
    ///
    /// # Errors
    /// It cannot be read, others can read it, or it has something else in it.
    pub(super) fn read(path: &Path) -> Result<Self, StoreError> {
        let text = secret_in(path)?;
        Self::parse(&text).map_err(|why| StoreError::Credentials { path: path.to_owned(), why })
    }

    /// Reads `NAME = VALUE`, a pair in a line. The fault quotes nothing.
    fn parse(text: &str) -> Result<Self, String> {
        let mut read = Self::default();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.trim();
            if line.is_empty() || line.starts_with(['#', ';']) || line == SECTION {
                continue;
            }
            let (name, value) =
                line.split_once('=').map(|(name, value)| (name.trim(), value.trim())).unwrap_or_default();
            let value = value.to_owned();
            match name.to_ascii_lowercase().as_str() {
                "aws_access_key_id" => read.key_id = value,
                "aws_secret_access_key" => read.secret = value,
                "aws_session_token" => read.token = Some(value),
                _ => {
                    return Err(format!(
                        "line {number} has another name; write aws_access_key_id = …, aws_secret_access_key = … or aws_session_token = …"
                    ));
                }
            }
        }
        if read.key_id.is_empty() || read.secret.is_empty() {
            return Err("aws_access_key_id or aws_secret_access_key is missing".to_owned());
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_form_of_others_is_read_and_a_fault_quotes_nothing() {
        let of_others = "# the mill\n[default]\naws_access_key_id = AKID\nAWS_SECRET_ACCESS_KEY=s3/cr=et+\n\naws_session_token = t\n";
        let read = Credentials::parse(of_others).unwrap();
        assert_eq!(
            (read.key_id.as_str(), read.secret.as_str(), read.token.as_deref()),
            ("AKID", "s3/cr=et+", Some("t"))
        );
        assert!(!format!("{read:?}").contains("s3/cr"));
        for text in [
            "",
            "aws_access_key_id = AKID",
            "s3cret",
            "[other]\naws_access_key_id = s3cret",
            "region = s3cret",
        ] {
            let fault = Credentials::parse(text).unwrap_err();
            assert!(!fault.contains("s3cret"), "{fault}");
        }
    }
}
