//! HAL pins of a public kinematics module of `LinuxCNC`.

use thiserror::Error;

use super::linuxcnc_modules::{LinuxCncModule, Senses};
use super::remaining::RemainingError;
use super::text::{MM_DECIMALS, in_comment, microradians, millimetres, rounded, squareness};
use crate::calibration::CommonPerpendicular;
use crate::geometry::{Screw, angle_between, shortest_turn_rad};
use crate::machine::{Machine, RotaryLetter, Side};
use crate::units::{UM_PER_MM, legible};

/// One reason why no module of `LinuxCNC` moves like this machine.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum LinuxCncFault {
    /// No module has these axes in this order.
    #[error(
        "no kinematics module with public formulas has a {side:?} axis {first} that carries, or is beside, a {other_side:?} axis {second}"
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
    /// The module assumes an exact direction, but the machine has another one.
    #[error(
        "{module} assumes {axis} parallel to its machine axis; here it is nominally tilted by {tilt_rad} rad, and at most {max_rad} rad can remain as an error"
    )]
    Tilted {
        /// Name of the module.
        module: &'static str,
        /// Letter of the axis.
        axis: char,
        /// Nominal angle to the machine axis \[rad\].
        tilt_rad: f64,
        /// Largest tilt that can remain as an error \[rad\].
        max_rad: f64,
    },
    /// The module counts an axis in the opposite direction.
    #[error("{module} counts {axis} {}, but this machine counts it in the opposite direction", if *as_iso_841 { "as ISO 841" } else { "opposite to ISO 841" })]
    Sense {
        /// Name of the module.
        module: &'static str,
        /// Letter of the axis.
        axis: char,
        /// True if the module counts as ISO 841.
        as_iso_841: bool,
    },
    /// The module counts both axes in the same way, but the machine does not.
    #[error(
        "{module} counts both axes as ISO 841, or both opposite to it; this machine counts only {axis} as ISO 841"
    )]
    UnlikeSenses {
        /// Name of the module.
        module: &'static str,
        /// Letter of the axis counted as ISO 841.
        axis: char,
    },
    /// The axis of a head does not intersect the spindle's line.
    #[error(
        "{module} assumes that {axis} intersects the spindle's line; here it is nominally {distance_mm} mm away, and at most {max_mm} mm can remain as an error"
    )]
    OffSpindle {
        /// Name of the module.
        module: &'static str,
        /// Letter of the axis.
        axis: char,
        /// Nominal distance \[mm\].
        distance_mm: f64,
        /// Largest distance that can remain as an error \[mm\].
        max_mm: f64,
    },
    /// A radius out of range.
    #[error("the radius of {} mm must be above 0 and at most {max_mm} mm", legible(.radius_mm))]
    Radius {
        /// The radius given \[mm\].
        radius_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
}

/// Pins, the errors that remain, and the text that sets the pins.
#[derive(Debug, Clone, PartialEq)]
pub struct LinuxCncExport {
    /// The module.
    pub module: LinuxCncModule,
    /// Names without the module's prefix, and values as printed \[mm\].
    pub pins: Vec<(&'static str, f64)>,
    /// Errors that the module cannot hold: tilts, and for a head also offsets from the spindle's line.
    pub remaining: RemainingError,
    /// `setp` commands for a HAL file, with their meaning.
    pub text: String,
}

/// A larger nominal tilt belongs to the machine's design \[rad\]. A smaller one is an error that remains.
const MAX_TILT_RAD: f64 = 0.01;
/// A larger nominal distance from the spindle's line belongs to a head's design \[mm\].
const MAX_OFFSET_MM: f64 = 1.0;

/// The calibrated machine as HAL pins of the module that has its axes ([`LinuxCncModule`]: formulas and sources).
///
/// The modules shift axes but do not tilt them. Table lines are set at the points where they are nearest to each
/// other, a head's tilting line by its height. The remaining error is given for tips at `radius_mm`
/// ([`RemainingError`]). Pins are in mm, for a configuration in mm whose machine coordinates are those of the
/// profile. No module includes squareness.
///
/// # Errors
/// Every reason why no module moves like the machine, or a radius out of range.
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
    // A machine with parallel axes is refused. The angle between calibrated axes is checked with the profile.
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

/// The module's lines in the directions of the profile.
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
            // C lies along the spindle's line, and B crosses it.
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

/// Whether to set the pin `conventional-directions`, if the module has one.
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
        format!("# Calibrated rotary axes for LinuxCNC, kinematics module {name}"),
        format!("# Machine: {}", in_comment(machine.name())),
        String::from(
            "# Values in mm, for a configuration with LINEAR_UNITS = mm whose machine coordinates are those of",
        ),
        String::from("# the profile. The tool length is not included."),
    ];
    match module.tool_pin() {
        Some(pin) => {
            lines.push(String::from("# It must come from the tool in use:"));
            lines.push(format!("#   net :tool-offset motion.tooloffset.z {name}.{pin}"));
        }
        None => lines.push(String::from(
            "# pivot-length is the distance from the B axis to the gauge point; with a tool, use the distance to its tip.",
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
                    "# Check the version: in the first version with this pin, the inverse of this module uses the part of z-offset in\n# X with the wrong sign unless the pin is 1; forward and inverse then disagree.",
                ));
            }
        }
        None if module == LinuxCncModule::XyzabTdr => lines.push(String::from(
            "# Check the version: the first one had a wrong sign in its forward kinematics (fixed by pull request 2320).",
        )),
        None => {}
    }
    lines.push(String::from("# Not included in these values, because the module has no parameter for it:"));
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
            "#   at the pivot's height C is at X {} Y {}, and B at X {}, from the spindle's line",
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
