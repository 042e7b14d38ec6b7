//! Where programs and results are kept.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// How the place of objects begins.
const SCHEME: &str = "s3://";
/// Shortest and longest name of a bucket, <https://docs.aws.amazon.com/AmazonS3/latest/userguide/bucketnamingrules.html>.
const BUCKET_CHARACTERS: std::ops::RangeInclusive<usize> = 3..=63;
/// Longest prefix \[characters\]: the key of an object has at most 1024 with what is added to it.
const MAX_PREFIX: usize = 512;

/// Where programs and results are kept.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum FilesIn {
    /// In the data directory.
    Directory,
    /// In rows of the database.
    Postgres,
    /// As objects in a bucket.
    Objects(Bucket),
}

/// A bucket of S3, and what the keys of all objects in it begin with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bucket {
    name: String,
    /// It neither begins nor ends with a slash. Without a prefix it is empty.
    prefix: String,
}

/// The setting names no place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "write directory, postgres or s3://BUCKET/PREFIX. A bucket has 3 to 63 characters of a-z 0-9 . -, and a \
     prefix has A-Z a-z 0-9 . _ - between single slashes"
)]
pub struct NoPlace;

impl FilesIn {
    /// Whether several services can have the files together: the data directory then has copies.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        *self != Self::Directory
    }
}

/// The word of the setting.
impl fmt::Display for FilesIn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Directory => f.write_str("directory"),
            Self::Postgres => f.write_str("postgres"),
            Self::Objects(bucket) => bucket.fmt(f),
        }
    }
}

impl FromStr for FilesIn {
    type Err = NoPlace;

    fn from_str(text: &str) -> Result<Self, NoPlace> {
        match text {
            "directory" => Ok(Self::Directory),
            "postgres" => Ok(Self::Postgres),
            _ => text.strip_prefix(SCHEME).ok_or(NoPlace)?.parse().map(Self::Objects),
        }
    }
}

impl TryFrom<String> for FilesIn {
    type Error = NoPlace;

    fn try_from(text: String) -> Result<Self, NoPlace> {
        text.parse()
    }
}

impl From<FilesIn> for String {
    fn from(place: FilesIn) -> Self {
        place.to_string()
    }
}

impl Bucket {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What all keys begin with; empty if there is nothing of the kind.
    #[must_use]
    pub fn prefix(&self) -> &str {
        &self.prefix
    }
}

/// `s3://BUCKET/PREFIX`.
impl fmt::Display for Bucket {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let slash = if self.prefix.is_empty() { "" } else { "/" };
        write!(f, "{SCHEME}{}{slash}{}", self.name, self.prefix)
    }
}

/// Reads `BUCKET/PREFIX`. One slash at the end changes nothing.
impl FromStr for Bucket {
    type Err = NoPlace;

    fn from_str(text: &str) -> Result<Self, NoPlace> {
        let text = text.strip_suffix('/').unwrap_or(text);
        let (name, prefix) = text.split_once('/').map_or((text, None), |(name, prefix)| (name, Some(prefix)));
        let ends =
            |end: Option<char>| end.is_some_and(|end| end.is_ascii_lowercase() || end.is_ascii_digit());
        let is_name = BUCKET_CHARACTERS.contains(&name.len())
            && name
                .bytes()
                .all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit() || b".-".contains(&byte))
            && ends(name.chars().next())
            && ends(name.chars().last())
            && !name.contains("..");
        let is_step = |step: &str| {
            !matches!(step, "" | "." | "..")
                && step.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"._-".contains(&byte))
        };
        let is_prefix =
            prefix.is_none_or(|prefix| prefix.len() <= MAX_PREFIX && prefix.split('/').all(is_step));
        if !is_name || !is_prefix {
            return Err(NoPlace);
        }
        Ok(Self { name: name.to_owned(), prefix: prefix.unwrap_or_default().to_owned() })
    }
}

/// What is wrong with the address of a server of objects, without a word of it; `None` if it can be used.
#[must_use]
pub(super) fn endpoint_fault(text: &str) -> Option<&'static str> {
    let Some(rest) = ["https://", "http://"].into_iter().find_map(|scheme| text.strip_prefix(scheme)) else {
        return Some("it does not begin with https:// or http://");
    };
    if rest.contains('@') {
        return Some("it contains a user or a password, which belong in files_credentials_file");
    }
    let is_host = |byte: u8| byte.is_ascii_alphanumeric() || b".-_:[]".contains(&byte);
    let host = rest.strip_suffix('/').unwrap_or(rest);
    (host.is_empty() || !host.bytes().all(is_host)).then_some("it is not https://HOST:PORT")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_read_in_one_way_and_shown_in_one_way() {
        for (text, shown) in [
            ("directory", "directory"),
            ("postgres", "postgres"),
            ("s3://plant", "s3://plant"),
            ("s3://plant/", "s3://plant"),
            ("s3://plant.north-1/shop/Mill_2", "s3://plant.north-1/shop/Mill_2"),
            ("s3://plant/shop/", "s3://plant/shop"),
        ] {
            let place: FilesIn = text.parse().unwrap();
            assert_eq!(place.to_string(), shown);
            assert_eq!(shown.parse(), Ok(place));
        }
        for text in [
            "",
            "Directory",
            "s3",
            "s3://",
            "s3://ab",
            "s3:///shop",
            "s3://Plant",
            "s3://-plant",
            "s3://plant-",
            "s3://pl..ant",
            "s3://plant//shop",
            "s3://plant/shop//",
            "s3://plant/../other",
            "s3://plant/a b",
            "s3://plant/%2e",
            "s3://key:secret@plant",
            "s3://plant/shop?x",
            "gs://plant",
        ] {
            assert_eq!(text.parse::<FilesIn>(), Err(NoPlace), "{text}");
        }
    }

    #[test]
    fn an_endpoint_is_a_host_and_no_secret() {
        for text in ["https://s3.plant.example", "http://127.0.0.1:9000", "http://[::1]:9000/"] {
            assert_eq!(endpoint_fault(text), None, "{text}");
        }
        for text in
            ["", "s3.plant.example", "https://", "http://key:secret@s3.plant", "https://s3.plant/bucket"]
        {
            let fault = endpoint_fault(text).unwrap();
            assert!(!fault.contains("secret@"), "{fault}");
        }
    }
}
