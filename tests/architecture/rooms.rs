//! The arrows one level deeper: between the rooms inside a module.
//!
//! A room is a folder in one of these modules, or a file that a row here names. What is no room is free, but for
//! circles.

use std::collections::{BTreeMap, BTreeSet};

use crate::tree::{Arrow, Tree};

/// The rows of one module.
type Rows<'a> = [(&'a str, &'a [&'a str])];

/// A member of a module, and the rooms that it may name, besides what those may name in turn.
///
/// A member without a row names no room. Every arrow here is in use.
const ROOMS: &[(&str, &Rows<'static>)] = &[
    (
        "process",
        &[
            ("arc_path", &[]),
            ("fault", &["arc_path"]),
            ("set_up", &["fault"]),
            ("text", &["set_up"]),
            // Those that write.
            ("pipeline", &["text"]),
            ("divided", &["pipeline"]),
            ("contact_path", &["divided"]),
            ("move_ends", &["pipeline"]),
            ("singular", &["contact_path"]),
            ("one_pass", &["singular", "move_ends", "simulate"]),
            // Those that only read. `post` writes another program, which the pipeline reads back.
            ("interpret", &["text"]),
            ("simulate", &["text"]),
            ("virtual_cutting", &["text"]),
            ("written_out", &["text"]),
            ("post", &["pipeline"]),
        ],
    ),
    (
        "motion",
        &[
            ("dialect", &[]),
            ("block_words", &["dialect"]),
            ("feed_rules", &["dialect"]),
            ("interpreter", &["dialect"]),
            ("spindle", &["dialect"]),
            ("statements", &["dialect"]),
        ],
    ),
    (
        "program",
        &[
            ("dialect", &["constants", "writer"]),
            ("constants", &["dialect"]),
            ("stamp", &["dialect"]),
            ("batch", &["dialect"]),
            ("fault", &["dialect"]),
            ("flow", &["dialect", "constants"]),
            ("reader", &["dialect"]),
        ],
    ),
    ("jobs", &[("queue", &[]), ("webhooks", &["queue"]), ("opening", &["webhooks"])]),
    (
        "http",
        &[
            // What every request goes through.
            ("body", &["coding"]),
            ("state", &["observation"]),
            ("watch", &["observation"]),
            ("request_facts", &["observation"]),
            ("before_handler", &["coding"]),
            // A program that is a path of `servo`, or a job, is answered as the programs are.
            ("servo", &["programs"]),
            ("jobs", &["programs"]),
            ("service", &["observation"]),
            ("openapi", &["webhooks"]),
            (
                "routes",
                &[
                    "audit",
                    "calibrations",
                    "jobs",
                    "keys",
                    "kinematics",
                    "machines",
                    "programs",
                    "service",
                    "servo",
                    "tools",
                    "wear",
                    "webhooks",
                ],
            ),
            ("router", &["observation"]),
        ],
    ),
];

/// The arrows between the members of one module, those to rooms alone.
fn between_rooms(
    module: &str,
    rows: &Rows<'_>,
    arrows: &BTreeSet<Arrow>,
) -> BTreeMap<String, BTreeSet<String>> {
    let member = |place: &str| {
        let inside = place.strip_prefix(module)?.strip_prefix('/')?;
        Some(inside.split('/').next()?.to_owned())
    };
    let is_folder = |member: &str| {
        let below = format!("{module}/{member}/");
        arrows.iter().any(|(from, to)| from.starts_with(&below) || to.starts_with(&below))
    };
    let mut between: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (from, to) in arrows {
        let (Some(from), Some(to)) = (member(from), member(to)) else { continue };
        let is_room = rows.iter().any(|(_, named)| named.contains(&to.as_str())) || is_folder(&to);
        if from != to && is_room {
            between.entry(from).or_default().insert(to);
        }
    }
    between
}

/// What each member may name, by its row and by the rows that follow from it.
fn allowed<'a>(rows: &Rows<'a>) -> BTreeMap<&'a str, BTreeSet<&'a str>> {
    let mut allowed: BTreeMap<&str, BTreeSet<&str>> =
        rows.iter().map(|(room, named)| (*room, named.iter().copied().collect())).collect();
    loop {
        let before = allowed.clone();
        for named in allowed.values_mut() {
            let further: Vec<_> =
                named.iter().filter_map(|room| before.get(room)).flatten().copied().collect();
            named.extend(further);
        }
        if allowed == before {
            return allowed;
        }
    }
}

fn faults_of(module: &str, rows: &Rows<'_>, arrows: &BTreeSet<Arrow>) -> Vec<String> {
    let mut faults = Vec::new();
    let between = between_rooms(module, rows, arrows);
    let allowed = allowed(rows);
    for (from, named) in &between {
        let may = allowed.get(from.as_str());
        for room in named.iter().filter(|room| !may.is_some_and(|may| may.contains(room.as_str()))) {
            faults.push(format!("{module}/{from} names {module}/{room}, and no arrow allows it"));
        }
    }
    for (from, named) in rows {
        let used = between.get(*from);
        for room in named.iter().filter(|room| !used.is_some_and(|used| used.contains(**room))) {
            faults
                .push(format!("{module}/{from} does not name {module}/{room} any more: take the arrow out"));
        }
    }
    faults
}

#[test]
fn every_room_names_only_what_its_arrows_allow() {
    let arrows = Tree::of_sources().arrows();
    let faults: Vec<_> = ROOMS.iter().flat_map(|(module, rows)| faults_of(module, rows, &arrows)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn posting_uses_the_reading_end_of_the_pipeline_alone() {
    let arrows = Tree::of_sources().arrows();
    let from_post = arrows.iter().filter(|(from, _)| from.starts_with("process/post/"));
    let ends: BTreeSet<_> =
        from_post.map(|(_, to)| to.as_str()).filter(|to| to.starts_with("process/pipeline/")).collect();
    assert_eq!(ends, BTreeSet::from(["process/pipeline/read_back"]));
}

#[test]
fn an_arrow_that_no_row_allows_is_found_and_so_is_one_out_of_use() {
    let tree = Tree::new(
        [
            ("m", "mod a; mod b; mod c; mod loose; pub use a::A;"),
            ("m/a", "mod x;"),
            ("m/a/x", "use super::super::b::y::Y;"),
            ("m/b", "pub mod y;"),
            ("m/b/y", "use crate::m::A; use crate::m::loose::L;"),
            ("m/loose", "fn f() { super::b::y::g() }"),
        ]
        .map(|(place, code)| (place, code.to_owned())),
    );
    let found = faults_of("m", &[("a", &["b"]), ("b", &["c"])], &tree.arrows());
    assert_eq!(
        found,
        [
            "m/b names m/a, and no arrow allows it",
            "m/loose names m/b, and no arrow allows it",
            "m/b does not name m/c any more: take the arrow out",
        ]
    );
}
