//! A ray in the machine, or a step of a frame's end.

use std::collections::VecDeque;
use std::rc::Rc;

use super::group::Group;
use crate::stream::{Decision, RayKind, Step};

/// The number of a pool entry, or, from the pool's size on, of an entry for a step of a frame's end.
pub(super) type Id = usize;

/// Who has a slot or a context for a ray, and gets it back from other units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sender {
    Traversal(usize),
    ShadowCache(usize),
}

/// Where a ray is in the stream.
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
    /// Steps of the path that are not performed yet.
    pub path: VecDeque<Step>,
    /// Steps of the policy that are not performed yet.
    pub policy: VecDeque<Step>,
    /// Whether the decision of a skipped ray is still to be made.
    pub undecided: bool,
    /// Whether the triangle test under way is at the edges.
    pub at_edges: bool,
    /// How many of the next steps set modes: at a first touch, or a frame's end.
    pub setting: usize,
    /// Whether an intersection unit has accessed the entry of the next step.
    pub accessed: bool,
    pub sender: Sender,
    /// The list unit that has a context for it.
    pub list: Option<usize>,
    /// When it was handed over, and the least that it takes from then on.
    pub handed_over: u64,
    pub done: u64,
    pub unloaded: u64,
    /// `None` for a step of a frame's end.
    pub origin: Option<Origin>,
}

impl Ray {
    /// The step that an intersection unit is to perform.
    pub(super) fn tested_step(&mut self) -> &mut VecDeque<Step> {
        match self.sender {
            Sender::Traversal(_) => &mut self.path,
            Sender::ShadowCache(_) => &mut self.policy,
        }
    }
}
