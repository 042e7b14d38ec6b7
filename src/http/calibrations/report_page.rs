//! A run as a page for people to read and print.

use super::figures::{eccentricities, residuals};
use crate::http::AppState;
use crate::http::problem::Problem;
use crate::plot::light_only;
use crate::store::CalibrationRow;
use crate::wire::{CalibrationDocument, Estimate};

/// The page: the measurement, the results with uncertainties, the errors that are not determined, and the figures.
pub(super) async fn page(app: &AppState, run: CalibrationRow) -> Result<String, Problem> {
    let figures = residuals(app, &run, None).await?;
    let document = run.document;
    let bars = if document.ball_bar.is_some() {
        let drawn = document.clone();
        app.compute.run(move |_stop| eccentricities(&drawn)).await?
    } else {
        String::new()
    };
    let title = format!("Calibration of {}", document.machine_id);
    let cascaded = document.errors.iter().flat_map(|(axis, errors)| {
        errors.iter().map(move |(name, estimate)| (format!("{axis}.{name}"), *estimate))
    });
    let absolute = document.iso_230.iter().map(|(name, estimate)| (name.clone(), *estimate));
    let hidden = document.blind.iter().map(|blind| {
        let remedy = blind.separated_by.as_ref().map(|run| format!("; add {run}")).unwrap_or_default();
        blind.words.clone() + &remedy
    });
    let questions = document.warnings.iter().map(|warning| {
        let test = warning.test.map(|test| format!("Test {test}: ")).unwrap_or_default();
        test + &warning.detail
    });
    let mut parts = vec![
        facts(&document),
        "<h2>Location errors, cascaded as in the profile</h2>".to_owned(),
        estimates(cascaded, &document.unidentifiable),
        "<h2>Location errors against the machine's frame (ISO 230-7)</h2>".to_owned(),
        estimates(absolute, &document.unidentifiable),
        list("Errors that the run cannot separate", hidden),
        list("Questions", questions),
        "<h2>Figures</h2>".to_owned(),
        light_only(&bars),
    ];
    // The page is light on every screen, and so are its figures.
    parts.extend(figures.iter().map(|figure| light_only(figure)));
    let body = parts.join("\n");
    let title = escaped(&title);
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>{title}</title>\n<style>body{{font-family:sans-serif;max-width:1040px;margin:2em auto}}table{{border-collapse:collapse}}td,th{{border:1px solid #ccc;padding:.3em .7em;text-align:left}}td.n{{text-align:right}}</style>\n<h1>{title}</h1>\n{body}</html>\n"
    ))
}

fn facts(document: &CalibrationDocument) -> String {
    let text = |value: &Option<String>| value.clone().unwrap_or_else(|| "not given".to_owned());
    let condition = document
        .condition_number
        .map_or_else(String::new, |number| format!(", condition number {number:.1}"));
    let rows = [
        ("run", document.id.clone()),
        ("machine", format!("{}, revision {}", document.machine_id, document.machine_revision)),
        ("kind", document.kind.as_str().to_owned()),
        ("measured", document.measured_at.clone()),
        ("instrument", text(&document.instrument)),
        ("operator", text(&document.operator)),
        (
            "temperature",
            document.temperature_c.map_or_else(|| "not given".to_owned(), |value| format!("{value} °C")),
        ),
        ("note", text(&document.note)),
        ("SHA-256 of the readings", document.run_sha256.clone()),
        ("determined", format!("{} of {} unknowns{condition}", document.rank, document.unknowns)),
        (
            "residual, rms",
            format!(
                "{:.3} µm with {} degrees of freedom",
                document.residual_rms_um, document.degrees_of_freedom
            ),
        ),
        ("evaluated by", format!("Trunnion {}", document.software_version)),
    ];
    let rows: Vec<String> = rows
        .iter()
        .map(|(name, value)| format!("<tr><th>{name}</th><td>{}</td></tr>", escaped(value)))
        .collect();
    format!("<table>\n{}\n</table>", rows.join("\n"))
}

fn estimates(rows: impl Iterator<Item = (String, Estimate)>, open: &[String]) -> String {
    let rows: Vec<String> = rows
        .map(|(name, Estimate { value, standard_uncertainty })| {
            let sigma =
                standard_uncertainty.map_or_else(|| "unknown".to_owned(), |sigma| format!("{sigma:.3}"));
            let remark = if open.contains(&name) { "not determined by this run alone" } else { "" };
            format!(
                "<tr><td>{name}</td><td class=n>{value:.3}</td><td class=n>{sigma}</td><td>{remark}</td></tr>"
            )
        })
        .collect();
    let head = "<tr><th>error</th><th>value</th><th>standard uncertainty</th><th></th></tr>";
    format!("<table>\n{head}\n{}\n</table>", rows.join("\n"))
}

/// A list under its heading; empty text for an empty list.
fn list(heading: &str, items: impl Iterator<Item = String>) -> String {
    let items: Vec<String> = items.map(|item| format!("<li>{}</li>", escaped(&item))).collect();
    if items.is_empty() {
        return String::new();
    }
    format!("<h2>{heading}</h2>\n<ul>\n{}\n</ul>", items.join("\n"))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
