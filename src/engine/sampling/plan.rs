//! Which windows of a stream are replayed.

use std::ops::Range;

use super::estimate::Total;
use crate::engine::Share;
use crate::machine::MachineSpec;

/// Pixels before a window, and of it, at least.
const LEAST_BEFORE: usize = 1024;
const LEAST_OWN: usize = 512;

/// How a stream is cut: windows are of so many pieces, which are replayed between so many others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Pixels of a piece, about.
    pub pixels: usize,
    /// Pieces before the window: they fill what is in flight.
    pub before: usize,
    /// The window's own.
    pub own: usize,
    /// Pieces behind it: they keep what is in flight full.
    pub behind: usize,
}

impl Cut {
    /// The cut for `machine`. As many primary rays as the pool has entries can be in flight, and their children come after them: a piece has as
    /// many pixels. It takes a while until an empty machine works as one in the middle of a frame (which units get which rays hangs on which were
    /// fast before): with one piece before windows of two, all windows of kitchen and robot on `tni_engine` moved 2.3 % more and 6.1 % fewer bytes
    /// of the L2 than the whole, with two pieces 0.5 % more and 0.8 % fewer; on `small`, with a pool of 128, robot moves 1.2 % more with two pieces
    /// before, 0.7 % with three, 0.1 % with eight. More pieces behind change nothing. Windows of two pieces take the fewest pixels for an interval
    /// of a width; of 128 or 256 pixels they are too short for what happens at their ends.
    pub fn new(machine: &MachineSpec) -> Self {
        let pixels = machine.pool() as usize;
        Self { pixels, before: LEAST_BEFORE.div_ceil(pixels).max(2), own: LEAST_OWN.div_ceil(pixels).max(2), behind: 1 }
    }

    /// Pixels that are replayed for one of a window.
    pub fn effort(&self) -> f64 {
        (self.before + self.own + self.behind) as f64 / self.own as f64
    }

    /// Pixels of a window.
    pub fn window(&self) -> usize {
        self.own * self.pixels
    }
}

/// How much is replayed. Windows stand in strata of consecutive ones; of each stratum some are measured, drawn one after another
/// by a hash, so that a later pass can measure the next ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Windows a stratum.
    pub stratum: usize,
    /// Which of a stratum's draws are measured.
    pub draws: Range<usize>,
    /// Which of these `Event` replays besides, to correct the others.
    pub corrected: Range<usize>,
    /// What a window is, and what is replayed beside it.
    pub cut: Cut,
    /// Which windows: by a hash of this and the stratum's number.
    pub seed: u64,
}

impl Plan {
    /// The plan that measures about `rate` of the windows of a stream on `machine`, two a stratum.
    pub fn new(rate: f64, machine: &MachineSpec, seed: u64) -> Self {
        let stratum = (2.0 / rate).round().max(2.0) as usize;
        Self { stratum, draws: 0..2, corrected: 0..0, cut: Cut::new(machine), seed }
    }

    /// The plan that measures about `rate` of the windows, and about `corrected` of them by `Event` too: two a stratum of what there is less of.
    pub fn of(rate: Share, corrected: Option<Share>, machine: &MachineSpec, seed: u64) -> Self {
        let Some(corrected) = corrected else { return Self::new(rate.get(), machine, seed) };
        let plan = Self::new(corrected.get(), machine, seed);
        let draws = (rate.get() * plan.stratum as f64).round().clamp(2.0, plan.stratum as f64) as usize;
        Self { draws: 0..draws, corrected: 0..2, ..plan }
    }

    /// What another pass should measure for twice as many windows of either kind, when `Event` replayed `corrected` of each stratum.
    pub fn doubled(&self, corrected: usize) -> Self {
        let draws = self.draws.end..2 * self.draws.end;
        Self { corrected: draws.start..draws.start + corrected, draws, ..self.clone() }
    }

    /// Share of the windows that are measured by this pass and those before.
    pub fn rate(&self) -> f64 {
        self.draws.end.min(self.stratum) as f64 / self.stratum as f64
    }

    /// What another pass should measure for intervals of `target`, when those of `totals` came from `draws` of each stratum, of which `Event`
    /// replayed `corrected`, and `cost` windows take as long as one of these. Variances fall with the number of windows; how many there should be of either kind
    /// is Neyman's allocation (Cochran 1977, chapter 12). A quarter more is taken, since variances are themselves known from a sample only.
    pub fn next(&self, totals: &[Total], corrected: usize, cost: f64, target: f64) -> Self {
        let (draws, all) = (self.draws.end as f64, self.stratum as f64);
        let mut wanted = [draws + 1.0, 0.0];
        for total in totals {
            let Some(share) = total.share() else { continue };
            let [windows, corrections] = total.variances;
            // Variances of one window a stratum, of as many strata, that are drawn from ever so many.
            let drawn = |variance: f64, n: f64| if n < all { variance * n / (1.0 - n / all) } else { 0.0 };
            let [windows, corrections] = [drawn(windows, draws), drawn(corrections, corrected as f64)];
            let allowed = total.variances.iter().sum::<f64>() * (target / share).powi(2) / 1.25;
            let root = (windows.sqrt() + (corrections * cost).sqrt()) / (allowed + (windows + corrections) / all);
            if root.is_finite() {
                wanted = [wanted[0].max(windows.sqrt() * root), wanted[1].max((corrections / cost).sqrt() * root)];
            }
        }
        let [draws, more] = wanted.map(|draws| (draws.ceil() as usize).min(self.stratum));
        let more = more.saturating_sub(corrected);
        let draws = self.draws.end..draws.max(self.draws.end + more.max(1));
        Self { corrected: draws.end - more..draws.end, draws, ..self.clone() }
    }

    /// Which draw each window of a stratum is, of the first `most`.
    pub fn drawn(&self, stratum: usize, most: usize) -> Vec<Option<usize>> {
        let mut order: Vec<usize> = (0..self.stratum).collect();
        let mut drawn = vec![None; self.stratum];
        for draw in 0..most.min(self.stratum) {
            let hash = mix(self.seed ^ mix(((stratum as u64) << 20) + draw as u64));
            order.swap(draw, draw + (hash % (self.stratum - draw) as u64) as usize);
            drawn[order[draw]] = Some(draw);
        }
        drawn
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
    fn each_window_is_drawn_once_and_the_first_draws_do_not_hang_on_how_many_follow() {
        for stratum in [2, 7, 40] {
            let cut = Cut { pixels: 1, before: 1, own: 1, behind: 1 };
            let plan = Plan { stratum, draws: 0..2, corrected: 0..0, cut, seed: 3 };
            let all = plan.drawn(5, 64);
            let mut draws: Vec<usize> = all.iter().flatten().copied().collect();
            draws.sort();
            assert_eq!(draws, (0..stratum).collect::<Vec<_>>());
            for most in 0..stratum {
                let first: Vec<_> = all.iter().map(|draw| draw.filter(|&draw| draw < most)).collect();
                assert_eq!(plan.drawn(5, most), first);
            }
        }
    }
}
