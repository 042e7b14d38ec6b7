//! Surfaces that come as files.

use std::io::Read;
use std::ops::ControlFlow;

use trunnion_core::surface::{Mesh, MeshSettings, STL_HEADER_BYTES, stl_facets_at_most};

/// Gives so many bytes at a time.
struct Pieces<'a> {
    left: &'a [u8],
    most: usize,
}

impl Read for Pieces<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let count = self.left.len().min(self.most).min(out.len());
        let (now, left) = self.left.split_at(count);
        out[..count].copy_from_slice(now);
        self.left = left;
        Ok(count)
    }
}

/// A file is read the same however it arrives; what is read has no more facets than its length allows, and is found
/// again where it is.
pub fn stl(data: &[u8]) {
    let Some((&choice, file)) = data.split_first() else { return };
    let settings = MeshSettings { max_facets: 5000, ..MeshSettings::default() };
    let go_on = || ControlFlow::Continue(());
    let whole = Mesh::read_stl(file, &settings, &go_on);
    let cut = Mesh::read_stl(Pieces { left: file, most: 1 + usize::from(choice) }, &settings, &go_on);
    assert_eq!(format!("{whole:?}"), format!("{cut:?}"), "a mesh depends on how its file was cut");
    let Ok(mesh) = whole else { return };
    let start = &file[..file.len().min(STL_HEADER_BYTES)];
    let report = mesh.report();
    assert!(report.facets <= stl_facets_at_most(start, file.len() as u64), "more facets than were counted: {report:?}");
    let text = format!("{report:?}");
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
}
