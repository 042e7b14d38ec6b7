//! Memory at the start of a line of the cache.
//!
//! A line has 64 bytes, and so has the widest vector. A vector that lies across two lines takes two accesses. The
//! allocator promises 16 bytes only, so without this three of four blocks of lanes would be read and written at half
//! the speed. The arrays of callers stay where they are.

use std::ops::{Deref, DerefMut};

/// A value at a multiple of 64 bytes.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Aligned<T>(pub(super) T);

impl<T> Deref for Aligned<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T> DerefMut for Aligned<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}
