//! Oracles: numbers and formulas from outside, compared within named tolerances.
#![expect(clippy::unwrap_used, reason = "an oracle that cannot be set up has failed")]

mod kinematics;
