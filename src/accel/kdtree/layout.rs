//! Lays a built tree out in memory: nodes depth-first, lists in the order of the leaves, records in the order in which
//! the lists first name them.

use super::bounds::Bounds;
use super::built::Built;
use super::node::{Node, Tree};
use crate::accel::spec::KdLayout;
use crate::accel::structure::{Base, Item};
use crate::accel::triangle::Record;

const UNPLACED: u32 = u32::MAX;

struct Placer<'a> {
    cells: &'a [Built],
    items: &'a [Item<'a>],
    layout: KdLayout,
    base: Base,
    /// The slot of each item.
    slots: Vec<u32>,
    tree: Tree,
}

/// Lays out `cells`, of which the first is the root, with the box `bounds`.
pub(super) fn lay_out(cells: &[Built], bounds: Bounds, items: &[Item<'_>], layout: KdLayout, base: Base) -> Tree {
    let tree = Tree {
        bounds,
        nodes: Vec::with_capacity(cells.len()),
        lists: Vec::new(),
        records: Vec::with_capacity(items.len()),
    };
    let mut placer = Placer { cells, items, layout, base, slots: vec![UNPLACED; items.len()], tree };
    placer.node(0, bounds);
    // Each primitive has a record, also one that clipping left out of every leaf because no ray can hit it.
    for index in 0..items.len() {
        placer.slot(index);
    }
    placer.tree
}

impl Placer<'_> {
    fn node(&mut self, index: usize, bounds: Bounds) {
        let place = self.tree.nodes.len();
        self.tree.nodes.push(Node::leaf(0..0));
        self.tree.nodes[place] = match &self.cells[index] {
            Built::Leaf(items) => {
                let start = self.next_entry();
                for &item in items {
                    let slot = self.slot(item as usize);
                    self.tree.lists.push(slot);
                }
                Node::leaf(start..self.next_entry())
            }
            &Built::Split { axis, at, right } => {
                let [below, above] = bounds.split(axis, at);
                let reordered = self.layout == KdLayout::Ordered && above.area() > below.area();
                let [first, second] =
                    if reordered { [(right, above), (index + 1, below)] } else { [(index + 1, below), (right, above)] };
                self.node(first.0, first.1);
                let other = self.base.node + self.tree.nodes.len() as u32;
                self.node(second.0, second.1);
                Node::split(axis, at, other, reordered)
            }
        };
    }

    fn next_entry(&self) -> u32 {
        self.base.list + self.tree.lists.len() as u32
    }

    /// The item's slot; adds its record if it has none.
    fn slot(&mut self, index: usize) -> u32 {
        if self.slots[index] == UNPLACED {
            self.slots[index] = self.base.slot + self.tree.records.len() as u32;
            let Item { primitive, triangle } = self.items[index];
            self.tree.records.push(Record::new(triangle, primitive));
        }
        self.slots[index]
    }
}
