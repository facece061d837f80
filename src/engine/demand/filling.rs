//! An L1 whose lines come some time after their requests, simulated as tags without timing.

use std::collections::VecDeque;

use crate::memory::tags::TagArray;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// The tags of a unit's L1. A requested line comes some accesses later. Until then it displaces nothing, and accesses
/// to it wait for it.
#[derive(Clone, Debug)]
pub(super) struct Filling {
    tags: TagArray,
    /// Requested lines: the line, its class, and the access number at which it comes.
    coming: VecDeque<(LineAddr, TrafficClass, u64)>,
    accesses: u64,
    delay: u64,
    most: usize,
}

impl Filling {
    /// An empty L1 whose lines come `delay` accesses after their requests; at most `most` are on their way.
    pub(super) fn new(tags: TagArray, delay: u64, most: usize) -> Self {
        Self { tags, coming: VecDeque::with_capacity(most), accesses: 0, delay, most }
    }

    /// Accesses `line`. Returns whether the L1 requests it.
    pub(super) fn misses(&mut self, line: LineAddr, class: TrafficClass) -> bool {
        self.accesses += 1;
        while self.coming.front().is_some_and(|&(.., at)| at <= self.accesses) {
            self.comes();
        }
        if self.tags.access(line, false) || self.coming.iter().any(|&(other, ..)| other == line) {
            return false;
        }
        if self.coming.len() == self.most {
            self.comes();
        }
        self.coming.push_back((line, class, self.accesses + self.delay));
        true
    }

    fn comes(&mut self) {
        if let Some((line, class, _)) = self.coming.pop_front() {
            self.tags.fill(line, class, false);
        }
    }

    /// Drops all lines from `first` on.
    pub(super) fn drop_from(&mut self, first: LineAddr) {
        self.tags.drop_from(first);
        self.coming.retain(|&(line, ..)| line < first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::replacement::Policy;

    #[test]
    fn a_line_that_comes_later_displaces_later() {
        let missed = |delay: u64, most: usize| {
            let mut l1 = Filling::new(TagArray::new(1, 1, 0, Policy::Lru), delay, most);
            [0, 1, 2, 0].map(|line| l1.misses(LineAddr(line), TrafficClass::Node))
        };
        assert_eq!(missed(0, 8), [true; 4], "each displaces the one before at once");
        assert_eq!(missed(4, 8), [true, true, true, false], "the first is still under way");
        assert_eq!(missed(4, 1), [true; 4], "one is under way: each came when the next was asked for");
    }
}
