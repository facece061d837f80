//! A built kd-tree before its layout in memory.

/// A cell before the layout; the left child of a split follows the split.
pub(super) enum Built {
    Split {
        axis: usize,
        at: f32,
        right: usize,
    },
    /// Indices of items.
    Leaf(Vec<u32>),
}
