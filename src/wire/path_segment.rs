//! Names in addresses.

/// A segment of a path in an address (RFC 3986 §3.3); unreserved characters stay as they are.
#[must_use]
pub fn path_segment(segment: &str) -> String {
    let mut out = String::with_capacity(segment.len());
    for byte in segment.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => out.push(char::from(byte)),
            other => {
                out.push('%');
                for digit in [other >> 4, other & 0xf] {
                    let digit = char::from_digit(u32::from(digit), 16).unwrap_or('0');
                    out.push(digit.to_ascii_uppercase());
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::path_segment;

    #[test]
    fn a_segment_of_any_characters_can_stand_in_an_address() {
        assert_eq!(path_segment("T12_a-b.c~"), "T12_a-b.c~");
        assert_eq!(path_segment("Ø 8/2 50%?"), "%C3%98%208%2F2%2050%25%3F");
    }
}
