//! The kd-tree in memory.

use std::ops::Range;

use super::bounds::Bounds;
use crate::accel::triangle::Record;

/// A node as stored: a plane with its axis, or a range of list entries. The first word is the plane's position or the
/// start of the range. The second word has the axis (3 for a leaf) in 2 bits, the reorder bit, and 29 bits for the id
/// of the child that does not follow, or for the length of the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Node([u32; 2]);

/// The content of a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum View {
    /// Two children, left (below) and right (above) of a plane.
    Split {
        /// The axis across which the plane lies.
        axis: usize,
        /// The plane's position.
        at: f32,
        /// Ids of the left and the right child.
        children: [u32; 2],
    },
    /// The leaf's list entries.
    Leaf(Range<u32>),
}

const LEAF: u32 = 3;

impl Node {
    /// A node with two children. Child `other` does not follow the node: it is the right child, or the left one if
    /// `reordered`.
    pub(crate) fn split(axis: usize, at: f32, other: u32, reordered: bool) -> Self {
        Self([at.to_bits(), other << 3 | u32::from(reordered) << 2 | axis as u32])
    }

    /// A leaf.
    pub(crate) fn leaf(entries: Range<u32>) -> Self {
        Self([entries.start, (entries.end - entries.start) << 3 | LEAF])
    }

    /// Decodes the node; `id` is its own id.
    pub(crate) fn view(self, id: u32) -> View {
        let Self([first, second]) = self;
        let rest = second >> 3;
        if second & 3 == LEAF {
            return View::Leaf(first..first + rest);
        }
        let children = if second & 4 == 0 { [id + 1, rest] } else { [rest, id + 1] };
        View::Split { axis: (second & 3) as usize, at: f32::from_bits(first), children }
    }
}

/// A tree over static or dynamic triangles. Ids of nodes, list entries and slots are global.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    /// The box around all triangles.
    pub bounds: Bounds,
    /// Nodes in depth-first order; empty for a tree without triangles.
    pub nodes: Vec<Node>,
    /// The slots that the leaves list, in the order of the leaves.
    pub lists: Vec<u32>,
    /// Triangle records in the order in which the lists name them first.
    pub records: Vec<Record>,
}
