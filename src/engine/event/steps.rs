//! The steps of a ray, and its progress through them.

use crate::quantity::NodeId;
use crate::stream::Step;

/// Stands after the last step; no step has this tag.
const END: u32 = u32::MAX;

/// Packed steps: those of a path, then those of the policy.
///
/// The next two steps are copied out of the list when the ray advances. Later reads then need not wait for main
/// memory.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    packed: Vec<u32>,
    /// Index of the policy's first step.
    path_end: u32,
    /// Index of the next step.
    next: u32,
    /// The next step, and the step after it.
    word: u32,
    behind: u32,
}

impl Default for Steps {
    fn default() -> Self {
        Self { packed: Vec::new(), path_end: 0, next: 0, word: END, behind: END }
    }
}

impl Steps {
    /// Replaces the steps; none of the new ones is done.
    pub(crate) fn begin(&mut self, path: &[u32], policy: &[u32]) {
        self.packed.clear();
        self.packed.extend_from_slice(path);
        self.packed.extend_from_slice(policy);
        debug_assert!(
            self.packed.iter().all(|&word| Step::unpack(word).is_some()),
            "checked when a ray is handed over"
        );
        (self.path_end, self.next) = (path.len() as u32, 0);
        self.look();
    }

    /// The next step; `None` after the last.
    #[inline]
    pub(crate) fn step(&self) -> Option<Step> {
        Step::unpack(self.word)
    }

    /// The next step of the path; `None` after its last.
    #[inline]
    pub(crate) fn path_step(&self) -> Option<Step> {
        if self.next < self.path_end { Step::unpack(self.word) } else { None }
    }

    /// The step of the path after the next one, if there is one.
    #[inline]
    pub(crate) fn path_step_behind(&self) -> Option<Step> {
        if self.next + 1 < self.path_end { Step::unpack(self.behind) } else { None }
    }

    /// The node of the path's next step, if that is a node.
    #[inline]
    pub(crate) fn node(&self) -> Option<NodeId> {
        if self.next < self.path_end { Step::node(self.word) } else { None }
    }

    /// The node of the path's step after the next one, if that is a node.
    #[inline]
    pub(crate) fn node_behind(&self) -> Option<NodeId> {
        if self.next + 1 < self.path_end { Step::node(self.behind) } else { None }
    }

    /// Moves past the next step.
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

    /// Lets `change` modify the policy's steps that are to come. `change` receives the packed steps, the index of the
    /// policy's first step, and the index of the next step.
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// The copies of the next two steps agree with the list at every position, and after every change behind it.
        #[test]
        fn the_next_two_steps_are_those_of_the_list(
            path in prop::collection::vec(0u32..5, 0..6), policy in prop::collection::vec(0u32..16, 0..6),
            changed in 0usize..12,
        ) {
            let pack = |tags: &[u32]| -> Vec<u32> {
                let word = |(at, &tag): (usize, &u32)| Step::of_tag(tag as usize).unwrap().pack() + at as u32;
                tags.iter().enumerate().map(word).collect()
            };
            let mut steps = Steps::default();
            steps.begin(&pack(&path), &pack(&policy));
            let mut list = [pack(&path), pack(&policy)].concat();
            for place in 0..=list.len() {
                if place == changed {
                    steps.change(|steps, policy, next| {
                        assert_eq!((policy, next), (path.len(), place));
                        steps.extend(pack(&[7, 8]));
                    });
                    list.extend(pack(&[7, 8]));
                }
                let at = |place: usize| list.get(place).and_then(|&word| Step::unpack(word));
                let of_path = |place: usize| at(place).filter(|_| place < path.len());
                let node = |step: Option<Step>| step.and_then(|step| Step::node(step.pack()));
                prop_assert_eq!(steps.step(), at(place));
                prop_assert_eq!((steps.path_step(), steps.path_step_behind()), (of_path(place), of_path(place + 1)));
                prop_assert_eq!((steps.node(), steps.node_behind()), (node(of_path(place)), node(of_path(place + 1))));
                prop_assert_eq!((steps.path(), steps.has_policy()), (&list[..path.len()], list.len() > path.len()));
                steps.advance();
            }
        }
    }
}
