//! Calibration runs as a table.

use std::collections::BTreeSet;

use super::table_text::table_text;
use super::{CalibrationDocument, Estimate};

/// Columns that every table of runs has.
const COLUMNS: [&str; 15] = [
    "id",
    "measured_at",
    "created_at",
    "machine_id",
    "machine_revision",
    "kind",
    "instrument",
    "instrument_serial_number",
    "operator",
    "temperature_c",
    "rank",
    "unknowns",
    "degrees_of_freedom",
    "residual_rms_um",
    "unidentifiable",
];

/// The runs, one row each. After the columns that every table has come the errors against the machine's frame that any
/// of these runs has, each with its standard uncertainty.
///
/// # Errors
/// The table cannot be written; this does not happen in memory.
pub fn calibration_table(runs: &[CalibrationDocument]) -> Result<Vec<u8>, csv::Error> {
    let errors: BTreeSet<&str> = runs.iter().flat_map(|run| run.iso_230.keys().map(String::as_str)).collect();
    let mut table = csv::Writer::from_writer(Vec::new());
    let of_errors =
        errors.iter().flat_map(|name| [(*name).to_owned(), format!("standard_uncertainty_{name}")]);
    table.write_record(COLUMNS.map(str::to_owned).into_iter().chain(of_errors))?;
    let text = |text: &Option<String>| text.as_deref().map(table_text).unwrap_or_default().into_owned();
    for run in runs {
        let head = [
            run.id.clone(),
            run.measured_at.clone(),
            run.created_at.clone(),
            run.machine_id.clone(),
            run.machine_revision.to_string(),
            run.kind.as_str().to_owned(),
            text(&run.instrument),
            text(&run.instrument_serial_number),
            text(&run.operator),
            number(run.temperature_c),
            run.rank.to_string(),
            run.unknowns.to_string(),
            run.degrees_of_freedom.to_string(),
            run.residual_rms_um.to_string(),
            run.unidentifiable.join(" "),
        ];
        let values = errors.iter().flat_map(|name| match run.iso_230.get(*name) {
            Some(Estimate { value, standard_uncertainty }) => {
                [value.to_string(), number(*standard_uncertainty)]
            }
            None => [String::new(), String::new()],
        });
        table.write_record(head.into_iter().chain(values))?;
    }
    table.into_inner().map_err(|fault| fault.into_error().into())
}

fn number(value: Option<f64>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}
