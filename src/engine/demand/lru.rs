//! What caches hold, as tags without time: the least recently used line of a set goes.

use std::collections::VecDeque;

/// A way without a line.
const EMPTY: u32 = u32::MAX;

/// The tags of a cache.
#[derive(Clone, Debug)]
pub(super) struct Lru {
    /// Lines set by set, the most recently used one first.
    lines: Vec<u32>,
    ways: usize,
    /// Sets, a power of two, less one.
    mask: u32,
}

impl Lru {
    /// An empty cache of so many lines.
    pub(super) fn new(lines: u64, ways: u64) -> Self {
        let (lines, ways) = (lines.max(ways) as usize, ways as usize);
        Self { lines: vec![EMPTY; lines], ways, mask: (lines / ways) as u32 - 1 }
    }

    fn set(&mut self, line: u32) -> &mut [u32] {
        let first = (line & self.mask) as usize * self.ways;
        &mut self.lines[first..first + self.ways]
    }

    /// Whether `line` is there; it is the most recently used of its set then.
    pub(super) fn uses(&mut self, line: u32) -> bool {
        let set = self.set(line);
        if set[0] == line {
            return true;
        }
        let way = set.iter().position(|&other| other == line);
        if let Some(way) = way {
            set.copy_within(..way, 1);
            set[0] = line;
        }
        way.is_some()
    }

    /// Puts in `line`, which is not there.
    pub(super) fn fill(&mut self, line: u32) {
        let set = self.set(line);
        set.copy_within(..set.len() - 1, 1);
        set[0] = line;
    }

    /// Drops all lines from `first` on.
    pub(super) fn drop_from(&mut self, first: u32) {
        self.lines.iter_mut().filter(|line| **line >= first).for_each(|line| *line = EMPTY);
    }
}

/// The tags of a unit's L1. A line that it asks for comes some accesses later. Until then it displaces nothing, and
/// whoever wants it waits for it.
#[derive(Clone, Debug)]
pub(super) struct Filling {
    tags: Lru,
    /// Lines that were asked for, and after how many accesses they come.
    coming: VecDeque<(u32, u64)>,
    accesses: u64,
    delay: u64,
    most: usize,
}

impl Filling {
    /// An empty L1 whose lines come `delay` accesses after they were asked for, and `most` of which are under way.
    pub(super) fn new(tags: Lru, delay: u64, most: usize) -> Self {
        Self { tags, coming: VecDeque::with_capacity(most), accesses: 0, delay, most }
    }

    /// Accesses `line`. Returns whether the L1 asks for it.
    pub(super) fn misses(&mut self, line: u32) -> bool {
        self.accesses += 1;
        while self.coming.front().is_some_and(|&(_, at)| at <= self.accesses) {
            self.comes();
        }
        if self.tags.uses(line) || self.coming.iter().any(|&(other, _)| other == line) {
            return false;
        }
        if self.coming.len() == self.most {
            self.comes();
        }
        self.coming.push_back((line, self.accesses + self.delay));
        true
    }

    fn comes(&mut self) {
        if let Some((line, _)) = self.coming.pop_front() {
            self.tags.fill(line);
        }
    }

    /// Drops all lines from `first` on.
    pub(super) fn drop_from(&mut self, first: u32) {
        self.tags.drop_from(first);
        self.coming.retain(|&(line, _)| line < first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_recently_used_line_goes() {
        let mut tags = Lru::new(4, 2);
        let mut missed = |line: u32| {
            let missed = !tags.uses(line);
            if missed {
                tags.fill(line);
            }
            missed
        };
        assert_eq!([0, 2, 0, 4, 0, 2, 1].map(&mut missed), [true, true, false, true, false, true, true]);
        tags.drop_from(2);
        assert_eq!([0, 1, 2].map(|line| tags.uses(line)), [true, true, false]);
    }

    #[test]
    fn a_line_that_comes_later_displaces_later() {
        let missed = |delay: u64, most: usize| {
            let mut l1 = Filling::new(Lru::new(1, 1), delay, most);
            [0, 1, 2, 0].map(|line| l1.misses(line))
        };
        assert_eq!(missed(0, 8), [true; 4], "each displaces the one before at once");
        assert_eq!(missed(4, 8), [true, true, true, false], "the first is still under way");
        assert_eq!(missed(4, 1), [true; 4], "one is under way: each came when the next was asked for");
    }
}
