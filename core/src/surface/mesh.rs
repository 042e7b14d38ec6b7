//! A part's surface as a mesh of facets.

use std::cell::Cell;
use std::fmt;
use std::io::{self, Read};
use std::ops::ControlFlow;

use super::asking::Asking;
use super::smoothing::{Edges, smooth};
use super::stl::StlReader;
use super::tree::Tree;
use super::weld::Weld;
use super::{MAX_FACETS, MeshFault, MeshParameter, StlFault};
use crate::geometry::Vec3;

/// Settings for making a mesh from a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshSettings {
    /// Millimetres in a unit of the file: 1, or 25.4 for inches.
    pub mm_per_unit: f64,
    /// Largest distance between the facets and the true surface \[mm\]. If a smooth surface across an edge would
    /// have to be farther away, the part has a real edge, and normals are not smoothed.
    pub chordal_tolerance_mm: f64,
    /// A file with more facets is refused; never more than [`MAX_FACETS`].
    pub max_facets: u64,
}

impl Default for MeshSettings {
    fn default() -> Self {
        Self { mm_per_unit: 1.0, chordal_tolerance_mm: 0.01, max_facets: u64::from(MAX_FACETS) }
    }
}

/// The facts found in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshReport {
    /// Facets in the file.
    pub facets: u64,
    /// Facets of the mesh.
    pub triangles: u64,
    /// Different corners of the facets with an area in the file.
    pub vertices: u64,
    /// Facets dropped because they are too thin for single precision: height below 2⁻²² of the largest coordinate.
    pub degenerate_facets: u64,
    /// Facets whose stated normal points against their winding. The winding is used.
    pub contradicting_normals: u64,
    /// Edges of one facet only: the rim of an open surface, or a gap.
    pub open_edges: u64,
    /// Edges of more than two facets.
    pub non_manifold_edges: u64,
    /// Edges across which the surface is not smooth.
    pub sharp_edges: u64,
    /// Area \[mm²\].
    pub area_mm2: f64,
    /// Enclosed volume \[mm³\] of a surface without open and non-manifold edges.
    pub volume_mm3: Option<f64>,
    /// Smallest coordinates \[mm\].
    pub least_mm: Vec3,
    /// Largest coordinates \[mm\].
    pub largest_mm: Vec3,
}

/// Triangles over welded vertices, with smoothed normals at their corners, and boxes to find them.
#[derive(Clone)]
pub struct Mesh {
    pub(super) vertices_mm: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each corner the index of its normal.
    pub(super) corners: Vec<[u32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) tree: Tree,
    report: MeshReport,
    chordal_tolerance_mm: f64,
}

impl fmt::Debug for Mesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mesh").field("report", &self.report).finish_non_exhaustive()
    }
}

/// Largest accepted coordinate \[mm\].
const MAX_COORDINATE_MM: f64 = 1e5;
/// Single precision resolves heights above this share of the largest coordinate.
const THIN: f64 = 1.0 / 4_194_304.0;
/// Bytes of memory for each facet at the peak of reading, if each has 3 corners of its own; measured, with a margin
/// (`docs/performance.md`).
const PEAK_BYTES_PER_FACET: u64 = 300;
/// Further bytes of memory.
const PEAK_BYTES: u64 = 16 << 20;

impl Mesh {
    /// Reads an STL file, binary or text, from a stream, in file order. Its memory is limited by the mesh itself.
    ///
    /// Corners with equal coordinates are welded. Open surfaces are accepted and reported.
    ///
    /// # Errors
    /// Not a complete STL file, more than 2²⁴ − 1 facets, a coordinate not finite or beyond 100 m, no facet with an
    /// area, neighbouring facets of opposite orientation, a closed surface that faces inward; a parameter out of
    /// range (`mm_per_unit` in [1e-6, 1e6], `chordal_tolerance_mm` in [1e-6, 10]); `stop` broke.
    pub fn read_stl(
        source: impl Read,
        settings: &MeshSettings,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Self, MeshFault> {
        settings.check()?;
        let stopped = Cell::new(false);
        let stop = || {
            let flow = stop();
            stopped.set(stopped.get() || flow.is_break());
            flow
        };
        Self::read(Stoppable { source, stop: &stop }, settings, &stop)
            .map_err(|fault| if stopped.get() { MeshFault::Cancelled } else { fault })
    }

    fn read(
        source: impl Read,
        settings: &MeshSettings,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Self, MeshFault> {
        let mut reader = StlReader::new(source)?;
        let mut asking = Asking::new(stop);
        let max_facets = settings.max_facets.min(u64::from(MAX_FACETS));
        let mut gathered = Gathered::default();
        let mut weld = Weld::new();
        while let Some(facet) = reader.next_facet()? {
            gathered.facets += 1;
            if gathered.facets > max_facets {
                let (facets, max) = (gathered.facets, max_facets);
                return Err(StlFault::TooManyFacets { facets, max }.into());
            }
            asking.after(1)?;
            let corners_mm = facet.corners.map(|corner| corner * settings.mm_per_unit);
            for value_mm in corners_mm.iter().flatten().copied() {
                if value_mm.is_nan() || value_mm.abs() > MAX_COORDINATE_MM {
                    let (facet, line, max_mm) = (gathered.facets, reader.line(), MAX_COORDINATE_MM);
                    return Err(MeshFault::Coordinate { facet, line, value_mm, max_mm });
                }
            }
            gathered.add(&mut weld, corners_mm, facet.normal, &mut asking)?;
        }
        Self::from_gathered(gathered, weld, settings.chordal_tolerance_mm, &mut asking)
    }

    /// A mesh of facets \[mm\], wound counter-clockwise as seen from outside.
    ///
    /// # Errors
    /// As for [`Mesh::read_stl`], without those of files.
    pub fn from_facets(
        facets_mm: impl IntoIterator<Item = [Vec3; 3]>,
        chordal_tolerance_mm: f64,
    ) -> Result<Self, MeshFault> {
        MeshSettings { chordal_tolerance_mm, ..MeshSettings::default() }.check()?;
        let mut gathered = Gathered::default();
        let mut weld = Weld::new();
        let mut asking = Asking::new(&|| ControlFlow::Continue(()));
        for corners_mm in facets_mm {
            gathered.facets += 1;
            let beyond = |x: &&f64| x.is_nan() || x.abs() > MAX_COORDINATE_MM;
            if let Some(value_mm) = corners_mm.iter().flatten().find(beyond) {
                let (facet, value_mm, max_mm) = (gathered.facets, *value_mm, MAX_COORDINATE_MM);
                return Err(MeshFault::Coordinate { facet, line: None, value_mm, max_mm });
            }
            if gathered.facets > u64::from(MAX_FACETS) {
                let (facets, max) = (gathered.facets, MAX_FACETS);
                return Err(StlFault::TooManyFacets { facets, max: max.into() }.into());
            }
            gathered.add(&mut weld, corners_mm, Vec3::zeros(), &mut asking)?;
        }
        Self::from_gathered(gathered, weld, chordal_tolerance_mm, &mut asking)
    }

    fn from_gathered(
        gathered: Gathered,
        weld: Weld,
        chordal_tolerance_mm: f64,
        asking: &mut Asking<'_>,
    ) -> Result<Self, MeshFault> {
        let vertices_mm = weld.into_vertices();
        let unordered = gathered.triangles;
        if unordered.is_empty() {
            return Err(MeshFault::NoFacets { degenerate: gathered.degenerate });
        }
        let at = |triangle: &[u32; 3]| corners_of(&vertices_mm, *triangle);
        let corners_mm = |facet: u32| unordered.get(facet as usize).map_or([Vec3::zeros(); 3], at);
        let (tree, order) = Tree::build(unordered.len(), corners_mm, asking)?;
        let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(unordered.len());
        for facet in &order {
            asking.after(1)?;
            triangles.extend(unordered.get(*facet as usize));
        }
        drop((order, unordered));
        let mut report = MeshReport {
            facets: gathered.facets,
            triangles: triangles.len() as u64,
            vertices: vertices_mm.len() as u64,
            degenerate_facets: gathered.degenerate,
            contradicting_normals: gathered.contradicting,
            open_edges: 0,
            non_manifold_edges: 0,
            sharp_edges: 0,
            area_mm2: 0.0,
            volume_mm3: None,
            least_mm: Vec3::repeat(f64::INFINITY),
            largest_mm: Vec3::repeat(f64::NEG_INFINITY),
        };
        let mut volume_mm3 = 0.0;
        for vertex in &vertices_mm {
            asking.after(1)?;
            report.least_mm = report.least_mm.inf(vertex);
            report.largest_mm = report.largest_mm.sup(vertex);
        }
        for triangle in &triangles {
            asking.after(1)?;
            let [a, b, c] = at(triangle).map(|corner| corner - report.least_mm);
            report.area_mm2 += 0.5 * (b - a).cross(&(c - a)).norm();
            volume_mm3 += a.dot(&b.cross(&c)) / 6.0;
        }
        let smoothed = smooth(&vertices_mm, &triangles, chordal_tolerance_mm, asking)?;
        let Edges { open, non_manifold, sharp, contrary, first_contrary } = smoothed.edges;
        if let Some([from_mm, to_mm]) = first_contrary {
            return Err(MeshFault::ContraryEdges { edges: contrary, from_mm, to_mm });
        }
        (report.open_edges, report.non_manifold_edges, report.sharp_edges) = (open, non_manifold, sharp);
        if open == 0 && non_manifold == 0 {
            if volume_mm3 < 0.0 {
                return Err(MeshFault::InsideOut { volume_mm3 });
            }
            report.volume_mm3 = Some(volume_mm3);
        }
        let (corners, normals) = (smoothed.corners, smoothed.normals);
        Ok(Self { vertices_mm, triangles, corners, normals, tree, report, chordal_tolerance_mm })
    }

    /// Upper bound on the memory at the peak of reading this number of facets \[bytes\].
    #[must_use]
    pub fn memory_estimate_bytes(facets: u64) -> u64 {
        PEAK_BYTES.saturating_add(facets.saturating_mul(PEAK_BYTES_PER_FACET))
    }

    /// The facts found in the file.
    #[must_use]
    pub fn report(&self) -> &MeshReport {
        &self.report
    }

    /// Largest distance between the facets and the true surface \[mm\].
    #[must_use]
    pub fn chordal_tolerance_mm(&self) -> f64 {
        self.chordal_tolerance_mm
    }

    /// The boxes over the triangles.
    pub(crate) fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// The corners of a triangle \[mm\], counter-clockwise as seen from outside. Triangles are numbered by
    /// position, not as in the file; `None` beyond the last.
    #[must_use]
    pub fn corners_mm(&self, triangle: u32) -> Option<[Vec3; 3]> {
        self.triangles.get(triangle as usize).map(|triangle| corners_of(&self.vertices_mm, *triangle))
    }
}

/// A file that asks whether to stop whenever more of it is read, so that a file without facets is stopped too.
struct Stoppable<'s, R> {
    source: R,
    stop: &'s dyn Fn() -> ControlFlow<()>,
}

impl<R: Read> Read for Stoppable<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if (self.stop)().is_break() {
            return Err(io::Error::other(MeshFault::Cancelled));
        }
        self.source.read(buffer)
    }
}

/// The corners of a triangle.
pub(super) fn corners_of(vertices_mm: &[Vec3], triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|vertex| vertices_mm.get(vertex as usize).copied().unwrap_or_default())
}

impl MeshSettings {
    /// Smallest and largest number of millimetres in a unit.
    pub const UNITS_MM: [f64; 2] = [1e-6, 1e6];
    /// Smallest and largest chordal tolerance \[mm\].
    pub const TOLERANCES_MM: [f64; 2] = [1e-6, 10.0];

    fn check(&self) -> Result<(), MeshFault> {
        for (parameter, value_mm, [min_mm, max_mm]) in [
            (MeshParameter::Unit, self.mm_per_unit, Self::UNITS_MM),
            (MeshParameter::ChordalTolerance, self.chordal_tolerance_mm, Self::TOLERANCES_MM),
        ] {
            if !(min_mm..=max_mm).contains(&value_mm) {
                return Err(MeshFault::Parameter { parameter, value_mm, min_mm, max_mm });
            }
        }
        Ok(())
    }
}

/// The data read so far.
#[derive(Debug, Default)]
struct Gathered {
    triangles: Vec<[u32; 3]>,
    facets: u64,
    degenerate: u64,
    contradicting: u64,
}

impl Gathered {
    fn add(
        &mut self,
        weld: &mut Weld,
        corners_mm: [Vec3; 3],
        stated_normal: Vec3,
        asking: &mut Asking<'_>,
    ) -> Result<(), MeshFault> {
        let [a, b, c] = corners_mm;
        let winding = (b - a).cross(&(c - a));
        let longest_mm = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let largest_mm = corners_mm.iter().fold(0.0, |largest: f64, corner| largest.max(corner.amax()));
        if winding.norm() <= longest_mm * largest_mm * THIN {
            self.degenerate += 1;
            return Ok(());
        }
        // A stated normal that is not a number is ignored.
        if stated_normal.dot(&winding) < 0.0 {
            self.contradicting += 1;
        }
        let [a, b, c] = corners_mm;
        self.triangles.push([weld.vertex(a, asking)?, weld.vertex(b, asking)?, weld.vertex(c, asking)?]);
        Ok(())
    }
}
