//! What `Auto` did with a stream, and why.

use serde::{Deserialize, Serialize};

/// What `Auto` did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// The target error.
    pub target: f64,
    /// Measured windows.
    pub windows: u64,
    /// Windows of the stream.
    pub of: u64,
    /// Processor time over that of `Event` on the whole stream, computed from the number of replayed rays.
    pub cost: f64,
    /// Why.
    pub why: Why,
}

/// Why `Auto` sampled, or did not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// A sample is within the target.
    Sampled,
    /// The stream has too few windows for a sample to pay: `Event` replayed everything.
    Short,
    /// Windows differ too much for a sample to pay: `Event` replayed everything.
    Varied,
}
