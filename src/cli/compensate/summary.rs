//! The three lines that a person reads after an operation: how good the result is, where it is worst, and what was
//! written.

use std::time::Duration;

use serde_json::Value;

use super::CompensateArguments;
use crate::cli::CommandFault;
use crate::jobs::JobFault;
use crate::wire::JobOperation;

/// The lines, joined.
///
/// # Errors
/// The report cannot be read.
pub(super) fn lines(
    arguments: &CompensateArguments,
    report: &str,
    took: Duration,
) -> Result<String, CommandFault> {
    let report = serde_json::from_str(report).map_err(|fault| CommandFault::Work(JobFault::from(fault)))?;
    let report = Report(&report);
    let [first, second] = match arguments.operation {
        JobOperation::CcCompensation => path(report),
        JobOperation::Compensation => one_pass(report),
        JobOperation::WearCompensation => worn(report),
        JobOperation::Posting => posted(report),
        JobOperation::Verification => cut(report),
        JobOperation::ServoSimulation => driven(report),
    };
    let third = written(arguments, report);
    Ok(format!("{first}, {:.1} s\n{second}\n{third}", took.as_secs_f64()))
}

/// A report or a part of it.
#[derive(Clone, Copy)]
struct Report<'a>(&'a Value);

impl<'a> Report<'a> {
    fn number(self, pointer: &str) -> Option<f64> {
        self.0.pointer(pointer)?.as_f64()
    }

    fn count(self, pointer: &str) -> u64 {
        self.0.pointer(pointer).and_then(Value::as_u64).unwrap_or_default()
    }

    /// A length in micrometres.
    fn um(self, pointer: &str) -> String {
        self.number(pointer).map_or_else(|| "–".to_owned(), |um| format!("{um:.1}"))
    }

    /// A value before and after.
    fn change(self, before: &str, after: &str) -> String {
        format!("{} → {} µm", self.um(before), self.um(after))
    }

    /// `at line 7`, if there is a line.
    fn at_line(self, pointer: &str) -> String {
        self.0
            .pointer(pointer)
            .and_then(Value::as_u64)
            .map(|line| format!(" at line {line}"))
            .unwrap_or_default()
    }

    /// The kinds of all warnings, each once: those of the report, and then those of its steps.
    fn warning_kinds(self) -> Vec<&'a str> {
        let steps = self.0.as_object().into_iter().flat_map(|members| members.values());
        let lists = std::iter::once(self.0).chain(steps).filter_map(|part| part.get("warnings")?.as_array());
        let mut kinds = Vec::new();
        for kind in lists.flatten().filter_map(|warning| warning.get("kind")?.as_str()) {
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        kinds
    }

    fn part(self, name: &str) -> Option<Report<'a>> {
        self.0.get(name).filter(|part| !part.is_null()).map(Report)
    }
}

/// A count with its noun.
fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn inserted(report: Report<'_>) -> String {
    match report.count("/blocks_inserted") {
        0 => "no block inserted".to_owned(),
        inserted => format!("{} inserted", counted(inserted, "block")),
    }
}

fn path(report: Report<'_>) -> [String; 2] {
    let change = report.change("/before/max_um", "/after/max_um");
    let left = match report.count("/motions_left_over") {
        0 => String::new(),
        left => format!("; {left} left over the tolerance"),
    };
    let second = format!(
        "{} of {} over the tolerance{left}; the largest deviation was{} and is{}",
        report.count("/motions_over_tolerance"),
        counted(report.count("/motions_checked"), "motion"),
        place(report.at_line("/before/worst_line")),
        place(report.at_line("/after/worst_line")),
    );
    [format!("{change}, {}", inserted(report)), second]
}

/// A place, or nowhere.
fn place(at_line: String) -> String {
    if at_line.is_empty() { " nowhere".to_owned() } else { at_line }
}

fn one_pass(report: Report<'_>) -> [String; 2] {
    let mut steps = Vec::new();
    if let Some(cc) = report.part("cc") {
        steps.push(cc.change("/before/max_um", "/after/max_um"));
    }
    if let Some(wear) = report.part("wear") {
        steps.push(format!("wear {}", wear.change("/before/max_um", "/after/max_um")));
    }
    if let Some(errors) = report.part("location_errors") {
        steps.push(format!("location errors up to {} µm", errors.um("/max_tip_um")));
    }
    steps.push(inserted(report));
    let budget = |name: &str| {
        let [before, after] = ["before", "after"].map(|when| format!("/error_budget/{name}/{when}_um"));
        report.number(&before).is_some_and(|um| um > 0.0).then(|| report.change(&before, &after))
    };
    let named = ["interpolation", "wear", "location_errors", "rounding", "servo"];
    let parts: Vec<String> = named
        .iter()
        .filter_map(|name| Some(format!("{} {}", name.replace('_', " "), budget(name)?)))
        .collect();
    let second = match report.part("cc") {
        _ if !parts.is_empty() => format!("errors before → after: {}", parts.join(", ")),
        Some(cc) => path(cc)[1].clone(),
        None => format!("{} changed", counted(report.count("/changes/motions_changed"), "motion")),
    };
    [steps.join(", "), second]
}

fn worn(report: Report<'_>) -> [String; 2] {
    let change = report.change("/before/max_um", "/after/max_um");
    let second = format!(
        "{} moved by up to {} µm{}; {} kept, {} assumed",
        counted(report.count("/motions_shifted"), "motion"),
        report.um("/max_shift_um"),
        report.at_line("/max_shift_line"),
        counted(report.count("/contacts_kept"), "contact"),
        report.count("/contacts_assumed"),
    );
    [format!("{change}, {} changed", counted(report.count("/blocks_changed"), "block")), second]
}

fn posted(report: Report<'_>) -> [String; 2] {
    let first = format!(
        "{} posted, {}, {}",
        counted(report.count("/points"), "point"),
        counted(report.count("/blocks_out"), "block"),
        counted(report.count("/rewinds"), "rewind"),
    );
    let second = format!(
        "read back within {} µm and {} µrad; up to {} µm from the line between points{}",
        report.um("/read_back/max_tip_um"),
        report.um("/read_back/max_axis_urad"),
        report.um("/between_points/max_tip_um"),
        report.at_line("/between_points/max_tip_line"),
    );
    [first, second]
}

fn cut(report: Report<'_>) -> [String; 2] {
    let first = format!(
        "{} of {} over {} µm, {} cut deeper, {} uncut",
        report.count("/excess_over_limit"),
        counted(report.count("/samples"), "sample"),
        report.um("/limit_um"),
        report.count("/gouge_over_limit"),
        report.count("/uncut"),
    );
    let most = |name: &str| match report.part(name) {
        Some(found) => format!("{} µm{}", found.um("/residual_um"), found.at_line("/line")),
        None => "none".to_owned(),
    };
    let second = format!(
        "most material left: {}; deepest cut: {}; rms {} µm",
        most("max_excess"),
        most("max_gouge"),
        report.um("/rms_um"),
    );
    [first, second]
}

fn driven(report: Report<'_>) -> [String; 2] {
    let first = format!(
        "contour error up to {} µm{}",
        report.um("/contour_error/max_abs_um"),
        report.at_line("/contour_error/worst_line"),
    );
    let second = format!(
        "rms {} µm; {} of {:.1} s on the machine",
        report.um("/contour_error/rms_um"),
        counted(report.count("/motions_simulated"), "motion"),
        report.number("/duration_s").unwrap_or_default(),
    );
    [first, second]
}

/// What was written, and which warnings there are.
fn written(arguments: &CompensateArguments, report: Report<'_>) -> String {
    let file = match &arguments.output {
        Some(path) => format!("written: {}", path.display()),
        None => "no result was written: name a second file for it".to_owned(),
    };
    let file = if arguments.operation == JobOperation::ServoSimulation {
        "the program is unchanged".to_owned()
    } else {
        file
    };
    let kinds = report.warning_kinds();
    if kinds.is_empty() {
        return format!("{file}; no warnings");
    }
    let whole = if arguments.report.is_some() { "" } else { " (--report FILE has them in full)" };
    format!("{file}; warnings: {}{whole}", kinds.join(", "))
}
