//! How a ray walks the trees of boxes: one loop for both widths.
//!
//! Children are visited nearest first, unless a shadow ray asks for another order; ties go by the node's own order. A
//! child that lies behind the nearest hit by the time it is taken from the stack is dropped without a visit.

use super::forest::Forest;
use super::tree::{Child, Node};
use crate::accel::query::{Hit, Order, Scope};
use crate::accel::ray::{Ray, SLAB};
use crate::accel::structure::JoinedTree;
use crate::accel::trail::Observer;
use crate::quantity::{NodeId, PrimitiveId, TriangleSlot};

/// A child that the ray meets, with what it is sorted by among its siblings.
type Met = (f32, Child);

/// Children that wait. One allocation a ray is faster here than a stack that may spill.
type Stack = Vec<Met>;

/// Visits a node: gives the child that the ray meets first in `order`, and pushes the others, the next one last.
#[inline(always)]
fn visit<const N: usize>(node: &Node<N>, ray: &Ray, order: Order, stack: &mut Stack) -> Option<Met> {
    let (mut met, mut count) = ([(0.0, Child::NONE); N], 0);
    for (number, entry) in node.entries(ray).into_iter().enumerate() {
        if entry < f32::INFINITY {
            let key = match order {
                Order::NearestFirst => entry,
                Order::LargestFirst => -node.half_area(number),
            };
            // Insertion, the last in order first; an equal key goes below, so that the node's own order decides a
            // tie.
            let mut at = count;
            while at > 0 && met[at - 1].0 <= key {
                met[at] = met[at - 1];
                at -= 1;
            }
            met[at] = (key, node.children[number]);
            count += 1;
        }
    }
    let (first, others) = met[..count].split_last()?;
    others.iter().for_each(|&child| stack.push(child));
    Some(*first)
}

/// The nearest hit; at equal distance the one on the lowest primitive.
pub(crate) fn nearest<const N: usize, W: Observer>(forest: &Forest<'_, N>, mut ray: Ray, watch: &mut W) -> Option<Hit> {
    let mut stack = Stack::with_capacity(64);
    let mut nearest: Option<Hit> = None;
    watch.node(NodeId(0));
    let mut next = visit(&forest.root, &ray, Order::NearestFirst, &mut stack);
    while let Some((entry, child)) = next.take().or_else(|| stack.pop()) {
        if entry > ray.reach * SLAB {
            continue;
        }
        if child.count == 0 {
            watch.node(NodeId(child.index));
            next = visit(forest.node(child.index), &ray, Order::NearestFirst, &mut stack);
            continue;
        }
        for slot in child.index..child.index + child.count {
            let stop = forest.record(TriangleSlot(slot)).test_nearest(&mut ray, &mut nearest);
            watch.triangle(TriangleSlot(slot), stop);
        }
    }
    nearest
}

/// A triangle that blocks the ray, among those below the children on the stack.
fn first_blocker<const N: usize, W: Observer>(
    forest: &Forest<'_, N>,
    ray: &Ray,
    order: Order,
    mut stack: Stack,
    watch: &mut W,
) -> Option<PrimitiveId> {
    let mut next = None;
    while let Some((_, child)) = next.take().or_else(|| stack.pop()) {
        if child.count == 0 {
            watch.node(NodeId(child.index));
            next = visit(forest.node(child.index), ray, order, &mut stack);
            continue;
        }
        for slot in child.index..child.index + child.count {
            let record = forest.record(TriangleSlot(slot));
            let (stop, blocked) = record.blocks(ray);
            watch.triangle(TriangleSlot(slot), stop);
            if blocked {
                return Some(record.primitive);
            }
        }
    }
    None
}

impl<const N: usize> Forest<'_, N> {
    /// A triangle that blocks the ray within `scope`, the first found in `order`; static triangles are all tried before
    /// the first dynamic one, so that a dynamic blocker proves that no static one blocks.
    pub(crate) fn blocker(
        &self,
        ray: &Ray,
        scope: Scope,
        order: Order,
        watch: &mut impl Observer,
    ) -> Option<PrimitiveId> {
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
        } else if let Some(first) = visit(&self.root, ray, order, &mut stack) {
            stack.push(first);
        }
        first_blocker(self, ray, order, stack, watch)
    }

    /// A triangle that blocks the ray, among those below a node, the nearest children first.
    pub(crate) fn blocker_below(&self, ray: &Ray, node: NodeId, watch: &mut impl Observer) -> Option<PrimitiveId> {
        let stack = vec![(0.0, Child { index: node.0, count: 0 })];
        first_blocker(self, ray, Order::NearestFirst, stack, watch)
    }
}
