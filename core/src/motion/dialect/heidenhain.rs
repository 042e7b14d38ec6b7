//! Heidenhain conversational words and M codes.

use super::{MotionRules, PlainStatement};
use crate::motion::cycle::{HoleLevels, HoleRules, HoleStroke};
use crate::motion::meaning::{MFunction, Meaning, Statement};
use crate::motion::modal::{MotionMode, Transformation};
use crate::motion::{FeedForm, FeedMode, FeedRules};
use crate::program::{Code, Keyword};
use crate::units::MM_PER_INCH;

/// The meaning of conversational programs.
pub(super) const RULES: MotionRules = MotionRules {
    feed: FEED,
    m: m_function,
    holes: Some(HoleRules {
        levels: HoleLevels::Clearances,
        stroke: hole,
        keeps_feed: true,
        under_tcp: false,
    }),
    keyword: keyword_meaning,
    motion_is_modal: false,
    plain_statement: Some((Keyword::L, PlainStatement::Line)),
    call_keeps_modes: true,
    has_sections: true,
    ..MotionRules::PLAIN
};

/// The meaning of F in conversational programs. They have no inverse time.
const FEED: FeedRules = FeedRules {
    paths: FeedRules::BY_MODE,
    form: FeedForm::Word,
    dwell_may_set_feed: true,
    dwell_times: 0,
    modes: &[(Code::M(1360), FeedMode::PerRevolution, None), (Code::M(1370), FeedMode::PerMinute, None)],
    otherwise: &[],
};

/// The meaning of an M code in tenths. Codes of the machine's builder are assumed to leave the path unchanged.
fn m_function(tenths: u32) -> MFunction {
    match tenths {
        20 | 300 => MFunction::End,
        60 => MFunction::ToolChange,
        890 => MFunction::CycleModal,
        910 => MFunction::MachineCoordinates,
        // M92 counts from a place of the machine's builder, M130 from the plane that is not tilted.
        920 | 1300 => MFunction::OtherCoordinates,
        940 => MFunction::ForgetRotary,
        990 => MFunction::CycleCall,
        1160 => MFunction::RotaryFeedInMm(true),
        1170 => MFunction::RotaryFeedInMm(false),
        1140 | 1440 | 1450 => MFunction::TcpOther,
        // M138 leaves axes out of TCP from the next M128 on.
        1380 => MFunction::KinematicsSwitch,
        1260 => MFunction::ShortestPath(true),
        1270 => MFunction::ShortestPath(false),
        1280 => MFunction::Tcp(true),
        1290 => MFunction::Tcp(false),
        // A retraction along the tool, or the end of a basic rotation: the axes are elsewhere.
        1400 | 1430 => MFunction::Elsewhere,
        code => FEED.mode(Code::M(code)).map_or(MFunction::Plain, |(mode, _)| MFunction::Feed(mode)),
    }
}

/// How a cycle makes its hole: 200 and 240 drill and centre, 201 to 203 go up at a feed, 206, 207 and 209 cut threads.
fn hole(number: u32) -> HoleStroke {
    match number {
        200 | 240 => HoleStroke::Drill,
        201..=203 => HoleStroke::Ream,
        206 | 207 | 209 => HoleStroke::Tap,
        _ => HoleStroke::Other,
    }
}

/// The meaning of a statement word.
fn keyword_meaning(keyword: Keyword) -> Meaning {
    use Keyword as K;
    let statement = match keyword {
        K::L | K::Ln => return Meaning::Motion(MotionMode::Linear),
        K::ArcOfRadius => return Meaning::Motion(MotionMode::Arc),
        // The M code of a retraction moves.
        K::CircleCentre | K::Statement | K::Sense | K::RetractToLimit | K::RetractToLimitAtFeed => {
            return Meaning::Harmless;
        }
        K::R0 => return Meaning::Compensation(false),
        K::RadiusCompensation => return Meaning::Compensation(true),
        K::BeginMm => return Meaning::Units(1.0),
        K::BeginInch => return Meaning::Units(MM_PER_INCH),
        K::TiltOn => return Meaning::Transform(Transformation::Tilt, true),
        K::RotationOn => return Meaning::Transform(Transformation::Rotation, true),
        K::RotationOff => return Meaning::Transform(Transformation::Rotation, false),
        K::MirrorOn => return Meaning::Transform(Transformation::Mirror, true),
        K::MirrorOff => return Meaning::Transform(Transformation::Mirror, false),
        K::ScalingOn => return Meaning::Transform(Transformation::Scaling, true),
        K::ScalingOff => return Meaning::Transform(Transformation::Scaling, false),
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
        K::CycleCallHere => Statement::CycleCallHere,
        K::Hole => Statement::DefineHole,
        K::OtherCycle => Statement::OtherCycle,
        K::Probe => Statement::Probe,
        _ => return Meaning::Unknown,
    };
    Meaning::Statement(statement)
}
