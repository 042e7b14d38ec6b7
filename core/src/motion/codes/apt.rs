//! APT statement words.

use super::{Code, MotionMode, Statement, Transformation};
use crate::motion::FeedRules;
use crate::program::{Dialect, Keyword};
use crate::units::MM_PER_INCH;

/// The meaning of a statement word.
pub(super) fn keyword_meaning(keyword: Keyword) -> Code {
    use Keyword as K;
    let statement = match keyword {
        K::PostWord | K::Cutter => return Code::Harmless,
        K::R0 => return Code::Compensation(false),
        K::RadiusCompensation => return Code::Compensation(true),
        K::BeginMm => return Code::Units(1.0),
        K::BeginInch => return Code::Units(MM_PER_INCH),
        K::PointsMoved => return Code::Transform(Transformation::Rotation, true),
        K::Goto => Statement::Point,
        K::From => Statement::From,
        K::Rapid => Statement::Next(MotionMode::Rapid),
        K::Circle => Statement::Next(MotionMode::Arc),
        K::Fedrat => Statement::Feedrate,
        K::FeedElsewhere => Statement::OtherFeed,
        K::CycleOn => Statement::InCycle(true),
        K::CycleOff => Statement::InCycle(false),
        K::MultaxOn => Statement::Multax(true),
        K::MultaxOff => Statement::Multax(false),
        K::ToolAxis => Statement::ToolAxis,
        K::CoordinateSystem => Statement::CoordinateSystem,
        K::GoHome => Statement::GoHome,
        K::SurfaceMotion => Statement::Contour,
        K::ToolCall => Statement::ToolCall,
        K::EndPgm => Statement::End,
        other => match FeedRules::of(Dialect::Apt).word(other) {
            Some((mode, mm_per_unit)) => Statement::FeedUnit(mode, mm_per_unit),
            None => return Code::Unknown,
        },
    };
    Code::Statement(statement)
}
