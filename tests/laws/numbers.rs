//! Numbers as programs of home-made posts spell them: with exponents, and with two signs.

use proptest::prelude::*;
use trunnion::program::{
    Address, Batch, BlockKind, Constants, Diagnostic, DiagnosticCode, Dialect, ReadLimits, Reader, Word,
};

/// The words of the text, expressions evaluated, and what is refused of it.
fn read(text: &str, dialect: Dialect) -> (Vec<Word>, Vec<Diagnostic>) {
    let mut reader = Reader::new(Some(dialect), ReadLimits::default());
    reader.feed(text.as_bytes());
    reader.finish();
    let (mut batch, mut constants) = (Batch::new(), Constants::new(dialect));
    let (mut words, mut faults) = (Vec::new(), Vec::new());
    while reader.next_batch(&mut batch).expect("short lines") {
        constants.evaluate(&mut batch);
        for block in batch.blocks().iter().filter(|block| block.kind != BlockKind::Malformed) {
            words.extend_from_slice(batch.words(block));
        }
        faults.extend_from_slice(batch.faults());
    }
    (words, faults)
}

fn value(words: &[Word], address: Address) -> Option<f64> {
    words.iter().rev().find(|word| word.address == address && word.is_known()).map(|word| word.value)
}

/// The excerpt of the exponent that the second line is refused for, if it is refused for one and nothing else is.
fn refused_exponent(text: &str, dialect: Dialect) -> Option<String> {
    let (words, faults) = read(&format!("G21 G90\n{text}\nG0 Y7\n"), dialect);
    assert_eq!(value(&words, Address::Y), Some(7.0), "the line after {text} is read");
    match faults[..] {
        [Diagnostic { code: DiagnosticCode::Exponent { text: excerpt }, line: 2, .. }] => {
            assert_eq!(value(&words, Address::X), None, "{text}: no word is left of the line");
            Some(excerpt.to_string())
        }
        _ => None,
    }
}

#[test]
fn an_exponent_directly_after_a_number_of_an_iso_program_refuses_its_line() {
    for (text, excerpt) in [
        ("G0 X6.123233995736766e-17", "X6.123233995736766e-17"),
        ("G0 X-6.12E-17 Z5", "X-6.12E-17 Z5"),
        ("G0 X1.5e+2", "X1.5e+2"),
        ("G1X10E5", "X10E5"),
        ("X5.E3", "X5.E3"),
        ("X1.5E 05", "X1.5E 05"),
        ("G1 X1 F1e3", "F1e3"),
        ("#1 = 6.12E-17", "6.12E-17"),
        ("G1 X1 ,R2E-1", "R2E-1"),
    ] {
        assert_eq!(refused_exponent(text, Dialect::Iso).as_deref(), Some(excerpt), "{text}");
    }
    let (_, faults) = read("G0 X6.12e-17\n", Dialect::Iso);
    let said = faults.first().map(ToString::to_string).unwrap_or_default();
    assert!(said.starts_with("line 1, column 4: `X6.12e-17`"), "{said}");
    assert!(said.contains("write the number without an exponent"), "{said}");
    // In brackets it is refused as what cannot stand there.
    assert_eq!(read("X[1.5E-3]\n", Dialect::Iso).1.len(), 1);
}

#[test]
fn a_word_e_stands_after_a_blank_or_has_a_decimal_point() {
    for (text, x, e) in [
        ("G1 X10.5 E3", 10.5, 3.0),
        ("G1 X10.5 E-3", 10.5, -3.0),
        ("G1X10.5E3.2F100", 10.5, 3.2),
        ("G1X10E.8", 10.0, 0.8),
        ("G1X10E-0.8", 10.0, -0.8),
        ("G1 E5 X1", 1.0, 5.0),
        ("G1 X10.5(A)E3", 10.5, 3.0),
    ] {
        let (words, faults) = read(&format!("{text}\n"), Dialect::Iso);
        assert_eq!(faults, [], "{text}");
        assert_eq!(
            [Address::X, Address::E].map(|address| value(&words, address)),
            [Some(x), Some(e)],
            "{text}"
        );
    }
}

#[test]
fn sinumerik_exponents_are_written_ex_and_every_other_one_refuses_its_line() {
    for (text, excerpt) in [
        ("G0 X6.12e-17", "X6.12e-17"),
        ("G0 X10E5", "X10E5"),
        ("G0 X10.5E3.2", "X10.5E3.2"),
        ("G0 X=6.12E-17", "6.12E-17"),
        ("G0 X=AC(6.12E-17)", "6.12E-17)"),
        ("G0 X=1+2*6.12E-17", "6.12E-17"),
        ("R1=6.12E-17", "6.12E-17"),
        ("_ZERO=6.12E-17", "6.12E-17"),
    ] {
        assert_eq!(refused_exponent(text, Dialect::Siemens).as_deref(), Some(excerpt), "{text}");
    }
    for (text, x) in [
        ("X1.5EX2", 150.0),
        ("X-1.5EX-1", -0.15),
        ("X1.5ex+1", 15.0),
        ("X=1.5EX-1", 0.15),
        ("X=IC(2EX1)", 20.0),
        ("R1=1.5EX-1\nX=R1", 0.15),
        ("DEF REAL _A=1.5EX1\nX=_A", 15.0),
    ] {
        let (words, faults) = read(&format!("{text}\n"), Dialect::Siemens);
        assert_eq!((faults, value(&words, Address::X)), (Vec::new(), Some(x)), "{text}");
    }
    // What a declaration cannot read is not known.
    let (words, _) = read("DEF REAL _A=6.12E-17\nX=_A\n", Dialect::Siemens);
    assert_eq!(value(&words, Address::X), None);
}

#[test]
fn tables_and_cutter_location_data_have_exponents() {
    for (cell, x) in [("6.12e-17", 6.12e-17), ("1.5E+2", 150.0), ("-1e-3", -0.001)] {
        let (words, faults) = read(&format!("x,y,z,a,c\n{cell},0,0,0,0\n"), Dialect::Csv);
        assert_eq!((faults, value(&words, Address::X)), (Vec::new(), Some(x)), "{cell}");
        let (words, faults) = read(&format!("GOTO/{cell},0,0\n"), Dialect::Apt);
        assert_eq!((faults, value(&words, Address::X)), (Vec::new(), Some(x)), "{cell}");
    }
    for (text, dialect) in [
        ("x,y,z,a,c\n1.5E,0,0,0,0\n", Dialect::Csv),
        ("GOTO/1.5E,0,0\n", Dialect::Apt),
        ("L X+6.12E-17 R0 F100\n", Dialect::Heidenhain),
    ] {
        let (words, faults) = read(text, dialect);
        assert_eq!((faults.len(), value(&words, Address::X)), (1, None), "{text}");
    }
}

#[test]
fn a_number_has_one_sign() {
    for text in ["X--5", "X - - 5", "X+-5", "X-+5", "X++5", "#1=--5", "X1 ,R--2"] {
        let (words, faults) = read(&format!("{text}\n"), Dialect::Iso);
        assert_eq!((faults.len(), words.len()), (1, 0), "{text}: {words:?}");
    }
    for (text, x) in [("X-5", -5.0), ("X - 5", -5.0), ("X+5", 5.0), ("#1=5\nX-#1", -5.0), ("X-+[5]", -5.0)] {
        let (words, faults) = read(&format!("{text}\n"), Dialect::Iso);
        assert_eq!((faults, value(&words, Address::X)), (Vec::new(), Some(x)), "{text}");
    }
}

proptest! {
    #[test]
    fn no_number_is_cut_off_at_its_exponent(
        mantissa in -9.999_f64..9.999, exponent in -320_i32..9, capital: bool, sinumerik: bool, equals: bool,
    ) {
        let number = format!("{:e}", mantissa * 10_f64.powi(exponent));
        let number = if capital { number.to_uppercase() } else { number };
        let (dialect, mark) = if sinumerik { (Dialect::Siemens, if equals { "=" } else { "" }) } else { (Dialect::Iso, "") };
        let (words, faults) = read(&format!("G1 X{mark}{number} F100\n"), dialect);
        prop_assert_eq!(faults.len(), 1);
        prop_assert!(words.is_empty(), "{} {:?}", number, words);
    }
}

#[test]
fn brackets_that_are_closed_but_too_deep_are_named_as_such() {
    for (dialect, open, close, depth, bound) in
        [(Dialect::Siemens, "(", ")", 45, "more than 40"), (Dialect::Iso, "[", "]", 40, "more than 32")]
    {
        let equals = if dialect == Dialect::Siemens { "=" } else { "" };
        let text = format!("G21 G90\nG1 X{equals}{}1{}\n", open.repeat(depth), close.repeat(depth));
        let (_, faults) = read(&text, dialect);
        assert!(faults.iter().any(|fault| fault.to_string().contains(bound)), "{text} {faults:?}");
    }
}
