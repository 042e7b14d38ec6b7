//! Reading a mesh of ten million facets, and asking it: `cargo bench --bench surface` (facets of a closed surface), or
//! `-- soup` (no two facets share a corner, the most memory a file can take). One thread.

use std::hint::black_box;
use std::io::Read;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use trunnion::contact::{CutterContact, PartSurface, contact_on_surface};
use trunnion::geometry::Vec3;
use trunnion::kinematics::ToolPose;
use trunnion::machine::Tool;
use trunnion::surface::{Bulge, Mesh, MeshSettings, ParametricSurface, Sphere, Uncounted};
use trunnion::units::Length;

const CELLS: [usize; 2] = [2500, 2000];
const QUERIES: u32 = 20_000;
const CONTACTS: u32 = 5_000;

/// A binary file that is made while it is read.
struct Facets {
    surface: Sphere,
    soup: bool,
    next: usize,
    ready: Vec<u8>,
    given: usize,
}

impl Facets {
    fn new(surface: Sphere, soup: bool) -> Self {
        let mut ready = vec![b' '; 80];
        ready.extend(u32::try_from(2 * CELLS[0] * CELLS[1]).unwrap_or(0).to_le_bytes());
        Self { surface, soup, next: 0, ready, given: 0 }
    }

    fn make(&mut self) {
        self.ready.clear();
        self.given = 0;
        let [columns, rows] = CELLS;
        if self.next == columns * rows {
            return;
        }
        let (i, j) = (self.next % columns, self.next / columns);
        let [[u0, u1], [v0, v1]] = self.surface.domain();
        let corner = |i: usize, j: usize| {
            let (a, b) = (i as f64 / columns as f64, j as f64 / rows as f64);
            self.surface.at([u0 + (u1 - u0) * a, v0 + (v1 - v0) * b]).point_mm
        };
        let (a, b, c, d) = (corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
        for mut facet in [[a, b, c], [a, c, d]] {
            if self.soup {
                let middle = (facet[0] + facet[1] + facet[2]) / 3.0;
                facet = facet.map(|corner| middle + (corner - middle) * 0.9);
            }
            for vector in std::iter::once(&Vec3::zeros()).chain(&facet) {
                #[expect(clippy::cast_possible_truncation, reason = "the file is single precision")]
                for x in vector.iter() {
                    self.ready.extend((*x as f32).to_le_bytes());
                }
            }
            self.ready.extend([0, 0]);
        }
        self.next += 1;
    }
}

impl Read for Facets {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let mut filled = 0;
        while filled < buffer.len() {
            if self.given == self.ready.len() {
                self.make();
                if self.ready.is_empty() {
                    break;
                }
            }
            let count = (self.ready.len() - self.given).min(buffer.len() - filled);
            buffer[filled..filled + count].copy_from_slice(&self.ready[self.given..self.given + count]);
            self.given += count;
            filled += count;
        }
        Ok(filled)
    }
}

fn peak_memory_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM"));
    let kib = line.and_then(|line| line.split_whitespace().nth(1)).and_then(|kib| kib.parse::<f64>().ok());
    kib.unwrap_or(f64::NAN) / 1024.0
}

#[expect(clippy::print_stdout, reason = "figures are what a benchmark is for")]
fn main() {
    let soup = std::env::args().any(|word| word == "soup");
    let Ok(surface) = Sphere::new(Vec3::zeros(), 100.0, 1.2, Bulge::Convex) else { return };
    let start = Instant::now();
    let mut file = Facets::new(surface, soup);
    let mut window = vec![0; 1 << 16];
    while matches!(file.read(&mut window), Ok(1..)) {}
    let making_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let file = Facets::new(surface, soup);
    let mesh = match Mesh::read_stl(file, &MeshSettings::default(), &|| ControlFlow::Continue(())) {
        Ok(mesh) => mesh,
        Err(fault) => {
            println!("{fault}");
            return;
        }
    };
    let read_s = start.elapsed().as_secs_f64() - making_s;
    let facets = mesh.report().facets;
    println!("{facets} facets, {} vertices: {read_s:.2} s", mesh.report().vertices);
    println!(
        "peak {:.0} MiB, {:.0} bytes a facet; estimate {} MiB",
        peak_memory_mib(),
        peak_memory_mib() * 1_048_576.0 / facets as f64,
        Mesh::memory_estimate_bytes(facets) >> 20
    );
    for height_mm in [0.01, 1.0] {
        let start = Instant::now();
        let mut sum = 0.0;
        for k in 0..QUERIES {
            let place =
                [0.618_033_988_7, 0.754_877_666].map(|step| 2.0 * (f64::from(k) * step).fract() - 1.0);
            let exact = surface.at(place);
            let from_mm = exact.point_mm + exact.normal * height_mm;
            sum += mesh.nearest(from_mm, 20.0).map_or(0.0, |found| found.normal.dot(&exact.normal));
        }
        let rate = f64::from(QUERIES) / start.elapsed().as_secs_f64() * 1e-6;
        println!(
            "nearest from {height_mm} mm, places at random: {rate:.2} M/s (normals {:e})",
            1.0 - black_box(sum) / f64::from(QUERIES)
        );
    }
    let part = PartSurface { mesh: Arc::new(mesh), contact_gap: PartSurface::DEFAULT_CONTACT_GAP };
    for (radius_mm, corner_mm) in [(5.0, 5.0), (5.0, 1.0), (5.0, 0.0)] {
        let Ok(tool) = Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_mm)) else { return };
        let start = Instant::now();
        let mut touching = 0;
        for k in 0..CONTACTS {
            let place =
                [0.618_033_988_7, 0.754_877_666].map(|step| 2.0 * (f64::from(k) * step).fract() - 1.0);
            let exact = surface.at(place);
            let aside = exact.normal.cross(&Vec3::new(0.3, 0.5, 0.8)).normalize();
            let axis = (exact.normal + aside * 0.1).normalize();
            let contact = CutterContact::Normal { direction: exact.normal, magnitude: 1.0 };
            let pose = ToolPose { tip_mm: exact.point_mm - contact.offset_mm(&tool, axis), axis };
            touching += u32::from(contact_on_surface(&part, &tool, &pose, &mut Uncounted).is_some());
        }
        let rate = f64::from(CONTACTS) / start.elapsed().as_secs_f64() * 1e-3;
        println!(
            "contacts of a cutter {radius_mm}/{corner_mm}, leading by 6°: {rate:.1} k/s ({touching} of {CONTACTS})"
        );
    }
    let mesh = &part.mesh;
    let start = Instant::now();
    let samples = black_box(mesh.samples(1_000_000));
    println!("1 M samples {:.4} mm apart: {:.2} s", samples.spacing_mm, start.elapsed().as_secs_f64());
}
