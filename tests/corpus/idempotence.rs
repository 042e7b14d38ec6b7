//! Whole programs that others wrote, compensated and treated twice: the second time nothing is to do. Blocks whose
//! deviation lies within one rounding of their words of the tolerance are exempt, and counted.
#![expect(clippy::panic, clippy::print_stdout, reason = "a test may stop, and tells what it measured")]

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use trunnion::machine::{Machine, RotaryLetter, Tool};
use trunnion::motion::Interpolation;
use trunnion::process::{
    CcParameters, CcReport, ContactSource, Fault, ListedTool, ProgramSetup, SingularityAction,
    SingularityParameters, StartPosition, ToolTable, Tools, compensate, treat_singular_regions,
};
use trunnion::program::{Dialect, Stamp, Steps, place_stamp};
use trunnion::units::Length;

use crate::set_ups::at_zero;
use crate::tables::tables;
use crate::{every_file, shared_file};

/// One rounding of words of three decimals, as the coarsest of these programs have: half a unit on three linear axes,
/// and on two rotary ones 100 mm away [mm].
const ROUNDED_MM: f64 = 0.866e-3 + 1.0e-3 * 100.0 * std::f64::consts::PI / 180.0;
/// Of the blocks written, at most this share may be exempt.
const EXEMPT_SHARE: f64 = 1e-3;

fn go_on() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn ball() -> Tool {
    let radius = Length::from_mm(5.0);
    Tool::new(radius, radius).expect("a ball")
}

/// A tool table in which every number is the same ball, for programs of several tools.
fn table() -> Arc<ToolTable> {
    let tool = |number| ListedTool {
        number: Some(number),
        name: None,
        cutter: Some(ball()),
        length: Some(Length::ZERO),
        worn: None,
    };
    Arc::new(ToolTable::new((1..1000).map(tool).collect()))
}

fn cc(machine: &Machine, parameters: &CcParameters, text: &[u8]) -> Result<(Vec<u8>, CcReport), Fault> {
    let mut output = Vec::new();
    let report = compensate(machine, parameters, &text.to_vec(), &mut output, &go_on)?;
    Ok((output, report))
}

/// The program with the stamp that the service would give it.
fn stamped(text: &[u8], dialect: Dialect, steps: Steps) -> Vec<u8> {
    let stamp = Stamp {
        version: "0.2.0".to_owned(),
        operation: "cc-compensation".to_owned(),
        steps,
        machine: "tables".to_owned(),
        revision: 1,
        tool: None,
        source: "0a1b2c3d4e5f6789".to_owned(),
        parameters: "9f8e7d6c5b4a3928".to_owned(),
    };
    match place_stamp(text, dialect, &stamp) {
        Some(place) => [&text[..place.offset], &place.line, &text[place.offset..]].concat(),
        None => text.to_vec(),
    }
}

/// What is found when programs are worked on again.
#[derive(Debug, Default)]
struct Again {
    read: usize,
    refused: usize,
    changed: usize,
    blocks: u64,
    left_over: u64,
    exempt: u64,
}

impl Again {
    fn cc(&mut self, machine: &Machine, parameters: &CcParameters, program: &[u8], told: &str) {
        let found = match cc(machine, parameters, program) {
            Err(Fault::Tool(_)) => {
                let tools = Tools::with(None, Some(Length::ZERO), table());
                let program_setup = ProgramSetup { tools, ..parameters.program.clone() };
                let by_table = CcParameters { tool: None, program: program_setup, ..parameters.clone() };
                let found = cc(machine, &by_table, program);
                found.map(|found| (found, by_table))
            }
            found => found.map(|found| (found, parameters.clone())),
        };
        let ((once, first), parameters) = match found {
            Ok(found) => found,
            Err(fault @ (Fault::VerificationFailed { .. } | Fault::Unwritable { .. } | Fault::Io(_))) => {
                panic!("{told}: {fault}")
            }
            Err(_) => {
                self.refused += 1;
                return;
            }
        };
        self.read += 1;
        if once == program {
            return;
        }
        self.changed += 1;
        self.blocks += first.blocks_out;
        self.left_over += first.motions_left_over;
        let once = stamped(&once, first.dialect, first.steps);
        let program = ProgramSetup { allow_repeated: true, ..parameters.program.clone() };
        let again = CcParameters { program, ..parameters };
        let (twice, second) = cc(machine, &again, &once).unwrap_or_else(|fault| panic!("{told}: {fault}"));
        let exempt = second.motions_over_tolerance - second.motions_left_over;
        println!(
            "{told}: {} over, {} left; again {exempt}, {} left, {:?}",
            first.motions_over_tolerance,
            first.motions_left_over,
            second.motions_left_over,
            second.before.worst_line
        );
        assert!(second.motions_left_over <= first.motions_left_over, "{told}");
        if twice == once {
            assert!(exempt == 0 && second.steps.is_empty(), "{told}");
            return;
        }
        self.exempt += exempt;
        let tolerance = again.tolerance + Length::from_mm(ROUNDED_MM);
        let loose = cc(machine, &CcParameters { tolerance, ..again }, &once)
            .unwrap_or_else(|fault| panic!("{told}: {fault}"));
        assert!(loose.0 == once, "{told}: {:?}", second.before);
    }
}

fn machines() -> [Machine; 3] {
    [
        tables([RotaryLetter::A, RotaryLetter::C], false),
        tables([RotaryLetter::B, RotaryLetter::C], false),
        tables([RotaryLetter::B, RotaryLetter::C], true),
    ]
}

/// From X0 Y0 Z0 on, both rotary axes at 0: so that more is followed.
fn with(contact: ContactSource, interpolation: Option<Interpolation>) -> CcParameters {
    let start = StartPosition { linear_mm: [Some(0.0); 3], rotary_deg: [Some(0.0); 2] };
    let program = ProgramSetup { interpolation, start, ..at_zero() };
    CcParameters { contact, ..CcParameters::new(ball(), program) }
}

fn told(folder: &Path, path: &Path, machine: &Machine, more: &str) -> String {
    let name = path.strip_prefix(folder).unwrap_or(path).display();
    let letters = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
    format!("{name} {}{} {more}", letters[0], letters[1])
}

#[test]
fn no_program_that_was_compensated_is_compensated_again() {
    let Some(folder) = shared_file("programs") else { return };
    let mut again = Again::default();
    for path in every_file(&folder) {
        let program = fs::read(&path).expect("a file");
        for machine in machines() {
            for contact in [ContactSource::Auto, ContactSource::FeedPlane] {
                for interpolation in [None, Some(Interpolation::Tcp)] {
                    // The tip keeps any tolerance that the decimals do; assumed contacts at the usual one.
                    let tolerances_um: &[f64] =
                        if contact == ContactSource::Auto { &[10.0, 2.0] } else { &[10.0, 5.0, 2.0] };
                    for &tolerance_um in tolerances_um {
                        let more = format!("{contact:?} {interpolation:?} {tolerance_um} um");
                        let tolerance = Length::from_um(tolerance_um);
                        let parameters = CcParameters { tolerance, ..with(contact, interpolation) };
                        again.cc(&machine, &parameters, &program, &told(&folder, &path, &machine, &more));
                    }
                }
            }
        }
    }
    println!("{again:?}");
    assert!(again.read > 300 && again.changed > 10, "{again:?}");
    assert!(again.exempt as f64 <= EXEMPT_SHARE * again.blocks as f64, "{again:?}");
}

#[test]
fn no_region_that_was_treated_is_treated_again() {
    let Some(folder) = shared_file("programs") else { return };
    let mut changed = 0;
    for path in every_file(&folder) {
        let program = fs::read(&path).expect("a file");
        for machine in machines() {
            for action in [SingularityAction::Densify, SingularityAction::Smooth] {
                for interpolation in [None, Some(Interpolation::Tcp)] {
                    let told = told(&folder, &path, &machine, &format!("{action:?} {interpolation:?}"));
                    let parameters = with(ContactSource::Tip, interpolation);
                    let setup = ProgramSetup { allow_repeated: true, ..parameters.program.clone() };
                    let parameters = CcParameters { program: setup, ..parameters };
                    let treat = |text: &[u8]| {
                        let mut output = Vec::new();
                        let regions = SingularityParameters::new(action);
                        let source = text.to_vec();
                        treat_singular_regions(&machine, &parameters, &regions, &source, &mut output, &go_on)
                            .map(|report| (output, report))
                    };
                    let Ok((once, first)) = treat(&program) else { continue };
                    if once == program {
                        continue;
                    }
                    changed += 1;
                    let once = stamped(&once, first.dialect, first.steps());
                    let (twice, second) = treat(&once).unwrap_or_else(|fault| panic!("{told}: {fault}"));
                    println!(
                        "{told}: {} changed, {} inserted; again {} and {}",
                        first.blocks_changed,
                        first.blocks_inserted,
                        second.blocks_changed,
                        second.blocks_inserted
                    );
                    assert!(twice == once, "{told}");
                }
            }
        }
    }
    println!("{changed} programs changed");
    assert!(changed > 2, "{changed}");
}
