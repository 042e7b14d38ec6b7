//! STL files, whole and hostile.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what it did not expect")]

use std::cell::Cell;
use std::io::Read;
use std::ops::ControlFlow;

use trunnion::geometry::Vec3;
use trunnion::surface::{
    MAX_FACETS, Mesh, MeshFault, MeshSettings, Plane, STL_HEADER_BYTES, StlFault, stl_facets_at_most,
};

use crate::tessellation::{binary_stl, cube, facets, text_stl};

fn read(file: impl Read) -> Result<Mesh, MeshFault> {
    Mesh::read_stl(file, &MeshSettings::default(), &|| ControlFlow::Continue(()))
}

fn stl_fault(file: impl Read) -> StlFault {
    match read(file).unwrap_err() {
        MeshFault::Stl(fault) => fault,
        other => panic!("{other}"),
    }
}

/// A stream that gives a few bytes at a time.
struct Trickle<'a>(&'a [u8]);

impl Read for Trickle<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.0.len().min(buffer.len()).min(7);
        let (now, later) = self.0.split_at(count);
        buffer[..count].copy_from_slice(now);
        self.0 = later;
        Ok(count)
    }
}

#[test]
fn binary_and_text_hold_the_same_mesh() {
    let facets = cube(20.0);
    let expected = *Mesh::from_facets(facets.clone(), 0.01).unwrap().report();
    let (binary, text) = (binary_stl(&facets, "made by hand"), text_stl(&facets));
    for file in [&binary, &binary_stl(&facets, "solid and yet binary"), text.as_bytes()] {
        assert_eq!(*read(file).unwrap().report(), expected);
        assert_eq!(*read(Trickle(file)).unwrap().report(), expected);
    }
    let shouting = text.to_uppercase().replace('\n', "\r\n\t");
    assert_eq!(*read(shouting.as_bytes()).unwrap().report(), expected);
    let twice = format!("\u{feff}{}{text}", text_stl(&[]));
    assert_eq!(*read(twice.as_bytes()).unwrap().report(), expected);
    let inches = MeshSettings { mm_per_unit: 25.4, ..MeshSettings::default() };
    let mesh = Mesh::read_stl(&binary[..], &inches, &|| ControlFlow::Continue(())).unwrap();
    assert_eq!(mesh.report().largest_mm, Vec3::repeat(508.0));
}

#[test]
fn text_keeps_all_digits() {
    let tenth = text_stl(&[[Vec3::zeros(), Vec3::new(0.1, 0.0, 0.0), Vec3::new(0.0, 1.0 / 3.0, 0.0)]]);
    assert_eq!(read(tenth.as_bytes()).unwrap().report().largest_mm, Vec3::new(0.1, 1.0 / 3.0, 0.0));
}

#[test]
fn stated_normals_are_counted_where_they_contradict() {
    let text = text_stl(&cube(20.0)).replacen("normal -0e0 0e0 -1e0", "normal nan nan nan", 1);
    let against = text.replace("normal 0e0 0e0 1e0", "normal 0e0 0e0 -1e0");
    assert_ne!(text, against);
    assert_eq!(read(text.as_bytes()).unwrap().report().contradicting_normals, 0);
    assert_eq!(read(against.as_bytes()).unwrap().report().contradicting_normals, 2);
}

#[test]
fn what_is_no_whole_file_is_refused_with_its_numbers() {
    let facets = cube(20.0);
    let binary = binary_stl(&facets, "solid");
    assert!(matches!(stl_fault(&binary[..83]), StlFault::TruncatedHeader { bytes: 83 }));
    assert!(matches!(stl_fault(&[0_u8; 20][..]), StlFault::TruncatedHeader { bytes: 20 }));
    for cut in [84, 100, 133, 134, binary.len() - 1] {
        let whole = u32::try_from((cut - 84) / 50).unwrap();
        assert!(matches!(
            stl_fault(&binary[..cut]),
            StlFault::Truncated { stated: 12, facets } if facets == whole
        ));
    }
    let longer = [&binary[..], b"x"].concat();
    assert!(matches!(stl_fault(&longer[..]), StlFault::TrailingBytes { stated: 12 }));
    // a header that promises the most, with nothing behind it
    let mut promise = vec![0_u8; 80];
    promise.extend(MAX_FACETS.to_le_bytes());
    assert!(matches!(stl_fault(&promise[..]), StlFault::Truncated { stated: MAX_FACETS, facets: 0 }));
    promise.truncate(80);
    promise.extend(u32::MAX.to_le_bytes());
    // a short file is not complete, whatever it promises; a long one is refused before it is read
    assert!(matches!(stl_fault(&promise[..]), StlFault::Truncated { stated: u32::MAX, facets: 0 }));
    promise.resize(1 << 16, 0);
    assert!(matches!(stl_fault(&promise[..]), StlFault::TooManyFacets { facets: 4_294_967_295, .. }));
    assert!(matches!(stl_fault(&b""[..]), StlFault::NotStl));
    assert!(matches!(stl_fault(&b"{\"solid\": true}"[..]), StlFault::NotStl));
    let text = text_stl(&facets);
    assert!(matches!(stl_fault(&text.as_bytes()[..text.len() - 18]), StlFault::TruncatedText { line: 86 }));
    let cut = &text[..text.rfind("vertex").unwrap() + 8];
    assert!(matches!(stl_fault(cut.as_bytes()), StlFault::TruncatedText { .. }));
    let colour = text.replacen("outer", "color", 1);
    assert!(matches!(stl_fault(colour.as_bytes()), StlFault::Syntax { line: 3, expected: "outer" }));
    assert!(matches!(read(&b"solid x\nendsolid"[..]), Err(MeshFault::NoFacets { degenerate: 0 })));
}

#[test]
fn numbers_that_are_none_are_refused() {
    let facets = cube(20.0);
    let text = text_stl(&facets).replacen("vertex 2e1", "vertex nan", 1);
    assert!(matches!(stl_fault(text.as_bytes()), StlFault::Syntax { expected: "a finite number", .. }));
    for (number, is_infinite) in [(f32::NAN, false), (f32::INFINITY, true), (1e9, false)] {
        let mut binary = binary_stl(&facets, "");
        binary[84 + 50 + 12..][..4].copy_from_slice(&number.to_le_bytes());
        let fault = read(&binary[..]).unwrap_err();
        let MeshFault::Coordinate { facet: 2, line: None, value_mm, .. } = fault else { panic!("{fault}") };
        assert_eq!(value_mm.is_infinite(), is_infinite);
    }
    let zero = MeshSettings { mm_per_unit: 0.0, ..MeshSettings::default() };
    let fault = Mesh::read_stl(&b""[..], &zero, &|| ControlFlow::Continue(())).unwrap_err();
    assert!(matches!(fault, MeshFault::Parameter { .. }), "{fault}");
    assert_eq!(fault.to_string(), "a unit of the file of 0e0 mm is not between 1e-6 mm and 1e6 mm");
    let far = text_stl(&facets).replacen("vertex 2e1", "vertex 2e9", 1);
    assert_eq!(
        read(far.as_bytes()).unwrap_err().to_string(),
        "facet 1, which ends in line 8: coordinate 2e9 mm is not between -100000 mm and 100000 mm"
    );
}

#[test]
fn no_file_has_more_facets_than_its_length_has_room_for() {
    let facets = cube(20.0);
    let at_most = |file: &[u8]| {
        stl_facets_at_most(&file[..file.len().min(STL_HEADER_BYTES)], u64::try_from(file.len()).unwrap())
    };
    assert_eq!(at_most(&binary_stl(&facets, "solid and yet binary")), 12);
    assert_eq!(at_most(&binary_stl(&[], "")), 0);
    assert_eq!(at_most(&[0_u8; 20]), 0);
    let shortest = "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet ";
    let text = format!("solid x\n{}endsolid", shortest.repeat(500));
    assert_eq!(read(text.as_bytes()).unwrap().report().facets, 500);
    assert!((500..550).contains(&at_most(text.as_bytes())), "{}", at_most(text.as_bytes()));
}

#[test]
fn a_line_without_end_takes_no_memory() {
    let endless = || std::io::repeat(b'a').take(1 << 26);
    // a name is skipped, a word is given up
    assert!(matches!(stl_fault(b"solid ".chain(endless())), StlFault::TruncatedText { line: 1 }));
    let word = b"solid x\nfacet normal ".chain(endless());
    assert!(matches!(stl_fault(word), StlFault::Syntax { line: 2, expected: "a word of at most 64 bytes" }));
    let spaces = b"solid x\n".chain(std::io::repeat(b' ').take(1 << 26));
    assert!(matches!(stl_fault(spaces), StlFault::TruncatedText { line: 2 }));
}

#[test]
fn reading_stops_when_nobody_waits() {
    let facet = cube(1.0)[0];
    let file = binary_stl(&vec![facet; 70_000], "");
    let stopped = Mesh::read_stl(&file[..], &MeshSettings::default(), &|| ControlFlow::Break(()));
    assert!(matches!(stopped, Err(MeshFault::Cancelled)));
}

#[test]
fn a_mesh_can_be_stopped_at_every_step_of_its_making() {
    let plane = Plane::new(Vec3::zeros(), 30.0, 30.0).unwrap();
    let file = binary_stl(&facets(&plane, [300, 300]), "");
    let stopped_at = |last: u32| {
        let asked = Cell::new(0);
        let stop = || {
            asked.set(asked.get() + 1);
            if asked.get() == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        (Mesh::read_stl(&file[..], &MeshSettings::default(), &stop), asked.get())
    };
    let (whole, asked) = stopped_at(u32::MAX);
    assert_eq!(whole.unwrap().report().facets, 180_000);
    // 180 000 facets read, put into a tree of 15 levels, brought into its order, gone over for their area, and three
    // times for what is around their 90 601 vertices: every 8192 of each, and every 64 KiB of the file
    assert!((500..3000).contains(&asked), "{asked}");
    for last in (1..=asked).step_by(53) {
        let (stopped, so_far) = stopped_at(last);
        assert!(matches!(stopped, Err(MeshFault::Cancelled)) && so_far == last, "{last}");
    }
}
