//! ISO 6983 and RS274 codes.

use super::{Code, MCode, MotionMode, ToolLength, Transformation};
use crate::motion::FeedRules;
use crate::program::Dialect;
use crate::units::MM_PER_INCH;

/// User codes by which RS274 machines switch their kinematics: linear positions are lost, and what is interpolated
/// is not known unless stated.
const KINEMATICS_SWITCHES: std::ops::RangeInclusive<u32> = 4280..=4300;

/// The meaning of an M code of so many tenths.
pub(super) fn m_meaning(tenths: u32) -> MCode {
    match tenths {
        20 | 300 => MCode::End,
        990 => MCode::Return,
        960 | 970 | 980 | 1980 => MCode::Call,
        60 | 610 => MCode::ToolChange,
        // M72: RS274 controls give back what M70 kept.
        720 => MCode::RestoresModes,
        820 => MCode::ExtruderAbsolute,
        830 => MCode::ExtruderRelative,
        code if KINEMATICS_SWITCHES.contains(&code) => MCode::KinematicsSwitch,
        _ => MCode::Plain,
    }
}

/// The meaning of the code of so many tenths.
pub(super) fn meaning(tenths: u32) -> Code {
    use Code::{
        Call, Compensation, Elsewhere, EndCycle, EndModalCall, Feed, Harmless, Incremental,
        MachineCoordinates, ModalCall, Motion, MotionWithAxes, NoMotion, OtherShift, Plane, Reference, Shift,
        Transform, Units, Unknown, WorkOffset, WriteOffsets,
    };
    use MotionMode::{Arc, Cycle, Linear, Probing, Rapid, Spline, Thread};
    use Transformation::{Cylinder, Mirror, PolarInterpolation, PolarWords, Rotation, Scaling, Tilt};
    match tenths {
        0 => Motion(Rapid),
        10 => Motion(Linear),
        20 | 30 => Motion(Arc),
        40 | 220 | 230 => NoMotion,
        // G5.2: the blocks behind it, up to another motion, are points that the curve is drawn by.
        52 => Motion(Spline),
        50 | 51 | 60 | 61 | 62 => MotionWithAxes(Spline),
        // Among them the sense of I J K (G90.1), which no end depends on.
        53 | 80 | 81 | 110 | 250 | 260 | 390 | 620 | 630 | 901 | 911 | 960 | 970 | 980 | 990 | 1030
        | 1870 => Harmless,
        90 => Code::ExactStopHere,
        610..=612 => Code::ExactStop(true),
        640 => Code::ExactStop(false),
        70 | 71 | 1070 => Transform(Cylinder, true),
        100 => WriteOffsets,
        121 | 1120 => Transform(PolarInterpolation, true),
        131 | 1130 => Transform(PolarInterpolation, false),
        150 => Transform(PolarWords, false),
        160 => Transform(PolarWords, true),
        170 | 171 => Plane(2),
        180 | 181 => Plane(1),
        190 | 191 => Plane(0),
        200 | 700 => Units(MM_PER_INCH),
        210 | 710 => Units(1.0),
        280 | 300 | 301 => Reference,
        270 | 290 | 360 | 370 | 531..=536 => Elsewhere,
        310..=319 | 380..=389 => Motion(Probing),
        330..=332 | 340 => Motion(Thread),
        400 => Compensation(false),
        410..=429 => Compensation(true),
        430..=432 | 440 | 490 | 491 => Code::ToolLength(ToolLength::Plain),
        434 | 2340 => Code::ToolLength(ToolLength::Tcp),
        435 => Code::ToolLength(ToolLength::Vector),
        450..=489 | 600 => MotionWithAxes(Thread),
        500 => Transform(Scaling, false),
        510 => Transform(Scaling, true),
        501 => Transform(Mirror, false),
        511 => Transform(Mirror, true),
        520 | 920 => Shift,
        530 => MachineCoordinates,
        540..=599 | 1540 => WorkOffset,
        650 => Call,
        660 | 661 => ModalCall,
        670 => EndModalCall,
        // G69 ends these as well.
        682..=684 => Transform(Tilt, true),
        680..=689 => Transform(Rotation, true),
        690..=699 => Transform(Rotation, false),
        730 | 740 | 760 | 810..=899 => Motion(Cycle),
        800 => EndCycle,
        900 => Incremental(false),
        910 => Incremental(true),
        921..=923 => OtherShift,
        code => FeedRules::of(Dialect::Iso).g_mode(code).map_or(Unknown, Feed),
    }
}
