//! The tag array of a set-associative cache: its lines and the replacement of lines. It has no timing; all engines use
//! it.

use std::mem::replace;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::replacement::{Policy, State};
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// A way without a line.
const EMPTY: u64 = u64::MAX;
/// A packed entry: the line number above `LINE_SHIFT`, then the dirty bit, then the class.
const LINE_SHIFT: u32 = 8;
const DIRTY: u64 = 1 << 7;

fn pack(line: LineAddr, class: TrafficClass, dirty: bool) -> u64 {
    line.0 << LINE_SHIFT | if dirty { DIRTY } else { 0 } | class as u64
}

fn unpack(packed: u64) -> Option<Victim> {
    (packed != EMPTY).then(|| Victim {
        line: LineAddr(packed >> LINE_SHIFT),
        class: TrafficClass::ALL[(packed & (DIRTY - 1)) as usize],
        dirty: packed & DIRTY != 0,
    })
}

/// A line that is displaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Victim {
    /// The line.
    pub line: LineAddr,
    /// The traffic class of the line.
    pub class: TrafficClass,
    /// Whether it must be written back.
    pub dirty: bool,
}

/// What a cache holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Contents {
    /// The lines in its tags: a normal cache.
    #[default]
    Tags,
    /// Every line: all accesses hit, and there is no traffic with the level below. For bounds; size, ways, replacement
    /// and MSHRs have no effect.
    Ideal,
}

/// A place in a tag array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    set: usize,
    way: usize,
}

/// The tags of a cache.
#[derive(Clone, Debug, PartialEq)]
pub struct TagArray {
    /// Packed lines, set by set; empty for an ideal cache.
    lines: Vec<u64>,
    state: State,
    /// Whether each set has two lines in LRU order and the set index is the line's lowest bits, as in most L1s.
    pairs: bool,
    ways: usize,
    set_mask: u64,
    set_shift: u32,
}

impl TagArray {
    /// An empty array of `sets` (a power of two) times `ways` lines. The set of a line is its number without the low
    /// `set_shift` bits (which select the bank), modulo `sets`.
    pub fn new(sets: usize, ways: usize, set_shift: u32, policy: Policy) -> Self {
        debug_assert!(sets.is_power_of_two() && ways > 0);
        let state = State::new(policy, sets);
        let pairs = ways == 2 && set_shift == 0 && state.is_used_order();
        Self { lines: vec![EMPTY; sets * ways], state, pairs, ways, set_mask: sets as u64 - 1, set_shift }
    }

    /// The array of an ideal cache.
    pub fn ideal() -> Self {
        Self { lines: Vec::new(), state: State::new(Policy::Lru, 0), pairs: false, ways: 0, set_mask: 0, set_shift: 0 }
    }

    /// Approximate memory use in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.lines.as_slice())
    }

    fn is_ideal(&self) -> bool {
        self.lines.is_empty()
    }

    #[inline]
    fn set(&self, line: LineAddr) -> usize {
        (line.0 >> self.set_shift & self.set_mask) as usize
    }

    fn ways(&self, set: usize) -> &[u64] {
        &self.lines[set * self.ways..][..self.ways]
    }

    /// Uses `line` and makes it dirty if `write`; returns whether it was there.
    #[inline]
    pub fn access(&mut self, line: LineAddr, write: bool) -> bool {
        let dirty = if write { DIRTY } else { 0 };
        // Most uses hit the most recently used line, whose order does not change.
        if self.pairs {
            let set = (line.0 & self.set_mask) as usize;
            let Some([front, back]) = self.lines.as_chunks_mut().0.get_mut(set) else { return false };
            if *front >> LINE_SHIFT == line.0 {
                *front |= dirty;
                return true;
            }
            let is_there = *back >> LINE_SHIFT == line.0;
            if is_there {
                (*front, *back) = (*back | dirty, *front);
            }
            return is_there;
        }
        let first = self.set(line) * self.ways;
        // An ideal cache has no lines.
        let Some(front) = self.lines.get_mut(first) else { return true };
        if *front >> LINE_SHIFT == line.0 && self.state.is_order() {
            *front |= dirty;
            return true;
        }
        self.access_behind(first, line, dirty)
    }

    /// As [`TagArray::access`], for any way of the set whose lines begin at index `first`.
    fn access_behind(&mut self, first: usize, line: LineAddr, dirty: u64) -> bool {
        let lines = &mut self.lines[first..first + self.ways];
        let Some(way) = lines.iter().position(|&packed| packed >> LINE_SHIFT == line.0) else { return false };
        lines[way] |= dirty;
        self.state.used((line.0 >> self.set_shift & self.set_mask) as usize, way, lines);
        true
    }

    /// Whether `line` is there. Changes nothing.
    pub fn contains(&self, line: LineAddr) -> bool {
        self.is_ideal() || self.ways(self.set(line)).iter().any(|&packed| packed >> LINE_SHIFT == line.0)
    }

    /// The line that [`TagArray::fill`] would displace. Changes nothing.
    pub fn victim(&self, line: LineAddr) -> Option<Victim> {
        self.at(self.place_for(line))
    }

    /// The place for an absent `line`: the lowest empty way, otherwise the victim's way.
    #[inline]
    pub fn place_for(&self, line: LineAddr) -> Place {
        debug_assert!(!self.contains(line));
        let set = self.set(line);
        let empty = self.ways(set).iter().position(|&packed| packed == EMPTY);
        Place { set, way: empty.unwrap_or_else(|| self.state.victim(set, self.ways)) }
    }

    /// The line at a place.
    #[inline]
    pub fn at(&self, place: Place) -> Option<Victim> {
        unpack(self.ways(place.set)[place.way])
    }

    /// Puts `line` into a place from [`TagArray::place_for`].
    #[inline]
    pub fn put(&mut self, Place { set, way }: Place, line: LineAddr, class: TrafficClass, dirty: bool) {
        let lines = &mut self.lines[set * self.ways..][..self.ways];
        lines[way] = pack(line, class, dirty);
        self.state.filled(set, way, lines);
    }

    /// Fills the absent `line`; returns the displaced line.
    pub fn fill(&mut self, line: LineAddr, class: TrafficClass, dirty: bool) -> Option<Victim> {
        if self.pairs {
            let new = pack(line, class, dirty);
            let [front, back] = self.lines.as_chunks_mut().0.get_mut((line.0 & self.set_mask) as usize)?;
            return match replace(front, new) {
                EMPTY => None,
                second => unpack(replace(back, second)),
            };
        }
        let place = self.place_for(line);
        let displaced = self.at(place);
        self.put(place, line, class, dirty);
        displaced
    }

    /// Distance in lines between neighbouring lines of the same set.
    pub fn span(&self) -> u64 {
        (self.set_mask + 1) << self.set_shift
    }

    /// Renames each line; `name` must keep the line's set.
    pub fn rename(&mut self, name: impl Fn(LineAddr) -> LineAddr) {
        for packed in self.lines.iter_mut().filter(|packed| **packed != EMPTY) {
            *packed = name(LineAddr(*packed >> LINE_SHIFT)).0 << LINE_SHIFT | *packed & ((1 << LINE_SHIFT) - 1);
        }
    }

    /// Drops a line, dirty or not, if it is there.
    pub fn drop_line(&mut self, line: LineAddr) {
        let set = self.set(line);
        let ways = &mut self.lines[set * self.ways..][..self.ways];
        ways.iter_mut().filter(|packed| **packed >> LINE_SHIFT == line.0).for_each(|packed| *packed = EMPTY);
    }

    /// Drops all lines from `first` on, dirty or not.
    pub fn drop_from(&mut self, first: LineAddr) {
        for packed in &mut self.lines {
            if *packed >> LINE_SHIFT >= first.0 {
                *packed = EMPTY;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn misses(tags: &mut TagArray, lines: impl IntoIterator<Item = u64>) -> usize {
        let mut misses = 0;
        for line in lines.into_iter().map(LineAddr) {
            if !tags.access(line, false) {
                tags.fill(line, TrafficClass::Node, false);
                misses += 1;
            }
        }
        misses
    }

    /// Belady, Nelson and Shedler 1969: more room, more misses.
    #[test]
    fn fifo_shows_beladys_anomaly() {
        let lines = [1, 2, 3, 4, 1, 2, 5, 1, 2, 3, 4, 5];
        for (policy, ways, expected) in
            [(Policy::Fifo, 3, 9), (Policy::Fifo, 4, 10), (Policy::Lru, 3, 10), (Policy::Lru, 4, 8)]
        {
            assert_eq!(misses(&mut TagArray::new(1, ways, 0, policy), lines), expected, "{policy:?}, {ways} lines");
        }
    }

    #[test]
    fn tree_plru_of_two_ways_is_lru_and_of_four_is_not() {
        let lines = || [1, 2, 3, 1, 4, 2, 5, 1, 3, 3, 2, 6, 1, 4];
        let count = |policy, ways| misses(&mut TagArray::new(1, ways, 0, policy), lines());
        assert_eq!(count(Policy::TreePlru, 2), count(Policy::Lru, 2));
        // 1 to 4 fill the ways in order. A use of 1 points the root to the other half, whose bit points to 3: the least
        // recently used line is 2, but 3 goes.
        let mut tags = TagArray::new(1, 4, 0, Policy::TreePlru);
        assert_eq!(misses(&mut tags, [1, 2, 3, 4, 1]), 4);
        assert_eq!(tags.victim(LineAddr(9)).map(|victim| victim.line), Some(LineAddr(3)));
    }

    #[test]
    fn a_dirty_line_is_displaced_as_such_and_dropped_lines_are_not() {
        let mut tags = TagArray::new(1, 1, 0, Policy::Lru);
        tags.fill(LineAddr(4), TrafficClass::ModeWord, false);
        assert!(tags.access(LineAddr(4), true));
        let expected = Victim { line: LineAddr(4), class: TrafficClass::ModeWord, dirty: true };
        assert_eq!(tags.victim(LineAddr(5)), Some(expected));
        assert_eq!(tags.fill(LineAddr(5), TrafficClass::Node, false), Some(expected));
        tags.drop_from(LineAddr(6));
        assert!(tags.contains(LineAddr(5)));
        tags.drop_from(LineAddr(5));
        assert_eq!(tags.victim(LineAddr(6)), None);
    }

    #[test]
    fn a_set_is_chosen_by_the_bits_above_the_banks() {
        let mut tags = TagArray::new(2, 1, 2, Policy::Lru);
        assert_eq!(misses(&mut tags, [0, 4, 0, 4, 8, 0]), 4, "0 and 8 share a set, 4 is in the other");
    }

    proptest! {
        /// Sets of two lines have code of their own: compares them with lists in LRU order.
        #[test]
        fn pairs_are_lists_in_the_order_of_uses(steps in prop::collection::vec((0..12u64, 0..8u8), 1..200)) {
            let mut tags = TagArray::new(2, 2, 0, Policy::Lru);
            let mut sets: [Vec<(u64, bool)>; 2] = Default::default();
            for (number, what) in steps {
                let (line, write, set) = (LineAddr(number), what % 2 == 1, &mut sets[number as usize % 2]);
                if what >= 6 {
                    tags.drop_line(line);
                    set.retain(|&(other, _)| other != number);
                    continue;
                }
                let place = set.iter().position(|&(other, _)| other == number);
                prop_assert_eq!(tags.access(line, write), place.is_some());
                let dirty = place.map(|place| set.remove(place).1);
                set.insert(0, (number, write || dirty == Some(true)));
                let gone = if set.len() > 2 { set.pop() } else { None };
                if place.is_none() {
                    let victim = tags.fill(line, TrafficClass::Node, write);
                    prop_assert_eq!(victim.map(|victim| (victim.line.0, victim.dirty)), gone);
                }
            }
        }

        /// Mattson et al. 1970: an LRU set of `n + 1` lines holds all lines of an LRU set of `n` lines.
        #[test]
        fn lru_sets_include_smaller_ones(lines in prop::collection::vec(0..24u64, 1..200), ways in 1..12usize, sets in 0..3u32) {
            let mut small = TagArray::new(1 << sets, ways, 0, Policy::Lru);
            let mut large = TagArray::new(1 << sets, ways + 1, 0, Policy::Lru);
            for &line in &lines {
                misses(&mut small, [line]);
                misses(&mut large, [line]);
                for line in (0..24).map(LineAddr) {
                    prop_assert!(!small.contains(line) || large.contains(line));
                }
            }
        }

        /// For every policy: a filled line is there, a set holds at most `ways` lines, and the announced victim is
        /// displaced.
        #[test]
        fn every_policy_keeps_its_word(lines in prop::collection::vec(0..64u64, 1..200), policy in 0..4usize) {
            let policy = [Policy::Lru, Policy::Fifo, Policy::TreePlru, Policy::Random { seed: 7 }][policy];
            let mut tags = TagArray::new(2, 4, 0, policy);
            for line in lines.into_iter().map(LineAddr) {
                if !tags.access(line, false) {
                    let announced = tags.victim(line);
                    prop_assert_eq!(tags.fill(line, TrafficClass::Node, false), announced);
                    prop_assert!(announced.is_none_or(|victim| !tags.contains(victim.line)));
                }
                prop_assert!(tags.contains(line));
                prop_assert!((0..64).map(LineAddr).filter(|&line| tags.contains(line)).count() <= 8);
            }
        }
    }
}
