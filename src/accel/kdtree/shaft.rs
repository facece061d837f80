//! How a shaft walks the static kd-tree: down to every cell that a ray of it may come to.

use super::View;
use super::traverse::Forest;
use crate::accel::shaft::{Relation, Shaft, Sight};
use crate::accel::{Observer, Ray};
use crate::quantity::{ListId, NodeId, TriangleSlot};

impl Forest<'_> {
    /// Looks for static blockers in the shaft, up to the first triangle that it does not miss. A triangle that several
    /// leaves list is tested in each.
    pub fn sight(&self, shaft: &Shaft, watch: &mut impl Observer) -> Sight {
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
                match self.relation(shaft, TriangleSlot(self.statics.lists[entry as usize]), watch) {
                    Relation::Misses => {}
                    Relation::Covers => return Sight::Blocked,
                    Relation::Crosses => return Sight::Unknown,
                }
            }
        }
        Sight::Clear
    }

    /// What the static triangle in `slot` does to the rays of `shaft`.
    pub fn relation(&self, shaft: &Shaft, slot: TriangleSlot, watch: &mut impl Observer) -> Relation {
        let (stop, relation) = shaft.relation(&self.statics.records[slot.0 as usize]);
        watch.triangle(slot, stop);
        relation
    }

    /// Whether the static triangle in `slot` is certain to block `ray`, also when the tree is traversed.
    pub fn surely_blocked(&self, ray: &Ray, slot: TriangleSlot, watch: &mut impl Observer) -> bool {
        let (stop, blocked) = self.statics.records[slot.0 as usize].surely_blocks(ray);
        watch.triangle(slot, stop);
        blocked
    }
}
