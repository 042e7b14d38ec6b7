//! The elements of a variable, of which most hold the same.

use std::collections::BTreeMap;

/// Most elements of a part of an array that get one value at once; of larger parts nothing is known any more.
const MAX_REPEATED: usize = 1000;

/// What the elements of a variable hold; `None` is not known. An array costs what was assigned to it, not its size.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Elements {
    count: usize,
    /// What all hold that have no value of their own.
    rest: Option<f64>,
    own: BTreeMap<usize, Option<f64>>,
}

impl Elements {
    /// So many, which all hold this.
    pub(super) const fn new(count: usize, rest: Option<f64>) -> Self {
        Self { count, rest, own: BTreeMap::new() }
    }

    pub(super) const fn len(&self) -> usize {
        self.count
    }

    /// The value of an element, if it is one and known.
    pub(super) fn get(&self, index: usize) -> Option<f64> {
        if index >= self.count {
            return None;
        }
        self.own.get(&index).copied().unwrap_or(self.rest)
    }

    /// All hold this.
    pub(super) fn fill(&mut self, value: Option<f64>) {
        self.rest = value;
        self.own.clear();
    }

    /// One gets a value. What `may_be_skipped` is known only if it is the same both ways.
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

    /// So many from `first` on get a value.
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
        // Skipped or not: known only if it is the same both ways.
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
