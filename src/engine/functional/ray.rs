//! A ray in flight on the functional rung, and what it does next.

use super::super::work::Holder;
use super::station::Fetch;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// What a ray does at its next event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The data of its operation are there.
    Ready,
    /// Its holder looks at its next step.
    Step,
    /// Its second operation begins with a fetch.
    Second,
    /// It comes back from a unit that its holder sent it to.
    Back,
    /// It comes to the shadow-cache unit.
    Policy,
}

/// A ray in flight, or a step of a frame's end.
#[derive(Clone, Debug)]
pub struct Ray {
    /// Who has it.
    pub holder: Holder,
    /// The shadow-cache unit that holds it.
    pub policy_unit: u32,
    /// The unit that performs the step.
    pub station: u32,
    /// Whether that is another than the holder.
    pub away: bool,
    /// What it does next.
    pub stage: Stage,
    /// Whether the shadow-cache unit's decision is still to come.
    pub undecided: bool,
    /// Operations that its step takes after the one under way.
    pub operations_left: u32,
    /// Whether a division follows the last.
    pub divides: bool,
    /// What it fetches.
    pub fetch: Fetch,
}

impl Ray {
    /// A ray that is not in flight.
    pub const IDLE: Self = Self {
        holder: Holder::Traversal,
        policy_unit: 0,
        station: 0,
        away: false,
        stage: Stage::Step,
        undecided: false,
        operations_left: 0,
        divides: false,
        fetch: Fetch {
            line: LineAddr(0),
            left: 0,
            missing: 0,
            write: false,
            class: TrafficClass::Node,
            bytes: 0,
            marked: false,
            data_at: 0,
        },
    };
}
