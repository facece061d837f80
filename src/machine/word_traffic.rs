//! Which of a policy's recorded updates reach the shadow-cache units, and where decisions are made.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::stream::{Decision, Effect, Step};

/// Which updates of mode words are sent to a shadow-cache unit. Nearly all updates are silent: a word is learned once
/// and then confirmed by every ray. (Compare silent stores of processors: Lepak and Lipasti, "On the value locality of
/// store instructions", ISCA 2000.)
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SilentUpdates {
    /// All updates.
    #[default]
    Sent,
    /// Updates that change a bit of the latched word. Hardware can check this: the ray's hit has read the word, and its
    /// bits travel with the ray.
    Latched,
    /// Updates that change a bit after all earlier updates of the frame, in stream order. A limit: hits would have to
    /// read live words and see updates of rays in flight.
    Live,
}

impl SilentUpdates {
    /// Whether a packed step is an update that is not sent.
    #[inline]
    pub fn drops(self, word: u32) -> bool {
        match (self, Step::effect(word)) {
            (Self::Sent, _) | (_, None | Some(Effect::Changes)) => false,
            (Self::Latched, Some(effect)) => effect == Effect::Silent,
            (Self::Live, Some(_)) => true,
        }
    }
}

/// Where the decision on a shadow ray is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Decide {
    /// In a shadow-cache unit, to which a culled ray is sent.
    #[default]
    Unit,
    /// At the hit where the ray starts: the mode word returns with the hit's results, and a culled ray is never sent.
    Hit,
}

impl Decide {
    /// Whether a ray with this decision takes an operation of its own in a shadow-cache unit.
    pub fn takes_an_operation(self, decision: Decision) -> bool {
        self == Self::Unit && decision == Decision::Skip
    }

    /// Whether the host answers a ray with this decision and `steps` steps left.
    pub fn answers(self, decision: Decision, steps: usize) -> bool {
        self == Self::Hit && decision == Decision::Skip && steps == 0
    }
}

/// How the latched word, which decisions read, and the bits that the frame learns are stored separately. It matters
/// only for policies that keep counters: other policies change no word before the end of the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum LatchedCopy {
    /// Both values at the cost of one word. A limit.
    #[default]
    Free,
    /// The word holds the modes twice, and two bits of the frame's number. A read with an old number combines both
    /// halves, and an update with an old number merges them; neither costs an access. Up to 6 lights fit into 4 bytes
    /// (2 x (2 + 2 x 6) + 2 = 30 bits); otherwise the word takes 8 bytes.
    Wide,
    /// Learned bits have their own array of words, which receives the updates of rays. The end-of-frame update reads
    /// each updated word there and updates the latched word.
    Buffers,
}
