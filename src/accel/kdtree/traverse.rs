//! How a ray walks the kd-trees: front to back, with a stack of the parts that it visits later.
//!
//! The two trees overlap in space, so no plane separates them. Node 0 joins them: the static tree follows it directly,
//! and the dynamic tree's root is its other child. The boxes of both trees are in registers of the unit that tests the
//! scene's box (the ray dispatcher of the T&I engine). A shadow ray walks the static tree first. A ray that is traced
//! among dynamic objects stops at the first node without dynamic objects below it, as the published algorithm asks.
//! That node is the static tree's root, which is not even fetched: node 0 already tells.
//!
//! Every ray fetches node 0, as in the other structures. The stack is unbounded, or short: a short stack drops its
//! deepest entries and finds them again by another descent ([`super::stack`]).

use std::ops::Range;

use super::bounds::Bounds;
use super::node::{Node, Tree, View};
use super::stack::{Span, Stack};
use crate::accel::query::{Hit, Scope};
use crate::accel::ray::{Ray, SLAB};
use crate::accel::structure::JoinedTree;
use crate::accel::trail::Observer;
use crate::quantity::{ListId, NodeId, PrimitiveId, TriangleSlot};

/// The static tree and the dynamic one under one root.
pub(crate) struct Forest<'a> {
    /// Whether node 0 joins two trees; otherwise node 0 is the static tree's own root.
    pub joined: bool,
    /// The static tree, with ids from 0 on.
    pub statics: &'a Tree,
    /// The dynamic tree, with ids after the static ones.
    pub dynamic: Tree,
    /// Places of a ray's stack, if it is short.
    pub short_stack: Option<usize>,
}

impl Bounds {
    /// The part of the ray in the box, as a span of `node`.
    fn span(&self, ray: &Ray, node: u32) -> Option<Span> {
        let (mut enter, mut exit) = (0.0f32, ray.reach * SLAB);
        for axis in 0..3 {
            let (origin, inverse) = (ray.origin[axis], ray.inverse[axis]);
            if ray.is_parallel(axis) {
                if origin < self.low[axis] || origin > self.high[axis] {
                    return None;
                }
                continue;
            }
            let (near, far) =
                if inverse < 0.0 { (self.high[axis], self.low[axis]) } else { (self.low[axis], self.high[axis]) };
            enter = enter.max((near - origin) * inverse);
            exit = exit.min((far - origin) * inverse * SLAB);
        }
        (enter <= exit).then_some(Span { node, enter, exit, depth: 0 })
    }
}

impl Forest<'_> {
    fn node(&self, id: u32) -> Node {
        let id = id as usize;
        self.statics.nodes.get(id).copied().unwrap_or_else(|| self.dynamic.nodes[id - self.statics.nodes.len()])
    }

    /// The slot that a list's entry names.
    pub(super) fn entry(&self, id: u32) -> TriangleSlot {
        let id = id as usize;
        let entry = self.statics.lists.get(id).copied();
        TriangleSlot(entry.unwrap_or_else(|| self.dynamic.lists[id - self.statics.lists.len()]))
    }

    /// The ray's spans in the static and the dynamic tree, where it meets their boxes. Visits node 0, unless the walk
    /// of the static tree will visit it.
    fn start(&self, ray: &Ray, watch: &mut impl Observer) -> [Option<Span>; 2] {
        let spans = [
            self.statics.bounds.span(ray, u32::from(self.joined)),
            self.dynamic.bounds.span(ray, self.statics.nodes.len() as u32),
        ];
        if self.joined || spans[0].is_none() {
            watch.node(NodeId(0));
        }
        spans
    }

    /// Goes down to the first leaf that the ray enters; returns its entries.
    fn descend(&self, mut span: Span, ray: &Ray, stack: &mut Stack, watch: &mut impl Observer) -> Range<u32> {
        loop {
            stack.visit(&span);
            watch.node(NodeId(span.node));
            let (axis, at, [left, right]) = match self.node(span.node).view(span.node) {
                View::Leaf(entries) => return entries,
                View::Split { axis, at, children } => (axis, at, children),
            };
            let (origin, inverse) = (ray.origin[axis], ray.inverse[axis]);
            let (near, far) = if inverse < 0.0 { (right, left) } else { (left, right) };
            span.depth += 1;
            let plane = (at - origin) * inverse;
            // The comparisons allow for rounding on both sides, so that a ray through an edge of cells visits all
            // these cells.
            if at == origin && ray.is_parallel(axis) {
                // The ray lies in the plane, so it runs along both sides.
                stack.push(Span { node: far, ..span });
                span.node = near;
            } else if plane > span.exit * SLAB {
                span.node = near;
            } else if plane * SLAB < span.enter {
                span.node = far;
            } else {
                stack.push(Span { node: far, enter: plane.max(span.enter), ..span });
                span = Span { node: near, exit: plane.min(span.exit), ..span };
            }
        }
    }

    /// The nearest hit; at equal distance, the hit on the lowest primitive.
    pub(crate) fn nearest(&self, mut ray: Ray, watch: &mut impl Observer) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        let mut trees: Vec<_> = self.start(&ray, watch).into_iter().flatten().collect();
        // The tree that is entered first is on top; if both are entered together, the static tree.
        trees.sort_by(|a, b| b.enter.total_cmp(&a.enter).then(b.node.cmp(&a.node)));
        let mut stack = Stack::new(self.short_stack, trees);
        // A hit counts in whichever leaf it is found. It may lie beyond the leaf, so the cells before it are still
        // walked.
        while let Some(span) = stack.pop(ray.reach * SLAB, watch) {
            let exit = span.exit.min(ray.reach * SLAB);
            for entry in self.descend(Span { exit, ..span }, &ray, &mut stack, watch) {
                watch.list(ListId(entry));
                let slot = self.entry(entry);
                let stop = self.record(slot).test_nearest(&mut ray, &mut nearest);
                watch.triangle(slot, stop);
            }
        }
        nearest
    }

    /// The first triangle found that blocks the ray within `scope`. All static triangles are tried before the first
    /// dynamic one, so a dynamic blocker proves that no static triangle blocks.
    pub(crate) fn blocker(&self, ray: &Ray, scope: Scope, watch: &mut impl Observer) -> Option<PrimitiveId> {
        if scope == Scope::Dynamic && !self.joined {
            return None;
        }
        let [statics, dynamic] = self.start(ray, watch);
        let trees = [dynamic.filter(|_| scope != Scope::Static), statics.filter(|_| scope != Scope::Dynamic)];
        let mut stack = Stack::new(self.short_stack, trees.into_iter().flatten().collect());
        while let Some(span) = stack.pop(f32::INFINITY, watch) {
            for entry in self.descend(span, ray, &mut stack, watch) {
                watch.list(ListId(entry));
                let slot = self.entry(entry);
                let record = self.record(slot);
                let (stop, blocked) = record.blocks(ray);
                watch.triangle(slot, stop);
                if blocked {
                    return Some(record.primitive);
                }
            }
        }
        None
    }
}
