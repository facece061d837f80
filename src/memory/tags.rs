//! The tag array of a set-associative cache: what is in it, and what goes. It knows no time; engines share it.

use super::replacement::{Policy, State};
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

const EMPTY: u64 = u64::MAX;

/// A line of the array besides its tag.
#[derive(Clone, Copy, Debug)]
struct Entry {
    class: TrafficClass,
    dirty: bool,
}

/// A line that goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Victim {
    /// The line.
    pub line: LineAddr,
    /// What it was for.
    pub class: TrafficClass,
    /// Whether it must be written back.
    pub dirty: bool,
}

/// The tags of a cache.
#[derive(Clone, Debug)]
pub struct TagArray {
    tags: Vec<u64>,
    entries: Vec<Entry>,
    state: State,
    ways: usize,
    set_mask: u64,
    set_shift: u32,
}

impl TagArray {
    /// An empty array of `sets` (a power of two) times `ways` lines. A line's set is its number without the low
    /// `set_shift` bits (which chose the bank), modulo the sets.
    pub fn new(sets: usize, ways: usize, set_shift: u32, policy: Policy) -> Self {
        debug_assert!(sets.is_power_of_two() && ways > 0);
        Self {
            tags: vec![EMPTY; sets * ways],
            entries: vec![Entry { class: TrafficClass::Node, dirty: false }; sets * ways],
            state: State::new(policy, sets, ways),
            ways,
            set_mask: sets as u64 - 1,
            set_shift,
        }
    }

    fn set(&self, line: LineAddr) -> usize {
        (line.0 >> self.set_shift & self.set_mask) as usize
    }

    fn find(&self, line: LineAddr) -> Option<(usize, usize)> {
        let set = self.set(line);
        self.tags[set * self.ways..][..self.ways].iter().position(|&tag| tag == line.0).map(|way| (set, way))
    }

    /// Uses `line`, which makes it dirty if `write`; whether it was there.
    pub fn access(&mut self, line: LineAddr, write: bool) -> bool {
        let Some((set, way)) = self.find(line) else { return false };
        self.state.used(set, way, self.ways);
        self.entries[set * self.ways + way].dirty |= write;
        true
    }

    /// Whether `line` is there; nothing changes.
    pub fn contains(&self, line: LineAddr) -> bool {
        self.find(line).is_some()
    }

    fn place(&self, line: LineAddr) -> (usize, usize) {
        let set = self.set(line);
        let tags = &self.tags[set * self.ways..][..self.ways];
        let way = tags.iter().position(|&tag| tag == EMPTY).unwrap_or_else(|| self.state.victim(set, self.ways));
        (set, way)
    }

    fn at(&self, place: usize) -> Option<Victim> {
        let Entry { class, dirty } = self.entries[place];
        (self.tags[place] != EMPTY).then_some(Victim { line: LineAddr(self.tags[place]), class, dirty })
    }

    /// What [`TagArray::fill`] would displace; nothing changes.
    pub fn victim(&self, line: LineAddr) -> Option<Victim> {
        let (set, way) = self.place(line);
        self.at(set * self.ways + way)
    }

    /// Puts in `line`, which is not there. An empty way is taken first, the lowest; returns what was displaced.
    pub fn fill(&mut self, line: LineAddr, class: TrafficClass, dirty: bool) -> Option<Victim> {
        debug_assert!(!self.contains(line));
        let (set, way) = self.place(line);
        let place = set * self.ways + way;
        let victim = self.at(place);
        self.tags[place] = line.0;
        self.entries[place] = Entry { class, dirty };
        self.state.filled(set, way, self.ways);
        victim
    }

    /// Drops all lines from `first` on, dirty or not.
    pub fn drop_from(&mut self, first: LineAddr) {
        for tag in &mut self.tags {
            if *tag >= first.0 {
                *tag = EMPTY;
            }
        }
    }
}
