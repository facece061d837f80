//! The ids that each kind of step can have.

use super::extent::Extent;
use super::step::Step;
use super::violation::StepFault;

/// Number of tags of a packed word, including tags that no step has.
const TAGS: usize = 1 << (u32::BITS - INDEX_BITS);
const INDEX_BITS: u32 = Step::MAX_INDEX.trailing_ones();

/// For each tag of a packed step the number of allowed ids; 0 if the step itself is not allowed.
#[derive(Clone, Debug, Default)]
pub(super) struct Limits([u32; TAGS]);

impl Limits {
    /// The limits with `allowed(step)` ids for each kind of step.
    pub(super) fn new(allowed: impl Fn(Step) -> u64) -> Self {
        let mut limits = [0; TAGS];
        for (tag, limit) in limits.iter_mut().enumerate() {
            if let Some(step) = Step::unpack((tag as u32) << INDEX_BITS) {
                // A packed id cannot be larger, whatever the counts say.
                *limit = allowed(step).min(u64::from(Step::MAX_INDEX) + 1) as u32;
            }
        }
        Self(limits)
    }

    fn of(&self, word: u32) -> u32 {
        self.0[(word >> INDEX_BITS) as usize]
    }

    /// Whether all steps of an extent are possible.
    pub(super) fn hold(&self, extent: &Extent) -> bool {
        extent.outermost().all(|step| step.pack() & Step::MAX_INDEX < self.of(step.pack()))
    }

    /// Checks packed steps.
    pub(super) fn check(&self, words: &[u32]) -> Result<(), StepFault> {
        let is_wrong = |&word: &u32| word & Step::MAX_INDEX >= self.of(word);
        // Errors are rare, and a loop without an early exit is faster.
        if !words.iter().fold(false, |any, word| any | is_wrong(word)) {
            return Ok(());
        }
        let at = words.iter().position(is_wrong).expect("one of them is wrong");
        Err(match Step::unpack(words[at]) {
            None => StepFault::Unknown { at, word: words[at] },
            Some(step) => StepFault::Id { at, step, limit: self.of(words[at]) },
        })
    }
}
