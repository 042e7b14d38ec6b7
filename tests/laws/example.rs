//! The example program of the documentation is what the generator writes, and compensates as the README says.

use std::fs;
use std::ops::ControlFlow;
use std::path::PathBuf;

use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::{EXAMPLE_ID, Machine, Preset};
use trunnion::process::{VerificationParameters, verify_part};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::surface::{Bulge, ParametricSurface, Sphere};
use trunnion::units::Length;
use trunnion::wear::{Surface, scallop_height};

use super::compensation::{parameters, run};
use crate::models::finishing::{FeedForm, Form, blade, tool};
use crate::models::set_ups::{at_zero, in_mm};
use crate::models::surface_passes::{Finish, program};

/// The committed file is this text.
fn assert_is_the_example(name: &str, text: &str) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs/examples").join(name);
    if std::env::var_os("BLESS").is_some() {
        fs::write(&path, text).expect("written");
    }
    assert!(fs::read_to_string(&path).expect("the example") == text, "BLESS=1 writes it again");
}

fn example_machine() -> Machine {
    let parts = Preset::by_id(EXAMPLE_ID).expect("the example machine").parts();
    Machine::new(parts).expect("the example machine makes sense")
}

#[test]
fn the_example_program_is_the_generator_s_blade() {
    let part = blade(example_machine(), tool(5.0, 5.0), 25, 4);
    let text = part.program(Form::ContactWords, FeedForm::PerMinute);
    assert_is_the_example("blade.nc", &text);
    let (output, report) = run(&part, &parameters(&part), &text).expect("compensated");
    assert!(report.motions_over_tolerance > 10 && report.after.max_mm <= 0.010);
    assert!(output.lines().count() > text.lines().count());
}

/// The dome of the README: a patch of a sphere of 20 mm, 20° either way, in passes 0.9 mm apart.
#[test]
fn the_example_dome_leaves_the_scallops_it_was_made_for() {
    let machine = example_machine();
    let setup = Setup { work_offset_mm: Vec3::new(12.0, -7.0, 35.0), ..Setup::default() };
    let half_rad = 20_f64.to_radians();
    // Passes reach beyond what is looked at by a fifth. The tool leans by 40°, so that it stays clear of the pole.
    let whole = Sphere::new(Vec3::zeros(), 20.0, 1.2 * half_rad, Bulge::Convex).expect("a sphere");
    let finish = Finish { radius_mm: 5.0, tolerance_mm: 0.004, towards: Vec3::y() };
    let count = 19;
    let passes: Vec<_> = (0..count)
        .map(|pass| {
            let v = 1.2 * half_rad * (2.0 * f64::from(pass) / f64::from(count - 1) - 1.0);
            let side = if pass % 2 == 0 { 1.0 } else { -1.0 };
            let at = |s: f64| (whole.at([side * 1.2 * half_rad * (2.0 * s - 1.0), v]), 0.7);
            finish.post(&machine, &setup, &finish.contacts(at, 1.0, 1.0 / 8.0))
        })
        .collect();
    let text = program("dome", &passes, 80.0);
    assert_is_the_example("dome.nc", &text);
    let tool = tool(5.0, 5.0);
    let parameters =
        VerificationParameters { program: in_mm(&setup), ..VerificationParameters::new(tool, at_zero()) };
    let samples = Sphere::new(Vec3::zeros(), 20.0, half_rad, Bulge::Convex).expect("a sphere").samples(4000);
    let stop = || ControlFlow::Continue(());
    let found =
        verify_part(&machine, &parameters, &samples.points, &text.into_bytes(), &OneAfterAnother, &stop);
    let found = found.expect("cut").summary;
    let stepover = Length::from_mm(2.0 * 20.0 * (0.5 * 2.4 * half_rad / f64::from(count - 1)).sin());
    let surface = Surface::Convex { radius: Length::from_mm(20.0) };
    let scallop_mm = scallop_height(stepover, tool.radius(), surface).expect("a scallop").mm();
    assert_eq!((found.uncut, found.over_excess, found.over_gouge), (0, 0, 0));
    let worst_mm = found.max_excess.expect("scallops").residual.residual_mm;
    assert!(worst_mm < scallop_mm + 0.001 && worst_mm > 0.8 * scallop_mm, "{worst_mm} {scallop_mm}");
}
