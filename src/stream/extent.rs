//! The largest ids of a chunk's steps: one check of a chunk replaces a check of each step.

use multiversion::multiversion;

use super::step::{Step, Store};
use crate::quantity::{ListId, NodeId, TriangleSlot};

/// The largest ids that the steps of some rays name, and whether every packed word is a step.
///
/// [`Chunk::extent`](super::Chunk::extent) computes it. An engine that replays a chunk checks [`Extent::outermost`],
/// [`Extent::unknown`] and [`Extent::strays`] once and needs no check of single steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// One more than the largest id of a node, 0 without a node; likewise for list entries and triangle slots.
    nodes: u32,
    list_entries: u32,
    slots: u32,
    /// For each [`Store`] a step that names the largest id.
    entries: [Option<Step>; 3],
    unknown: Option<u32>,
    strays: bool,
}

impl Extent {
    /// For each kind of element (nodes, list entries, triangle slots, entries of each store) a step that names the
    /// largest id. A layout that holds the elements of these steps holds the elements of all steps.
    pub fn outermost(&self) -> impl Iterator<Item = Step> + use<> {
        // The extent does not record where triangle tests stopped; no check depends on it.
        let slot = |slot| Step::Triangle { slot: TriangleSlot(slot), stop: super::step::Stop::Plane };
        let node = self.nodes.checked_sub(1).map(|node| Step::Node(NodeId(node)));
        let list = self.list_entries.checked_sub(1).map(|entry| Step::List(ListId(entry)));
        [node, list, self.slots.checked_sub(1).map(slot)].into_iter().chain(self.entries).flatten()
    }

    /// A packed word that is no step, if there is one.
    pub fn unknown(&self) -> Option<u32> {
        self.unknown
    }

    /// Whether a path holds a step of a store.
    pub fn strays(&self) -> bool {
        self.strays
    }

    /// The extent of all steps in `words`; `policies` are the slices of `words` with policy steps.
    pub(super) fn of<'a>(words: &[u32], policies: impl Iterator<Item = &'a [u32]>) -> Self {
        let [nodes, list_entries, slots, others] = furthest(words);
        let mut extent = Self { nodes, list_entries, slots, ..Self::default() };
        if others > 0 {
            let known: usize = policies.map(|words| extent.add_stores(words)).sum();
            if known < others as usize {
                extent.strays = true;
                extent.add_stores(words);
            }
        }
        extent
    }

    /// Adds the steps of `words` that a traversal cannot have; returns their number.
    #[inline]
    fn add_stores(&mut self, words: &[u32]) -> usize {
        let others = words.iter().filter(|&&word| Step::tag(word) as i32 > Step::LAST_TRAVERSAL);
        others
            .map(|&word| match Step::unpack(word) {
                Some(step) => self.entry(step),
                None => self.unknown = self.unknown.or(Some(word)),
            })
            .count()
    }

    /// Adds a step on a store.
    fn entry(&mut self, step: Step) {
        let Some((store, index)) = step.entry() else { return };
        let furthest = &mut self.entries[store as usize];
        if furthest.and_then(Step::entry).is_none_or(|(_, furthest)| index > furthest) {
            // A layout's check does not distinguish reads, writes and updates of an entry.
            *furthest = Some(Step::Read { store, index });
        }
    }
}

/// One more than the largest ids of nodes, list entries and triangle slots in `words`, and the number of other words.
/// The loop has no branch, so that the compiler vectorises it.
#[multiversion(targets("x86_64+avx2"))]
fn furthest(words: &[u32]) -> [u32; 4] {
    let (mut nodes, mut lists, mut slots, mut others) = (0i32, 0i32, 0i32, 0i32);
    for &word in words {
        let (tag, end) = (Step::tag(word) as i32, (word & Step::MAX_INDEX) as i32 + 1);
        nodes = nodes.max(if tag == Step::NODE { end } else { 0 });
        lists = lists.max(if tag == Step::LIST { end } else { 0 });
        slots = slots.max(if tag > Step::LIST && tag <= Step::LAST_TRAVERSAL { end } else { 0 });
        others += i32::from(tag > Step::LAST_TRAVERSAL);
    }
    [nodes, lists, slots, others].map(|number| number as u32)
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
        assert_eq!(Extent::of(&[], std::iter::empty()).outermost().count(), 0);
        let small = [Step::Node(NodeId(2)), Step::Triangle { slot: TriangleSlot(0), stop: Stop::Hit }].map(Step::pack);
        let update = [Step::Update { store: Store::ModeWord, index: 2 }.pack()];
        let words = [small.as_slice(), &update, &steps().map(Step::pack)].concat();
        let extent = Extent::of(&words, [&words[2..3], &words[3..]].into_iter());
        assert_eq!(extent.outermost().collect::<Vec<_>>(), steps());
        assert_eq!((extent.unknown(), extent.strays()), (None, false));
    }

    #[test]
    fn steps_that_cannot_be_there_are_seen() {
        let read = Step::Read { store: Store::ModeWord, index: 3 }.pack();
        let node = Step::Node(NodeId(1)).pack();
        let extent = |words: &[u32], policy: &[u32]| Extent::of(words, std::iter::once(policy));
        let sound = extent(&[node, read], &[read]);
        assert_eq!((sound.unknown(), sound.strays()), (None, false));
        assert!(extent(&[node, read, read], &[read]).strays());
        let unknown = extent(&[node, read, 0xf000_0001], &[0xf000_0001]);
        assert_eq!((unknown.unknown(), unknown.strays()), (Some(0xf000_0001), true));
    }

    /// The vectorised loop and its remainder agree with a scalar loop.
    #[test]
    fn many_steps_are_as_one_by_one() {
        let words: Vec<u32> = (0..401u32).map(|at| ((at * 7919) % 1000) | ((at % 16) << 27)).collect();
        let one = |of: fn(Step) -> Option<u32>| {
            words.iter().filter_map(|&word| Step::unpack(word).and_then(of)).max().map_or(0, |id| id + 1)
        };
        let [nodes, lists, slots, others] = furthest(&words);
        assert_eq!(nodes, one(|step| if let Step::Node(NodeId(id)) = step { Some(id) } else { None }));
        assert_eq!(lists, one(|step| if let Step::List(ListId(id)) = step { Some(id) } else { None }));
        assert_eq!(slots, one(|step| if let Step::Triangle { slot, .. } = step { Some(slot.0) } else { None }));
        assert_eq!(others as usize, words.iter().filter(|&&word| Step::tag(word) > 4).count());
    }
}
