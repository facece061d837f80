//! Which windows of a stream are replayed.

use std::ops::Range;

use serde::Serialize;

use super::strata::Strata;
use crate::machine::MachineSpec;
use crate::stream::Header;

/// Pixels of the lead-in for each ray that the machine has room for.
const BEFORE_A_RAY: usize = 2;
/// Minimum number of pieces in a lead-in, and in a window.
const PIECES_BEFORE: usize = 5;
const PIECES: usize = 4;
/// Minimum pixels of the lead-in and of the window itself.
const LEAST_BEFORE: usize = 768;
const LEAST_OWN: usize = 512;

/// Minimum points for an interval: eight leave three degrees of freedom or more.
pub(crate) const MIN_POINTS: usize = 8;
/// Points from which on an interval's width predicts the number of points needed. With fewer, regressions have few
/// columns, and intervals shrink much faster than with the root of the number of points. (Kitchen, `Published`,
/// `small`, 512 windows: for 2 %, the width from 24 windows predicted more windows than there are; 48 gave 1.9 %.)
///
/// A sample with a target does not stop before. Where most intervals are too wide, stopping at a narrow one selects
/// those that are narrow by chance: of 59 such samples of the recorded quick start (targets of 2 to 15 %), the
/// intervals of 43 held the truth.
pub(crate) const MIN_POINTS_TO_STOP: usize = 48;

/// How a stream is cut: the number of pieces in a window, in its lead-in and in its tail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Cut {
    /// Approximate pixels of a piece.
    pub pixels: usize,
    /// Pieces of the lead-in, before the window: they fill the pool and the FIFOs.
    pub before: usize,
    /// Pieces of the window itself.
    pub own: usize,
    /// Pieces of the tail, behind the window: they keep the machine full.
    pub behind: usize,
}

/// The lengths that a machine needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lengths {
    /// Pixels of a piece.
    piece: usize,
    /// Rays that pool and FIFOs have room for.
    room: usize,
}

impl Lengths {
    /// The lengths for `machine`. A piece has as many pixels as the pool has entries: so many primary rays can be in
    /// flight, and their children follow them.
    pub(crate) fn new(machine: &MachineSpec) -> Self {
        let piece = machine.pool() as usize;
        let fifos = machine.dispatcher.in_fifo.size() + machine.dispatcher.out_fifo.size();
        Self { piece, room: piece + machine.cores.size() * fifos }
    }

    /// The larger of both lengths.
    fn longer(self, other: Self) -> Self {
        Self { piece: self.piece.max(other.piece), room: self.room.max(other.room) }
    }

    /// The cut with these lengths. An engine started on warm tags needs a lead-in to reach steady state. Errors of all
    /// windows together, each replayed by itself as in `windows_by_themselves_add_up` (kitchen at 512x512, robot,
    /// staircase, living room at 256x256; `Published`):
    ///
    /// | machine | pieces of lead-in, window | cycles | L2 bytes | DRAM bytes |
    /// |---|---|---|---|---|
    /// | `small` | 8, 4 | 0.0 to 0.3 % | 0.0 to 0.7 % | 0.0 to 0.2 % |
    /// | `small` | 6, 4 | 0.0 to 0.3 % | 0.0 to 0.5 % | 0.0 to 0.2 % |
    /// | `small` | 4, 4 | 0.1 to 0.6 % | 0.1 to 0.5 % | 0.0 to 0.7 % |
    /// | `desktop` | 2, 8 | 0.0 to 0.1 % | 0.1 to 0.3 % | 0.0 to 0.1 % |
    /// | `desktop` | 2, 4 | 0.1 to 0.7 % | 0.2 to 0.5 % | 0.0 to 0.2 % |
    /// | `desktop` | 2, 2 | 0.0 to 0.4 % | 0.3 to 1.1 % | 0.1 to 0.9 % |
    ///
    /// A lead-in also replaces what the L1s held. The larger the picture, the more lines neighbouring pixels share, and
    /// the longer this takes. L2 bytes of the gas station at 1024x1024 on `desktop`, from the same 161 windows behind
    /// lead-ins of different lengths (frames 20 to 27, `Published`, 25 million rays; intervals of 0.7 to 0.9 %):
    ///
    /// | pieces of lead-in | 2 | 3 | 4 | 6 | 8 | 16 |
    /// |---|---|---|---|---|---|---|
    /// | error | -3.5 % | -2.5 % | -1.3 % | -0.6 % | -0.5 % | -0.4 % |
    ///
    /// L1s of 64 KiB do not need longer windows: L2 bytes are off by up to 0.8 %, most where hardly any are moved. Long
    /// FIFOs take longer to fill: on `tni_engine`, a lead-in of two pieces of 1920 pixels before windows of four gave
    /// 0.2 to 1.2 % fewer cycles and 0.9 to 1.3 % fewer DRAM bytes (kitchen, living room). Four pieces gave 0.1 % more
    /// and 0.4 % fewer. So the lead-in grows with the room for rays.
    fn cut(self) -> Cut {
        let Self { piece, room } = self;
        let [least_before, least_own] = [LEAST_BEFORE, LEAST_OWN].map(|pixels| pixels.div_ceil(piece));
        let before = ((BEFORE_A_RAY * room + piece / 2) / piece).max(PIECES_BEFORE);
        Cut { pixels: piece, before: before.max(least_before), own: PIECES.max(least_own), behind: 1 }
    }
}

impl Cut {
    /// The cut for `machine`.
    pub(crate) fn new(machine: &MachineSpec) -> Self {
        Lengths::new(machine).cut()
    }

    /// One cut for several machines, as long as the most demanding one needs: their samples can then be compared window
    /// by window. `None` without machines.
    pub(crate) fn common(machines: impl IntoIterator<Item = Lengths>) -> Option<Self> {
        machines.into_iter().reduce(Lengths::longer).map(Lengths::cut)
    }

    /// Approximate number of windows in the measured frames of a stream.
    pub(crate) fn windows(&self, header: &Header) -> f64 {
        let frames = header.frames.len().saturating_sub(header.warmup.len());
        frames as f64 * (header.resolution.pixels() as f64 / self.window() as f64).max(1.0)
    }

    /// Pixels replayed for each pixel of a window.
    pub(crate) fn effort(&self) -> f64 {
        (self.before + self.own + self.behind) as f64 / self.own as f64
    }

    /// Pixels of a window.
    pub(crate) fn window(&self) -> usize {
        self.own * self.pixels
    }
}

/// How much is replayed. Windows lie one after another on an axis ([`super::axis`]), which is cut into strata of equal
/// length. Each stratum has two points ([`super::strata`]); windows with a point are measured. A larger sample halves
/// strata. Points have an order, so a later pass can measure the next ones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plan {
    /// The strata of the axis; windows have length 1.
    pub strata: Strata,
    /// Which points of each initial stratum are measured: 0..2 are its own two, 2..4 are those that its halves add.
    pub draws: Range<usize>,
    /// The cut into windows.
    pub cut: Cut,
}

impl Plan {
    /// A plan that measures about `rate` of a stream's windows, two in each stratum.
    pub(crate) fn new(rate: f64, cut: Cut, seed: u64) -> Self {
        Self { strata: Strata { length: 2.0 / rate, seed }, draws: 0..2, cut }
    }

    /// The next `draws.end` for intervals of `target`, given that `points` so far have the relative half width `share`;
    /// `None` where more than `most` would be needed.
    ///
    /// Intervals shrink with the root of the number of points. A quarter is added, since the width itself is an
    /// estimate. For the same reason the number at most doubles: a first width may be far too large. With fewer points
    /// than [`MIN_POINTS_TO_STOP`], the goal is [`MIN_POINTS_TO_STOP`]. Widths of few points shrink faster: to half
    /// with twice as many, where the root says 0.7 (staircase, `Published`, `small`: 4.5 % of L2 bytes with 48 windows,
    /// 2.2 % with 94). So with fewer than twice [`MIN_POINTS_TO_STOP`] points, a need of twice `most` is accepted.
    pub(crate) fn next_draws(&self, points: usize, share: f64, target: f64, most: usize) -> Option<usize> {
        let (now, twice) = (self.draws.end, 2 * self.draws.end);
        let needed = |share: f64| (1.25 * now as f64 * (share / target).powi(2)).ceil() as usize;
        let enough = if points < MIN_POINTS_TO_STOP {
            (now * MIN_POINTS_TO_STOP).div_ceil(points.max(1))
        } else {
            needed(share).max(now + 1)
        };
        let believed = if points < 2 * MIN_POINTS_TO_STOP { 2 * most } else { most };
        (enough <= believed && enough.min(twice) <= most).then_some(enough.min(twice))
    }
}
