//! Trees of boxes with `N` children per node: `N` = 2 for the BVH2, 8 for the CwBVH.

use glam::Vec3;

use crate::accel::ray::Boxes;
use crate::accel::triangle::Record;

/// A reference to a child: a range of triangle slots, another node, or nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Child {
    /// The first slot of a leaf, or the node's id.
    pub index: u32,
    /// Number of triangles of a leaf; 0 for a node.
    pub count: u32,
}

impl Child {
    /// No child.
    pub(crate) const NONE: Self = Self { index: u32::MAX, count: 0 };

    /// Whether there is no child.
    pub(crate) fn is_none(self) -> bool {
        self == Self::NONE
    }
}

/// A node: the boxes of its children, axis by axis, and the references to them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node<const N: usize> {
    /// The children's boxes.
    bounds: Boxes<N>,
    /// The children; an absent one has a box at infinity, which no ray meets.
    pub children: [Child; N],
}

impl<const N: usize> Default for Node<N> {
    fn default() -> Self {
        Self { bounds: [[[f32::INFINITY; N]; 2]; 3], children: [Child::NONE; N] }
    }
}

impl<const N: usize> Node<N> {
    /// Sets child number `at` to `child`, with the given box.
    pub(crate) fn set(&mut self, at: usize, child: Child, low: Vec3, high: Vec3) {
        for (side, corner) in [low, high].into_iter().enumerate() {
            let [x, y, z] = &mut self.bounds;
            (x[side][at], y[side][at], z[side][at]) = corner.into();
        }
        self.children[at] = child;
    }

    /// The box around all children.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for child in (0..N).filter(|&child| !self.children[child].is_none()) {
            let (child_low, child_high) = self.corners(child);
            (low, high) = (low.min(child_low), high.max(child_high));
        }
        (low, high)
    }

    /// The lower and the upper corner of a child's box.
    pub(crate) fn corners(&self, child: usize) -> (Vec3, Vec3) {
        let [x, y, z] = &self.bounds;
        let corner = |side: usize| Vec3::new(x[side][child], y[side][child], z[side][child]);
        (corner(0), corner(1))
    }

    /// Half the area of a child's box.
    pub(crate) fn half_area(&self, child: usize) -> f32 {
        let (low, high) = self.corners(child);
        let [x, y, z] = (high - low).to_array();
        x * y + y * z + z * x
    }
}

/// A tree over static or dynamic triangles. Ids of nodes and slots are global (see [`NodeId`], [`TriangleSlot`]).
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree<const N: usize> {
    /// Nodes in depth-first order, the root first.
    pub nodes: Vec<Node<N>>,
    /// Triangle records in leaf order.
    pub records: Vec<Record>,
}
