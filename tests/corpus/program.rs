//! The reader over programs that nobody here wrote.

#![expect(clippy::unwrap_used, reason = "tests stop at the first surprise")]

use trunnion::machine::{Machine, RotaryLetter};
use trunnion::motion::{
    FeedMode, Interpolation, Interpreter, InterpreterOptions, Motion, MotionKind, Unfollowable,
};
use trunnion::program::{
    Address, Batch, Diagnostics, Dialect, ReadFault, ReadLimits, Reader, Severity, WordForm,
};

use trunnion::units::LengthUnit;

use crate::tables::tables;
use crate::{every_file, shared_file};

fn read(text: &[u8], dialect: Option<Dialect>, chunk: usize) -> Result<Vec<Batch>, ReadFault> {
    let mut reader = Reader::new(dialect, ReadLimits::default());
    let mut batches = Vec::new();
    let mut batch = Batch::new();
    for piece in text.chunks(chunk) {
        reader.feed(piece);
        while reader.next_batch(&mut batch)? {
            batches.push(batch.clone());
        }
    }
    reader.finish();
    while reader.next_batch(&mut batch)? {
        batches.push(batch.clone());
    }
    Ok(batches)
}

#[test]
fn every_file_is_covered_by_its_blocks_byte_for_byte() {
    let Some(folder) = shared_file("programs") else { return };
    let files = every_file(&folder);
    assert!(files.len() > 150, "only {} files", files.len());
    for path in files {
        let text = std::fs::read(&path).unwrap();
        let batches = read(&text, Some(Dialect::Iso), 4096).unwrap();
        let mut printed = Vec::new();
        let mut line = 1;
        for batch in &batches {
            assert_eq!(batch.offset(), printed.len() as u64);
            for block in batch.blocks() {
                assert_eq!(block.line, line);
                line += 1;
                printed.extend_from_slice(batch.block_text(block));
            }
        }
        assert!(printed == text, "{}", path.display());
        assert!(read(&text, Some(Dialect::Iso), 997).unwrap() == batches, "{}", path.display());
    }
}

/// File, blocks, and in how many blocks an address stands.
type Count = (&'static str, usize, &'static [(char, usize)]);

const COUNTS: [Count; 17] = [
    (
        "5axis/linuxcnc_impeller_xyzac_tcp_g93.ngc",
        4498,
        &[('X', 4491), ('Y', 4491), ('Z', 4491), ('A', 4491), ('C', 4491)],
    ),
    (
        "5axis/nx_mori_nmv5000_bc_g43.4.txt",
        889,
        &[('Z', 423), ('X', 597), ('Y', 232), ('B', 364), ('C', 367)],
    ),
    (
        "5axis/zhangty_simple_curve_bc_machine.gcode",
        41680,
        &[('X', 41516), ('Y', 41516), ('Z', 41535), ('B', 41516), ('C', 41516)],
    ),
    (
        "5axis/linuxcnc_xyzab_dual_rotary_demo.ngc",
        38,
        &[('X', 8), ('Y', 13), ('Z', 10), ('A', 18), ('B', 16)],
    ),
    ("5axis/linuxcnc_twp_g68.2_simple.ngc", 8, &[('X', 4), ('Y', 4), ('Z', 4)]),
    ("5axis/linuxcnc_twp_circular_pocket.ngc", 12, &[('X', 2), ('Z', 5), ('Y', 1)]),
    ("5axis/nx_sundstrand_4axis_b_no_blanks.ptp", 371, &[('X', 249), ('Y', 58), ('Z', 233), ('B', 213)]),
    ("5axis/nx_okuma_7000m.txt", 161, &[('W', 2), ('X', 41), ('Y', 51), ('Z', 33)]),
    ("5axis/nx_roeders_finish_36k.ptp", 36746, &[('X', 33760), ('Y', 34641), ('Z', 1498)]),
    ("other/nist_d2mi_op1_g41_macro.nc", 1008, &[('Z', 237), ('X', 691), ('Y', 597)]),
    ("other/nist_mtc_box_op4_engraving.nc", 5220, &[('X', 4675), ('Y', 4773), ('Z', 2758)]),
    ("other/gcws_macro7.nc", 84, &[]),
    ("other/gcws_fanuc0m.nc", 33, &[('X', 10), ('Y', 10), ('Z', 9)]),
    ("other/gcws_haas.nc", 40, &[('X', 12), ('Y', 12), ('Z', 15)]),
    ("other/camotics_tiger_67k.nc", 67426, &[('X', 64080), ('Y', 2601), ('Z', 63099)]),
    ("other/linuxcnc_3d_chips.ngc", 4698, &[]),
    ("other/linuxcnc_cds.ngc", 273, &[('Z', 45), ('X', 202), ('Y', 138)]),
];

#[test]
fn blocks_and_words_are_counted_as_the_index_counts_them() {
    let Some(folder) = shared_file("programs") else { return };
    let mut wrong = Vec::new();
    for (name, blocks, words) in COUNTS {
        let text = std::fs::read(folder.join(name)).unwrap();
        let batches = read(&text, None, 64 * 1024).unwrap();
        let counted = batches.iter().flat_map(Batch::blocks).filter(|block| block.counts()).count();
        if counted != blocks {
            wrong.push(format!("{name}: {counted} blocks, not {blocks}"));
        }
        for &(letter, expected) in words {
            let address = Address::from_letter(letter as u8).unwrap();
            let found: usize = batches
                .iter()
                .map(|batch| {
                    let has = |block| {
                        batch
                            .words(block)
                            .iter()
                            .any(|word| word.address == address && word.form == WordForm::Number)
                    };
                    batch.blocks().iter().filter(|block| has(block)).count()
                })
                .sum();
            if found != expected {
                wrong.push(format!("{name}: {found} blocks with {letter}, not {expected}"));
            }
        }
        for fault in batches.iter().flat_map(Batch::faults) {
            if name != "other/gcws_macro7.nc" {
                wrong.push(format!("{name}: {fault}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn dialects_are_recognised() {
    let Some(folder) = shared_file("programs") else { return };
    for (name, dialect) in [
        ("5axis/nx_dmu70evo_840d_bc_traori.mpf", Dialect::Siemens),
        ("5axis/elmoe_achskreuz_840d_bc_3plus2.mpf", Dialect::Siemens),
        ("5axis/nx_huron_kx20_840d_g41.mpf", Dialect::Siemens),
        ("other/gcws_sinumerik840d.nc", Dialect::Siemens),
        ("5axis/nx_dmc100_heidenhain_m128.h", Dialect::Heidenhain),
        ("cl/aamorim_boss_posted_11.h", Dialect::Heidenhain),
        ("cl/aamorim_boss_posted_12.h", Dialect::Heidenhain),
        ("other/aamorim_machine_cirstud.h", Dialect::Heidenhain),
        ("other/aamorim_machine_printr1.h", Dialect::Heidenhain),
        ("cl/aamorim_boss.apt", Dialect::Apt),
        ("cl/aamorim_tilt_support.apt", Dialect::Apt),
        ("cl/aamorim_interface_glue.clt", Dialect::Apt),
    ] {
        let text = std::fs::read(folder.join(name)).unwrap();
        assert_eq!(read(&text, None, 1000).unwrap()[0].dialect(), dialect, "{name}");
    }
}

#[test]
fn no_program_is_taken_for_one_of_a_dialect_that_is_not_read() {
    let Some(folder) = shared_file("programs") else { return };
    for path in every_file(&folder) {
        let text = std::fs::read(&path).unwrap();
        let foreign = matches!(read(&text, None, 4096), Err(ReadFault::UnsupportedDialect { .. }));
        assert!(!foreign, "{}", path.display());
    }
    // Plain words of an Okuma control are read as they were.
    let text = std::fs::read(folder.join("5axis/nx_okuma_7000m.txt")).unwrap();
    assert_eq!(read(&text, None, 4096).unwrap()[0].dialect(), Dialect::Iso);
}

#[test]
fn the_okuma_listing_is_followed_as_what_its_control_does() {
    let Some(folder) = shared_file("programs") else { return };
    let text = std::fs::read(folder.join("5axis/nx_okuma_7000m.txt")).unwrap();
    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    let mut all = Vec::new();
    for dialect in [Dialect::Okuma, Dialect::Iso] {
        let options = InterpreterOptions {
            unit: Some(LengthUnit::Inch),
            start: [None, None, None, Some(0.0), Some(0.0)],
            ..InterpreterOptions::default()
        };
        let mut interpreter = Interpreter::new(&machine, options);
        let (mut motions, mut diagnostics) = (Vec::new(), Diagnostics::new());
        for mut batch in read(&text, Some(dialect), 4096).unwrap() {
            assert!(batch.faults().is_empty(), "{:?}", batch.faults());
            interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
        }
        assert_eq!(diagnostics.kept(), [], "{dialect}");
        all.push(motions);
    }
    let [okuma, iso] = [&all[0], &all[1]];
    let at = |motions: &[Motion], line| *motions.iter().find(|motion| motion.line == line).unwrap();
    // No work offset is named: G56 is a length along Z, and the cuts behind it stand where the words say.
    assert!(okuma.iter().all(|motion| !motion.offset_changed));
    assert_eq!(
        at(iso, 23).end,
        None,
        "as ISO, G56 is another work offset, in which nobody knows where A and C are"
    );
    let cut = at(okuma, 23);
    let end = cut.end.unwrap().linear_mm;
    assert_eq!((cut.kind, cut.unfollowable), (MotionKind::Linear, None));
    for (found, inch) in end.into_iter().zip([-0.4331, 4.3701, 3.937]) {
        assert!((found - inch * 25.4).abs() < 1e-9, "{end:?}");
    }
    // G55 and G54: the tool stands along Y and X, and nothing of that is followed.
    let along_others = |motion: &&Motion| (50..79).contains(&motion.line);
    assert!(okuma.iter().filter(along_others).count() >= 8);
    assert!(okuma.iter().filter(along_others).all(|motion| motion.unfollowable.is_some()));
    // Bores stand in cycles.
    let cycles = okuma.iter().filter(|motion| motion.unfollowable == Some(Unfollowable::CannedCycle)).count();
    assert!(cycles > 40, "{cycles}");
}

fn follow(text: &[u8], machine: &Machine) -> (Vec<Motion>, Diagnostics) {
    follow_with(text, machine, InterpreterOptions::in_mm())
}

fn follow_with(text: &[u8], machine: &Machine, options: InterpreterOptions) -> (Vec<Motion>, Diagnostics) {
    let mut interpreter = Interpreter::new(machine, options);
    let (mut motions, mut diagnostics) = (Vec::new(), Diagnostics::new());
    for mut batch in read(text, None, 64 * 1024).unwrap() {
        interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
    }
    (motions, diagnostics)
}

#[test]
fn the_impeller_is_followed_from_end_to_end() {
    let Some(folder) = shared_file("programs") else { return };
    let text = std::fs::read(folder.join("5axis/linuxcnc_impeller_xyzac_tcp_g93.ngc")).unwrap();
    let stated =
        InterpreterOptions { interpolation: Some(Interpolation::Tcp), ..InterpreterOptions::in_mm() };
    let (motions, diagnostics) =
        follow_with(&text, &tables([RotaryLetter::A, RotaryLetter::C], false), stated);
    assert_eq!(diagnostics.kept(), []);
    assert!(motions.len() >= 4491);
    let complete: Vec<_> =
        motions.iter().filter(|motion| motion.start.is_some() && motion.end.is_some()).collect();
    assert!(complete.len() >= 4489, "{}", complete.len());
    for motion in complete.iter().filter(|motion| motion.kind == MotionKind::Linear) {
        assert_eq!(motion.feed.mode, Some(FeedMode::InverseTime), "line {}", motion.line);
        assert!(motion.feed.word_in_block && motion.feed.decimals == 0, "line {}", motion.line);
        assert_eq!(motion.decimals.linear, 3);
        assert_eq!(motion.unfollowable, None, "line {}", motion.line);
        // M428 is a code of one machine's builder, not a TCP switch.
        assert_eq!(motion.interpolation, Interpolation::Machine);
    }
    let least =
        complete.iter().filter_map(|motion| motion.end).map(|end| end.rotary_deg[1]).fold(0.0, f64::min);
    assert!(least < -390.0, "C is not unwound: {least}");
}

#[test]
fn the_impeller_is_left_alone_where_nobody_says_what_its_user_codes_switch() {
    let Some(folder) = shared_file("programs") else { return };
    let text = std::fs::read(folder.join("5axis/linuxcnc_impeller_xyzac_tcp_g93.ngc")).unwrap();
    let (motions, diagnostics) = follow(&text, &tables([RotaryLetter::A, RotaryLetter::C], false));
    assert_eq!(diagnostics.kept(), []);
    assert!(motions.len() >= 4491);
    // M428 stands in line 4.
    for motion in motions.iter().filter(|motion| motion.line > 4) {
        assert_eq!(motion.unfollowable, Some(Unfollowable::KinematicsSwitched), "line {}", motion.line);
    }
}

#[test]
fn the_printed_curve_is_followed_in_machine_coordinates() {
    let Some(folder) = shared_file("programs") else { return };
    let text = std::fs::read(folder.join("5axis/zhangty_simple_curve_bc_machine.gcode")).unwrap();
    let (motions, diagnostics) = follow(&text, &tables([RotaryLetter::B, RotaryLetter::C], false));
    assert_eq!(diagnostics.count(Severity::Refusal), 0);
    let cuts: Vec<_> = motions
        .iter()
        .filter(|motion| {
            motion.kind == MotionKind::Linear && motion.end.is_some() && motion.unfollowable.is_none()
        })
        .collect();
    let with_extruder = cuts.iter().filter(|motion| motion.extra.is_some()).count();
    assert_eq!(with_extruder, 41_494);
    assert!(
        cuts.iter().all(|motion| !motion.offset_changed && motion.interpolation == Interpolation::Machine)
    );
    let complete = motions.iter().filter(|motion| motion.start.is_some() && motion.end.is_some()).count();
    assert!(complete > 41_510, "{complete}");
}

#[test]
fn tool_centre_point_is_on_where_the_mori_program_says_so() {
    let Some(folder) = shared_file("programs") else { return };
    let text = std::fs::read(folder.join("5axis/nx_mori_nmv5000_bc_g43.4.txt")).unwrap();
    let (motions, diagnostics) = follow(&text, &tables([RotaryLetter::B, RotaryLetter::C], false));
    for diagnostic in diagnostics.kept() {
        println!("{diagnostic}");
    }
    assert_eq!(diagnostics.count(Severity::Refusal), 0);
    let tcp = motions.iter().filter(|motion| motion.interpolation == Interpolation::Tcp).count();
    assert!(tcp > 400, "{tcp}");
    let simultaneous: Vec<_> =
        motions.iter().filter(|motion| motion.line > 440 && motion.line < 700).collect();
    assert!(simultaneous.iter().any(|motion| motion.unfollowable.is_none() && motion.start.is_some()));
    assert!(motions.iter().all(|motion| (motion.mm_per_unit - 25.4).abs() < 1e-12));
}

#[test]
fn templates_and_control_flow_are_refused_with_their_lines() {
    let Some(folder) = shared_file("programs") else { return };
    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    for (name, line) in [
        ("other/gcws_macro7.nc", 4),
        ("5axis/linuxcnc_twp_circular_pocket.ngc", 1),
        ("corpus/gcode-rs/_libgcode_slot.ngc", 3),
        ("corpus/linuxcnc-interp/bad/nested.ngc", 3),
    ] {
        let text = std::fs::read(folder.join(name)).unwrap();
        let (_, diagnostics) = follow(&text, &machine);
        assert_eq!(diagnostics.refusals().next().map(|refusal| refusal.line), Some(line), "{name}");
    }
}

#[test]
fn readable_programs_are_not_refused() {
    let Some(folder) = shared_file("programs") else { return };
    let machine = tables([RotaryLetter::A, RotaryLetter::C], false);
    let mut refused = Vec::new();
    for (name, _, _) in COUNTS {
        if matches!(name, "other/gcws_macro7.nc" | "5axis/linuxcnc_twp_circular_pocket.ngc") {
            continue;
        }
        let (motions, diagnostics) = follow(&std::fs::read(folder.join(name)).unwrap(), &machine);
        let unfollowable = motions.iter().filter(|motion| motion.unfollowable.is_some()).count();
        println!("{name}: {} motions, {unfollowable} left alone", motions.len());
        refused.extend(diagnostics.refusals().map(|refusal| format!("{name}: {refusal}")));
    }
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}
