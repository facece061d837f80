//! Steps: the elementary memory operations of a ray or a policy, each packed in 32 bits.

use serde::{Deserialize, Serialize};

use multiversion::multiversion;

use crate::quantity::{ListId, NodeId, TriangleSlot};

/// Where a triangle test ended. The test has the two memory phases of the T&I engine (Nah et al. 2011, section 4): the
/// plane's bytes first, the edges' bytes only if the plane is hit within the ray's reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stop {
    /// The plane is not hit within reach.
    Plane,
    /// The plane is hit outside the triangle.
    Edges,
    /// The triangle is hit.
    Hit,
}

/// What a culling policy keeps in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Store {
    /// The 32-bit word of occlusion and shadow modes, one a primitive.
    ModeWord,
    /// The two counters of rendered pixels, one pair a primitive.
    PixelCounter,
    /// Ids of occluders.
    OccluderId,
}

/// What an update changes in its entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// At least one bit that no earlier update of the frame has set.
    Changes,
    /// Only bits that earlier updates of the frame have set already; the word as latched at the frame's start lacks
    /// them.
    Repeats,
    /// No bit of the word as latched at the frame's start.
    Silent,
}

impl Effect {
    /// The effect of setting `bits` in a word that was `latched` at the frame's start; `learned` are the bits set since
    /// then.
    pub fn of_bits(bits: u32, latched: u32, learned: u32) -> Self {
        match (bits & !latched, bits & !(latched | learned)) {
            (0, _) => Self::Silent,
            (_, 0) => Self::Repeats,
            _ => Self::Changes,
        }
    }
}

/// A step of a ray's path, or of a policy's work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// A node is fetched and its boxes (or plane) tested.
    Node(NodeId),
    /// An entry of a primitive list is read.
    List(ListId),
    /// A triangle is tested.
    Triangle {
        /// Which record is read.
        slot: TriangleSlot,
        /// How far the test went.
        stop: Stop,
    },
    /// An entry of a policy's store is read.
    Read {
        /// The store.
        store: Store,
        /// The entry.
        index: u32,
    },
    /// An entry of a policy's store is written whole.
    Write {
        /// The store.
        store: Store,
        /// The entry.
        index: u32,
    },
    /// An entry of a policy's store is read, changed and written (OR, count).
    Update {
        /// The store.
        store: Store,
        /// The entry.
        index: u32,
    },
}

/// Bits of a packed step below the tag.
const INDEX_BITS: u32 = 27;
/// Tags of updates of mode words by their effect. The first is the tag that [`Step::pack`] gives.
const WORD_UPDATES: [(Effect, u32); 3] = [(Effect::Changes, 11), (Effect::Repeats, 14), (Effect::Silent, 15)];

impl Step {
    /// The largest id that fits a packed step.
    pub const MAX_INDEX: u32 = (1 << INDEX_BITS) - 1;

    /// Tags of the steps of a path: a node, a list entry, then triangles up to the last.
    pub(super) const NODE: i32 = 0;
    pub(super) const LIST: i32 = 1;
    pub(super) const LAST_TRAVERSAL: i32 = 4;

    /// Number of tags of a packed word; some belong to no step.
    pub const TAGS: usize = 32;

    /// The tag of a packed step, below [`Step::TAGS`].
    #[inline]
    pub fn tag(word: u32) -> u32 {
        word >> INDEX_BITS
    }

    /// The step with this tag and id 0; `None` if no step has the tag.
    pub fn of_tag(tag: usize) -> Option<Self> {
        u32::try_from(tag).ok().filter(|&tag| tag < Self::TAGS as u32).and_then(|tag| Self::unpack(tag << INDEX_BITS))
    }

    /// A tag and an id in 32 bits.
    pub(super) fn packed(tag: u32, index: u32) -> u32 {
        debug_assert!(index <= Self::MAX_INDEX);
        tag << INDEX_BITS | index
    }

    /// The step in 32 bits: a tag of 5 bits, then the id.
    pub fn pack(self) -> u32 {
        let (tag, index) = match self {
            Self::Node(NodeId(index)) => (0, index),
            Self::List(ListId(index)) => (1, index),
            Self::Triangle { slot, stop } => (2 + stop as u32, slot.0),
            Self::Read { store, index } => (5 + store as u32, index),
            Self::Write { store, index } => (8 + store as u32, index),
            Self::Update { store, index } => (11 + store as u32, index),
        };
        Self::packed(tag, index)
    }

    /// The update of mode word `index` in 32 bits, with its effect. [`Step::unpack`] drops the effect.
    pub fn pack_word_update(index: u32, effect: Effect) -> u32 {
        let tag = WORD_UPDATES.iter().find(|(known, _)| *known == effect).map_or(11, |&(_, tag)| tag);
        Self::packed(tag, index)
    }

    /// The effect of a packed update; `None` for another step. An update of another store always counts as a change.
    #[inline]
    pub fn effect(word: u32) -> Option<Effect> {
        match Self::tag(word) {
            11..=13 => Some(Effect::Changes),
            14 => Some(Effect::Repeats),
            15 => Some(Effect::Silent),
            _ => None,
        }
    }

    /// Unpacks `word`; `None` if no step has its tag.
    #[inline]
    pub fn unpack(word: u32) -> Option<Self> {
        const STOPS: [Stop; 3] = [Stop::Plane, Stop::Edges, Stop::Hit];
        const STORES: [Store; 3] = [Store::ModeWord, Store::PixelCounter, Store::OccluderId];
        let index = word & Self::MAX_INDEX;
        Some(match word >> INDEX_BITS {
            0 => Self::Node(NodeId(index)),
            1 => Self::List(ListId(index)),
            tag @ 2..=4 => Self::Triangle { slot: TriangleSlot(index), stop: STOPS[tag as usize - 2] },
            tag @ 5..=7 => Self::Read { store: STORES[tag as usize - 5], index },
            tag @ 8..=10 => Self::Write { store: STORES[tag as usize - 8], index },
            tag @ 11..=13 => Self::Update { store: STORES[tag as usize - 11], index },
            14 | 15 => Self::Update { store: Store::ModeWord, index },
            _ => return None,
        })
    }

    /// The node that a packed step visits, if it visits one.
    #[inline]
    pub fn node(word: u32) -> Option<NodeId> {
        (Self::tag(word) as i32 == Self::NODE).then_some(NodeId(word & Self::MAX_INDEX))
    }

    /// The numbers of packed steps that visit nodes, that read lists, and of all others.
    pub(super) fn count(words: &[u32]) -> [u64; 3] {
        let [nodes, lists] = visits_and_reads(words).map(u64::from);
        [nodes, lists, words.len() as u64 - nodes - lists]
    }

    /// Unpacks valid packed steps.
    pub fn unpack_all(words: &[u32]) -> impl ExactSizeIterator<Item = Self> + use<'_> {
        // Steps are packed by `pack`, and readers of files check every word.
        words.iter().map(|&word| Self::unpack(word).expect("packed steps are valid"))
    }

    /// The store and the entry that the step accesses; `None` for a step of a path.
    #[inline]
    pub fn entry(self) -> Option<(Store, u32)> {
        match self {
            Self::Read { store, index } | Self::Write { store, index } | Self::Update { store, index } => {
                Some((store, index))
            }
            Self::Node(_) | Self::List(_) | Self::Triangle { .. } => None,
        }
    }

    /// Whether the step writes an entry.
    pub fn writes(self) -> bool {
        matches!(self, Self::Write { .. } | Self::Update { .. })
    }

    /// Whether a ray's path can hold the step.
    #[inline]
    pub fn is_traversal(self) -> bool {
        matches!(self, Self::Node(_) | Self::List(_) | Self::Triangle { .. })
    }
}

/// The numbers of packed steps that visit nodes and that read lists. The loop has no branch, so that the compiler
/// vectorises it.
#[multiversion(targets("x86_64+avx2"))]
fn visits_and_reads(words: &[u32]) -> [u32; 2] {
    let (mut nodes, mut lists) = (0, 0);
    for &word in words {
        nodes += u32::from(Step::tag(word) as i32 == Step::NODE);
        lists += u32::from(Step::tag(word) as i32 == Step::LIST);
    }
    [nodes, lists]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vectorised loop and its remainder agree with a scalar loop.
    #[test]
    fn many_steps_are_counted_as_one_by_one() {
        for length in [0, 1, 7, 8, 31, 32, 33, 401] {
            let words: Vec<u32> =
                (0..length).map(|at: u32| ((at * 7919) % 1000) | ((at * 5 % 16) << INDEX_BITS)).collect();
            let of =
                |is: fn(Step) -> bool| words.iter().filter(|&&word| Step::unpack(word).is_some_and(is)).count() as u64;
            let (nodes, lists) = (of(|it| matches!(it, Step::Node(_))), of(|it| matches!(it, Step::List(_))));
            assert_eq!(Step::count(&words), [nodes, lists, words.len() as u64 - nodes - lists], "{length} words");
        }
    }

    #[test]
    fn an_update_is_the_same_step_whatever_it_changes() {
        for (effect, bits, latched, learned) in [
            (Effect::Changes, 0b0110, 0b0100, 0),
            (Effect::Changes, 0b0110, 0b0100, 0b1000),
            (Effect::Repeats, 0b0110, 0b0100, 0b0010),
            (Effect::Silent, 0b0110, 0b1110, 0),
        ] {
            assert_eq!(Effect::of_bits(bits, latched, learned), effect);
            let word = Step::pack_word_update(7, effect);
            assert_eq!(Step::unpack(word), Some(Step::Update { store: Store::ModeWord, index: 7 }));
            assert_eq!(Step::effect(word), Some(effect));
        }
        let other = Step::Update { store: Store::PixelCounter, index: 7 };
        assert_eq!(Step::effect(other.pack()), Some(Effect::Changes));
        assert_eq!(Step::effect(Step::Read { store: Store::ModeWord, index: 7 }.pack()), None);
        assert_eq!(Step::unpack(16 << INDEX_BITS), None);
    }
}
