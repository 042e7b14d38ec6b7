//! The errors of calibration runs as rows of their own, which a trend reads without opening every document.

use std::collections::BTreeMap;

use sqlx::sqlite::SqliteConnection;

use super::pace::Pace;
use crate::wire::CalibrationDocument;

/// One error of a run, as a trend reads it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ErrorRow {
    pub axis: String,
    pub error: String,
    pub value: f64,
    pub standard_uncertainty: Option<f64>,
    pub identifiable: bool,
}

/// `e_y_um` without its unit.
fn without_unit(name: &str) -> &str {
    name.strip_suffix("_urad").or_else(|| name.strip_suffix("_um")).unwrap_or(name)
}

/// The rows of a run.
pub(super) fn error_rows(document: &CalibrationDocument) -> Vec<ErrorRow> {
    let identifiable = |name: &str| !document.unidentifiable.iter().any(|open| open == name);
    let mut rows = Vec::new();
    for (axis, errors) in &document.errors {
        for (name, estimate) in errors {
            rows.push(ErrorRow {
                axis: axis.clone(),
                error: without_unit(name).to_owned(),
                value: estimate.value,
                standard_uncertainty: estimate.standard_uncertainty,
                identifiable: identifiable(&format!("{axis}.{name}")),
            });
        }
    }
    for (name, estimate) in &document.iso_230 {
        let error = without_unit(name);
        let axis: String = error.chars().last().into_iter().collect();
        rows.push(ErrorRow {
            axis,
            error: error.to_owned(),
            value: estimate.value,
            standard_uncertainty: estimate.standard_uncertainty,
            identifiable: identifiable(name),
        });
    }
    rows
}

/// Runs compared at a time.
const AT_ONCE: i64 = 200;

/// Rows by axis and error: value, standard uncertainty, whether it is identifiable, time and revision.
type Rows = BTreeMap<(String, String), (f64, Option<f64>, bool, String, i64)>;

/// The runs whose rows say something else than their document, in words. A document that cannot be read is left out: its
/// digest tells.
///
/// # Errors
/// The database failed.
pub(super) async fn contradictions(
    connection: &mut SqliteConnection,
    pace: &Pace,
) -> Result<Vec<String>, sqlx::Error> {
    let (mut after, mut found) = (0, Vec::new());
    while !pace.is_over() {
        let runs: Vec<(i64, String)> =
            sqlx::query_as("SELECT seq, document FROM calibrations WHERE seq > ? ORDER BY seq LIMIT ?")
                .bind(after)
                .bind(AT_ONCE)
                .fetch_all(&mut *connection)
                .await?;
        let Some((last, _)) = runs.last() else { break };
        let last = *last;
        let mut stored = stored_rows(connection, after, last).await?;
        for (seq, text) in runs {
            let Ok(document) = serde_json::from_str::<CalibrationDocument>(&text) else { continue };
            let of_document = error_rows(&document).into_iter().map(|row| {
                let ErrorRow { axis, error, value, standard_uncertainty, identifiable } = row;
                let (at, revision) = (document.measured_at.clone(), document.machine_revision);
                ((axis, error), (value, standard_uncertainty, identifiable, at, revision))
            });
            let expected = (document.machine_id.clone(), document.id.clone(), of_document.collect());
            let none = || (expected.0.clone(), expected.1.clone(), Rows::new());
            if stored.remove(&seq).unwrap_or_else(none) != expected {
                let id = &document.id;
                found.push(format!("the errors of calibration {id} are not those of its document"));
            }
        }
        after = last;
    }
    Ok(found)
}

/// The rows of the runs behind `after` and up to `last`, each with machine and run.
async fn stored_rows(
    connection: &mut SqliteConnection,
    after: i64,
    last: i64,
) -> Result<BTreeMap<i64, (String, String, Rows)>, sqlx::Error> {
    type Row = (i64, String, String, String, String, f64, Option<f64>, bool, String, i64);
    let rows: Vec<Row> = sqlx::query_as(
        "SELECT calibration_seq, machine_id, calibration_id, axis, error, value, standard_uncertainty, identifiable,
             measured_at, machine_revision
         FROM calibration_errors WHERE calibration_seq > ? AND calibration_seq <= ?",
    )
    .bind(after)
    .bind(last)
    .fetch_all(connection)
    .await?;
    let mut runs = BTreeMap::new();
    for (seq, machine, id, axis, error, value, uncertainty, identifiable, at, revision) in rows {
        let (of, run, rows) = runs.entry(seq).or_insert_with(|| (machine.clone(), id.clone(), Rows::new()));
        // Two rows of one run that name different machines or runs are never those of a document.
        if *of != machine || *run != id {
            run.clear();
        }
        rows.insert((axis, error), (value, uncertainty, identifiable, at, revision));
    }
    Ok(runs)
}
