//! Values of Sinumerik words: numbers, expressions, functions and variables. Every number was computed by hand.

use super::super::{EXACT_MM, assert_ends, linear, read, run};
use crate::motion::Unfollowable;
use crate::program::{Address, WordForm};

/// The X that a value gives; `None` if it is not known.
fn x_of(before: &str, value: &str) -> Option<f64> {
    run(&format!("{before}\nG1 X={value} F100\n")).last().and_then(linear).map(|end| end[0])
}

#[track_caller]
fn assert_x(before: &str, value: &str, expected: f64) {
    let x = x_of(before, value);
    assert!(
        x.is_some_and(|x| (x - expected).abs() <= EXACT_MM * expected.abs().max(1.0)),
        "{value}: {x:?}, not {expected}"
    );
}

fn words(text: &str) -> Vec<(Address, WordForm, f64, u8)> {
    let batches = read(text);
    let batch = &batches[0];
    batch
        .words(&batch.blocks()[0])
        .iter()
        .map(|word| (word.address, word.form, word.value, word.lead))
        .collect()
}

#[test]
fn words_are_read_in_every_form() {
    use WordForm::{Absolute, Evaluated, Expression, Incremental, Name, Number};
    let expected = [
        (Address::N, Number, 10.0, 1),
        (Address::G, Number, 1.0, 1),
        (Address::X, Number, -10.5, 2),
        (Address::Y, Number, 3.0, 3),
        (Address::Z, Number, 0.5, 1),
        (Address::R, Number, 12.5, 3),
        (Address::F, Expression, 0.0, 2),
        (Address::T, Name, 0.0, 2),
    ];
    assert_eq!(words("N10 G1 X=-10.5 Y = 3 Z.5 CR=12.5 F=R1 T=\"MILL;D12\" ; X99"), expected);
    let expected = [
        (Address::X, Incremental, -2.5, 2),
        (Address::Y, Absolute, 4.0, 2),
        (Address::Z, Evaluated, 14.0, 2),
        (Address::C, Expression, 0.0, 2),
        (Address::TI, Number, 0.6, 3),
        (Address::TJ, Number, 0.0, 3),
        (Address::TK, Number, 0.8, 3),
    ];
    assert_eq!(words("X=IC(-2.5) Y=AC(4) Z=2+3*4 C=DC(90) A3=.6 B3=0 C3=0.8"), expected);
    let expected = [
        (Address::G, Number, 10.0, 2),
        (Address::G, Expression, 0.0, 1),
        (Address::M, Number, 10.0, 2),
        (Address::M, Number, 8.0, 3),
    ];
    assert_eq!(words("G=10 G[0]=1 M=QU(10) M0=8 M2=3 M[2]=4 S1=500 H10=2"), expected);
    let compact: Vec<_> = words("N10G0G54X-10Y.20Z30.4EX-4B0T100S400.0M3H12");
    let values: Vec<_> = compact.iter().map(|word| word.2).collect();
    assert_eq!(values, [10.0, 0.0, 54.0, -10.0, 0.2, 0.00304, 0.0, 100.0, 400.0, 3.0, 12.0]);
}

#[test]
fn values_count_from_zero_or_from_the_place_before() {
    assert_ends(
        "G1 X=10.5 Y=2*3 Z=-(4+1) F1000\nX=IC(2) Y=AC(7) Z=IC(-1/2)\nG91 X1 Y=AC(0) Z=IC(1)\nG90 X=IC(1) X\n",
        &[[10.5, 6.0, -5.0], [12.5, 7.0, -5.5], [13.5, 0.0, -4.5]],
    );
    // Degrees. The place of a rotary axis modulo 360 depends on its position.
    let motions = run("G1 C=AC(30) F100\nC=IC(400)\nC=DC(10)\n");
    let c: Vec<_> = motions.iter().map(|motion| motion.end.map(|end| end.rotary_deg[1])).collect();
    assert_eq!(c, [Some(30.0), Some(430.0), None]);
    assert_eq!(motions[2].unfollowable, Some(Unfollowable::Expression { address: Address::C }));
}

#[test]
fn operators_have_the_priorities_of_the_manual() {
    for (value, expected) in [
        ("2+3*4", 14.0),
        ("10-6/2", 7.0),
        ("2+6 DIV 4", 3.0),
        ("1+7 MOD 4", 4.0),
        ("(2+3)*4", 20.0),
        ("-2+3", 1.0),
        ("2*-3", -6.0),
        ("1+1-1+-1", 0.0),
        ("7 MOD 4.1", 2.9),
        ("7 DIV 4.1", 1.0),
        ("7 DIV 0.4", 17.0),
        ("7/2", 3.5),
        ("2EX2+1", 201.0),
        ("'HFF'-'B101'", 250.0),
        // B_AND binds tighter than B_XOR, and B_XOR tighter than B_OR: 12 | (10 ^ (6 & 3)) = 12 | 8.
        ("12 B_OR 10 B_XOR 6 B_AND 3", 12.0),
        // 1 + 2 is compared, because comparisons bind weakest.
        ("1+2==3", 1.0),
        // (NOT 1 OR (TRUE AND 4)) <> 4.
        ("NOT (3>2) OR TRUE AND 4<>4", 1.0),
    ] {
        assert_x("", value, expected);
    }
    // A value that is rounded, overflows or is not described in the manuals is not known.
    for value in ["-7 DIV 2", "7 MOD 0", "1/0", "0.3 DIV 0.1", "0.1+0.2==0.3", "1EX300*1EX300", "SQRT(-1)"] {
        assert_eq!(x_of("", value), None, "{value}");
    }
}

#[test]
fn functions_have_the_values_of_the_manual() {
    let degrees = 30.5_f64.atan2(80.1).to_degrees();
    for (value, expected) in [
        ("SIN(30)", 0.5),
        ("cos(60)", 0.5),
        ("TAN(45)", 1.0),
        ("ASIN(0.5)", 30.0),
        ("ACOS(0.5)", 60.0),
        ("ATAN2(30.5, 80.1)", degrees),
        ("SQRT(POT(3)+POT(4))", 5.0),
        ("ABS(-2.5)", 2.5),
        ("ROUND(2.5)", 3.0),
        ("ROUND(-2.4)", -2.0),
        ("TRUNC(-2.7)", -2.0),
        ("ROUNDUP(2.1)", 3.0),
        ("LN(EXP(2))", 2.0),
        ("MINVAL(3,-1)+MAXVAL(3,-1)", 2.0),
        ("BOUND(0,10,12)", 10.0),
    ] {
        assert_x("", value, expected);
    }
    assert_eq!(x_of("", "NOSUCH(3)"), None);
}

#[test]
fn variables_hold_what_the_program_gives_them() {
    assert_x("R1=5 R2=2*3\nR3=R1*R2", "R3+r1", 35.0);
    assert_x("R[7]=4\nR8=R7+$R7", "R[8]", 8.0);
    assert_x("DEF REAL lAYER\nLAYER = 2.5", "Layer*2", 5.0);
    assert_x("DEF REAL A_B=1.5, C_D\nC_D=A_B*2", "A_B+C_D", 4.5);
    // INT is rounded when it is assigned. A variable without a value is zero.
    assert_x("DEF INT NN=9, MM\nNN=NN/2", "NN+MM", 5.0);
    assert_x("DEF INT F[2,3]=SET(1,2,3,4,5,6)", "F[1,0]*10+F[0,2]", 43.0);
    assert_x("DEF REAL G_[4]=(0.6,0.7,0.5,0.7)", "G_[1]", 0.7);
    assert_x(
        "DEF REAL H_[2,2]=REP(3)\nH_[1,0]=8\nH_[0,0]=SET(1,,5)",
        "H_[0,0]+H_[0,1]*10+H_[1,0]*100",
        531.0,
    );
    assert_x(
        "DEF NCK APW 5 APR 7 REAL PHU 5 LLI -100.0 ULI +100.0 V_[3,3] = SET(1,0,0, 0,1,0, 0,0,1), W_=2",
        "V_[2,2]+W_",
        3.0,
    );
    assert_x("_GUD=3", "_GUD", 3.0);
    // A value that a block assigns does not hold in the same block.
    assert_eq!(x_of("R1=1 R2=R1", "R2"), None);
    assert_eq!(run("R1=1\nG1 R1=2 X=R1 F100\n")[0].end, None);
    // Never assigned, known only at run time, out of bounds, or perhaps skipped.
    for (before, value) in [
        ("", "R99"),
        ("", "$AA_IM[X]"),
        ("DEF INT F[2]=SET(1,2)", "F[2]"),
        ("R1=5\n/R1=6", "R1"),
        ("R1=5\nL100", "R1"),
        ("R1=5\nMY_PROGRAM(1)", "R1"),
        ("R1=$AA_IM[X]", "R1"),
        ("R1=5\nWHENEVER $A_IN[1]==1 DO R1=3", "R1"),
    ] {
        assert_eq!(x_of(before, value), None, "{before}: {value}");
    }
}

#[test]
fn a_value_that_is_not_known_leaves_its_motion_alone_until_an_absolute_word() {
    let motions = run("G1 X=R5 F100\nX3\n");
    assert_eq!(motions[0].unfollowable, Some(Unfollowable::Expression { address: Address::X }));
    assert!(motions[1].start.is_none() && linear(&motions[1]) == Some([3.0, 0.0, 0.0]));
    assert_eq!(motions[1].unfollowable, None);
}
