//! The section of a stress report's page in which a plot stands.

/// A section of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Section {
    /// The outcome of each case.
    Map,
    /// Wrong decisions by frame.
    OverFrames,
}
