//! Laws of reading, printing and writing programs.

#![expect(clippy::unwrap_used, clippy::float_cmp, reason = "tests; values that have to be equal to the bit")]

use proptest::prelude::*;
use trunnion::program::{
    Address, Batch, BlockKind, Dialect, NewWord, ReadFault, ReadLimits, Reader, WordForm, print_changed,
    print_changed_without, print_decimal, print_feed_only, print_inserted, round_to_decimals,
};

fn read_chunks(chunks: &[&[u8]], dialect: Option<Dialect>) -> Result<Vec<Batch>, ReadFault> {
    let mut reader = Reader::new(dialect, ReadLimits { batch_blocks: 7, ..ReadLimits::default() });
    let (mut batches, mut batch) = (Vec::new(), Batch::new());
    for chunk in chunks {
        reader.feed(chunk);
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

fn text_of(batches: &[Batch]) -> Vec<u8> {
    let block_texts = |batch: &Batch| -> Vec<u8> {
        batch.blocks().iter().flat_map(|block| batch.block_text(block).to_vec()).collect()
    };
    batches.iter().flat_map(block_texts).collect()
}

/// Pieces of which programs are made, good and bad.
fn program_text() -> impl Strategy<Value = Vec<u8>> {
    let piece = prop::sample::select(vec![
        &b"G1"[..],
        b" ",
        b"X1.5",
        b"Y-.25",
        b"z +3.",
        b"A  12.345",
        b"C-720",
        b"\n",
        b"\r\n",
        b"\r",
        b"\n",
        b"\n",
        b"(note)",
        b"(open",
        b";rest",
        b"%",
        b"/",
        b"N10",
        b"O1001",
        b"o<a> call",
        b"#501 = 1",
        b"X[#<a>*2]",
        b"X#510",
        b",R2",
        b"F100",
        b"M30",
        b"{BEGIN}",
        b"\xe9",
        b"X",
        b"1.2.3",
        b"E",
        b"[",
        b"\t",
        b"G43.4",
        b"X99999999999",
        b"X,Y,Z,A,C\n",
        b"1,2,3,4,5",
        b"IF [#1 EQ 2] GOTO 5",
        b"\0",
    ]);
    prop::collection::vec(piece, 0..60).prop_map(|pieces| pieces.concat())
}

proptest! {
    #[test]
    fn printing_what_was_read_gives_the_same_bytes(text in program_text()) {
        for dialect in [None, Some(Dialect::Iso)] {
            if let Ok(batches) = read_chunks(&[&text], dialect) {
                prop_assert_eq!(text_of(&batches), text.clone());
            }
        }
    }

    #[test]
    fn any_bytes_are_read_without_loss_and_without_panic(text in prop::collection::vec(any::<u8>(), 0..300)) {
        let batches = read_chunks(&[&text], Some(Dialect::Iso)).unwrap();
        prop_assert_eq!(text_of(&batches), text);
    }

    #[test]
    fn any_chunking_gives_the_same_blocks(text in program_text(), cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..12)) {
        let mut cuts: Vec<_> = cuts.iter().map(|cut| cut.index(text.len() + 1)).collect();
        cuts.sort_unstable();
        let mut chunks = Vec::new();
        let mut from = 0;
        for cut in cuts.into_iter().chain([text.len()]) {
            chunks.push(&text[from..cut]);
            from = cut;
        }
        prop_assert_eq!(read_chunks(&chunks, None), read_chunks(&[&text], None));
        let bytes: Vec<_> = text.chunks(1).collect();
        prop_assert_eq!(read_chunks(&bytes, None), read_chunks(&[&text], None));
    }

    #[test]
    fn a_number_is_read_as_the_nearest_double(whole in 0_u64..1_000_000_000, fraction in "[0-9]{0,25}", negative: bool) {
        let sign = if negative { "-" } else { "" };
        let text = format!("X{sign}{whole}.{fraction}\n");
        let batches = read_chunks(&[text.as_bytes()], Some(Dialect::Iso)).unwrap();
        let expected: f64 = text[1..].trim().parse().unwrap();
        let word = batches[0].words(&batches[0].blocks()[0])[0];
        prop_assert_eq!(word.value, expected);
        prop_assert!(word.value != 0.0 || word.value.is_sign_positive());
        prop_assert_eq!(usize::from(word.decimals), fraction.len());
    }

    #[test]
    fn rounding_gives_what_reading_the_printed_text_gives(value in -1e9..1e9_f64, small in -1.0..1.0_f64, decimals in 0_u8..12) {
        for value in [value, small] {
            let mut text = b"X".to_vec();
            print_decimal(value, decimals, &mut text);
            prop_assert!(!text.starts_with(b"X-0.0000000000") || value < 0.0);
            let batches = read_chunks(&[&text], Some(Dialect::Iso)).unwrap();
            let read = batches[0].words(&batches[0].blocks()[0])[0].value;
            prop_assert_eq!(read.to_bits(), round_to_decimals(value, decimals).to_bits());
            prop_assert!((read - value).abs() <= 0.500_000_1 * 0.1_f64.powi(i32::from(decimals)) + value.abs() * 4e-16);
            // Where the decimals are coarser than the doubles.
            if value.abs() * 10_f64.powi(i32::from(decimals)) < 1e15 {
                prop_assert_eq!(round_to_decimals(read, decimals).to_bits(), read.to_bits());
            }
            let minus_zero = text[1] == b'-' && text[2..].iter().all(|byte| matches!(byte, b'0' | b'.'));
            prop_assert!(!minus_zero);
        }
    }

    #[test]
    fn a_changed_block_reads_as_its_new_words_and_keeps_the_others(
        style in 0..STYLES.len(),
        values in prop::array::uniform5(-999.0..999.0_f64),
        decimals in 0_u8..6,
        end_codes: bool,
    ) {
        let batches = read_chunks(&[STYLES[style].as_bytes()], Some(Dialect::Iso)).unwrap();
        let source = &batches[0];
        let words = [Address::X, Address::Y, Address::Z, Address::A, Address::C];
        let words: Vec<_> = words.iter().zip(values).map(|(&address, value)| NewWord { address, value, decimals }).collect();
        for index in 0..source.blocks().len() {
            let mut out = Vec::new();
            print_changed(source, index, &words, end_codes, &mut out).unwrap();
            let again = read_chunks(&[&out], Some(Dialect::Iso)).unwrap();
            prop_assert_eq!(again[0].blocks().len(), 1, "{:?}", String::from_utf8_lossy(&out));
            let block = &again[0].blocks()[0];
            prop_assert_eq!(block.kind, BlockKind::Words, "{:?}", String::from_utf8_lossy(&out));
            for new in &words {
                let found: Vec<_> = again[0].words(block).iter().filter(|word| word.address == new.address && word.form != WordForm::Comma).collect();
                prop_assert_eq!(found.len(), 1, "{:?}", String::from_utf8_lossy(&out));
                prop_assert_eq!(found[0].value.to_bits(), round_to_decimals(new.value, decimals).to_bits());
            }
            let others = |batch: &Batch, index: usize| -> Vec<(Address, f64)> {
                let is_other = |word: &&trunnion::program::Word| !words.iter().any(|new| new.address == word.address && word.form != WordForm::Comma);
                batch.words(&batch.blocks()[index]).iter().filter(is_other).map(|word| (word.address, word.value)).collect()
            };
            let mut kept = others(source, index);
            if end_codes {
                kept.retain(|&(address, value)| address != Address::M || ![9.0, 30.0].contains(&value));
            }
            prop_assert_eq!(kept, others(&again[0], 0));
        }
    }

    #[test]
    fn an_inserted_block_reads_as_its_words_alone(
        style in 0..STYLES.len(),
        values in prop::array::uniform5(-999.0..999.0_f64),
        decimals in 0_u8..6,
        end_codes: bool,
    ) {
        let batches = read_chunks(&[STYLES[style].as_bytes()], Some(Dialect::Iso)).unwrap();
        let source = &batches[0];
        let words = [Address::X, Address::Y, Address::Z, Address::A, Address::F];
        let words: Vec<_> = words.iter().zip(values).map(|(&address, value)| NewWord { address, value, decimals }).collect();
        for index in 0..source.blocks().len() {
            let mut out = b"G1".to_vec();
            print_inserted(source, index, &words, end_codes, &mut out).unwrap();
            let again = read_chunks(&[&out], Some(Dialect::Iso)).unwrap();
            prop_assert_eq!(again[0].blocks().len(), 2);
            let read = again[0].words(&again[0].blocks()[1]);
            for (word, new) in read.iter().zip(&words) {
                prop_assert_eq!(word.address, new.address);
                prop_assert_eq!(word.value.to_bits(), round_to_decimals(new.value, decimals).to_bits());
            }
            prop_assert!(read[words.len()..].iter().all(|word| end_codes && word.address == Address::M && word.value != 3.0));
        }
    }
}

/// Blocks as real posts set them.
const STYLES: [&str; 9] = [
    "G1  X   6.302  Y -11.560  Z  27.743  A -71.841  C -35.930  F 318\n",
    "N0120X-.9406Z3.8559B96.061\r\n",
    "G1 X1.465 Y-14.992 Z40.737 B0.000 C-0.000 E0.773\n",
    "n0230 g1 x+1.437 (note) m9 m3\n",
    " x33.059 y225.446",
    "Z.852\nX[#<a>*2] Y#510 M30\n",
    "N10 G0\nF100\nG1 X1 ,R2\n",
    "G1 X1. Y2. M9 M30 ; done\rX5.\r",
    "G2 X1 Y1 I.5 J0 F10000.\nM9\n",
];

#[test]
fn what_cannot_be_printed_is_refused_and_nothing_is_written() {
    let batches = read_chunks(&[b"G1 X1\n"], None).unwrap();
    let mut out = b"kept".to_vec();
    for value in [f64::NAN, f64::INFINITY, -f64::INFINITY, 2e9] {
        let word = NewWord { address: Address::X, value, decimals: 3 };
        assert!(print_changed(&batches[0], 0, &[word], false, &mut out).is_err());
        assert!(print_inserted(&batches[0], 0, &[word], false, &mut out).is_err());
        assert!(print_feed_only(&batches[0], 0, value, 0, &mut out).is_err());
    }
    assert!(print_changed(&batches[0], 1, &[], false, &mut out).is_err());
    assert_eq!(out, b"kept");
}

fn changed(text: &str, words: &[(Address, f64, u8)], without_end_codes: bool) -> String {
    let batches = read_chunks(&[text.as_bytes()], None).unwrap();
    let words: Vec<_> =
        words.iter().map(|&(address, value, decimals)| NewWord { address, value, decimals }).collect();
    let mut out = Vec::new();
    print_changed(&batches[0], batches[0].blocks().len() - 1, &words, without_end_codes, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn inserted(text: &str, words: &[(Address, f64, u8)], with_end_codes: bool) -> String {
    inserted_in(None, text, words, with_end_codes)
}

fn inserted_in(
    dialect: Option<Dialect>,
    text: &str,
    words: &[(Address, f64, u8)],
    with_end_codes: bool,
) -> String {
    let batches = read_chunks(&[text.as_bytes()], dialect).unwrap();
    let words: Vec<_> =
        words.iter().map(|&(address, value, decimals)| NewWord { address, value, decimals }).collect();
    let mut out = Vec::new();
    print_inserted(&batches[0], batches[0].blocks().len() - 1, &words, with_end_codes, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn blocks_keep_the_style_of_their_program() {
    let (x, y, z, a, b, f) = (Address::X, Address::Y, Address::Z, Address::A, Address::B, Address::F);
    let padded = "G1  X   6.302  Y -11.560  A -71.841  F 318\n";
    assert_eq!(
        changed(padded, &[(x, -6.5, 3), (y, 111.0, 3), (f, 1200.0, 0)], false),
        "G1  X  -6.500  Y 111.000  A -71.841  F 1200\n"
    );
    assert_eq!(inserted(padded, &[(x, 1.0, 3), (a, 0.0, 3)], false), "X   1.000  A   0.000\n");
    let tight = "N0120X-.9406Z3.8559B96.061\r\n";
    assert_eq!(changed(tight, &[(x, 0.5, 4), (y, 2.0, 0)], false), "N0120X.5000Z3.8559B96.061Y2.\r\n");
    assert_eq!(inserted(tight, &[(x, 0.25, 2), (b, -96.0, 0)], false), "X.25B-96.\r\n");
    assert_eq!(inserted(tight, &[(Address::N, 121.0, 0), (x, 0.25, 2)], false), "N0121X.25\r\n");
    let lower = "n10 g1 x+1.5 y-2.0 m9 (end)";
    assert_eq!(changed(lower, &[(x, 2.0, 1), (z, 3.0, 1)], true), "n10 g1 x+2.0 y-2.0 z3.0 (end)\n");
    assert_eq!(inserted(lower, &[(x, 2.0, 1)], true), "x+2.0 m9\n");
    assert_eq!(inserted(lower, &[(Address::N, 11.0, 0), (x, 2.0, 1)], false), "n11 x+2.0\n");
    assert_eq!(changed("X1.\nF100", &[(f, 50.0, 0)], false), "F50");
    for (exact_stop, first, last) in [
        ("G09 G1 X1. Y2. F100", "G1 X2. Y2. F100\n", "X3. G09\n"),
        ("  g9 x1.0 m9", "  x2.0\n", "  x3.0 g9 m9\n"),
        ("N5 G1 G9 X1.0", "N5 G1 X2.0\n", "X3.0 G9\n"),
        ("G09G01X1.", "G01X2.\n", "X3.G09\n"),
    ] {
        let decimals = u8::from(exact_stop.contains("1.0"));
        assert_eq!(changed(exact_stop, &[(x, 2.0, decimals)], true), first);
        assert_eq!(inserted(exact_stop, &[(x, 3.0, decimals)], true), last);
    }
    assert_eq!(changed("G09 X1.", &[(x, 2.0, 0)], false), "G09 X2.");
    assert_eq!(changed("G90 G1 X1.", &[(x, 2.0, 0)], true), "G90 G1 X2.\n");
}

/// The last block of a program of this dialect with these words in place of its own.
fn changed_in(dialect: Dialect, text: &str, words: &[(Address, f64, u8)], dropped: &[Address]) -> String {
    let batches = read_chunks(&[text.as_bytes()], Some(dialect)).unwrap();
    let words: Vec<_> =
        words.iter().map(|&(address, value, decimals)| NewWord { address, value, decimals }).collect();
    let mut out = Vec::new();
    let last = batches[0].blocks().len() - 1;
    print_changed_without(&batches[0], last, &words, dropped, false, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn vectors_of_conversational_programs_have_their_names() {
    let all = [(Address::TI, 0.0, 1), (Address::TJ, 0.6, 1), (Address::TK, 0.8, 1)];
    let block = "LN X+1.0 Y+2.0 Z+3.0 NX+0.0 NY+0.0 NZ+1.0\n";
    let program = format!("BEGIN PGM A MM\n{block}");
    let out = changed_in(Dialect::Heidenhain, &program, &all, &[]);
    assert_eq!(out, "LN X+1.0 Y+2.0 Z+3.0 NX+0.0 NY+0.0 NZ+1.0 TX+0.0 TY+0.6 TZ+0.8\n");
}

#[test]
fn new_words_stand_as_those_of_their_program() {
    let (x, y, z) = (Address::X, Address::Y, Address::Z);
    let all = [(x, 5.0, 1), (y, 6.0, 1), (z, 7.0, 1)];
    for block in ["G1 X1.0   Y2.0  Z3.0\n", "X1.0   Y2.0  Z3.0\n"] {
        assert_eq!(inserted(block, &all, false), "X5.0   Y6.0  Z7.0\n");
    }
    for (program, expected) in
        [("M8\n", "X5.0 Y6.0 M8\n"), ("G1 X1.0\nN10\n", "N10 X5.0 Y6.0\n"), ("G1 X1.0\n\n", "X5.0 Y6.0\n")]
    {
        assert_eq!(changed(program, &all[..2], false), expected);
    }
    // A program that writes plus signs goes on to, also behind words without one.
    for (first, last) in [("L X+1.0 Y+2.0", "L X-1.0 Y-2.0 Z+7.0\n"), ("L X1.0 Y2.0", "L X-1.0 Y-2.0 Z7.0\n")]
    {
        let program = format!("BEGIN PGM A MM\n{first}\nL X-1.0 Y-2.0\n");
        assert_eq!(changed_in(Dialect::Heidenhain, &program, &all[2..], &[]), last);
    }
    // So do its new blocks, where the source block has minus signs.
    let program = "BEGIN PGM A MM\nL X+1.0 Y+2.0\nL X-1.0 Y-2.0\n";
    assert_eq!(inserted_in(Some(Dialect::Heidenhain), program, &all[..2], false), "L X+5.0 Y+6.0\n");
}

#[test]
fn cutter_locations_keep_their_statements() {
    let (x, y, z, f) = (Address::X, Address::Y, Address::Z, Address::F);
    let (i, j, k) = (Address::TI, Address::TJ, Address::TK);
    let point = [(x, 7.0, 1), (y, 8.0, 1), (z, 9.0, 1)];
    let with_axis = [&point[..], &[(i, 0.0, 1), (j, 0.6, 1), (k, 0.8, 1)]].concat();
    for (program, words, expected) in [
        ("GOTO/1.0,2.0,3.0\n", &point[..], "GOTO/7.0,8.0,9.0\n"),
        ("GOTO/1.0,2.0,3.0\n", &with_axis[..], "GOTO/7.0,8.0,9.0,0.0,0.6,0.8\n"),
        (
            "MULTAX\nGOTO / 1.0, 2.0, 3.0, 0.0, 0.0, 1.0\n",
            &with_axis[..],
            "GOTO / 7.0, 8.0, 9.0, 0.0, 0.6, 0.8\n",
        ),
        // Only the numbers change; the blanks between them stay.
        ("MULTAX\nGOTO/1.0, 2.0,3.0 ,0.0,  0.0,1.0\n", &point[..], "GOTO/7.0, 8.0,9.0 ,0.0,  0.0,1.0\n"),
        (
            "FEDRAT/MMPM,100.0\n  GOTO/1.0,2.0,3.0\n",
            &[(f, 250.0, 1)],
            "  FEDRAT/MMPM,250.0\n  GOTO/1.0,2.0,3.0\n",
        ),
        (
            "FEDRAT/ 100.0, MMPM\n  GOTO/1.0,2.0,3.0\n",
            &[(f, 250.0, 1), (x, 4.0, 1)],
            "  FEDRAT/ 250.0, MMPM\n  GOTO/4.0,2.0,3.0\n",
        ),
        ("FEDRAT/100.0\nGOTO/1.0,2.0,3.0\r\n", &[(f, 250.0, 1)], "FEDRAT/250.0\r\nGOTO/1.0,2.0,3.0\r\n"),
        (
            "FEDRAT/100.0,IPM\nFEDRAT/10.0,IPR\nGOTO/1.0,2.0,3.0\n",
            &[(f, 2.5, 1)],
            "FEDRAT/2.5,IPR\nGOTO/1.0,2.0,3.0\n",
        ),
    ] {
        assert_eq!(changed_in(Dialect::Apt, program, words, &[]), expected);
    }
    // The feed before a point counts, not one behind it.
    let program = b"FEDRAT/IPM,9.0\nGOTO/1.0,2.0,3.0\nFEDRAT/ 0.1, IPR\nGOTO/1.0,2.0,4.0\n";
    let batches = read_chunks(&[program], Some(Dialect::Apt)).unwrap();
    let mut out = Vec::new();
    let feed = NewWord { address: f, value: 5.0, decimals: 1 };
    print_changed(&batches[0], 1, &[feed], false, &mut out).unwrap();
    assert_eq!(String::from_utf8(out).unwrap(), "FEDRAT/IPM,5.0\nGOTO/1.0,2.0,3.0\n");
    // A point whose axis goes is a point of three numbers.
    let goes = [Address::TI, Address::TJ, Address::TK];
    let out = changed_in(Dialect::Apt, "GOTO/1.0,2.0,3.0,0.0,0.0,1.0\n", &point, &goes);
    assert_eq!(out, "GOTO/7.0,8.0,9.0\n");
}

#[test]
fn an_incremental_word_becomes_one_of_its_axis() {
    let program = "BEGIN PGM A MM\nL IX+1.0 Y+2.0 F100\n";
    let out = changed_in(Dialect::Heidenhain, program, &[(Address::X, 7.5, 1)], &[]);
    assert_eq!(out, "L X+7.5 Y+2.0 F100\n");
}

#[test]
fn rows_of_a_table_keep_their_columns() {
    let table = "X; Y ;z;A;C;F\n1;2;3;4;5;600\n 1.5; 2.5;3.5;4;5;\n";
    let batches = read_chunks(&[table.as_bytes()], None).unwrap();
    assert_eq!(batches[0].dialect(), Dialect::Csv);
    assert_eq!(batches[0].words(&batches[0].blocks()[2]).len(), 5);
    assert_eq!(
        changed(table, &[(Address::Y, -0.25, 3), (Address::F, 30.0, 0)], false),
        " 1.5; -0.250;3.5;4;5;30\n"
    );
    assert_eq!(inserted(table, &[(Address::X, 9.0, 1)], true), " 9.0; 2.5;3.5;4;5;\n");
    // Rows with more or fewer cells than columns.
    for row in ["1;2;3;4;5;600;;\n", "1;2;3\n"] {
        let table = format!("X;Y;Z;A;C;F\n{row}");
        assert_eq!(changed(&table, &[], false), row);
    }
}

/// Found by fuzzing: a faulty feed statement kept a word, and had those of the statement behind it.
#[test]
fn a_statement_that_cannot_be_read_has_no_words() {
    let text = "FEDRAT\u{15}6423.8,MMPM\nRAPID/\nGOTO/1,2,3\n";
    let batches = read_chunks(&[text.as_bytes()], Some(Dialect::Apt)).unwrap();
    let batch = &batches[0];
    for block in batch.blocks() {
        let words = batch.words(block);
        assert!(
            words.iter().all(|word| word.start >= block.start && word.end <= block.body_end),
            "{words:?}"
        );
        assert_eq!(words.is_empty(), block.kind == trunnion::program::BlockKind::Malformed, "{block:?}");
    }
    assert_eq!(batch.blocks().len(), 3);
}
