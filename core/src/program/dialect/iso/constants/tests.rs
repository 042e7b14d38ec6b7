//! Values of RS274/NGC and Fanuc programs, as stated in their manuals.

use std::fmt::Write as _;

use crate::program::{Batch, BlockKind, Constants, Dialect, ReadLimits, Reader, WordForm};

/// The program's blocks with the computed values.
fn evaluated(text: &str) -> Batch {
    let mut reader = Reader::new(Some(Dialect::Iso), ReadLimits::default());
    let mut batch = Batch::new();
    reader.feed(text.as_bytes());
    reader.finish();
    assert!(reader.next_batch(&mut batch).unwrap(), "{text}");
    Constants::new(Dialect::Iso).evaluate(&mut batch);
    batch
}

/// The words of the last line, with `None` if the value is not known.
fn last_words(text: &str) -> Vec<Option<f64>> {
    let batch = evaluated(text);
    assert!(batch.faults().is_empty(), "{text}: {:?}", batch.faults());
    let words = batch.words(batch.blocks().last().unwrap());
    words.iter().map(|word| (word.form != WordForm::Expression).then_some(word.value)).collect()
}

/// The value of `X…` in a program for RS274/NGC.
fn rs274(value: &str) -> Option<f64> {
    last_words(&format!("#<name>=0\nX{value}")).first().copied().flatten()
}

/// The value of `X…` if both readings agree.
fn either(value: &str) -> Option<f64> {
    last_words(&format!("X{value}")).first().copied().flatten()
}

/// Tolerance for results with a rounded argument.
const NEAR: f64 = 1e-12;

fn assert_near(found: Option<f64>, expected: f64, text: &str) {
    let found = found.unwrap_or(f64::NAN);
    assert!((found - expected).abs() <= NEAR, "{text}: {found}, {expected}");
}

#[test]
fn operators_bind_as_in_rs274() {
    for (text, value) in [
        ("[1+2*3]", 7.0),
        ("[10-4-3]", 3.0),
        ("[2*3**2]", 18.0),
        ("[2**3**2]", 64.0),
        ("[-2**2]", 4.0),
        ("[7 MOD 4 + 1]", 4.0),
        ("[-7 MOD 4]", 1.0),
        ("[8/4/2]", 1.0),
        ("[1+1 EQ 2]", 1.0),
        ("[1 LT 2 AND 3 GE 4]", 0.0),
        ("[1 NE 2 OR 0]", 1.0),
        ("[1 XOR 1]", 0.0),
        ("[2 AND 4]", 1.0),
        ("-[1+1]", -2.0),
        ("-+[3]", -3.0),
        ("[[1+2]*[3+4]]", 21.0),
    ] {
        assert_eq!(rs274(text), Some(value), "{text}");
    }
}

#[test]
fn functions_take_degrees() {
    for (text, value) in [
        ("ABS[-1.5]", 1.5),
        ("ACOS[0.5]", 60.0),
        ("ASIN[1]", 90.0),
        ("ATAN[1]/[-1]", 135.0),
        ("ATAN[-1]/[-1]", -135.0),
        ("COS[60]", 0.5),
        ("EXP[1]", std::f64::consts::E),
        ("FIX[2.8]", 2.0),
        ("FIX[-2.8]", -3.0),
        ("FUP[2.8]", 3.0),
        ("FUP[-2.8]", -2.0),
        ("ROUND[2.5]", 3.0),
        ("ROUND[-2.5]", -3.0),
        ("LN[10]", std::f64::consts::LN_10),
        ("SIN[30]", 0.5),
        ("SQRT[2]", std::f64::consts::SQRT_2),
        ("TAN[45]", 1.0),
        ("[25.00 - [0.0099 * sqrt[2]]]", 25.0 - 0.0099 * std::f64::consts::SQRT_2),
    ] {
        assert_near(rs274(text), value, text);
    }
}

#[test]
fn where_controls_differ_nothing_is_known() {
    for text in [
        "FIX[-2.8]",
        "FUP[-2.8]",
        "ROUND[2.5]",
        "ATAN[-1]/[1]",
        "[2 AND 4]",
        "[7.5 MOD 2]",
        "[1 EQ 1.00001]",
        "[1 AND 1 EQ 1]",
        "FIX[3-0.0000001]",
        "BIN[7]",
        "POW[2,3]",
        "#5021",
        "#<_x>",
        "#1",
        "#_ABSIO[1]",
    ] {
        assert_eq!(either(text), None, "{text}");
    }
    assert_eq!(either("FIX[2.8]"), Some(2.0));
    assert_eq!(either("[1 AND 1]"), Some(1.0));
}

#[test]
fn parameters_hold_what_was_assigned() {
    assert_eq!(last_words("#1=2\n#[#1+1]=5.5\nX#3"), [Some(5.5)]);
    assert_eq!(last_words("#1=3\n#3=7\nX##1"), [Some(7.0)]);
    assert_eq!(last_words("#<My Name>=1.5\nX-#<myname>"), [Some(-1.5)]);
    assert_eq!(last_words("#501 = 1 ( SELECT [ 1=G54 ] )\nP#501 X#510"), [Some(1.0), None]);
    assert_eq!(last_words("#atan[1]/[1]=3\nX#45"), [Some(3.0)]);
    // Fanuc needs no brackets around an assigned expression.
    assert_eq!(last_words("#1=10\n#2=#1*2+SQRT[16]-1\nX#2"), [Some(23.0)]);
}

#[test]
fn a_block_is_read_before_it_is_carried_out() {
    assert_eq!(last_words("#1=1\n#2=2\n#1=#2 #2=#1\nX#1Y#2"), [Some(2.0), Some(1.0)]);
    assert_eq!(last_words("#3=6\nX#3 #3=15\nX#3"), [Some(15.0)]);
    let batch = evaluated("#3=6\nX#3 #3=15\n");
    assert_eq!(batch.words(&batch.blocks()[1])[0].value, 6.0);
}

#[test]
fn conditions_and_skipped_blocks_make_unknown_what_they_set() {
    assert_eq!(last_words("#1=1\nIF[#1EQ1]THEN#2=7\nX#2"), [Some(7.0)]);
    assert_eq!(last_words("#1=1 #2=3\nIF [#1 NE 1] THEN #2=7\nX#2"), [Some(3.0)]);
    assert_eq!(last_words("#2=3\nIF[#1EQ1]THEN#2=7\nX#2"), [None]);
    assert_eq!(last_words("#2=3\n/#2=7\nX#2"), [None]);
    assert_eq!(last_words("#2=7\n/#2=7\nX#2"), [Some(7.0)]);
    assert_eq!(last_words("#2=7\n#[#5021]=1\nX#2"), [None]);
}

#[test]
fn calls_forget_what_they_can_reach() {
    let set = "#1=1 #100=2 #<a>=3 #<_mine>=4\n";
    let read = "\nX#1Y#100Z#<a>A#<_mine>";
    let behind = |call: &str| last_words(&format!("{set}{call}{read}"));
    assert_eq!(behind("G0"), [Some(1.0), Some(2.0), Some(3.0), Some(4.0)]);
    assert_eq!(behind("o<sub> call [1]"), [Some(1.0), None, Some(3.0), None]);
    assert_eq!(behind("G65 P9000"), [Some(1.0), None, None, None]);
    assert_eq!(behind("G66 P9000"), [Some(1.0), None, None, None]);
    assert_eq!(behind("M98 P1000"), [None; 4]);
    assert_eq!(behind("G#2"), [None; 4]);
}

#[test]
fn what_exists_is_told_where_it_can_be() {
    assert_eq!(
        last_words(
            "#<a>=999\nG0 X EXISTS[#1] Y EXISTS[#99999] Z EXISTS[#<a>] A EXISTS[#<b>] B EXISTS[#<_c>]"
        ),
        [Some(0.0), Some(1.0), Some(0.0), Some(1.0), Some(0.0), None]
    );
    assert_eq!(
        last_words("#1=2\n#2=99999\nG0 X EXISTS[##1] Y EXISTS[##2] Z EXISTS[###1]"),
        [Some(0.0), Some(1.0), Some(0.0), Some(0.0)]
    );
}

#[test]
fn mistakes_are_told_by_line_and_column() {
    for (text, line, column, kind) in [
        ("G0\nX[1/0]", 2, 3, "undefined_value"),
        ("#1=0\nX[5 MOD #1]", 2, 3, "undefined_value"),
        ("X SQRT[-1]", 1, 3, "undefined_value"),
        ("X ACOS[1.5]", 1, 3, "undefined_value"),
        ("X FOO[1]", 1, 3, "unknown_function"),
        ("X EXISTS[1]", 1, 10, "unexpected_text"),
        ("X EXISTS[#1+#2]", 1, 12, "unexpected_text"),
        ("X EXISTS[#<foo]", 1, 11, "unclosed"),
        ("X EXISTS[#<foo>+1]", 1, 16, "unexpected_text"),
        ("#2=99999\nX EXISTS[###2]", 2, 3, "undefined_value"),
        ("X[1 2]", 1, 5, "unexpected_text"),
        ("X[1+]", 1, 5, "unexpected_text"),
        ("#1=[EXP[800]]", 1, 5, "undefined_value"),
        ("#1=1000000\nX[#1*#1]", 2, 1, "too_large"),
    ] {
        let batch = evaluated(text);
        let [fault] = batch.faults() else { panic!("{text}: {:?}", batch.faults()) };
        assert_eq!((fault.line, fault.column, fault.code.name()), (line, column, kind), "{text}");
        assert_eq!(batch.blocks().last().unwrap().kind, BlockKind::Malformed, "{text}");
    }
    for (opening, closing) in [("[", "]"), ("#", ""), ("SIN[", "]"), ("EXISTS[##", "]"), ("#[", "]")] {
        let deep = format!("X{}1{}", opening.repeat(2000), closing.repeat(2000));
        assert_eq!(evaluated(&deep).faults()[0].code.name(), "too_deep", "{opening}");
    }
}

#[test]
fn faults_stay_in_the_order_of_the_lines() {
    let batch = evaluated("X[1/0]\nX..\nY SQRT[-4]\n");
    let lines: Vec<_> = batch.faults().iter().map(|fault| fault.line).collect();
    assert_eq!(lines, [1, 2, 3]);
}

#[test]
fn what_is_kept_is_bounded() {
    let mut text = String::new();
    for index in 0..1500 {
        writeln!(text, "#<n{index}>={index}").unwrap();
    }
    text.push_str("X#<n10>Y#<n1400>");
    let mut reader = Reader::new(Some(Dialect::Iso), ReadLimits::default());
    let (mut batch, mut constants) = (Batch::new(), Constants::new(Dialect::Iso));
    reader.feed(text.as_bytes());
    reader.finish();
    while reader.next_batch(&mut batch).unwrap() {
        constants.evaluate(&mut batch);
    }
    let words = batch.words(batch.blocks().last().unwrap());
    assert_eq!(words[0].value, 10.0);
    assert_eq!(words[1].form, WordForm::Expression);
}
