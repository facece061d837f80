//! What a step of a stream requires of the machine: the kind of unit that performs it, and the elements that it
//! fetches, one per operation. All levels below the engines use this module, so that a new kind of unit is defined
//! once.

use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::layout::{Element, Layout};
use crate::machine::shadow_cache::{FrameEnd, Place};
use crate::machine::word_traffic::LatchedCopy;
use crate::stream::{RayKind, Step, Stop};

/// The unit that holds a ray while one of its steps is performed, possibly by another unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holder {
    /// A traversal unit: the step is of the ray's path.
    Traversal,
    /// The shadow-cache unit: the step is of the policy.
    ShadowCache,
}

impl Holder {
    /// The kind of this unit.
    pub(crate) fn kind(self) -> Kind {
        match self {
            Self::Traversal => Kind::Traversal,
            Self::ShadowCache => Kind::ShadowCache,
        }
    }
}

/// Whether stores are accessed as the stream records it: by the shadow-cache units' own L1s, step by step.
pub(crate) fn stores_as_recorded(machine: &MachineSpec) -> bool {
    let unit = &machine.shadow_cache;
    unit.gather.get() == 0 && entries_as_recorded(machine)
}

/// As [`stores_as_recorded`], except that updates of a hit may be gathered.
pub(crate) fn entries_as_recorded(machine: &MachineSpec) -> bool {
    let unit = &machine.shadow_cache;
    let adds = unit.frame_end != FrameEnd::List || unit.latched == LatchedCopy::Buffers;
    unit.place == Place::Own && unit.register.get() == 0 && !adds
}

/// What a step requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Work {
    /// The kind of unit that performs it.
    pub kind: Kind,
    /// The element fetched for the first operation.
    pub first: Element,
    /// The element fetched for the second operation, if there is one.
    pub second: Option<Element>,
    /// Whether a division follows.
    pub divides: bool,
}

impl Work {
    /// The work for `step` of a ray of kind `ray`, while `holder` holds the ray.
    #[inline(always)]
    pub(crate) fn of(step: Step, holder: Holder, ray: RayKind, layout: &Layout) -> Self {
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

    /// The number of operations for the step.
    pub(crate) fn operations(&self) -> u64 {
        1 + u64::from(self.second.is_some())
    }

    /// The elements, in order.
    pub(crate) fn elements(&self) -> impl Iterator<Item = Element> + use<> {
        [Some(self.first), self.second].into_iter().flatten()
    }
}
