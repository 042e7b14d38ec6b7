//! Laws of programs whose contacts come from the part: on facets of a surface that is known exactly they are worth as
//! much as the exact normals.
#![expect(clippy::unwrap_used, reason = "a test may stop at what it did not expect")]

use std::ops::ControlFlow;
use std::sync::Arc;

use trunnion::contact::PartSurface;
use trunnion::geometry::Vec3;
use trunnion::machine::Tool;
use trunnion::process::{
    CcParameters, ContactSource, Fault, WarningKind, WearParameters, WearReport, WornCutter, compensate,
    compensate_wear,
};
use trunnion::surface::{Blade, BladeSizes, Bulge, Mesh, ParametricSurface, Saddle, Sphere};
use trunnion::units::Length;

use crate::models::finishing::{FeedForm, Finishing, Form, ac_machine, patch, tool};
use crate::models::set_ups::{at_zero, in_mm};
use crate::models::tessellation::facets;

/// Words of four decimals on three axes, in both programs [mm].
const WORDS_MM: f64 = 2.0 * 0.866_025_404e-4;

/// Of the contact from its line [mm].
const TOLERANCE_MM: f64 = 0.003;

struct Case {
    name: &'static str,
    surface: Box<dyn ParametricSurface>,
    cells: [usize; 2],
    window: [[f64; 2]; 2],
    lean_deg: [f64; 2],
    /// By how much normals on the mesh are off, over the window [rad]; asserted.
    normal_error: f64,
    /// Least radius of curvature over the window [mm].
    radius_mm: f64,
}

fn cases() -> Vec<Case> {
    let at = Vec3::new(3.0, -2.0, 1.0);
    let blade = || Box::new(Blade::new(at, BladeSizes::default()).unwrap());
    let middle = [[0.2, 0.8], [0.2, 0.8]];
    vec![
        Case {
            name: "sphere",
            surface: Box::new(Sphere::new(at, 30.0, 0.6, Bulge::Convex).unwrap()),
            cells: [80, 80],
            window: middle,
            lean_deg: [20.0, 10.0],
            normal_error: 1e-6,
            radius_mm: 30.0,
        },
        Case {
            name: "saddle",
            surface: Box::new(Saddle::new(at, 30.0, 50.0, 40.0, 40.0).unwrap()),
            cells: [120, 120],
            window: middle,
            lean_deg: [25.0, -10.0],
            normal_error: 5e-5,
            radius_mm: 30.0,
        },
        // the convex side from beyond its middle, over the leading edge, to the hollow side
        Case {
            name: "blade",
            surface: blade(),
            cells: [1800, 60],
            window: [[0.25, 0.75], [0.3, 0.7]],
            lean_deg: [10.0, 50.0],
            normal_error: 2e-5,
            radius_mm: 0.65,
        },
    ]
}

fn part_of(case: &Case) -> PartSurface {
    let mesh = Mesh::from_facets(facets(case.surface.as_ref(), case.cells), 0.02).unwrap();
    PartSurface { mesh: Arc::new(mesh), contact_gap: PartSurface::DEFAULT_CONTACT_GAP }
}

fn finishing(case: &Case, tool: Tool) -> Finishing {
    patch(case.name, tool, case.surface.as_ref(), case.window, case.lean_deg, [60, 4])
}

fn worn(part: &Finishing, parameters: &WearParameters, text: &str) -> Result<(String, WearReport), Fault> {
    let mut output = Vec::new();
    let source = text.as_bytes().to_vec();
    let go_on = || ControlFlow::Continue(());
    let report = compensate_wear(&part.machine, parameters, &source, &mut output, &go_on)?;
    Ok((String::from_utf8(output).unwrap(), report))
}

/// X Y Z of a table's rows.
fn places(table: &str) -> Vec<Vec3> {
    table
        .lines()
        .skip(1)
        .map(|row| {
            let mut cells = row.split(',').map(|cell| cell.parse::<f64>().unwrap());
            let mut next = || cells.next().unwrap();
            Vec3::new(next(), next(), next())
        })
        .collect()
}

/// How far a place is from the way along others [mm].
fn distance(place: &Vec3, way: &[Vec3]) -> f64 {
    let to_chord = |pair: &[Vec3]| {
        let along = pair[1] - pair[0];
        let share = (place - pair[0]).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        (place - pair[0] - along * share.clamp(0.0, 1.0)).norm()
    };
    way.windows(2).map(to_chord).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_worn_cutter_moves_by_the_surface_as_by_its_normals() {
    for case in cases() {
        let surface = part_of(&case);
        for (nominal, actual) in [
            (tool(2.0, 2.0), tool(1.9, 1.9)),
            (tool(2.0, 0.5), tool(1.95, 0.4)),
            (tool(2.0, 0.0), tool(1.9, 0.0)),
        ] {
            let part = finishing(&case, nominal);
            let own = part.points.iter().map(|point| {
                let found = surface.mesh.nearest(point.contact_mm, 0.1).unwrap();
                (found.normal - point.normal).norm()
            });
            let own = own.fold(0.0, f64::max);
            assert!(own < case.normal_error, "{}: {own:e}", case.name);
            let text = part.program(Form::NormalTable, FeedForm::PerMinute);
            let by = |contact, given: Option<&PartSurface>| {
                let setup = WearParameters::new(nominal, WornCutter::Tool(actual), at_zero());
                let parameters =
                    WearParameters { contact, program: in_mm(&part.setup), part: given.cloned(), ..setup };
                worn(&part, &parameters, &text).unwrap_or_else(|fault| panic!("{}: {fault:?}", case.name))
            };
            let (normals, _) = by(ContactSource::Normals, None);
            let (found, report) = by(ContactSource::Surface, Some(&surface));
            assert_eq!(report.contact, ContactSource::Surface);
            assert_eq!(report.contacts_kept, part.points.len() as u64, "{}", case.name);
            // (r − r′) and the change of R − r, each by what its direction is off; m turns by more than n
            let radii = |tool: Tool| [tool.corner_radius().mm(), tool.core_radius().mm()];
            let [corner, core] = [0, 1].map(|k| (radii(nominal)[k] - radii(actual)[k]).abs());
            let least_sine =
                part.points.iter().map(|p| p.normal.cross(&p.pose.axis).norm()).fold(1.0, f64::min);
            // the pose's own words stand for a place of the surface half a unit away
            let off = case.normal_error + WORDS_MM / case.radius_mm;
            let bound_mm = (corner + core / least_sine) * off + WORDS_MM;
            let apart =
                places(&normals).iter().zip(places(&found)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            println!("{} {}: own {own:e}, apart {apart:e} of {bound_mm:e}", case.name, radii(nominal)[0]);
            assert!(apart <= bound_mm, "{}: {apart} {bound_mm}", case.name);
            // and it is no idle bound: the shift itself is far larger
            assert!(report.max_shift.mm() > 20.0 * bound_mm, "{} {bound_mm}", report.max_shift.mm());
        }
    }
}

#[test]
fn a_compensated_path_keeps_its_contacts_by_the_surface_as_by_its_normals() {
    for case in cases() {
        let surface = part_of(&case);
        // around the edge of the blade a bull-nose cutter swings too far from one pass to the next
        let round = [tool(2.0, 2.0), tool(2.0, 0.5)];
        for nominal in round.into_iter().take(if case.name == "blade" { 1 } else { 2 }) {
            let part = finishing(&case, nominal);
            let text = part.program(Form::NormalTable, FeedForm::PerMinute);
            let by = |contact, given: Option<&PartSurface>| {
                let parameters = CcParameters {
                    contact,
                    program: in_mm(&part.setup),
                    part: given.cloned(),
                    tolerance: Length::from_mm(TOLERANCE_MM),
                    ..CcParameters::new(nominal, at_zero())
                };
                let mut output = Vec::new();
                let source = text.as_bytes().to_vec();
                let go_on = || ControlFlow::Continue(());
                let report = compensate(&part.machine, &parameters, &source, &mut output, &go_on)
                    .unwrap_or_else(|fault| panic!("{}: {fault:?}", case.name));
                (String::from_utf8(output).unwrap(), report)
            };
            let ((normals, exact), (found, report)) =
                (by(ContactSource::Normals, None), by(ContactSource::Surface, Some(&surface)));
            assert!(
                report.after.max_mm <= TOLERANCE_MM + 1e-9 && report.blocks_out > report.blocks_in,
                "{report:?}"
            );
            assert_eq!(report.motions_checked, exact.motions_checked);
            // what a block strays before it is divided differs by the cutter times what normals are off
            let reach_mm = nominal.corner_radius().mm() + 4.0 * nominal.core_radius().mm();
            let bound_mm = reach_mm * (case.normal_error + WORDS_MM / case.radius_mm) + WORDS_MM;
            let apart = (report.before.max_mm - exact.before.max_mm).abs();
            println!(
                "{}: {apart:e} of {bound_mm:e}, blocks {} {}",
                case.name, exact.blocks_out, report.blocks_out
            );
            assert!(apart <= bound_mm, "{}: {apart} {bound_mm}", case.name);
            let (normals, found) = (places(&normals), places(&found));
            if case.name != "blade" {
                // in these cases the blocks are divided alike
                assert_eq!(normals.len(), found.len(), "{}", case.name);
                let ends = normals.iter().zip(&found).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                assert!(ends <= bound_mm, "{}: {ends}", case.name);
                continue;
            }
            // around the edge the normal of the surface turns unevenly; parts that stay as they are when they are
            // compensated again are a few more, on the same way
            assert!((normals.len()..normals.len() * 21 / 20).contains(&found.len()), "{}", found.len());
            let off = normals.iter().map(|place| distance(place, &found)).fold(0.0, f64::max);
            assert!(off <= TOLERANCE_MM + bound_mm, "{}: {off}", case.name);
        }
    }
}

#[test]
fn a_roof_has_no_curvature_along_its_ridge() {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let at = |way: f64, y: f64| Vec3::new(way * cos, y, -way.abs() * sin);
    let planes = [[-30.0, 0.0], [0.0, 30.0]].map(|[from, to]| {
        let [a, b, c, d] = [at(from, -40.0), at(to, -40.0), at(to, 40.0), at(from, 40.0)];
        [[a, b, c], [a, c, d]]
    });
    let mesh = Mesh::from_facets(planes.into_iter().flatten(), 0.02).unwrap();
    assert_eq!(mesh.report().sharp_edges, 1);
    let surface = PartSurface { mesh: Arc::new(mesh), contact_gap: PartSurface::DEFAULT_CONTACT_GAP };
    let part = Finishing { machine: ac_machine(), ..finishing(&cases()[0], tool(2.0, 2.0)) };
    let parameters = WearParameters {
        contact: ContactSource::Surface,
        part: Some(surface),
        ..WearParameters::new(part.tool, WornCutter::Tool(tool(1.9, 1.9)), at_zero())
    };
    let text = "G90 G21 G94\nG0 X0 Y-20 Z30 A0 C0\nG1 Z0 F500\nG1 Y0\nG1 Y20\nG0 Z30\nM30\n";
    let (_, report) = worn(&part, &parameters, text).unwrap();
    assert_eq!(report.contacts_kept, 3);
    let curvature = report.curvature.unwrap();
    assert!(curvature.convex.is_none() && curvature.concave.is_none(), "{curvature:?}");
}

#[test]
fn where_nothing_touches_only_the_length_moves_a_point() {
    let case = &cases()[0];
    let surface = part_of(case);
    let part = finishing(case, tool(2.0, 2.0));
    let text = part.program(Form::Plain, FeedForm::PerMinute);
    // a retract at feed before the program's end
    let (head, tail) = text.split_at(text.find(" M5").unwrap());
    let number = head.rfind('N').unwrap();
    let text = format!("{}N5000 G1 Z300.\n{}{tail}", &head[..number], &head[number..]);
    let worn_ball = WornCutter::Tool(tool(1.9, 1.9));
    let parameters = WearParameters {
        program: in_mm(&part.setup),
        part: Some(surface),
        ..WearParameters::new(part.tool, worn_ball, at_zero())
    };
    let (output, report) = worn(&part, &parameters, &text).unwrap();
    // by itself: no contact words, no normals, but a surface
    assert_eq!(report.contact, ContactSource::Surface);
    assert_eq!(report.contacts_kept, part.points.len() as u64);
    let missing = report.warnings.iter().find(|warning| warning.kind == WarningKind::NoContactAtEnd).unwrap();
    assert_eq!(missing.count, 1);
    assert!(output.contains("N5000 G1 Z300."), "{output}");
    let curvature = report.curvature.unwrap();
    let (radius, _) = curvature.convex.unwrap();
    assert!((radius.mm() - 30.0).abs() < 0.05 && curvature.concave.is_none(), "{curvature:?}");
    // an unworn cutter comes back byte for byte
    let same = WearParameters { worn: Some(WornCutter::Tool(part.tool)), ..parameters.clone() };
    assert_eq!(worn(&part, &same, &text).unwrap().0, text);
    let without = WearParameters { contact: ContactSource::Surface, part: None, ..parameters };
    assert!(matches!(
        worn(&part, &without, &text),
        Err(Fault::NoContactInProgram { contact: "surface", .. })
    ));
}
