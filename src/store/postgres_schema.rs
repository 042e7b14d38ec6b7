//! Compares the schema of a database on a server with the one that the migrations make. They make it once more, in a
//! transaction that is rolled back.

use std::collections::{BTreeMap, BTreeSet};

use sqlx::{AssertSqlSafe, Connection, Error, Executor, PgConnection};

use super::migrations::of_postgres;
use super::postgres_form::own_form;
use super::postgres_rows::WITHOUT_LIMITS;

/// Everything in the present schema: its table (empty for functions), its kind, its name, and its definition without
/// the name of the schema. The table of the migrations is left out, and so is what belongs to an extension.
const EVERYTHING: &str = "
    WITH here AS (SELECT oid, quote_ident(nspname) || '.' AS prefix FROM pg_namespace WHERE nspname = current_schema()),
         tables AS (SELECT c.oid, c.relname FROM pg_class c JOIN here ON c.relnamespace = here.oid
                    WHERE c.relkind IN ('r', 'p') AND c.relname <> '_sqlx_migrations'),
         all_of_it AS (
            SELECT relname AS of, 'table' AS kind, relname AS name, (
                SELECT string_agg(concat_ws(' ', a.attname, format_type(a.atttypid, a.atttypmod), o.collname, a.attnotnull,
                    a.attidentity, pg_get_expr(d.adbin, d.adrelid)), ', ' ORDER BY a.attname)
                FROM pg_attribute a LEFT JOIN pg_collation o ON o.oid = a.attcollation
                LEFT JOIN pg_attrdef d ON d.adrelid = a.attrelid AND d.adnum = a.attnum
                WHERE a.attrelid = tables.oid AND a.attnum > 0 AND NOT a.attisdropped) AS definition
            FROM tables
            UNION ALL SELECT relname, 'constraint', conname, pg_get_constraintdef(c.oid) || ' ' || c.convalidated
            FROM pg_constraint c JOIN tables ON tables.oid = c.conrelid
            UNION ALL SELECT relname, 'index', i.indexrelid::regclass::text, pg_get_indexdef(i.indexrelid) || ' ' || i.indisvalid
            FROM pg_index i JOIN tables ON tables.oid = i.indrelid
            UNION ALL SELECT relname, 'trigger', t.tgname, pg_get_triggerdef(t.oid) || ' ' || CAST(t.tgenabled AS TEXT)
            FROM pg_trigger t JOIN tables ON tables.oid = t.tgrelid WHERE NOT t.tgisinternal
            UNION ALL SELECT '', 'function', p.oid::regprocedure::text, pg_get_functiondef(p.oid)
            FROM pg_proc p JOIN here ON p.pronamespace = here.oid
            WHERE p.prokind = 'f' AND NOT EXISTS (SELECT 1 FROM pg_depend e
                WHERE e.classid = 'pg_proc'::regclass AND e.objid = p.oid AND e.deptype = 'e'))
    SELECT of::text, kind, replace(name::text, prefix, ''), replace(definition, prefix, '') FROM all_of_it, here";

/// Table, kind and name of everything, with its definition.
type Schema = BTreeMap<(String, String, String), String>;

async fn schema_of(connection: &mut PgConnection) -> Result<Schema, Error> {
    let rows: Vec<(String, String, String, String)> =
        sqlx::query_as(EVERYTHING).fetch_all(&mut *connection).await?;
    Ok(rows.into_iter().map(|(of, kind, name, text)| ((of, kind, name), text)).collect())
}

/// The differences between the present schema and the one that the migrations up to `version` make, in words; a newer
/// schema cannot be compared. Tables that others keep beside ours are no difference.
///
/// # Errors
/// The server failed, or nobody may make a schema in this database (SQLSTATE 42501, or 25006 on a standby).
pub(super) async fn differences(connection: &mut PgConnection, version: i64) -> Result<Vec<String>, Error> {
    if version > own_form() {
        return Ok(Vec::new());
    }
    let found = schema_of(connection).await?;
    let made = {
        let mut transaction = connection.begin().await?;
        transaction.execute(WITHOUT_LIMITS).await?;
        let name: String =
            sqlx::query_scalar("SELECT 'trunnion_doctor_' || md5(CAST(gen_random_uuid() AS TEXT))")
                .fetch_one(&mut *transaction)
                .await?;
        let text = format!("CREATE SCHEMA {name}; SET LOCAL search_path = {name}");
        sqlx::raw_sql(AssertSqlSafe(text)).execute(&mut *transaction).await?;
        for migration in of_postgres().iter().filter(|migration| migration.version <= version) {
            sqlx::raw_sql(migration.sql.clone()).execute(&mut *transaction).await?;
        }
        let made = schema_of(&mut transaction).await?;
        transaction.rollback().await?;
        made
    };
    let tables: BTreeSet<&String> = made.keys().map(|(of, ..)| of).filter(|of| !of.is_empty()).collect();
    let mut differences = Vec::new();
    for ((of, kind, name), text) in &made {
        match found.get(&(of.clone(), kind.clone(), name.clone())) {
            None => differences.push(format!("the {kind} {name} is missing from the schema")),
            Some(other) if other != text => {
                differences.push(format!("the {kind} {name} differs from the one that the migrations make"));
            }
            Some(_) => {}
        }
    }
    let more = found.keys().filter(|key| !made.contains_key(*key) && tables.contains(&key.0));
    differences.extend(more.map(|(of, kind, name)| format!("no migration makes the {kind} {name} of {of}")));
    Ok(differences)
}
