//! Position of a ray in the machine, and its next action.

use crate::engine::work::Holder;

/// A ray's next action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Its holder looks at the next step.
    Step,
    /// The first operation of the step begins, at a unit to which the holder sent the ray.
    First,
    /// The second operation begins there.
    Second,
    /// The ray comes back from a unit to which its holder sent it.
    Back,
    /// The ray comes to a shadow-cache unit.
    Policy,
    /// Its shadow-cache unit, which owns the entry of the next step, accesses the entry.
    Entry,
}

/// Position of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whereabouts {
    /// Its next action.
    pub stage: Stage,
    /// Its holder.
    pub holder: Holder,
    /// The shadow-cache unit that holds it.
    pub policy_unit: u32,
    /// The unit to which it was sent.
    pub away: u32,
    /// Whether the decision of the shadow-cache unit is not yet made.
    pub undecided: bool,
    /// Whether an update of the next step's entry sets modes.
    pub sets_modes: bool,
    /// Whether an intersection unit has accessed the entry and the operation of the shadow-cache unit is still to come.
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
    /// From the L2, bypassing the L1.
    Bypass,
    /// No read: the written data goes down with the operation.
    Operand,
}
