//! No circle between files, but for a parent and its own children.
//!
//! Each folder is looked at alone. The files and folders directly in it must not name each other in a circle, where a
//! folder stands for everything below it. A `mod.rs` and the files below it are no circle.

use std::collections::{BTreeMap, BTreeSet};

use crate::tree::{Arrow, Tree};

/// The modules whose inside is held free of circles.
const LOOKED_AT: [&str; 5] = ["process", "motion", "program", "jobs", "http"];

/// Circles that are meant: their members, and the reason.
const MEANT_CIRCLES: &[(&[&str], &str)] = &[
    (
        &[
            "motion/block_words",
            "motion/course",
            "motion/dialect",
            "motion/execute",
            "motion/feed",
            "motion/feed_rules",
            "motion/interpreter",
            "motion/meaning",
            "motion/modal",
            "motion/motion_shell",
            "motion/motions",
            "motion/point_arc",
            "motion/position",
            "motion/sections",
            "motion/spindle",
            "motion/statements",
            "motion/tool_lengths",
            "motion/travel",
            "motion/unit",
        ],
        "The interpreter is one state machine. These files hold parts of its state and of its course.",
    ),
    (
        &["program/batch", "program/constants", "program/dialect", "program/fault", "program/writer"],
        "A batch knows the dialect in which it was read. A dialect makes batches and prints them.",
    ),
    (
        &[
            "program/dialect/apt",
            "program/dialect/csv",
            "program/dialect/detect",
            "program/dialect/foreign",
            "program/dialect/heidenhain",
            "program/dialect/iso",
            "program/dialect/okuma",
            "program/dialect/rules",
            "program/dialect/siemens",
        ],
        "The table of dialects names their rows. The rows are of a type that is beside the table.",
    ),
    (
        &[
            "program/dialect/apt/circle",
            "program/dialect/apt/cycle",
            "program/dialect/apt/line",
            "program/dialect/apt/point",
            "program/dialect/apt/statement",
        ],
        "One grammar, read by recursive descent.",
    ),
    (
        &[
            "program/dialect/heidenhain/cycle",
            "program/dialect/heidenhain/line",
            "program/dialect/heidenhain/path",
            "program/dialect/heidenhain/statement",
        ],
        "One grammar, read by recursive descent.",
    ),
    (
        &["program/dialect/siemens/constants/declaration", "program/dialect/siemens/constants/variables"],
        "One grammar, read by recursive descent.",
    ),
    (
        &[
            "program/dialect/siemens/constants/expression",
            "program/dialect/siemens/constants/functions",
            "program/dialect/siemens/constants/operators",
        ],
        "One grammar, read by recursive descent.",
    ),
    (
        &["program/dialect/siemens/line", "program/dialect/siemens/statement"],
        "One grammar, read by recursive descent.",
    ),
];

/// Every circle between the members of a folder, with the arrows between them.
fn circles(arrows: &BTreeSet<Arrow>) -> BTreeMap<Vec<String>, Vec<String>> {
    let mut names: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut seen_as: BTreeMap<[String; 2], String> = BTreeMap::new();
    for (from, to) in arrows {
        if let Some(members) = members(from, to) {
            let [a, b] = members.clone();
            names.entry(a).or_default().insert(b);
            seen_as.entry(members).or_insert_with(|| format!("    {from} names {to}"));
        }
    }
    let reached: BTreeMap<_, _> = names.keys().map(|member| (member, reached_from(member, &names))).collect();
    let mut circles = BTreeMap::new();
    for (member, reached_here) in reached.iter().filter(|(member, all)| all.contains(**member)) {
        let is_back = |other: &&&String| reached.get(**other).is_some_and(|back| back.contains(*member));
        let circle: Vec<String> = reached_here.iter().filter(is_back).map(|other| (*other).clone()).collect();
        let inside = |pair: &[String; 2]| pair.iter().all(|member| circle.contains(member));
        let seen = seen_as.iter().filter(|(pair, _)| inside(pair)).map(|(_, seen)| seen.clone()).collect();
        circles.insert(circle, seen);
    }
    circles
}

/// The two members of one folder that an arrow joins. There are none between a file and its own parent.
fn members(from: &str, to: &str) -> Option<[String; 2]> {
    let [a, b] = [from, to].map(|place| place.split('/').collect::<Vec<_>>());
    let common = a.iter().zip(&b).take_while(|(a, b)| a == b).count();
    let member = |parts: &[&str]| Some(parts.get(..=common)?.join("/"));
    Some([member(&a)?, member(&b)?])
}

fn reached_from<'a>(start: &str, names: &'a BTreeMap<String, BTreeSet<String>>) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut ways: Vec<_> = names.get(start).into_iter().flatten().collect();
    while let Some(member) = ways.pop() {
        if reached.insert(member) {
            ways.extend(names.get(member).into_iter().flatten());
        }
    }
    reached
}

#[test]
fn files_name_each_other_in_no_circle_but_the_meant_ones() {
    let mut arrows = Tree::of_sources().arrows();
    arrows.retain(|(from, _)| LOOKED_AT.iter().any(|module| from.split('/').next() == Some(module)));
    assert!(arrows.len() > 1000, "only {} arrows were seen", arrows.len());
    let mut found = circles(&arrows);
    let mut faults = Vec::new();
    for (members, reason) in MEANT_CIRCLES {
        assert!(!reason.is_empty(), "{members:?} needs a reason");
        if found.remove(&members.iter().map(|&member| member.to_owned()).collect::<Vec<_>>()).is_none() {
            faults
                .push(format!("no such circle any more: {}. Take it out of the table.", members.join(", ")));
        }
    }
    for (members, seen) in found {
        faults.push(format!("a circle between {}:\n{}", members.join(", "), seen.join("\n")));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The circles of a small tree, each as the last parts of its members.
#[cfg(test)]
fn circles_of(files: &[(&str, &str)]) -> Vec<String> {
    let tree = Tree::new(files.iter().map(|&(place, code)| (place, code.to_owned())));
    circles(&tree.arrows()).into_keys().map(|members| members.join(" ")).collect()
}

#[test]
fn a_circle_between_two_files_is_found() {
    let files = [("m", "mod a; mod b;"), ("m/a", "use super::b::B;"), ("m/b", "fn f(a: &crate::m::a::A) {}")];
    assert_eq!(circles_of(&files), ["m/a m/b"]);
    assert_eq!(circles_of(&files[..2]), [""; 0]);
}

#[test]
fn a_circle_through_re_exports_and_folders_is_found() {
    let files = [
        ("m", "mod a; mod b; mod c; pub use b::deep::{B as Other}; use c::{self, C};"),
        ("m/a", "use super::Other;"),
        ("m/b", "mod deep; mod side;"),
        ("m/b/deep", "struct B;"),
        // Only the folder closes this circle, no single file.
        ("m/b/side", "use super::super::c; fn f(_: c::C) {}"),
        ("m/c", "use crate::m::a::{self as first, A}; struct C;"),
    ];
    assert_eq!(circles_of(&files), ["m/a m/b m/c"]);
}

#[test]
fn a_parent_and_its_children_are_no_circle() {
    let files = [
        ("m", "mod a; mod b; pub use a::A; struct Shared;"),
        ("m/a", "use super::Shared; use super::b::B;"),
        ("m/b", "use crate::m; fn f(_: m::Shared) {}"),
    ];
    assert_eq!(circles_of(&files), [""; 0]);
}
