//! P3 Tables 5 and 6 cut again on a blade of our own: a 10 mm ball programmed, balls of 8, 9 and 9.5 mm in the
//! spindle, as they are and compensated.

use std::ops::ControlFlow;

use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::Tool;
use trunnion::process::{
    ContactSource, Verification, VerificationParameters, WearParameters, WornCutter, compensate_wear,
    verify_part,
};
use trunnion::surface::{Blade, BladeSizes, ParametricSurface, SurfacePoint};
use trunnion::units::Length;
use trunnion::wear::OneAfterAnother;

use crate::blade_passes::Spiral;
use crate::finishing::ac_machine;

fn ball(diameter_mm: f64) -> Tool {
    let radius = Length::from_mm(0.5 * diameter_mm);
    Tool::new(radius, radius).expect("a ball")
}

#[test]
fn tables_5_and_6_come_out_in_the_papers_order() {
    let machine = ac_machine();
    let setup = Setup { work_offset_mm: Vec3::new(5.0, -3.0, 40.0), ..Setup::default() };
    let blade = Blade::new(Vec3::zeros(), BladeSizes::default()).expect("a blade");
    let spiral = Spiral {
        radius_mm: 5.0,
        stepover_mm: 0.894,
        tolerance_mm: 0.03,
        lean_rad: 45_f64.to_radians(),
        heights_mm: [20.0, 40.0],
    };
    let contacts = spiral.contacts(&blade);
    let nominal = spiral.table(&machine, &setup, &contacts).into_bytes();
    let samples: Vec<SurfacePoint> = blade
        .samples(60_000)
        .points
        .into_iter()
        .filter(|sample| (24.0..36.0).contains(&sample.point_mm.z))
        .collect();
    let cut = |diameter_mm: f64, program: &Vec<u8>| -> Verification {
        let parameters = VerificationParameters { setup, ..VerificationParameters::new(ball(diameter_mm)) };
        let stop = || ControlFlow::Continue(());
        verify_part(&machine, &parameters, &samples, program, &OneAfterAnother, &stop).expect("cut")
    };
    let compensated = |diameter_mm: f64| {
        let parameters = WearParameters {
            setup,
            contact: ContactSource::Normals,
            ..WearParameters::new(ball(10.0), WornCutter::Tool(ball(diameter_mm)))
        };
        let mut output = Vec::new();
        let stop = || ControlFlow::Continue(());
        compensate_wear(&machine, &parameters, &nominal, &mut output, &stop).expect("compensated");
        output
    };
    eprintln!("{} contacts, {} samples", contacts.len(), samples.len());
    let say = |name: &str, found: &Verification| {
        let s = &found.summary;
        eprintln!(
            "{name}: over {} gouge {} uncut {} max {:.4} gouge {:.4} rms {:.4} pairs {} pieces {} conv {:.2e}",
            s.over_excess,
            s.over_gouge,
            s.uncut,
            s.max_excess.map_or(0.0, |e| e.residual.residual_mm),
            s.max_gouge.map_or(0.0, |e| e.residual.residual_mm),
            s.rms_mm,
            found.effort.pairs,
            found.effort.pieces,
            found.convergence.max_change.mm()
        );
    };
    let t = std::time::Instant::now();
    say("10", &cut(10.0, &nominal));
    eprintln!("{:?}", t.elapsed());
    for d in [8.0, 9.0, 9.5] {
        say(&format!("{d} as it is"), &cut(d, &nominal));
        say(&format!("{d} compensated"), &cut(d, &compensated(d)));
    }
    eprintln!("{:?}", t.elapsed());
}
