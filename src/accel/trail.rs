//! Observers of a traversal: one records, one does nothing.

use super::steps::Steps;
use crate::quantity::{ListId, NodeId, TriangleSlot};
use crate::stream::{Effect, Step, Stop, Store};

/// Receives every step of a traversal, in order.
pub trait Observer {
    /// A node was fetched and its children tested.
    fn node(&mut self, node: NodeId);
    /// An entry of a primitive list was read.
    fn list(&mut self, entry: ListId);
    /// A triangle was tested.
    fn triangle(&mut self, slot: TriangleSlot, stop: Stop);

    /// A visit in a tree of boxes is about to start: of at most two nodes, or of at most four triangles.
    #[inline(always)]
    fn make_room(&mut self) {}

    /// The first `count` of two nodes were visited.
    #[inline(always)]
    fn nodes(&mut self, nodes: [NodeId; 2], count: usize) {
        nodes.into_iter().take(count).for_each(|node| self.node(node));
    }

    /// The first `count` (at most four) triangles from `slot` on were tested, and none was hit. The plane test
    /// rejected those whose bits in `in_plane` are not set.
    #[inline(always)]
    fn missed(&mut self, slot: TriangleSlot, count: u32, in_plane: u32) {
        for at in 0..count {
            let stop = if in_plane >> at & 1 == 0 { Stop::Plane } else { Stop::Edges };
            self.triangle(TriangleSlot(slot.0 + at), stop);
        }
    }
}

/// Ignores all steps.
pub struct Silent;

impl Observer for Silent {
    fn nodes(&mut self, _: [NodeId; 2], _: usize) {}
    fn missed(&mut self, _: TriangleSlot, _: u32, _: u32) {}
    fn node(&mut self, _: NodeId) {}
    fn list(&mut self, _: ListId) {}
    fn triangle(&mut self, _: TriangleSlot, _: Stop) {}
}

/// Records the steps and counts them separately; the counts must match the recorded steps.
#[derive(Clone, Debug, Default)]
pub struct Trail {
    /// Packed steps.
    pub steps: Steps,
    /// Number of nodes visited.
    pub nodes: u64,
    /// Number of primitive list entries read.
    pub lists: u64,
    /// Number of triangles tested.
    pub triangles: u64,
    /// Number of store entries read.
    pub reads: u64,
    /// Number of store entries written, or read and written.
    pub writes: u64,
    /// Number of updates, among the writes, that repeat an earlier update.
    pub repeated: u64,
    /// Number of updates, among the writes, that change nothing.
    pub silent: u64,
    /// Updates of mode words that change bits, as far as the recorder knows.
    pub fresh: Vec<Fresh>,
}

/// An update that sets bits of a mode word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fresh {
    /// Index of the update among the steps.
    pub at: usize,
    /// Index of the word.
    pub word: u32,
    /// The bits that the update sets.
    pub bits: u32,
}

/// A recorded path, or a part of one.
#[derive(Clone, Copy, Debug)]
pub struct Path<'a> {
    /// Packed steps.
    pub steps: &'a [u32],
    /// Number of nodes visited.
    pub nodes: u64,
    /// Number of primitive list entries read.
    pub lists: u64,
    /// Number of triangles tested.
    pub triangles: u64,
}

/// A position in a [`Trail`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Mark {
    steps: usize,
    nodes: u64,
    lists: u64,
    triangles: u64,
}

impl Trail {
    /// The trail's present end.
    pub fn mark(&self) -> Mark {
        Mark { steps: self.steps.len(), nodes: self.nodes, lists: self.lists, triangles: self.triangles }
    }

    /// The part between two marks.
    pub fn between(&self, start: Mark, end: Mark) -> Path<'_> {
        Path {
            steps: &self.steps[start.steps..end.steps],
            nodes: end.nodes - start.nodes,
            lists: end.lists - start.lists,
            triangles: end.triangles - start.triangles,
        }
    }

    /// The whole path.
    pub fn path(&self) -> Path<'_> {
        self.between(Mark::default(), self.mark())
    }

    /// Removes everything and keeps the memory.
    pub fn clear(&mut self) {
        let (mut steps, mut fresh) = (std::mem::take(&mut self.steps), std::mem::take(&mut self.fresh));
        steps.clear();
        fresh.clear();
        *self = Self { steps, fresh, ..Self::default() };
    }

    /// An entry of a store was read.
    pub fn read(&mut self, store: Store, index: u32) {
        self.reads += 1;
        self.steps.push(Step::Read { store, index }.pack());
    }

    /// A whole entry of a store was written.
    pub fn write(&mut self, store: Store, index: u32) {
        self.writes += 1;
        self.steps.push(Step::Write { store, index }.pack());
    }

    /// An entry of a store was read, changed and written.
    pub fn update(&mut self, store: Store, index: u32) {
        self.writes += 1;
        self.steps.push(Step::Update { store, index }.pack());
    }

    /// Bits of a mode word were set, with this effect.
    pub fn set_bits(&mut self, word: u32, bits: u32, effect: Effect) {
        self.writes += 1;
        match effect {
            Effect::Changes => self.fresh.push(Fresh { at: self.steps.len(), word, bits }),
            Effect::Repeats => self.repeated += 1,
            Effect::Silent => self.silent += 1,
        }
        self.steps.push(Step::pack_word_update(word, effect));
    }
}

impl Observer for Trail {
    fn node(&mut self, node: NodeId) {
        self.nodes += 1;
        self.steps.push(Step::Node(node).pack());
    }

    fn list(&mut self, entry: ListId) {
        self.lists += 1;
        self.steps.push(Step::List(entry).pack());
    }

    fn triangle(&mut self, slot: TriangleSlot, stop: Stop) {
        self.triangles += 1;
        self.steps.push(Step::Triangle { slot, stop }.pack());
    }

    #[inline(always)]
    fn make_room(&mut self) {
        self.steps.make_room();
    }

    /// Always writes both nodes; `count` says how many are kept. So there is no branch to predict.
    #[inline(always)]
    fn nodes(&mut self, nodes: [NodeId; 2], count: usize) {
        self.nodes += count as u64;
        self.steps.write(nodes.map(|node| Step::Node(node).pack()), count);
    }

    #[inline(always)]
    fn missed(&mut self, slot: TriangleSlot, count: u32, in_plane: u32) {
        self.triangles += u64::from(count);
        let steps: [u32; 4] = std::array::from_fn(|at| {
            let (slot, in_plane) = (TriangleSlot(slot.0 + at as u32), in_plane >> at & 1 == 1);
            let [plane, edges] = [Stop::Plane, Stop::Edges].map(|stop| Step::Triangle { slot, stop }.pack());
            if in_plane { edges } else { plane }
        });
        self.steps.write(steps, count as usize);
    }
}
