//! Trees of boxes with `N` children a node: `N` = 2 for the BVH2, 8 for the CwBVH.

use glam::Vec3;

use crate::accel::ray::Ray;
use crate::accel::triangle::Record;

/// A reference to a child: a run of triangle slots, another node, or nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Child {
    /// The first slot of a leaf, or the node's id.
    pub index: u32,
    /// Triangles of a leaf; 0 for a node.
    pub count: u32,
}

impl Child {
    /// No child.
    pub const NONE: Self = Self { index: u32::MAX, count: 0 };

    /// Whether there is no child.
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }
}

/// A node: the boxes of its children, axis by axis, and the references to them.
#[derive(Clone, Copy, Debug)]
pub struct Node<const N: usize> {
    /// Lower bounds, by axis and child.
    pub low: [[f32; N]; 3],
    /// Upper bounds, by axis and child.
    pub high: [[f32; N]; 3],
    /// The children; an absent one has a box at infinity, which no ray meets.
    pub children: [Child; N],
}

impl<const N: usize> Default for Node<N> {
    fn default() -> Self {
        Self { low: [[f32::INFINITY; N]; 3], high: [[f32::INFINITY; N]; 3], children: [Child::NONE; N] }
    }
}

impl<const N: usize> Node<N> {
    /// Makes `child` the child number `at`, with the given box.
    pub fn set(&mut self, at: usize, child: Child, low: Vec3, high: Vec3) {
        for axis in 0..3 {
            self.low[axis][at] = low[axis];
            self.high[axis][at] = high[axis];
        }
        self.children[at] = child;
    }

    /// The box around all children.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for child in (0..N).filter(|&child| !self.children[child].is_none()) {
            low = low.min(Vec3::from_array(self.low.map(|planes| planes[child])));
            high = high.max(Vec3::from_array(self.high.map(|planes| planes[child])));
        }
        (low, high)
    }

    /// Where the ray enters each child's box, and infinity where it misses it.
    #[inline(always)]
    pub fn entries(&self, ray: &Ray) -> [f32; N] {
        ray.entries(&self.low, &self.high)
    }

    /// Half the area of a child's box.
    pub fn half_area(&self, child: usize) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.high[axis][child] - self.low[axis][child]);
        x * y + y * z + z * x
    }
}

/// A tree over static or dynamic triangles. Ids of nodes and slots are global (see [`NodeId`], [`TriangleSlot`]).
#[derive(Clone, Debug, Default)]
pub struct Tree<const N: usize> {
    /// Nodes in depth-first order, the root first.
    pub nodes: Vec<Node<N>>,
    /// Triangle records in leaf order.
    pub records: Vec<Record>,
}
