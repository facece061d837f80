//! How far the ids of steps reach: one check of a chunk instead of one check of each step.

use super::step::{Step, Store};
use crate::quantity::{ListId, NodeId, TriangleSlot};

/// The largest ids that the steps of some rays name, and whether all packed steps are steps.
///
/// A chunk knows its extent ([`Chunk::extent`](super::Chunk::extent)). Whoever replays a chunk checks the steps of
/// [`Extent::outermost`] once, [`Extent::unknown`] and [`Extent::strays`], and needs to check no single step after
/// that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// One more than the largest id of a node, 0 without a node; the same of the other kinds.
    nodes: u32,
    list_entries: u32,
    slots: u32,
    /// Of each [`Store`], and one step that names the largest id.
    entries: [Option<Step>; 3],
    unknown: Option<u32>,
    strays: bool,
}

impl Extent {
    /// For each kind of thing (nodes, list entries, triangle slots, entries of each store) a step that names the
    /// largest id. A layout that holds what these steps name holds what every step names.
    pub fn outermost(&self) -> impl Iterator<Item = Step> + use<> {
        // The extent of triangle slots does not say how far the tests went, and no check depends on that.
        let slot = |slot| Step::Triangle { slot: TriangleSlot(slot), stop: super::step::Stop::Plane };
        let node = self.nodes.checked_sub(1).map(|node| Step::Node(NodeId(node)));
        let list = self.list_entries.checked_sub(1).map(|entry| Step::List(ListId(entry)));
        [node, list, self.slots.checked_sub(1).map(slot)].into_iter().chain(self.entries).flatten()
    }

    /// A packed word that stands for no step, if there is one.
    pub fn unknown(&self) -> Option<u32> {
        self.unknown
    }

    /// Whether a path holds a step of a store.
    pub fn strays(&self) -> bool {
        self.strays
    }

    /// Widens the extent to that of `other`, too.
    pub(super) fn join(&mut self, other: &Self) {
        self.nodes = self.nodes.max(other.nodes);
        self.list_entries = self.list_entries.max(other.list_entries);
        self.slots = self.slots.max(other.slots);
        other.entries.into_iter().flatten().for_each(|step| self.entry(step));
        self.unknown = self.unknown.or(other.unknown);
        self.strays |= other.strays;
    }

    /// Adds the steps of a path.
    pub(super) fn add_path(&mut self, words: &[u32]) {
        if self.add_traversal(words) > 0 {
            self.strays = true;
            self.add_stores(words);
        }
    }

    /// Adds the steps of a policy.
    pub(super) fn add_policy(&mut self, words: &[u32]) {
        if !words.is_empty() && self.add_traversal(words) > 0 {
            self.add_stores(words);
        }
    }

    /// Adds the steps of rays, which lie one after another in `words`; `policies` are those of the policy among them.
    pub(super) fn add_rays<'a>(&mut self, words: &[u32], policies: impl Iterator<Item = &'a [u32]>) {
        let others = self.add_traversal(words);
        if others > 0 {
            let known: usize = policies.map(|words| self.add_stores(words)).sum();
            if known < others {
                self.strays = true;
                self.add_stores(words);
            }
        }
    }

    /// Adds the steps of `words` that a traversal can have; returns how many others there are. The loop has no branch,
    /// so that several words are looked at at once.
    fn add_traversal(&mut self, words: &[u32]) -> usize {
        let (mut nodes, mut lists, mut slots, mut others) = (0i32, 0i32, 0i32, 0i32);
        for &word in words {
            let (tag, end) = (Step::tag(word) as i32, (word & Step::MAX_INDEX) as i32 + 1);
            nodes = nodes.max(if tag == Step::NODE { end } else { 0 });
            lists = lists.max(if tag == Step::LIST { end } else { 0 });
            slots = slots.max(if tag > Step::LIST && tag <= Step::LAST_TRAVERSAL { end } else { 0 });
            others += i32::from(tag > Step::LAST_TRAVERSAL);
        }
        self.nodes = self.nodes.max(nodes as u32);
        self.list_entries = self.list_entries.max(lists as u32);
        self.slots = self.slots.max(slots as u32);
        others as usize
    }

    /// Adds the steps of `words` that no traversal has; returns how many there are.
    fn add_stores(&mut self, words: &[u32]) -> usize {
        let others = words.iter().filter(|&&word| Step::tag(word) as i32 > Step::LAST_TRAVERSAL);
        others
            .map(|&word| match Step::unpack(word) {
                Some(step) => self.entry(step),
                None => self.unknown = self.unknown.or(Some(word)),
            })
            .count()
    }

    /// Adds the step of a store.
    fn entry(&mut self, step: Step) {
        let Some((store, index)) = step.entry() else { return };
        let furthest = &mut self.entries[store as usize];
        if furthest.and_then(Step::entry).is_none_or(|(_, furthest)| index > furthest) {
            // Reads, writes and updates of an entry need the same of a layout.
            *furthest = Some(Step::Read { store, index });
        }
    }
}

const _: () = assert!(Store::OccluderId as usize == 2, "a store has a place in `Extent::entries`");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stop;

    fn steps() -> [Step; 6] {
        [
            Step::Node(NodeId(7)),
            Step::List(ListId(Step::MAX_INDEX)),
            Step::Triangle { slot: TriangleSlot(0), stop: Stop::Plane },
            Step::Read { store: Store::ModeWord, index: 3 },
            Step::Read { store: Store::PixelCounter, index: 0 },
            Step::Read { store: Store::OccluderId, index: 11 },
        ]
    }

    #[test]
    fn the_outermost_steps_are_those_of_the_largest_ids() {
        let mut extent = Extent::default();
        assert_eq!(extent.outermost().count(), 0);
        let small = [Step::Node(NodeId(2)), Step::Triangle { slot: TriangleSlot(0), stop: Stop::Hit }].map(Step::pack);
        extent.add_path(&small);
        extent.add_policy(&[Step::Update { store: Store::ModeWord, index: 2 }.pack()]);
        extent.add_policy(&steps().map(Step::pack));
        assert_eq!(extent.outermost().collect::<Vec<_>>(), steps());
        assert_eq!((extent.unknown(), extent.strays()), (None, false));
    }

    #[test]
    fn steps_that_cannot_be_there_are_seen() {
        let read = Step::Read { store: Store::ModeWord, index: 3 }.pack();
        let node = Step::Node(NodeId(1)).pack();
        let mut extent = Extent::default();
        extent.add_rays(&[node, read], std::iter::once(&[read][..]));
        assert_eq!((extent.unknown(), extent.strays()), (None, false));
        extent.add_path(&[node, read]);
        assert!(extent.strays());
        let mut joined = Extent::default();
        joined.add_policy(&[0xf000_0001]);
        joined.join(&extent);
        assert_eq!((joined.unknown(), joined.strays()), (Some(0xf000_0001), true));
    }

    #[test]
    fn rays_at_once_are_as_rays_one_by_one() {
        let words: Vec<u32> = (0..400u32).map(|at| ((at * 7919) % 1000) | ((at % 14) << 27)).collect();
        let (mut one, mut all) = (Extent::default(), Extent::default());
        one.add_path(&words);
        all.add_rays(&words, std::iter::empty());
        assert_eq!(one, all);
    }
}
