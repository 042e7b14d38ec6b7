//! Laws: sentences that hold for every machine and every program.

#[path = "../models/mod.rs"]
mod models;

mod assume_nothing;
mod assumed_contact;
mod calibration;
mod compensation;
mod constants;
mod conversational;
mod course;
mod cycles;
mod example;
mod head_survey;
mod hostile_surfaces;
mod idempotence;
mod inverse;
mod location_errors;
mod machines;
mod numbering;
mod numbers;
mod okuma;
mod one_pass;
mod other_controls;
mod path;
mod post;
mod program;
mod programs;
mod radius;
mod reading;
mod reference;
mod servo;
mod side_by_side;
mod siemens;
mod singularity;
mod stamps;
mod stated_tools;
mod statements;
mod surface_contact;
mod tool_vectors;
mod travel;
mod turned;
mod unsaid;
mod virtual_cutting;
mod wear;
mod wear_history;
mod wear_program;
