//! P3 Tables 5 and 6 cut again on a blade of our own: a 10 mm ball programmed, balls of 8, 9 and 9.5 mm in the
//! spindle, as they are and compensated.

use std::ops::ControlFlow;

use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::Tool;
use trunnion::process::{
    ContactSource, VerificationParameters, WearParameters, WornCutter, compensate_wear, verify_part,
};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::surface::{Blade, BladeSizes, ParametricSurface, SurfacePoint};
use trunnion::units::Length;

use crate::finishing::ac_machine;
use crate::set_ups::{at_zero, in_mm};
use crate::surface_passes::{Finish, table};

/// P3 Table 3's finishing: 0.02 mm of scallop on a plane by a ball of 10 mm, tolerance 0.03 mm.
const STEPOVER_MM: f64 = 0.894;
const TOLERANCE_MM: f64 = 0.03;
/// Heights between which the blade is cut, and looked at: a ball's radius less at either end.
const CUT_MM: [f64; 2] = [20.0, 40.0];
const SEEN_MM: [f64; 2] = [24.0, 36.0];
/// The tool axis leans from the normal by this at the lower end of what is looked at, and at the upper \[deg\].
const LEAN_DEG: [f64; 2] = [5.0, 50.0];
/// Samples on the whole blade.
const SAMPLES: usize = 24_000;
/// The contact of the program's words, four decimals of a millimetre and of a degree at 40 mm [mm].
const WORDS_MM: f64 = 3e-4;

fn ball(diameter_mm: f64) -> Tool {
    let radius = Length::from_mm(0.5 * diameter_mm);
    Tool::new(radius, radius).expect("a ball")
}

/// Points over the limit and the largest residual [mm].
#[derive(Debug, Clone, Copy)]
struct Row {
    over: u64,
    max_mm: f64,
}

#[test]
fn tables_5_and_6_come_out_in_the_papers_order() {
    let machine = ac_machine();
    let setup = Setup { work_offset_mm: Vec3::new(5.0, -3.0, 40.0), ..Setup::default() };
    let blade = Blade::new(Vec3::zeros(), BladeSizes::default()).expect("a blade");
    let finish = Finish { radius_mm: 5.0, tolerance_mm: TOLERANCE_MM, towards: Vec3::z() };
    let share = |height_mm: f64| ((height_mm - SEEN_MM[0]) / (SEEN_MM[1] - SEEN_MM[0])).clamp(0.0, 1.0);
    let lean = |height_mm: f64| LEAN_DEG[0] + (LEAN_DEG[1] - LEAN_DEG[0]) * share(height_mm);
    let at = |turn: f64| {
        let height_mm = CUT_MM[0] + STEPOVER_MM * turn;
        (blade.at([turn.fract(), height_mm]), lean(height_mm).to_radians())
    };
    let contacts = finish.contacts(at, (CUT_MM[1] - CUT_MM[0]) / STEPOVER_MM, 1.0 / 16.0);
    let nominal = table(&finish.post(&machine, &setup, &contacts)).into_bytes();
    let samples: Vec<SurfacePoint> = blade
        .samples(SAMPLES)
        .points
        .into_iter()
        .filter(|sample| (SEEN_MM[0]..SEEN_MM[1]).contains(&sample.point_mm.z))
        .collect();
    let stop = || ControlFlow::Continue(());
    let cut = |diameter_mm: f64, program: &Vec<u8>| -> Row {
        let parameters = VerificationParameters {
            program: in_mm(&setup),
            ..VerificationParameters::new(ball(diameter_mm), at_zero())
        };
        let found = verify_part(&machine, &parameters, &samples, program, &OneAfterAnother, &stop)
            .expect("cut")
            .summary;
        assert_eq!(found.uncut, 0);
        let max_mm = found.max_excess.map_or(0.0, |worst| worst.residual.residual_mm);
        let row = Row { over: found.over_excess, max_mm };
        println!("{diameter_mm} mm: {row:?}");
        row
    };
    let compensated = |diameter_mm: f64| {
        let worn = WornCutter::Tool(ball(diameter_mm));
        let contact = ContactSource::Normals;
        let parameters = WearParameters {
            program: in_mm(&setup),
            contact,
            ..WearParameters::new(ball(10.0), worn, at_zero())
        };
        let mut output = Vec::new();
        compensate_wear(&machine, &parameters, &nominal, &mut output, &stop).expect("compensated");
        output
    };
    println!("{} contacts, {} samples", contacts.len(), samples.len());
    let programmed = cut(10.0, &nominal);
    let worn = [8.0, 9.0, 9.5];
    let as_is = worn.map(|diameter_mm| cut(diameter_mm, &nominal));
    let mended = worn.map(|diameter_mm| cut(diameter_mm, &compensated(diameter_mm)));
    // The papers' order: more and larger the more is worn, fewer and smaller once compensated, never below what the
    // nominal ball leaves.
    for rows in [as_is, mended] {
        let falls = |value: fn(&Row) -> f64| {
            rows.windows(2).all(|pair| value(&pair[0]) > value(&pair[1]))
                && value(&rows[2]) >= value(&programmed)
        };
        assert!(falls(|row| row.over as f64) && falls(|row| row.max_mm), "{rows:?} {programmed:?}");
    }
    for (diameter_mm, (as_is, mended)) in worn.into_iter().zip(as_is.into_iter().zip(mended)) {
        assert!(mended.over < as_is.over && mended.max_mm < as_is.max_mm);
        // What stands off uncompensated is (r − r′)(1 − n·t) where the axis leans most.
        let lost_mm = (5.0 - 0.5 * diameter_mm) * (1.0 - LEAN_DEG[1].to_radians().cos());
        assert!(as_is.max_mm > lost_mm - WORDS_MM && as_is.max_mm < lost_mm + mended.max_mm);
    }
}
