//! The set-up of a run in a report: machine, instrument, tests, and what the run cannot separate.

use super::report_markup::{escaped, facts, given, list, number, table};
use crate::wire::{
    BallBarTestDoc, CalibrationDocument, CalibrationKind, CalibrationRequest, Fixed, MachineProfile,
    SetupErrorAnswer, SetupErrorSource, SphereAxisAnswer,
};

const NOT_STATED: &str = "not stated";

fn stated(text: Option<&str>) -> String {
    text.map_or_else(|| NOT_STATED.to_owned(), escaped)
}

/// Machine and instrument, who measured and when. The names of the machine come from `profile`, its `revision`.
pub(super) fn identity(document: &CalibrationDocument, profile: &MachineProfile, revision: i64) -> String {
    let machine = [
        ("Machine", escaped(&profile.name)),
        ("Serial number", stated(profile.serial_number.as_deref())),
        ("Asset id", stated(profile.asset_id.as_deref())),
        ("Id", escaped(&document.machine_id)),
        ("Measured revision", document.machine_revision.to_string()),
        ("Names from revision", revision.to_string()),
    ];
    let instrument = [
        ("Instrument", stated(document.instrument.as_deref())),
        ("Serial number", stated(document.instrument_serial_number.as_deref())),
        ("Certificate", stated(document.instrument_certificate.as_deref())),
        ("Measured", time(&document.measured_at)),
        ("Measured by", stated(document.operator.as_deref())),
        ("Temperature", temperature(document.temperature_c)),
    ];
    format!("<div class=pair>\n{}\n{}\n</div>", facts(&machine), facts(&instrument))
}

fn temperature(temperature_c: Option<f64>) -> String {
    match temperature_c {
        Some(celsius) => format!("{} °C (values are not corrected to 20 °C)", given(celsius)),
        None => NOT_STATED.to_owned(),
    }
}

/// A stored time as people read it.
pub(super) fn time(text: &str) -> String {
    let (day, clock) = text.split_once('T').unwrap_or((text, ""));
    format!("{} {} UTC", escaped(day), escaped(clock.get(..5).unwrap_or(clock)))
}

/// The measurement: how it was set up, and what was evaluated.
pub(super) fn setup(document: &CalibrationDocument, request: &CalibrationRequest) -> String {
    let method = match document.kind {
        CalibrationKind::RtcpBallbar => "ball bar while RTCP holds the spindle ball (ISO 230-7, ISO 10791-6)",
        CalibrationKind::RotarySphere => "centres of spheres on the table, probed at several angles",
    };
    let mut rows = vec![("Method", method.to_owned())];
    if let Some(found) = &document.ball_bar {
        rows.push(("Bar length", request.bar_length_mm.map_or_else(String::new, |mm| given(mm) + " mm")));
        let zero = if request.offset_per_test.unwrap_or(true) {
            "arbitrary: one offset for each test is fitted"
        } else {
            "known: no offset is fitted"
        };
        rows.push(("Zero of the bar", zero.to_owned()));
        rows.push(("Set-up error", setup_error(&found.setup_error_um)));
    }
    let condition = document
        .condition_number
        .map_or_else(String::new, |number| format!(", condition number {number:.1}"));
    rows.extend([
        ("Determined", format!("{} of {} unknowns{condition}", document.rank, document.unknowns)),
        (
            "Residuals",
            format!(
                "{} µm rms, {} degrees of freedom",
                number(document.residual_rms_um, 3),
                document.degrees_of_freedom
            ),
        ),
        ("Note", stated(document.note.as_deref())),
        ("Evaluated by", format!("Trunnion {}", escaped(&document.software_version))),
        ("Run", format!("<code>{}</code>", escaped(&document.id))),
        ("SHA-256 of the readings", format!("<code>{}</code>", escaped(&document.run_sha256))),
    ]);
    let measured = match &document.axes {
        Some(axes) => spheres(axes),
        None => tests(document, request),
    };
    format!("{}\n{measured}", facts(&rows))
}

fn setup_error(found: &SetupErrorAnswer) -> String {
    let source = match found.source {
        SetupErrorSource::Given => "given with the run",
        SetupErrorSource::Measured => "measured with a spindle step",
        SetupErrorSource::HeldAtZero => return "not known, held at zero".to_owned(),
    };
    let [x, y] = [found.e_xs.value, found.e_ys.value].map(|value| number(value, 2));
    format!("<i>e</i><sub>xs</sub> = {x} µm, <i>e</i><sub>ys</sub> = {y} µm, {source}")
}

fn place(place_mm: &Fixed<3>) -> String {
    place_mm.0.map(given).join(", ")
}

/// One row for each test of a ball bar.
fn tests(document: &CalibrationDocument, request: &CalibrationRequest) -> String {
    let Some(found) = &document.ball_bar else { return String::new() };
    let posted = request.tests.iter().flatten().zip(&found.tests).enumerate();
    let rows: Vec<Vec<String>> = posted
        .map(|(index, (test, answer))| {
            let left_out = found.outliers.iter().filter(|outlier| outlier.test == index).count();
            let weight = test.reading_uncertainty_um.map_or_else(|| "–".to_owned(), given);
            vec![
                index.to_string(),
                escaped(&test.rotary_axis),
                test.bar_direction.as_str().to_owned(),
                place(&test.ball_mm),
                given(test.tool_length_mm.unwrap_or(0.0)),
                readings(test),
                weight,
                number(answer.residual_rms_um, 2),
                left_out.to_string(),
            ]
        })
        .collect();
    let columns = [
        "test",
        "axis",
        "bar",
        "ball x, y, z [mm]",
        "tool [mm]",
        "readings",
        "<i>u</i> of a reading [µm]",
        "residual rms [µm]",
        "left out",
    ];
    let note = format!(
        "<p>The ball is the programmed spindle ball at zero, from the reference point of the table axis next to the \
         workpiece. All readings: <code>/v1/machines/{}/calibrations/{}/run</code>.</p>",
        escaped(&document.machine_id),
        escaped(&document.id)
    );
    table("tests", &columns, 3, &rows) + &note
}

/// The number of readings and their angles.
fn readings(test: &BallBarTestDoc) -> String {
    let Some(readings) = &test.readings else { return "eccentricities".to_owned() };
    let angles = readings.iter().map(|reading| reading.angle_deg);
    let (least, most) = angles
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), angle| (angle.min(least), angle.max(most)));
    format!("{}, {} … {}°", readings.len(), given(least), given(most))
}

/// One row for each axis of probed spheres.
fn spheres(axes: &[SphereAxisAnswer]) -> String {
    let rows: Vec<Vec<String>> = axes
        .iter()
        .map(|axis| {
            let circles: Vec<String> =
                axis.spheres.iter().map(|circle| number(circle.radius_mm, 3)).collect();
            let suspicious = axis.outliers.iter().map(|outlier| outlier.centre.to_string());
            let suspicious: Vec<String> = suspicious.collect();
            vec![
                escaped(&axis.rotary_axis),
                axis.centres.to_string(),
                circles.join(", "),
                number(axis.axial_rms_um, 2),
                number(axis.radial_rms_um, 2),
                axis.tangential_rms_um.map_or_else(|| "–".to_owned(), |um| number(um, 2)),
                if suspicious.is_empty() { "–".to_owned() } else { suspicious.join(", ") },
            ]
        })
        .collect();
    let columns = [
        "axis",
        "centres",
        "radii [mm]",
        "axial rms [µm]",
        "radial rms [µm]",
        "tangential rms [µm]",
        "centres to check",
    ];
    table("spheres", &columns, 1, &rows)
}

/// The errors that the run cannot separate, each with the run to add.
pub(super) fn inseparable(document: &CalibrationDocument) -> String {
    let blind = document.blind.iter().map(|blind| {
        let remedy =
            blind.separated_by.as_ref().map(|run| format!(" To separate them, add {}.", escaped(run)));
        format!("{}.{}", escaped(&blind.words), remedy.unwrap_or_default())
    });
    let text = list(blind);
    if text.is_empty() { "<p>Nothing: the run determines all its unknowns.</p>".to_owned() } else { text }
}

/// The points that a metrologist should check.
pub(super) fn questions(document: &CalibrationDocument) -> String {
    list(document.warnings.iter().map(|warning| {
        let test = warning.test.map(|test| format!("Test {test}: ")).unwrap_or_default();
        test + &escaped(&warning.detail)
    }))
}
