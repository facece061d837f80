//! Where a ray is, and what it does next.

use crate::engine::work::Holder;

/// What a ray does when it acts next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Its holder looks at its next step.
    Step,
    /// The first operation of its step begins, at a unit that its holder sent it to.
    First,
    /// The second does.
    Second,
    /// It comes back from a unit that its holder sent it to.
    Back,
    /// It comes to a shadow-cache unit.
    Policy,
    /// Its shadow-cache unit, which owns the entry of its next step, accesses that.
    Entry,
}

/// Where a ray is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whereabouts {
    /// What it does next.
    pub stage: Stage,
    /// Who holds it.
    pub holder: Holder,
    /// The shadow-cache unit that holds it.
    pub policy_unit: u32,
    /// The unit that it was sent to.
    pub away: u32,
    /// Whether the shadow-cache unit's decision is still to come.
    pub undecided: bool,
    /// Whether an update of the next step's entry sets modes.
    pub sets_modes: bool,
    /// Whether an intersection unit has accessed that entry, and the shadow-cache unit's operation is still to come.
    pub fetched: bool,
}

impl Whereabouts {
    pub(super) const IDLE: Self = Self {
        stage: Stage::Step,
        holder: Holder::Traversal,
        policy_unit: 0,
        away: 0,
        undecided: false,
        sets_modes: false,
        fetched: false,
    };
}

/// How a unit accesses an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// Through its L1.
    Cached,
    /// From the L2, past the L1.
    Past,
    /// Not at all: what is written goes down with the operation.
    Operand,
}
