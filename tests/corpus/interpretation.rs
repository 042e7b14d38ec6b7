//! What is understood of programs, beside what their reference interpreters make of them: every motion that is
//! followed is one of theirs, in their order, and the share that is followed is counted.

#![expect(clippy::unwrap_used, reason = "tests stop at the first surprise")]

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use trunnion::kinematics::{Kinematics, Setup};
use trunnion::machine::{Machine, MachineCoordinates, RotaryLetter};
use trunnion::motion::{OffsetCode, StartModes, WorkOffset, WorkOffsets};
use trunnion::process::{
    Interpreted, InterpretedKind, InterpretedMotion, ProgramSetup, StartPosition, interpret_program,
};
use trunnion::units::LengthUnit;

use crate::set_ups::in_mm;
use crate::tables::tables;
use crate::{every_file, shared_file};

/// Positions of the reference interpreter of RS274/NGC are printed with four decimals, in inches too.
const PRINTED_MM: f64 = 0.5e-4 * 25.4 + 1e-9;
/// Those of the reference for Sinumerik programs with three.
const THREE_DECIMALS: f64 = 0.5e-3 + 1e-9;
/// Motions of the reference interpreter of RS274/NGC, and how many of them are followed at least.
const RS274: [usize; 2] = [1511, 1191];
/// The same of Sinumerik programs.
const SINUMERIK: [usize; 2] = [476, 303];

/// X Y Z A B C after a motion [mm, deg], then X Y Z of an arc's centre [mm] and its sense: 1 counter-clockwise, −1
/// clockwise, 0 of a line. X Y Z count along axes that are not turned. Then come X Y Z in machine coordinates [mm].
/// Those that are not known, or that the program never names, are `None`.
type Place = [Option<f64>; 13];

/// The zeros of the reference's words: in machine coordinates, a shift along their axes [mm], and their turn about Z.
#[derive(Default)]
struct Zeros {
    origin_mm: [f64; 3],
    shift_mm: [f64; 3],
    turn_rad: f64,
}

impl Zeros {
    fn turned(&self, at_mm: [Option<f64>; 3]) -> [Option<f64>; 3] {
        let [x, y, z] = at_mm;
        let (sin, cos) = self.turn_rad.sin_cos();
        let both = x.zip(y).filter(|_| self.turn_rad.abs() > 0.0);
        both.map_or(at_mm, |(x, y)| [Some(x * cos - y * sin), Some(x * sin + y * cos), z])
    }

    /// Completes a place of the reference, which counts in turned axes.
    fn complete(&self, mut place: Place) -> Place {
        let words = [place[0], place[1], place[2]];
        let shifted = std::array::from_fn(|k| words[k].map(|word| word + self.shift_mm[k]));
        let machine = self.turned(shifted);
        place[..3].copy_from_slice(&self.turned(words));
        place[10..].copy_from_slice(&[0, 1, 2].map(|k: usize| machine[k].map(|at| at + self.origin_mm[k])));
        let centre = [place[6], place[7], place[8]];
        if self.turn_rad.abs() > 0.0 {
            place[6..9].copy_from_slice(&self.turned(centre));
        }
        place
    }
}

const LETTERS: [char; 6] = ['X', 'Y', 'Z', 'A', 'B', 'C'];

/// The motions that are followed, or why none is.
/// The motions that are followed in a program whose control begins in these codes, with Y at this place.
fn followed(
    machine: &Machine,
    text: &[u8],
    unit: LengthUnit,
    (start_codes, start_y_mm): (&str, f64),
) -> Result<Vec<InterpretedMotion>, String> {
    let start_modes = StartModes::from_codes(start_codes).unwrap();
    let start =
        StartPosition { linear_mm: [Some(0.0), Some(start_y_mm), Some(0.0)], rotary_deg: [Some(0.0); 2] };
    let named = |number: u16| (WorkOffset::Code(OffsetCode::new(number, 0)), [0.0; 3]);
    let work_offsets = WorkOffsets {
        only_mm: Some([0.0; 3]),
        named_mm: (54..=59).map(named).collect(),
        ..WorkOffsets::default()
    };
    let program = ProgramSetup {
        unit: Some(unit),
        start,
        start_modes,
        work_offsets: Arc::new(work_offsets),
        ..in_mm(&Setup::default())
    };
    let mut motions = Vec::new();
    let mut take = |told: &Interpreted| {
        if let Interpreted::Motion(motion) = told {
            motions.push(*motion);
        }
        Ok(())
    };
    let source = text.to_vec();
    let found = interpret_program(machine, &program, &source, &mut take, &|| ControlFlow::Continue(()));
    found.map_err(|fault| fault.to_string())?;
    Ok(motions)
}

fn place(machine: &Machine, motion: &InterpretedMotion) -> Place {
    let mut place = [None; 13];
    let letters = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
    place[..3].copy_from_slice(&motion.joints[..3]);
    for (letter, word) in letters.into_iter().zip(&motion.joints[3..]) {
        let at = LETTERS.iter().position(|known| *known == letter).unwrap();
        place[at] = *word;
    }
    let at_rest = motion.joints[3..].iter().all(|word| *word == Some(0.0));
    if let Some(tip_mm) = motion.tip_mm.filter(|_| at_rest) {
        place[10..].copy_from_slice(&tip_mm.map(Some));
    }
    place[9] = (motion.kind != InterpretedKind::Arc).then_some(0.0);
    if let Some((arc, tip_mm)) = motion.arc.zip(motion.tip_mm) {
        let across = (0..3).find(|k| arc.normal[*k].abs() > 0.5).unwrap();
        place[9] = Some(arc.normal[across].round());
        for k in (0..3).filter(|k| *k != across) {
            place[6 + k] = place[k].map(|word| word + arc.centre_mm[k] - tip_mm[k]);
        }
    }
    place
}

/// Whether what is known of both is the same.
fn agree(found: &Place, expected: &Place, tolerance: f64) -> bool {
    found.iter().zip(expected).all(|pair| match pair {
        (Some(found), Some(expected)) => (found - expected).abs() <= tolerance,
        _ => true,
    })
}

/// How many motions are found among the reference's, in their order; every one has to be.
fn matched(name: &str, found: &[(u64, Place)], expected: &[Place], tolerance: f64) -> usize {
    let mut rest = expected.iter();
    for (line, place) in found {
        let known = place.iter().flatten().count();
        let is_there = rest.any(|expected| agree(place, expected, tolerance));
        assert!(is_there, "{name} line {line}: the reference never comes to {place:?} ({known} known)");
    }
    found.len()
}

/// X Y Z A B C after every canonical motion of the reference interpreter.
fn canonical(expected: &str) -> (LengthUnit, Vec<Place>) {
    let mut places = Vec::new();
    let (mut scale, mut first) = (1.0, None);
    let mut plane = [0, 1, 2];
    let mut zeros = Zeros::default();
    for line in expected.lines() {
        let Some((head, rest)) = line.split_once('(') else { continue };
        let name = head.split_whitespace().last().unwrap_or_default();
        let arguments = rest.trim_end().trim_end_matches(')');
        let numbers: Vec<f64> = arguments.split(',').filter_map(|text| text.trim().parse().ok()).collect();
        match name {
            "USE_LENGTH_UNITS" => {
                let unit =
                    if arguments.contains("INCHES") { LengthUnit::Inch } else { LengthUnit::Millimetre };
                scale = unit.mm();
                first = first.or(Some(unit));
            }
            // The first number is that of the offset.
            "SET_G5X_OFFSET" => zeros.origin_mm = [1, 2, 3].map(|k: usize| numbers[k] * scale),
            "SET_G92_OFFSET" => zeros.shift_mm = [0, 1, 2].map(|k: usize| numbers[k] * scale),
            "SET_XY_ROTATION" => zeros.turn_rad = numbers[0].to_radians(),
            "SELECT_PLANE" if arguments.contains("XZ") => plane = [2, 0, 1],
            "SELECT_PLANE" if arguments.contains("YZ") => plane = [1, 2, 0],
            "SELECT_PLANE" => plane = [0, 1, 2],
            "STRAIGHT_FEED" | "STRAIGHT_TRAVERSE" => {
                let [x, y, z] = [0, 1, 2].map(|k: usize| Some(numbers[k] * scale));
                let [a, b, c] = [3, 4, 5].map(|k: usize| Some(numbers[k]));
                let place = [x, y, z, a, b, c, None, None, None, Some(0.0), None, None, None];
                places.push(zeros.complete(place));
            }
            "ARC_FEED" => {
                let mut place = [None; 13];
                for (axis, k) in plane.into_iter().zip([0, 1, 5]) {
                    place[axis] = Some(numbers[k] * scale);
                }
                place[3..6].copy_from_slice(&[6, 7, 8].map(|k: usize| Some(numbers[k])));
                for (axis, k) in plane.into_iter().zip([2, 3]) {
                    place[6 + axis] = Some(numbers[k] * scale);
                }
                place[9] = Some(numbers[4].signum());
                places.push(zeros.complete(place));
            }
            _ => {}
        }
    }
    (first.unwrap_or(LengthUnit::Millimetre), places)
}

/// The `expected` beside a program.
fn expected_of(program: &Path) -> Option<String> {
    let name = program.file_name()?.to_str()?;
    let beside = [program.with_file_name(format!("{name}.expected")), program.with_file_name("expected")];
    beside.into_iter().find_map(|path| std::fs::read_to_string(path).ok())
}

#[expect(clippy::print_stdout, reason = "tells what it measured")]
fn share(what: &str, [of_reference, least]: [usize; 2], total: usize, found: usize, refused: usize) {
    println!(
        "{what}: {found} of {total} motions of the reference are followed, {:.1} %; {refused} programs are refused",
        100.0 * found as f64 / total as f64
    );
    assert_eq!(total, of_reference, "{what}");
    assert!(found >= least, "{what}: {found} of {total}");
}

/// The machine of the RS274/NGC programs, whose machine coordinates are those of M.
fn rs274_machine() -> Machine {
    let coordinates =
        MachineCoordinates { zero_mm: [0.0; 3], length_counts: Some(false), ..MachineCoordinates::default() };
    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    machine.with_machine_coordinates(Some(coordinates)).with_rs274_control(true)
}

#[test]
fn every_followed_motion_is_one_of_the_reference_interpreter_for_rs274() {
    let Some(folder) = shared_file("programs") else { return };
    let folder = folder.join("corpus/linuxcnc-interp");
    let machine = rs274_machine();
    let (mut total, mut found, mut refused) = (0, 0, 0);
    for program in every_file(&folder) {
        let name = program.strip_prefix(&folder).unwrap().to_str().unwrap().to_owned();
        if program.extension().is_none_or(|extension| extension != "ngc") || name.starts_with("bad/") {
            continue;
        }
        // Some tests print only what the program itself prints.
        let Some(expected) = expected_of(&program).filter(|text| text.contains("USE_LENGTH_UNITS")) else {
            continue;
        };
        let (unit, expected) = canonical(&expected);
        total += expected.len();
        match followed(&machine, &std::fs::read(&program).unwrap(), unit, ("", 0.0)) {
            Ok(motions) => {
                let places: Vec<_> =
                    motions.iter().map(|motion| (motion.line, place(&machine, motion))).collect();
                let matched = matched(&name, &places, &expected, PRINTED_MM);
                println!("{name}: {matched} of {}", expected.len());
                found += matched;
            }
            Err(why) => {
                println!("{name}: 0 of {}: {why}", expected.len());
                refused += 1;
            }
        }
    }
    share("RS274/NGC", RS274, total, found, refused);
}

/// The rows of a reference table that name an axis, each with the last value of every axis.
fn rows(table: &str) -> Vec<Place> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(table.as_bytes());
    let columns: BTreeMap<usize, usize> = reader
        .headers()
        .unwrap()
        .iter()
        .enumerate()
        .filter_map(|(column, name)| {
            let axis = LETTERS.iter().position(|letter| name == letter.to_string())?;
            Some((column, axis))
        })
        .collect();
    let mut last: Place = [None; 13];
    let mut places = Vec::new();
    for record in reader.records() {
        let record = record.unwrap();
        let mut moves = false;
        for (column, axis) in &columns {
            if let Some(value) = record.get(*column).and_then(|text| text.parse::<f64>().ok()) {
                last[*axis] = Some(value);
                moves = true;
            }
        }
        if moves {
            places.push(last);
        }
    }
    places
}

/// Where the axes are with TRANS, which the reference counts in: where they have to be for the tip.
fn with_offset(machine: &Machine, motion: &InterpretedMotion) -> Place {
    let mut at = place(machine, motion);
    at[6..].fill(None);
    let rotary_rad = [0, 1].map(|k| motion.joints[3 + k].map(f64::to_radians));
    at[..3].fill(None);
    if let (Some(tip_mm), [Some(first), Some(second)]) = (motion.tip_mm, rotary_rad) {
        let kinematics = Kinematics::new(machine, &Setup::default());
        let linear_mm: [f64; 3] = kinematics.linear_mm(tip_mm.into(), [first, second]).into();
        at[..3].copy_from_slice(&linear_mm.map(Some));
    }
    at
}

#[test]
fn every_followed_motion_is_one_of_the_reference_for_sinumerik() {
    let Some(folder) = shared_file("programs") else { return };
    let folder = folder.join("corpus/cead-sinumerik");
    let (mut total, mut found, mut refused) = (0, 0, 0);
    for program in every_file(&folder) {
        if program.extension().is_none_or(|extension| extension != "mpf") {
            continue;
        }
        let name = program.file_name().unwrap().to_str().unwrap().to_owned();
        let expected = rows(&std::fs::read_to_string(program.with_extension("csv")).unwrap());
        let has_b = expected.iter().any(|place| place[4].is_some());
        let first = if has_b { RotaryLetter::B } else { RotaryLetter::A };
        let machine = tables([first, RotaryLetter::C], false);
        total += expected.len();
        // The reference ran this one from Y900.
        let start_y_mm = if name == "increment.mpf" { 900.0 } else { 0.0 };
        let begins = ("G1", start_y_mm);
        match followed(&machine, &std::fs::read(&program).unwrap(), LengthUnit::Millimetre, begins) {
            Ok(motions) => {
                let places: Vec<_> =
                    motions.iter().map(|motion| (motion.line, with_offset(&machine, motion))).collect();
                let matched = matched(&name, &places, &expected, THREE_DECIMALS);
                println!("{name}: {matched} of {}", expected.len());
                found += matched;
            }
            Err(why) => {
                println!("{name}: 0 of {}: {why}", expected.len());
                refused += 1;
            }
        }
    }
    share("Sinumerik", SINUMERIK, total, found, refused);
}

/// After each of its motions, this program prints the place in machine coordinates: whatever its zeros are, it is in turn
/// (0, 0, 0) and (1, 2, 3), first in inches, then in millimetres.
#[test]
fn motions_in_machine_coordinates_go_where_the_reference_says_whatever_the_zeros_are() {
    let Some(folder) = shared_file("programs") else { return };
    let program = folder.join("corpus/linuxcnc-interp/rotation/abs-pts/test.ngc");
    let printed = expected_of(&program).unwrap();
    let printed: Vec<[f64; 3]> = printed
        .lines()
        .map(|line| {
            let (_, numbers) = line.split_once('"').unwrap();
            let numbers = numbers.trim_end_matches(['"', ')']).split_whitespace();
            numbers.map(|number| number.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap()
        })
        .collect();
    let machine = rs274_machine();
    let motions = followed(&machine, &std::fs::read(&program).unwrap(), LengthUnit::Inch, ("", 0.0)).unwrap();
    assert_eq!((motions.len(), printed.len()), (28, 28));
    for (index, (motion, printed)) in motions.iter().zip(&printed).enumerate() {
        let scale = if index < 14 { LengthUnit::Inch.mm() } else { 1.0 };
        let found = &place(&machine, motion)[10..];
        let near = found.iter().zip(printed).all(|(found, at)| (found.unwrap() - at * scale).abs() < 1e-9);
        assert!(near, "motion {index}: {found:?}, not {printed:?}");
    }
}

#[test]
fn a_compensated_path_that_the_reference_interpreter_refuses_is_left_alone() {
    let Some(folder) = shared_file("programs") else { return };
    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    // Of the second one the motion before the piece that is too short is left as well. Its last motion follows G40, and
    // where Y stands is not known.
    for (name, kept) in [("ccomp-arcexit.ngc", 3), ("ccomp-gouging.ngc", 3)] {
        let text = std::fs::read(folder.join("corpus/linuxcnc-interp/bad").join(name)).unwrap();
        let motions = followed(&machine, &text, LengthUnit::Inch, ("", 0.0)).unwrap();
        assert_eq!(motions.len(), kept, "{name}");
    }
}
