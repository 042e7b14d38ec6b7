//! The schema of a database on a server, and which versions may use it. Services of two versions run beside each other
//! while a plant is updated, so a schema says how old a service may be (`docs/scale-out.md`).

use sqlx::postgres::PgConnection;
use sqlx::{Error, Executor};

use super::StoreError;
use super::error::Doing;
use super::migrations::{newest, of_postgres};

/// The newest schema of a database.
const SCHEMA: &str = "SELECT MAX(version) FROM _sqlx_migrations WHERE success";
const HAS_SCHEMA: &str = "SELECT to_regclass('_sqlx_migrations') IS NOT NULL";
/// The oldest schema that a service must know; nothing where an earlier version has made the database.
const USABLE_FROM: &str = "SELECT CAST(to_jsonb(s) ->> 'usable_from' AS BIGINT) FROM service s";

/// The newest schema of this version on PostgreSQL.
pub(super) fn own_form() -> i64 {
    newest(&of_postgres())
}

/// The newest schema that a migration has made; `None` if no migration has run.
///
/// # Errors
/// The database failed.
pub(super) async fn schema(session: &mut PgConnection) -> Result<Option<i64>, StoreError> {
    let doing = "asking for the schema of the database";
    if !sqlx::query_scalar::<_, bool>(HAS_SCHEMA).fetch_one(&mut *session).await.doing(doing)? {
        return Ok(None);
    }
    sqlx::query_scalar(SCHEMA).fetch_one(session).await.doing(doing)
}

/// The oldest schema that a service must know to use the database; `None` where an earlier version has made it.
///
/// # Errors
/// The database failed.
pub(super) async fn usable_from(session: &mut PgConnection) -> Result<Option<i64>, Error> {
    sqlx::query_scalar(USABLE_FROM).fetch_one(session).await
}

/// Refuses a database that a newer version has made, unless that says that this one may use it.
///
/// # Errors
/// It does not, or the database failed.
pub(super) async fn accept_newer(session: &mut PgConnection, found: i64) -> Result<(), StoreError> {
    let (ours, doing) = (own_form(), "asking which versions may use the database");
    match usable_from(session).await.doing(doing)? {
        Some(usable_from) if usable_from <= ours => Ok(()),
        Some(usable_from) => Err(StoreError::NotUsable { found, usable_from, ours }),
        None => Err(StoreError::Newer { found, ours }),
    }
}

/// Updates the database to the newest form. One that a newer version has made stays as it is.
///
/// # Errors
/// A newer version has made it, and this one may not use it; or a migration failed.
pub(super) async fn migrate(session: &mut PgConnection) -> Result<(), StoreError> {
    let ours = own_form();
    match schema(session).await? {
        Some(found) if found == ours => return Ok(()),
        Some(found) if found > ours => {
            accept_newer(session, found).await?;
            tracing::warn!(
                schema = found,
                known = ours,
                "a newer version has updated the database, and this one may use it"
            );
            return Ok(());
        }
        _ => {}
    }
    let doing = "setting how long a migration may take";
    session.execute("SET statement_timeout = 0").await.doing(doing)?;
    // The lock of the service is enough: another one would make plants that share a database wait for each other.
    of_postgres().set_locking(false).run(&mut *session).await?;
    session.execute("RESET statement_timeout").await.doing(doing)?;
    Ok(())
}
