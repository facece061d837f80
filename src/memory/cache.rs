//! A non-blocking cache: tags, MSHRs, counts, and the spec of the L1s.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::allocation::NoAllocate;
use super::mshr::{FillPolicy, MshrFile};
use super::replacement::Policy;
use super::tags::{Contents, TagArray, Victim};
use crate::quantity::{Bytes, LineAddr};
use crate::ranged::{PowerOfTwo, Size, Within};
use crate::stats::{CacheCounts, L1Counts, TrafficClass};

/// How accesses that wait in an MSHR receive their line when it arrives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Release {
    /// All at once; the MSHR is free immediately.
    #[default]
    Together,
    /// One per cycle, in cycles without another access, like the rows of a ray accumulation unit (Nah et al. 2011,
    /// section 4).
    OneByOne,
}

/// An L1 cache.
///
/// Source: the T&I engine's traversal cache (Nah et al. 2011, section 5: 8 KB, 2 ways, latency 1, one port; 8 rows of 4
/// rays wait for lines).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CacheSpec {
    /// What the cache holds.
    pub contents: Contents,
    /// Size in bytes.
    pub bytes: Size<32, 0x1000_0000>,
    /// Lines per set.
    pub ways: Within<1, 64>,
    /// Which line of a full set is evicted.
    pub replacement: Policy,
    /// Accesses that do not allocate a line.
    pub no_allocate: NoAllocate,
    /// Cycles from a hit to its data.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 1000>,
    /// Accesses per cycle.
    pub ports: Within<1, 16>,
    /// Number of banks; each bank takes one access per cycle. Without banks, every port reaches every line.
    pub banks: Option<PowerOfTwo<1, 64>>,
    /// Number of MSHRs (miss status holding registers).
    pub mshrs: Within<1, 1024>,
    /// Accesses that can wait in one MSHR.
    pub targets: Within<1, 1024>,
    /// How accesses that wait in an MSHR receive their line.
    pub release: Release,
    /// Places of the out queue to the level below.
    pub queue: Within<1, 1024>,
}

impl CacheSpec {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        contents: Contents::Tags,
        bytes: Size::literal(8192),
        ways: Within::literal(2),
        replacement: Policy::Lru,
        no_allocate: NoAllocate::NONE,
        latency: Within::literal(1),
        ports: Within::literal(1),
        banks: None,
        mshrs: Within::literal(8),
        targets: Within::literal(4),
        release: Release::Together,
        queue: Within::literal(4),
    };

    /// Checks what single fields cannot: `field` names the spec in errors, `line` is the line size in bytes.
    ///
    /// # Errors
    /// Fields that contradict each other; the error begins with `field`.
    pub fn check(&self, field: &str, line: u64) -> Result<(), String> {
        match self.contents {
            Contents::Tags => check_geometry(field, self.bytes.get(), self.ways.get(), 1, line, self.replacement),
            Contents::Ideal => Ok(()),
        }
    }

    /// Maximum accesses in one cycle.
    pub fn accesses_per_cycle(&self) -> u64 {
        self.banks.map_or(self.ports.get(), |banks| banks.get().min(self.ports.get()))
    }

    /// An empty tag array for lines of `line` bytes.
    pub fn tags(&self, line: u64) -> TagArray {
        let sets = || self.bytes.get() / (line * self.ways.get());
        match self.contents {
            Contents::Tags => TagArray::new(sets() as usize, self.ways.size(), 0, self.replacement),
            Contents::Ideal => TagArray::ideal(),
        }
    }

    /// An empty cache for lines of `line` bytes.
    pub fn build(&self, line: u64) -> Cache {
        Cache::new(self.tags(line), self.no_allocate, MshrFile::new(self.mshrs.size(), self.targets.size()))
    }
}

impl Default for CacheSpec {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Checks that size, ways and banks give a power of two of whole sets in each bank.
pub(super) fn check_geometry(
    field: &str,
    bytes: u64,
    ways: u64,
    banks: u64,
    line: u64,
    policy: Policy,
) -> Result<(), String> {
    let unit = line * ways * banks;
    if !bytes.is_multiple_of(unit) || !(bytes / unit).is_power_of_two() {
        return Err(format!(
            "`{field}.bytes` is {bytes}: with lines of {line} B, {ways} ways and {banks} bank(s), {unit} times a power \
             of two is allowed"
        ));
    }
    if policy == Policy::TreePlru && !ways.is_power_of_two() {
        return Err(format!("`{field}.ways` is {ways}: with `replacement: TreePlru` a power of two is allowed"));
    }
    Ok(())
}

/// Kinds of accesses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Reads the line.
    Read,
    /// Writes the line and makes it dirty.
    Write,
    /// Writes to the level below; the line does not become dirty.
    WriteThrough,
}

impl Access {
    /// What it asks of the fill of a line of `class`, in a cache that does not allocate all.
    pub(crate) fn fill(self, class: TrafficClass, no_allocate: &NoAllocate) -> FillPolicy {
        FillPolicy { dirty: self == Self::Write, keep: no_allocate.keeps(class, self != Self::Read) }
    }
}

/// The result of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lookup {
    /// The line was in the cache.
    Hit,
    /// MSHR hit: the line was on its way.
    Merged,
    /// The line must be fetched: the caller sends a request.
    Miss,
    /// A write to an absent line that allocates nothing: the caller sends the write down.
    WriteAround,
    /// No MSHR, target or place in the output queue was free: nothing was counted or changed.
    Stalled,
}

/// Counts reads or writes that bypassed an L1, or writes through it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BypassCounts {
    /// Number of accesses.
    pub count: u64,
    /// Their data in bytes.
    pub bytes: Bytes,
}

impl BypassCounts {
    /// Counts one access of `bytes` bytes.
    pub fn add(&mut self, bytes: Bytes) {
        self.count += 1;
        self.bytes += bytes;
    }
}

/// The result of a fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fill {
    /// The fill waits: its dirty victim has no place in the output queue.
    Blocked,
    /// The line was filled; a dirty victim must be written back.
    Done {
        /// The displaced dirty line.
        victim: Option<Victim>,
    },
}

/// Tags, MSHRs and counts of one cache.
#[derive(Clone, Debug)]
pub struct Cache {
    tags: TagArray,
    no_allocate: NoAllocate,
    mshrs: MshrFile,
    counts: [CacheCounts; TrafficClass::ALL.len()],
}

impl Cache {
    pub(super) fn new(tags: TagArray, no_allocate: NoAllocate, mshrs: MshrFile) -> Self {
        Self { tags, no_allocate, mshrs, counts: [CacheCounts::default(); TrafficClass::ALL.len()] }
    }

    /// Accesses `line`. On a miss, [`Cache::fill`] wakes `waiting`; `None` is an access that needs no data. `room` says
    /// whether the output queue has a place for a request.
    #[inline]
    pub fn access(
        &mut self,
        line: LineAddr,
        class: TrafficClass,
        access: Access,
        waiting: Option<u32>,
        room: bool,
    ) -> Lookup {
        if self.hit(line, class, access) { Lookup::Hit } else { self.miss(line, class, access, waiting, room) }
    }

    /// Accesses `line` if it is in the cache; returns whether it is. On a miss nothing is counted or changed.
    #[inline]
    pub fn hit(&mut self, line: LineAddr, class: TrafficClass, access: Access) -> bool {
        let hit = self.tags.access(line, access == Access::Write);
        if hit {
            let counts = &mut self.counts[class as usize];
            counts.accesses += 1;
            counts.hits += 1;
        }
        hit
    }

    /// Completes an access to an absent `line` as [`Cache::access`] does.
    pub fn miss(
        &mut self,
        line: LineAddr,
        class: TrafficClass,
        access: Access,
        waiting: Option<u32>,
        room: bool,
    ) -> Lookup {
        let fill = access.fill(class, &self.no_allocate);
        let counts = &mut self.counts[class as usize];
        if let Some(register) = self.mshrs.find(line) {
            if !self.mshrs.merge(register, fill, waiting) {
                return Lookup::Stalled;
            }
            counts.accesses += 1;
            counts.mshr_hits += 1;
            return Lookup::Merged;
        }
        if !room {
            return Lookup::Stalled;
        }
        if waiting.is_none() && !fill.keep {
            counts.accesses += 1;
            counts.passed_writes += 1;
            return Lookup::WriteAround;
        }
        if self.mshrs.is_full() {
            return Lookup::Stalled;
        }
        self.mshrs.allocate(line, class, fill, waiting);
        counts.accesses += 1;
        counts.misses += 1;
        Lookup::Miss
    }

    /// Fills the missed `line` if an access to it allocates; appends the waiting accesses to `waiting`. `room` says
    /// whether the output queue has a place for a dirty victim. A dirty line that does not allocate is its own victim.
    pub fn fill(&mut self, line: LineAddr, room: bool, waiting: &mut Vec<u32>) -> Fill {
        let register = self.mshrs.find(line).expect("only a missed line comes");
        let (class, fill) = self.mshrs.missed(register);
        let place = fill.keep.then(|| self.tags.place_for(line));
        let displaced = match place {
            Some(place) => self.tags.at(place),
            None => Some(Victim { line, class, dirty: fill.dirty }),
        };
        let victim = displaced.filter(|victim| victim.dirty);
        if victim.is_some() && !room {
            return Fill::Blocked;
        }
        self.mshrs.release(register, waiting);
        if let Some(place) = place {
            self.tags.put(place, line, class, fill.dirty);
        }
        if let Some(victim) = victim {
            self.counts[victim.class as usize].write_backs += 1;
        }
        Fill::Done { victim }
    }

    /// Loads the contents of `tags`, except lines that are on their way.
    pub fn hold(&mut self, tags: &TagArray) {
        self.tags.clone_from(tags);
        self.mshrs.lines().for_each(|line| self.tags.drop_line(line));
    }

    /// Drops all lines from `first` on.
    pub fn drop_from(&mut self, first: LineAddr) {
        self.tags.drop_from(first);
    }

    /// Accesses so far, by class in the order of [`TrafficClass::ALL`].
    pub fn counts(&self) -> &[CacheCounts; TrafficClass::ALL.len()] {
        &self.counts
    }

    /// MSHRs in use.
    pub fn misses_under_way(&self) -> usize {
        self.mshrs.len()
    }
}

/// Banks of an L1 that are in use in one cycle, and the bank conflicts so far.
#[derive(Clone, Copy, Debug)]
pub struct BanksInUse {
    /// The number of banks minus one; `None` without banks.
    mask: Option<u64>,
    used: u64,
    counts: [L1Counts; TrafficClass::ALL.len()],
}

impl BanksInUse {
    /// No bank is in use yet.
    pub fn none(spec: &CacheSpec) -> Self {
        Self { mask: spec.banks.map(|banks| banks.get() - 1), used: 0, counts: Default::default() }
    }

    /// A new cycle begins.
    pub fn clear(&mut self) {
        self.used = 0;
    }

    /// Takes the bank of `line` for an access of `class`. If the bank is in use, counts a conflict and returns false.
    pub fn take(&mut self, line: LineAddr, class: TrafficClass) -> bool {
        let Some(mask) = self.mask else { return true };
        let bank = 1 << (line.0 & mask);
        let free = self.used & bank == 0;
        self.used |= bank;
        self.counts[class as usize].bank_conflicts += u64::from(!free);
        free
    }

    /// Bank conflicts by class, in the order of [`TrafficClass::ALL`].
    pub fn counts(&self) -> &[L1Counts; TrafficClass::ALL.len()] {
        &self.counts
    }
}
