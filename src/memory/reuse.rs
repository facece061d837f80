//! Reuse (stack) distances: the number of other lines touched since the last touch of a line (Mattson et al. 1970). A
//! fully associative LRU cache of `n` lines hits if the distance is less than `n`: one pass gives the hits for all
//! sizes.

use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::paged::Paged;
use crate::random::mix;

/// Touches per word of bits, and per block of words.
const WORD: usize = 64;
const BLOCK: usize = 64 * WORD;
/// Marks an untouched line.
const NEVER: u32 = u32::MAX;

/// One bit per time: whether it is the last touch of a line. Words of bits, and the number of ones in each block of
/// words.
#[derive(Clone, Debug, Default)]
struct Bits {
    words: Vec<u64>,
    blocks: Vec<u32>,
}

impl Bits {
    fn new(blocks: usize) -> Self {
        Self { words: vec![0; blocks * (BLOCK / WORD)], blocks: vec![0; blocks] }
    }

    fn set(&mut self, time: usize) {
        self.words[time / WORD] |= 1 << (time % WORD);
        self.blocks[time / BLOCK] += 1;
    }

    fn clear(&mut self, time: usize) {
        self.words[time / WORD] &= !(1 << (time % WORD));
        self.blocks[time / BLOCK] -= 1;
    }

    fn has(&self, time: usize) -> bool {
        self.words[time / WORD] >> (time % WORD) & 1 == 1
    }

    /// Number of ones after `time`.
    fn since(&self, time: usize) -> u64 {
        let (word, block) = (time / WORD, time / BLOCK);
        let end = (block + 1) * (BLOCK / WORD);
        let in_word = u64::from((self.words[word] & !1 << (time % WORD)).count_ones());
        let in_block: u64 = self.words[word + 1..end].iter().map(|word| u64::from(word.count_ones())).sum();
        in_word + in_block + self.blocks[block + 1..].iter().map(|&ones| u64::from(ones)).sum::<u64>()
    }
}

/// The LRU stack of one cache. Lines belong to groups; distances are counted per group.
#[derive(Clone, Debug)]
pub(crate) struct Stack<const GROUPS: usize = 1> {
    /// The last touch of each line.
    last: Paged<u32>,
    /// The line touched at each time.
    line: Vec<u32>,
    bits: [Bits; GROUPS],
}

impl<const GROUPS: usize> Default for Stack<GROUPS> {
    fn default() -> Self {
        Self { last: Paged::new(NEVER), line: Vec::new(), bits: std::array::from_fn(|_| Bits::default()) }
    }
}

impl<const GROUPS: usize> Stack<GROUPS> {
    /// Touches `line` of `group`. Returns the number of other lines of each group touched since its last touch, or
    /// `None` at its first touch.
    pub(crate) fn touch(&mut self, line: u32, group: usize) -> Option<[u64; GROUPS]> {
        if self.line.len() == self.bits[0].words.len() * WORD {
            self.make_room();
        }
        let now = self.line.len();
        let before = std::mem::replace(self.last.at(line as usize), now as u32);
        self.line.push(line);
        let distance = (before != NEVER).then(|| {
            let since = std::array::from_fn(|group| self.bits[group].since(before as usize));
            self.bits[group].clear(before as usize);
            since
        });
        self.bits[group].set(now);
        distance
    }

    /// Renumbers times: keeps only each line's last touch, in order. At least as many free times follow.
    fn make_room(&mut self) {
        let group = |time: usize| (0..GROUPS).find(|&group| self.bits[group].has(time));
        let kept: Vec<(u32, usize)> =
            (0..self.line.len()).filter_map(|time| group(time).map(|group| (self.line[time], group))).collect();
        let blocks = (2 * kept.len() / BLOCK) + 1;
        self.bits = std::array::from_fn(|_| Bits::new(blocks));
        self.line.clear();
        for (time, (line, group)) in kept.into_iter().enumerate() {
            *self.last.at(line as usize) = time as u32;
            self.bits[group].set(time);
            self.line.push(line);
        }
    }

    /// Forgets the touches of lines from `first` on.
    pub(crate) fn drop_from(&mut self, first: u32) {
        for (_, last) in self.last.from(first as usize).filter(|(_, last)| **last != NEVER) {
            let time = std::mem::replace(last, NEVER) as usize;
            let group = (0..GROUPS).find(|&group| self.bits[group].has(time));
            self.bits[group.expect("a line that was touched is of a group")].clear(time);
        }
    }
}

/// A share of the lines, chosen by a hash (SHARDS: Waldspurger et al. 2015), plus fixed hot lines. Every ray touches
/// the first nodes of a hierarchy: a random sample with only one or none of them has a large error.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    rate: f64,
    hot: Arc<FxHashSet<u32>>,
    stack: Stack<2>,
}

/// A touch of a sampled line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sampled {
    /// The estimated distance; `None` for a first touch.
    pub distance: Option<u64>,
    /// The number of touches that this touch represents.
    pub weight: f64,
}

impl Sample {
    /// Samples a share `rate` of the lines and all lines of `hot`.
    pub(crate) fn new(rate: f64, hot: Arc<FxHashSet<u32>>) -> Self {
        Self { rate, hot, stack: Stack::default() }
    }

    /// Touches `line`; returns `None` if it is not in the sample.
    pub(crate) fn touch(&mut self, line: u32) -> Option<Sampled> {
        if self.hot.contains(&line) {
            return Some(Sampled { distance: self.estimate(line, 0), weight: 1.0 });
        }
        let hash = mix(u64::from(line)) as f64 / 2f64.powi(64);
        (hash < self.rate).then(|| Sampled { distance: self.estimate(line, 1), weight: 1.0 / self.rate })
    }

    fn estimate(&mut self, line: u32, group: usize) -> Option<u64> {
        let [hot, others] = self.stack.touch(line, group)?;
        Some(hot + (others as f64 / self.rate) as u64)
    }

    /// Forgets lines from `first` on.
    pub(crate) fn drop_from(&mut self, first: u32) {
        self.stack.drop_from(first);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::memory::replacement::Policy;
    use crate::memory::tags::TagArray;
    use crate::quantity::LineAddr;
    use crate::stats::TrafficClass;

    #[test]
    fn a_sample_of_everything_is_exact_with_and_without_hot_lines() {
        for hot in [0..0, 0..16] {
            let (mut sample, mut stack) = (Sample::new(1.0, Arc::new(hot.collect())), Stack::<1>::default());
            for line in (0..4000u64).map(|at| (mix(at) % 200) as u32) {
                let distance = stack.touch(line, 0).map(|[distance]| distance);
                assert_eq!(sample.touch(line), Some(Sampled { distance, weight: 1.0 }));
            }
        }
    }

    proptest! {
        /// Compares with a searched list; some lines are dropped on the way.
        #[test]
        fn distances_are_those_of_a_list(touches in prop::collection::vec((0..300u32, 0..200u32), 1..12_000)) {
            let (mut stack, mut list) = (Stack::<1>::default(), Vec::new());
            for (line, dice) in touches {
                // Half of the touches go to few lines.
                let line = if dice % 2 == 0 { line % 8 } else { line };
                let place = list.iter().rev().position(|&other| other == line);
                prop_assert_eq!(stack.touch(line, 0), place.map(|place| [place as u64]));
                list.retain(|&other| other != line);
                list.push(line);
                if dice == 77 {
                    stack.drop_from(40);
                    list.retain(|&line| line < 40);
                }
            }
        }

        /// An LRU set hits where the distance is less than its ways.
        #[test]
        fn misses_are_those_of_a_set(lines in prop::collection::vec(0..64u32, 1..2000), ways in 1..64usize) {
            let (mut stack, mut tags) = (Stack::<1>::default(), TagArray::new(1, ways, 0, Policy::Lru));
            for line in lines {
                let hit = tags.access(LineAddr(line.into()), false);
                if !hit {
                    tags.fill(LineAddr(line.into()), TrafficClass::Node, false);
                }
                prop_assert_eq!(stack.touch(line, 0).is_some_and(|[distance]| distance < ways as u64), hit);
            }
        }
    }
}
