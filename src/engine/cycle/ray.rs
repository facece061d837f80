//! A ray in the machine, or an end-of-frame step.

use std::collections::VecDeque;
use std::rc::Rc;

use super::group::Group;
use crate::stream::{Decision, RayKind, Step};

/// The number of a pool entry; numbers from the pool's size on are entries for end-of-frame steps.
pub(super) type Id = usize;

/// The unit that holds a slot or a context for a ray, and gets the ray back from other units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sender {
    Traversal(usize),
    ShadowCache(usize),
}

/// Position of a ray in the stream.
#[derive(Clone, Debug)]
pub(super) struct Origin {
    pub group: Rc<Group>,
    pub index: usize,
}

/// The ray.
#[derive(Clone, Debug)]
pub(super) struct Ray {
    pub kind: RayKind,
    pub decision: Decision,
    /// Steps of the path not yet performed.
    pub path: VecDeque<Step>,
    /// Steps of the policy not yet performed.
    pub policy: VecDeque<Step>,
    /// Whether the decision of a skipped ray is not yet made.
    pub undecided: bool,
    /// Whether the current triangle test has reached the edges.
    pub at_edges: bool,
    /// Number of the next steps that set modes, at a first touch or in the end-of-frame update.
    pub setting: usize,
    /// Whether an intersection unit has accessed the entry of the next step.
    pub accessed: bool,
    pub sender: Sender,
    /// The list unit that holds a context for the ray.
    pub list: Option<usize>,
    /// Cycles of hand-over and completion, and the lower bound of the latency between them in cycles.
    pub handed_over: u64,
    pub done: u64,
    pub unloaded: u64,
    /// `None` for an end-of-frame step.
    pub origin: Option<Origin>,
}

impl Ray {
    /// The remaining steps whose first step an intersection unit is to perform.
    pub(super) fn tested_step(&mut self) -> &mut VecDeque<Step> {
        match self.sender {
            Sender::Traversal(_) => &mut self.path,
            Sender::ShadowCache(_) => &mut self.policy,
        }
    }
}
