//! APT statement words.

use super::{MotionRules, PlainStatement};
use crate::motion::meaning::{Meaning, Statement};
use crate::motion::modal::{ToolLength, Transformation};
use crate::motion::{FeedForm, FeedMode, FeedPath, FeedPaths, FeedRules};
use crate::program::{Code, Keyword};
use crate::units::MM_PER_INCH;

/// The meaning of cutter location data: points of the tip with the tool's axis.
pub(super) const RULES: MotionRules = MotionRules {
    feed: FEED,
    keyword: keyword_meaning,
    tool_length: ToolLength::Vector,
    motion_is_modal: false,
    plain_statement: Some((Keyword::Goto, PlainStatement::Point)),
    call_keeps_modes: true,
    unknown_is_final: true,
    is_of_points: true,
    ..MotionRules::PLAIN
};

/// The meaning of F in cutter location data, whose points are tips.
const FEED: FeedRules = FeedRules {
    paths: FeedPaths { machine: FeedPath::Tip, tcp: FeedPath::Tip },
    form: FeedForm::Statement,
    dwell_may_set_feed: true,
    dwell_times: 0,
    modes: &[
        (Code::Keyword(Keyword::MmPerMinute), FeedMode::PerMinute, Some(1.0)),
        (Code::Keyword(Keyword::InchPerMinute), FeedMode::PerMinute, Some(MM_PER_INCH)),
        (Code::Keyword(Keyword::UnitPerMinute), FeedMode::PerMinute, None),
        (Code::Keyword(Keyword::MmPerRevolution), FeedMode::PerRevolution, Some(1.0)),
        (Code::Keyword(Keyword::InchPerRevolution), FeedMode::PerRevolution, Some(MM_PER_INCH)),
        (Code::Keyword(Keyword::UnitPerRevolution), FeedMode::PerRevolution, None),
    ],
    otherwise: &[],
};

/// The meaning of a statement word.
fn keyword_meaning(keyword: Keyword) -> Meaning {
    use Keyword as K;
    let statement = match keyword {
        K::PostWord | K::Cutter => return Meaning::Harmless,
        K::R0 => return Meaning::Compensation(false),
        K::RadiusCompensation => return Meaning::Compensation(true),
        K::BeginMm => return Meaning::Units(1.0),
        K::BeginInch => return Meaning::Units(MM_PER_INCH),
        K::PointsMoved => return Meaning::Transform(Transformation::Rotation, true),
        K::Goto => Statement::Point,
        K::From => Statement::From,
        K::Rapid => Statement::NextRapid,
        K::Circle => Statement::Circle,
        K::Fedrat => Statement::Feedrate,
        K::FeedElsewhere => Statement::OtherFeed,
        K::CycleOn => Statement::InCycle(true),
        K::CycleOff => Statement::InCycle(false),
        K::MultaxOn => Statement::Multax(true),
        K::MultaxOff => Statement::Multax(false),
        K::ToolAxis => Statement::ToolAxis,
        K::CoordinateSystem => Statement::CoordinateSystem,
        K::WorldPoints => Statement::WorldPoints,
        K::GoHome => Statement::GoHome,
        K::SurfaceMotion => Statement::Contour,
        K::ToolCall => Statement::ToolCall,
        K::EndPgm => Statement::End,
        other => match FEED.mode(Code::Keyword(other)) {
            Some((mode, mm_per_unit)) => Statement::FeedUnit(mode, mm_per_unit),
            None => return Meaning::Unknown,
        },
    };
    Meaning::Statement(statement)
}
