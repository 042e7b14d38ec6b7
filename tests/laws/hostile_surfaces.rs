//! Laws of surfaces that were made to be searched for ever: what a search takes is counted, and ends where it may not
//! take more.
#![expect(clippy::unwrap_used, reason = "a test may stop at what it did not expect")]

use std::cell::Cell;
use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use trunnion::contact::{Effort, EffortEnd, PartSurface, SurfaceContact, contact_on_surface};
use trunnion::geometry::Vec3;
use trunnion::kinematics::ToolPose;
use trunnion::machine::Tool;
use trunnion::process::{
    Budget, CcParameters, ContactSource, Fault, WearParameters, WornCutter, compensate, compensate_wear,
};
use trunnion::surface::{Mesh, MeshFault, MeshSettings, Uncounted};
use trunnion::units::Length;

use crate::models::finishing::{ac_machine, tool};
use crate::models::hostile_facets::FAMILIES;
use crate::models::set_ups::at_zero;
use crate::models::tessellation::binary_stl;

const FACETS: u32 = 1000;
/// Steps of one facet: five looks, and 53 halvings of each side.
const ONE_FACET: u64 = 5 + 3 * 53;
/// Steps between two questions whether to go on.
const ASKED_EVERY: u64 = 2048;

fn part(facets: &[[Vec3; 3]]) -> PartSurface {
    let mesh = Mesh::from_facets(facets.iter().copied(), 0.01).unwrap();
    PartSurface { mesh: Arc::new(mesh), contact_gap: Length::from_mm(1.0) }
}

/// Cutters that touch, or nearly touch, in the crowd.
fn looks() -> Vec<(Tool, ToolPose)> {
    let tools = [tool(5.0, 5.0), tool(5.0, 1.0), tool(5.0, 0.0)];
    let axes = [Vec3::z(), Vec3::new(0.2, 0.1, 1.0).normalize(), Vec3::new(1.0, 0.3, 0.2).normalize()];
    tools
        .into_iter()
        .flat_map(|tool| axes.map(|axis| (tool, ToolPose { tip_mm: Vec3::new(0.3, 0.2, 0.1), axis })))
        .collect()
}

#[test]
fn a_search_ends_within_one_facet_of_what_it_may_take() {
    for (name, facets) in FAMILIES {
        let part = part(&facets(FACETS));
        for (tool, pose) in looks() {
            let stop = || ControlFlow::Continue(());
            let mut free = Effort::new(&stop, u64::MAX);
            let found = contact_on_surface(&part, &tool, &pose, &mut free);
            let taken = free.surface_steps();
            assert_eq!((found, free.end()), (contact_on_surface(&part, &tool, &pose, &mut Uncounted), None));
            let search = |most: u64| -> (Option<SurfaceContact>, u64, Option<EffortEnd>) {
                let mut effort = Effort::new(&stop, u64::MAX).searching_at_most(most);
                let found = contact_on_surface(&part, &tool, &pose, &mut effort);
                (found, effort.surface_steps(), effort.end())
            };
            assert_eq!(search(taken), (found, taken, None), "{name}");
            for most in [0, taken / 3, taken - 1] {
                let (_, steps, end) = search(most);
                assert_eq!(end, Some(EffortEnd::Searched { most }), "{name}");
                assert!(steps <= most + 8 * ONE_FACET, "{name}: {steps} steps of {most}");
            }
        }
    }
}

#[test]
fn facets_one_on_another_are_not_all_looked_at_closely() {
    // A facet looked at closely takes some ninety steps here, one that is passed over takes one.
    let (tool, pose) = looks()[1];
    for (name, facets) in FAMILIES.iter().filter(|(name, _)| ["equal", "stacked"].contains(name)) {
        let stop = || ControlFlow::Continue(());
        let mut effort = Effort::new(&stop, u64::MAX);
        let _ = contact_on_surface(&part(&facets(20_000)), &tool, &pose, &mut effort);
        let each = effort.surface_steps() as f64 / 20_000.0;
        assert!(each < 12.0, "{name}: {each} steps a facet");
    }
}

#[test]
fn after_a_stop_a_search_takes_no_more_than_one_facet() {
    for (name, facets) in FAMILIES {
        let part = part(&facets(FACETS));
        for (tool, pose) in looks() {
            let asked = AtomicU64::new(0);
            let stop = || {
                asked.fetch_add(1, Ordering::Relaxed);
                ControlFlow::Break(())
            };
            let mut effort = Effort::new(&stop, u64::MAX);
            let _ = contact_on_surface(&part, &tool, &pose, &mut effort);
            assert!(effort.surface_steps() <= ASKED_EVERY + 8 * ONE_FACET, "{name}");
            if effort.is_over() {
                assert_eq!(effort.end(), Some(EffortEnd::Unwanted), "{name}");
            }
        }
    }
}

#[test]
fn no_file_is_read_for_long_without_a_question() {
    let equal = vec![FAMILIES[0].1(1)[0]; 100_000];
    let fan: Vec<[Vec3; 3]> = (0..100_000_u32)
        .map(|k| {
            let at = |k: u32| {
                let (sin, cos) = (f64::from(k) * 1e-5).sin_cos();
                Vec3::new(1e3 * cos, 1e3 * sin, 0.0)
            };
            [Vec3::zeros(), at(k), at(k + 1)]
        })
        .collect();
    let thin = vec![[Vec3::zeros(), Vec3::x(), Vec3::x() * 2.0]; 100_000];
    for (name, facets) in [("equal", equal), ("fan", fan), ("thin", thin)] {
        let file = binary_stl(&facets, "");
        let read = |last: u64| {
            let asked = Cell::new(0_u64);
            let stop = || {
                asked.set(asked.get() + 1);
                if asked.get() >= last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let read = Mesh::read_stl(&file[..], &MeshSettings::default(), &stop);
            (read.map(|mesh| mesh.report().facets), asked.get())
        };
        let (_, asked) = read(u64::MAX);
        // every 64 KiB of the file, and every 8192 facets
        assert!(asked >= file.len() as u64 >> 16, "{name}: {asked}");
        for last in [1, asked / 3, asked / 2, asked - asked / 20] {
            let (stopped, so_far) = read(last);
            assert!(matches!(stopped, Err(MeshFault::Cancelled)), "{name}: {stopped:?}");
            assert_eq!(so_far, last, "{name} was asked again after it was stopped");
        }
    }
}

/// A pass of so many blocks over the crowd.
fn pass(blocks: u32) -> Vec<u8> {
    let mut text = String::from("G21 G90 G94\nG0 X0 Y0 Z20 A0 C0\nG1 X0 Y0 Z0.1 A5 C5 F1000\n");
    for k in 0..blocks {
        let (x, a) = (f64::from(k % 40) * 0.01, 5.0 + f64::from(k % 7));
        writeln!(text, "G1 X{x:.3} Y0.2 Z0.1 A{a:.3} C{:.3}", 5.0 + f64::from(k % 11)).unwrap();
    }
    text.into_bytes()
}

#[test]
fn programs_over_hostile_surfaces_are_refused_by_the_same_count_every_time() {
    let (machine, source) = (ac_machine(), pass(30));
    let go_on = || ControlFlow::Continue(());
    for (name, facets) in FAMILIES {
        let part = Some(part(&facets(FACETS)));
        let budget = |max_surface_steps| Budget { max_surface_steps, ..Budget::default() };
        let cc = |max_steps| {
            let parameters = CcParameters {
                contact: ContactSource::Surface,
                part: part.clone(),
                budget: budget(max_steps),
                ..CcParameters::new(tool(5.0, 1.0), at_zero())
            };
            compensate(&machine, &parameters, &source, &mut Vec::new(), &go_on).map(drop)
        };
        let wear = |max_steps| {
            let worn = WornCutter::Tool(tool(4.9, 0.9));
            let parameters = WearParameters {
                contact: ContactSource::Surface,
                part: part.clone(),
                budget: budget(max_steps),
                ..WearParameters::new(tool(5.0, 1.0), worn, at_zero())
            };
            compensate_wear(&machine, &parameters, &source, &mut Vec::new(), &go_on).map(drop)
        };
        for (way, run) in [("cc", &cc as &dyn Fn(u64) -> Result<(), Fault>), ("wear", &wear)] {
            for most in [0, 1000, 50_000] {
                let [first, again] =
                    [run(most), run(most)].map(|done| done.map_err(|fault| fault.to_string()));
                assert!(
                    matches!(run(most), Err(Fault::TooCostly { limit, .. }) if limit == most),
                    "{name}, {way}"
                );
                assert_eq!(first, again, "{name}, {way}");
            }
            assert!(!matches!(run(u64::MAX), Err(Fault::TooCostly { .. })), "{name}, {way}");
        }
    }
}
