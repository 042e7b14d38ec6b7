//! Files as rows of the database, in parts.

use std::fs::File;
use std::io;

use sqlx::postgres::PgPool;
use sqlx::{Connection, Error};

use super::filled;

/// Bytes of a part.
const PART_BYTES: usize = 1 << 20;
/// Parts stored in one transaction.
pub(super) const PARTS_AT_ONCE: i64 = 16;

/// Adds some parts, the first of which has this number.
pub(super) async fn add(pool: &PgPool, object: &str, first: i64, parts: &[Vec<u8>]) -> Result<(), Error> {
    let mut connection = pool.acquire().await?;
    let mut transaction = connection.begin().await?;
    for (number, bytes) in (first..).zip(parts) {
        let bytes = bytes.as_slice();
        let done: Result<u64, Error> = postgres!(
            &mut *transaction,
            execute,
            "INSERT INTO file_parts (object_key, part, bytes) VALUES ($1, $2, $3)",
            object,
            number,
            bytes
        );
        done?;
    }
    transaction.commit().await
}

/// The part with this number.
pub(super) async fn part(pool: &PgPool, object: &str, number: i64) -> Result<Option<Vec<u8>>, Error> {
    let mut connection = pool.acquire().await?;
    let bytes: Result<Option<Vec<u8>>, Error> = postgres!(
        &mut *connection,
        optional(_),
        "SELECT bytes FROM file_parts WHERE object_key = $1 AND part = $2",
        object,
        number
    );
    bytes
}

/// The length of all parts together \[bytes\].
pub(super) async fn length(pool: &PgPool, object: &str) -> Result<i64, Error> {
    let mut connection = pool.acquire().await?;
    let bytes: Result<i64, Error> = postgres!(
        &mut *connection,
        one(_),
        "SELECT CAST(coalesce(sum(length(bytes)), 0) AS BIGINT) AS \"bytes!\" FROM file_parts WHERE object_key = $1",
        object
    );
    bytes
}

/// The parts of a file that one transaction stores, from this one on.
pub(super) fn parts(file: &File, first: i64) -> io::Result<Vec<Vec<u8>>> {
    let mut at = u64::try_from(first).unwrap_or(0) * PART_BYTES as u64;
    let mut parts = Vec::new();
    for _ in 0..PARTS_AT_ONCE {
        let part = filled(file, at, PART_BYTES)?;
        let length = part.len();
        at += length as u64;
        if length > 0 {
            parts.push(part);
        }
        if length < PART_BYTES {
            break;
        }
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_file_are_its_bytes_whatever_its_length() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("file");
        let most = usize::try_from(PARTS_AT_ONCE).unwrap() * PART_BYTES;
        for length in [0, 1, PART_BYTES - 1, PART_BYTES, PART_BYTES + 1, most, most + 1] {
            let bytes: Vec<u8> = (0..=250_u8).cycle().take(length).collect();
            std::fs::write(&path, &bytes).unwrap();
            let (file, mut read, mut first) = (File::open(&path).unwrap(), Vec::new(), 0);
            loop {
                let some = parts(&file, first).unwrap();
                if some.is_empty() {
                    break;
                }
                assert!(some.iter().all(|part| part.len() <= PART_BYTES));
                read.extend(some.concat());
                first += PARTS_AT_ONCE;
            }
            assert!(read == bytes, "{length}");
        }
    }
}
