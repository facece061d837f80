//! How a shaft walks the static tree of boxes.

use super::forest::Forest;
use super::packed::Wide;
use super::tree::{Child, Node, Tree};
use crate::accel::shaft::{Shaft, Sight};
use crate::accel::structure::JoinedTree;
use crate::accel::trail::Observer;
use crate::quantity::{NodeId, TriangleSlot};

impl<const N: usize> Forest<'_, N>
where
    Tree<N>: Wide<N>,
{
    /// Looks for static blockers in the shaft, up to the first triangle that the shaft does not miss.
    pub(crate) fn look(&self, shaft: &Shaft, watch: &mut impl Observer) -> Sight {
        if self.statics.records.is_empty() {
            return Sight::Clear;
        }
        let mut stack = vec![Child { index: u32::from(self.joined), count: 0 }];
        while let Some(child) = stack.pop() {
            if child.count == 0 {
                watch.node(NodeId(child.index));
                self.statics.nodes[child.index as usize].meet(shaft, &mut stack);
                continue;
            }
            for slot in child.index..child.index + child.count {
                if let Some(sight) = shaft.test(TriangleSlot(slot), self.record(TriangleSlot(slot)), watch).sight() {
                    return sight;
                }
            }
        }
        Sight::Clear
    }
}

impl<const N: usize> Node<N> {
    /// Pushes the children that a ray of the shaft may visit.
    fn meet(&self, shaft: &Shaft, stack: &mut Vec<Child>) {
        for (at, &child) in self.children.iter().enumerate() {
            let (low, high) = self.corners(at);
            if !child.is_none() && !shaft.misses_box(low.as_dvec3(), high.as_dvec3()) {
                stack.push(child);
            }
        }
    }
}
