//! Oracles: numbers and formulas from outside, compared within named tolerances.

mod kinematics;
