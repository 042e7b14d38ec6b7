//! The contact between cutter and part: its point, its deviation from its line, and the correction of that
//! deviation.
//!
//! Everything here works on motions, not on text. A block is a [`Segment`] between two [`Station`]s. A [`Carry`]
//! moves the contact between its ends. The [`ContactLine`] of the source is the line it should follow.

mod assumed;
mod carry;
mod curvature;
mod cutter_body;
mod cutter_contact;
mod deviation;
mod effort;
mod feed;
mod from_surface;
mod quick;
mod repair;
mod sampling;
mod segment;
mod subdivision;
mod tip_looks;

pub use assumed::{feed_direction, feed_plane_normal};
pub use carry::Carry;
pub use cutter_body::{CutterBody, CutterBodyFault};
pub use cutter_contact::{ContactFault, CutterContact, Touch};
pub use deviation::{ContactLine, Deviation};
pub use effort::{Effort, EffortEnd};
pub use feed::{BlockTime, block_time_s, feed_word};
pub use from_surface::{PartSurface, SurfaceContact, contact_on_surface, nearest_to_cutter};
pub use quick::{QuickLook, quick_look};
pub use repair::{Correction, repaired_tip_mm};
pub use sampling::{Sampled, sample_until_sure, within_tolerance};
pub use segment::{Segment, SourceBlock, Station, rotary_rad, stated_point_mm};
pub use subdivision::{Node, Resolution, divide, nodes, prove, segments};
pub use tip_looks::{TipLook, TipPaths, look_at_tips};
