//! What the steps of a stream ask of the machine: which kind of unit performs a step, and which elements it fetches, an
//! operation each. All rungs below the engines take it from here, so that a new kind of unit is told once.

use crate::machine::MachineSpec;
use crate::machine::layout::{Element, Layout};
use crate::machine::pipeline::WritePolicy;
use crate::machine::shadow_cache::{FrameEnd, Place};
use crate::memory::cache::CacheSpec;
use crate::stream::{RayKind, Step, Stop};

/// Who holds a ray while a step of it is performed, which may be by another unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// A traversal unit: the step is of the ray's path.
    Traversal,
    /// The shadow-cache unit: the step is of the policy.
    ShadowCache,
}

impl Holder {
    /// The kind of units that it is.
    pub fn kind(self) -> Kind {
        match self {
            Self::Traversal => Kind::Traversal,
            Self::ShadowCache => Kind::ShadowCache,
        }
    }
}

/// Kinds of units, in the order of [`super::tally::Tally::units`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Traversal units.
    Traversal,
    /// List units.
    List,
    /// Intersection units.
    Intersection,
    /// Shadow-cache units.
    ShadowCache,
}

/// What all units of a kind have.
#[derive(Clone, Copy, Debug)]
pub struct KindSpec {
    /// Units of all cores.
    pub count: u64,
    /// Stages of the pipeline.
    pub latency: u64,
    /// Cycles from an operation to the next.
    pub interval: u64,
    /// Rays that the unit works on at once; `None` where nothing but the slots of who sends them limits them.
    pub contexts: Option<u64>,
    /// Rays that can wait for a context; `None` where there is room for all.
    pub places: Option<u64>,
    /// The L1 of each.
    pub cache: CacheSpec,
    /// What becomes of writes.
    pub writes: WritePolicy,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Traversal, Self::List, Self::Intersection, Self::ShadowCache];

    /// The names of a kind, and of its L1s, in reports.
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Traversal => ("traversal", "l1_traversal"),
            Self::List => ("list", "l1_list"),
            Self::Intersection => ("intersection", "l1_intersection"),
            Self::ShadowCache => ("shadow_cache", "l1_shadow_cache"),
        }
    }

    /// The units of this kind in `machine`.
    pub fn spec(self, machine: &MachineSpec) -> KindSpec {
        let MachineSpec { traversal, list, intersection, shadow_cache, .. } = machine;
        let of_all_cores = |count: u64| machine.cores.get() * count;
        match self {
            Self::Traversal => KindSpec {
                count: of_all_cores(traversal.count.get()),
                latency: traversal.latency.get(),
                interval: traversal.interval.get(),
                contexts: None,
                places: None,
                cache: traversal.cache,
                writes: WritePolicy::Back,
            },
            Self::List => KindSpec {
                count: of_all_cores(list.count.get()),
                latency: list.latency.get(),
                interval: list.interval.get(),
                contexts: Some(list.lists.get()),
                places: Some(list.queue.get()),
                cache: list.cache,
                writes: WritePolicy::Back,
            },
            Self::Intersection => KindSpec {
                count: of_all_cores(intersection.count.get()),
                latency: intersection.latency.get(),
                interval: intersection.interval.get(),
                contexts: Some(intersection.tests.get()),
                places: Some(intersection.queue.get()),
                cache: intersection.cache,
                writes: WritePolicy::Back,
            },
            Self::ShadowCache => KindSpec {
                count: of_all_cores(shadow_cache.count.get()),
                latency: shadow_cache.latency.get(),
                interval: shadow_cache.interval.get(),
                contexts: Some(shadow_cache.contexts.get()),
                places: None,
                cache: shadow_cache.cache,
                writes: shadow_cache.writes,
            },
        }
    }
}

/// Whether stores are accessed as the stream records it: by the shadow-cache units' own L1s, step by step.
pub fn stores_as_recorded(machine: &MachineSpec) -> bool {
    let unit = &machine.shadow_cache;
    unit.place == Place::Own && unit.register.get() == 0 && unit.frame_end == FrameEnd::List
}

/// What a step asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// Who performs it.
    pub kind: Kind,
    /// What is fetched for the first operation.
    pub first: Element,
    /// What is fetched for the second, if there is one.
    pub second: Option<Element>,
    /// Whether a division follows.
    pub divides: bool,
}

impl Work {
    /// What `step` of a ray of kind `ray` asks for while `holder` has the ray.
    #[inline(always)]
    pub fn of(step: Step, holder: Holder, ray: RayKind, layout: &Layout) -> Self {
        let one = |kind, first| Self { kind, first, second: None, divides: false };
        let holders = holder.kind();
        match (step, holder) {
            (Step::Node(node), _) => one(holders, layout.node(node)),
            (Step::Triangle { slot, stop }, _) => Self {
                kind: Kind::Intersection,
                first: layout.plane(slot),
                second: (stop != Stop::Plane).then(|| layout.edges(slot)),
                divides: stop == Stop::Hit && holder == Holder::Traversal && ray != RayKind::Shadow,
            },
            (Step::List(entry), Holder::Traversal) => one(Kind::List, layout.list_entry(entry)),
            (Step::List(entry), Holder::ShadowCache) => one(holders, layout.list_entry(entry)),
            (Step::Read { store, index }, _) => one(holders, layout.entry(store, index, false)),
            (Step::Write { store, index } | Step::Update { store, index }, _) => {
                one(holders, layout.entry(store, index, true))
            }
        }
    }

    /// Operations begun for the step.
    pub fn operations(&self) -> u64 {
        1 + u64::from(self.second.is_some())
    }

    /// The elements in order.
    pub fn elements(&self) -> impl Iterator<Item = Element> + use<> {
        [Some(self.first), self.second].into_iter().flatten()
    }
}
