//! What has to hold whatever the bytes are. A check that fails panics, and that is a finding.

use std::ops::ControlFlow;

use trunnion_core::kinematics::Setup;
use trunnion_core::machine::{Machine, Preset, Tool};
use trunnion_core::motion::{Interpolation, Interpreter, InterpreterOptions};
use trunnion_core::process::{
    Budget, CcParameters, CcStep, CompensationParameters, Fault, MemorySpool, SingularityAction,
    SingularityParameters, WearParameters, WearStep, WornCutter, compensate, compensate_program, compensate_wear,
    treat_singular_regions,
};
use trunnion_core::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader, print_changed};
use trunnion_core::units::Length;
use trunnion_core::wear::OneAfterAnother;
use set_ups::{at_zero, in_mm};
use trunnion::process::ProgramSetup;

/// Lines longer than this are refused, so that the refusal is met too.
const LINE_BYTES: usize = 2048;
/// Small batches, so that their ends are met often.
const BATCH_BLOCKS: usize = 7;
const BATCH_BYTES: usize = 512;

/// A layout with tens of micrometres and microradians of location errors.
fn machine(id: &str) -> Machine {
    let mut parts = Preset::by_id(id).expect("a preset").parts();
    for axis in &mut parts.rotary_axes {
        axis.location_error.translation_mm = [0.02, -0.03, 0.01].into();
        axis.location_error.rotation_rad = [3e-5, -2e-5, 4e-5].into();
    }
    Machine::new(parts).expect("a machine")
}

/// Reads a program in chunks of this size; gives its bytes as read, its blocks by their lines and lengths, and whether
/// it was read to its end. Every block printed again is what it was.
fn read(dialect: Option<Dialect>, text: &[u8], chunk: usize, machine: &Machine) -> (Vec<u8>, Vec<(u64, u32, u32)>, bool) {
    let limits = ReadLimits {
        max_line_bytes: LINE_BYTES,
        batch_blocks: BATCH_BLOCKS,
        batch_bytes: BATCH_BYTES,
    };
    let mut reader = Reader::new(dialect, limits);
    let mut interpreter = Interpreter::new(machine, InterpreterOptions::in_mm());
    let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
    let (mut bytes, mut blocks) = (Vec::new(), Vec::new());
    let mut chunks = text.chunks(chunk.max(1));
    loop {
        let more = chunks.next();
        match more {
            Some(chunk) => reader.feed(chunk),
            None => reader.finish(),
        }
        loop {
            match reader.next_batch(&mut batch) {
                Err(_) => return (bytes, blocks, false),
                Ok(false) => break,
                Ok(true) => {}
            }
            assert_eq!(batch.offset(), bytes.len() as u64, "a gap between batches");
            bytes.extend_from_slice(batch.text());
            let mut again = Vec::new();
            for (index, block) in batch.blocks().iter().enumerate() {
                let from = again.len();
                print_changed(&batch, index, &[], false, &mut again).expect("a block without new words");
                assert_eq!(&again[from..], batch.block_text(block), "a block printed again");
                blocks.push((block.line, block.body_end - block.start, block.words_end - block.words_start));
                for word in batch.words(block) {
                    assert!(word.start >= block.start && word.start <= word.end && word.end <= block.body_end);
                    assert!(word.value.is_finite(), "a value that is no number");
                }
            }
            assert_eq!(again, batch.text(), "blocks do not cover the text");
            motions.clear();
            interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
            for motion in &motions {
                let known = motion.start.iter().chain(&motion.end);
                for words in known {
                    assert!(words.linear_mm.iter().chain(&words.rotary_deg).all(|value| value.is_finite()));
                }
            }
        }
        if more.is_none() {
            return (bytes, blocks, true);
        }
    }
}

/// A reader gives back every byte, the same blocks however the text is cut, and what it gives can be interpreted.
pub fn reader(dialect: Dialect, data: &[u8]) {
    let Some((&first, text)) = data.split_first() else { return };
    let machine = machine(["ac-table", "nutating-b-head-c-table", "bc-head"][usize::from(first >> 6) % 3]);
    // One chosen dialect, or the one that the text shows.
    let wanted = if first & 1 == 0 { Some(dialect) } else { None };
    let (bytes, blocks, whole) = read(wanted, text, usize::MAX, &machine);
    assert!(text.starts_with(&bytes) && (!whole || bytes == text), "bytes were lost");
    let (cut, same, also) = read(wanted, text, 1 + usize::from(first >> 1 & 31) * 5, &machine);
    assert_eq!(whole, also, "refused by how it was cut");
    if whole {
        assert_eq!((bytes, blocks), (cut, same), "blocks depend on how the text was cut");
    }
}

/// Nothing but a defect of the software makes a verification fail.
fn no_defect<T>(step: &str, found: Result<T, Fault>) -> Option<T> {
    if let Err(fault @ (Fault::VerificationFailed { .. } | Fault::Unwritable { .. })) = &found {
        panic!("{step}: {fault}");
    }
    found.ok()
}

/// A program goes through every step with a small budget: refused or written, never miswritten; what asks for nothing
/// gives it back as it was.
pub fn pipeline(data: &[u8]) {
    let Some((&[choice, detail], text)) = data.split_first_chunk::<2>() else { return };
    let source = text.to_vec();
    let go_on = || ControlFlow::Continue(());
    let machine = machine(["ac-table", "bc-table", "nutating-b-head-c-table", "bc-head"][usize::from(choice & 3)]);
    let mm = Length::from_mm;
    let tool = if choice & 4 == 0 { Tool::new(mm(5.0), mm(5.0)) } else { Tool::new(mm(6.0), mm(1.5)) };
    let tool = tool.expect("a tool");
    let setup = Setup { work_offset_mm: [12.0, -7.0, 35.0].into(), ..Setup::default() };
    let interpolation =
        [None, Some(Interpolation::Machine), Some(Interpolation::Tcp), None][usize::from(choice >> 3 & 3)];
    let budget = Budget { max_evaluations: 50_000, max_blocks_out: 5_000 };
    let cc = CcParameters {
        tolerance: mm([0.01, 0.1, 1.0, 0.001][usize::from(detail & 3)]),
        program: in_mm(&setup),
        program: ProgramSetup { interpolation, ..at_zero() },
        budget,
        ..CcParameters::new(tool, at_zero())
    };
    match choice >> 5 {
        0 | 1 => {
            let mut out = Vec::new();
            no_defect("cc", compensate(&machine, &cc, &source, &mut out, &go_on));
        }
        2 => {
            let wide = CcParameters { tolerance: CcParameters::MAX_TOLERANCE, ..cc };
            let mut out = Vec::new();
            let report = no_defect("cc, wide", compensate(&machine, &wide, &source, &mut out, &go_on));
            if report.is_some_and(|report| report.motions_over_tolerance == 0) {
                assert_eq!(out, source, "a program within tolerance was changed");
            }
        }
        3 => {
            let worn = Tool::new(tool.radius() - mm(0.1), tool.corner_radius() - mm(0.1)).expect("a tool");
            let wear = WearParameters { program: in_mm(&setup), program: ProgramSetup { interpolation, ..at_zero() }, ..WearParameters::new(tool, WornCutter::Tool(worn), at_zero()) };
            let mut out = Vec::new();
            no_defect("wear", compensate_wear(&machine, &wear, &source, &mut out, &go_on));
        }
        4 => {
            let worn = Tool::new(tool.radius() - mm(0.05), tool.corner_radius()).ok().map(WornCutter::Tool);
            let parameters = CompensationParameters {
                program: in_mm(&setup),
                program: ProgramSetup { interpolation, ..at_zero() },
                wear: worn.filter(|_| detail & 4 != 0).map(|worn| WearStep::new(tool, worn)),
                location_errors: detail & 8 != 0,
                cc: (detail & 16 != 0).then(|| CcStep { budget, ..CcStep::new(tool) }),
                ..CompensationParameters::new(at_zero())
            };
            let mut out = Vec::new();
            let spool = MemorySpool::default();
            let step = compensate_program(
                &machine,
                &parameters,
                &source,
                &spool,
                &mut out,
                &mut (),
                &OneAfterAnother,
                &go_on,
            );
            no_defect("one pass", step);
        }
        _ => {
            use SingularityAction::{Densify, Report, Smooth};
            let action = [Report, Densify, Smooth, Smooth][usize::from(detail >> 2 & 3)];
            let singularity = SingularityParameters::new(action);
            let mut out = Vec::new();
            let found = treat_singular_regions(&machine, &cc, &singularity, &source, &mut out, &go_on);
            if no_defect("singular regions", found).is_some_and(|report| report.regions_treated == 0) {
                assert_eq!(out, source, "a program without a treated region was changed");
            }
        }
    }
}
