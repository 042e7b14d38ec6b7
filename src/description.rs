//! What a described type and a described handler derive.
//!
//! Only tests make the description of the interface; the binary has the committed file. So only a test build has the
//! derives of `utoipa`. Every other build has derives of the same names that add nothing, and is built much faster.

#[cfg(not(test))]
pub(crate) use trunnion_description::{IntoParams, ToSchema};
#[cfg(test)]
pub(crate) use utoipa::{IntoParams, ToSchema};

pub(crate) use trunnion_description::operation;
