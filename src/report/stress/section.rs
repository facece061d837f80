//! Where a plot of a stress report stands.

/// The part of the page that a plot belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Section {
    /// How each case ended.
    Map,
    /// What happened frame by frame.
    OverFrames,
}
