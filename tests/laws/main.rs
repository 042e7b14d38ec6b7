//! Laws: sentences that hold for every machine and every program.

#[path = "../models/mod.rs"]
mod models;

mod calibration;
mod compensation;
mod example;
mod inverse;
mod machines;
mod one_pass;
mod path;
mod program;
mod programs;
mod servo;
mod surface_contact;
mod virtual_cutting;
mod wear;
mod wear_program;
