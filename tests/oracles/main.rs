//! Oracles: numbers and formulas from outside (tables, closed forms, second methods), compared within named tolerances.

mod ballbar;
#[path = "../models/bar_machine.rs"]
mod bar_machine;
mod calibration_budget;
mod control_export;
mod cutter_contact;
#[path = "../models/double_double.rs"]
mod double_double;
#[path = "../models/finishing.rs"]
#[expect(dead_code, unreachable_pub, reason = "one machine of it")]
mod finishing;
mod inverse_precision;
mod kinematics;
mod rotary_sphere;
mod servo;
mod servo_paths;
mod servo_second_methods;
#[path = "../models/set_ups.rs"]
#[expect(dead_code, unreachable_pub, reason = "each binary uses its own part")]
mod set_ups;
mod sphere_run;
mod stl;
mod surface_contact;
mod surface_mesh;
#[path = "../models/surface_passes.rs"]
#[expect(dead_code, unreachable_pub, reason = "each binary uses its own part")]
mod surface_passes;
#[path = "../models/tables.rs"]
mod tables;
#[path = "../models/tessellation.rs"]
mod tessellation;
mod virtual_blade;
mod virtual_cutting;
mod wear_back_test;
#[path = "../models/wear_back_test.rs"]
mod wear_back_test_model;
mod wear_compensation;
mod wear_history;
mod wear_scallop;
