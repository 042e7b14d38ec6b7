//! Long work on a mesh asks at intervals whether to continue.

use std::ops::ControlFlow;

use super::MeshFault;

/// Steps between two questions. A step is one facet, corner, vertex or slot and takes at most 0.2 µs, so two
/// questions are at most 2 ms apart.
pub(super) const ASK_EVERY: usize = 1 << 13;
/// Items that are sorted between two questions: some milliseconds.
const SORTED_AT_ONCE: usize = 1 << 16;
/// Facets that are divided at their median between two questions: some 10 ms. A larger tree is divided in parts,
/// which gives other leaves. A change of this number therefore changes results.
pub(super) const DIVIDED_AT_ONCE: usize = 1 << 19;

/// Asks `stop` after every [`ASK_EVERY`] steps.
pub(super) struct Asking<'s> {
    stop: &'s dyn Fn() -> ControlFlow<()>,
    unasked: usize,
}

impl<'s> Asking<'s> {
    pub(super) fn new(stop: &'s dyn Fn() -> ControlFlow<()>) -> Self {
        Self { stop, unasked: 0 }
    }

    /// Counts `steps` steps.
    ///
    /// # Errors
    /// The caller no longer waits.
    #[inline]
    pub(super) fn after(&mut self, steps: usize) -> Result<(), MeshFault> {
        self.unasked += steps;
        if self.unasked < ASK_EVERY {
            return Ok(());
        }
        self.unasked = 0;
        if (self.stop)().is_break() { Err(MeshFault::Cancelled) } else { Ok(()) }
    }
}

/// Sorts by keys that all differ.
///
/// # Errors
/// The caller no longer waits.
pub(super) fn sort_by_unique_key<T: Copy, K: Ord>(
    items: &mut Vec<T>,
    key: impl Fn(&T) -> K,
    asking: &mut Asking<'_>,
) -> Result<(), MeshFault> {
    asking.after(items.len())?;
    if items.len() <= SORTED_AT_ONCE {
        items.sort_unstable_by_key(key);
        return Ok(());
    }
    for some in items.chunks_mut(SORTED_AT_ONCE) {
        some.sort_unstable_by_key(&key);
        asking.after(some.len())?;
    }
    // Pairs of sorted stretches are merged until one is left.
    let mut length = SORTED_AT_ONCE;
    let mut merged = Vec::with_capacity(items.len());
    while length < items.len() {
        merged.clear();
        for pair in items.chunks(2 * length) {
            let (left, right) = pair.split_at(length.min(pair.len()));
            let (mut left, mut right) = (left.iter().copied().peekable(), right.iter().copied().peekable());
            loop {
                asking.after(1)?;
                let takes_right = match (left.peek(), right.peek()) {
                    (Some(a), Some(b)) => key(b) < key(a),
                    (None, Some(_)) => true,
                    (Some(_), None) => false,
                    (None, None) => break,
                };
                merged.extend(if takes_right { right.next() } else { left.next() });
            }
        }
        std::mem::swap(items, &mut merged);
        length *= 2;
    }
    Ok(())
}

/// Moves the items with the smallest keys into the first `count` places. All keys differ.
///
/// # Errors
/// The caller no longer waits.
pub(super) fn divide_at<T: Copy>(
    items: &mut [T],
    count: usize,
    key: impl Fn(&T) -> u64,
    asking: &mut Asking<'_>,
) -> Result<(), MeshFault> {
    asking.after(items.len())?;
    if items.len() <= DIVIDED_AT_ONCE {
        if count < items.len() {
            items.select_nth_unstable_by_key(count, key);
        }
        return Ok(());
    }
    // The key of the first item of the second part, 16 bits at a time.
    let (mut known, mut below) = (0_u64, count);
    let mut counts = vec![0_usize; 1 << DIGIT_BITS];
    for shift in [48, 32, 16, 0] {
        counts.fill(0);
        for some in items.chunks(ASK_EVERY) {
            for item in some {
                let key = key(item);
                // The bits above this digit; there are none for the first.
                let above = key.checked_shr(shift + DIGIT_BITS).unwrap_or(0);
                if above == known {
                    #[expect(clippy::cast_possible_truncation, reason = "16 bits")]
                    let digit = (key >> shift) as usize & (counts.len() - 1);
                    if let Some(count) = counts.get_mut(digit) {
                        *count += 1;
                    }
                }
            }
            asking.after(some.len())?;
        }
        let mut digit = 0_u64;
        for found in &counts {
            if below < *found {
                break;
            }
            below -= found;
            digit += 1;
        }
        known = known << DIGIT_BITS | digit;
    }
    let (mut from, mut to) = (0, items.len());
    while from < to {
        asking.after(1)?;
        let is_low = |at: usize| items.get(at).is_some_and(|item| key(item) < known);
        if is_low(from) {
            from += 1;
        } else if is_low(to - 1) {
            items.swap(from, to - 1);
        } else {
            to -= 1;
        }
    }
    Ok(())
}

const DIGIT_BITS: u32 = 16;

#[cfg(test)]
mod tests {
    use super::*;

    fn go_on() -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Keys that all differ, in no order.
    fn keys(count: u64, crowded: bool) -> Vec<u64> {
        let spread = |k: u64| k.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (0..count).map(|k| if crowded { (spread(k) >> 60 << 32) + k } else { spread(k) }).collect()
    }

    #[test]
    fn what_is_sorted_in_stretches_is_sorted() {
        for count in [0, 1, 700_000, 9 * SORTED_AT_ONCE as u64 + 11] {
            let mut items = keys(count, false);
            let mut expected = items.clone();
            expected.sort_unstable();
            sort_by_unique_key(&mut items, |item| *item, &mut Asking::new(&go_on)).unwrap();
            assert!(items == expected, "{count}");
        }
    }

    #[test]
    fn what_is_divided_has_the_least_in_front() {
        for crowded in [false, true] {
            for count in [10, 1000, DIVIDED_AT_ONCE + 1, 2 * DIVIDED_AT_ONCE + 3] {
                for front in [0, 1, count / 2, count - 1, count] {
                    let mut items = keys(count as u64, crowded);
                    let mut expected = items.clone();
                    expected.sort_unstable();
                    divide_at(&mut items, front, |item| *item, &mut Asking::new(&go_on)).unwrap();
                    let (left, right) = items.split_at_mut(front);
                    left.sort_unstable();
                    right.sort_unstable();
                    assert!(*left == expected[..front] && *right == expected[front..], "{count}, {front}");
                }
            }
        }
    }
}
