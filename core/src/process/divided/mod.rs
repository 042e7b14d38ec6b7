//! Blocks that are divided into parts: which parts they have, how these are written, and what must hold when they are
//! read back. The steps that divide decide where.

mod block;
mod checked;
mod contact_ends;
mod division;
mod write;

pub(in crate::process) use block::{DividedBlock, LAST_BIT};
pub(in crate::process) use checked::Checked;
pub(in crate::process) use contact_ends::node_contact;
pub(in crate::process) use division::{Division, resolution, unfit_feed};
pub(in crate::process) use write::write_division;
