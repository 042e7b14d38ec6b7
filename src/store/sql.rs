//! One text of SQL for both databases. Every statement of the store goes through [`sql!`] (`docs/scale-out.md` describes
//! the rules for a text). `.ci/statements` compiles the store once more for each database, with the texts, arguments and
//! columns checked by the database itself. An ordinary build does not: what the check needs takes longer to build than
//! the rest of the store.
//!
//! Statements that belong to `SQLite` alone (its pragmas, its copies, the examination of a file) are in
//! `database_file.rs`, `deep.rs` and `sqlite.rs`, and name `SQLite`'s types.

use sqlx::Column;
use sqlx::sqlite::SqliteConnection;

use super::readers::Readers;

#[cfg(feature = "scale-out")]
pub(super) use {
    super::instance::Instance,
    super::postgres::{PgReaders, PgWriter},
    super::shared_files::SharedFiles,
    sqlx::postgres::PgConnection,
};

/// Stands in the place of PostgreSQL's types in a binary without them: no value of it exists.
#[cfg(not(feature = "scale-out"))]
pub(super) use std::convert::{
    Infallible as Instance, Infallible as PgConnection, Infallible as PgReaders, Infallible as PgWriter,
    Infallible as SharedFiles,
};

/// One of the two databases.
#[derive(Debug, Clone)]
pub(super) enum On<S, P> {
    /// `SQLite`.
    Sqlite(S),
    /// PostgreSQL.
    #[cfg_attr(not(feature = "scale-out"), expect(dead_code, reason = "no value of this type exists"))]
    Postgres(P),
}

/// The connections that only read.
#[derive(Debug, Clone)]
pub(super) struct Db(pub(super) On<Readers, PgReaders>);

impl Db {
    /// The database, as [`sql!`] uses it.
    pub(super) fn on(&self) -> On<&Readers, &PgReaders> {
        match &self.0 {
            On::Sqlite(readers) => On::Sqlite(readers),
            On::Postgres(readers) => On::Postgres(readers),
        }
    }
}

/// A transaction that writes.
#[derive(Debug)]
pub(super) struct Tx<'c>(pub(super) On<&'c mut SqliteConnection, &'c mut PgConnection>);

impl Tx<'_> {
    /// The database, as [`sql!`] uses it.
    pub(super) fn on(&mut self) -> On<&mut SqliteConnection, &mut PgConnection> {
        match &mut self.0 {
            On::Sqlite(connection) => On::Sqlite(connection),
            On::Postgres(connection) => On::Postgres(connection),
        }
    }
}

/// Runs a statement on a [`Db`] or in a [`Tx`]: `execute` answers the number of rows, and `one`, `optional` and `all`
/// answer rows of a type, or single values for `_`. A text may be joined from several with `+`. Where the databases
/// need different texts, there are two: `sqlite "…", postgres "…"`, with arguments of their own in brackets if these
/// differ too. A statement that only a server needs is `postgres "…"`: on `SQLite` it finds and changes nothing.
macro_rules! sql {
    ($on:expr, $how:ident $(($row:tt))?, sqlite $lite:literal, postgres $pg:literal $(, $arg:expr)* $(,)?) => {
        match $on.on() {
            $crate::store::sql::On::Sqlite(on) => sqlite!(on, $how $(($row))?, $lite $(, $arg)*),
            $crate::store::sql::On::Postgres(on) => postgres!(on, $how $(($row))?, $pg $(, $arg)*),
        }
    };
    ($on:expr, $how:ident $(($row:tt))?, sqlite $lite:literal [$($own:expr),* $(,)?],
        postgres $pg:literal [$($arg:expr),* $(,)?] $(,)?) => {
        match $on.on() {
            $crate::store::sql::On::Sqlite(on) => {
                $(let _ = &$arg;)*
                sqlite!(on, $how $(($row))?, $lite $(, $own)*)
            }
            $crate::store::sql::On::Postgres(on) => postgres!(on, $how $(($row))?, $pg $(, $arg)*),
        }
    };
    ($on:expr, $how:ident $(($row:tt))?, postgres $pg:literal $(, $arg:expr)* $(,)?) => {
        match $on.on() {
            $crate::store::sql::On::Sqlite(_) => {
                $(let _ = &$arg;)*
                std::future::ready(Ok::<_, sqlx::Error>(Default::default())).await
            }
            $crate::store::sql::On::Postgres(on) => postgres!(on, $how $(($row))?, $pg $(, $arg)*),
        }
    };
    ($on:expr, $how:ident $(($row:tt))?, $text:tt $(+ $more:tt)* $(, $arg:expr)* $(,)?) => {
        match $on.on() {
            $crate::store::sql::On::Sqlite(on) => sqlite!(on, $how $(($row))?, $text $(+ $more)* $(, $arg)*),
            $crate::store::sql::On::Postgres(on) => postgres!(on, $how $(($row))?, $text $(+ $more)* $(, $arg)*),
        }
    };
}

/// The statement on `SQLite`.
#[cfg(not(check_postgres))]
macro_rules! sqlite { ($($all:tt)*) => { checked!($($all)*) }; }
/// Nothing: only the statements on PostgreSQL are checked.
#[cfg(check_postgres)]
macro_rules! sqlite { ($($all:tt)*) => { skipped!($($all)*) }; }

/// The statement on PostgreSQL.
#[cfg(all(feature = "scale-out", not(check_sqlite)))]
macro_rules! postgres { ($($all:tt)*) => { checked!($($all)*) }; }
/// Nothing: only the statements on `SQLite` are checked.
#[cfg(all(feature = "scale-out", check_sqlite))]
macro_rules! postgres { ($($all:tt)*) => { skipped!($($all)*) }; }
/// Never: a binary without PostgreSQL has no such connection.
#[cfg(not(feature = "scale-out"))]
macro_rules! postgres {
    ($on:expr, $($all:tt)*) => {
        match *$on {}
    };
}

/// A statement as the service runs it.
#[cfg(not(any(check_sqlite, check_postgres)))]
macro_rules! checked {
    ($on:expr, execute, $text:tt $(+ $more:tt)* $(, $arg:expr)*) => {
        sqlx::query(concat!($text $(, $more)*))$(.bind(&$arg))*.execute($on).await.map(|done| done.rows_affected())
    };
    ($on:expr, one(_), $text:tt $(+ $more:tt)* $(, $arg:expr)*) => {
        sqlx::query_scalar(concat!($text $(, $more)*))$(.bind(&$arg))*.fetch_one($on).await
    };
    ($on:expr, optional(_), $text:tt $(+ $more:tt)* $(, $arg:expr)*) => {
        sqlx::query_scalar(concat!($text $(, $more)*))$(.bind(&$arg))*.fetch_optional($on).await
    };
    ($on:expr, all(_), $text:tt $(+ $more:tt)* $(, $arg:expr)*) => {
        sqlx::query_scalar(concat!($text $(, $more)*))$(.bind(&$arg))*.fetch_all($on).await
    };
    ($on:expr, one($row:ident), $text:tt $(+ $more:tt)* $(, $arg:expr)*) => {
        sqlx::query_as::<_, $row>(concat!($text $(, $more)*))$(.bind(&$arg))*.fetch_one($on).await
    };
    ($on:expr, optional($row:ident), $text:tt $(+ $more:tt)* $(, $arg:expr)*) => {
        sqlx::query_as::<_, $row>(concat!($text $(, $more)*))$(.bind(&$arg))*.fetch_optional($on).await
    };
    ($on:expr, all($row:ident), $text:tt $(+ $more:tt)* $(, $arg:expr)*) => {
        sqlx::query_as::<_, $row>(concat!($text $(, $more)*))$(.bind(&$arg))*.fetch_all($on).await
    };
}

/// A statement that a database checks while it is compiled: its text, its arguments, and the types of its columns.
#[cfg(any(check_sqlite, check_postgres))]
macro_rules! checked {
    ($on:expr, execute, $($query:tt)*) => {
        sqlx::query!($($query)*).execute($on).await.map(|done| done.rows_affected())
    };
    ($on:expr, one(_), $($query:tt)*) => { sqlx::query_scalar!($($query)*).fetch_one($on).await };
    ($on:expr, optional(_), $($query:tt)*) => { sqlx::query_scalar!($($query)*).fetch_optional($on).await };
    ($on:expr, all(_), $($query:tt)*) => { sqlx::query_scalar!($($query)*).fetch_all($on).await };
    ($on:expr, one($row:ident), $($query:tt)*) => { sqlx::query_as!($row, $($query)*).fetch_one($on).await };
    ($on:expr, optional($row:ident), $($query:tt)*) => {
        sqlx::query_as!($row, $($query)*).fetch_optional($on).await
    };
    ($on:expr, all($row:ident), $($query:tt)*) => { sqlx::query_as!($row, $($query)*).fetch_all($on).await };
}

/// Declares a row of [`sql!`]. Its members are read from the columns with their names.
macro_rules! row {
    ($(#[$of_row:meta])* $visible:vis struct $row:ident {
        $($(#[$of_member:meta])* $shown:vis $member:ident: $kind:ty),+ $(,)?
    }) => {
        $(#[$of_row])*
        $visible struct $row {
            $($(#[$of_member])* $shown $member: $kind),+
        }

        impl sqlx::FromRow<'_, sqlx::sqlite::SqliteRow> for $row {
            fn from_row(row: &sqlx::sqlite::SqliteRow) -> Result<Self, sqlx::Error> {
                Ok(Self { $($member: $crate::store::sql::column(row, stringify!($member))?),+ })
            }
        }

        #[cfg(feature = "scale-out")]
        impl sqlx::FromRow<'_, sqlx::postgres::PgRow> for $row {
            fn from_row(row: &sqlx::postgres::PgRow) -> Result<Self, sqlx::Error> {
                Ok(Self { $($member: $crate::store::sql::column(row, stringify!($member))?),+ })
            }
        }
    };
}

/// The value of a column. In the text of a statement its name may end in marks for the check (`count!`, `due_days?: _`).
pub(super) fn column<'r, R, T>(row: &'r R, name: &str) -> Result<T, sqlx::Error>
where
    R: sqlx::Row,
    T: sqlx::Decode<'r, R::Database> + sqlx::Type<R::Database>,
    usize: sqlx::ColumnIndex<R>,
{
    let is_named = |column: &<R::Database as sqlx::Database>::Column| {
        column.name().split(['!', '?', ':']).next() == Some(name)
    };
    let index = row.columns().iter().position(is_named);
    row.try_get(index.ok_or_else(|| sqlx::Error::ColumnNotFound(name.to_owned()))?)
}

/// In the place of a statement while those of the other database are checked.
#[cfg(any(check_sqlite, check_postgres))]
macro_rules! skipped {
    ($on:expr, execute, $($query:tt)*) => {{
        drop($on);
        Err::<u64, _>(sqlx::Error::WorkerCrashed)
    }};
    ($on:expr, $how:ident($row:tt), $($query:tt)*) => {{
        drop($on);
        Err(sqlx::Error::WorkerCrashed)
    }};
}
