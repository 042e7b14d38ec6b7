//! Wear histories of a machine's tools: entries posted, listed, withdrawn, followed to a limit.

mod create_wear_entries;
mod figure;
mod get_wear_entry;
mod get_wear_trend;
mod list_wear_entries;
mod withdraw_wear_entry;

use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::http::AppState;
use crate::http::problem::{Problem, ProblemType};
use crate::wire::{FaultList, check_name};

/// The routes of this resource.
pub(super) fn router() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(create_wear_entries::create_wear_entries, list_wear_entries::list_wear_entries))
        .routes(routes!(get_wear_entry::get_wear_entry))
        .routes(routes!(withdraw_wear_entry::withdraw_wear_entry))
        .routes(routes!(get_wear_trend::get_wear_trend))
}

/// A machine that was deleted keeps its history.
async fn ever_existed(app: &AppState, machine_id: &str) -> Result<(), Problem> {
    let first = app.store.machine_revision(machine_id, 1).await?;
    first.map(drop).ok_or_else(|| Problem::machine_not_found(machine_id))
}

/// A name in the path or the query that no tool or cutter can have.
fn checked(pointer: &str, name: &str) -> Result<(), Problem> {
    let mut faults = FaultList::default();
    check_name(|| pointer.to_owned(), name, &mut faults);
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))
}

/// A part of a path as it stands in an address (RFC 3986 §3.3, its unreserved characters left).
fn encoded(segment: &str) -> String {
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
    use super::encoded;

    #[test]
    fn a_segment_of_any_characters_can_stand_in_an_address() {
        assert_eq!(encoded("T12_a-b.c~"), "T12_a-b.c~");
        assert_eq!(encoded("Ø 8/2 50%?"), "%C3%98%208%2F2%2050%25%3F");
    }
}
