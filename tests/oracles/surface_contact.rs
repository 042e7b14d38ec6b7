//! The contact from the part, against surfaces whose contacts are known: the cutter is put where it touches a chosen
//! point with the exact normal, and has to find that point and that normal on a mesh.
#![expect(clippy::unwrap_used, reason = "a test may stop at what it did not expect")]

use std::sync::Arc;

use trunnion::contact::{
    CutterBody, CutterContact, PartSurface, SurfaceContact, contact_on_surface, nearest_to_cutter,
};
use trunnion::geometry::{Vec3, across};
use trunnion::kinematics::ToolPose;
use trunnion::machine::Tool;
use trunnion::surface::{
    Blade, BladeSizes, Bulge, Cylinder, Mesh, ParametricSurface, Saddle, Sphere, Uncounted,
};
use trunnion::units::Length;

use crate::tessellation::{cube, facets};

fn tool(radius_mm: f64, corner_mm: f64) -> Tool {
    Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_mm)).unwrap()
}

fn part(facets: Vec<[Vec3; 3]>) -> PartSurface {
    let mesh = Mesh::from_facets(facets, 0.05).unwrap();
    PartSurface { mesh: Arc::new(mesh), contact_gap: PartSurface::DEFAULT_CONTACT_GAP }
}

/// A tool axis that leans from the normal by an angle, toward one of the directions along the surface.
fn leaning(normal: Vec3, lean_deg: f64, toward_deg: f64) -> Vec3 {
    let first = across(Vec3::new(0.36, 0.48, 0.8), normal).normalize();
    let second = normal.cross(&first);
    let (sin, cos) = toward_deg.to_radians().sin_cos();
    let (lean_sin, lean_cos) = lean_deg.to_radians().sin_cos();
    normal * lean_cos + (first * cos + second * sin) * lean_sin
}

fn touching(tool: &Tool, point_mm: Vec3, normal: Vec3, axis: Vec3) -> ToolPose {
    let contact = CutterContact::Normal { direction: normal, magnitude: 1.0 };
    ToolPose { tip_mm: point_mm - contact.offset_mm(tool, axis), axis }
}

struct Case {
    name: &'static str,
    surface: Box<dyn ParametricSurface>,
    cells: [usize; 2],
    /// Leans that gouge nowhere [deg].
    leans_deg: &'static [f64],
}

fn cases() -> Vec<Case> {
    let at = Vec3::new(2.0, -1.0, 3.0);
    let case = |name, surface: Box<dyn ParametricSurface>, cells, leans_deg| Case {
        name,
        surface,
        cells,
        leans_deg,
    };
    vec![
        case(
            "dome",
            Box::new(Sphere::new(at, 25.0, 0.8, Bulge::Convex).unwrap()),
            [60, 50],
            &[2.0, 15.0, 60.0],
        ),
        case("bowl", Box::new(Sphere::new(at, 25.0, 0.8, Bulge::Concave).unwrap()), [60, 50], &[20.0, 35.0]),
        case(
            "ridge",
            Box::new(Cylinder::new(at, 12.0, 1.2, 30.0, Bulge::Convex).unwrap()),
            [60, 9],
            &[2.0, 15.0, 60.0],
        ),
        case("saddle", Box::new(Saddle::new(at, 30.0, 50.0, 40.0, 40.0).unwrap()), [60, 60], &[10.0, 40.0]),
        case("blade", Box::new(Blade::new(at, BladeSizes::default()).unwrap()), [900, 80], &[20.0, 50.0]),
    ]
}

/// Parameters in the middle of a domain, away from its rim.
fn places(surface: &dyn ParametricSurface) -> Vec<[f64; 2]> {
    let [[u0, u1], [v0, v1]] = surface.domain();
    (0..150)
        .map(|k| {
            let (a, b) = ((f64::from(k) * 0.618_033_988_7).fract(), (f64::from(k) * 0.754_877_666).fract());
            [u0 + (u1 - u0) * (0.15 + 0.7 * a), v0 + (v1 - v0) * (0.15 + 0.7 * b)]
        })
        .collect()
}

/// Largest error of the mesh's own normals at the places [rad].
fn normal_error(case: &Case, part: &PartSurface) -> f64 {
    places(case.surface.as_ref())
        .into_iter()
        .map(|place| {
            let exact = case.surface.at(place);
            (part.mesh.nearest(exact.point_mm, 1.0).unwrap().normal - exact.normal).norm()
        })
        .fold(0.0, f64::max)
}

/// A contact's way over the mesh is followed to this [mm].
const FOLLOWED_MM: f64 = 1e-5;
/// What the cutter's width times a turn leaves out, of turns within 0.01 rad and leans from 2° (share).
const SECOND_ORDER: f64 = 1.1;

#[test]
fn cutters_find_the_point_and_the_normal_they_were_put_on() {
    for case in cases() {
        let part = part(facets(case.surface.as_ref(), case.cells));
        let own_error = normal_error(&case, &part);
        for tool in [tool(5.0, 5.0), tool(5.0, 1.0), tool(5.0, 0.0)] {
            let mut worst = [0.0_f64; 3];
            for (k, place) in places(case.surface.as_ref()).into_iter().enumerate() {
                let exact = case.surface.at(place);
                for &lean_deg in case.leans_deg {
                    let axis = leaning(exact.normal, lean_deg, 70.0 * k as f64);
                    let pose = touching(&tool, exact.point_mm, exact.normal, axis);
                    let found = contact_on_surface(&part, &tool, &pose, &mut Uncounted);
                    let Some(found) = found else { panic!("{} {k} {lean_deg}: no contact", case.name) };
                    assert!(!found.on_edge, "{} {k} {lean_deg} {}", case.name, found.gap_mm);
                    let normal_off = (found.normal - exact.normal).norm();
                    // the place follows from the normal: below the cutter's point of that normal, it is off by the
                    // cutter's width times what the normal is off, and by the gap
                    let width_mm =
                        tool.corner_radius().mm() + tool.core_radius().mm() / lean_deg.to_radians().sin();
                    let place_off_mm = found.place.point_mm + found.normal * found.gap_mm - exact.point_mm;
                    assert!(
                        place_off_mm.norm() <= SECOND_ORDER * width_mm * normal_off + FOLLOWED_MM,
                        "{} {k} {lean_deg}: {:e} {normal_off:e}",
                        case.name,
                        place_off_mm.norm()
                    );
                    worst[0] = worst[0].max(normal_off);
                    worst[1] = worst[1].max((found.place.point_mm - exact.point_mm).norm());
                    worst[2] = worst[2].max(found.gap_mm.abs());
                }
            }
            println!("{} {}: own {own_error:e}, {worst:?}", case.name, tool.corner_radius().mm());
            let bound = 3.0 * own_error + 1e-5;
            assert!(worst[0] < bound, "{}: {:e} {:e}", case.name, worst[0], own_error);
            assert!(worst[2] < 0.02, "{}: {:e}", case.name, worst[2]);
        }
    }
}

#[test]
fn a_cutter_above_or_inside_by_more_than_the_gap_does_not_touch() {
    let case = &cases()[0];
    let part = part(facets(case.surface.as_ref(), case.cells));
    let tool = tool(5.0, 1.0);
    for place in places(case.surface.as_ref()) {
        let exact = case.surface.at(place);
        let axis = leaning(exact.normal, 15.0, 40.0);
        for (height_mm, touches) in
            [(0.15, false), (0.05, true), (-0.05, true), (-0.15, false), (40.0, false)]
        {
            let pose = touching(&tool, exact.point_mm + exact.normal * height_mm, exact.normal, axis);
            let found = contact_on_surface(&part, &tool, &pose, &mut Uncounted);
            assert_eq!(found.is_some(), touches, "{height_mm}");
            if let Some(SurfaceContact { gap_mm, normal, .. }) = found {
                assert!((gap_mm - height_mm).abs() < 0.02, "{gap_mm} {height_mm}");
                assert!((normal - exact.normal).norm() < 1e-3);
            }
        }
    }
}

#[test]
fn on_a_real_edge_the_normal_is_the_cutters_own() {
    let part = part(cube(20.0));
    let ball = tool(5.0, 5.0);
    for lean_deg in [20.0, 45.0, 70.0_f64] {
        // the ball touches the edge x = 20, z = 20 in a direction between +X and +Z
        let (sin, cos) = lean_deg.to_radians().sin_cos();
        let normal = Vec3::new(sin, 0.0, cos);
        let edge_mm = Vec3::new(20.0, 7.0, 20.0);
        let pose = touching(&ball, edge_mm, normal, Vec3::z());
        let found = contact_on_surface(&part, &ball, &pose, &mut Uncounted).unwrap();
        assert!(found.on_edge && found.gap_mm.abs() < 1e-6, "{found:?}");
        assert!(
            (found.place.point_mm - edge_mm).norm() < 1e-5 && (found.normal - normal).norm() < 1e-5,
            "{found:?}"
        );
        assert_eq!(found.curvature_across_per_mm(&part.mesh, Vec3::y(), &mut Uncounted), None);
    }
    let flat = tool(5.0, 0.0);
    let pose = ToolPose { tip_mm: Vec3::new(8.0, 9.0, 20.01), axis: Vec3::z() };
    let found = contact_on_surface(&part, &flat, &pose, &mut Uncounted).unwrap();
    assert!((found.gap_mm - 0.01).abs() < 1e-12 && (found.normal - Vec3::z()).norm() < 1e-7, "{found:?}");
    // on the flank, and at no height but its own
    let pose = ToolPose { tip_mm: Vec3::new(25.02, 9.0, 8.0), axis: Vec3::z() };
    let found = contact_on_surface(&part, &flat, &pose, &mut Uncounted).unwrap();
    assert!((found.gap_mm - 0.02).abs() < 1e-9, "{found:?}");
    assert!((found.normal - Vec3::x()).norm() < 1e-7, "{found:?}");
}

#[test]
fn no_point_of_the_mesh_is_nearer_to_the_cutter_than_the_one_found() {
    /// A side is halved down to this [mm].
    const SETTLED_MM: f64 = 1e-6;
    let case = &cases()[3];
    let part = part(facets(case.surface.as_ref(), [24, 24]));
    let mesh = &part.mesh;
    for (radius_mm, corner_mm) in [(5.0, 5.0), (5.0, 1.0), (5.0, 0.0)] {
        let tool = tool(radius_mm, corner_mm);
        let body = CutterBody::with_default_length(&tool);
        for (k, place) in places(case.surface.as_ref()).into_iter().enumerate().take(40) {
            let exact = case.surface.at(place);
            let axis = leaning(exact.normal, 12.0, 50.0 * k as f64);
            let above_mm = exact.point_mm + exact.normal * 0.5;
            let pose = touching(&tool, above_mm, exact.normal, axis);
            let found = nearest_to_cutter(mesh, &body, &pose, 5.0, 0.0, &mut Uncounted).unwrap();
            let found_mm = body.distance_mm(&pose, found.point_mm);
            let mut least_mm = f64::INFINITY;
            for triangle in 0..u32::try_from(mesh.triangles()).unwrap() {
                for i in 0..=12 {
                    for j in 0..=12 - i {
                        let (a, b) = (f64::from(i) / 12.0, f64::from(j) / 12.0);
                        let at = mesh.at(triangle, [1.0 - a - b, a, b]).unwrap();
                        least_mm = least_mm.min(body.distance_mm(&pose, at.point_mm));
                    }
                }
            }
            assert!(found_mm <= least_mm + SETTLED_MM, "{corner_mm} {k}: {found_mm} {least_mm}");
        }
    }
}

/// Parameters all around a blade, but where its curvature jumps within what the measured one looks over: two facets to
/// either side, which are long along the blade and lie across the direction.
fn clear_of_joints(case: &Case) -> Vec<[f64; 2]> {
    let surface = case.surface.as_ref();
    let [_, [v0, v1]] = surface.domain();
    let cell = 1.0 / case.cells[0] as f64;
    (0..400)
        .map(|k| {
            let (a, b) = ((f64::from(k) * 0.618_033_988_7).fract(), (f64::from(k) * 0.754_877_666).fract());
            [a, v0 + (v1 - v0) * (0.15 + 0.7 * b)]
        })
        .filter(|&[u, v]| {
            let around = |u: f64| {
                let place = [u.rem_euclid(1.0), v];
                surface.curvature_per_mm(place, surface.derivatives(place).by_u)
            };
            let here = around(u);
            (-8..=8).all(|k| (around(u + 4.0 * cell * f64::from(k)) - here).abs() < 0.01)
        })
        .collect()
}

#[test]
fn the_curvature_across_the_feed_is_the_surfaces() {
    for case in cases() {
        let part = part(facets(case.surface.as_ref(), case.cells));
        let ball = tool(2.0, 2.0);
        let (mut worst, mut tightest) = (0.0_f64, 0.0_f64);
        let places =
            if case.name == "blade" { clear_of_joints(&case) } else { places(case.surface.as_ref()) };
        assert!(places.len() > 100, "{}: {}", case.name, places.len());
        for place in places {
            let exact = case.surface.at(place);
            let feed = leaning(exact.normal, 90.0, 25.0);
            let pose = touching(&ball, exact.point_mm, exact.normal, leaning(exact.normal, 20.0, 0.0));
            let found = contact_on_surface(&part, &ball, &pose, &mut Uncounted).unwrap();
            let across = case.surface.curvature_per_mm(place, exact.normal.cross(&feed));
            let off =
                (found.curvature_across_per_mm(&part.mesh, feed, &mut Uncounted).unwrap() - across).abs();
            worst = worst.max(off);
            tightest = tightest.max(across.abs());
        }
        println!("{}: {worst:e} of {tightest:e}", case.name);
        // of the tightest curvature met: an answer of 0 is off by all of it
        assert!(worst < 0.03 * tightest, "{}: {worst:e} {tightest:e}", case.name);
    }
}
