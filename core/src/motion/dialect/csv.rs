//! Tables: every row is a straight motion in millimetres.

use super::{MotionRules, ToolRules, iso};
use crate::motion::modal::MotionMode;
use crate::motion::{FeedForm, FeedRules};

/// The meaning of the rows of a table.
pub(super) const RULES: MotionRules = MotionRules {
    feed: FeedRules { form: FeedForm::Cell, ..iso::FEED },
    g: iso::g_meaning,
    m: iso::m_function,
    motion: Some(MotionMode::Linear),
    counts_in_mm: true,
    tools: ToolRules::CHANGED_BY_M6,
    ..MotionRules::PLAIN
};
