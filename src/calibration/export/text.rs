//! How numbers and names are written.

use std::fmt::Write;

use crate::geometry::Vec3;

/// The shortest digits that read back as the same number; −0 is never written.
pub(super) fn exact(value: f64) -> String {
    format!("{:?}", value + 0.0)
}

/// Three numbers in brackets, exact.
pub(super) fn exact_vector(v: Vec3) -> String {
    format!("[{}, {}, {}]", exact(v.x), exact(v.y), exact(v.z))
}

/// A name between quotation marks, as TOML reads it.
pub(super) fn quoted(name: &str) -> String {
    let mut out = String::from("\"");
    for c in name.chars() {
        match c {
            '"' | '\\' => {
                out.push('\\');
                out.push(c);
            }
            c if c.is_control() => {
                // writing to a String cannot fail
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
