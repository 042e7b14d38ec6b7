use super::*;

fn blade(change: impl Fn(&mut BladeSizes)) -> Result<Blade, Vec<SurfaceFault>> {
    let mut sizes = BladeSizes::default();
    change(&mut sizes);
    Blade::new(Vec3::new(5.0, -3.0, 2.0), sizes)
}

#[test]
fn normals_are_continuous_all_around() {
    /// A parameter step of 1e-12 turns the normal of an edge by less than this [1].
    const CONTINUOUS: f64 = 1e-9;
    let blade = blade(|_| {}).unwrap();
    let mut joints = blade.profile.joints().to_vec();
    joints.push(1.0);
    for v in [0.0, 21.0, 60.0] {
        for &u in &joints {
            let (before, after) = (blade.at([u - 1e-12, v]), blade.at([(u + 1e-12) % 1.0, v]));
            assert!((before.normal - after.normal).norm() < CONTINUOUS, "{u}");
            assert!((before.point_mm - after.point_mm).norm() < CONTINUOUS, "{u}");
        }
    }
}

#[test]
fn the_blade_is_as_thick_as_asked_and_its_edges_as_round() {
    /// Rounding of lengths up to 100 mm [mm].
    const ROUNDING_MM: f64 = 1e-12;
    let blade = blade(|sizes| sizes.twist_rad = 0.0).unwrap();
    let [a, b, c] = blade.profile.joints();
    for (u, radius_mm) in [(0.5 * (a + b), 0.65), (0.5 * (c + 1.0), 0.35)] {
        let across = blade.curvature_per_mm([u, 10.0], blade.derivatives([u, 10.0]).by_u);
        assert!((1.0 / across - radius_mm).abs() < ROUNDING_MM, "{across}");
        assert!(blade.curvature_per_mm([u, 10.0], Vec3::z()).abs() < ROUNDING_MM);
    }
    // Equal distances along the camber line on both sides lie across the same circle: the largest width is the
    // thickness.
    let widest = (0..=100_000)
        .map(|k| f64::from(k) / 100_000.0)
        .map(|t| {
            let (upper, lower) = (blade.at([a * (1.0 - t), 0.0]), blade.at([b + (c - b) * t, 0.0]));
            let centre_to_upper = upper.point_mm - lower.point_mm;
            centre_to_upper.dot(&upper.normal) / (1.0 - upper.normal.dot(&lower.normal))
        })
        .fold(0.0, f64::max);
    assert!((2.0 * widest - 3.8).abs() < 1e-8, "{widest}");
}

#[test]
fn every_unmakeable_size_is_named() {
    let faults = |change: fn(&mut BladeSizes)| blade(change).unwrap_err();
    assert!(matches!(
        faults(|sizes| {
            sizes.span_mm = f64::NAN;
            sizes.twist_rad = 2.0;
            sizes.leading_radius_mm = 2.0;
        })[..],
        [
            SurfaceFault::Length { quantity: SurfaceQuantity::Span, .. },
            SurfaceFault::Angle { quantity: SurfaceQuantity::Twist, .. },
            SurfaceFault::EdgeTooThick { radius_mm: 2.0, max_mm: 1.9, .. },
        ]
    ));
    assert!(matches!(faults(|sizes| sizes.camber_length_mm = 4.0)[..], [SurfaceFault::TooSteep { .. }]));
    assert!(matches!(
        faults(|sizes| {
            sizes.camber_length_mm = 20.0;
            sizes.thickness_mm = 30.0;
            sizes.leading_radius_mm = 15.0;
            sizes.trailing_radius_mm = 15.0;
            sizes.camber_rad = 1.5;
        })[..],
        [SurfaceFault::CamberTooTight { .. }]
    ));
}
