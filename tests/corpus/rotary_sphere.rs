//! A rotary table's axis from five probed sphere centres, as its owner's own program fitted it (data/INDEX.md).

use trunnion::calibration::rotary_sphere::{ExpectedAxis, fit_circle};
use trunnion::geometry::{Screw, Vec3};
use trunnion::machine::Side;

use crate::shared_file;

/// Half a unit of the sixth decimal [mm, and of a unit vector].
const PRINTED: f64 = 0.5e-6 + 1e-12;
/// Residuals as told beside the data, to a tenth of a micrometre [mm].
const TOLD_MM: f64 = 0.05e-3;

/// The numbers of a line, signs kept.
fn numbers(line: &str) -> Vec<f64> {
    line.split(|c: char| c.is_whitespace() || c == '=')
        .filter_map(|word| word.replace(',', ".").parse().ok())
        .collect()
}

#[test]
fn a_real_tables_axis_is_that_of_its_owners_fit() {
    let (Some(points), Some(fit)) = (
        shared_file("data/dmu50_table_axis_sphere_points.txt"),
        shared_file("data/dmu50_table_axis_fit.txt"),
    ) else {
        return;
    };
    let points = std::fs::read_to_string(points).unwrap();
    // the first line is the datum
    let centers: Vec<Vec3> = points
        .lines()
        .skip(1)
        .map(numbers)
        .filter(|p| p.len() == 3)
        .map(|p| Vec3::new(p[0], p[1], p[2]))
        .collect();
    assert_eq!(centers.len(), 5);
    let record = std::fs::read_to_string(fit).unwrap();
    let told = |start: &str| numbers(record.lines().find(|line| line.starts_with(start)).unwrap());
    let line = Screw { direction: Vec3::z(), point_mm: Vec3::zeros() };
    let found = fit_circle(&centers, &ExpectedAxis { line, side: Side::Table }).unwrap();
    let ball = found.balls[0];
    for (value, told) in found.line.direction.iter().zip(told("normal")) {
        assert!((value - told).abs() <= PRINTED, "{value} {told}");
    }
    for (value, told) in ball.center_mm.iter().zip(told("center of circle")) {
        assert!((value - told).abs() <= PRINTED, "{value} {told}");
    }
    assert!((ball.radius_mm - told("R")[0]).abs() <= PRINTED, "{}", ball.radius_mm);
    let largest = |of: fn(&trunnion::calibration::rotary_sphere::Residual) -> f64| {
        found.residuals.iter().map(|r| of(r).abs()).fold(0.0, f64::max)
    };
    assert!((largest(|r| r.axial_mm) - 6.7e-3).abs() < TOLD_MM, "{}", largest(|r| r.axial_mm));
    assert!((largest(|r| r.radial_mm) - 2.0e-3).abs() < TOLD_MM, "{}", largest(|r| r.radial_mm));
    assert!(found.outliers.is_empty());
    assert_eq!(found.degrees_of_freedom, 2);
}
