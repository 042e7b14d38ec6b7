//! Where cutter contacts come from.

/// The source of the contact at the ends of blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactSource {
    /// The first available of program, normals and surface, otherwise the tip.
    #[default]
    Auto,
    /// U V W words.
    Program,
    /// Contact normals carried with the program (CSV columns nx ny nz).
    Normals,
    /// P0's rule: from the feed direction, where rotary axes turn. It is an assumption, and the
    /// report says so.
    FeedPlane,
    /// The contact between the cutter and the part's surface, if the surface is sent with the
    /// program.
    Surface,
    /// The tool tip itself.
    Tip,
}

impl ContactSource {
    /// In a finishing pass the feed turns by a few degrees from block to block. At a link or a corner it turns by
    /// more than this.
    pub const PASS_BREAK_DEG: f64 = 15.0;

    /// The name in the contract.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Program => "program",
            Self::Normals => "normals",
            Self::FeedPlane => "feed-plane",
            Self::Surface => "surface",
            Self::Tip => "tip",
        }
    }
}
