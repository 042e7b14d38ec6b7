use super::*;
use crate::geometry::{RigidMotion, Vec3, rotation_from_vector};

/// One surface of each kind, the curved ones in both directions.
fn surfaces() -> Vec<Box<dyn ParametricSurface>> {
    let at = Vec3::new(3.0, -4.0, 5.0);
    let turned = RigidMotion { rotation: rotation_from_vector(Vec3::new(0.4, 1.1, -0.3)), shift_mm: at };
    let blade = Blade::new(at, BladeSizes::default()).unwrap();
    vec![
        Box::new(Plane::new(at, 40.0, 20.0).unwrap()),
        Box::new(Sphere::new(at, 25.0, 1.0, Bulge::Convex).unwrap()),
        Box::new(Sphere::new(at, 25.0, 1.0, Bulge::Concave).unwrap()),
        Box::new(Cylinder::new(at, 12.0, 1.2, 30.0, Bulge::Convex).unwrap()),
        Box::new(Cylinder::new(at, 12.0, 1.2, 30.0, Bulge::Concave).unwrap()),
        Box::new(Saddle::new(at, 30.0, 50.0, 40.0, 40.0).unwrap()),
        Box::new(blade),
        Box::new(Placed { surface: blade, motion: turned }),
    ]
}

/// Parameters inside a domain, away from any joint.
fn places(surface: &dyn ParametricSurface) -> Vec<[f64; 2]> {
    let [[u0, u1], [v0, v1]] = surface.domain();
    (0..400)
        .map(|k| {
            let k = f64::from(k);
            let (a, b) = ((0.01 + k * 0.618_033_988_7).fract(), (0.02 + k * 0.754_877_666).fract());
            [u0 + (u1 - u0) * a, v0 + (v1 - v0) * b]
        })
        .collect()
}

#[test]
fn derivatives_are_those_of_differences() {
    /// Central differences of step h have an error of h²/6 times the third derivative; blade edges have up to 1e5
    /// mm each.
    const SHARE: f64 = 2e-5;
    for (kind, surface) in surfaces().iter().enumerate() {
        let domain = surface.domain();
        let step = domain.map(|[from, to]| (to - from) * 1e-6);
        for [u, v] in places(surface.as_ref()) {
            let found = surface.derivatives([u, v]);
            let [du, dv] = step;
            let (next_u, last_u) = (surface.derivatives([u + du, v]), surface.derivatives([u - du, v]));
            let (next_v, last_v) = (surface.derivatives([u, v + dv]), surface.derivatives([u, v - dv]));
            let pairs = [
                (found.by_u, (next_u.point_mm - last_u.point_mm) / (2.0 * du)),
                (found.by_v, (next_v.point_mm - last_v.point_mm) / (2.0 * dv)),
                (found.by_uu, (next_u.by_u - last_u.by_u) / (2.0 * du)),
                (found.by_uv, (next_v.by_u - last_v.by_u) / (2.0 * dv)),
                (found.by_vv, (next_v.by_v - last_v.by_v) / (2.0 * dv)),
            ];
            for (index, (exact, difference)) in pairs.into_iter().enumerate() {
                let error = (exact - difference).norm();
                assert!(error <= SHARE * (1.0 + exact.norm()), "{kind} {index} at {u} {v}: {error}");
            }
        }
    }
}

#[test]
fn curvatures_are_the_closed_forms() {
    /// Rounding of a handful of operations on curvatures up to 1/12 mm [1/mm].
    const ROUNDING_PER_MM: f64 = 1e-14;
    let at = Vec3::zeros();
    let close = |found: f64, closed: f64| {
        assert!((found - closed).abs() < ROUNDING_PER_MM, "{found} {closed}");
    };
    for (bulge, k) in [(Bulge::Convex, 1.0), (Bulge::Concave, -1.0)] {
        let sphere = Sphere::new(at, 25.0, 1.0, bulge).unwrap();
        for place in places(&sphere) {
            close(sphere.curvature_per_mm(place, Vec3::new(0.3, 0.5, -0.2)), k / 25.0);
            // the normal is the radius
            let found = sphere.at(place);
            assert!((found.normal - found.point_mm * (k / 25.0)).norm() < ROUNDING_PER_MM);
        }
        let cylinder = Cylinder::new(at, 12.0, 1.2, 30.0, bulge).unwrap();
        for place in places(&cylinder) {
            close(cylinder.curvature_per_mm(place, Vec3::y()), 0.0);
            let around = cylinder.derivatives(place).by_u.normalize();
            close(cylinder.curvature_per_mm(place, around), k / 12.0);
            // Euler: at 30° to the axis a quarter
            let slanted = around * 0.5 + Vec3::y() * 0.75_f64.sqrt();
            close(cylinder.curvature_per_mm(place, slanted), 0.25 * k / 12.0);
        }
    }
    let saddle = Saddle::new(at, 30.0, 50.0, 40.0, 40.0).unwrap();
    close(saddle.curvature_per_mm([0.0, 0.0], Vec3::x()), 1.0 / 30.0);
    close(saddle.curvature_per_mm([0.0, 0.0], Vec3::y()), -1.0 / 50.0);
    // z = −x²/2a: curvature (1/a)/(1 + x²/a²)^1.5.
    close(saddle.curvature_per_mm([15.0, 0.0], Vec3::x()), 1.0 / 30.0 / 1.25_f64.powf(1.5));
    close(saddle.curvature_per_mm([0.0, 0.0], Vec3::z()), 0.0);
}

#[test]
fn normals_point_out_of_the_part() {
    for surface in surfaces().iter().take(6) {
        for place in places(surface.as_ref()) {
            assert!(surface.at(place).normal.z > 0.0);
        }
    }
    // A blade's normals point away from the middle of its camber line near that line.
    let blade =
        Blade::new(Vec3::zeros(), BladeSizes { camber_rad: 0.0, twist_rad: 0.0, ..BladeSizes::default() })
            .unwrap();
    for place in places(&blade) {
        let found = blade.at(place);
        assert!(found.normal.y * found.point_mm.y > 0.0 || found.point_mm.x.abs() > 20.0, "{found:?}");
    }
}

#[test]
fn samples_are_even_in_area_and_always_the_same() {
    const COUNT: usize = 4000;
    let at = Vec3::zeros();
    let sphere = Sphere::new(at, 25.0, 1.0, Bulge::Convex).unwrap();
    let samples = sphere.samples(COUNT);
    assert_eq!(samples.points.len(), COUNT);
    assert_eq!(samples, sphere.samples(COUNT));
    // The area of the patch, ∫∫ R² cos v; midpoints of 128 cells have an error of 1e-5 of it.
    let area_mm2 = 25.0_f64.powi(2) * 2.0 * 2.0 * 1.0_f64.sin();
    assert!((samples.area_mm2 / area_mm2 - 1.0).abs() < 2e-5, "{}", samples.area_mm2);
    assert!((samples.spacing_mm - (samples.area_mm2 / 4000.0).sqrt()).abs() < 1e-12);
    // Each tenth of the area, by latitude, has a tenth of the points, except for the ends of two rows.
    for k in 0..10 {
        let band = [f64::from(k), f64::from(k + 1)].map(|edge| 25.0 * 1.0_f64.sin() * (0.2 * edge - 1.0));
        let inside = samples.points.iter().filter(|p| (band[0]..band[1]).contains(&p.point_mm.y)).count();
        assert!(inside.abs_diff(COUNT / 10) <= 16, "{k}: {inside}");
    }
    for surface in surfaces() {
        let samples = surface.samples(COUNT);
        assert_eq!(samples.points.len(), COUNT);
        // No point of the surface is farther from the next sample than two spacings.
        for place in places(surface.as_ref()) {
            let place_mm = surface.at(place).point_mm;
            let nearest_mm =
                samples.points.iter().map(|p| (p.point_mm - place_mm).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest_mm < 2.0 * samples.spacing_mm, "{nearest_mm} {}", samples.spacing_mm);
        }
        assert_eq!(surface.samples(0).points.len(), 0);
        assert_eq!(surface.samples(1).points.len(), 1);
    }
}

#[test]
fn every_bad_size_is_named() {
    assert_eq!(Plane::new(Vec3::new(f64::NAN, 0.0, 1e9), 0.0, -1.0).unwrap_err().len(), 4);
    assert_eq!(Sphere::new(Vec3::zeros(), 0.0, 1.6, Bulge::Convex).unwrap_err().len(), 2);
    assert_eq!(Cylinder::new(Vec3::zeros(), 1e9, 3.2, 0.0, Bulge::Convex).unwrap_err().len(), 3);
    assert_eq!(Saddle::new(Vec3::zeros(), 0.0, f64::INFINITY, 1.0, 1.0).unwrap_err().len(), 2);
}

/// Counts how often it is evaluated.
struct Counted<S>(S, std::cell::Cell<usize>);

impl<S: ParametricSurface> ParametricSurface for Counted<S> {
    fn domain(&self) -> [[f64; 2]; 2] {
        self.0.domain()
    }

    fn derivatives(&self, parameters: [f64; 2]) -> SurfaceDerivatives {
        self.1.set(self.1.get() + 1);
        self.0.derivatives(parameters)
    }
}

#[test]
fn a_narrow_strip_is_sampled_evenly_and_for_what_its_points_cost() {
    const COUNT: usize = 40_000;
    const LENGTH_MM: f64 = 10_000.0;
    const BANDS: i32 = 400;
    /// Each row measures its cells twice and has at least four points.
    const MOST_EVALUATIONS: usize = COUNT * (2 * 128 / 4 + 1) + 128 * 128;
    for width_mm in [0.001, 0.5] {
        let strip = Counted(Plane::new(Vec3::zeros(), width_mm, LENGTH_MM).unwrap(), std::cell::Cell::new(0));
        let samples = strip.samples(COUNT);
        assert_eq!(samples.points.len(), COUNT);
        assert!(strip.1.get() <= MOST_EVALUATIONS, "{width_mm} mm: {} evaluations", strip.1.get());
        let mut along: Vec<f64> = samples.points.iter().map(|sample| sample.point_mm.y).collect();
        along.sort_by(f64::total_cmp);
        let below =
            |end: i32| along.partition_point(|y| *y < (f64::from(end) / f64::from(BANDS) - 0.5) * LENGTH_MM);
        let bands: Vec<usize> = (0..BANDS).map(|band| below(band + 1) - below(band)).collect();
        // A row belongs to one band or is shared by two.
        assert!(bands.iter().all(|points| (92..=108).contains(points)), "{width_mm} mm: {bands:?}");
    }
}
