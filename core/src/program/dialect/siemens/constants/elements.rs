//! The elements of a variable. Most of them hold the same value.

use std::collections::BTreeMap;

/// The most elements of an array that get one value at once. If more get it, no element of the array is known any
/// more.
const MAX_REPEATED: usize = 1000;

/// The values of a variable's elements; `None` is not known. The memory for an array depends on what was assigned to
/// it, not on its size.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Elements {
    count: usize,
    /// The value of all elements that have no value of their own.
    rest: Option<f64>,
    own: BTreeMap<usize, Option<f64>>,
}

impl Elements {
    /// This number of elements, which all hold this value.
    pub(super) const fn new(count: usize, rest: Option<f64>) -> Self {
        Self { count, rest, own: BTreeMap::new() }
    }

    pub(super) const fn len(&self) -> usize {
        self.count
    }

    /// The value of an element, if the element exists and its value is known.
    pub(super) fn get(&self, index: usize) -> Option<f64> {
        if index >= self.count {
            return None;
        }
        self.own.get(&index).copied().unwrap_or(self.rest)
    }

    /// Gives all elements this value.
    pub(super) fn fill(&mut self, value: Option<f64>) {
        self.rest = value;
        self.own.clear();
    }

    /// Gives one element a value. If the assignment `may_be_skipped`, the value is known only if it is the same both
    /// ways.
    pub(super) fn set(&mut self, index: usize, value: Option<f64>, may_be_skipped: bool) {
        if index >= self.count {
            return;
        }
        let value = if may_be_skipped && self.get(index) != value { None } else { value };
        if self.count == 1 {
            self.rest = value;
        } else {
            self.own.insert(index, value);
        }
    }

    /// Gives a value to `count` elements from `first` on.
    pub(super) fn repeat(&mut self, first: usize, count: usize, value: Option<f64>, may_be_skipped: bool) {
        if first == 0 && count >= self.count {
            let same = self.own.is_empty() && self.rest == value;
            self.fill(if may_be_skipped && !same { None } else { value });
        } else if count > MAX_REPEATED {
            self.fill(None);
        } else {
            (first..first + count).for_each(|index| self.set(index, value, may_be_skipped));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_hold_what_was_assigned_last_however_it_was() {
        let mut elements = Elements::new(5000, Some(0.0));
        elements.set(7, Some(1.5), false);
        elements.repeat(9, 2, Some(3.0), false);
        assert_eq!([6, 7, 8, 9, 10, 11].map(|at| elements.get(at)), [0.0, 1.5, 0.0, 3.0, 3.0, 0.0].map(Some));
        assert_eq!(elements.get(5000), None);
        // The value is known only if it is the same whether the assignment is skipped or not.
        elements.set(7, Some(1.5), true);
        elements.set(9, Some(4.0), true);
        assert_eq!([7, 9, 10].map(|at| elements.get(at)), [Some(1.5), None, Some(3.0)]);
        elements.repeat(0, 5000, Some(2.0), false);
        assert_eq!([0, 9, 4999].map(|at| elements.get(at)), [Some(2.0); 3]);
        elements.repeat(0, 5000, Some(2.0), true);
        assert_eq!(elements.get(1), Some(2.0));
        elements.repeat(0, 5000, Some(1.0), true);
        assert_eq!(elements.get(1), None);
    }

    #[test]
    fn a_large_part_of_an_array_is_not_filled_one_by_one() {
        let mut elements = Elements::new(5000, Some(0.0));
        elements.repeat(1, 4999, Some(2.0), false);
        assert_eq!([0, 1].map(|at| elements.get(at)), [None, None]);
        assert!(elements.own.is_empty());
    }
}
