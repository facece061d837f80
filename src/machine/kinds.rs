//! The kinds of units that have an L1, and the fields that they share.

use super::spec::MachineSpec;
use super::writes::WritePolicy;
use crate::memory::cache::CacheSpec;

/// Kinds of units with an L1. The engine's `Tally::units` has the same order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// Traversal units.
    Traversal,
    /// List units.
    List,
    /// Intersection units.
    Intersection,
    /// Shadow-cache units.
    ShadowCache,
}

/// The properties of all units of one kind.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KindSpec {
    /// Units of all cores.
    pub count: u64,
    /// Stages of the pipeline.
    pub latency: u64,
    /// Cycles from an operation to the next.
    pub interval: u64,
    /// Operations that can begin in the same cycle.
    pub width: u64,
    /// Rays that the unit works on at once; `None` where only the slots of the sending units limit them.
    pub contexts: Option<u64>,
    /// Rays that can wait for a context; `None` where there is room for all.
    pub places: Option<u64>,
    /// The L1 of each unit.
    pub cache: CacheSpec,
    /// How the L1 handles writes.
    pub writes: WritePolicy,
}

impl Kind {
    /// All kinds.
    pub(crate) const ALL: [Self; 4] = [Self::Traversal, Self::List, Self::Intersection, Self::ShadowCache];

    /// The names, in reports, of the kind and of its L1s.
    pub(crate) fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Traversal => ("traversal", "l1_traversal"),
            Self::List => ("list", "l1_list"),
            Self::Intersection => ("intersection", "l1_intersection"),
            Self::ShadowCache => ("shadow_cache", "l1_shadow_cache"),
        }
    }

    /// The units of this kind in `machine`.
    pub(crate) fn spec(self, machine: &MachineSpec) -> KindSpec {
        let MachineSpec { traversal, list, intersection, shadow_cache, .. } = machine;
        let of_all_cores = |count: u64| machine.cores.get() * count;
        match self {
            Self::Traversal => KindSpec {
                count: of_all_cores(traversal.count.get()),
                latency: traversal.latency.get(),
                interval: traversal.interval.get(),
                width: 1,
                contexts: None,
                places: None,
                cache: traversal.cache,
                writes: WritePolicy::Back,
            },
            Self::List => KindSpec {
                count: of_all_cores(list.count.get()),
                latency: list.latency.get(),
                interval: list.interval.get(),
                width: 1,
                contexts: Some(list.lists.get()),
                places: Some(list.queue.get()),
                cache: list.cache,
                writes: WritePolicy::Back,
            },
            Self::Intersection => KindSpec {
                count: of_all_cores(intersection.count.get()),
                latency: intersection.latency.get(),
                interval: intersection.interval.get(),
                width: 1,
                contexts: Some(intersection.tests.get()),
                places: Some(intersection.queue.get()),
                cache: intersection.cache,
                writes: WritePolicy::Back,
            },
            Self::ShadowCache => KindSpec {
                count: of_all_cores(shadow_cache.count.get()),
                latency: shadow_cache.latency.get(),
                interval: shadow_cache.interval.get(),
                width: shadow_cache.width.get(),
                contexts: Some(shadow_cache.contexts.get()),
                places: None,
                cache: shadow_cache.cache,
                writes: shadow_cache.writes,
            },
        }
    }
}
