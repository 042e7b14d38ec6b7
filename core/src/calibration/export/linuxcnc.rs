//! HAL pins of a public kinematics module of `LinuxCNC`.

use thiserror::Error;

use super::linuxcnc_modules::{LinuxCncModule, Senses};
use super::remaining::RemainingError;
use super::text::{MM_DECIMALS, in_comment, microradians, millimetres, rounded, squareness};
use crate::calibration::CommonPerpendicular;
use crate::geometry::{Screw, angle_between, shortest_turn_rad};
use crate::machine::{Machine, RotaryLetter, Side};
use crate::units::UM_PER_MM;

/// One reason why no module of `LinuxCNC` moves like this machine.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum LinuxCncFault {
    /// No module has these axes in this order.
    #[error(
        "no kinematics module whose formulas are public has a {side:?} axis {first} that carries or stands beside a {other_side:?} axis {second}"
    )]
    NoModule {
        /// Letter of the first axis of the profile.
        first: char,
        /// Its side.
        side: Side,
        /// Letter of the second axis.
        second: char,
        /// Its side.
        other_side: Side,
    },
    /// The module takes a direction for exact that the machine does not have.
    #[error(
        "{module} takes {axis} for parallel to its machine axis; here it is nominally tilted by {tilt_rad} rad, at most {max_rad} rad are left as an error"
    )]
    Tilted {
        /// Name of the module.
        module: &'static str,
        /// Letter of the axis.
        axis: char,
        /// Nominal angle to the machine axis \[rad\].
        tilt_rad: f64,
        /// Largest taken for an error \[rad\].
        max_rad: f64,
    },
    /// The module counts an axis the other way.
    #[error("{module} counts {axis} {}, this machine counts it the other way", if *as_iso_841 { "as ISO 841" } else { "opposite to ISO 841" })]
    Sense {
        /// Name of the module.
        module: &'static str,
        /// Letter of the axis.
        axis: char,
        /// How the module counts.
        as_iso_841: bool,
    },
    /// The module counts both axes alike, the machine does not.
    #[error(
        "{module} counts both axes as ISO 841 or both opposite to it; this machine counts only {axis} as ISO 841"
    )]
    UnlikeSenses {
        /// Name of the module.
        module: &'static str,
        /// Letter of the axis counted as ISO 841.
        axis: char,
    },
    /// The axis of a head does not meet the spindle's line.
    #[error(
        "{module} takes {axis} for meeting the spindle's line; here it is nominally {distance_mm} mm away, at most {max_mm} mm are left as an error"
    )]
    OffSpindle {
        /// Name of the module.
        module: &'static str,
        /// Letter of the axis.
        axis: char,
        /// Nominal distance \[mm\].
        distance_mm: f64,
        /// Largest taken for an error \[mm\].
        max_mm: f64,
    },
    /// A radius that is none.
    #[error("a radius of {radius_mm} mm is not above 0 and at most {max_mm} mm")]
    Radius {
        /// Given \[mm\].
        radius_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
}

/// Pins, what they leave, and the text that sets them.
#[derive(Debug, Clone, PartialEq)]
pub struct LinuxCncExport {
    /// The module.
    pub module: LinuxCncModule,
    /// Names without the module's prefix, and values as printed \[mm\].
    pub pins: Vec<(&'static str, f64)>,
    /// What the module cannot take: tilts, and of a head offsets from the spindle's line.
    pub remaining: RemainingError,
    /// `setp` commands for a HAL file, with what they mean.
    pub text: String,
}

/// Nominal tilt above which a machine is built that way \[rad\]; below, it is an error that stays.
const MAX_TILT_RAD: f64 = 0.01;
/// Nominal distance from the spindle's line above which a head is built that way \[mm\].
const MAX_OFFSET_MM: f64 = 1.0;

/// The calibrated machine as HAL pins of the module that has its axes ([`LinuxCncModule`]: formulas and sources).
///
/// The modules shift axes but do not tilt them. Table lines are given where they come nearest each other, a head's tilting
/// line by its height; what remains is told for tips at `radius_mm` ([`RemainingError`]). Pins are in mm, for a
/// configuration in mm whose machine coordinates are those of the profile. Squareness is no part of any module.
///
/// # Errors
/// Every fact by which no module moves like the machine, or the radius is none.
pub fn linuxcnc(machine: &Machine, radius_mm: f64) -> Result<LinuxCncExport, Vec<LinuxCncFault>> {
    let mut faults = Vec::new();
    let max_mm = Machine::MAX_LENGTH_MM;
    if !(radius_mm > 0.0 && radius_mm <= max_mm) {
        faults.push(LinuxCncFault::Radius { radius_mm, max_mm });
    }
    let axes = machine.rotary_axes();
    let fits = |module: &LinuxCncModule| {
        axes.iter()
            .zip(module.letters())
            .all(|(axis, letter)| axis.letter == letter && axis.side == module.side())
    };
    let Some(module) = LinuxCncModule::ALL.into_iter().find(fits) else {
        let [first, second] = axes;
        faults.push(LinuxCncFault::NoModule {
            first: first.letter.as_char(),
            side: first.side,
            second: second.letter.as_char(),
            other_side: second.side,
        });
        return Err(faults);
    };
    check_nominal(machine, module, &mut faults);
    let conventional = check_senses(machine, module, &mut faults);
    let lines = machine.screws(true);
    // Parallel axes are no machine; the angle between calibrated axes is checked with the profile.
    let between = CommonPerpendicular::of(&lines[0], &lines[1]);
    let feet_mm = between.map_or(lines.map(|line| line.point_mm), |between| between.feet_mm);
    if !faults.is_empty() {
        return Err(faults);
    }
    let pins: Vec<(&'static str, f64)> =
        module.pins(feet_mm).into_iter().map(|(pin, value)| (pin, rounded(value, MM_DECIMALS))).collect();
    let simplified = upright(machine, module.lines(&pins));
    let remaining = RemainingError::of(machine, &simplified, feet_mm[1], radius_mm);
    let text = text(machine, module, &pins, conventional, &remaining);
    Ok(LinuxCncExport { module, pins, remaining, text })
}

/// The module's lines with the senses of the profile's directions.
fn upright(machine: &Machine, lines: [Screw; 2]) -> [Screw; 2] {
    std::array::from_fn(|k| {
        let Screw { direction, point_mm } = lines[k];
        let sign = direction.dot(&machine.rotary_axes()[k].direction).signum();
        Screw { direction: direction * sign, point_mm }
    })
}

fn check_nominal(machine: &Machine, module: LinuxCncModule, faults: &mut Vec<LinuxCncFault>) {
    for (axis, direction) in machine.rotary_axes().iter().zip(module.directions()) {
        let letter = axis.letter.as_char();
        let angle = angle_between(axis.direction, direction);
        let tilt_rad = angle.min(std::f64::consts::PI - angle);
        if tilt_rad > MAX_TILT_RAD {
            let max_rad = MAX_TILT_RAD;
            faults.push(LinuxCncFault::Tilted { module: module.name(), axis: letter, tilt_rad, max_rad });
        }
        if module.side() == Side::Head {
            let off = axis.direction.cross(&Machine::TOOL_AXIS);
            // C lies along the spindle's line, B crosses it
            let distance_mm = if axis.letter == RotaryLetter::C {
                axis.point_mm.cross(&Machine::TOOL_AXIS).norm()
            } else {
                axis.point_mm.dot(&off).abs() / off.norm().max(f64::MIN_POSITIVE)
            };
            if distance_mm > MAX_OFFSET_MM {
                let max_mm = MAX_OFFSET_MM;
                faults.push(LinuxCncFault::OffSpindle {
                    module: module.name(),
                    axis: letter,
                    distance_mm,
                    max_mm,
                });
            }
        }
    }
}

/// Whether the pin `conventional-directions` is to be set, where the module has one.
fn check_senses(machine: &Machine, module: LinuxCncModule, faults: &mut Vec<LinuxCncFault>) -> Option<bool> {
    let axes = machine.rotary_axes();
    let directions = module.directions();
    let senses: [f64; 2] = std::array::from_fn(|k| {
        let counts = if axes[k].reversed { -1.0 } else { 1.0 };
        counts * axes[k].direction.dot(&directions[k]).signum()
    });
    match module.senses() {
        Senses::Alike => {
            if senses[0] * senses[1] < 0.0 {
                let iso = usize::from(senses[1] > 0.0);
                let axis = axes[iso].letter.as_char();
                faults.push(LinuxCncFault::UnlikeSenses { module: module.name(), axis });
            }
            Some(senses[0] > 0.0)
        }
        Senses::Fixed(fixed) => {
            for k in 0..2 {
                if senses[k] * fixed[k] < 0.0 {
                    let (axis, as_iso_841) = (axes[k].letter.as_char(), fixed[k] > 0.0);
                    faults.push(LinuxCncFault::Sense { module: module.name(), axis, as_iso_841 });
                }
            }
            None
        }
    }
}

fn text(
    machine: &Machine,
    module: LinuxCncModule,
    pins: &[(&'static str, f64)],
    conventional: Option<bool>,
    remaining: &RemainingError,
) -> String {
    let name = module.name();
    let mut lines = vec![
        format!("# Rotary axes as calibrated, for LinuxCNC, kinematics module {name}"),
        format!("# Machine: {}", in_comment(machine.name())),
        String::from(
            "# Values in mm, for a configuration with LINEAR_UNITS = mm whose machine coordinates are those of",
        ),
        String::from("# the profile. The tool's length is not among them."),
    ];
    match module.tool_pin() {
        Some(pin) => {
            lines.push(String::from("# It has to come from the tool in use:"));
            lines.push(format!("#   net :tool-offset motion.tooloffset.z {name}.{pin}"));
        }
        None => lines.push(String::from(
            "# pivot-length is the distance from the B axis to the gauge point; with a tool the distance to its tip counts.",
        )),
    }
    lines.extend(pins.iter().map(|(pin, value)| format!("setp {name}.{pin} {}", millimetres(*value))));
    match conventional {
        Some(true) => {
            lines.push(format!("setp {name}.conventional-directions 1"));
            lines.push(String::from("# Both words count as ISO 841. A version without this pin counts both opposite: it does not fit."));
        }
        Some(false) => {
            lines.push(String::from("# Both words count opposite to ISO 841, as the module does by default: conventional-directions stays 0."));
            if module == LinuxCncModule::XyzbcTrt {
                lines.push(String::from(
                    "# Check the version: where the pin was first added, the inverse of this module takes the part of z-offset in\n# X with the wrong sign unless the pin is 1; forward and inverse then disagree.",
                ));
            }
        }
        None if module == LinuxCncModule::XyzabTdr => lines.push(String::from(
            "# Check the version: the first one had a wrong sign in its forward kinematics (mended by pull request 2320).",
        )),
        None => {}
    }
    lines.push(String::from("# Not in these values, because the module has no place for it:"));
    let directions = upright(machine, module.lines(pins)).map(|line| line.direction);
    for ((axis, line), direction) in machine.rotary_axes().iter().zip(machine.screws(true)).zip(directions) {
        let tilt_rad = shortest_turn_rad(direction, line.direction);
        lines.push(format!(
            "#   {} is turned by {}, {}, {} urad about X, Y, Z from its machine axis",
            axis.letter.as_char(),
            microradians(tilt_rad.x),
            microradians(tilt_rad.y),
            microradians(tilt_rad.z)
        ));
    }
    if module == LinuxCncModule::FiveAxis {
        let [c, b] = machine.screws(true);
        let pivot_mm = pins.iter().map(|(_, value)| *value).sum::<f64>();
        let at = c.point_mm + c.direction * ((pivot_mm - c.point_mm.z) / c.direction.z);
        let x_mm = b.point_mm.x - b.direction.x * (b.point_mm.y / b.direction.y);
        lines.push(format!(
            "#   at the pivot's height C stands at X {} Y {}, and B at X {}, from the spindle's line",
            millimetres(at.x),
            millimetres(at.y),
            millimetres(x_mm)
        ));
    }
    lines.push(format!("#   squareness: {}", squareness(machine.squareness())));
    let [first, second] = module.letters().map(RotaryLetter::as_char);
    let place = match module.side() {
        Side::Table => format!("from the point of {second} nearest {first}"),
        Side::Head => String::from("below the gauge point"),
    };
    lines.push(format!(
        "# With square linear axes the tool tip, {} mm {place}, is then wrong by up to {:.3} um,",
        remaining.radius_mm,
        remaining.tip_mm * UM_PER_MM
    ));
    lines.push(format!(
        "# the tool axis by up to {} urad (bounds, over a grid of angles within the travel).",
        microradians(remaining.axis_rad)
    ));
    let mut out = lines.join("\n");
    out.push('\n');
    out
}
