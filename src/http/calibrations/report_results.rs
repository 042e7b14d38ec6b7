//! The results of a report: values with expanded uncertainty, limit and verdict, and the uncertainty budget.

use super::report_markup::{decimals, escaped, given, list, number, section, split_unit, symbol, table};
use crate::calibration::{UncertaintyBudget, UncertaintySource};
use crate::machine::Machine;
use crate::wire::{
    CalibrationDocument, CalibrationKind, CalibrationRequest, MachineProfile, ReportedError,
    SetupErrorSource, Verdict, cascaded_errors, reported_errors,
};

/// The parts of a report that the results come from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Results<'a> {
    pub(super) document: &'a CalibrationDocument,
    pub(super) request: &'a CalibrationRequest,
    /// The measured machine.
    pub(super) machine: &'a Machine,
    pub(super) budget: Option<&'a UncertaintyBudget>,
    /// The profile that states limits, and its revision.
    pub(super) profile: &'a MachineProfile,
    pub(super) revision: i64,
}

/// Mark of an error that is not determined.
const OPEN: &str = " <b>†</b>";
/// Below this number of degrees of freedom, twice the standard uncertainty covers about 94 % or less.
const FEW_DEGREES_OF_FREEDOM: f64 = 20.0;

/// Results, budget, and the values for the profile.
pub(super) fn results(found: Results<'_>) -> String {
    let errors = reported_errors(
        found.document,
        found.machine,
        found.budget,
        found.profile.calibration_limits.as_ref(),
    );
    let parts =
        [section("Results", &values(found, &errors)), section("Uncertainty budget", &budget(found, &errors))];
    parts.join("\n")
}

fn values(found: Results<'_>, errors: &[ReportedError]) -> String {
    let rows: Vec<Vec<String>> = errors
        .iter()
        .map(|error| {
            let digits = decimals(error.expanded);
            let mark = if error.is_determined { "" } else { OPEN };
            vec![
                symbol(&error.name) + mark,
                meaning(&error.name),
                number(error.value, digits),
                error.expanded.map_or_else(|| "not known".to_owned(), |expanded| number(expanded, digits)),
                error.limit.map_or_else(|| "–".to_owned(), |limit| format!("±{}", given(limit))),
                verdict(error.verdict).to_owned(),
            ]
        })
        .collect();
    let columns = ["symbol", "meaning", "value", "<i>U</i> (<i>k</i> = 2)", "limit", "verdict"];
    let mut text = table("results", &columns, 2, &rows);
    let mut notes = vec![
        "Location errors against the machine's frame, symbols of ISO 230-7. They hold where the axis passes its \
         reference point in the profile."
            .to_owned(),
    ];
    if found.profile.calibration_limits.is_some() {
        notes.push(format!(
            "Limits: <code>calibration_limits</code> of revision {}. Rule of ISO 14253-1: <i>within</i> if |value| + \
             <i>U</i> ≤ limit; <i>outside</i> if |value| − <i>U</i> &gt; limit; otherwise <i>not proven</i>.",
            found.revision
        ));
    }
    if errors.iter().any(|error| !error.is_determined) {
        notes.push(
            "† This run alone does not determine the error: see “What cannot be separated”. <i>U</i> covers that \
             only as far as an uncertainty of the set-up error was stated."
                .to_owned(),
        );
    }
    text += &list(notes);
    text
}

/// `E_A0C_urad` in words.
fn meaning(name: &str) -> String {
    let mut letters = name.strip_prefix("E_").unwrap_or(name).chars();
    let (motion, axis) = (letters.next().unwrap_or('?'), letters.nth(1).unwrap_or('?'));
    match motion {
        'A' => format!("tilt of {axis} about X"),
        'B' => format!("tilt of {axis} about Y"),
        'C' => format!("tilt of {axis} about Z"),
        _ => format!("position of {axis} along {motion}"),
    }
}

const fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoLimit => "no limit stated",
        Verdict::NotDetermined => "none: not determined",
        Verdict::NoUncertainty => "none: <i>U</i> not known",
        Verdict::Within => "<b>within</b>",
        Verdict::Outside => "<b>outside</b>",
        Verdict::NotProven => "<b>not proven</b>",
    }
}

/// The name of a source as a column.
const fn column(source: UncertaintySource) -> &'static str {
    match source {
        UncertaintySource::Readings => "readings (Type A)",
        UncertaintySource::Instrument => "instrument",
        UncertaintySource::SetupError => "set-up error",
        UncertaintySource::Ball => "ball position",
        UncertaintySource::BarLength => "bar length",
    }
}

fn budget(found: Results<'_>, errors: &[ReportedError]) -> String {
    let sources: Vec<UncertaintySource> = UncertaintySource::ALL
        .into_iter()
        .filter(|source| errors.iter().any(|error| error.part(*source).is_some()))
        .collect();
    let mut columns = vec!["symbol"];
    columns.extend(sources.iter().map(|source| column(*source)));
    columns.extend(["combined <i>u</i>", "<i>ν</i><sub>eff</sub>", "<i>U</i> = 2<i>u</i>"]);
    let rows: Vec<Vec<String>> = errors
        .iter()
        .map(|error| {
            let digits = decimals(error.combined) + 1;
            let shown =
                |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| number(value, digits));
            let parts = sources.iter().map(|source| shown(error.part(*source)));
            let degrees = error.effective_degrees_of_freedom;
            std::iter::once(symbol(&error.name))
                .chain(parts)
                .chain([
                    shown(error.combined),
                    degrees.map_or_else(|| "–".to_owned(), whole),
                    shown(error.expanded),
                ])
                .collect()
        })
        .collect();
    let mut text = table("budget", &columns, 1, &rows);
    text += "<p>Standard uncertainties. The sources are independent: their squares are added.</p>";
    text += &list(
        UncertaintySource::ALL
            .map(|source| format!("<b>{}</b>: {}", column(source), source_words(found, source))),
    );
    text += "<p><b>Not in the budget</b>, because nothing about it is known here: drift of the machine and of the \
             instrument during the run, errors of the linear axes, angle errors of the rotary axes, the scale of the \
             instrument. They count only as far as they show as scatter of the readings. Where a source is missing, \
             <i>U</i> is too small.</p>";
    let few = errors.iter().filter_map(|error| error.effective_degrees_of_freedom);
    if few.into_iter().any(|degrees| degrees < FEW_DEGREES_OF_FREEDOM) {
        text += "<p><b>Few readings</b>: with fewer than 20 effective degrees of freedom, <i>U</i> with <i>k</i> = 2 \
                 covers about 94 % or less.</p>";
    }
    text
}

fn whole(degrees: f64) -> String {
    if degrees > 9999.0 { "&gt; 9999".to_owned() } else { number(degrees.floor(), 0) }
}

/// What is in the budget from a source, or that it is missing and where to state it.
fn source_words(found: Results<'_>, source: UncertaintySource) -> String {
    let Results { document, request, .. } = found;
    let is_bar = document.kind == CalibrationKind::RtcpBallbar;
    let missing = |member: &str| {
        if is_bar {
            format!("<b>missing</b>: it was not stated with the run (<code>{member}</code>)")
        } else {
            "<b>missing</b>: a run of probed spheres states none".to_owned()
        }
    };
    match source {
        UncertaintySource::Readings if document.degrees_of_freedom == 0 => {
            "<b>missing</b>: there are as many unknowns as readings, so their scatter is not known. Post more \
             readings, not only eccentricities"
                .to_owned()
        }
        UncertaintySource::Readings => format!(
            "scatter about the fit, {} µm rms, {} degrees of freedom",
            number(document.residual_rms_um, 3),
            document.degrees_of_freedom
        ),
        UncertaintySource::Instrument => match request.instrument_uncertainty_um {
            Some(um) => format!(
                "{} µm as stated with the run, taken as an unknown first harmonic of that size in every test",
                given(um)
            ),
            None => missing("instrument_uncertainty_um"),
        },
        UncertaintySource::SetupError => setup_words(found),
        UncertaintySource::Ball => match request.ball_uncertainty_mm {
            Some(mm) => format!("{} mm in each coordinate, as stated with the run", given(mm)),
            None => missing("ball_uncertainty_mm"),
        },
        UncertaintySource::BarLength if !is_bar => "a run of probed spheres has no bar".to_owned(),
        UncertaintySource::BarLength => match request.bar_length_uncertainty_mm {
            Some(mm) => format!("{} mm, as stated with the run", given(mm)),
            None => missing("bar_length_uncertainty_mm"),
        },
    }
}

fn setup_words(found: Results<'_>) -> String {
    let stated = found.request.setup_uncertainty_um;
    let source = found.document.ball_bar.as_ref().map(|found| found.setup_error_um.source);
    match (source, stated) {
        (None, _) => "a run of probed spheres has no set-up error of a spindle ball".to_owned(),
        (Some(SetupErrorSource::Measured), _) => {
            "measured with the spindle step; its uncertainty is part of the readings".to_owned()
        }
        (Some(SetupErrorSource::Given), Some(um)) => {
            format!("{} µm in each component of the given values, as stated with the run", given(um))
        }
        (Some(SetupErrorSource::HeldAtZero), Some(um)) => {
            format!("{} µm in each component about zero, as stated with the run", given(um))
        }
        (Some(SetupErrorSource::Given), None) => {
            "<b>missing</b>: the values were given without an uncertainty (<code>setup_uncertainty_um</code>)"
                .to_owned()
        }
        (Some(SetupErrorSource::HeldAtZero), None) => {
            "<b>missing</b>: it is not known and held at zero. Measure it with a spindle step, or state its size \
             (<code>setup_uncertainty_um</code>)"
                .to_owned()
        }
    }
}

/// The cascaded values that applying the run writes into the profile.
pub(super) fn for_profile(found: Results<'_>) -> String {
    let rows: Vec<Vec<String>> = cascaded_errors(found.document, found.machine, found.budget)
        .into_iter()
        .map(|error| {
            let digits = decimals(error.expanded);
            let open = found.document.unidentifiable.contains(&error.name);
            let (name, unit) = split_unit(&error.name);
            let (axis, component) = name.split_once('.').unwrap_or(("", name));
            vec![
                escaped(axis),
                format!("{component} [{unit}]{}", if open { OPEN } else { "" }),
                number(error.value, digits),
                error.expanded.map_or_else(|| "not known".to_owned(), |expanded| number(expanded, digits)),
            ]
        })
        .collect();
    table("cascaded", &["axis", "component", "value", "<i>U</i> (<i>k</i> = 2)"], 2, &rows)
}
