//! Offset and axis vectors of the generic five-axis transformation of SINUMERIK controls (TRAORI).

use std::num::NonZeroU16;

use super::text::{DIRECTION_DECIMALS, MM_DECIMALS, in_comment, millimetres, rounded_vector, squareness};
use crate::geometry::Vec3;
use crate::machine::{Machine, RotaryAxis, Side};

/// The target of the vectors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SiemensForm {
    /// Machine data of the first transformation of the channel, type 24, 40 or 56.
    MachineData,
    /// The tool carrier with this number, which transformation type 72 and the swivel cycle use.
    ToolCarrier(NonZeroU16),
}

/// The vectors, each with its name in both forms.
struct Vectors {
    /// Type of the generic transformation.
    transformation: u16,
    /// Letter of the carrier's kinematics: tool, part or mixed.
    carrier: char,
    /// Name of the machine data, first number of the carrier's three, vector \[mm\].
    offsets_mm: Vec<(&'static str, u16, Vec3)>,
    /// The axes in the order of the transformation.
    axes: [usize; 2],
}

const BASE_TOOL: &str = "TRAFO5_BASE_TOOL_1";
const JOINT: &str = "TRAFO5_JOINT_OFFSET_1";
const JOINT_PART: &str = "TRAFO5_JOINT_OFFSET_PART_1";
const PART: &str = "TRAFO5_PART_OFFSET_1";
/// First numbers of the carrier's vectors l1 to l4, v1 and v2.
const L: [u16; 4] = [1, 4, 15, 18];
const V: [u16; 2] = [7, 10];

/// The calibrated machine as offset and axis vectors of the generic five-axis transformation, in mm, for every machine.
///
/// Sources of their meaning: Siemens, *SINUMERIK Operate (IM9), Commissioning Manual*, 12/2017, 6FC5397-1DP40-6BA1:
/// p. 572 (the machine data for each tool carrier vector, for types 24, 40, 56; the chains close; an axis that
/// moves the workpiece has its direction reversed), p. 567 (axis 2 is on axis 1; on a mixed machine axis 1 turns
/// the tool), p. 586 (swivel table: from the machine's reference point to axis 1, to axis 2); the same, 03/2013,
/// 6FC5397-1DP40-3BA1, p. 502 (start and end of each offset, axes not swivelled). *Function Manual Tool
/// Compensation (W1)*, 08/2005, 6FC5397-0BP10-0BA0, p. 2-88 (head vectors lead from the tool to the reference
/// point), p. 2-98 (a table about +Y turned by +45° turns that way itself). *Function Manual Transformations*,
/// 06/2019, A5E47435470B AA, p. 172 (the generic transformation is for axes that are not square to each other or
/// not parallel to a machine axis).
///
/// With R₁, R₂ right-handed about the axis vectors by the words: heads `w = q − part − R₁(joint + R₂·base)`, tables
/// `q = base + R₁(joint + R₂(part + w))`. p. 572 prints the number 24558 beside `JOINT_OFFSET_1` of a swivel table
/// and beside `JOINT_OFFSET_PART_1` of a mixed machine, 24560 beside `JOINT_OFFSET_1` elsewhere; the name is
/// followed. Some values are not set, because they have no source or belong to the channel: axis assignment, zero
/// offsets and directions of the words, base orientation, pole limits. The text says so.
#[must_use]
pub fn siemens(machine: &Machine, form: SiemensForm) -> String {
    let vectors = vectors(machine);
    let mut lines = vec![
        String::from("; Calibrated rotary axes for the generic 5-axis transformation of SINUMERIK"),
        format!("; Machine: {}", in_comment(machine.name())),
        String::from(
            "; Lengths in mm, in the machine coordinate system; axes not swivelled. Vectors of axes that move the workpiece",
        ),
        String::from("; are reversed: a positive word turns the table right-handed about its vector."),
    ];
    match form {
        SiemensForm::MachineData => {
            lines.push(format!("$MC_TRAFO_TYPE_1={}", vectors.transformation));
            for (name, _, offset_mm) in &vectors.offsets_mm {
                lines.extend((0..3).map(|k| format!("$MC_{name}[{k}]={}", millimetres(offset_mm[k]))));
            }
        }
        SiemensForm::ToolCarrier(number) => {
            for first in L {
                let given = vectors.offsets_mm.iter().find(|(_, carrier, _)| *carrier == first);
                let offset_mm = given.map_or_else(Vec3::zeros, |(_, _, offset_mm)| *offset_mm);
                lines.extend(
                    (first..).zip(offset_mm.iter()).map(|(n, v)| carrier(n, number, &millimetres(*v))),
                );
            }
        }
    }
    for (order, index) in vectors.axes.into_iter().enumerate() {
        let axis = &machine.rotary_axes()[index];
        let vector =
            rounded_vector(machine.screws(true)[index].direction * turning_sense(axis), DIRECTION_DECIMALS);
        lines.push(format!("; axis {}: {}", order + 1, axis.letter.as_char()));
        lines.extend((0_u16..).zip(vector.iter()).map(|(k, component)| match form {
            SiemensForm::MachineData => format!("$MC_TRAFO5_AXIS{}_1[{k}]={component:.12}", order + 1),
            SiemensForm::ToolCarrier(number) => carrier(V[order] + k, number, &format!("{component:.12}")),
        }));
    }
    if let SiemensForm::ToolCarrier(number) = form {
        lines.push(carrier(23, number, &format!("\"{}\"", vectors.carrier)));
        lines.push(String::from(
            "; The fine offsets (the same numbers plus 40) are added to these values. They must be zero.",
        ));
    }
    lines.push(String::from(
        "; Assumed and not set here: words that start at 0 and count in the direction of the vectors",
    ));
    lines.push(String::from("; ($MC_TRAFO5_ROT_AX_OFFSET_1, $MC_TRAFO5_ROT_SIGN_IS_PLUS_1 or $TC_CARR24, $TC_CARR25), a tool along Z with"));
    lines.push(String::from("; all axes at zero. Not set: axis assignment ($MC_TRAFO_AXES_IN_1, $MC_TRAFO_GEOAX_ASSIGN_TAB_1), pole limits."));
    lines.push(format!("; Squareness is not included: {}.", squareness(machine.squareness())));
    let mut out = lines.join("\n");
    out.push('\n');
    out
}

fn carrier(n: u16, number: NonZeroU16, value: &str) -> String {
    format!("$TC_CARR{n}[{number}]={value}")
}

/// +1 if a positive word turns the part or tool that the axis carries right-handed about the profile's direction.
fn turning_sense(axis: &RotaryAxis) -> f64 {
    let counts = if axis.reversed { -1.0 } else { 1.0 };
    match axis.side {
        Side::Table => -counts,
        Side::Head => counts,
    }
}

/// The closed chains: at zero they displace nothing.
fn vectors(machine: &Machine) -> Vectors {
    // Rounded before the differences are computed, so that the printed chain closes as well.
    let points = machine.screws(true).map(|line| rounded_vector(line.point_mm, MM_DECIMALS));
    let sides = [0, 1].map(|index| machine.rotary_axes()[index].side);
    let [first, second] = points;
    match sides {
        [Side::Head, Side::Head] => Vectors {
            transformation: 24,
            carrier: 'T',
            offsets_mm: vec![(PART, L[0], -first), (JOINT, L[1], first - second), (BASE_TOOL, L[2], second)],
            axes: [0, 1],
        },
        [Side::Table, Side::Table] => Vectors {
            transformation: 40,
            carrier: 'P',
            offsets_mm: vec![(BASE_TOOL, L[1], first), (JOINT, L[2], second - first), (PART, L[3], -second)],
            axes: [0, 1],
        },
        _ => {
            let head = usize::from(sides[1] == Side::Head);
            let table = 1 - head;
            Vectors {
                transformation: 56,
                carrier: 'M',
                offsets_mm: vec![
                    (JOINT, L[0], -points[head]),
                    (BASE_TOOL, L[1], points[head]),
                    (JOINT_PART, L[2], points[table]),
                    (PART, L[3], -points[table]),
                ],
                axes: [head, table],
            }
        }
    }
}
