//! Heidenhain conversational words.

use super::{Code, MCode, MotionMode};
use crate::program::Keyword;

/// The meaning of an M code of so many tenths.
pub(super) fn m_meaning(tenths: u32) -> MCode {
    match tenths {
        20 | 300 => MCode::End,
        _ => MCode::Plain,
    }
}

/// The meaning of a statement word.
pub(super) fn keyword_meaning(keyword: Keyword) -> Code {
    match keyword {
        Keyword::L => Code::Motion(MotionMode::Linear),
        _ => Code::Unknown,
    }
}
