//! The example program of the documentation is what the generator writes, and compensates as the README says.

use std::fs;
use std::path::PathBuf;

use trunnion::machine::{EXAMPLE_ID, Machine, Preset};

use super::compensation::{parameters, run};
use crate::models::finishing::{FeedForm, Form, blade, tool};

#[test]
fn the_example_program_is_the_generator_s_blade() {
    let parts = Preset::by_id(EXAMPLE_ID).expect("the example machine").parts();
    let machine = Machine::new(parts).expect("the example machine makes sense");
    let part = blade(machine, tool(5.0, 5.0), 25, 4);
    let text = part.program(Form::ContactWords, FeedForm::PerMinute);
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs/examples/blade.nc");
    if std::env::var_os("BLESS").is_some() {
        fs::write(&path, &text).expect("written");
    }
    assert!(fs::read_to_string(&path).expect("the example") == text, "BLESS=1 writes it again");
    let (output, report) = run(&part, &parameters(&part), &text).expect("compensated");
    assert!(report.motions_over_tolerance > 10 && report.after.max_mm <= 0.010);
    assert!(output.lines().count() > text.lines().count());
}
