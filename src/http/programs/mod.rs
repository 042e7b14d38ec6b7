//! NC programs in, compensated programs out. A program is sent completely or not at all.

pub(super) mod answer;
mod arrival;
mod compensate_cc_path;
mod compensate_program;
mod compensate_wear;
mod interpret_program;
mod post_program;
pub(super) mod several;
mod simulate_servo_program;
pub(super) mod upload;
mod verify_part;

use super::described::resource;

/// A pass of a ball-end cutter of 5 mm, as the description shows it: it states its unit, its tool and its contacts.
#[cfg(test)]
pub(super) const EXAMPLE_PROGRAM: &str = "%
O1001 (BLADE)
G21 G90 G17 G54
T1 M6
S12000 M3
G0 X-20.9179 Y-0.5561 Z-4.5730 A-20.9718 C30.9638 U-20.9179 V-4.8862 W-2.0730
G94 G1 X-17.1430 Y-1.9862 Z-5.1318 A-22.6064 C26.5651 U-17.1430 V-6.3163 W-2.6318 F1200.
X-11.6991 Y-3.5587 Z-5.8244 A-24.9307 C19.2900 U-11.6991 V-7.8888 W-3.3244
X-6.5088 Y-4.4042 Z-6.2350 A-27.1423 C11.3099 U-6.5087 V-8.7344 W-3.7350
M30
%
";

resource! {
    compensate_cc_path::compensate_cc_path,
    compensate_wear::compensate_wear_of_program,
    compensate_program::compensate_program,
    interpret_program::interpret_program,
    post_program::post_program,
    simulate_servo_program::simulate_servo_program,
    verify_part::verify_part,
}
