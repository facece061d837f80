//! The counters of the parts of a machine.

use std::ops::{AddAssign, Deref, Sub};

use serde::{Deserialize, Serialize};

use crate::counters::counters;

counters! {
    /// Accesses to a cache, of one class of traffic.
    pub struct CacheCounts {
        accesses: "accesses", "accesses to a kind of cache: hits + mshr_hits + misses + passed_writes";
        hits: "accesses", "the line was in the cache";
        mshr_hits: "accesses", "MSHR hits (secondary misses): the line was already on its way";
        misses: "accesses", "the line was fetched from the level below";
        passed_writes: "accesses",
            "write misses that do not allocate a line (`no_allocate`): the write went to the level below";
        write_backs: "lines", "dirty lines of the class that were evicted and written to the level below";
    }
}

impl CacheCounts {
    /// Hits over accesses; `None` without an access.
    pub fn hit_rate(&self) -> Option<f64> {
        (self.accesses > 0).then(|| self.hits as f64 / self.accesses as f64)
    }
}

counters! {
    /// What an L1 alone counts, of one class of traffic.
    pub struct L1Counts {
        bank_conflicts: "cycles",
            "an access to an L1 with `banks` waited, since its bank had another access in the cycle";
    }
}

/// Accesses of one class of traffic to all caches of a kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CacheStats {
    /// What every cache counts.
    #[serde(flatten)]
    pub counts: CacheCounts,
    /// The counts that only L1s have; `None` for other levels.
    #[serde(flatten)]
    pub l1: Option<L1Counts>,
}

impl Sub for CacheStats {
    type Output = Self;

    fn sub(self, earlier: Self) -> Self {
        let l1 = self.l1.map(|now| now - earlier.l1.unwrap_or_default());
        Self { counts: self.counts - earlier.counts, l1 }
    }
}

impl AddAssign for CacheStats {
    fn add_assign(&mut self, other: Self) {
        self.counts += other.counts;
        if let Some(more) = other.l1 {
            *self.l1.get_or_insert_with(L1Counts::default) += more;
        }
    }
}

/// Gives the counts of any cache without naming the field.
impl Deref for CacheStats {
    type Target = CacheCounts;

    fn deref(&self) -> &CacheCounts {
        &self.counts
    }
}

counters! {
    /// Column commands of a DRAM by the state of their bank, and refreshes and activates.
    pub struct DramCounts {
        reads: "commands", "lines read";
        writes: "commands", "lines written";
        row_hits: "commands", "column commands that found their row open";
        row_misses: "commands", "column commands whose bank was closed: the row was activated first";
        row_conflicts: "commands", "column commands whose bank had another row open, which was closed first";
        refreshes: "commands", "refresh commands, all channels together";
        activates: "commands", "activate commands; a row that a refresh closes before its column command is reopened";
    }
}

counters! {
    /// Entries of the queues in front of parts of a kind, and their waits.
    pub struct QueueCounts {
        entries: "entries", "entries put into the queues in front of all parts of a kind";
        waited: "cycles",
            "waiting times of all entries in these queues; divided by entries: the mean wait; divided by the run's \
             cycles: the mean queue length (Little 1961)";
    }
}

counters! {
    /// Latency of traced rays of a kind, from hand-over to completion, policy steps included.
    pub struct LatencyCounts {
        rays: "rays", "traced rays of a kind whose latency is known";
        cycles: "cycles",
            "from hand-over to completion, policy steps included; summed over the rays of the kind";
        unloaded: "cycles",
            "lower bound of these rays' latency: no contention, missed lines arrive after one cycle, no policy steps";
    }
    peaks {
        most: "cycles", "the longest latency of a ray of the kind";
    }
}
