//! Where cutter contacts come from.

/// Where the contact at the block ends comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactSource {
    /// The first available of program, normals and surface, else the tip.
    #[default]
    Auto,
    /// U V W words.
    Program,
    /// Contact normals carried with the program (CSV columns nx ny nz).
    Normals,
    /// P0's rule from the feed direction, where rotary axes turn; an assumption, reported as such.
    FeedPlane,
    /// The part's surface, where it comes with the program: where the cutter touches it.
    Surface,
    /// The tool tip itself.
    Tip,
}

impl ContactSource {
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
