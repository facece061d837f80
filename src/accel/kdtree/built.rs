//! A kd-tree between its building and its layout.

/// A cell that is built, before the layout; the left child of a split follows it.
pub(super) enum Built {
    Split {
        axis: usize,
        at: f32,
        right: usize,
    },
    /// Indices of items.
    Leaf(Vec<u32>),
}
