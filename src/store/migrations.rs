//! The migrations of both databases, which make the schema of this version. `build.rs` puts the files of `migrations`
//! and `migrations-postgres` into the binary.

use sqlx::SqlSafeStr;
use sqlx::migrate::{Migration, MigrationType, Migrator};

/// The files for `SQLite`: name without its ending, and text.
const OF_SQLITE: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/migrations.rs"));
/// The files for PostgreSQL.
#[cfg(feature = "scale-out")]
const OF_POSTGRES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/migrations-postgres.rs"));

/// The migrations of `SQLite`.
pub(super) fn of_sqlite() -> Migrator {
    migrator(OF_SQLITE)
}

/// The migrations of PostgreSQL.
#[cfg(feature = "scale-out")]
pub(super) fn of_postgres() -> Migrator {
    migrator(OF_POSTGRES)
}

/// The newest schema that migrations make: the number of the last one.
pub(super) fn newest(migrator: &Migrator) -> i64 {
    migrator.iter().map(|migration| migration.version).max().unwrap_or_default()
}

fn migrator(files: &'static [(&str, &str)]) -> Migrator {
    let migrations = files.iter().filter_map(|(name, text)| {
        let (version, description) = name.split_once('_')?;
        let description = description.replace('_', " ").into();
        let text = text.into_sql_str();
        Some(Migration::new(version.parse().ok()?, description, MigrationType::Simple, text, false))
    });
    Migrator::with_migrations(migrations.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_a_migration() {
        let of = |folder: &str| {
            std::fs::read_dir(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).unwrap().count()
        };
        assert_eq!(of_sqlite().iter().count(), of("migrations"));
        #[cfg(feature = "scale-out")]
        assert_eq!(of_postgres().iter().count(), of("migrations-postgres"));
        let first = of_sqlite().iter().next().map(|first| (first.version, first.description.clone()));
        assert_eq!(first, Some((20_260_101_000_000, "first light".into())));
    }
}
