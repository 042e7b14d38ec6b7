//! The errors of calibration runs as rows of their own, so that a trend can read them without opening every document.

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

/// The runs whose rows contradict their document, in words. A document that cannot be read is left out: its digest
/// shows the damage.
///
/// # Errors
/// The database failed.
pub(super) async fn contradictions(
    connection: &mut SqliteConnection,
    pace: &Pace,
) -> Result<Vec<String>, sqlx::Error> {
    let (mut after, mut expected, mut all_are_read, mut found) = (0, 0, true, Vec::new());
    // One document at a time: they may be long.
    while let Some((seq, text)) = sqlx::query_as::<_, (i64, String)>(
        "SELECT seq, document FROM calibrations WHERE seq > ? ORDER BY seq LIMIT 1",
    )
    .bind(after)
    .fetch_optional(&mut *connection)
    .await?
    {
        after = seq;
        pace.spend(text.len() as u64).await;
        if pace.is_over() {
            return Ok(found);
        }
        let Ok(document) = serde_json::from_str::<CalibrationDocument>(&text) else {
            all_are_read = false;
            continue;
        };
        let mut differs = false;
        for row in error_rows(&document) {
            differs |= stored(connection, &document, seq, &row).await?.as_ref() != Some(&row);
            expected += 1;
        }
        if differs {
            found.push(format!("the error rows of calibration {} contradict its document", document.id));
        }
    }
    let rows: i64 =
        sqlx::query_scalar("SELECT COUNT(*) FROM calibration_errors").fetch_one(connection).await?;
    if all_are_read && rows > expected {
        found.push(format!("trends read {rows} errors, but the calibrations have {expected}"));
    }
    Ok(found)
}

/// The row of a trend for this error of a run.
async fn stored(
    connection: &mut SqliteConnection,
    document: &CalibrationDocument,
    seq: i64,
    row: &ErrorRow,
) -> Result<Option<ErrorRow>, sqlx::Error> {
    let found: Option<(f64, Option<f64>, bool)> = sqlx::query_as(
        "SELECT value, standard_uncertainty, identifiable FROM calibration_errors
         WHERE machine_id = ? AND axis = ? AND error = ? AND measured_at = ? AND calibration_seq = ?
             AND calibration_id = ? AND machine_revision = ?",
    )
    .bind(&document.machine_id)
    .bind(&row.axis)
    .bind(&row.error)
    .bind(&document.measured_at)
    .bind(seq)
    .bind(&document.id)
    .bind(document.machine_revision)
    .fetch_optional(connection)
    .await?;
    Ok(found.map(|(value, standard_uncertainty, identifiable)| ErrorRow {
        value,
        standard_uncertainty,
        identifiable,
        ..row.clone()
    }))
}
