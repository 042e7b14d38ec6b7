//! The errors that a run cannot separate, and the points to check, in a metrologist's words.

use super::calibration_answer::unknown_name;
use crate::calibration::{Blind, FurtherRun, RunWarning, Unknown};
use crate::machine::Machine;
use crate::units::UM_PER_MM;

/// A number in a form that people read.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn axis_letter(machine: &Machine, axis: usize) -> char {
    machine.rotary_axes().get(axis).map_or('?', |axis| axis.letter.as_char())
}

/// `e_x of the A axis`, `the set-up error e_xs`.
fn spoken(machine: &Machine, unknown: Unknown) -> String {
    let name = unknown_name(machine, unknown);
    match unknown {
        Unknown::Error(parameter) => {
            let component = name.split('.').nth(1).unwrap_or_default();
            let component = component.trim_end_matches("_urad").trim_end_matches("_um");
            format!("{component} of the {} axis", axis_letter(machine, parameter.axis))
        }
        Unknown::SetupError(_) => format!("the set-up error {}", name.trim_end_matches("_um")),
    }
}

fn unit(unknown: Unknown) -> &'static str {
    match unknown {
        Unknown::Error(parameter) if parameter.is_angle() => "µrad",
        Unknown::Error(_) | Unknown::SetupError(_) => "µm",
    }
}

/// The errors that cannot be separated, in words.
pub(super) fn blind_words(machine: &Machine, blind: &Blind) -> String {
    let spoken: Vec<String> = blind.parts.iter().map(|(unknown, _)| spoken(machine, *unknown)).collect();
    let amounts: Vec<String> = blind
        .parts
        .iter()
        .map(|(unknown, part)| {
            format!("{} {} of {}", short(*part), unit(*unknown), unknown_name(machine, *unknown))
        })
        .collect();
    let offsets: Vec<String> = blind.offsets.iter().map(|test| format!("test {test}")).collect();
    let zero = if offsets.is_empty() {
        String::new()
    } else {
        format!(" but the bar's zero of {}", offsets.join(", "))
    };
    match (spoken.as_slice(), blind.offsets.as_slice()) {
        ([only], []) => format!("{only} changes no reading of this run"),
        ([only], _) => format!(
            "{only} cannot be separated from the bar's gauge length (its zero): it changes no reading{zero}"
        ),
        ([first, rest @ ..], _) => format!(
            "{first} cannot be separated from {}: {} together change no reading{zero}",
            rest.join(" and "),
            amounts.join(" and ")
        ),
        ([], _) => String::new(),
    }
}

/// The run to add, in words.
pub(super) fn further_words(machine: &Machine, run: FurtherRun) -> String {
    match run {
        FurtherRun::SpindleStep => {
            "a spindle step: the bar read at spindle angles 0, 90, 180 and 270° with both rotary axes at zero (setup_error_um.spindle_deg), or a known set-up error".to_owned()
        }
        FurtherRun::Test { axis, bar, ball_mm, tool_length_mm } => {
            let tool = if tool_length_mm > 0.0 {
                format!(" and a tool length of {} mm", short(tool_length_mm))
            } else {
                String::new()
            };
            format!(
                "a test of {} with the bar {} and the ball at ({}, {}, {}) mm{tool}",
                axis_letter(machine, axis),
                bar.as_str(),
                short(ball_mm.x),
                short(ball_mm.y),
                short(ball_mm.z)
            )
        }
    }
}

/// Kind, test and words of a warning.
pub(super) fn warning_words(warning: &RunWarning) -> (&'static str, Option<usize>, String) {
    match *warning {
        RunWarning::SingleSweep { test } => (
            "single-sweep",
            Some(test),
            "the axis turned in one direction only, so play and friction are not visible; add the return sweep"
                .to_owned(),
        ),
        RunWarning::DuplicateAngle { test, reading, angle_deg } => {
            let detail =
                format!("reading {reading} repeats the angle {}° within one sweep", short(angle_deg));
            ("duplicate-angle", Some(test), detail)
        }
        RunWarning::SmallArc { test, arc_deg } => {
            let detail = format!(
                "the readings cover only {}°: offset, sine and cosine are hard to separate",
                short(arc_deg)
            );
            ("small-arc", Some(test), detail)
        }
        RunWarning::OutsideTravel { test, readings } => {
            let detail =
                format!("{readings} readings lie outside the travel that the profile gives the axis");
            ("outside-travel", Some(test), detail)
        }
        RunWarning::SuspiciouslySmall { largest_mm } => {
            let detail = format!(
                "no reading is larger than {} µm; check whether they are in millimetres",
                short(largest_mm * UM_PER_MM)
            );
            ("suspiciously-small", None, detail)
        }
        RunWarning::SuspiciouslyLarge { largest_mm } => {
            let detail = format!(
                "a reading of {} µm is more than a ball bar measures (about ±1000 µm)",
                short(largest_mm * UM_PER_MM)
            );
            ("suspiciously-large", None, detail)
        }
        RunWarning::NoToolLength { test } => (
            "no-tool-length",
            Some(test),
            "the axis is on the head and tool_length_mm is 0: the ball was assumed to be at the gauge point"
                .to_owned(),
        ),
        RunWarning::OutliersLeftOut { test, readings } => {
            let detail = format!("{readings} readings are far from all others and were left out");
            ("outliers-left-out", Some(test), detail)
        }
        RunWarning::ManyOutliers { test, left_out, readings } => {
            let detail = format!(
                "{left_out} of {readings} readings were left out. The other readings may be the wrong ones; measure the test again"
            );
            ("many-outliers", Some(test), detail)
        }
        RunWarning::IllConditioned { condition_number } => {
            let detail = format!(
                "the tests hardly separate some errors (condition number {}): check the standard uncertainties",
                short(condition_number)
            );
            ("ill-conditioned", None, detail)
        }
    }
}
