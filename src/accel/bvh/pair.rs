//! Nodes of the packed BVH2. Each holds the boxes of its children and of its grandchildren, so that one slab test does
//! the work of two or three visits.
//!
//! A ray that visits node A next visits the child that it enters first, for example B; after everything below B, it
//! visits the other child, C. Nothing is hit between A and B, so the test of A can also tell what the ray meets in B.
//! C has a node of its own.
//!
//! Each outcome of the test has its own code. The processor predicts the outcome and continues with the next node long
//! before the test is done. It would have to wait for a next node that is read from a table.

use super::packed::{Goal, NO_BOXES, Packed, Packing, Wide, set_box};
use super::stack::Stack;
use super::tree::{Node, Tree};
use crate::accel::lanes::{First, Lanes, Processor};
use crate::accel::query::Order;
use crate::accel::ray::Boxes;
use crate::accel::slabs::Slabs;
use crate::accel::trail::Observer;
use crate::quantity::NodeId;

/// Lanes of child B and of its two children; then lanes of C and its children. A child that is a leaf also takes the
/// first lane of its children.
const FAMILIES: [[usize; 3]; 2] = [[0, 1, 5], [4, 2, 6]];

/// Node A of the tree and its children B and C.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Pair {
    boxes: Boxes<8>,
    /// The content of each box.
    goals: [Goal; 8],
    /// Ids of A, B and C.
    ids: [u32; 3],
    /// Number of nodes that a visit records: of A alone, of A and B, and of A and C. A leaf does not count.
    nodes: [u8; 3],
    /// Bits that say whether the second sibling has the larger box, in the order of [`decide`].
    larger: u32,
}

/// The outcomes of [`decide`]. Index: the lanes that the ray meets (bits 0 to 6), and the second siblings that come
/// first: C, and the second children of B and C (bits 7 to 9).
static DECISIONS: [u8; 1024] = decisions();

const fn decisions() -> [u8; 1024] {
    let mut all = [0; 1024];
    let mut at = 0;
    while at < all.len() {
        all[at] = decide(at as u32 & 0x7f, at as u32 >> 7);
        at += 1;
    }
    all
}

/// 0 if nothing is met; otherwise 1 + first + 2 both + 4 children. "First" is the child that comes first (0 for B, 1
/// for C); "both" is 1 if both are met. "Children" says which of the first child's children are met: 0 none, 1 the
/// first, 2 the second, 3 both, 4 both with the second first.
const fn decide(met: u32, second_first: u32) -> u8 {
    let [b, c] = [met & 1 << FAMILIES[0][0] != 0, met & 1 << FAMILIES[1][0] != 0];
    if !b && !c {
        return 0;
    }
    let first = if c && (!b || second_first & 1 != 0) { 1 } else { 0 };
    let [_, one, two] = FAMILIES[first];
    let (one, two) = (met & 1 << one != 0, met & 1 << two != 0);
    let children = match (one, two) {
        (false, false) => 0,
        (true, false) => 1,
        (false, true) => 2,
        (true, true) => 3 + (second_first >> (1 + first) & 1) as u8,
    };
    1 + first as u8 + 2 * (b && c) as u8 + 4 * children
}

impl Wide<2> for Tree<2> {
    type Node = Pair;
}

impl Packing<2> for Pair {
    type Rest = (f32, Goal);
    type Few = [Self::Rest; 64];

    fn rests(children: usize) -> usize {
        children.saturating_sub(1)
    }

    #[inline(always)]
    fn few() -> Self::Few {
        [Self::Rest::default(); 64]
    }

    #[inline(always)]
    fn next<L: First>(_: L, _: &[Self], stack: &mut Stack<'_, Self::Rest>, last: f32) -> Option<Goal> {
        while let Some(&mut (entry, goal)) = stack.top() {
            stack.drop_top();
            if entry <= last {
                return Some(goal);
            }
        }
        None
    }

    fn pack(packed: &mut Packed<Self>, tree: &Tree<2>, node: usize) -> Self {
        let top = &tree.nodes[node];
        let mut pair =
            Self { boxes: NO_BOXES, goals: [Goal::default(); 8], ids: [packed.id(node); 3], nodes: [1; 3], larger: 0 };
        pair.larger = u32::from(top.half_area(1) > top.half_area(0));
        for (at, family) in FAMILIES.into_iter().enumerate() {
            let child = top.children[at];
            if child.is_none() {
                continue;
            }
            let goal = packed.goal(tree, child);
            pair.put(family[0], goal, top, at);
            if child.count > 0 {
                pair.put(family[1], goal, top, at);
                continue;
            }
            pair.ids[at + 1] = child.index;
            pair.nodes[at + 1] = 2;
            let below = &tree.nodes[packed.local(child.index)];
            pair.larger |= u32::from(below.half_area(1) > below.half_area(0)) << (at + 1);
            for (number, &child) in below.children.iter().enumerate().filter(|(_, child)| !child.is_none()) {
                pair.put(family[number + 1], packed.goal(tree, child), below, number);
            }
        }
        pair
    }

    #[inline(always)]
    fn visit<L: Processor>(
        &self,
        lanes: L,
        _: Goal,
        slabs: &Slabs<L>,
        order: Order,
        stack: &mut Stack<'_, (f32, Goal)>,
        watch: &mut impl Observer,
    ) -> Option<Goal> {
        let (near, met) = slabs.meet(&self.boxes);
        let second_first = match order {
            Order::NearestFirst => {
                let [a, b, c, d, e, f, g, h] = near;
                Lanes::<4>::below(lanes, lanes.load(&[e, f, g, h]), lanes.load(&[a, b, c, d]))
            }
            Order::LargestFirst => self.larger,
        };
        let decision = DECISIONS[(met | (second_first & 7) << 7) as usize & 1023];
        macro_rules! each {
            ($($code:literal)*) => {
                match decision {
                    $($code => self.go::<{ ($code - 1) % 2 }, { ($code - 1) / 2 % 2 }, { ($code - 1) / 4 }>(
                        &near, stack, watch,
                    ),)*
                    _ => {
                        watch.nodes([NodeId(self.ids[0]); 2], 1);
                        None
                    }
                }
            };
        }
        each!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20)
    }
}

impl Pair {
    /// Fills a lane with a child of `node`.
    fn put(&mut self, lane: usize, goal: Goal, node: &Node<2>, child: usize) {
        set_box(&mut self.boxes, lane, node.corners(child));
        self.goals[lane] = goal;
    }

    /// Goes to child `FIRST`, and pushes the other child if `BOTH` are met. `CHILDREN` says which children of the
    /// first child are met, and in which order, in the code of [`decide`].
    #[inline(always)]
    fn go<const FIRST: usize, const BOTH: usize, const CHILDREN: usize>(
        &self,
        near: &[f32; 8],
        stack: &mut Stack<'_, (f32, Goal)>,
        watch: &mut impl Observer,
    ) -> Option<Goal> {
        let child = 1 + FIRST;
        watch.nodes([self.ids[0], self.ids[child]].map(NodeId), usize::from(self.nodes[child]));
        let [[_, one, two], [other, ..]] = [FAMILIES[FIRST], FAMILIES[1 - FIRST]];
        let (first, second) = match CHILDREN {
            0 => (None, None),
            1 => (Some(one), None),
            2 => (Some(two), None),
            3 => (Some(one), Some(two)),
            _ => (Some(two), Some(one)),
        };
        if BOTH == 1 {
            stack.push((near[other], self.goals[other]));
        }
        if let Some(second) = second {
            stack.push((near[second], self.goals[second]));
        }
        first.map(|lane| self.goals[lane])
    }
}
