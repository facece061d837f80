//! What `Auto` did with a stream, and why.

use serde::{Deserialize, Serialize};

/// What `Auto` did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// The error that was asked for.
    pub target: f64,
    /// Windows that were measured.
    pub windows: u64,
    /// Windows of the stream.
    pub of: u64,
    /// Processor time over that of `Event` on the whole stream, by count of the rays that were replayed.
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
    /// The stream has so few windows that a sample would not pay: `Event` replayed everything.
    Short,
    /// Windows differ so much that a sample would not pay: `Event` replayed everything.
    Varied,
}
