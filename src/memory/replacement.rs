//! Which line of a full set goes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::random::mix;

/// The replacement policy: which line of a full set is evicted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Policy {
    /// The least recently used line.
    #[default]
    Lru,
    /// The line that was filled first.
    Fifo,
    /// Tree pseudo-LRU: a binary tree of bits per set points away from recently used lines. The number of ways must be
    /// a power of two.
    TreePlru,
    /// A pseudo-random line: a hash of the seed and the number of fills so far.
    Random {
        /// The seed of the hash.
        seed: u64,
    },
}

/// State of a policy for one cache, besides the order of the lines in their sets.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum State {
    /// The order of the lines in a set is the state; the last line is the next victim. A fill moves a line to the
    /// front; with `on_use` a use does so too.
    Order { on_use: bool },
    /// A word of tree bits per set. Bit `n` belongs to node `n`; the root is node 1. Each bit points to the side of the
    /// next victim.
    Tree { bits: Vec<u64> },
    /// The number of fills.
    Random { seed: u64, fills: u64 },
}

impl State {
    pub(super) fn new(policy: Policy, sets: usize) -> Self {
        match policy {
            Policy::Lru => Self::Order { on_use: true },
            Policy::Fifo => Self::Order { on_use: false },
            Policy::TreePlru => Self::Tree { bits: vec![0; sets] },
            Policy::Random { seed } => Self::Random { seed, fills: 0 },
        }
    }

    /// Whether a use of a set's first line changes nothing.
    #[inline]
    pub(super) fn is_order(&self) -> bool {
        matches!(self, Self::Order { .. })
    }

    /// Whether the state is LRU order alone.
    #[inline]
    pub(super) fn is_used_order(&self) -> bool {
        matches!(self, Self::Order { on_use: true })
    }

    /// Line `way` of set `set`, whose lines are `lines`, was used.
    #[inline]
    pub(super) fn used(&mut self, set: usize, way: usize, lines: &mut [u64]) {
        match self {
            Self::Order { on_use: true } => to_front(lines, way),
            Self::Tree { bits } => point_away(&mut bits[set], way, lines.len()),
            Self::Order { on_use: false } | Self::Random { .. } => {}
        }
    }

    /// Line `way` of set `set`, whose lines are `lines`, was filled.
    pub(super) fn filled(&mut self, set: usize, way: usize, lines: &mut [u64]) {
        match self {
            Self::Order { .. } => to_front(lines, way),
            Self::Tree { bits } => point_away(&mut bits[set], way, lines.len()),
            Self::Random { fills, .. } => *fills += 1,
        }
    }

    /// The way of the next victim in a full set. Changes nothing.
    pub(super) fn victim(&self, set: usize, ways: usize) -> usize {
        match self {
            Self::Order { .. } => ways - 1,
            Self::Tree { bits } => {
                let mut node = 1;
                while node < ways {
                    node = 2 * node + (bits[set] >> node & 1) as usize;
                }
                node - ways
            }
            Self::Random { seed, fills } => (mix(seed ^ mix(*fills)) % ways as u64) as usize,
        }
    }
}

/// Moves line `way` to the front. Most uses are of the first few lines.
#[inline]
fn to_front(lines: &mut [u64], way: usize) {
    let mut next = lines[way];
    for line in &mut lines[..=way] {
        std::mem::swap(line, &mut next);
    }
}

/// Sets the bits from the root to `way` so that they point to the other side.
fn point_away(bits: &mut u64, way: usize, ways: usize) {
    let mut node = way + ways;
    while node > 1 {
        let came_from_right = node & 1;
        node /= 2;
        *bits = *bits & !(1 << node) | ((1 - came_from_right as u64) << node);
    }
}
