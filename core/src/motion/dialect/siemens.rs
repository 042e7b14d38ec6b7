//! Sinumerik codes and statement words.

use super::{MotionRules, ToolRules, ToolWords};
use crate::motion::cycle::{HoleLevels, HoleRules, HoleStroke};
use crate::motion::meaning::{MFunction, Meaning, ProgramFrame, Statement};
use crate::motion::modal::{MotionMode, ToolLength, Transformation};
use crate::motion::work_offset::OffsetCode;
use crate::motion::{FeedForm, FeedMode, FeedRules};
use crate::program::{Code, Keyword};
use crate::units::MM_PER_INCH;

/// The meaning of Sinumerik programs.
pub(super) const RULES: MotionRules = MotionRules {
    feed: FEED,
    g: g_meaning,
    m: m_function,
    holes: Some(HoleRules { levels: HoleLevels::Planes, stroke: hole, keeps_feed: false, under_tcp: true }),
    keyword: keyword_meaning,
    tool_words: ToolWords::EdgeByTAndD,
    two_codes_conflict: true,
    tools: ToolRules { t_may_change: true, d_is_edge: true, ..ToolRules::CHANGED_BY_M6 },
    ..MotionRules::PLAIN
};

/// The meaning of F in Sinumerik programs. The default of FGROUP is the geometry axes; under TRAORI these are the axes
/// of the tip.
const FEED: FeedRules = FeedRules {
    paths: FeedRules::BY_MODE,
    form: FeedForm::Word,
    dwell_may_set_feed: false,
    dwell_times: 0,
    modes: &[
        (Code::G(930), FeedMode::InverseTime, None),
        (Code::G(940), FeedMode::PerMinute, None),
        (Code::G(9610), FeedMode::PerMinute, None),
        (Code::G(9710), FeedMode::PerMinute, None),
        (Code::G(950), FeedMode::PerRevolution, None),
        (Code::G(960), FeedMode::PerRevolution, None),
        (Code::G(970), FeedMode::PerRevolution, None),
        (Code::G(9730), FeedMode::PerRevolution, None),
    ],
    otherwise: &[Code::G(700), Code::G(710), Code::G(7000), Code::G(7100)],
};

/// The meaning of a G code in tenths.
fn g_meaning(tenths: u32) -> Meaning {
    use Meaning::{
        Compensation, Feed, Harmless, Incremental, MachineCoordinates, Motion, MotionWithAxes, NoMotion,
        OtherShift, Plane, Reference, Units, Unknown, WorkOffset, WorkOffsetByP,
    };
    use MotionMode::{Arc, Linear, Rapid, Thread};
    match tenths {
        0 => Motion(Rapid),
        10 => Motion(Linear),
        20 | 30 => Motion(Arc),
        330 | 340 | 350 | 3310 | 3320 | 3350 | 3360 => Motion(Thread),
        // Tapping with a compensating chuck, and smooth approach and retraction.
        630 | 1470 | 1480 | 2470 | 2480 | 3470 | 3480 => MotionWithAxes(Thread),
        // Dwell, limits of the working area and of the spindle, and poles of polar words.
        40 | 250 | 260 | 1100 | 1110 | 1120 => NoMotion,
        170 => Plane(2),
        180 => Plane(1),
        190 => Plane(0),
        400 => Compensation(false),
        410 | 420 => Compensation(true),
        // F is taken in the same unit.
        700 | 7000 => Units(MM_PER_INCH),
        710 | 7100 => Units(1.0),
        // G53 leaves the basic frame in force, which no text states.
        530 => Meaning::NearMachineZero,
        1530 => MachineCoordinates,
        540 => WorkOffsetByP(OffsetCode::of_tenths(tenths)),
        550 | 560 | 570 | 5000 => WorkOffset(OffsetCode::of_tenths(tenths)),
        5050..=5990 if tenths.is_multiple_of(10) => WorkOffset(OffsetCode::of_tenths(tenths)),
        // Parts of the programmable frame. No reset of the frame is certain to take them back.
        580 | 590 => OtherShift,
        740 | 750 => Reference,
        900 => Incremental(false),
        910 => Incremental(true),
        90 => Meaning::ExactStopHere,
        600 => Meaning::ExactStop(true),
        640 | 6410 | 6420 | 6430 | 6440 | 6450 => Meaning::ExactStop(false),
        // The precision of a stop; corners and ends of compensated contours; ISO mode off.
        6010 | 6020 | 6030 | 620 | 6210 | 4500 | 4510 | 4600 | 4610 | 4620 | 1400 | 1410 | 1420 | 1430
        | 3400 | 3410 | 2900 | 9620 | 9720 => Harmless,
        code => FEED.mode(Code::G(code)).map_or(Unknown, |(mode, _)| Feed(mode)),
    }
}

/// The meaning of an M code in tenths.
fn m_function(tenths: u32) -> MFunction {
    match tenths {
        20 | 170 | 300 => MFunction::End,
        60 => MFunction::ToolChange,
        _ => MFunction::Plain,
    }
}

/// How a cycle makes its hole. CYCLE83 breaks chips or removes them, CYCLE82, CYCLE88 and CYCLE89 wait at the depth,
/// CYCLE86 to CYCLE88 stop the spindle there. CYCLE84 and CYCLE840 cut threads.
fn hole(number: u32) -> HoleStroke {
    match number {
        81..=83 | 86..=88 => HoleStroke::Drill,
        85 => HoleStroke::Ream,
        89 => HoleStroke::Bore,
        84 | 840 => HoleStroke::Tap,
        _ => HoleStroke::Other,
    }
}

/// The meaning of a statement word.
fn keyword_meaning(keyword: Keyword) -> Meaning {
    use Transformation::{Cylinder, Diameter, Orientation, PartFrame, PointToPoint, ToolFrame};
    match keyword {
        Keyword::Traori => Meaning::SwitchTip(ToolLength::Tcp),
        Keyword::OtherTraori => Meaning::SwitchTip(ToolLength::OtherTcp),
        Keyword::Turns => Meaning::Statement(Statement::FurtherTurns),
        Keyword::Trafoof => Meaning::SwitchTip(ToolLength::Plain),
        Keyword::Supa => Meaning::MachineCoordinates,
        Keyword::OtherTransformation => Meaning::Transform(Cylinder, true),
        Keyword::Trans => Meaning::ProgramFrame(ProgramFrame::Offset, false),
        Keyword::Atrans => Meaning::ProgramFrame(ProgramFrame::Offset, true),
        Keyword::Rot => Meaning::ProgramFrame(ProgramFrame::Rotation, false),
        Keyword::Arot => Meaning::ProgramFrame(ProgramFrame::Rotation, true),
        Keyword::Scale => Meaning::ProgramFrame(ProgramFrame::Scaling, false),
        Keyword::Ascale => Meaning::ProgramFrame(ProgramFrame::Scaling, true),
        Keyword::Mirror => Meaning::ProgramFrame(ProgramFrame::Mirror, false),
        Keyword::Amirror => Meaning::ProgramFrame(ProgramFrame::Mirror, true),
        Keyword::ToolFrame => Meaning::Transform(ToolFrame, true),
        Keyword::ToolFrameOff => Meaning::Transform(ToolFrame, false),
        Keyword::PartFrame => Meaning::Transform(PartFrame, true),
        Keyword::PartFrameOff => Meaning::Transform(PartFrame, false),
        Keyword::Swivel => Meaning::Swivel(true),
        Keyword::SwivelOff => Meaning::Swivel(false),
        Keyword::PointToPoint => Meaning::Transform(PointToPoint, true),
        Keyword::PointToPointOff => Meaning::Transform(PointToPoint, false),
        Keyword::OrientationPath => Meaning::Transform(Orientation, true),
        Keyword::OrientationAxes => Meaning::Transform(Orientation, false),
        Keyword::OrientationMachine => Meaning::VectorsInMachine(true),
        Keyword::OrientationWorkpiece => Meaning::VectorsInMachine(false),
        Keyword::OrientationWord => Meaning::OrientationWord,
        Keyword::Diameter => Meaning::Transform(Diameter, true),
        Keyword::DiameterOff => Meaning::Transform(Diameter, false),
        Keyword::Spline => Meaning::Motion(MotionMode::Spline),
        Keyword::Cycle => Meaning::Cycle,
        Keyword::ModalCycle => Meaning::ModalCycle,
        Keyword::ModalCall | Keyword::ContourTable => Meaning::ModalCall,
        Keyword::ModalCallEnd => Meaning::EndModalCall,
        Keyword::Probing => Meaning::Probing,
        Keyword::PolarEnd => Meaning::PolarEnd,
        // A word that is still `Named` here has no known meaning.
        Keyword::MachineAxis | Keyword::Named => Meaning::OtherAxis,
        Keyword::ForeignAxis | Keyword::OtherCourse => Meaning::ForeignWord,
        // The words of a hole belong to the cycle in the same block.
        Keyword::Assigned | Keyword::Declaration | Keyword::PlaneAngle | Keyword::Hole => Meaning::Harmless,
        Keyword::BlockWord => Meaning::BlockWord,
        Keyword::ToolOffset => Meaning::ToolOffset,
        Keyword::CornerRounding => Meaning::RoundsCorners(true),
        Keyword::CornerRoundingOff => Meaning::RoundsCorners(false),
        Keyword::AxisPreset => Meaning::OtherShift,
        Keyword::Reposition => Meaning::Elsewhere,
        _ => Meaning::Unknown,
    }
}
