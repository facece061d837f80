//! Hand-built streams for tests.

use std::sync::Arc;

use crate::quantity::{LightId, NodeId, PixelId, PrimitiveId, Resolution, TriangleSlot};
use crate::stream::{
    Chunk, Decision, FrameInfo, Header, Item, Outcome, RayHead, RayKind, Step, Stop, Store, StoreEntries, Structure,
    Totals,
};

/// Static nodes, slots and primitives of [`header`].
pub(crate) const STATIC: u32 = 4096;
/// Static primitives of [`header`].
const STATIC_PRIMITIVES: u32 = 48;

/// The header of a scene with one light and [`STATIC`] static nodes, list entries and slots; few of its [`STATIC`]
/// primitives are static.
pub(crate) fn header() -> Header {
    Header {
        scene: "synthetic".into(),
        frames: vec![0],
        warmup: Vec::new(),
        resolution: Resolution { width: 1, height: 1 },
        policy: "none".into(),
        structure: Structure::Bvh2,
        lights: 1,
        static_primitives: STATIC_PRIMITIVES,
        primitives: STATIC,
        static_nodes: STATIC,
        static_slots: STATIC,
        static_list_entries: STATIC,
        stores: StoreEntries {
            mode_words: STATIC,
            word_owners: STATIC,
            words_per_primitive: 1,
            pixel_counters: STATIC,
            occluder_ids: STATIC,
        },
        unjudged_updates: false,
        input_hash: 0,
        records: (0..STATIC_PRIMITIVES).rev().map(TriangleSlot).collect(),
    }
}

/// The same header with more lights, whose modes take more words.
pub(crate) fn header_of(lights: u32) -> Header {
    let header = header();
    let words_per_primitive = 1 + lights.saturating_sub(15).div_ceil(16);
    let stores = StoreEntries { word_owners: STATIC / words_per_primitive, words_per_primitive, ..header.stores };
    Header { lights, stores, ..header }
}

/// A ray that is not in a stream yet.
#[derive(Clone, Debug)]
pub(crate) struct SyntheticRay {
    pub kind: RayKind,
    pub decision: Decision,
    pub parent: u32,
    pub path: Vec<Step>,
    /// Packed steps.
    pub policy: Vec<u32>,
}

impl SyntheticRay {
    pub(crate) fn primary(path: Vec<Step>) -> Self {
        Self { kind: RayKind::Primary, decision: Decision::Trace, parent: 0, path, policy: Vec::new() }
    }

    pub(crate) fn shadow(parent: u32, decision: Decision, path: Vec<Step>) -> Self {
        Self { kind: RayKind::Shadow, decision, parent, path, policy: Vec::new() }
    }

    pub(crate) fn with_policy(self, policy: Vec<Step>) -> Self {
        Self { policy: pack(&policy), ..self }
    }
}

fn pack(steps: &[Step]) -> Vec<u32> {
    steps.iter().map(|step| step.pack()).collect()
}

/// A frame of rays, in chunks of whole pixel groups with at least `chunk` rays each.
pub(crate) fn frame(info: FrameInfo, rays: &[SyntheticRay], end: &[Step], chunk: usize) -> Vec<Item> {
    let mut items = vec![Item::Frame(info)];
    let mut totals = Totals::default();
    let mut open = Chunk::default();
    for ray in rays {
        if ray.kind == RayKind::Primary && open.len() >= chunk {
            items.push(Item::Rays(Arc::new(std::mem::take(&mut open))));
        }
        let outcome = match ray.kind {
            RayKind::Shadow => Outcome::Lit,
            _ => Outcome::Hit(PrimitiveId(0)),
        };
        let head = RayHead {
            kind: ray.kind,
            light: LightId(0),
            decision: ray.decision,
            outcome,
            pixel: PixelId(0),
            parent: ray.parent,
        };
        open.push(head, &pack(&ray.path), &ray.policy);
        totals.count(&open.ray(open.len() - 1));
    }
    items.push(Item::Rays(Arc::new(open)));
    totals.count_policy(end.iter().copied());
    items.push(Item::End { policy: Arc::new(pack(end)), totals });
    items
}

/// Visits of nodes.
pub(crate) fn nodes(ids: impl IntoIterator<Item = u32>) -> Vec<Step> {
    ids.into_iter().map(|id| Step::Node(NodeId(id))).collect()
}

/// A triangle test.
pub(crate) fn triangle(slot: u32, stop: Stop) -> Step {
    Step::Triangle { slot: TriangleSlot(slot), stop }
}

/// A small generator of pseudo-random numbers for streams (xorshift64, Marsaglia 2003).
pub(crate) struct Numbers(pub u64);

impl Numbers {
    /// A number below `end`.
    pub(crate) fn below(&mut self, end: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (((self.0 >> 32) * u64::from(end)) >> 32) as u32
    }
}

/// A path that descends a tree of `depth` levels `descents` times, from the root or a node near it, with a triangle
/// test at each leaf. All rays share the upper levels; rays of the same `region` share the lower levels.
pub(crate) fn descent(numbers: &mut Numbers, region: u32, depth: u32, descents: u32) -> Vec<Step> {
    let mut path = Vec::new();
    for descent in 0..descents {
        let mut node = if descent == 0 { 1 } else { 2 + numbers.below(2) };
        while node < 1 << (depth - 1) {
            path.push(Step::Node(NodeId(node - 1)));
            let level = node.ilog2();
            let bit = if level + 2 < depth { region >> (level % 32) & 1 } else { numbers.below(2) };
            node = 2 * node + bit;
        }
        path.push(Step::Node(NodeId(node - 1)));
        let stop = [Stop::Plane, Stop::Plane, Stop::Edges, Stop::Hit][numbers.below(4) as usize];
        path.push(triangle(node - (1 << (depth - 1)), stop));
    }
    path
}

/// A frame similar to that of a BVH: `pixels` primary rays, each with a policy's read of a word, a shadow ray, and an
/// update of a counter. Neighbouring pixels go to the same region. The tree has `depth` levels.
pub(crate) fn bvh_like(seed: u64, pixels: u32, depth: u32, descents: u32) -> Vec<SyntheticRay> {
    let mut numbers = Numbers(seed);
    let mut rays = Vec::new();
    let mut region = 0;
    for pixel in 0..pixels {
        if pixel % 64 == 0 {
            region = numbers.below(u32::MAX);
        }
        let word = region >> 20 & (STATIC - 1);
        let decision = if numbers.below(4) == 0 { Decision::Skip } else { Decision::Trace };
        let read = Step::Read { store: Store::ModeWord, index: word };
        let update = Step::Update { store: Store::PixelCounter, index: word };
        rays.push(
            SyntheticRay::primary(descent(&mut numbers, region, depth, descents)).with_policy(vec![read, update]),
        );
        let path =
            if decision == Decision::Skip { Vec::new() } else { descent(&mut numbers, !region, depth, descents) };
        let or = Step::Update { store: Store::ModeWord, index: word };
        rays.push(SyntheticRay::shadow(1, decision, path).with_policy(vec![or]));
    }
    rays
}
