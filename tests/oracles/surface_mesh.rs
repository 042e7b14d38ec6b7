//! Meshes of surfaces that are known exactly: places, normals, curvatures; edges of solids.
#![expect(clippy::unwrap_used, reason = "a test may stop at what it did not expect")]

use trunnion::geometry::Vec3;
use trunnion::surface::{
    Blade, BladeSizes, Bulge, Cylinder, Mesh, MeshFault, ParametricSurface, Plane, Saddle, Sphere,
};

use crate::tessellation::{cube, facets};

/// Facets stand for the surface within this; wide, so that every facet of a coarse mesh is joined [mm].
const TOLERANCE_MM: f64 = 0.5;

fn mesh(surface: &dyn ParametricSurface, cells: [usize; 2]) -> Mesh {
    Mesh::from_facets(facets(surface, cells), TOLERANCE_MM).unwrap()
}

/// Parameters spread over the middle of a domain, away from its rim by a tenth.
fn inner_places(surface: &dyn ParametricSurface, count: u32) -> Vec<[f64; 2]> {
    let [[u0, u1], [v0, v1]] = surface.domain();
    (0..count)
        .map(|k| {
            let (a, b) = ((f64::from(k) * 0.618_033_988_7).fract(), (f64::from(k) * 0.754_877_666).fract());
            [u0 + (u1 - u0) * (0.1 + 0.8 * a), v0 + (v1 - v0) * (0.1 + 0.8 * b)]
        })
        .collect()
}

struct Kind {
    name: &'static str,
    surface: Box<dyn ParametricSurface>,
    cells: [usize; 2],
    /// Largest curvature there is [1/mm].
    curvature_per_mm: f64,
}

fn kinds() -> Vec<Kind> {
    let at = Vec3::new(2.0, -1.0, 3.0);
    let kind = |name, surface: Box<dyn ParametricSurface>, cells, radius_mm: f64| Kind {
        name,
        surface,
        cells,
        curvature_per_mm: 1.0 / radius_mm,
    };
    vec![
        kind("dome", Box::new(Sphere::new(at, 25.0, 0.8, Bulge::Convex).unwrap()), [40, 30], 25.0),
        kind("bowl", Box::new(Sphere::new(at, 25.0, 0.8, Bulge::Concave).unwrap()), [40, 30], 25.0),
        kind("ridge", Box::new(Cylinder::new(at, 12.0, 1.2, 30.0, Bulge::Convex).unwrap()), [40, 7], 12.0),
        kind("trough", Box::new(Cylinder::new(at, 12.0, 1.2, 30.0, Bulge::Concave).unwrap()), [40, 7], 12.0),
        kind("saddle", Box::new(Saddle::new(at, 30.0, 50.0, 40.0, 40.0).unwrap()), [30, 40], 30.0),
    ]
}

/// Largest errors of a mesh over inner places: of the normal [rad] and of the curvature [1/mm].
fn errors(kind: &Kind, cells: [usize; 2]) -> [f64; 2] {
    let mesh = mesh(kind.surface.as_ref(), cells);
    let mut worst = [0.0_f64; 2];
    for place in inner_places(kind.surface.as_ref(), 700) {
        let exact = kind.surface.at(place);
        let found = mesh.nearest(exact.point_mm, 1.0).unwrap();
        // at the same place of the surface: the facet is off along the normal only, to second order
        worst[0] = worst[0].max((found.normal - exact.normal).norm());
        for direction in [Vec3::new(1.0, 0.0, 0.2), Vec3::new(0.3, 0.8, 0.0), Vec3::new(-0.6, 0.7, 0.1)] {
            let exact = kind.surface.curvature_per_mm(place, direction);
            worst[1] = worst[1].max((mesh.curvature_per_mm(&found, direction) - exact).abs());
        }
    }
    worst
}

#[test]
fn normals_get_better_with_the_square_of_the_facets_and_curvatures_with_them() {
    for kind in kinds() {
        let [coarse, fine] = [1, 2].map(|times| errors(&kind, kind.cells.map(|cells| cells * times)));
        println!(
            "{}: normal {:e} {:e} curvature {:e} {:e}",
            kind.name, coarse[0], fine[0], coarse[1], fine[1]
        );
        // halving the facets quarters the error of normals; a third leaves room for where places fall in facets
        assert!(fine[0] < coarse[0] / 3.0, "{}: {} {}", kind.name, coarse[0], fine[0]);
        assert!(coarse[0] < 2e-3, "{}: {}", kind.name, coarse[0]);
        assert!(fine[1] < coarse[1] / 1.6, "{}: {} {}", kind.name, coarse[1], fine[1]);
        assert!(fine[1] < 0.02 * kind.curvature_per_mm, "{}: {}", kind.name, fine[1]);
    }
}

#[test]
fn the_nearest_place_is_the_foot_of_the_normal() {
    for kind in kinds() {
        let mesh = mesh(kind.surface.as_ref(), kind.cells.map(|cells| cells * 2));
        // half a facet's diagonal squared over 8 R, both ways [mm]
        let sag_mm = 0.02;
        for place in inner_places(kind.surface.as_ref(), 300) {
            let exact = kind.surface.at(place);
            for height_mm in [-4.0, -0.5, 0.3, 5.0] {
                let from_mm = exact.point_mm + exact.normal * height_mm;
                let found = mesh.nearest(from_mm, 6.0).unwrap();
                let distance_mm = (found.point_mm - from_mm).norm();
                assert!((distance_mm - f64::abs(height_mm)).abs() < sag_mm, "{}: {distance_mm}", kind.name);
                assert!((found.point_mm - exact.point_mm).norm() < 0.5, "{}", kind.name);
                assert!(mesh.nearest(from_mm, 0.99 * distance_mm).is_none());
            }
        }
    }
}

#[test]
fn the_boxes_find_what_looking_at_every_facet_finds() {
    let blade = Blade::new(Vec3::zeros(), BladeSizes::default()).unwrap();
    let mesh = mesh(&blade, [120, 20]);
    for k in 0..400 {
        let k = f64::from(k);
        let at_mm = Vec3::new(
            50.0 * (k * 0.618_033_988_7).fract() - 25.0,
            30.0 * (k * 0.754_877_666).fract() - 10.0,
            80.0 * (k * 0.569_840_291).fract() - 10.0,
        );
        let found_mm = (mesh.nearest(at_mm, 1e3).unwrap().point_mm - at_mm).norm();
        let mut least_mm = f64::INFINITY;
        for triangle in 0..u32::try_from(mesh.triangles()).unwrap() {
            least_mm = least_mm.min(distance_mm(mesh.corners_mm(triangle).unwrap(), at_mm));
        }
        assert!((found_mm - least_mm).abs() < 1e-12, "{found_mm} {least_mm}");
    }
}

/// The distance of a point from a triangle: over its inside where the foot is inside, else over its three sides.
fn distance_mm([a, b, c]: [Vec3; 3], p: Vec3) -> f64 {
    let normal = (b - a).cross(&(c - a)).normalize();
    let inside =
        [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (to - from).cross(&(p - from)).dot(&normal) >= 0.0);
    if inside {
        return (p - a).dot(&normal).abs();
    }
    [(a, b), (b, c), (c, a)]
        .iter()
        .map(|(from, to)| {
            let side = to - from;
            let t = ((p - from).dot(&side) / side.norm_squared()).clamp(0.0, 1.0);
            (from + side * t - p).norm()
        })
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn a_cube_keeps_its_edges() {
    let mesh = Mesh::from_facets(cube(20.0), 0.01).unwrap();
    let report = mesh.report();
    assert_eq!((report.triangles, report.vertices, report.sharp_edges), (12, 8, 12));
    assert_eq!((report.open_edges, report.non_manifold_edges, report.degenerate_facets), (0, 0, 0));
    assert!((report.volume_mm3.unwrap() - 8000.0).abs() < 1e-9 && (report.area_mm2 - 2400.0).abs() < 1e-9);
    assert_eq!((report.least_mm, report.largest_mm), (Vec3::zeros(), Vec3::repeat(20.0)));
    for triangle in 0..12 {
        for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.3, 0.5]] {
            let place = mesh.at(triangle, weights).unwrap();
            assert!((place.normal - place.facet_normal).norm() < 1e-7);
            assert!(mesh.curvature_per_mm(&place, Vec3::new(1.0, 2.0, 3.0)).abs() < 1e-7);
        }
    }
    let above = mesh.nearest(Vec3::new(5.0, 6.0, 23.0), 10.0).unwrap();
    assert!(
        (above.point_mm - Vec3::new(5.0, 6.0, 20.0)).norm() < 1e-12
            && (above.normal - Vec3::z()).norm() < 1e-7
    );
}

#[test]
fn a_fillet_is_smooth_and_the_plane_beside_it_stays_flat() {
    // a quarter of a cylinder of 2 mm in 12 facets, then a plane of 30 mm, tangential
    let arc = |k: usize| {
        let (sin, cos) = (k as f64 / 12.0 * std::f64::consts::FRAC_PI_2).sin_cos();
        (-2.0 * cos, 2.0 * sin - 2.0)
    };
    let mut profile: Vec<(f64, f64)> = (0..=12).map(arc).collect();
    profile.push((30.0, 0.0));
    let mut strip = Vec::new();
    for pair in profile.windows(2) {
        let corner = |(x, z): (f64, f64), y: f64| Vec3::new(x, y, z);
        let (a, b) = (corner(pair[0], 0.0), corner(pair[1], 0.0));
        let (c, d) = (corner(pair[1], 10.0), corner(pair[0], 10.0));
        strip.extend([[a, b, c], [a, c, d]]);
    }
    let mesh = Mesh::from_facets(strip, 0.01).unwrap();
    let on_plane = mesh.nearest(Vec3::new(0.01, 5.0, 1.0), 5.0).unwrap();
    assert!((on_plane.normal - Vec3::z()).norm() < 1e-7);
    // between the facets of the fillet the normal turns evenly: a facet is 7.5°, its normal alone is off by 3.75°
    let (sin, cos) = 40.0_f64.to_radians().sin_cos();
    let on_fillet = mesh.nearest(Vec3::new(-2.0 * cos, 5.0, 2.0 * sin - 2.0), 1.0).unwrap();
    assert!((on_fillet.normal - Vec3::new(-cos, 0.0, sin)).norm() < 2e-3, "{on_fillet:?}");
}

#[test]
fn facets_that_face_both_ways_are_refused() {
    let mut turned = cube(20.0);
    turned[3].swap(0, 1);
    let fault = Mesh::from_facets(turned, 0.01).unwrap_err();
    assert!(matches!(fault, MeshFault::ContraryEdges { edges: 3, .. }), "{fault}");
    let inward: Vec<_> = cube(20.0).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let fault = Mesh::from_facets(inward, 0.01).unwrap_err();
    assert!(
        matches!(fault, MeshFault::InsideOut { volume_mm3 } if (volume_mm3 + 8000.0).abs() < 1e-9),
        "{fault}"
    );
}

#[test]
fn rims_seams_and_slivers_are_counted() {
    let blade = Blade::new(Vec3::zeros(), BladeSizes::default()).unwrap();
    let report = *mesh(&blade, [120, 20]).report();
    // open at root and tip only: the profile closes
    assert_eq!((report.open_edges, report.non_manifold_edges, report.triangles), (240, 0, 4800));
    assert_eq!(report.vertices, 120 * 21);
    let mut three = facets(&Plane::new(Vec3::zeros(), 10.0, 10.0).unwrap(), [1, 1]);
    let [a, _, c] = three[0];
    three.push([a, c, Vec3::new(0.0, 0.0, 9.0)]);
    three.push([a, a, c]);
    three.push([a, c, (a + c) * 0.5 + Vec3::new(0.0, 0.0, 1e-7)]);
    let report = *Mesh::from_facets(three, 0.01).unwrap().report();
    assert_eq!((report.non_manifold_edges, report.degenerate_facets, report.facets), (1, 2, 5));
    assert!(matches!(Mesh::from_facets([[a, a, c]], 0.01), Err(MeshFault::NoFacets { degenerate: 1 })));
}

#[test]
fn samples_are_even_whatever_the_facets() {
    // facets of very different sizes: a plane whose first column is a thousand times finer
    let wide = Plane::new(Vec3::zeros(), 20.0, 10.0).unwrap();
    let fine = Plane::new(Vec3::new(10.05, 0.0, 0.0), 0.1, 10.0).unwrap();
    let mut all = facets(&wide, [3, 2]);
    all.extend(facets(&fine, [20, 200]));
    let mesh = Mesh::from_facets(all, 0.01).unwrap();
    let samples = mesh.samples(2000);
    assert_eq!(samples.points.len(), 2000);
    assert_eq!(samples, mesh.samples(2000));
    assert!(
        (samples.area_mm2 - 201.0).abs() < 1e-9 && (samples.spacing_mm - (0.1005_f64).sqrt()).abs() < 1e-9
    );
    // a tenth of the plane holds a tenth of the points, and no place is far from one
    for k in 0..10 {
        let from = f64::from(k) * 2.0 - 10.0;
        let inside = samples.points.iter().filter(|p| (from..from + 2.0).contains(&p.point_mm.x)).count();
        assert!(inside.abs_diff(199) <= 20, "{k}: {inside}");
    }
    for k in 0..500 {
        let k = f64::from(k);
        let at_mm = Vec3::new(
            20.0 * (k * 0.618_033_988_7).fract() - 10.0,
            10.0 * (k * 0.754_877_666).fract() - 5.0,
            0.0,
        );
        let nearest_mm =
            samples.points.iter().map(|p| (p.point_mm - at_mm).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest_mm < 2.0 * samples.spacing_mm, "{nearest_mm}");
    }
    assert!(samples.points.iter().all(|p| (p.normal - Vec3::z()).norm() < 1e-7));
}
