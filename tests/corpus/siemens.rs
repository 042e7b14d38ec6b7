//! Sinumerik programs that others wrote: bytes, positions of a reference interpreter, token classes, compensation.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "tests stop at the first surprise, and tell numbers"
)]

use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use trunnion::machine::{Machine, Preset, RotaryLetter, Tool};
use trunnion::motion::{
    ArcCourse, Interpolation, Interpreter, InterpreterOptions, Motion, MotionKind, Unfollowable, WorkOffset,
    WorkOffsets,
};
use trunnion::process::{
    CcParameters, ContactSource, Fault, Interpreted, ListedTool, ProgramSetup, ToolTable, compensate,
    interpret_program,
};
use trunnion::program::{
    Batch, Block, BlockKind, Diagnostics, Dialect, ReadLimits, Reader, Severity, Word, WordForm,
};
use trunnion::units::Length;

use crate::set_ups::at_zero;
use crate::tables::tables;
use crate::{every_file, shared_file};

const PROGRAMS: [&str; 4] = [
    "5axis/nx_dmu70evo_840d_bc_traori.mpf",
    "5axis/elmoe_achskreuz_840d_bc_3plus2.mpf",
    "5axis/nx_huron_kx20_840d_g41.mpf",
    "other/gcws_sinumerik840d.nc",
];

fn read(text: &[u8], dialect: Option<Dialect>, chunk: usize) -> Vec<Batch> {
    let mut reader = Reader::new(dialect, ReadLimits::default());
    let (mut batches, mut batch) = (Vec::new(), Batch::new());
    for piece in text.chunks(chunk) {
        reader.feed(piece);
        while reader.next_batch(&mut batch).unwrap() {
            batches.push(batch.clone());
        }
    }
    reader.finish();
    while reader.next_batch(&mut batch).unwrap() {
        batches.push(batch.clone());
    }
    batches
}

fn follow(text: &[u8], machine: &Machine) -> (Vec<Motion>, Diagnostics) {
    let mut interpreter = Interpreter::new(machine, InterpreterOptions::in_mm());
    let (mut motions, mut diagnostics) = (Vec::new(), Diagnostics::new());
    for mut batch in read(text, Some(Dialect::Siemens), 64 * 1024) {
        interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
    }
    (motions, diagnostics)
}

/// Every Sinumerik file of the shared folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = PROGRAMS.iter().map(|name| folder.join(name)).collect();
    for corpus in ["corpus/cead-sinumerik", "corpus/s840d-syntax"] {
        files.extend(every_file(&folder.join(corpus)));
    }
    files.retain(|path| path.extension().is_none_or(|ending| ending != "csv"));
    files
}

#[test]
fn every_file_is_covered_by_its_blocks_byte_for_byte() {
    let Some(folder) = shared_file("programs") else { return };
    let files = files(&folder);
    assert_eq!(files.len(), 4 + 15 + 9);
    for path in files {
        let text = fs::read(&path).unwrap();
        let batches = read(&text, Some(Dialect::Siemens), 4096);
        let mut printed = Vec::new();
        for batch in &batches {
            for block in batch.blocks() {
                printed.extend_from_slice(batch.block_text(block));
                for word in batch.words(block) {
                    assert!(block.start <= word.start && word.end <= block.end, "{}", path.display());
                    assert!(word.start + u32::from(word.lead) <= word.end, "{}", path.display());
                }
            }
        }
        assert!(printed == text, "{}", path.display());
        assert!(read(&text, Some(Dialect::Siemens), 997) == batches, "{}", path.display());
    }
}

#[test]
fn every_program_is_recognised() {
    let Some(folder) = shared_file("programs") else { return };
    // Pieces of programs with nothing that only this control has would be read as ISO.
    let unmarked: [&str; 0] = [];
    for path in files(&folder).iter().filter(|path| !path.to_string_lossy().contains("s840d-syntax")) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let dialect = read(&fs::read(path).unwrap(), None, 64 * 1024)[0].dialect();
        assert_eq!(dialect == Dialect::Siemens, !unmarked.contains(&name.as_str()), "{name}");
    }
}

#[test]
fn real_programs_are_read_without_a_fault() {
    let Some(folder) = shared_file("programs") else { return };
    let machine = tables([RotaryLetter::B, RotaryLetter::C], false);
    for name in PROGRAMS {
        let text = fs::read(folder.join(name)).unwrap();
        let faults: Vec<_> =
            read(&text, None, 64 * 1024).iter().flat_map(|batch| batch.faults().to_vec()).collect();
        assert_eq!(faults, [], "{name}");
        let (motions, diagnostics) = follow(&text, &machine);
        assert_eq!(diagnostics.count(Severity::Refusal), 0, "{name}");
        let alone = motions.iter().filter(|motion| motion.unfollowable.is_some()).count();
        let known = motions.iter().filter(|motion| motion.end.is_some()).count();
        println!("{name}: {} motions, {alone} left alone, end known of {known}", motions.len());
        for diagnostic in diagnostics.kept() {
            println!("  {diagnostic}");
        }
    }
}

#[test]
fn helices_with_turns_are_arcs_and_tools_have_their_names() {
    let Some(folder) = shared_file("programs") else { return };
    let text = fs::read(folder.join(PROGRAMS[2])).unwrap();
    let (motions, _) = follow(&text, &tables([RotaryLetter::B, RotaryLetter::C], false));
    let helices: Vec<_> = motions.iter().filter(|motion| (210..=222).contains(&motion.line)).collect();
    assert_eq!(helices.len(), 13);
    for helix in helices {
        assert_eq!((helix.kind, helix.arc), (MotionKind::Arc, ArcCourse::Centre), "line {}", helix.line);
        // The last one has TURN=.5, which is no number of circles.
        assert_eq!(helix.further_turns, (helix.line != 222).then_some(1), "line {}", helix.line);
        assert_eq!(helix.unfollowable, Some(Unfollowable::CutterCompensation), "line {}", helix.line);
    }
    let batches = read(&fs::read(folder.join(PROGRAMS[1])).unwrap(), None, 64 * 1024);
    let names: Vec<String> = batches
        .iter()
        .flat_map(|batch| {
            batch.blocks().iter().flat_map(|block| batch.words(block)).map(move |word| (batch, word))
        })
        .filter_map(|(batch, word)| Some(String::from_utf8_lossy(batch.name(word)?).into_owned()))
        .collect();
    assert_eq!(names, ["PLAN_D50_N_AP4", "SCHAFT_D12_N_AP30", "SCHAFT_D6_N_AP15", "ENTFRAESER_D8_N_90GRAD"]);
}

/// Words of an axis in so many blocks, as the index counts them.
#[test]
fn blocks_and_words_are_counted_as_the_index_counts_them() {
    let Some(folder) = shared_file("programs") else { return };
    for (name, blocks, words) in [
        (PROGRAMS[0], 1198, &[('Z', 503), ('Y', 659), ('X', 747), ('B', 337), ('C', 337)][..]),
        (PROGRAMS[1], 3073, &[('B', 25), ('C', 25)][..]),
        (PROGRAMS[2], 262, &[('Z', 70), ('X', 125), ('Y', 115)][..]),
        (PROGRAMS[3], 274, &[('B', 37), ('X', 45), ('Y', 72), ('Z', 12)][..]),
    ] {
        let batches = read(&fs::read(folder.join(name)).unwrap(), None, 64 * 1024);
        let counted = batches.iter().flat_map(Batch::blocks).filter(|block| block.counts()).count();
        assert_eq!(counted, blocks, "{name}");
        for &(letter, expected) in words {
            // The index counts numbers, not `Z=WYSSRU`; TRANS and AROT take words as motions do.
            let has = |batch: &Batch, block: &Block| {
                batch.words(block).iter().any(|word| {
                    word.address.letter() == Some(letter as u8)
                        && word.form == WordForm::Number
                        && word.lead == 1
                })
            };
            let found: usize = batches
                .iter()
                .map(|batch| batch.blocks().iter().filter(|block| has(batch, block)).count())
                .sum();
            assert_eq!(found, expected, "{name}: {letter}");
        }
    }
}

/// Half of the last of three decimals printed \[mm\], and what a double may lose.
const PRINTED_MM: f64 = 0.5e-3 + 1e-9;

/// Cases of the reference interpreter that follow from the text alone, and where X Y Z stand before them: its own
/// defaults, which `increment` shows to be Y 900.
const FOLLOWED: [(&str, [f64; 3]); 8] = [
    ("basic_math", [0.0; 3]),
    ("case_insensitive_variables", [0.0; 3]),
    ("def_string", [0.0; 3]),
    ("increment", [0.0, 900.0, 0.0]),
    ("precedence", [0.0; 3]),
    ("trans", [0.0; 3]),
    ("trans_ic", [0.0; 3]),
    ("trig", [0.0; 3]),
];

/// Cases that do not, and why: refused, with the line of the first statement in the way.
const LEFT_OUT: [(&str, u64, &str); 7] = [
    ("actual_position", 7, "REPEAT loop; $AA_IW is run-time state"),
    ("arrays", 8, "FOR loops"),
    ("edge_cases", 56, "jumps and CASE, and a call; compared up to the call"),
    ("for_loop", 3, "FOR loop"),
    ("goto", 3, "jumps"),
    ("loop", 31, "IF and WHILE"),
    ("repeat", 3, "REPEAT loop"),
];

/// X Y Z and F of every row of a table, blank cells as they stood; rows that change nothing apart.
fn reference(csv: &str, rows: usize, start: [f64; 3]) -> Vec<([f64; 3], Option<f64>)> {
    let mut lines = csv.lines();
    let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut places = vec![(start, None)];
    for line in lines.take(rows) {
        // The comment comes last: no comma of it is counted.
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |name: &str| {
            let index = columns.iter().position(|column| *column == name)?;
            cells.get(index)?.parse::<f64>().ok()
        };
        let (before, feed_before) = places[places.len() - 1];
        let mut place = before;
        for (value, name) in place.iter_mut().zip(["X", "Y", "Z"]) {
            *value = cell(name).unwrap_or(*value);
        }
        places.push((place, cell("F").or(feed_before)));
    }
    places.dedup_by_key(|place| place.0.map(f64::to_bits));
    places
}

/// The same of a program that stands at `start`.
fn followed(text: &[u8], start: [f64; 3]) -> Vec<([f64; 3], Option<f64>)> {
    let [x, y, z] = start;
    let mut program = format!("G0 X{x} Y{y} Z{z} B0 C0\n").into_bytes();
    program.extend_from_slice(text);
    let (motions, diagnostics) = follow(&program, &tables([RotaryLetter::B, RotaryLetter::C], false));
    assert_eq!(diagnostics.count(Severity::Refusal), 0);
    let mut places: Vec<([f64; 3], Option<f64>)> = Vec::new();
    for motion in motions.iter().filter(|motion| motion.kind != MotionKind::Opaque) {
        let (end, offset) = (motion.end.unwrap().linear_mm, motion.program_offset_mm.unwrap());
        places.push((std::array::from_fn(|k| end[k] + offset[k]), motion.feed.value));
    }
    places.dedup_by_key(|place| place.0.map(f64::to_bits));
    places
}

fn assert_same(name: &str, found: &[([f64; 3], Option<f64>)], expected: &[([f64; 3], Option<f64>)]) {
    assert_eq!(found.len(), expected.len(), "{name}: {found:?}, not {expected:?}");
    for (found, expected) in found.iter().zip(expected) {
        let near = found.0.iter().zip(&expected.0).all(|(a, b)| (a - b).abs() <= PRINTED_MM);
        assert!(near, "{name}: {found:?}, not {expected:?}");
        if expected.1.is_some() {
            assert_eq!(found.1, expected.1, "{name}: {found:?}");
        }
    }
}

#[test]
fn places_agree_with_the_reference_interpreter() {
    let Some(folder) = shared_file("programs/corpus/cead-sinumerik") else { return };
    let all: HashSet<String> = every_file(&folder)
        .iter()
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    assert_eq!(all.len(), FOLLOWED.len() + LEFT_OUT.len());
    let mut places = 0;
    for (name, start) in FOLLOWED {
        let text = fs::read(folder.join(format!("{name}.mpf"))).unwrap();
        let csv = fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap();
        let expected = reference(&csv, usize::MAX, start);
        assert!(expected.len() > 2, "{name}");
        places += expected.len() - 1;
        assert_same(name, &followed(&text, start), &expected);
    }
    println!("{places} places of {} cases agree", FOLLOWED.len());
}

#[test]
fn the_rest_of_the_reference_is_refused_by_line() {
    let Some(folder) = shared_file("programs/corpus/cead-sinumerik") else { return };
    let machine = tables([RotaryLetter::B, RotaryLetter::C], false);
    for (name, line, reason) in LEFT_OUT {
        let text = fs::read(folder.join(format!("{name}.mpf"))).unwrap();
        let (_, diagnostics) = follow(&text, &machine);
        let first = diagnostics.refusals().next().map(|refusal| refusal.line);
        assert_eq!(first, Some(line), "{name}: {reason}");
    }
}

/// The part of `edge_cases` in front of its first call, line 53 of 88.
#[test]
fn edge_cases_agree_up_to_the_first_call() {
    let Some(folder) = shared_file("programs/corpus/cead-sinumerik") else { return };
    let text = fs::read_to_string(folder.join("edge_cases.mpf")).unwrap();
    let before = text.split_once("N53 MATERIAL_UPDATE").unwrap().0;
    let csv = fs::read_to_string(folder.join("edge_cases.csv")).unwrap();
    let rows = csv.lines().skip(1).take_while(|line| !line.contains("MATERIAL_UPDATE")).count();
    let expected = reference(&csv, rows, [0.0; 3]);
    assert!(expected.len() > 15, "{}", expected.len());
    assert_same("edge_cases", &followed(before.as_bytes(), [0.0; 3]), &expected);
}

/// A class that the syntax corpus expects of some bytes of the line above.
struct Expected<'a> {
    line: usize,
    from: usize,
    to: usize,
    scope: &'a str,
}

/// Lines of code, and what is said of them.
fn expectations(text: &str) -> Vec<Expected<'_>> {
    let mut found = Vec::new();
    let mut code = 0;
    for (number, line) in text.lines().enumerate() {
        let Some((marks, scope)) = line.rsplit_once('^') else {
            if !line.starts_with(';') {
                code = number;
            }
            continue;
        };
        let Some(from) = marks.find('^').or(Some(marks.len())) else { continue };
        let is_mark = line.starts_with(';') && marks[1..].chars().all(|mark| mark == '^' || mark == ' ');
        if is_mark {
            found.push(Expected { line: code, from, to: marks.len() + 1, scope: scope.trim() });
        } else if !line.starts_with(';') {
            code = number;
        }
    }
    found
}

/// What is compared: letters with numbers. Names with a digit or a bracket of their own (`X1=`, `AX[1]=`, `M1=`,
/// `PO[THT]`) are no words here, and the insides of expressions are not told apart: those are left out.
#[test]
fn token_classes_of_words_agree_with_the_syntax_corpus() {
    let Some(folder) = shared_file("programs/corpus/s840d-syntax") else { return };
    let text = fs::read_to_string(folder.join("syntax_test_din.spf")).unwrap();
    let batches = read(text.as_bytes(), Some(Dialect::Siemens), 64 * 1024);
    let lines: Vec<&str> = text.lines().collect();
    let blocks: Vec<(&Batch, &Block)> =
        batches.iter().flat_map(|batch| batch.blocks().iter().map(move |block| (batch, block))).collect();
    let (mut heads, mut numbers, mut refused) = (0, 0, 0);
    for expected in expectations(&text) {
        let (batch, block) = blocks[expected.line];
        let code = lines[expected.line].as_bytes();
        let place = format!("line {}: {}", expected.line + 1, lines[expected.line]);
        let words = batch.words(block);
        let at = |word: &Word| {
            let start = (word.start - block.start) as usize;
            (start, start + usize::from(word.lead), (word.end - block.start) as usize)
        };
        if expected.scope.starts_with("invalid.illegal") {
            // `AX1[1]=` may be a variable of the builder's: its motion is left alone, not refused.
            let is_name = lines[expected.line].contains("AX1[");
            assert!(is_name || block.kind == BlockKind::Malformed, "{place}");
            refused += usize::from(!is_name);
        } else if block.kind == BlockKind::Malformed {
        } else if ["support.function.iso", "support.variable.iso"]
            .iter()
            .any(|scope| expected.scope.starts_with(scope))
        {
            let letter = code[expected.from];
            let behind = &code[expected.from + 1..];
            let digits = behind.iter().take_while(|byte| byte.is_ascii_digit()).count();
            let after = behind[digits..].iter().find(|byte| **byte != b' ').copied();
            let is_name = behind.first().is_some_and(u8::is_ascii_alphabetic)
                || (digits > 0 && matches!(after, Some(b'=' | b'[')))
                || (after == Some(b'[') && letter != b'G');
            if !is_name {
                let has = words
                    .iter()
                    .any(|word| at(word).0 == expected.from && word.address.letter() == Some(letter));
                assert!(has, "{place}: no word at column {}", expected.from);
                heads += 1;
            }
        } else if expected.scope.starts_with("constant.numeric") {
            let inside = words.iter().any(|word| {
                let (_, from, to) = at(word);
                word.keyword().is_none() && from <= expected.from && expected.to <= to
            });
            numbers += usize::from(inside);
        }
    }
    println!("{heads} words, {numbers} numbers, {refused} marks of what no control takes");
    assert!(heads >= 59 && numbers >= 51 && refused >= 7, "{heads} {numbers} {refused}");
}

/// Lines of the operation of cross-check 2 of the index.
const CONTOUR: std::ops::RangeInclusive<u64> = 480..=789;

fn nutating() -> Machine {
    Machine::new(Preset::by_id("nutating-b-head-c-table").unwrap().parts()).unwrap()
}

#[test]
fn the_contour_of_the_nutating_head_is_followed_under_traori() {
    let Some(path) = shared_file("programs/5axis/nx_dmu70evo_840d_bc_traori.mpf") else { return };
    let (motions, _) = follow(&fs::read(path).unwrap(), &nutating());
    let contour: Vec<_> = motions.iter().filter(|motion| CONTOUR.contains(&motion.line)).collect();
    assert_eq!(contour.len(), 310);
    for motion in &contour {
        assert_eq!(motion.unfollowable, None, "line {}", motion.line);
        assert_eq!(motion.interpolation, Interpolation::Tcp);
        assert!(motion.start.is_some() && motion.end.is_some(), "line {}", motion.line);
        // The file works in G54 first; this operation stands under G56.
        assert!(motion.offset_changed, "line {}", motion.line);
        assert!((motion.mm_per_unit - 25.4).abs() < 1e-12);
    }
    let last = contour[contour.len() - 1].end.unwrap();
    assert!((last.rotary_deg[1] - 1721.096).abs() < 1e-9, "{last:?}");
    let supa = motions.iter().filter(|motion| motion.unfollowable == Some(Unfollowable::MachineCoordinates));
    assert!(supa.count() >= 39);
}

/// Compensates and says what came of it; the motions checked, and those over the tolerance.
fn compensated(program: &[u8], contact: ContactSource, tolerance_um: f64) -> (u64, u64) {
    let radius = Length::from_mm(5.0);
    let ball = Tool::new(radius, radius).unwrap();
    // What its tools are and where its three zeros are the file does not say.
    let tools = [1, 2, 3, 5, 6, 7, 8, 9].map(|number| ListedTool {
        number: Some(number),
        name: None,
        cutter: Some(ball),
        length: Some(Length::ZERO),
        worn: None,
    });
    let named_mm =
        ["G54", "G55", "G56"].map(|name| (WorkOffset::from_name(name).unwrap(), [3.0, -7.0, 50.0]));
    let offsets = WorkOffsets { named_mm: BTreeMap::from(named_mm), ..WorkOffsets::default() };
    let mut program_setup = ProgramSetup { work_offsets: Arc::new(offsets), ..at_zero() };
    program_setup.tools.table = Arc::new(ToolTable::new(tools.to_vec()));
    let parameters = CcParameters {
        contact,
        tolerance: Length::from_um(tolerance_um),
        ..CcParameters::new(ball, program_setup)
    };
    let mut output = Vec::new();
    let report =
        compensate(&nutating(), &parameters, &program.to_vec(), &mut output, &|| ControlFlow::Continue(()));
    let report = report.unwrap();
    println!(
        "{contact:?} {tolerance_um} µm, {:?}: {} checked, {} over; {:.2} µm before, {:.2} µm after; {} blocks became {}",
        report.interpolation,
        report.motions_checked,
        report.motions_over_tolerance,
        report.before.max_mm * 1e3,
        report.after.max_mm * 1e3,
        report.blocks_in,
        report.blocks_out,
    );
    assert!(report.after.max_mm <= tolerance_um / 1e3);
    // Every line that is not divided is there as it was, but for those that get their feed back behind one.
    let written: HashSet<&[u8]> = output.split(|byte| *byte == b'\n').collect();
    let missing = program.split(|byte| *byte == b'\n').filter(|line| !written.contains(line)).count();
    assert!(missing as u64 <= report.motions_over_tolerance + report.feeds_restored, "{missing}");
    if report.motions_over_tolerance == 0 {
        assert!(output == program);
    }
    (report.motions_checked, report.motions_over_tolerance)
}

#[test]
fn the_nutating_head_s_program_is_compensated_and_keeps_its_tolerance() {
    let Some(path) = shared_file("programs/5axis/nx_dmu70evo_840d_bc_traori.mpf") else { return };
    let program = fs::read(path).unwrap();
    // Four decimals of an inch leave 2.5 µm open.
    let (checked, over) = compensated(&program, ContactSource::FeedPlane, 4.0);
    assert!(checked >= 500 && over > 0, "{checked} {over}");
    // The contour as a program of its own, in the offset it starts with.
    let mut contour = b"N1 G00 G90 G70 G40\n".to_vec();
    for line in program.split_inclusive(|byte| *byte == b'\n').skip(475).take(314) {
        contour.extend_from_slice(line);
    }
    for contact in [ContactSource::FeedPlane, ContactSource::Tip] {
        let (checked, over) = compensated(&contour, contact, 4.0);
        assert!(checked >= 309, "{checked}");
        assert!((over > 0) == (contact == ContactSource::FeedPlane), "{over}");
    }
}

#[test]
fn every_program_is_compensated_or_refused_by_line_and_never_miswritten() {
    let Some(folder) = shared_file("programs") else { return };
    let machines = [nutating(), tables([RotaryLetter::B, RotaryLetter::C], false)];
    let (mut written, mut refused) = (0, 0);
    for path in files(&folder) {
        let program = fs::read(&path).unwrap();
        for machine in &machines {
            let radius = Length::from_mm(5.0);
            let parameters = CcParameters {
                program: ProgramSetup { dialect: Some(Dialect::Siemens), ..at_zero() },
                contact: ContactSource::FeedPlane,
                ..CcParameters::new(Tool::new(radius, radius).unwrap(), at_zero())
            };
            let mut output = Vec::new();
            match compensate(machine, &parameters, &program, &mut output, &|| ControlFlow::Continue(())) {
                Ok(report) => {
                    assert!(report.after.max_mm <= 0.010);
                    assert!(report.motions_over_tolerance > 0 || output == program, "{}", path.display());
                    written += 1;
                }
                Err(fault @ (Fault::VerificationFailed { .. } | Fault::Unwritable { .. } | Fault::Io(_))) => {
                    panic!("{}: {fault}", path.display());
                }
                Err(fault) => {
                    println!("{}: {fault}", path.display());
                    refused += 1;
                }
            }
        }
    }
    println!("{written} written, {refused} refused");
    assert!(written >= 16, "{written}");
}

/// The program states the turn of every face by AROT, and the rotary axes by B and C. So both have to agree: under a
/// turn, a motion of Z alone runs along the tool.
#[test]
fn plunges_in_turned_frames_run_along_the_tool() {
    let Some(folder) = shared_file("programs") else { return };
    let text = fs::read_to_string(folder.join(PROGRAMS[1])).unwrap();
    let machine = tables([RotaryLetter::B, RotaryLetter::C], false);
    let mut motions = Vec::new();
    let mut take = |told: &Interpreted| {
        if let Interpreted::Motion(motion) = told {
            motions.push(*motion);
        }
        Ok(())
    };
    let source = text.clone().into_bytes();
    let program = ProgramSetup { dialect: Some(Dialect::Siemens), ..at_zero() };
    interpret_program(&machine, &program, &source, &mut take, &|| ControlFlow::Continue(())).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let turned_from = lines.iter().position(|line| line.contains("AROT")).unwrap() as u64;
    let mut plunges = 0;
    for pair in motions.windows(2) {
        let [before, after] = pair else { continue };
        let (Some(from), Some(to), Some(axis)) = (before.tip_mm, after.tip_mm, after.axis) else { continue };
        let block = lines[usize::try_from(after.line).unwrap() - 1];
        let is_plunge = block.contains('Z') && !block.contains(['X', 'Y']);
        if after.line != before.line + 1 || after.line < turned_from || !is_plunge {
            continue;
        }
        let path: [f64; 3] = std::array::from_fn(|k| to[k] - from[k]);
        let length = path.iter().map(|part| part * part).sum::<f64>().sqrt();
        let along = path.iter().zip(axis).map(|(part, axis)| part * axis).sum::<f64>().abs();
        assert!((length - along).abs() < 1e-9, "line {}: {path:?} along {axis:?}", after.line);
        plunges += 1;
    }
    println!("{plunges} plunges run along the tool");
    assert!(plunges > 100, "{plunges}");
    // Arcs of a face run across the tool.
    let arcs = motions.iter().filter(|motion| motion.line >= turned_from && motion.arc.is_some());
    let mut across = 0;
    for motion in arcs {
        let (normal, axis) = (motion.arc.unwrap().normal, motion.axis.unwrap());
        let along = normal.iter().zip(axis).map(|(part, axis)| part * axis).sum::<f64>().abs();
        assert!((along - 1.0).abs() < 1e-9, "line {}: {normal:?} and {axis:?}", motion.line);
        across += 1;
    }
    println!("{across} arcs run across the tool");
    assert!(across >= 306, "{across}");
}
