//! The section of a run's page in which a plot stands.

/// A section of the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Section {
    /// Results of the policies.
    Policies,
    /// Results by frame.
    Frames,
    /// Results of the machine with this name.
    Machine(String),
}
