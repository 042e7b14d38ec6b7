//! Facets of surfaces that are known exactly, and the files that hold them.
#![expect(
    unreachable_pub,
    clippy::unwrap_used,
    reason = "one model for several binaries; it stops at what it did not expect"
)]

use trunnion::geometry::Vec3;
use trunnion::surface::ParametricSurface;

/// Two facets for each of so many cells of the domain, corners on the surface; a surface that closes upon itself
/// along u is closed.
pub fn facets(surface: &dyn ParametricSurface, [columns, rows]: [usize; 2]) -> Vec<[Vec3; 3]> {
    let [[u0, u1], [v0, v1]] = surface.domain();
    let closes = (surface.at([u0, v0]).point_mm - surface.at([u1, v0]).point_mm).norm() < 1e-9;
    let corner = |i: usize, j: usize| {
        let i = if closes { i % columns } else { i };
        let u = u0 + (u1 - u0) * i as f64 / columns as f64;
        surface.at([u, v0 + (v1 - v0) * j as f64 / rows as f64]).point_mm
    };
    let mut facets = Vec::with_capacity(2 * columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let (a, b) = (corner(i, j), corner(i + 1, j));
            let (c, d) = (corner(i + 1, j + 1), corner(i, j + 1));
            facets.push([a, b, c]);
            facets.push([a, c, d]);
        }
    }
    facets
}

/// As [`facets`], but corners stand up to 0.3 cells off their places, and cells are halved either way.
pub fn uneven_facets(surface: &dyn ParametricSurface, [columns, rows]: [usize; 2]) -> Vec<[Vec3; 3]> {
    let [[u0, u1], [v0, v1]] = surface.domain();
    let chance = |i: usize, j: usize, k: usize| {
        let mixed = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (j as u64 + 7).wrapping_mul(0xd1b5_4a32_d192_ed03);
        let mixed = (mixed ^ (mixed >> 29) ^ k as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let corner = |i: usize, j: usize| {
        let (a, b) = (i as f64 + 0.6 * chance(i, j, 1) - 0.3, j as f64 + 0.6 * chance(i, j, 2) - 0.3);
        surface.at([u0 + (u1 - u0) * a / columns as f64, v0 + (v1 - v0) * b / rows as f64]).point_mm
    };
    let mut facets = Vec::with_capacity(2 * columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let (a, b, c, d) = (corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
            if chance(i, j, 3) < 0.5 {
                facets.extend([[a, b, c], [a, c, d]]);
            } else {
                facets.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    facets
}

/// The twelve facets of a cube from the origin.
pub fn cube(side_mm: f64) -> Vec<[Vec3; 3]> {
    let corner = |k: usize| {
        let at = |bit: usize| if k >> bit & 1 == 1 { side_mm } else { 0.0 };
        Vec3::new(at(0), at(1), at(2))
    };
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|facet| facet.map(corner)).collect()
}

fn normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)).normalize()
}

/// A binary file whose header begins with these bytes.
pub fn binary_stl(facets: &[[Vec3; 3]], header: &str) -> Vec<u8> {
    let mut file = vec![b' '; 80];
    file[..header.len()].copy_from_slice(header.as_bytes());
    file.extend(u32::try_from(facets.len()).unwrap().to_le_bytes());
    for facet in facets {
        for vector in std::iter::once(&normal(facet)).chain(facet) {
            #[expect(clippy::cast_possible_truncation, reason = "the file is single precision")]
            for x in vector.iter() {
                file.extend((*x as f32).to_le_bytes());
            }
        }
        file.extend([0, 0]);
    }
    file
}

/// A text file, every number with all its digits.
pub fn text_stl(facets: &[[Vec3; 3]]) -> String {
    use std::fmt::Write;
    let mut file = String::from("solid part one\n");
    for facet in facets {
        let n = normal(facet);
        writeln!(file, "  facet normal {:e} {:e} {:e}\n    outer loop", n.x, n.y, n.z).unwrap();
        for p in facet {
            writeln!(file, "      vertex {:e} {:e} {:e}", p.x, p.y, p.z).unwrap();
        }
        file.push_str("    endloop\n  endfacet\n");
    }
    file.push_str("endsolid part one\n");
    file
}
