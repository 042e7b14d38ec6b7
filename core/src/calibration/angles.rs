//! The number of angles visited.

use std::f64::consts::TAU;

/// Number of different angles of one turn \[rad\]. Angles closer than `same_rad` to an earlier one, with or without
/// whole turns between them, are counted once.
pub(super) fn different_angles(angles_rad: impl Iterator<Item = f64>, same_rad: f64) -> usize {
    let mut angles: Vec<f64> = angles_rad.map(|angle_rad| angle_rad.rem_euclid(TAU)).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|after, before| *after - *before < same_rad);
    let (first, last) = (angles.first(), angles.last());
    let closes = first.zip(last).is_some_and(|(first, last)| first + TAU - last < same_rad);
    angles.len() - usize::from(closes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_turns_and_both_ends_of_a_turn_are_counted_once() {
        let count = |angles: &[f64]| different_angles(angles.iter().copied(), 1e-6);
        assert_eq!(count(&[]), 0);
        assert_eq!(count(&[1.0]), 1);
        assert_eq!(count(&[0.0, 1.0, 1.0 + TAU, 2.0 - 3.0 * TAU, 2.0]), 3);
        assert_eq!(count(&[0.5 * TAU, -0.5 * TAU, 0.0, -1e-7, 1e-7]), 2);
        assert_eq!(count(&[-1e-20, 1.0]), 2);
    }
}
