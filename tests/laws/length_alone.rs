//! A tool that is only longer or shorter: every motion has to move along the tool, also where no contact is known.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::ops::ControlFlow;

use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, PlaneRule, PlaneSolution, Preset, RotaryLetter};
use trunnion::process::{Fault, LengthInControl, LineFaultKind, WearParameters, WornCutter, compensate_wear};
use trunnion::units::Length;

use crate::models::finishing::tool;
use crate::models::set_ups::in_mm;

const SHORTER_MM: f64 = 0.1;

/// The program for a tool that is shorter than the control knows.
fn shortened(text: &str, shorter_mm: f64) -> Result<String, Fault> {
    let rule = PlaneSolution { rule: PlaneRule::NegativeFirst, axis: Some(RotaryLetter::A) };
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let machine = machine.with_plane_solution(Some(rule));
    let setup = Setup { work_offset_mm: Vec3::new(70.0, -40.0, 95.0), ..Setup::default() };
    let ball = tool(5.0, 5.0);
    let parameters = WearParameters {
        shorter_by: Length::from_mm(shorter_mm),
        length_in_control: LengthInControl::Nominal,
        ..WearParameters::new(ball, WornCutter::Tool(ball), in_mm(&setup))
    };
    let mut output = Vec::new();
    compensate_wear(&machine, &parameters, &text.as_bytes().to_vec(), &mut output, &|| {
        ControlFlow::Continue(())
    })?;
    Ok(String::from_utf8(output).unwrap())
}

/// A cut whose work offset is not known would have to move too. It is no way out that its axes are stated anew.
#[test]
fn a_cut_in_an_offset_that_nobody_states_refuses_the_program() {
    let heidenhain = |shift: &str| {
        format!(
            "BEGIN PGM T MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+100.000 A+0 C+0 R0 FMAX\nL X+5 Y+6 Z+2.000 F300\n\
             {shift}L X+0 Y+0 Z+30.000 R0 FMAX\nL X+5 Y+6 Z+2.000 R0 F300\nM30\nEND PGM T MM\n"
        )
    };
    let datum = "CYCL DEF 7.0 NULLPUNKT\nCYCL DEF 7.1 X+10\nCYCL DEF 7.2 Y+5\nCYCL DEF 7.3 Z-3\n";
    let iso = |shift: &str| {
        format!(
            "G90 G21 G94 G17 G54\nG0 X0 Y0 Z100.000 A0 C0\nG1 X5 Y6 Z2.000 F300\n{shift}G0 X0 Y0 Z30.000\n\
             G1 X5 Y6 Z2.000 F300\nM30\n"
        )
    };
    for (text, line) in [(heidenhain(datum), 10), (iso("G52 X10 Y5 Z-3\n"), 6), (iso("G55\n"), 6)] {
        let Err(Fault::Lines(faults)) = shortened(&text, SHORTER_MM) else { panic!("{text}") };
        let kept: Vec<_> = faults.kept.iter().map(|fault| (fault.line, fault.kind.clone())).collect();
        assert_eq!(kept, [(line, LineFaultKind::OtherWorkOffset)], "{text}");
        // A tool as the control knows it moves nothing.
        let same = shortened(&text, 0.0).unwrap();
        assert_eq!(
            same.lines().filter(|line| !line.contains("trunnion")).collect::<Vec<_>>(),
            text.lines().collect::<Vec<_>>()
        );
    }
    for text in [heidenhain(""), iso("")] {
        let moved = shortened(&text, SHORTER_MM).unwrap();
        assert_eq!(moved.matches("1.900").count(), 2, "{moved}");
    }
}

/// Planes of the same tilt in one program: the last bits of a solved word depend on the position before it.
#[test]
fn planes_of_equal_tilt_follow_each_other() {
    for (tilt, first, second) in
        [(40, 30, 80), (20, 140, -164), (30, -3, -75), (40, 95, -32), (30, 0, 90), (35, 10, -170)]
    {
        let plane = |turn: i32| {
            format!(
                "G68.2 X10. Y20. Z-5. I{turn}. J{tilt}. K-20.\nG53.1\nG0 X0. Y0. Z30.000\nG1 X5. Z2.000 F300\n\
                 G0 Z30.000\nG69\n"
            )
        };
        let text = format!(
            "G90 G21 G94 G17 G54\nG43 H1\nG0 X0. Y0. Z100.000 A0. C0.\n{}{}M30\n",
            plane(first),
            plane(second)
        );
        for shorter_mm in [0.0, SHORTER_MM] {
            let output = shortened(&text, shorter_mm).unwrap_or_else(|fault| panic!("{fault}\n{text}"));
            let lower = |z: f64| format!("Z{:.3}", z - shorter_mm);
            let wanted = [100.0, 30.0, 2.0]
                .iter()
                .fold(text.clone(), |text, z| text.replace(&format!("Z{z:.3}"), &lower(*z)));
            let found: Vec<&str> = output.lines().filter(|line| !line.contains("trunnion")).collect();
            assert_eq!(found, wanted.lines().collect::<Vec<_>>(), "{tilt} {first} {second}");
        }
    }
}
