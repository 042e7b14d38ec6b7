//! Sinumerik codes and statement words.

use super::{Code, MCode, MotionMode, ProgramFrame, Statement, ToolLength, Transformation};
use crate::motion::FeedRules;
use crate::program::{Dialect, Keyword};
use crate::units::MM_PER_INCH;

/// The meaning of the G code of so many tenths.
pub(super) fn meaning(tenths: u32) -> Code {
    use Code::{
        Compensation, Feed, Harmless, Incremental, MachineCoordinates, Motion, MotionWithAxes, NoMotion,
        OtherShift, Plane, Reference, Units, Unknown, WorkOffset,
    };
    use MotionMode::{Arc, Linear, Rapid, Thread};
    match tenths {
        0 => Motion(Rapid),
        10 => Motion(Linear),
        20 | 30 => Motion(Arc),
        330 | 340 | 350 | 3310 | 3320 | 3350 | 3360 => Motion(Thread),
        // Tapping with a compensating chuck; approaching and leaving smoothly.
        630 | 1470 | 1480 | 2470 | 2480 | 3470 | 3480 => MotionWithAxes(Thread),
        // Dwell, limits of the working area and of the spindle, poles of polar words.
        40 | 250 | 260 | 1100 | 1110 | 1120 => NoMotion,
        170 => Plane(2),
        180 => Plane(1),
        190 => Plane(0),
        400 => Compensation(false),
        410 | 420 => Compensation(true),
        // F is taken in the same unit.
        700 | 7000 => Units(MM_PER_INCH),
        710 | 7100 => Units(1.0),
        530 | 1530 => MachineCoordinates,
        540 | 550 | 560 | 570 | 5000 => WorkOffset,
        5050..=5990 if tenths.is_multiple_of(10) => WorkOffset,
        // Parts of the programmable frame, which no reset of it takes back for certain.
        580 | 590 => OtherShift,
        740 | 750 => Reference,
        900 => Incremental(false),
        910 => Incremental(true),
        90 => Code::ExactStopHere,
        600 => Code::ExactStop(true),
        640 | 6410 | 6420 | 6430 | 6440 | 6450 => Code::ExactStop(false),
        // How exact a stop is; corners and ends of compensated contours; ISO mode off.
        6010 | 6020 | 6030 | 620 | 6210 | 4500 | 4510 | 4600 | 4610 | 4620 | 1400 | 1410 | 1420 | 1430
        | 3400 | 3410 | 2900 | 9620 | 9720 => Harmless,
        code => FeedRules::of(Dialect::Siemens).g_mode(code).map_or(Unknown, Feed),
    }
}

/// The meaning of an M code of so many tenths.
pub(super) fn m_meaning(tenths: u32) -> MCode {
    match tenths {
        20 | 170 | 300 => MCode::End,
        60 => MCode::ToolChange,
        _ => MCode::Plain,
    }
}

/// The meaning of a statement word.
pub(super) fn keyword_meaning(keyword: Keyword) -> Code {
    use Transformation::{Cylinder, Diameter, Orientation, PartFrame, PointToPoint, ToolFrame};
    match keyword {
        Keyword::Traori => Code::ToolLength(ToolLength::Tcp),
        Keyword::OtherTraori => Code::ToolLength(ToolLength::OtherTcp),
        Keyword::Turns => Code::Statement(Statement::FurtherTurns),
        Keyword::Trafoof => Code::ToolLength(ToolLength::Plain),
        Keyword::Supa => Code::MachineCoordinates,
        Keyword::OtherTransformation => Code::Transform(Cylinder, true),
        Keyword::Trans => Code::ProgramFrame(ProgramFrame::Offset, false),
        Keyword::Atrans => Code::ProgramFrame(ProgramFrame::Offset, true),
        Keyword::Rot => Code::ProgramFrame(ProgramFrame::Rotation, false),
        Keyword::Arot => Code::ProgramFrame(ProgramFrame::Rotation, true),
        Keyword::Scale => Code::ProgramFrame(ProgramFrame::Scaling, false),
        Keyword::Ascale => Code::ProgramFrame(ProgramFrame::Scaling, true),
        Keyword::Mirror => Code::ProgramFrame(ProgramFrame::Mirror, false),
        Keyword::Amirror => Code::ProgramFrame(ProgramFrame::Mirror, true),
        Keyword::ToolFrame => Code::Transform(ToolFrame, true),
        Keyword::ToolFrameOff => Code::Transform(ToolFrame, false),
        Keyword::PartFrame => Code::Transform(PartFrame, true),
        Keyword::PartFrameOff => Code::Transform(PartFrame, false),
        Keyword::Swivel => Code::Swivel(true),
        Keyword::SwivelOff => Code::Swivel(false),
        Keyword::PointToPoint => Code::Transform(PointToPoint, true),
        Keyword::PointToPointOff => Code::Transform(PointToPoint, false),
        Keyword::OrientationPath => Code::Transform(Orientation, true),
        Keyword::OrientationAxes => Code::Transform(Orientation, false),
        Keyword::OrientationMachine => Code::VectorsInMachine(true),
        Keyword::OrientationWorkpiece => Code::VectorsInMachine(false),
        Keyword::OrientationWord => Code::OrientationWord,
        Keyword::Diameter => Code::Transform(Diameter, true),
        Keyword::DiameterOff => Code::Transform(Diameter, false),
        Keyword::Spline => Code::Motion(MotionMode::Spline),
        Keyword::Cycle => Code::Cycle,
        Keyword::ModalCycle => Code::ModalCycle,
        Keyword::ModalCall | Keyword::ContourTable => Code::ModalCall,
        Keyword::ModalCallEnd => Code::EndModalCall,
        Keyword::Probing => Code::Probing,
        Keyword::PolarEnd => Code::PolarEnd,
        // What is still `Named` here, nobody has told.
        Keyword::MachineAxis | Keyword::Named => Code::OtherAxis,
        Keyword::ForeignAxis | Keyword::OtherCourse => Code::ForeignWord,
        Keyword::Assigned | Keyword::Declaration | Keyword::PlaneAngle => Code::Harmless,
        Keyword::BlockWord => Code::BlockWord,
        Keyword::ToolOffset => Code::ToolOffset,
        Keyword::CornerRounding => Code::RoundsCorners(true),
        Keyword::CornerRoundingOff => Code::RoundsCorners(false),
        Keyword::AxisPreset => Code::OtherShift,
        Keyword::Reposition => Code::Elsewhere,
        _ => Code::Unknown,
    }
}
