//! How a shaft walks the static kd-tree: down to every cell that one of its rays may enter.

use super::node::View;
use super::traverse::Forest;
use crate::accel::shaft::{Shaft, Sight};
use crate::accel::structure::JoinedTree;
use crate::accel::trail::Observer;
use crate::quantity::{ListId, NodeId};

impl Forest<'_> {
    /// Looks for static blockers in the shaft, up to the first triangle that the shaft does not miss. A triangle in
    /// the lists of several leaves is tested in each.
    pub(crate) fn look(&self, shaft: &Shaft, watch: &mut impl Observer) -> Sight {
        let mut stack = vec![(u32::from(self.joined), self.statics.bounds)];
        while let Some((id, cell)) = stack.pop() {
            if shaft.misses_box(cell.low.as_dvec3(), cell.high.as_dvec3()) {
                continue;
            }
            watch.node(NodeId(id));
            let entries = match self.statics.nodes[id as usize].view(id) {
                View::Leaf(entries) => entries,
                View::Split { axis, at, children } => {
                    stack.extend(children.into_iter().zip(cell.split(axis, at)));
                    continue;
                }
            };
            for entry in entries {
                watch.list(ListId(entry));
                let slot = self.entry(entry);
                if let Some(sight) = shaft.test(slot, self.record(slot), watch).sight() {
                    return sight;
                }
            }
        }
        Sight::Clear
    }
}
