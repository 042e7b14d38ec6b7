//! A program that bears the stamp of a step is refused for that step and let through for the others, in whatever form
//! and dialect the stamp stands.

use std::ops::ControlFlow;

use proptest::prelude::*;
use trunnion::machine::Machine;
use trunnion::process::{
    CcParameters, CompensationParameters, ContactSource, Fault, ProgramSetup, SingularityAction,
    SingularityParameters, WearParameters, WornCutter, treat_singular_regions,
};
use trunnion::program::{Borne, Dialect, Stamp, StampFinder, StepName, Steps, borne_by, place_stamp};

use crate::assume_nothing::{cc, wear};
use crate::models::displaced::{errors, with_errors};
use crate::models::finishing::{ac_machine, tool};
use crate::models::set_ups::at_zero;
use crate::one_pass;

fn stamp(steps: Steps) -> Stamp {
    Stamp {
        version: "0.2.0".to_owned(),
        operation: "compensation".to_owned(),
        steps,
        machine: "dmu-80".to_owned(),
        revision: 3,
        tool: Some("12".to_owned()),
        source: "0a1b2c3d4e5f6789".to_owned(),
        parameters: "9f8e7d6c5b4a3928".to_owned(),
    }
}

/// One program in each dialect that has comments, with a cut that stands within every tolerance.
const PROGRAMS: [(Dialect, &str); 5] = [
    (Dialect::Iso, "%\nO1001(PART)\nG21 G90 G94\nG0 X0. Y0. Z5. A0. C0.\nG1 X9. A1. F500.\nM30\n%\n"),
    (
        Dialect::Siemens,
        "%_N_P_MPF\n;$PATH=/_N_MPF_DIR\nN10 G71 G90 G94\nN20 G0 X0 Y0 Z5 A0 C0\nN30 G1 X9 A1 F500\nN40 M30\n",
    ),
    (
        Dialect::Heidenhain,
        "0 BEGIN PGM P MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n2 L X+9 A+1 F500\n3 END PGM P MM\n",
    ),
    (
        Dialect::Apt,
        "PARTNO/ P\nUNITS/MM\nFEDRAT/500.,MMPM\nGOTO/0.,0.,5.,0.,0.,1.\nGOTO/9.,0.,5.,0.,0.,1.\nFINI\n",
    ),
    (
        Dialect::Okuma,
        "$P.MIN%\nO1001(PART)\nG15 H1\nG21 G90 G94\nG0 X0. Y0. A0. C0.\nG56 Z5. H1\nG1 X9. A1. F500.\nM02\n%\n",
    ),
];

fn steps() -> impl Strategy<Value = Steps> {
    prop::sample::subsequence(StepName::ALL.to_vec(), 1..=StepName::ALL.len())
        .prop_map(|steps| Steps::of(&steps))
}

proptest! {
    #[test]
    fn what_a_stamp_prints_is_found_again_anywhere_in_a_text_of_every_dialect(
        steps in steps(),
        machine in "[ -~]{1,40}",
        tool in prop::option::of("[ -~]{1,64}"),
        upper in 0..3_u8,
        before in "[G0-9XYZ. \n]{0,400}",
        pieces in 1_usize..400,
    ) {
        let stamp = Stamp { machine, tool, ..stamp(steps) };
        for (dialect, program) in PROGRAMS {
            let place = place_stamp(program.as_bytes(), dialect, &stamp).expect("a place");
            let (head, rest) = program.as_bytes().split_at(place.offset);
            let stamped = [head, &place.line, rest].concat();
            prop_assert_eq!(borne_by(program.as_bytes()).steps, Steps::NONE);
            prop_assert_eq!(borne_by(&stamped).steps, steps);
            // Controls and transfers change the size of letters, and a head may come to stand before it.
            let stamped = [before.as_bytes(), b"\n", &stamped].concat();
            let stamped = match upper {
                0 => stamped,
                1 => stamped.to_ascii_uppercase(),
                _ => stamped.to_ascii_lowercase(),
            };
            let mut finder = StampFinder::default();
            stamped.chunks(pieces).for_each(|piece| finder.see(piece));
            prop_assert_eq!(finder.finish(), Borne { steps, unreadable: None });
        }
        prop_assert_eq!(Steps::from_names(&steps.to_string()), Some(steps));
    }
}

/// One step done to a program.
fn done(machine: &Machine, step: StepName, allow_repeated: bool, text: &str) -> Result<String, Fault> {
    let program = ProgramSetup { allow_repeated, ..at_zero() };
    let (ball, worn) = (tool(5.0, 5.0), WornCutter::Tool(tool(4.9, 4.9)));
    let by_tip =
        CcParameters { contact: ContactSource::Tip, ..CcParameters::new(tool(5.0, 5.0), program.clone()) };
    match step {
        StepName::Wear => {
            let contact = ContactSource::FeedPlane;
            let parameters = WearParameters { contact, ..WearParameters::new(ball, worn, program) };
            wear(machine, &parameters, text).map(|(output, _)| output)
        }
        StepName::LocationErrors => {
            let parameters =
                CompensationParameters { location_errors: true, ..CompensationParameters::new(program) };
            one_pass::run(machine, &parameters, text).map(|(output, ..)| output)
        }
        StepName::Cc => cc(machine, &by_tip, text).map(|(output, _)| output),
        StepName::Singularity => {
            let regions = SingularityParameters::new(SingularityAction::Densify);
            let (mut output, source) = (Vec::new(), text.as_bytes().to_vec());
            let go_on = || ControlFlow::Continue(());
            treat_singular_regions(machine, &by_tip, &regions, &source, &mut output, &go_on)?;
            Ok(String::from_utf8(output).expect("text"))
        }
    }
}

#[test]
fn a_step_that_the_text_bears_is_refused_and_every_other_step_is_let_through() {
    let machine = with_errors(&ac_machine(), errors());
    for (dialect, program) in PROGRAMS.into_iter().filter(|(dialect, _)| *dialect != Dialect::Apt) {
        for borne in StepName::ALL {
            let place =
                place_stamp(program.as_bytes(), dialect, &stamp(Steps::of(&[borne]))).expect("a place");
            let line = String::from_utf8(place.line).expect("text");
            let text = format!("{}{line}{}", &program[..place.offset], &program[place.offset..]);
            for step in StepName::ALL {
                for allow_repeated in [false, true] {
                    let told = format!("{dialect:?} bears {borne}, {step} asked, {allow_repeated}");
                    let is_refused = step == borne && !(allow_repeated && step.may_be_repeated());
                    match done(&machine, step, allow_repeated, &text) {
                        Err(Fault::AlreadyCompensated { step: found }) => {
                            assert!(is_refused && found == step, "{told}");
                        }
                        // The stamp of another step stays where it is.
                        Ok(output) => {
                            assert!(!is_refused && output.contains(&line), "{told}: {output}");
                        }
                        Err(fault) => panic!("{told}: {fault}"),
                    }
                }
            }
        }
    }
}

#[test]
fn steps_that_move_ends_stay_refused_even_where_repetition_is_allowed() {
    for step in StepName::ALL {
        assert_eq!(step.may_be_repeated(), matches!(step, StepName::Cc | StepName::Singularity), "{step}");
    }
    let (_, program) = PROGRAMS[0];
    let program = program.replace(
        "O1001(PART)\n",
        &format!("O1001(PART)\n({})\n", stamp(Steps::of(&[StepName::Wear, StepName::Cc]))),
    );
    for allow_repeated in [false, true] {
        let setup = ProgramSetup { allow_repeated, ..at_zero() };
        let parameters = WearParameters {
            contact: ContactSource::FeedPlane,
            ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.9, 4.9)), setup.clone())
        };
        let moved = wear(&ac_machine(), &parameters, &program);
        let Err(fault @ Fault::AlreadyCompensated { step: StepName::Wear }) = moved else {
            panic!("{moved:?}")
        };
        assert!(!fault.to_string().contains("allow_repeated"), "no way round it is told: {fault}");
        let path = cc(
            &ac_machine(),
            &CcParameters { contact: ContactSource::Tip, ..CcParameters::new(tool(5.0, 5.0), setup) },
            &program,
        );
        assert_eq!(path.is_ok(), allow_repeated, "{path:?}");
    }
}
