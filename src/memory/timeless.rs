//! A cache without timing: accesses go through its tags one after another, and nothing is counted.

use super::allocation::NoAllocate;
use super::cache::Access;
use super::tags::{TagArray, Victim};
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// Tags and allocation rules. Two equal caches answer every sequence of accesses alike.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TimelessCache {
    tags: TagArray,
    no_allocate: NoAllocate,
}

impl TimelessCache {
    /// Creates a cache with these tags.
    pub(crate) fn new(tags: TagArray, no_allocate: NoAllocate) -> Self {
        Self { tags, no_allocate }
    }

    /// Accesses `line` and fills it after a miss that allocates. Returns whether it hit, and a dirty line to write
    /// back.
    #[inline]
    pub(crate) fn pass(&mut self, line: LineAddr, class: TrafficClass, access: Access) -> (bool, Option<Victim>) {
        if self.tags.access(line, access == Access::Write) {
            (true, None)
        } else {
            (false, self.miss(line, class, access))
        }
    }

    /// Fills an absent `line` if the access allocates. Returns a dirty line to write back.
    fn miss(&mut self, line: LineAddr, class: TrafficClass, access: Access) -> Option<Victim> {
        let dirty = access == Access::Write;
        let victim = if self.no_allocate.keeps(class, access != Access::Read) {
            self.tags.fill(line, class, dirty)
        } else {
            Some(Victim { line, class, dirty })
        };
        victim.filter(|victim| victim.dirty)
    }

    /// A copy in which `name` renames each line to one of the same set.
    pub(crate) fn renamed(&self, name: impl Fn(LineAddr) -> LineAddr) -> Self {
        let mut renamed = self.clone();
        renamed.tags.rename(name);
        renamed
    }

    /// Its tags.
    pub(crate) fn tags(&self) -> &TagArray {
        &self.tags
    }

    /// Approximate memory use of the tags in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.tags.bytes()
    }

    /// Drops all lines from `first` on.
    pub(crate) fn drop_from(&mut self, first: LineAddr) {
        self.tags.drop_from(first);
    }
}
