//! The errors of calibration runs as rows of their own, so that a trend can read them without opening every document.

use super::pace::Pace;
use super::sql::Tx;
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

row! {
    /// A run as it is stored.
    struct StoredRun {
        seq: i64,
        document: String,
    }
}

row! {
    /// The row of a trend.
    struct StoredError {
        value: f64,
        standard_uncertainty: Option<f64>,
        identifiable: i64,
    }
}

/// The runs whose rows contradict their document, in words. A document that cannot be read is left out: its digest
/// shows the damage.
///
/// # Errors
/// The database failed.
pub(super) async fn contradictions(tx: &mut Tx<'_>, pace: &Pace) -> Result<Vec<String>, sqlx::Error> {
    let (mut after, mut expected, mut all_are_read, mut found) = (0, 0, true, Vec::new());
    // One document at a time: they may be long.
    while let Some(StoredRun { seq, document: text }) = sql!(
        tx,
        optional(StoredRun),
        "SELECT seq, document FROM calibrations WHERE seq > $1 ORDER BY seq LIMIT 1",
        after
    )? {
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
            differs |= stored(tx, &document, seq, &row).await?.as_ref() != Some(&row);
            expected += 1;
        }
        if differs {
            found.push(format!("the error rows of calibration {} contradict its document", document.id));
        }
    }
    let rows: i64 = sql!(tx, one(_), "SELECT COUNT(*) AS \"count!\" FROM calibration_errors")?;
    if all_are_read && rows > expected {
        found.push(format!("trends read {rows} errors, but the calibrations have {expected}"));
    }
    Ok(found)
}

/// The row of a trend for this error of a run.
async fn stored(
    tx: &mut Tx<'_>,
    document: &CalibrationDocument,
    seq: i64,
    row: &ErrorRow,
) -> Result<Option<ErrorRow>, sqlx::Error> {
    let found: Option<StoredError> = sql!(
        tx,
        optional(StoredError),
        "SELECT value, standard_uncertainty, identifiable FROM calibration_errors
         WHERE machine_id = $1 AND axis = $2 AND error = $3 AND measured_at = $4 AND calibration_seq = $5
             AND calibration_id = $6 AND machine_revision = $7",
        document.machine_id,
        row.axis,
        row.error,
        document.measured_at,
        seq,
        document.id,
        document.machine_revision
    )?;
    Ok(found.map(|StoredError { value, standard_uncertainty, identifiable }| ErrorRow {
        value,
        standard_uncertainty,
        identifiable: identifiable != 0,
        ..row.clone()
    }))
}
