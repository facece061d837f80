//! The steps of a ray in the machine, and how far it has come.

use crate::quantity::NodeId;
use crate::stream::Step;

/// What is behind the last step: no step has its tag.
const END: u32 = u32::MAX;

/// Packed steps: those of a path, then those of the policy.
///
/// The next two are kept beside the list. They are read when the ray goes on, and not when somebody asks for them, who
/// would have to wait until they come from the host's memory.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    packed: Vec<u32>,
    /// Where the policy's steps begin.
    path_end: u32,
    /// The place of the next step.
    next: u32,
    /// The next step, and the one behind it.
    word: u32,
    behind: u32,
}

impl Default for Steps {
    fn default() -> Self {
        Self { packed: Vec::new(), path_end: 0, next: 0, word: END, behind: END }
    }
}

impl Steps {
    /// From now on, they are these, and none is done.
    pub(crate) fn begin(&mut self, path: &[u32], policy: &[u32]) {
        self.packed.clear();
        self.packed.extend_from_slice(path);
        self.packed.extend_from_slice(policy);
        (self.path_end, self.next) = (path.len() as u32, 0);
        self.look();
    }

    /// The next step; `None` behind the last.
    #[inline]
    pub(crate) fn step(&self) -> Option<Step> {
        Step::unpack(self.word)
    }

    /// The next step of the path; `None` behind its last.
    #[inline]
    pub(crate) fn path_step(&self) -> Option<Step> {
        if self.next < self.path_end { Step::unpack(self.word) } else { None }
    }

    /// The step of the path behind the next one, if there is one.
    #[inline]
    pub(crate) fn path_step_behind(&self) -> Option<Step> {
        if self.next + 1 < self.path_end { Step::unpack(self.behind) } else { None }
    }

    /// The node of the path's next step, if that is a node.
    #[inline]
    pub(crate) fn node(&self) -> Option<NodeId> {
        if self.next < self.path_end { Step::node(self.word) } else { None }
    }

    /// The node of the path's step behind the next one, if that is a node.
    #[inline]
    pub(crate) fn node_behind(&self) -> Option<NodeId> {
        if self.next + 1 < self.path_end { Step::node(self.behind) } else { None }
    }

    /// The next step is done.
    #[inline]
    pub(crate) fn advance(&mut self) {
        self.next += 1;
        self.word = self.behind;
        self.behind = self.at(self.next + 1);
    }

    /// Whether the policy has steps.
    pub(crate) fn has_policy(&self) -> bool {
        (self.path_end as usize) < self.packed.len()
    }

    /// The packed steps of the path.
    pub(crate) fn path(&self) -> &[u32] {
        &self.packed[..self.path_end as usize]
    }

    /// The packed steps, to change those of the policy that are to come; where these begin, and the place of the next.
    pub(crate) fn change<T>(&mut self, change: impl FnOnce(&mut Vec<u32>, usize, usize) -> T) -> T {
        let changed = change(&mut self.packed, self.path_end as usize, self.next as usize);
        self.look();
        changed
    }

    #[inline]
    fn look(&mut self) {
        (self.word, self.behind) = (self.at(self.next), self.at(self.next + 1));
    }

    #[inline]
    fn at(&self, place: u32) -> u32 {
        self.packed.get(place as usize).copied().unwrap_or(END)
    }
}
