//! The taut string: of all paths from one value to another through given intervals, the path with the least travel.
//!
//! Its steepest piece is also the least steep of all paths. A string that is pulled tight bends only where the end of
//! an interval holds it. Between two such places, any other path must be as steep as the string somewhere.

/// The values at `at` (rising) of the taut string through the `rooms`. The first and the last room are points.
pub(super) fn taut_string(at: &[f64], rooms: &[[f64; 2]]) -> Vec<f64> {
    let count = at.len().min(rooms.len());
    let Some(&[mut value, _]) = rooms.first() else { return Vec::new() };
    let mut way = Vec::with_capacity(count);
    way.push(value);
    let mut from = 0;
    while from + 1 < count {
        let (to, reached) = next_bend(at, rooms, from, value);
        let slope = (reached - value) / (at[to] - at[from]);
        for index in from + 1..to {
            let straight = value + slope * (at[index] - at[from]);
            way.push(straight.max(rooms[index][0]).min(rooms[index][1]));
        }
        way.push(reached);
        (from, value) = (to, reached);
    }
    way
}

/// The index and the value where the string from `value` at `from` bends next, or its end.
fn next_bend(at: &[f64], rooms: &[[f64; 2]], from: usize, value: f64) -> (usize, f64) {
    let mut low = (f64::NEG_INFINITY, from + 1);
    let mut high = (f64::INFINITY, from + 1);
    let count = at.len().min(rooms.len());
    for index in from + 1..count {
        let [below, above] = rooms[index].map(|end| (end - value) / (at[index] - at[from]));
        if below > high.0 {
            return (high.1, rooms[high.1][1]);
        }
        if above < low.0 {
            return (low.1, rooms[low.1][0]);
        }
        if below >= low.0 {
            low = (below, index);
        }
        if above <= high.0 {
            high = (above, index);
        }
    }
    (count - 1, rooms[count - 1][0])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The least steepness, by bisection on the values that can be reached: a second method.
    fn least_steepness(at: &[f64], rooms: &[[f64; 2]]) -> f64 {
        let feasible = |steep: f64| {
            let mut reach = rooms[0];
            for k in 1..rooms.len() {
                let run = at[k] - at[k - 1];
                reach =
                    [(reach[0] - steep * run).max(rooms[k][0]), (reach[1] + steep * run).min(rooms[k][1])];
                if reach[0] > reach[1] + 1e-12 {
                    return false;
                }
            }
            true
        };
        let (mut low, mut high) = (0.0, 1e6);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if feasible(middle) { high = middle } else { low = middle }
        }
        high
    }

    proptest! {
        #[test]
        fn no_way_through_the_rooms_is_less_steep(
            steps in prop::collection::vec((0.01..2.0_f64, -10.0..10.0_f64, 0.0..8.0_f64, 0..8), 2..40),
        ) {
            let mut at = vec![0.0];
            let mut rooms = vec![[0.0, 0.0]];
            for (run, middle, half, free) in &steps {
                at.push(at[at.len() - 1] + run);
                rooms.push(if *free == 0 {
                    [f64::NEG_INFINITY, f64::INFINITY]
                } else {
                    [middle - half, middle + half]
                });
            }
            let last = rooms.len() - 1;
            rooms[last] = [steps[last - 1].1; 2];
            let way = taut_string(&at, &rooms);
            prop_assert_eq!(way.len(), rooms.len());
            for (value, room) in way.iter().zip(&rooms) {
                prop_assert!(room[0] <= *value && *value <= room[1]);
            }
            let steepest = (1..way.len())
                .map(|k| (way[k] - way[k - 1]).abs() / (at[k] - at[k - 1]))
                .fold(0.0, f64::max);
            let least = least_steepness(&at, &rooms);
            prop_assert!((steepest - least).abs() < 1e-6 * (1.0 + least), "{} {}", steepest, least);
        }
    }

    #[test]
    fn it_bends_only_at_the_corners_that_hold_it() {
        let at = [0.0, 1.0, 2.0, 3.0, 4.0];
        let rooms = [[0.0, 0.0], [-1.0, 0.5], [2.0, 3.0], [-9.0, 9.0], [0.0, 0.0]];
        assert_eq!(taut_string(&at, &rooms), [0.0, 0.5, 2.0, 1.0, 0.0]);
    }
}
