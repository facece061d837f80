//! The static part of a scene's acceleration structure.

use super::kind::{AnyStatic, on};
use super::spec::AccelSpec;
use super::structure::{Item, JoinedTree, StaticTree};
use super::triangle::Record;
use super::world::World;
use crate::quantity::{PrimitiveId, TriangleSlot};
use crate::scene::{Frame, Geometry, Scene};
use crate::stream::{FrameInfo, NO_RECORD, Structure};

/// The static part, built once for a scene.
pub struct Accel {
    spec: AccelSpec,
    statics: AnyStatic,
    /// The slot of each static primitive.
    slots: Vec<TriangleSlot>,
}

impl Accel {
    /// Builds the static tree.
    pub fn new(scene: &Scene, spec: AccelSpec) -> Self {
        let items: Vec<_> = items(&scene.statics, 0).collect();
        let statics = AnyStatic::build(&items, &spec, scene.dynamic_count > 0);
        let slots = on!(&statics, tree => slots(tree.records(), 0, items.len()));
        Self { spec, statics, slots }
    }

    /// The kind of tree.
    pub fn structure(&self) -> Structure {
        self.spec.structure
    }

    /// The number of nodes of the root and the static tree.
    pub fn static_nodes(&self) -> u32 {
        on!(&self.statics, tree => tree.sizes().nodes)
    }

    /// The number of entries of the static tree's primitive lists.
    pub fn static_list_entries(&self) -> u32 {
        on!(&self.statics, tree => tree.sizes().list_entries)
    }

    /// The number of static triangle records.
    pub fn static_slots(&self) -> u32 {
        self.slots.len() as u32
    }

    /// The slot of each static primitive's record; [`NO_RECORD`] for an invisible primitive.
    pub fn static_records(&self) -> &[TriangleSlot] {
        &self.slots
    }

    /// Builds the frame's dynamic tree and joins it with the static one.
    pub fn frame<'a>(&'a self, scene: &'a Scene, frame: &'a Frame) -> World<'a> {
        let first = scene.statics.len() as u32;
        let visible = items(&frame.dynamic, first).zip(&frame.visible).filter(|&(_, &visible)| visible);
        let items: Vec<_> = visible.map(|(item, _)| item).collect();
        let tree = self.statics.join(&items, &self.spec);
        let (sizes, dynamic_slots) = on!(&tree, tree => {
            (tree.dynamic_sizes(), slots(tree.dynamic_records(), first, scene.dynamic_count))
        });
        let info = FrameInfo {
            number: frame.number,
            dynamic_nodes: sizes.nodes,
            dynamic_slots: items.len() as u32,
            dynamic_list_entries: sizes.list_entries,
        };
        World::new(tree, info, &self.slots, dynamic_slots)
    }
}

fn items(geometry: &Geometry, first: u32) -> impl Iterator<Item = Item<'_>> {
    let numbered = (first..).zip(&geometry.triangles);
    numbered.map(|(index, triangle)| Item { primitive: PrimitiveId(index), triangle })
}

/// The slot of each of `count` primitives from `first` on; [`NO_RECORD`] for an invisible triangle, which has no
/// record.
fn slots(records: &[Record], first: u32, count: usize) -> Vec<TriangleSlot> {
    let mut slots = vec![NO_RECORD; count];
    for (slot, record) in records.iter().enumerate() {
        slots[(record.primitive.0 - first) as usize] = TriangleSlot(slot as u32);
    }
    slots
}
