//! Contact words: which of them complete one another, and where a contact point may stand.

use super::tests::*;
use super::*;

#[test]
fn contact_words_complete_one_another() {
    let motions = run_from_zero("G1 X1 U1 V2 F1\nX2 W3\nX3\nX4 U2.25\n");
    let seen: Vec<_> = motions.iter().map(|motion| motion.contact).collect();
    assert_eq!(
        seen,
        [
            ContactWords::None,
            ContactWords::Point([1.0, 2.0, 3.0]),
            ContactWords::None,
            ContactWords::Point([2.25, 2.0, 3.0])
        ]
    );
    assert_eq!(motions[3].decimals.contact, 2);
}

#[test]
fn contact_words_in_g91_are_not_followed() {
    let motions = run_from_zero("G1 X1 U1 V2 W3 F1\nG91 X1 W.5\nX1\nG90 X5 U1 V2 W3\n");
    let seen: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
    assert_eq!(seen, [None, Some(Unfollowable::IncrementalContact), None, None]);
    assert_eq!(motions[1].contact, ContactWords::Point([1.0, 2.0, 3.5]));
}

#[test]
fn only_motions_under_the_motion_codes_have_a_contact_point() {
    for block in [
        "G28 U0 V0 W0",
        "G28 X0 U0 V0 W0",
        "G30 U0 V0 W0",
        "G53 X0 U0 V0 W0",
        "G81 X1 U0 V0 W0",
        "G31 X1 U0 V0 W0",
        "G5.1 X1 U0 V0 W0",
        "G92 U0 V0 W0",
        "G10 L2 P1 X0 U0 V0 W0",
        "G4 X1 U0 V0 W0",
        "G65 P1 X1 U0 V0 W0",
    ] {
        let motions = run_from_zero(&format!("G1 F1\n{block}\n"));
        assert!(motions.iter().all(|motion| motion.contact == ContactWords::None), "{block}");
    }
    for code in ["G0", "G1", "G2"] {
        let motions = run_from_zero(&format!("{code} X1 U0 V0 W0 F1\n"));
        assert_eq!(motions[0].contact, ContactWords::Point([0.0; 3]), "{code}");
    }
}

#[test]
fn axis_words_without_a_point_are_counted_where_others_have_one() {
    for (text, count) in [
        ("G0 X10 Y20\nA5\n", 0),
        ("G0 X10. Y20.5\nA5.\n", 0),
        ("G0 X10 Y20.5\nX0 A-5\n", 2),
        ("G0 X10\nX10.\n", 1),
        ("G0 X10. F100 I5 S1000\n", 0),
        ("G0 X10.\nG4 X500\nY#1\n", 0),
        ("G0 X10\nG4 X5.\n", 0),
        ("G0 X10.\nM30\nX10\n", 0),
        ("x,y,z,a,c\n1,2.5,3,4,5\n", 0),
    ] {
        let (interpreter, ..) = interpreted(text, InterpreterOptions::in_mm());
        assert_eq!(interpreter.words_without_point(), count, "{text}");
    }
}
