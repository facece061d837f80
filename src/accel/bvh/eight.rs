//! Nodes of the packed CwBVH: one for each node of the tree.
//!
//! The children that a ray meets are not sorted: one stack entry holds all waiting children of a node. The next child
//! is looked for when the ray returns to the entry. Most children behind a hit are then dropped together.

use super::packed::{Goal, NO_BOXES, Packed, Packing, Wide, set_box};
use super::stack::Stack;
use super::tree::Tree;
use crate::accel::lanes::{First, Processor};
use crate::accel::query::Order;
use crate::accel::ray::Boxes;
use crate::accel::slabs::Slabs;
use crate::accel::trail::Observer;
use crate::quantity::NodeId;

/// A node with its eight children.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Eight {
    boxes: Boxes<8>,
    goals: [Goal; 8],
    id: u32,
    /// Sort key of each child in a visit by area: the larger the area, the smaller the key.
    sizes: [f32; 8],
}

/// The waiting children of a node.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rest {
    /// Sort keys of the children: the smallest is visited first.
    keys: [f32; 8],
    /// A bit for each waiting child.
    lanes: u32,
    /// The node.
    node: Goal,
}

impl Wide<8> for Tree<8> {
    type Node = Eight;
}

impl Packing<8> for Eight {
    type Rest = Rest;
    type Few = [Rest; 24];

    fn rests(children: usize) -> usize {
        usize::from(children > 1)
    }

    #[inline(always)]
    fn few() -> Self::Few {
        [Rest::default(); 24]
    }

    fn pack(packed: &mut Packed<Self>, tree: &Tree<8>, node: usize) -> Self {
        let source = &tree.nodes[node];
        let mut eight = Self { boxes: NO_BOXES, goals: [Goal::default(); 8], id: packed.id(node), sizes: [0.0; 8] };
        for (lane, &child) in source.children.iter().enumerate().filter(|(_, child)| !child.is_none()) {
            set_box(&mut eight.boxes, lane, source.corners(lane));
            eight.goals[lane] = packed.goal(tree, child);
            eight.sizes[lane] = -source.half_area(lane);
        }
        eight
    }

    #[inline(always)]
    fn visit<L: Processor>(
        &self,
        lanes: L,
        goal: Goal,
        slabs: &Slabs<L>,
        order: Order,
        stack: &mut Stack<'_, Rest>,
        watch: &mut impl Observer,
    ) -> Option<Goal> {
        watch.nodes([NodeId(self.id); 2], 1);
        let (near, met) = slabs.meet(&self.boxes);
        if met == 0 {
            return None;
        }
        let others = met & (met - 1);
        if others == 0 {
            return Some(self.goals[met.trailing_zeros() as usize & 7]);
        }
        let keys = match order {
            Order::NearestFirst => near,
            Order::LargestFirst => self.sizes,
        };
        let first = lanes.first(&keys, met);
        stack.push(Rest { keys, lanes: met & !(1 << first), node: goal });
        Some(self.goals[first & 7])
    }

    #[inline(always)]
    fn next<L: First>(lanes: L, nodes: &[Self], stack: &mut Stack<'_, Rest>, last: f32) -> Option<Goal> {
        while let Some(rest) = stack.top() {
            let within = rest.lanes & lanes.at_most(lanes.load(&rest.keys), lanes.splat(last));
            if within & within.wrapping_sub(1) == 0 {
                let goals = &nodes[rest.node.place()].goals;
                stack.drop_top();
                if within != 0 {
                    return Some(goals[within.trailing_zeros() as usize & 7]);
                }
                continue;
            }
            let first = lanes.first(&rest.keys, within);
            rest.lanes = within & !(1 << first);
            return Some(nodes[rest.node.place()].goals[first & 7]);
        }
        None
    }
}
