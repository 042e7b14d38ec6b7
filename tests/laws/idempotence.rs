//! A program that was compensated is compensated: the same step with the same parameters on its own output has
//! nothing to do, and the stamp stays as well. Blocks whose deviation lies within one rounding of their words of the
//! tolerance are exempt, and counted.
#![expect(clippy::panic, reason = "a test may stop at what it did not expect")]

use std::ops::ControlFlow;

use trunnion::machine::{Machine, Tool};
use trunnion::process::{
    CcParameters, CcStep, CompensationParameters, ContactSource, ProgramSetup, SingularityAction,
    SingularityParameters, treat_singular_regions,
};
use trunnion::program::{Dialect, Stamp, Steps, place_stamp};
use trunnion::units::{Angle, Length};

use crate::assume_nothing::cc;
use crate::models::finishing::{
    FeedForm, Finishing, Form, ac_machine, blade, dome_near_pole, impeller_flank, tool,
};
use crate::models::pole_passes::{PassShape, pole_pass};
use crate::models::set_ups::{at_zero, in_mm};
use crate::one_pass;

/// One rounding of words of four decimals: half a unit on three linear axes, and on two rotary ones 150 mm away [mm].
const ROUNDED_MM: f64 = 0.866e-4 + 1.0e-4 * 150.0 * std::f64::consts::PI / 180.0;

/// The program with the stamp that the service would give it.
fn stamped(text: &str, dialect: Dialect, steps: Steps) -> String {
    let stamp = Stamp {
        version: "0.2.0".to_owned(),
        operation: "cc-compensation".to_owned(),
        steps,
        machine: "dmu-80".to_owned(),
        revision: 3,
        tool: None,
        source: "0a1b2c3d4e5f6789".to_owned(),
        parameters: "9f8e7d6c5b4a3928".to_owned(),
    };
    let Some(place) = place_stamp(text.as_bytes(), dialect, &stamp) else {
        assert_eq!(dialect, Dialect::Csv);
        return text.to_owned();
    };
    let (head, rest) = text.split_at(place.offset);
    format!("{head}{}{rest}", String::from_utf8(place.line).expect("text"))
}

/// What is found when programs are compensated again.
#[derive(Debug, Default)]
struct Again {
    programs: usize,
    changed: usize,
    blocks: u64,
    exempt: u64,
    /// The programs with exempt blocks.
    told: Vec<String>,
}

impl Again {
    /// Compensates a program, stamps it, and compensates it again.
    fn cc(&mut self, machine: &Machine, parameters: &CcParameters, text: &str, told: &str) {
        let (once, first) = cc(machine, parameters, text).unwrap_or_else(|fault| panic!("{told}: {fault}"));
        self.programs += 1;
        if once == text {
            return;
        }
        self.changed += 1;
        self.blocks += first.blocks_out;
        let once = stamped(&once, first.dialect, first.steps);
        let program = ProgramSetup { allow_repeated: true, ..parameters.program.clone() };
        let again = CcParameters { program, ..parameters.clone() };
        let (twice, second) = cc(machine, &again, &once).unwrap_or_else(|fault| panic!("{told}: {fault}"));
        if twice == once {
            assert!(second.steps.is_empty(), "{told}");
            return;
        }
        self.exempt += second.motions_over_tolerance - second.motions_left_over;
        self.told.push(format!("{told}: {:?} -> {:?}", second.before, second.after));
        let tolerance = parameters.tolerance + Length::from_mm(ROUNDED_MM);
        let (loose, _) = cc(machine, &CcParameters { tolerance, ..again }, &once).expect(told);
        assert!(loose == once, "{told}: {:?}", second.before);
    }
}

fn parts(tool: Tool) -> [Finishing; 3] {
    [
        blade(ac_machine(), tool, 25, 3),
        impeller_flank(ac_machine(), tool, 30, 3),
        dome_near_pole(ac_machine(), tool, 41, 3),
    ]
}

#[test]
fn a_compensated_program_compensated_again_is_the_same_whatever_states_its_contacts() {
    let mut again = Again::default();
    for tool in [tool(5.0, 5.0), tool(6.0, 1.5), tool(8.0, 0.0)] {
        for part in parts(tool) {
            for (form, contact) in [
                (Form::Plain, ContactSource::Auto),
                (Form::Plain, ContactSource::Tip),
                (Form::Plain, ContactSource::FeedPlane),
                (Form::ContactWords, ContactSource::Auto),
                (Form::Tcp, ContactSource::Auto),
                (Form::NormalTable, ContactSource::Auto),
            ] {
                if tool.corner_radius() == Length::ZERO && matches!(form, Form::ContactWords | Form::Tcp) {
                    continue;
                }
                for feed in [FeedForm::PerMinute, FeedForm::InverseTime] {
                    for tolerance_um in [20.0, 2.0] {
                        let parameters = CcParameters {
                            contact,
                            tolerance: Length::from_um(tolerance_um),
                            ..CcParameters::new(part.tool, in_mm(&part.setup))
                        };
                        let told = format!(
                            "{} R{}/{} {form:?} {contact:?} {feed:?} {tolerance_um} um",
                            part.name,
                            tool.radius().mm(),
                            tool.corner_radius().mm()
                        );
                        again.cc(&part.machine, &parameters, &part.program(form, feed), &told);
                    }
                }
            }
        }
    }
    println!("{again:?}");
    assert!(again.changed > 100 && again.exempt == 0, "{again:?}");
}

/// Machines with a pole: tables, heads, both, and nutating ones.
const LAYOUTS: [&str; 7] = [
    "ac-table",
    "bc-head",
    "ab-table",
    "b-head-c-table",
    "nutating-b-head-c-table",
    "nutating-bc-table",
    "nutating-ac-head",
];

fn shapes() -> [PassShape; 4] {
    let plain = PassShape::PLAIN;
    [
        plain,
        PassShape { miss_deg: 0.05, ..plain },
        PassShape { miss_deg: 1.0, motions: 25, inverse_time: true, ..plain },
        PassShape { miss_deg: 0.5, incremental: true, ..plain },
    ]
}

#[test]
fn treated_regions_treated_again_are_the_same() {
    let (mut changed, mut not_the_same) = (0, Vec::new());
    for id in LAYOUTS {
        for tcp in [true, false] {
            for shape in shapes() {
                let pass = pole_pass(id, tcp, shape);
                for action in [SingularityAction::Densify, SingularityAction::Smooth] {
                    for contact in [ContactSource::Tip, ContactSource::FeedPlane] {
                        for axis_tolerance_deg in [0.05, 0.3] {
                            let regions = SingularityParameters {
                                axis_tolerance: Angle::from_deg(axis_tolerance_deg),
                                ..SingularityParameters::new(action)
                            };
                            let program = ProgramSetup { allow_repeated: true, ..in_mm(&pass.setup) };
                            let parameters =
                                CcParameters { contact, ..CcParameters::new(pass.tool, program) };
                            let told = format!(
                                "{id} TCP {tcp} {shape:?} {action:?} {contact:?} {axis_tolerance_deg}"
                            );
                            let treat = |text: &str| {
                                let (source, mut output) = (text.as_bytes().to_vec(), Vec::new());
                                let go_on = || ControlFlow::Continue(());
                                let report = treat_singular_regions(
                                    &pass.machine,
                                    &parameters,
                                    &regions,
                                    &source,
                                    &mut output,
                                    &go_on,
                                )
                                .unwrap_or_else(|fault| panic!("{told}: {fault}"));
                                (String::from_utf8(output).expect("text"), report)
                            };
                            let (once, first) = treat(&pass.text);
                            if once == pass.text {
                                continue;
                            }
                            changed += 1;
                            let once = stamped(&once, first.dialect, first.steps());
                            let (twice, second) = treat(&once);
                            if twice != once {
                                let lines = once.lines().zip(twice.lines()).filter(|(a, b)| a != b).count();
                                not_the_same.push((
                                    told,
                                    lines,
                                    second.blocks_inserted,
                                    second.blocks_changed,
                                ));
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(changed > 50, "{changed}");
    assert!(not_the_same.is_empty(), "{} of {changed}: {not_the_same:#?}", not_the_same.len());
}

#[test]
fn both_steps_together_done_again_change_nothing() {
    let (mut changed, mut not_the_same) = (0, Vec::new());
    for id in LAYOUTS {
        for tcp in [true, false] {
            for shape in shapes() {
                let pass = pole_pass(id, tcp, shape);
                for action in [SingularityAction::Densify, SingularityAction::Smooth] {
                    for contact in [ContactSource::Tip, ContactSource::FeedPlane] {
                        let parameters = CompensationParameters {
                            singularity: Some(SingularityParameters::new(action)),
                            cc: Some(CcStep { contact, ..CcStep::new(pass.tool) }),
                            program: ProgramSetup { allow_repeated: true, ..in_mm(&pass.setup) },
                            ..CompensationParameters::new(at_zero())
                        };
                        let told = format!("{id} TCP {tcp} {shape:?} {action:?} {contact:?}");
                        let (once, first, _) = one_pass::done(&pass.machine, &parameters, &pass.text);
                        let once = stamped(&once, Dialect::Iso, first.steps);
                        let (twice, report, _) = one_pass::done(&pass.machine, &parameters, &once);
                        changed += usize::from(once != pass.text);
                        if once != twice {
                            let lines = once.lines().zip(twice.lines()).filter(|(a, b)| a != b).count();
                            not_the_same.push((told, lines, report.steps.to_string()));
                        }
                    }
                }
            }
        }
    }
    assert!(changed > 50, "{changed}");
    assert!(not_the_same.is_empty(), "{} of {changed}: {not_the_same:#?}", not_the_same.len());
}
