//! Laws of posted arcs: the circle of the source in its unit and its sense, and nothing where the text leaves the course
//! open.

#![expect(clippy::panic, reason = "a test stops at the first surprise, helpers included")]

use std::ops::ControlFlow;

use trunnion::motion::Unfollowable;
use trunnion::process::{
    Fault, Interpreted, LineFaultKind, NotPosted, PostForm, PostParameters, PostReport, ProgramSetup,
    interpret_program, post,
};
use trunnion::units::{LengthUnit, MM_PER_INCH};

use crate::models::finishing::ac_machine;
use crate::models::set_ups::at_zero;
use crate::models::witness::scan;

fn run(program: ProgramSetup, form: PostForm, text: &str) -> Result<(String, PostReport), Fault> {
    let parameters = PostParameters { form, ..PostParameters::new(program) };
    let mut output = Vec::new();
    let source = text.as_bytes().to_vec();
    let report = post(&ac_machine(), &parameters, &source, &mut output, &|| ControlFlow::Continue(()))?;
    Ok((String::from_utf8(output).expect("text"), report))
}

/// Line and reason of every refusal.
fn refusals(text: &str) -> Vec<(u64, NotPosted)> {
    let Err(Fault::Lines(faults)) = run(at_zero(), PostForm::Tcp, text) else { panic!("{text} is posted") };
    let why = |kind: &LineFaultKind| match kind {
        LineFaultKind::NotPosted(why) => *why,
        other => panic!("{other:?}"),
    };
    faults.kept.iter().map(|fault| (fault.line, why(&fault.kind))).collect()
}

/// A set-up whose data count in inches, as the caller says.
fn in_inches() -> ProgramSetup {
    ProgramSetup { unit: Some(LengthUnit::Inch), ..at_zero() }
}

#[test]
fn a_circle_counts_in_the_unit_of_its_points_whoever_states_it() {
    let body = "FEDRAT/10,PERMIN\nGOTO/1,1,0\nCIRCLE/1,0,0,0,0,1\nGOTO/1,-1,0\n";
    for form in [PostForm::Tcp, PostForm::Machine] {
        let (stated, _) = run(in_inches(), form, body).expect("posted");
        let (in_text, _) = run(at_zero(), form, &format!("UNITS/INCHES\n{body}")).expect("posted");
        assert_eq!(stated, in_text);
        let tips: Vec<_> = scan(&stated, ['A', 'C']).into_iter().skip(2).map(|line| line.q).collect();
        assert!(tips.len() > 20, "{stated}");
        for tip in tips {
            let radius_mm = (tip.x - MM_PER_INCH).hypot(tip.y);
            assert!((radius_mm - MM_PER_INCH).abs() < 1e-3 && tip.x < MM_PER_INCH + 1e-3, "{tip}");
        }
    }
    // If the unit changes between a circle and its end, the arc is refused.
    let mixed = "FEDRAT/10,MMPM\nGOTO/2,0,0\nCIRCLE/1,0,0,0,0,1\nUNITS/INCHES\nFEDRAT/1,IPM\nGOTO/0,0,0\n";
    let refused = refusals(mixed);
    assert!(matches!(refused[..], [(4, NotPosted::Arc { .. }), ..]), "{refused:?}");
}

#[test]
fn a_further_point_on_the_circle_is_refused_and_points_with_their_own_circle_are_posted() {
    let quarter = "FEDRAT/100,MMPM\nGOTO/10.,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10.,0\n";
    let doubt = NotPosted::Unfollowable(Unfollowable::OnCircle);
    // Creo writes points on the arc, and the last one is its end.
    let creo = format!("{quarter}GOTO/-10.,0,0\nGOTO/0,-10.,0\nGOTO/30.,0,0\n");
    assert_eq!(refusals(&creo), [(5, doubt), (6, doubt)]);
    assert_eq!(refusals(&format!("{quarter}FEDRAT/50,MMPM\nGOTO/-6.,8.,0\n")), [(6, doubt)]);
    for sound in [
        "CIRCLE/0,0,0,0,0,1,10\nGOTO/-10.,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,-10.,0\nGOTO/30.,0,0\n",
        "GOTO/-10.,10.,0\n",
        "RAPID\nGOTO/-10.,0,0\n",
        "GOTO/0,10.,5\n",
    ] {
        run(at_zero(), PostForm::Tcp, &format!("{quarter}{sound}")).expect(sound);
    }
}

#[test]
fn turns_and_other_items_of_a_circle_are_refused() {
    for items in [
        "0,0,0,0,0,1,10,0.06,0.5,12,0,TIMES,3",
        "0,0,0,0,0,1,10,TIMES,1",
        "0,0,0,0,0,1,10,CCLW",
        "0,0,,0,0,1,10",
        "0,0,0,0,0,0,10",
    ] {
        let text = format!("FEDRAT/100,MMPM\nGOTO/10.,0,0\nCIRCLE/{items}\nGOTO/0,10.,0\n");
        let refused = refusals(&text);
        assert!(matches!(refused[..], [(4, NotPosted::Arc { .. })]), "{items} {refused:?}");
    }
}

#[test]
fn no_operation_follows_a_point_that_may_be_on_the_arc() {
    let text =
        "FEDRAT/100,MMPM\nGOTO/10.,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10.,0\nGOTO/-10.,0,0\nGOTO/-20.,0,0\n";
    let mut motions = Vec::new();
    let source = text.as_bytes().to_vec();
    let mut take = |motion: &Interpreted| {
        motions.push(match *motion {
            Interpreted::Motion(motion) => (motion.line, None),
            Interpreted::LeftAlone { line, reason, .. } => (line, Some(reason)),
        });
        Ok(())
    };
    interpret_program(&ac_machine(), &at_zero(), &source, &mut take, &|| ControlFlow::Continue(()))
        .expect("read");
    let expected = [(2, None), (4, None), (5, Some(Unfollowable::OnCircle)), (6, None)];
    assert_eq!(motions, expected);
}
