//! The complete calibration, for any reader.

use std::fmt::Write;

use super::text::{exact, exact_vector, quoted};
use crate::calibration::{COMPONENT_NAMES, ErrorParameter, absolute_errors, iso_230_symbol, told_per_unit};
use crate::machine::{Machine, Side};
use crate::units::URAD_PER_RAD;

/// The meaning of the values, at the top of the text.
const PREAMBLE: &str = "\
# Calibrated rotary axes of a five-axis machine. The text is TOML. Numbers have their unit in their name, and all
# their digits.
#
# Frame and sense. M is right-handed along X Y Z; head points are relative to the gauge point with all axes at zero. A
# positive word is the motion of the tool relative to the workpiece (ISO 841): a head axis turns by +word about its
# direction (right hand), a table axis, which carries the workpiece, by -word. Both turn the opposite way if
# counts_opposite_to_iso_841 is true. An error is the REAL position of an axis, seen in M, minus its nominal one;
# a positive rotation is right-handed about +X, +Y or +Z.
#
# calibrated_*: the line itself, with the errors of the axes that carry it.
# location_error: cascaded. Displacement of the axis' own frame, with the rotation vector about nominal_point_mm.
#   Everything it carries moves along: line = G_1 ... G_r (nominal line), G = translation(e_x, e_y, e_z)
#   rotation(e_a, e_b, e_c), axes in this order outward, from the bed for tables and from the ram for heads.
# iso_230: ISO 230-7 symbols, absolute: each axis against M. Translation of nominal_point_mm, and rotation vector, under
#   G_1 ... G_r, to first order in the errors. The parts along and about the axis' own direction move no line: they are
#   left out and listed as redundant. The two kinds must not be mixed.
# squareness_urad: e_c0y turns Y about Z, e_b0z and e_a0z turn Z about Y and X; X is the reference.
";

/// The calibration of a machine with ISO 230-7 names (absolute), the cascaded values of the profile, and both axes'
/// lines, nominal and calibrated, at full precision, as a TOML text that states its sign convention.
///
/// Translations in µm, rotations in µrad, points in mm. Every [`Machine`] has such a text. ISO 230-7:2015 defines
/// the symbols (`E`, direction of the error, `0`, name of the axis).
#[must_use]
pub fn neutral(machine: &Machine) -> String {
    let mut out = String::from(PREAMBLE);
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    line(String::from("\nformat = \"trunnion-calibration\"\nversion = 1"));
    line(format!("machine = {}", quoted(machine.name())));
    let lines = machine.screws(true);
    let errors = machine.rotary_axes().each_ref().map(|axis| axis.location_error);
    let absolute = absolute_errors(machine);
    for (index, (axis, calibrated)) in machine.rotary_axes().iter().zip(&lines).enumerate() {
        let side = match axis.side {
            Side::Table => "table",
            Side::Head => "head",
        };
        line(format!("\n[[rotary_axes]]\nname = \"{}\"\nside = \"{side}\"", axis.letter.as_char()));
        line(format!("counts_opposite_to_iso_841 = {}", axis.reversed));
        line(format!("nominal_direction = {}", exact_vector(axis.direction)));
        line(format!("nominal_point_mm = {}", exact_vector(axis.point_mm)));
        line(format!("calibrated_direction = {}", exact_vector(calibrated.direction)));
        line(format!("calibrated_point_mm = {}", exact_vector(calibrated.point_mm)));
        line(String::from("[rotary_axes.location_error]"));
        for (component, name) in COMPONENT_NAMES.iter().enumerate() {
            let value = ErrorParameter { axis: index, component }.value(&errors);
            line(format!("{name} = {}", exact(value * told_per_unit(component))));
        }
        line(String::from("[rotary_axes.iso_230]"));
        let mut redundant = String::new();
        for component in 0..6 {
            let symbol = iso_230_symbol(axis.letter, component);
            let found = absolute.iter().find(|error| (error.axis, error.component) == (index, component));
            if let Some(error) = found {
                let unit = if component < 3 { "um" } else { "urad" };
                line(format!("{symbol}_{unit} = {}", exact(error.value * told_per_unit(component))));
            } else {
                let comma = if redundant.is_empty() { "" } else { ", " };
                // Writing to a String cannot fail.
                let _ = write!(redundant, "{comma}\"{symbol}\"");
            }
        }
        line(format!("redundant = [{redundant}]"));
    }
    let square = machine.squareness();
    line(String::from("\n[squareness_urad]"));
    line(format!("e_c0y = {}", exact(square.e_c0y_rad * URAD_PER_RAD)));
    line(format!("e_b0z = {}", exact(square.e_b0z_rad * URAD_PER_RAD)));
    line(format!("e_a0z = {}", exact(square.e_a0z_rad * URAD_PER_RAD)));
    out
}
