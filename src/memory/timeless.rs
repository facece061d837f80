//! A cache without time: accesses go through its tags one after another, and nothing is counted.

use super::allocation::NoAllocate;
use super::cache::Access;
use super::tags::{TagArray, Victim};
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// Tags, and which accesses give a line a place in them. Two that are equal do alike whatever they are asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TimelessCache {
    tags: TagArray,
    no_allocate: NoAllocate,
}

impl TimelessCache {
    /// A cache with these tags.
    pub(crate) fn new(tags: TagArray, no_allocate: NoAllocate) -> Self {
        Self { tags, no_allocate }
    }

    /// Accesses `line`, and fills it if it is not there and is to be kept: whether it was, and a dirty line that went.
    #[inline]
    pub(crate) fn pass(&mut self, line: LineAddr, class: TrafficClass, access: Access) -> (bool, Option<Victim>) {
        if self.tags.access(line, access == Access::Write) {
            (true, None)
        } else {
            (false, self.miss(line, class, access))
        }
    }

    /// Fills `line`, which is not there, if it is to be kept; a dirty line that goes.
    fn miss(&mut self, line: LineAddr, class: TrafficClass, access: Access) -> Option<Victim> {
        let dirty = access == Access::Write;
        let victim = if self.no_allocate.keeps(class, access != Access::Read) {
            self.tags.fill(line, class, dirty)
        } else {
            Some(Victim { line, class, dirty })
        };
        victim.filter(|victim| victim.dirty)
    }

    /// The same, each line of which is another one of its set.
    pub(crate) fn renamed(&self, name: impl Fn(LineAddr) -> LineAddr) -> Self {
        let mut renamed = self.clone();
        renamed.tags.rename(name);
        renamed
    }

    /// Its tags.
    pub(crate) fn tags(&self) -> &TagArray {
        &self.tags
    }

    /// What its tags take in memory, about.
    pub(crate) fn bytes(&self) -> usize {
        self.tags.bytes()
    }

    /// Drops all lines from `first` on.
    pub(crate) fn drop_from(&mut self, first: LineAddr) {
        self.tags.drop_from(first);
    }
}
