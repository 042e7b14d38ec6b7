//! Oracles: numbers and formulas from outside (tables, closed forms, second methods), compared within named tolerances.

mod ballbar;
#[path = "../models/bar_machine.rs"]
mod bar_machine;
mod control_export;
mod cutter_contact;
#[path = "../models/double_double.rs"]
mod double_double;
mod kinematics;
mod rotary_sphere;
mod servo;
mod servo_paths;
mod servo_second_methods;
mod sphere_run;
#[path = "../models/tables.rs"]
mod tables;
mod wear_compensation;
mod wear_history;
mod wear_scallop;
