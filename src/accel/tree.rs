//! Trees of boxes with `N` children a node, and how a ray walks them: one loop for the BVH2 (`N` = 2) and the CwBVH
//! (`N` = 8).
//!
//! Children are visited nearest first, unless a shadow ray asks for another order, ties in the node's own order; a child that lies behind the nearest hit by the
//! time it is taken from the stack is dropped without a visit.

use glam::Vec3;

use super::ray::SLAB;
use super::trail::Observer;
use super::triangle::Record;
use super::{Hit, Order, Ray, Scope};
use crate::quantity::{NodeId, PrimitiveId, TriangleSlot};

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
    fn entries(&self, ray: &Ray) -> [f32; N] {
        ray.entries(&self.low, &self.high)
    }

    /// Half the area of a child's box.
    fn half_area(&self, child: usize) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.high[axis][child] - self.low[axis][child]);
        x * y + y * z + z * x
    }
}

/// A tree over static or dynamic triangles. Ids of nodes and slots are global (see [`NodeId`], [`TriangleSlot`]).
#[derive(Clone, Debug)]
pub struct Tree<const N: usize> {
    /// Nodes in depth-first order, the root first.
    pub nodes: Vec<Node<N>>,
    /// Triangle records in leaf order.
    pub records: Vec<Record>,
}

/// The static tree and the dynamic one under one root.
pub struct Forest<'a, const N: usize> {
    /// Node 0. With dynamic triangles it joins the two trees (child 0 and child 1); without, it is the static tree's own.
    pub root: Node<N>,
    /// Whether the root joins two trees.
    pub joined: bool,
    /// Nodes and records with ids from 0 on; node 0 itself is `root`.
    pub statics: &'a Tree<N>,
    /// Nodes and records with ids after the static ones.
    pub dynamic: Tree<N>,
}

/// Children that wait, each with what it is sorted by among its siblings. One allocation a ray is faster here than a stack
/// that may spill.
type Stack = Vec<(f32, Child)>;

impl<const N: usize> Forest<'_, N> {
    /// The box around the static tree.
    pub fn static_bounds(&self) -> (Vec3, Vec3) {
        let root = if self.joined { self.statics.nodes.get(1) } else { self.statics.nodes.first() };
        root.unwrap_or(&Node::default()).bounds()
    }

    fn node(&self, id: u32) -> &Node<N> {
        let id = id as usize;
        self.statics.nodes.get(id).unwrap_or_else(|| &self.dynamic.nodes[id - self.statics.nodes.len()])
    }

    /// The record in a slot.
    pub fn record(&self, slot: u32) -> &Record {
        let slot = slot as usize;
        self.statics.records.get(slot).unwrap_or_else(|| &self.dynamic.records[slot - self.statics.records.len()])
    }

    /// Visits a node: pushes the children that the ray meets, the first in `order` last.
    fn visit(&self, node: &Node<N>, ray: &Ray, order: Order, stack: &mut Stack) {
        let entries = node.entries(ray);
        let first = stack.len();
        for (number, (entry, &child)) in entries.into_iter().zip(&node.children).enumerate() {
            if entry < f32::INFINITY {
                let key = match order {
                    Order::NearestFirst => entry,
                    Order::LargestFirst => -node.half_area(number),
                };
                // Insertion, the last in order first; an equal key goes below, so that the node's own order decides a
                // tie.
                let mut at = stack.len();
                while at > first && stack[at - 1].0 <= key {
                    at -= 1;
                }
                stack.insert(at, (key, child));
            }
        }
    }

    /// The nearest hit; at equal distance the one on the lowest primitive.
    pub fn closest(&self, mut ray: Ray, watch: &mut impl Observer) -> Option<Hit> {
        let mut stack = Stack::with_capacity(64);
        let mut nearest: Option<Hit> = None;
        watch.node(NodeId(0));
        self.visit(&self.root, &ray, Order::NearestFirst, &mut stack);
        while let Some((entry, child)) = stack.pop() {
            if entry > ray.reach * SLAB {
                continue;
            }
            if child.count == 0 {
                watch.node(NodeId(child.index));
                self.visit(self.node(child.index), &ray, Order::NearestFirst, &mut stack);
                continue;
            }
            for slot in child.index..child.index + child.count {
                let record = self.record(slot);
                let (stop, hit) = record.test(&ray);
                watch.triangle(TriangleSlot(slot), stop);
                let Some(hit) = hit else { continue };
                let nearer = nearest.is_none_or(|old| (hit.t, record.primitive) < (old.t, old.primitive));
                if nearer && hit.t <= ray.reach {
                    ray.reach = hit.t;
                    nearest = Some(Hit { primitive: record.primitive, t: hit.t, barycentric: hit.barycentric });
                }
            }
        }
        nearest
    }

    /// A triangle that blocks the ray within `scope`, the first found in `order`; static triangles are all tried before
    /// the first dynamic one, so that a dynamic blocker proves that no static one blocks.
    pub fn occluded(&self, ray: &Ray, scope: Scope, order: Order, watch: &mut impl Observer) -> Option<PrimitiveId> {
        if scope == Scope::Dynamic && !self.joined {
            return None;
        }
        let mut stack = Stack::with_capacity(64);
        watch.node(NodeId(0));
        if self.joined {
            let entries = self.root.entries(ray);
            let trees = match scope {
                Scope::All => 0..2,
                Scope::Static => 0..1,
                Scope::Dynamic => 1..2,
            };
            for tree in trees.rev() {
                if entries[tree] < f32::INFINITY {
                    stack.push((entries[tree], self.root.children[tree]));
                }
            }
        } else {
            self.visit(&self.root, ray, order, &mut stack);
        }
        self.first_blocker(ray, order, stack, watch)
    }

    /// A triangle that blocks the ray, among those below a node, the nearest children first.
    pub fn occluded_below(&self, ray: &Ray, node: NodeId, watch: &mut impl Observer) -> Option<PrimitiveId> {
        let stack = vec![(0.0, Child { index: node.0, count: 0 })];
        self.first_blocker(ray, Order::NearestFirst, stack, watch)
    }

    fn first_blocker(
        &self,
        ray: &Ray,
        order: Order,
        mut stack: Stack,
        watch: &mut impl Observer,
    ) -> Option<PrimitiveId> {
        while let Some((_, child)) = stack.pop() {
            if child.count == 0 {
                watch.node(NodeId(child.index));
                self.visit(self.node(child.index), ray, order, &mut stack);
                continue;
            }
            for slot in child.index..child.index + child.count {
                let record = self.record(slot);
                let (stop, blocked) = record.blocks(ray);
                watch.triangle(TriangleSlot(slot), stop);
                if blocked {
                    return Some(record.primitive);
                }
            }
        }
        None
    }
}
