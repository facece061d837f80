//! Which windows of a stream are replayed.

use std::ops::Range;

use crate::machine::MachineSpec;

/// Pieces of a window.
pub const PIECES: usize = 2;

/// How much is replayed. Windows stand in strata of consecutive ones; of each stratum some are measured, drawn one after another
/// by a hash, so that a later pass can measure the next ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Windows a stratum.
    pub stratum: usize,
    /// Which of a stratum's draws are measured.
    pub draws: Range<usize>,
    /// Pixels of a window: it is cut in [`PIECES`], and a piece before it and one behind it are replayed too.
    pub pixels: usize,
    /// Which windows: by a hash of this and the stratum's number.
    pub seed: u64,
}

impl Plan {
    /// The plan that measures about `rate` of the windows of a stream on `machine`, two a stratum.
    pub fn new(rate: f64, machine: &MachineSpec, seed: u64) -> Self {
        let stratum = (2.0 / rate).round().max(2.0) as usize;
        Self { stratum, draws: 0..2, pixels: Self::pixels_of_window(machine), seed }
    }

    /// Pixels of a window on `machine`. As many primary rays as the pool has entries can be in flight, and their children come after them: with
    /// less a piece, windows would be mixed. Where the pool is small, what is in flight at a window's ends must not count: with windows of
    /// 256 pixels `small` moved 3.2 % too many L2 bytes (robot, `Hybrid()`), with 1024 it is 0.3 %.
    pub fn pixels_of_window(machine: &MachineSpec) -> usize {
        PIECES * (machine.pool() as usize).max(512)
    }

    /// Share of the windows that are measured by this pass and those before.
    pub fn rate(&self) -> f64 {
        self.draws.end.min(self.stratum) as f64 / self.stratum as f64
    }

    /// How many draws of each stratum should do for intervals of `target`, when those so far gave `share`: intervals shrink with the root of
    /// the number of windows. A quarter more is taken, since the width of an interval is itself known from a sample only.
    pub fn enough_draws(&self, share: f64, target: f64) -> usize {
        let needed = 1.25 * self.draws.end as f64 * (share / target).powi(2);
        (needed.ceil() as usize).clamp(self.draws.end + 1, self.stratum.max(self.draws.end + 1))
    }

    /// Whether each window of a stratum is measured.
    pub fn measures(&self, stratum: usize) -> Vec<bool> {
        let mut order: Vec<usize> = (0..self.stratum).collect();
        let mut measured = vec![false; self.stratum];
        for draw in 0..self.draws.end.min(self.stratum) {
            let hash = mix(self.seed ^ mix(((stratum as u64) << 20) + draw as u64));
            order.swap(draw, draw + (hash % (self.stratum - draw) as u64) as usize);
            measured[order[draw]] = self.draws.contains(&draw);
        }
        measured
    }
}

/// SplitMix64's output function (Steele, Lea and Flood 2014).
pub fn mix(seed: u64) -> u64 {
    let x = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_measure_each_window_once() {
        for stratum in [2, 7, 40] {
            let plan = |draws| Plan { stratum, draws, pixels: 128, seed: 3 };
            let mut times = vec![0; stratum];
            for draws in [0..2, 2..4, 4..8, 8..16, 16..64] {
                let measures = plan(draws).measures(5);
                times.iter_mut().zip(measures).for_each(|(times, measures)| *times += u32::from(measures));
            }
            assert_eq!(times, vec![1; stratum]);
        }
    }
}
