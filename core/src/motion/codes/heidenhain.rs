//! Heidenhain conversational words and M codes.

use super::{Code, MCode, MotionMode, Statement, Transformation};
use crate::motion::FeedRules;
use crate::program::{Dialect, Keyword};
use crate::units::MM_PER_INCH;

/// The meaning of an M code of so many tenths. Those of the machine's builder are taken to leave the path alone.
pub(super) fn m_meaning(tenths: u32) -> MCode {
    match tenths {
        20 | 300 => MCode::End,
        60 => MCode::ToolChange,
        890 => MCode::CycleModal,
        // M91 and M92 count from other places, M130 from the plane that is not tilted.
        910 | 920 | 1300 => MCode::MachineCoordinates,
        940 => MCode::ForgetRotary,
        990 => MCode::CycleCall,
        1160 => MCode::RotaryFeedInMm(true),
        1170 => MCode::RotaryFeedInMm(false),
        1140 | 1440 | 1450 => MCode::TcpOther,
        // Axes are left out of TCP from the next M128 on.
        1380 => MCode::KinematicsSwitch,
        1260 => MCode::ShortestPath(true),
        1270 => MCode::ShortestPath(false),
        1280 => MCode::Tcp(true),
        1290 => MCode::Tcp(false),
        // A retraction along the tool, a basic rotation that goes: the axes stand elsewhere.
        1400 | 1430 => MCode::Elsewhere,
        code => FeedRules::of(Dialect::Heidenhain).m_mode(code).map_or(MCode::Plain, MCode::Feed),
    }
}

/// The meaning of a statement word.
pub(super) fn keyword_meaning(keyword: Keyword) -> Code {
    use Keyword as K;
    let statement = match keyword {
        K::L | K::Ln => return Code::Motion(MotionMode::Linear),
        K::ArcOfRadius => return Code::Motion(MotionMode::Arc),
        K::CircleCentre | K::Statement | K::Sense => return Code::Harmless,
        K::R0 => return Code::Compensation(false),
        K::RadiusCompensation => return Code::Compensation(true),
        K::BeginMm => return Code::Units(1.0),
        K::BeginInch => return Code::Units(MM_PER_INCH),
        K::TiltOn => return Code::Transform(Transformation::Tilt, true),
        K::RotationOn => return Code::Transform(Transformation::Rotation, true),
        K::RotationOff => return Code::Transform(Transformation::Rotation, false),
        K::MirrorOn => return Code::Transform(Transformation::Mirror, true),
        K::MirrorOff => return Code::Transform(Transformation::Mirror, false),
        K::ScalingOn => return Code::Transform(Transformation::Scaling, true),
        K::ScalingOff => return Code::Transform(Transformation::Scaling, false),
        K::AxisScaling => Statement::AxisScaling,
        K::ArcAboutCentre => Statement::ArcAboutCentre,
        K::TangentArc => Statement::TangentArc,
        K::ContourElement => Statement::Contour,
        K::CornerFollows => Statement::Corner,
        K::Fmax => Statement::RapidHere,
        K::FeedElsewhere => Statement::OtherFeed,
        K::EndPgm => Statement::End,
        K::ToolCall => Statement::ToolCall,
        K::OtherToolAxis => Statement::OtherToolAxis,
        K::DatumShift => Statement::DatumShift,
        K::DatumReset => Statement::DatumReset,
        K::DatumTable => Statement::DatumTable,
        K::Preset => Statement::Preset,
        K::TiltOff => Statement::TiltOff,
        K::TcpmOn => Statement::Tcp(true),
        K::TcpmOff => Statement::Tcp(false),
        K::TcpmOther => Statement::TcpOther,
        K::Label => Statement::Label,
        K::LabelEnd => Statement::LabelEnd,
        K::CallLabel => Statement::CallLabel,
        K::RepeatLabel => Statement::RepeatLabel,
        K::CycleCall => Statement::CycleCall,
        K::Probe => Statement::Probe,
        _ => return Code::Unknown,
    };
    Code::Statement(statement)
}
