//! What the steps of a stream ask of the machine: which kind of unit performs a step, and which elements it fetches, an
//! operation each. All rungs below the engines take it from here, so that a new kind of unit is told once.

use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::layout::{Element, Layout};
use crate::machine::shadow_cache::{FrameEnd, Place};
use crate::machine::word_traffic::LatchedCopy;
use crate::stream::{RayKind, Step, Stop};

/// Who holds a ray while a step of it is performed, which may be by another unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holder {
    /// A traversal unit: the step is of the ray's path.
    Traversal,
    /// The shadow-cache unit: the step is of the policy.
    ShadowCache,
}

impl Holder {
    /// The kind of units that it is.
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

/// Whether entries are accessed as the stream records it, but for updates gathered by hits: by the shadow-cache units'
/// own L1s, step by step.
pub(crate) fn entries_as_recorded(machine: &MachineSpec) -> bool {
    let unit = &machine.shadow_cache;
    let adds = unit.frame_end != FrameEnd::List || unit.latched == LatchedCopy::Buffers;
    unit.place == Place::Own && unit.register.get() == 0 && !adds
}

/// What a step asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Work {
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

    /// Operations begun for the step.
    pub(crate) fn operations(&self) -> u64 {
        1 + u64::from(self.second.is_some())
    }

    /// The elements in order.
    pub(crate) fn elements(&self) -> impl Iterator<Item = Element> + use<> {
        [Some(self.first), self.second].into_iter().flatten()
    }
}
