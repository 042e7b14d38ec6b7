//! The sources as the tests look at them: without comments, without the contents of strings, without tests.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use crate::CORE;

/// One file under `core/src` or `src`.
#[derive(Debug)]
pub(crate) struct Source {
    /// Where the file is.
    pub(crate) path: PathBuf,
    /// Its module's top level, `process` for `core/src/process/text/stream.rs`.
    pub(crate) module: String,
    /// Its place in its package, `process/text/stream`; a `mod.rs` has the place of its folder.
    pub(crate) place: String,
    /// The code, by line. Lines of tests are empty.
    pub(crate) code: Vec<String>,
    /// How many lines are outside tests.
    pub(crate) lines: usize,
}

/// Every file of both packages that is not a test.
pub(crate) fn sources() -> &'static [Source] {
    static SOURCES: LazyLock<Vec<Source>> = LazyLock::new(read_sources);
    &SOURCES
}

fn read_sources() -> Vec<Source> {
    let mut all = Vec::new();
    for package in ["core/src", "src"] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(package);
        let mut files = Vec::new();
        collect(&root, &mut files);
        files.sort();
        assert!(files.len() > 30, "the sources were not found");
        all.extend(files.into_iter().map(|path| {
            let text = fs::read_to_string(&path).unwrap();
            let inside = path.strip_prefix(&root).unwrap().with_extension("");
            let inside = inside.to_str().unwrap();
            let place = inside.strip_suffix("/mod").unwrap_or(inside).to_owned();
            let module = place.split('/').next().unwrap().to_owned();
            let in_core = CORE.contains(&module.as_str());
            assert!(module == "lib" || in_core == (package == "core/src"), "{module} in {package}");
            let (code, lines) = code_of(&text);
            Source { path, module, place, code, lines }
        }));
    }
    all
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") && !path.ends_with("tests.rs") {
            files.push(path);
        }
    }
}

/// The code by line, with comments, contents of strings and tests blanked, and how many lines are outside tests.
pub(crate) fn code_of(text: &str) -> (Vec<String>, usize) {
    const TEST: &str = "#[cfg(test)]";
    let mut code = without_comments(text);
    let mut of_tests = 0;
    while let Some(at) = code.find(TEST) {
        let end = at + end_of_item(&code[at..]);
        let blank: String = code[at..end].chars().filter(|c| *c == '\n').collect();
        of_tests += blank.len() + 1;
        code.replace_range(at..end, &blank);
    }
    let code: Vec<_> = code.lines().map(str::to_owned).collect();
    let lines = code.len().saturating_sub(of_tests);
    (code, lines)
}

/// Where the item ends that begins here with its attributes: after its closing brace, or after its semicolon.
fn end_of_item(code: &str) -> usize {
    let mut depth = 0;
    for (at, c) in code.char_indices() {
        match c {
            '{' | '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            '}' => {
                depth -= 1;
                if depth == 0 {
                    return at + 1;
                }
            }
            ';' if depth == 0 => return at + 1,
            _ => {}
        }
    }
    code.len()
}

/// The text with comments and the contents of strings and characters left out; every line end stays.
fn without_comments(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if c == '"' {
            out.push_str("\"\"");
            length_of_string(rest)
        } else if let Some(length) = length_of_raw_string(rest, &out) {
            out.push_str("\"\"");
            length
        } else if let Some(length) = length_of_character(rest) {
            out.push_str("' '");
            length
        } else {
            out.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        out.extend(rest[..length].chars().filter(|c| *c == '\n'));
        rest = &rest[length..];
    }
    out
}

fn length_of_string(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// The length of `r"…"` or `r#"…"#`. A name that ends in r begins none.
fn length_of_raw_string(text: &str, before: &str) -> Option<usize> {
    if before.ends_with(|c: char| c.is_alphanumeric() && c != 'b' || c == '_') {
        return None;
    }
    let inside = text.strip_prefix('r')?;
    let hashes = inside.len() - inside.trim_start_matches('#').len();
    inside[hashes..].strip_prefix('"')?;
    let begin = 1 + hashes + 1;
    let close = format!("\"{}", "#".repeat(hashes));
    Some(text[begin..].find(&close).map_or(text.len(), |end| begin + end + close.len()))
}

/// The length of `'c'` or `'\n'`; a lifetime is no character.
fn length_of_character(text: &str) -> Option<usize> {
    let mut chars = text.strip_prefix('\'')?.char_indices();
    let (_, first) = chars.next()?;
    if first == '\\' {
        return text[3..].find('\'').map(|end| 3 + end + 1);
    }
    let (end, last) = chars.next()?;
    (last == '\'').then_some(1 + end + 1)
}

#[test]
fn comments_strings_and_tests_are_no_code() {
    let (code, lines) = code_of(
        "let a = \"crate::http\"; // crate::http\nlet b = '\"'; /* crate\n::http */ let c: &'a str;\n\
         #[cfg(test)]\n#[expect(x, reason = \"}\")]\nmod tests {\n    use super::*;\n}\nlet d = r#\"a \" b\"#;\n",
    );
    assert_eq!(
        code,
        ["let a = \"\"; ", "let b = ' '; ", " let c: &'a str;", "", "", "", "", "", "let d = \"\";"]
    );
    assert_eq!(lines, 4);
}
