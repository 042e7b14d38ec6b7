//! The wear that is accepted from entries without a question.

use crate::units::Length;

/// Largest radius loss accepted from entries, as a share of the nominal radius. A cutter that lost a fifth no
/// longer cuts the part for which it was chosen. A larger loss is nearly always a mistake: another unit, a
/// diameter, or another cutter.
pub const MOST_WEAR_OF_RADIUS: f64 = 0.2;

/// A decrease of wear below this counts as scatter of readings \[µm\]: flank wear under a microscope is read to 2
/// to 5 µm.
pub const FALL_UM: f64 = 10.0;

/// A decrease by a smaller share of the wear measured before counts as scatter, because scatter grows with the
/// wear.
pub const FALL_OF_WEAR: f64 = 0.2;

/// Largest wear accepted from entries for a cutter with this nominal radius.
#[must_use]
pub fn most_wear(radius: Length) -> Length {
    radius * MOST_WEAR_OF_RADIUS
}

/// Whether one cutter cannot have had both values. Wear does not grow back, so the later reading is of another
/// cutter, or one reading is wrong. Both in \[µm\].
#[must_use]
pub fn has_fallen(earlier_um: f64, newest_um: f64) -> bool {
    let fall_um = earlier_um - newest_um;
    fall_um > FALL_UM && fall_um > FALL_OF_WEAR * earlier_um
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wear_may_fall_by_scatter_and_no_more() {
        for (earlier_um, newest_um, fallen) in [
            (50.0, 5.0, true),
            (20.0, 10.0, false),
            (20.0, 9.9, true),
            (100.0, 80.0, false),
            (100.0, 79.9, true),
            (5.0, 0.0, false),
            (5.0, 50.0, false),
        ] {
            assert_eq!(has_fallen(earlier_um, newest_um), fallen, "{earlier_um} {newest_um}");
        }
    }

    #[test]
    fn a_fifth_of_the_radius_is_the_most() {
        assert!((most_wear(Length::from_mm(5.0)).um() - 1000.0).abs() < 1e-9);
    }
}
