//! Webhooks: whoever posted a job is told of its end, signed as Standard Webhooks 1.0.0 describes, again and again until
//! it is taken or given up.
//!
//! What is to be told stands in the database from the moment the job ends (`store::deliveries`); here is who may be called,
//! what is sent, when, and how. A process that dies in between tells it again: the receiver knows it by its id.

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
