//! Where a plot of a run stands.

/// The part of the page that a plot belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Section {
    /// What the policies did.
    Policies,
    /// What happened frame by frame.
    Frames,
    /// What the machine of that name measured.
    Machine(String),
}
