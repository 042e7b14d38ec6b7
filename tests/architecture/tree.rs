//! The files of one package, and which file names which.
//!
//! A name leads to the file that declares it, through every `use` that hands it on. Methods are not followed: a file
//! that only calls a method of a value names nothing.

use std::collections::{BTreeMap, BTreeSet};

use crate::names::{Import, Names};
use crate::source::sources;

/// An arrow from the file that names to the file that is named; both are places like `process/text/stream`.
pub(crate) type Arrow = (String, String);

/// Uses that may hand a name on to the next before something must be wrong.
const MAX_HANDS: usize = 16;

/// The files of one package by their place.
#[derive(Debug)]
pub(crate) struct Tree {
    files: BTreeMap<String, Names>,
}

impl Tree {
    /// The tree of files given as place and code.
    pub(crate) fn new<'a>(files: impl IntoIterator<Item = (&'a str, String)>) -> Self {
        Self { files: files.into_iter().map(|(place, code)| (place.to_owned(), Names::of(&code))).collect() }
    }

    /// The tree of both packages: their modules have different names, and `crate` means the package of its file.
    pub(crate) fn of_sources() -> Self {
        let modules = sources().iter().filter(|source| source.module != "lib");
        Self::new(modules.map(|source| (source.place.as_str(), source.code.join("\n"))))
    }

    /// Every arrow between two different files.
    pub(crate) fn arrows(&self) -> BTreeSet<Arrow> {
        let mut arrows = BTreeSet::new();
        for (from, names) in &self.files {
            let imported = names.imports.iter().map(|import| &import.path);
            for path in imported.chain(&names.paths) {
                let mut through = BTreeSet::new();
                self.follow(from, path, &mut through, MAX_HANDS);
                arrows.extend(through.into_iter().map(|to| (from.clone(), to)));
            }
        }
        arrows.retain(|(from, to)| from != to && self.files.contains_key(to));
        arrows
    }

    /// Follows a path that stands in a file. Adds every file it leads through. Returns the module where it ends, if it
    /// ends at a module.
    fn follow(
        &self,
        from: &str,
        path: &[String],
        through: &mut BTreeSet<String>,
        hands: usize,
    ) -> Option<String> {
        let (first, rest) = path.split_first()?;
        let mut at = match first.as_str() {
            "crate" => String::new(),
            "self" => from.to_owned(),
            "super" => parent(from).to_owned(),
            name => match self.step(from, name, through, hands) {
                Step::Module(module) => module,
                Step::Item | Step::Unknown => return None,
            },
        };
        for part in rest {
            if part == "super" {
                at = parent(&at).to_owned();
                continue;
            }
            through.insert(at.clone());
            match self.step(&at, part, through, hands) {
                Step::Module(module) => at = module,
                Step::Item | Step::Unknown => return None,
            }
        }
        if self.files.contains_key(&at) {
            through.insert(at.clone());
        }
        Some(at)
    }

    /// What a name is in a module: a file below it, something that it imports, or something else.
    fn step(&self, at: &str, name: &str, through: &mut BTreeSet<String>, hands: usize) -> Step {
        let below = if at.is_empty() { name.to_owned() } else { format!("{at}/{name}") };
        if self.files.contains_key(&below) {
            return Step::Module(below);
        }
        let import = |import: &&Import| import.name == name && import.path != [name];
        let Some(import) = self.files.get(at).and_then(|names| names.imports.iter().find(import)) else {
            return Step::Unknown;
        };
        match hands.checked_sub(1).and_then(|hands| self.follow(at, &import.path, through, hands)) {
            Some(module) => Step::Module(module),
            None => Step::Item,
        }
    }
}

enum Step {
    Module(String),
    Item,
    Unknown,
}

fn parent(place: &str) -> &str {
    place.rsplit_once('/').map_or("", |(parent, _)| parent)
}

#[test]
fn no_file_imports_all_names_of_another() {
    // Where its names come from could not be followed.
    for (place, names) in &Tree::of_sources().files {
        for import in names.imports.iter().filter(|import| import.name == "*") {
            let is_ours = ["crate", "super", "self"].contains(&import.path[0].as_str());
            assert!(
                !is_ours,
                "{place} imports all names of {}: name them one by one",
                import.path.join("::")
            );
        }
    }
}
