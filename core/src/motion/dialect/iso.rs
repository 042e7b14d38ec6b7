//! ISO 6983 and RS274 codes.

use super::{MotionRules, ToolRules, ToolWords};
use crate::motion::cycle::{Retract, Stroke};
use crate::motion::meaning::{MFunction, Meaning};
use crate::motion::modal::{MotionMode, ToolLength, Transformation};
use crate::motion::work_offset::OffsetCode;
use crate::motion::{FeedForm, FeedMode, FeedRules, WorkOffset};
use crate::program::{Address, Code};
use crate::units::MM_PER_INCH;

/// The meaning of ISO programs. Controls that count millimetres and degrees of a block together are not distinguished.
pub(super) const RULES: MotionRules = MotionRules {
    feed: FEED,
    g: g_meaning,
    m: m_function,
    cycles: Some(stroke),
    tool_words: ToolWords::LengthByH,
    counts_points: true,
    takes_ijk_as_vector: true,
    two_codes_conflict: true,
    first_offset: Some(WorkOffset::G54),
    has_rs274_codes: true,
    reference_passes_point: true,
    tools: ToolRules { m61_sets: true, second_t_changes: true, ..ToolRules::CHANGED_BY_M6 },
    ..MotionRules::PLAIN
};

/// The meaning of F in ISO programs.
pub(super) const FEED: FeedRules = FeedRules {
    paths: FeedRules::BY_MODE,
    form: FeedForm::Word,
    dwell_may_set_feed: true,
    dwell_times: Address::X.bit() | Address::U.bit(),
    modes: &[
        (Code::G(930), FeedMode::InverseTime, None),
        (Code::G(940), FeedMode::PerMinute, None),
        (Code::G(950), FeedMode::PerRevolution, None),
    ],
    otherwise: &[Code::G(200), Code::G(210), Code::G(700), Code::G(710), Code::G(960), Code::G(970)],
};

/// User codes with which RS274 machines switch their kinematics. The linear positions are lost, and the interpolation
/// is not known unless it is stated.
const KINEMATICS_SWITCHES: std::ops::RangeInclusive<u32> = 4280..=4300;

/// The meaning of an M code in tenths.
pub(super) fn m_function(tenths: u32) -> MFunction {
    match tenths {
        20 | 300 => MFunction::End,
        990 => MFunction::Return,
        960 | 970 | 980 | 1980 => MFunction::Call,
        60 | 610 => MFunction::ToolChange,
        // M72: RS274 controls restore the modes that M70 kept.
        720 => MFunction::Unknown,
        820 => MFunction::ExtruderAbsolute,
        830 => MFunction::ExtruderRelative,
        code if KINEMATICS_SWITCHES.contains(&code) => MFunction::KinematicsSwitch,
        _ => MFunction::Plain,
    }
}

/// How a canned cycle drills. G73 and G83 break chips, G82 and G89 wait, G86 stops the spindle. G74 and G84 cut threads,
/// and the spindle turns back on the way up.
/// G76 and G87 move aside, and G88 is moved out by hand.
fn stroke(code: Code) -> Option<Stroke> {
    match code {
        Code::G(810 | 820 | 860) => Some(Stroke::Drill),
        Code::G(730 | 830) => Some(Stroke::Peck),
        Code::G(740 | 840 | 850 | 890) => Some(Stroke::Bore),
        Code::G(760 | 810..=899) => Some(Stroke::Other),
        _ => None,
    }
}

/// The meaning of a G code in tenths.
pub(super) fn g_meaning(tenths: u32) -> Meaning {
    use Meaning::{
        Call, Compensation, CompensationByDiameter, CompensationByRegister, CylinderOfAxis, Elsewhere,
        EndCycle, EndModalCall, EndPolarOrOffset, EndRotation, EndScaling, EndShift, ExactStop,
        ExactStopHere, Feed, Harmless, HarmlessUnlessAxes, HypotheticalAxis, Incremental, LengthAlongTool,
        LocalShift, MachineCoordinates, MirrorNamed, ModalCall, ModeByP, Motion, MotionWithAxes, NoMotion,
        OtherShift, Plane, Reference, Shift, TipControl, Transform, Units, UnitsUnlessCycle, Unknown,
        WorkOffsetByP, WriteOffsets,
    };
    use MotionMode::{Arc, Cycle, Linear, Probing, Rapid, Spline, Thread};
    use Transformation::{
        Cylinder, FixtureOffset, PolarInterpolation, PolarWords, Rotation, Scaling, SetupError, Tilt,
    };
    match tenths {
        0 => Motion(Rapid),
        10 => Motion(Linear),
        20 | 30 => Motion(Arc),
        40 | 220 | 230 => NoMotion,
        // G5.2: the blocks after it, up to another motion, are points that define the curve.
        52 => Motion(Spline),
        50 | 51 | 60 | 61 | 62 => MotionWithAxes(Spline),
        // Among them is the sense of I J K (G90.1). No end depends on it.
        53 | 80 | 81 | 250 | 260 | 630 | 901 | 911 | 960 | 970 | 1030 | 1870 => Harmless,
        110 | 620 => HarmlessUnlessAxes,
        90 => ExactStopHere,
        610..=612 => ExactStop(true),
        640 => ExactStop(false),
        70 => HypotheticalAxis,
        // G7.1.
        71 => Transform(Cylinder, true),
        1070 => CylinderOfAxis,
        100 => WriteOffsets,
        121 | 1120 => Transform(PolarInterpolation, true),
        131 | 1130 => Transform(PolarInterpolation, false),
        150 => EndPolarOrOffset,
        160 => Transform(PolarWords, true),
        170 | 171 => Plane(2),
        180 | 181 => Plane(1),
        190 | 191 => Plane(0),
        200 => Units(MM_PER_INCH),
        210 => Units(1.0),
        700 => UnitsUnlessCycle(MM_PER_INCH),
        710 => UnitsUnlessCycle(1.0),
        280 | 300 | 301 => Reference,
        281 => Meaning::StoreReference,
        531 => Meaning::ToPlane,
        270 | 290 | 360 | 370 | 532..=536 => Elsewhere,
        310..=319 | 380..=389 => Motion(Probing),
        330..=332 | 340 => Motion(Thread),
        400 => Compensation(false),
        411 | 421 => CompensationByDiameter { left: tenths == 411 },
        410 | 420 => CompensationByRegister { left: tenths == 410 },
        410..=429 => Compensation(true),
        431 => LengthAlongTool,
        430 | 432 | 440 => Meaning::ToolLength(ToolLength::Plain),
        490 | 491 => TipControl(ToolLength::Plain),
        434 | 2340 => TipControl(ToolLength::Tcp),
        435 => TipControl(ToolLength::Vector),
        390 | 450..=489 | 600 => MotionWithAxes(Thread),
        500 => EndScaling,
        510 => Transform(Scaling, true),
        501 => MirrorNamed(false),
        511 => MirrorNamed(true),
        520 => LocalShift,
        920 => Shift,
        530 => MachineCoordinates,
        540 | 541 | 1540 => WorkOffsetByP(OffsetCode::of_tenths(tenths)),
        542 => ModeByP(FixtureOffset),
        544 => ModeByP(SetupError),
        543 | 545..=599 => Meaning::WorkOffset(OffsetCode::of_tenths(tenths)),
        650 => Call,
        660 | 661 => ModalCall,
        670 => EndModalCall,
        // G69 also ends these.
        682..=684 => Transform(Tilt, true),
        680..=689 => Transform(Rotation, true),
        690..=699 => EndRotation { names_axes: tenths == 690 },
        730 | 740 | 760 | 810..=899 => Motion(Cycle),
        800 => EndCycle,
        980 => Meaning::CycleRetract(Retract::Initial),
        990 => Meaning::CycleRetract(Retract::Plane),
        900 => Incremental(false),
        910 => Incremental(true),
        921 | 922 => EndShift,
        923 => OtherShift,
        code => FEED.mode(Code::G(code)).map_or(Unknown, |(mode, _)| Feed(mode)),
    }
}
