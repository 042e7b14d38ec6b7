//! What has to hold whatever the bytes are. A check that fails panics, and that is a finding.

use std::ops::ControlFlow;
use std::sync::Arc;

use trunnion_core::machine::{Machine, Preset, Tool};
use trunnion_core::motion::{Interpolation, Interpreter, InterpreterOptions, ToolName, WorkOffset, WorkOffsets};
use trunnion_core::process::{
    Budget, CcParameters, CcStep, CompensationParameters, ContactSource, Fault, ListedTool, MemoryStepStore, ProgramSetup,
    SingularityAction, SingularityParameters, StartPosition, ToolTable, Tools, WearParameters, WearStep, WornCutter,
    compensate, compensate_program, compensate_wear, treat_singular_regions,
};
use trunnion_core::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader, print_changed};
use trunnion_core::units::{Feedrate, Length, LengthUnit};
use trunnion_core::side_by_side::OneAfterAnother;

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

/// What is stated of a program, by the bits of a byte: its unit, its work offsets, where the axes start, its tools.
fn stated(bits: u8, interpolation: Option<Interpolation>) -> ProgramSetup {
    use LengthUnit::{Inch, Millimetre};
    let mm = Length::from_mm;
    let unit = [Some(Millimetre), Some(Inch), None, Some(Millimetre)][usize::from(bits & 3)];
    let only_mm = Some([12.0, -7.0, 35.0]);
    let named = [("G54", [12.0, -7.0, 35.0]), ("G55", [-3.0, 2.5, 40.0]), ("G54.1 P3", [0.0; 3])];
    let named = named.into_iter().filter_map(|(name, at_mm)| Some((WorkOffset::from_name(name)?, at_mm))).collect();
    let work_offsets = match bits >> 2 & 3 {
        0 => WorkOffsets { only_mm, ..WorkOffsets::default() },
        1 => WorkOffsets { named_mm: named, ..WorkOffsets::default() },
        2 => WorkOffsets { only_mm, of_machine_mm: named, ..WorkOffsets::default() },
        _ => WorkOffsets::default(),
    };
    let known = StartPosition { linear_mm: [None, None, Some(100.0)], rotary_deg: [Some(0.0); 2] };
    let listed = |number, name: Option<&[u8]>, radius: f64, corner: f64, worn: f64| ListedTool {
        number,
        name: name.and_then(ToolName::new),
        cutter: Tool::new(mm(radius), mm(corner)).ok(),
        length: Some(mm(100.0 + radius)),
        worn: Tool::new(mm(radius - worn), mm((corner - worn).max(0.0))).ok(),
    };
    let table = ToolTable::new(vec![
        listed(Some(1), None, 5.0, 5.0, 0.1),
        listed(Some(2), Some(b"BALL_10"), 6.0, 1.5, 0.0),
        ListedTool { number: Some(3), name: None, cutter: None, length: None, worn: None },
    ]);
    let has_table = bits & 32 != 0;
    let table = Arc::new(if has_table { table } else { ToolTable::default() });
    let length = Some(mm(100.0)).filter(|_| !has_table);
    ProgramSetup {
        unit,
        interpolation,
        work_offsets: Arc::new(work_offsets),
        start: if bits & 16 == 0 { StartPosition::default() } else { known },
        tools: Tools::with(if bits & 0xc0 == 0xc0 { Some(1) } else { None }, length, table),
        allow_repeated: bits & 0x80 != 0,
        ..ProgramSetup::default()
    }
}

/// A program goes through every step with a small budget: refused or written, never miswritten; what asks for nothing
/// gives it back as it was.
pub fn pipeline(data: &[u8]) {
    let Some((&[choice, detail, bits], text)) = data.split_first_chunk::<3>() else { return };
    let source = text.to_vec();
    let go_on = || ControlFlow::Continue(());
    let machine = machine(["ac-table", "bc-table", "nutating-b-head-c-table", "bc-head"][usize::from(choice & 3)]);
    let mm = Length::from_mm;
    let tool = if choice & 4 == 0 { Tool::new(mm(5.0), mm(5.0)) } else { Tool::new(mm(6.0), mm(1.5)) };
    let tool = tool.expect("a tool");
    // With a table the tools may be its own.
    let stated_tool = Some(tool).filter(|_| bits & 0x60 != 0x60);
    let interpolation =
        [None, Some(Interpolation::Machine), Some(Interpolation::Tcp), None][usize::from(choice >> 3 & 3)];
    let budget = Budget { max_evaluations: 50_000, max_blocks_out: 5_000, ..Budget::default() };
    let cc = CcParameters {
        tolerance: mm([0.01, 0.1, 1.0, 0.001][usize::from(detail & 3)]),
        contact: if detail & 0x80 == 0 { ContactSource::Auto } else { ContactSource::FeedPlane },
        max_feed: Some(Feedrate::from_mm_per_min(10_000.0)).filter(|_| detail & 0x40 != 0),
        budget,
        ..CcParameters::new(stated_tool, stated(bits, interpolation))
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
            let worn = stated_tool.map(|_| WornCutter::Tool(worn));
            let wear = WearParameters { contact: cc.contact, ..WearParameters::new(stated_tool, worn, cc.program) };
            let mut out = Vec::new();
            no_defect("wear", compensate_wear(&machine, &wear, &source, &mut out, &go_on));
        }
        4 => {
            let worn = Tool::new(tool.radius() - mm(0.05), tool.corner_radius()).ok().map(WornCutter::Tool);
            let parameters = CompensationParameters {
                wear: (detail & 4 != 0).then(|| WearStep {
                    contact: cc.contact,
                    ..WearStep::new(stated_tool, worn.filter(|_| stated_tool.is_some()))
                }),
                location_errors: detail & 8 != 0,
                cc: (detail & 16 != 0).then(|| CcStep { contact: cc.contact, budget, ..CcStep::new(stated_tool) }),
                max_feed: cc.max_feed,
                ..CompensationParameters::new(cc.program)
            };
            let mut out = Vec::new();
            let spool = MemoryStepStore::default();
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
