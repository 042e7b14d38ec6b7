//! Facets made so that a search on them looks at as many as it can.

use trunnion::geometry::Vec3;

/// A kind of facets, and so many of them, all around the origin.
pub type Family = (&'static str, fn(u32) -> Vec<[Vec3; 3]>);

/// All kinds.
pub const FAMILIES: &[Family] =
    &[("equal", equal), ("stacked", stacked), ("huge", huge), ("needles", needles), ("terraces", terraces)];

const LEANING: [Vec3; 3] =
    [Vec3::new(-10.0, -10.0, -1.0), Vec3::new(10.0, -10.0, 0.5), Vec3::new(0.0, 10.0, 1.0)];

/// The same facet again and again: no box tells one from another.
pub fn equal(count: u32) -> Vec<[Vec3; 3]> {
    vec![LEANING; count as usize]
}

/// Facets a millionth of a millimetre above each other: no two are equal.
pub fn stacked(count: u32) -> Vec<[Vec3; 3]> {
    let raised = |k: u32| Vec3::z() * (f64::from(k * 7919 % count) * 1e-6);
    (0..count).map(|k| LEANING.map(|corner| corner + raised(k))).collect()
}

/// Facets of 100 m that all pass by the origin: every box holds every place.
pub fn huge(count: u32) -> Vec<[Vec3; 3]> {
    let turned = |k: u32| {
        let (sin, cos) = (f64::from(k) * 2.399_963).sin_cos();
        let lean = 1e-3 * f64::from(k % 101 + 1);
        [[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]].map(|[x, y]| {
            let (x, y) = (9e4 * (cos * x - sin * y), 9e4 * (sin * x + cos * y));
            Vec3::new(x, y, lean * (x + 0.5 * y) / 10.0)
        })
    };
    (0..count).map(turned).collect()
}

/// Facets 100 mm long and some hundredths of a millimetre wide, all through the same place.
pub fn needles(count: u32) -> Vec<[Vec3; 3]> {
    let turned = |k: u32| {
        let (sin, cos) = (f64::from(k) * 2.399_963).sin_cos();
        let (along, aside) = (Vec3::new(cos, sin, 0.02 * cos), Vec3::new(-sin, cos, 0.0));
        [along * -50.0, along * 50.0, aside * 0.05]
    };
    (0..count).map(turned).collect()
}

/// Facets that come nearer and nearer to a cutter above them in the order in which their boxes are opened: the larger a
/// facet, the lower its middle.
pub fn terraces(count: u32) -> Vec<[Vec3; 3]> {
    let step = |k: u32| {
        let (size, height) = (20.0 - 10.0 * f64::from(k) / f64::from(count), 1e-6 * f64::from(k));
        [[-1.0, -1.0, -0.1], [1.0, -1.0, 0.05], [0.0, 1.0, 0.05]]
            .map(|[x, y, z]| Vec3::new(size * x, size * y, size * z + height))
    };
    (0..count).map(step).collect()
}
