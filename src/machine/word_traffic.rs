//! Which of a policy's recorded updates reach the shadow-cache units, and where decisions are made.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::stream::{Decision, Effect, Step};

/// Which updates of mode words are sent to a shadow-cache unit. Nearly all of them change no bit: a word is learned
/// once and then confirmed by every ray. (Silent stores of processors are the same case: Lepak and Lipasti, "On the
/// value locality of store instructions", ISCA 2000.)
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SilentUpdates {
    /// All.
    #[default]
    Sent,
    /// Those that change a bit of the word as latched at the frame's start. Hardware knows: the ray's hit has read that
    /// word, and its bits go with the ray.
    Latched,
    /// Those that change a bit after all earlier updates of the frame, in the order of the stream. A limit: hits would
    /// have to read live words, and to see the updates of rays in flight.
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

/// Where the decision on a shadow ray falls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Decide {
    /// In a shadow-cache unit, to which a culled ray is sent.
    #[default]
    Unit,
    /// With the hit that the ray starts on: the word came back with the hit's results, and a culled ray is never sent.
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

/// How the word as latched at the frame's start, which decisions read, and the bits that the frame learns are kept
/// apart. It matters for policies that keep counters: the others change no word before the frame's end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum LatchedCopy {
    /// One word stands for both values and costs no more than one. A limit.
    #[default]
    Free,
    /// The word has the modes twice and two bits of the frame's number. A read whose number is old takes both
    /// halves together, an update whose number is old folds them; neither costs an access. The word takes 8 bytes
    /// where 4 are too few: up to 6 lights fit (2 x (2 + 2 x 6) + 2 = 30 bits).
    Wide,
    /// Learned bits have an array of words of their own, which updates of rays go to. At the frame's end each word
    /// that was updated is read there, and the latched one is updated.
    Buffers,
}
