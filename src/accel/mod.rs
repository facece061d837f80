//! Acceleration structures: a static tree built once, a dynamic tree built every frame, both under one root.
//!
//! A scene in which nothing moves has no dynamic tree, and its root is the static tree's own.

mod ancestry;
pub mod build;
pub mod kdtree;
pub mod ray;
pub mod shaft;
#[cfg(test)]
mod tests;
pub mod trail;
pub mod tree;
pub mod triangle;

use glam::{Vec2, Vec3};
use obvhs::BvhBuildParams;
use serde::{Deserialize, Serialize};

use self::ancestry::Ancestry;
use self::build::{Base, Build, Item};
pub use self::ray::Ray;
pub use self::shaft::{Relation, Shaft, Sight};
pub use self::trail::{Fresh, Mark, Observer, Path, Silent, Trail};
use self::tree::{Child, Forest, Node, Tree};
use crate::quantity::{NodeId, PrimitiveId, TriangleSlot};
use crate::ranged::Within;
use crate::scene::{Frame, Scene};
use crate::stream::{FrameInfo, NO_RECORD, Structure};

/// Which structure is built, and how well.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AccelSpec {
    /// The kind of tree.
    pub structure: Structure,
    /// How much work goes into the static tree.
    pub statics: Quality,
    /// How much work goes into the dynamic tree, each frame.
    pub dynamic: Quality,
    /// The order of a kd-tree's nodes; the other structures have one order only.
    pub kd_layout: kdtree::Layout,
    /// Entries of a ray's stack in a kd-tree: a full one drops its deepest entry, and the ray goes down again when it needs that. Without a limit if
    /// it is not given.
    pub kd_stack: Option<Within<1, 64>>,
    /// The level at which no cell of a kd-tree is split any more; by the number of triangles if it is not given.
    pub kd_depth: Option<Within<1, 64>>,
}

impl Default for AccelSpec {
    fn default() -> Self {
        Self {
            structure: Structure::Bvh2,
            statics: Quality::Best,
            dynamic: Quality::Fast,
            kd_layout: kdtree::Layout::Ordered,
            kd_stack: None,
            kd_depth: None,
        }
    }
}

impl AccelSpec {
    fn kd(self, quality: Quality) -> kdtree::BuildSpec {
        let max_depth = self.kd_depth.map(|depth| depth.get() as u32);
        kdtree::BuildSpec { quality, layout: self.kd_layout, max_depth }
    }
}

/// How well a tree is built. For BVHs, presets of obvhs without pre-splits, so that each triangle has one record; for
/// kd-trees see [`kdtree::build`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quality {
    /// For trees that live one frame.
    Fast,
    /// A good tree.
    Medium,
    /// The best that there is.
    Best,
}

impl Quality {
    fn params(self) -> BvhBuildParams {
        let preset = match self {
            Self::Fast => BvhBuildParams::fast_build(),
            Self::Medium => BvhBuildParams::medium_build(),
            Self::Best => BvhBuildParams::very_slow_build(),
        };
        BvhBuildParams { pre_split: false, ..preset }
    }
}

/// What a shadow ray is traced among.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Everything, static triangles first.
    All,
    /// Dynamic triangles only.
    Dynamic,
    /// Static triangles only.
    Static,
}

/// In which order a shadow ray visits the children of a node that it meets. It changes what is visited before a blocker
/// is found, never whether one is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// By where the ray enters their boxes.
    #[default]
    NearestFirst,
    /// By the area of their boxes (SATO: Nah and Manocha 2014).
    LargestFirst,
}

/// The nearest hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// What is hit.
    pub primitive: PrimitiveId,
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Barycentric coordinates of corners 1 and 2.
    pub barycentric: Vec2,
}

/// The static part, made once for a scene.
pub struct Accel {
    spec: AccelSpec,
    /// Whether there is a dynamic part to join.
    joined: bool,
    statics: Statics,
    /// The slot of each static primitive.
    slots: Vec<TriangleSlot>,
    /// Of a BVH.
    ancestry: Option<Ancestry>,
}

enum Statics {
    Bvh2(Tree<2>),
    CwBvh(Tree<8>),
    KdTree(kdtree::Tree),
}

impl Accel {
    /// Builds the static tree.
    pub fn new(scene: &Scene, spec: AccelSpec) -> Self {
        let joined = scene.dynamic_count > 0;
        let items: Vec<_> = scene
            .statics
            .triangles
            .iter()
            .enumerate()
            .map(|(index, triangle)| Item { primitive: PrimitiveId(index as u32), triangle })
            .collect();
        let params = spec.statics.params();
        let (statics, slots, ancestry) = match spec.structure {
            Structure::Bvh2 => {
                let tree = static_tree(&items, params, joined);
                let slots = slots(&tree.records, 0, items.len());
                let ancestry = Ancestry::of(&tree);
                (Statics::Bvh2(tree), slots, Some(ancestry))
            }
            Structure::CwBvh => {
                let tree = static_tree(&items, params, joined);
                let slots = slots(&tree.records, 0, items.len());
                let ancestry = Ancestry::of(&tree);
                (Statics::CwBvh(tree), slots, Some(ancestry))
            }
            Structure::KdTree => {
                let tree = kdtree::build_static(&items, spec.kd(spec.statics), joined);
                let slots = slots(&tree.records, 0, items.len());
                (Statics::KdTree(tree), slots, None)
            }
        };
        Self { spec, joined, statics, slots, ancestry }
    }

    /// Which structure it is.
    pub fn structure(&self) -> Structure {
        self.spec.structure
    }

    /// The number of nodes of the root and the static tree.
    pub fn static_nodes(&self) -> u32 {
        match &self.statics {
            Statics::Bvh2(tree) => tree.nodes.len() as u32,
            Statics::CwBvh(tree) => tree.nodes.len() as u32,
            Statics::KdTree(tree) => tree.nodes.len() as u32,
        }
    }

    /// The number of entries of the static tree's primitive lists.
    pub fn static_list_entries(&self) -> u32 {
        match &self.statics {
            Statics::Bvh2(_) | Statics::CwBvh(_) => 0,
            Statics::KdTree(tree) => tree.lists.len() as u32,
        }
    }

    /// The number of static triangle records.
    pub fn static_slots(&self) -> u32 {
        self.slots.len() as u32
    }

    /// The record of each static primitive; [`crate::stream::NO_RECORD`] for an invisible one.
    pub fn static_records(&self) -> &[TriangleSlot] {
        &self.slots
    }

    /// Builds the frame's dynamic tree and joins it with the static one.
    pub fn frame<'a>(&'a self, scene: &'a Scene, frame: &'a Frame) -> World<'a> {
        let first = scene.statics.len() as u32;
        let items: Vec<_> = frame
            .dynamic
            .triangles
            .iter()
            .enumerate()
            .filter(|&(index, _)| frame.visible[index])
            .map(|(index, triangle)| Item { primitive: PrimitiveId(first + index as u32), triangle })
            .collect();
        let base = Base { node: self.static_nodes(), slot: self.static_slots(), list: self.static_list_entries() };
        let params = self.spec.dynamic.params();
        let (forest, nodes, list_entries, dynamic_slots) = match &self.statics {
            Statics::Bvh2(statics) => {
                let forest = forest(statics, self.joined, &items, params, base);
                let slots = slots(&forest.dynamic.records, first, scene.dynamic_count);
                let nodes = forest.dynamic.nodes.len();
                (Kind::Bvh2(forest), nodes, 0, slots)
            }
            Statics::CwBvh(statics) => {
                let forest = forest(statics, self.joined, &items, params, base);
                let slots = slots(&forest.dynamic.records, first, scene.dynamic_count);
                let nodes = forest.dynamic.nodes.len();
                (Kind::CwBvh(forest), nodes, 0, slots)
            }
            Statics::KdTree(statics) => {
                let dynamic = kdtree::build(&items, self.spec.kd(self.spec.dynamic), base);
                let slots = slots(&dynamic.records, first, scene.dynamic_count);
                let (nodes, entries) = (dynamic.nodes.len(), dynamic.lists.len());
                let short_stack = self.spec.kd_stack.map(|places| places.size());
                let forest = kdtree::Forest { joined: self.joined, statics, dynamic, short_stack };
                (Kind::KdTree(forest), nodes, entries, slots)
            }
        };
        let info = FrameInfo {
            number: frame.number,
            dynamic_nodes: nodes as u32,
            dynamic_slots: items.len() as u32,
            dynamic_list_entries: list_entries as u32,
        };
        World { forest, info, static_slots: &self.slots, ancestry: self.ancestry.as_ref(), dynamic_slots }
    }
}

/// The static tree; with dynamic triangles to join, node 0 is kept free for the root.
fn static_tree<const N: usize>(items: &[Item<'_>], params: BvhBuildParams, joined: bool) -> Tree<N>
where
    Tree<N>: Build,
{
    if items.is_empty() {
        return Tree { nodes: vec![Node::default()], records: Vec::new() };
    }
    if !joined {
        return Tree::build(items, params, Base::default());
    }
    let mut tree = Tree::build(items, params, Base { node: 1, ..Base::default() });
    tree.nodes.insert(0, Node::default());
    tree
}

fn forest<'a, const N: usize>(
    statics: &'a Tree<N>,
    joined: bool,
    items: &[Item<'_>],
    params: BvhBuildParams,
    base: Base,
) -> Forest<'a, N>
where
    Tree<N>: Build,
{
    let dynamic = if items.is_empty() {
        Tree { nodes: Vec::new(), records: Vec::new() }
    } else {
        Tree::build(items, params, base)
    };
    let mut root = statics.nodes[0];
    if joined {
        let trees = [(statics.nodes.get(1), 1), (dynamic.nodes.first(), base.node)];
        for (at, (tree, index)) in trees.into_iter().enumerate() {
            if let Some(tree) = tree {
                let (low, high) = tree.bounds();
                root.set(at, Child { index, count: 0 }, low, high);
            }
        }
    }
    Forest { root, joined, statics, dynamic }
}

/// The slot of each primitive from `first` on; what has no record (an invisible triangle) has a slot that is never
/// asked for.
fn slots(records: &[triangle::Record], first: u32, count: usize) -> Vec<TriangleSlot> {
    let mut slots = vec![NO_RECORD; count];
    for (slot, record) in records.iter().enumerate() {
        slots[(record.primitive.0 - first) as usize] = TriangleSlot(slot as u32);
    }
    slots
}

enum Kind<'a> {
    Bvh2(Forest<'a, 2>),
    CwBvh(Forest<'a, 8>),
    KdTree(kdtree::Forest<'a>),
}

/// Everything that rays can meet in one frame.
pub struct World<'a> {
    forest: Kind<'a>,
    info: FrameInfo,
    static_slots: &'a [TriangleSlot],
    ancestry: Option<&'a Ancestry>,
    /// Slots of dynamic primitives, counted from the first dynamic slot.
    dynamic_slots: Vec<TriangleSlot>,
}

/// Why some methods are never called on a kd-tree.
const BOXES_ONLY: &str = "a policy that needs a tree of boxes is refused with a kd-tree before it is built";

impl World<'_> {
    /// Sizes of the frame's dynamic part.
    pub fn info(&self) -> FrameInfo {
        self.info
    }

    /// The nearest hit; at equal distance the one on the lowest primitive.
    pub fn closest(&self, ray: &Ray, watch: &mut impl Observer) -> Option<Hit> {
        match &self.forest {
            Kind::Bvh2(forest) => forest.closest(*ray, watch),
            Kind::CwBvh(forest) => forest.closest(*ray, watch),
            Kind::KdTree(forest) => forest.closest(*ray, watch),
        }
    }

    /// A triangle that blocks the ray; if it is dynamic, no static triangle blocks.
    pub fn occluded(&self, ray: &Ray, scope: Scope, watch: &mut impl Observer) -> Option<PrimitiveId> {
        self.occluded_in_order(ray, scope, Order::NearestFirst, watch)
    }

    /// The same, with the children of a BVH's nodes visited in `order`: perhaps another triangle, and yet one if there is one. A
    /// kd-tree is walked front to back.
    pub fn occluded_in_order(
        &self,
        ray: &Ray,
        scope: Scope,
        order: Order,
        watch: &mut impl Observer,
    ) -> Option<PrimitiveId> {
        match &self.forest {
            Kind::Bvh2(forest) => forest.occluded(ray, scope, order, watch),
            Kind::CwBvh(forest) => forest.occluded(ray, scope, order, watch),
            Kind::KdTree(forest) => forest.occluded(ray, scope, watch),
        }
    }

    /// A static triangle below the static node `node` of a BVH that blocks the ray.
    pub fn occluded_below(&self, ray: &Ray, node: NodeId, watch: &mut impl Observer) -> Option<PrimitiveId> {
        match &self.forest {
            Kind::Bvh2(forest) => forest.occluded_below(ray, node, watch),
            Kind::CwBvh(forest) => forest.occluded_below(ray, node, watch),
            Kind::KdTree(_) => unreachable!("{BOXES_ONLY}"),
        }
    }

    /// Whether one visible primitive's triangle blocks the ray. If it does, [`World::occluded`] finds a blocker too.
    pub fn blocks(&self, ray: &Ray, primitive: PrimitiveId, watch: &mut impl Observer) -> bool {
        if matches!(self.forest, Kind::KdTree(_)) {
            // Cells are no boxes around the triangle's own: only a hit by more than rounding is certain to be found.
            return self.surely_blocked(ray, primitive, watch);
        }
        let slot = self.slot(primitive);
        let (stop, blocked) = self.record(slot).blocks(ray);
        watch.triangle(slot, stop);
        blocked
    }

    /// The node that is `levels` levels above the leaf of a static primitive, or the static tree's root if that is lower.
    /// Level 1 is the node that holds the leaf. For a BVH.
    pub fn ancestor(&self, primitive: PrimitiveId, levels: u32) -> NodeId {
        self.ancestry.expect(BOXES_ONLY).ancestor(self.slot(primitive), levels)
    }

    /// The box around all static triangles; empty without any.
    pub fn static_bounds(&self) -> (Vec3, Vec3) {
        match &self.forest {
            Kind::Bvh2(forest) => forest.static_bounds(),
            Kind::CwBvh(forest) => forest.static_bounds(),
            Kind::KdTree(forest) => forest.static_bounds(),
        }
    }

    /// Tests one visible primitive's triangle: the distance of the hit, if there is one.
    pub fn test(&self, ray: &Ray, primitive: PrimitiveId, watch: &mut impl Observer) -> Option<f32> {
        let slot = self.slot(primitive);
        let (stop, hit) = self.record(slot).test(ray);
        watch.triangle(slot, stop);
        hit.map(|hit| hit.t)
    }

    /// A static triangle's record.
    pub fn static_record(&self, primitive: PrimitiveId) -> &triangle::Record {
        self.record(self.static_slots[primitive.0 as usize])
    }

    /// Looks for static blockers of the rays of `shaft`.
    pub fn sight(&self, shaft: &Shaft, watch: &mut impl Observer) -> Sight {
        match &self.forest {
            Kind::Bvh2(forest) => forest.sight(shaft, watch),
            Kind::CwBvh(forest) => forest.sight(shaft, watch),
            Kind::KdTree(forest) => forest.sight(shaft, watch),
        }
    }

    /// What a static triangle does to the rays of `shaft`.
    pub fn relation(&self, shaft: &Shaft, primitive: PrimitiveId, watch: &mut impl Observer) -> Relation {
        let slot = self.slot(primitive);
        shaft.test(slot, self.record(slot), watch)
    }

    /// Whether one visible primitive's triangle is certain to block `ray`, also when the tree is traversed.
    pub fn surely_blocked(&self, ray: &Ray, primitive: PrimitiveId, watch: &mut impl Observer) -> bool {
        let slot = self.slot(primitive);
        let (stop, blocked) = self.record(slot).surely_blocks(ray);
        watch.triangle(slot, stop);
        blocked
    }

    fn record(&self, slot: TriangleSlot) -> &triangle::Record {
        match &self.forest {
            Kind::Bvh2(forest) => forest.record(slot.0),
            Kind::CwBvh(forest) => forest.record(slot.0),
            Kind::KdTree(forest) => forest.record(slot),
        }
    }

    fn slot(&self, primitive: PrimitiveId) -> TriangleSlot {
        let index = primitive.0 as usize;
        match index.checked_sub(self.static_slots.len()) {
            None => self.static_slots[index],
            Some(index) => TriangleSlot(self.static_slots.len() as u32 + self.dynamic_slots[index].0),
        }
    }
}
