//! Webhooks: the client that posted a job gets a message about its end, signed as Standard Webhooks 1.0.0 describes.
//! It is sent again until the receiver accepts it or it is given up.
//!
//! The message is in the database from the moment the job ends (`store::deliveries`). This module decides which
//! receivers are allowed, and what is sent, when, and how. If the process dies in between, the message is sent again:
//! the receiver recognises it by its id.

mod address;
mod call;
mod courier;
mod pauses;
mod receivers;
mod signature;
mod trust;

pub use courier::{Courier, DeliveriesReading};
pub use receivers::{NotAllowed, Receivers};
pub use signature::{SECRET_OVERLAP_S, new_webhook_secret, signing_now};
pub use trust::trusted_certificates;
