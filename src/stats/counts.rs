//! The counters of the parts of a machine.

use std::ops::{AddAssign, Deref, Sub};

use serde::{Deserialize, Serialize};

use crate::counters::counters;

counters! {
    /// Accesses to a cache, of one class of traffic.
    pub struct CacheCounts {
        accesses: "accesses", "lines asked of a kind of cache: hits + half_misses + misses + passed_writes";
        hits: "accesses", "the line was there";
        half_misses: "accesses", "MSHR hits (secondary misses): the line was on its way already";
        misses: "accesses", "the line was fetched from the level below";
        passed_writes: "accesses",
            "the line was not there, and a write that allocates none (`no_allocate`) went down to the level below";
        write_backs: "lines", "dirty lines of the class that were displaced and written down";
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
            "an access to an L1 with `banks` waited, since its bank had made another in the cycle";
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
    /// A DRAM's column commands and what they met.
    pub struct DramCounts {
        reads: "commands", "lines read";
        writes: "commands", "lines written";
        row_hits: "commands", "column commands that found their row open";
        row_misses: "commands", "column commands whose bank was closed: an activate went before";
        row_conflicts: "commands", "column commands for which another row had to be closed";
        refreshes: "commands", "refreshes given, all channels together";
        activates: "commands", "rows opened; a row that a refresh closed before its column command is opened again";
    }
}

counters! {
    /// What went through queues between parts of a kind.
    pub struct QueueCounts {
        entries: "entries", "put into the queues in front of all parts of a kind";
        waited: "cycles",
            "that entries stood in these queues: over entries the mean wait, over the run's cycles the mean number \
             that stood there (Little 1961)";
    }
}

counters! {
    /// How long traced rays of a kind took, policy steps included, from being handed over to being done.
    pub struct LatencyCounts {
        rays: "rays", "traced rays of a kind whose latency is known";
        cycles: "cycles",
            "from being handed over to being done, policy steps included; summed over the rays of the kind";
        unloaded: "cycles",
            "what these rays take at least, alone and with every line at hand, without policy steps";
    }
    peaks {
        most: "cycles", "the longest latency of a ray of the kind";
    }
}
