//! A block whose deviation was computed, with everything that its parts need.

use crate::contact::{CutterContact, Sampled, SourceBlock};
use crate::geometry::Vec3;

/// A motion that is to be divided.
#[derive(Debug, Clone)]
pub(in crate::process) struct Checked<'a> {
    pub(in crate::process) block: SourceBlock<'a>,
    pub(in crate::process) before: Sampled,
    /// U V W words gave the contacts, so inserted blocks get U V W of the target contact.
    pub(in crate::process) contact_from_words: bool,
    /// U V W or nx ny nz at the start. If the start point states none, the last words stated before it still hold.
    pub(in crate::process) start_contact: Option<[f64; 3]>,
    /// Where the tool touches at both ends.
    pub(in crate::process) contacts: [CutterContact; 2],
    /// The feed of the pass, for a motion whose own tip does not show its feed.
    pub(in crate::process) pass_feed: Option<Vec3>,
}
