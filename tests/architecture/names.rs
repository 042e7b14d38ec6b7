//! The names that one file uses: its `use` trees, re-exports included, and the paths in its code.

/// A name that a `use` brings into a file, or that a `pub use` hands on.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Import {
    /// The name in this file.
    pub(crate) name: String,
    /// The path it stands for.
    pub(crate) path: Vec<String>,
}

/// All names of one file.
#[derive(Debug, Default)]
pub(crate) struct Names {
    /// Every `use`, one a name.
    pub(crate) imports: Vec<Import>,
    /// The other paths, from their first part on.
    pub(crate) paths: Vec<Vec<String>>,
}

impl Names {
    /// Reads the names of a file whose comments, strings and tests are blanked.
    pub(crate) fn of(code: &str) -> Self {
        let tokens = tokens(code);
        let mut names = Self::default();
        let mut at = 0;
        while at < tokens.len() {
            let before = at.checked_sub(1).map_or("", |before| tokens[before]);
            let next = tokens.get(at + 1).copied().unwrap_or_default();
            if tokens[at] == "use" && next != "<" {
                at = names.read_tree(&tokens, at + 1, &[]);
            } else if is_word(tokens[at]) && !["::", "."].contains(&before) {
                let path = path_at(&tokens, at);
                at += 2 * path.len() - 1;
                if path.len() > 1 || ["crate", "super"].contains(&path[0].as_str()) {
                    names.paths.push(path);
                }
            } else {
                at += 1;
            }
        }
        names
    }

    /// Reads one branch of a `use` tree and returns where it ends.
    fn read_tree(&mut self, tokens: &[&str], from: usize, above: &[String]) -> usize {
        let mut path = above.to_vec();
        let mut at = from;
        while let Some(token) = tokens.get(at) {
            match *token {
                "::" => at += 1,
                "{" => {
                    at += 1;
                    while tokens.get(at).is_some_and(|token| *token != "}") {
                        at = self.read_tree(tokens, at, &path);
                        at += usize::from(tokens.get(at) == Some(&","));
                    }
                    return at + 1;
                }
                "*" => {
                    self.imports.push(Import { name: "*".to_owned(), path });
                    return at + 1;
                }
                word if is_word(word) => {
                    // `{self}` stands for the path before the brace.
                    if word != "self" || path.is_empty() {
                        path.push(word.to_owned());
                    }
                    at += 1;
                    let renamed = tokens.get(at) == Some(&"as");
                    if renamed || tokens.get(at) != Some(&"::") {
                        let name = if renamed { tokens[at + 1] } else { path[path.len() - 1].as_str() };
                        self.imports.push(Import { name: name.to_owned(), path: path.clone() });
                        return at + if renamed { 2 } else { 0 };
                    }
                }
                _ => return at,
            }
        }
        at
    }
}

fn path_at(tokens: &[&str], at: usize) -> Vec<String> {
    let mut path = vec![tokens[at].to_owned()];
    let mut rest = &tokens[at + 1..];
    while let ["::", word, after @ ..] = rest
        && is_word(word)
    {
        path.push((*word).to_owned());
        rest = after;
    }
    path
}

/// Words, `::` and single signs.
fn tokens(code: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = code.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if is_part_of_word(first) {
            rest.find(|c| !is_part_of_word(c)).unwrap_or(rest.len())
        } else if rest.starts_with("::") {
            2
        } else {
            first.len_utf8()
        };
        tokens.push(&rest[..length]);
        rest = rest[length..].trim_start();
    }
    tokens
}

fn is_part_of_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

#[test]
fn use_trees_and_paths_are_read() {
    let names = Names::of(
        "pub(in crate::a) use b::{self, C as D, e::{F, *}};\nuse std::fs;\n\
         fn f(x: &g::H) -> impl I + use<'_> { super::j::k(Vec::<u8>::new(), x.l) }",
    );
    let imports: Vec<_> =
        names.imports.iter().map(|import| format!("{} = {}", import.name, import.path.join("::"))).collect();
    assert_eq!(imports, ["b = b", "D = b::C", "F = b::e::F", "* = b::e", "fs = std::fs"]);
    let paths: Vec<_> = names.paths.iter().map(|path| path.join("::")).collect();
    assert_eq!(paths, ["crate::a", "g::H", "super::j::k"]);
}
