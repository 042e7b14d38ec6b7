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
