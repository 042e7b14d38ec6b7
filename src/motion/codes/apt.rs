//! APT statement words.

use super::{Code, MotionMode};
use crate::program::Keyword;

/// The meaning of a statement word.
pub(super) fn keyword_meaning(keyword: Keyword) -> Code {
    match keyword {
        Keyword::Goto => Code::Motion(MotionMode::Linear),
        _ => Code::Unknown,
    }
}
