//! Which steps are possible: the ids of each kind of step.

use super::extent::Extent;
use super::step::Step;
use super::violation::StepFault;

/// Tags that a packed step can have, those of no step included.
const TAGS: usize = 1 << (u32::BITS - INDEX_BITS);
const INDEX_BITS: u32 = Step::MAX_INDEX.trailing_ones();

/// For each tag of a packed step the number of ids that it can have: 0 if the step cannot be there.
#[derive(Clone, Debug, Default)]
pub(super) struct Limits([u32; TAGS]);

impl Limits {
    /// The limits that `allowed` states for a step of each tag.
    pub fn new(allowed: impl Fn(Step) -> u64) -> Self {
        let mut limits = [0; TAGS];
        for (tag, limit) in limits.iter_mut().enumerate() {
            if let Some(step) = Step::unpack((tag as u32) << INDEX_BITS) {
                // No packed id is larger, whatever the counts say.
                *limit = allowed(step).min(u64::from(Step::MAX_INDEX) + 1) as u32;
            }
        }
        Self(limits)
    }

    fn of(&self, word: u32) -> u32 {
        self.0[(word >> INDEX_BITS) as usize]
    }

    /// Whether all steps of an extent are possible.
    pub fn hold(&self, extent: &Extent) -> bool {
        extent.outermost().all(|step| step.pack() & Step::MAX_INDEX < self.of(step.pack()))
    }

    /// Checks packed steps.
    pub fn check(&self, words: &[u32]) -> Result<(), StepFault> {
        let is_wrong = |&word: &u32| word & Step::MAX_INDEX >= self.of(word);
        // Where one is wrong hardly ever matters, and a loop without a way out is faster.
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
