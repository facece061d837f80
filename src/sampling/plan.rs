//! Which windows of a stream are replayed.

use std::ops::Range;

use serde::Serialize;

use super::strata::Strata;
use crate::machine::MachineSpec;
use crate::stream::Header;

/// Pixels before a window for a ray that the machine has room for.
const BEFORE_A_RAY: usize = 2;
/// Pieces of a window.
const PIECES: usize = 4;
/// Pixels before a window, and of it, at least.
const LEAST_BEFORE: usize = 768;
const LEAST_OWN: usize = 512;

/// Points that tell an interval, at least: eight leave three degrees of freedom or more.
pub(crate) const LEAST: usize = 8;
/// Points from which on an interval's width tells how many are needed: with fewer, regressions have few columns, and
/// intervals shrink much faster than with the root of the number of points. (Kitchen, `Published`, `small`, 512
/// windows: 24 windows would have asked for more than there are for 2 %; 48 gave 1.9 %.)
///
/// With fewer a sample that goes on to a target is not over. Whoever stops since the interval is narrow enough, where
/// most are not, has a narrow one by chance: of 59 such samples of the recorded quick start (targets of 2 to 15 %), the
/// intervals of 43 held the truth.
pub(crate) const TELLING: usize = 48;

/// How a stream is cut: windows are of so many pieces, which are replayed between so many others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Cut {
    /// Pixels of a piece, about.
    pub pixels: usize,
    /// Pieces before the window: they fill what is in flight.
    pub before: usize,
    /// The window's own.
    pub own: usize,
    /// Pieces behind it: they keep what is in flight full.
    pub behind: usize,
}

/// How long a machine wants pieces and windows to be, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lengths {
    /// Of a piece.
    piece: usize,
    /// Rays that there is room for, in the pool and in FIFOs.
    room: usize,
}

impl Lengths {
    /// Those of `machine`. As many primary rays as the pool has entries can be in flight, and their children come after
    /// them: a piece has as many pixels.
    pub(crate) fn new(machine: &MachineSpec) -> Self {
        let piece = machine.pool() as usize;
        let fifos = machine.dispatcher.in_fifo.size() + machine.dispatcher.out_fifo.size();
        Self { piece, room: piece + machine.cores.size() * fifos }
    }

    /// Those that are enough for both.
    fn longer(self, other: Self) -> Self {
        Self { piece: self.piece.max(other.piece), room: self.room.max(other.room) }
    }

    /// The cut with these lengths. It takes a while until an empty machine behind warm tags works as one in the middle
    /// of a frame. All windows together, each replayed by itself as `windows_by_themselves_add_up` does, are off by as
    /// much (kitchen at 512x512, robot, staircase, living room at 256x256; `Published`):
    ///
    /// | machine | pieces before, of the window | cycles | L2 bytes | DRAM bytes |
    /// |---|---|---|---|---|
    /// | `small` | 8, 4 | 0.0 to 0.3 % | 0.0 to 0.7 % | 0.0 to 0.2 % |
    /// | `small` | 6, 4 | 0.0 to 0.3 % | 0.0 to 0.5 % | 0.0 to 0.2 % |
    /// | `small` | 4, 4 | 0.1 to 0.6 % | 0.1 to 0.5 % | 0.0 to 0.7 % |
    /// | `desktop` | 2, 8 | 0.0 to 0.1 % | 0.1 to 0.3 % | 0.0 to 0.1 % |
    /// | `desktop` | 2, 4 | 0.1 to 0.7 % | 0.2 to 0.5 % | 0.0 to 0.2 % |
    /// | `desktop` | 2, 2 | 0.0 to 0.4 % | 0.3 to 1.1 % | 0.1 to 0.9 % |
    ///
    /// Of L1s of 64 KiB windows need not be longer: L2 bytes are off by up to 0.8 %, most of all where hardly any are
    /// moved. Long FIFOs take longer to fill: on `tni_engine`, two pieces of 1920 before windows of four made for 0.2
    /// to 1.2 % fewer cycles and 0.9 to 1.3 % fewer bytes of the DRAM (kitchen, living room), four for 0.1 % more and
    /// 0.4 % fewer. So what comes before is the longer the more rays there is room for.
    fn cut(self) -> Cut {
        let Self { piece, room } = self;
        let [least_before, least_own] = [LEAST_BEFORE, LEAST_OWN].map(|pixels| pixels.div_ceil(piece));
        let before = (BEFORE_A_RAY * room + piece / 2) / piece;
        Cut { pixels: piece, before: before.max(least_before), own: PIECES.max(least_own), behind: 1 }
    }
}

impl Cut {
    /// The cut for `machine`.
    pub(crate) fn new(machine: &MachineSpec) -> Self {
        Lengths::new(machine).cut()
    }

    /// One cut for several machines, as long as the longest asks for: what they measure can be compared window by
    /// window.
    pub(crate) fn common(machines: impl IntoIterator<Item = Lengths>) -> Option<Self> {
        machines.into_iter().reduce(Lengths::longer).map(Lengths::cut)
    }

    /// Windows of the measured frames of a stream, about.
    pub(crate) fn windows(&self, header: &Header) -> f64 {
        let frames = header.frames.len().saturating_sub(header.warmup.len());
        frames as f64 * (header.resolution.pixels() as f64 / self.window() as f64).max(1.0)
    }

    /// Pixels that are replayed for one of a window.
    pub(crate) fn effort(&self) -> f64 {
        (self.before + self.own + self.behind) as f64 / self.own as f64
    }

    /// Pixels of a window.
    pub(crate) fn window(&self) -> usize {
        self.own * self.pixels
    }
}

/// How much is replayed. Windows lie one after another on an axis ([`super::axis`]), which is cut into strata of equal
/// length. Each stratum has two points ([`super::strata`]), and windows with a point are measured. When more are
/// wanted, strata are halved: points have an order, so that a later pass can measure the next ones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plan {
    /// The strata of the axis, on which windows are of length 1.
    pub strata: Strata,
    /// Which of the points of what was a stratum at first are measured: of 0 to 2, both; of 2 to 4, those that its
    /// halves get.
    pub draws: Range<usize>,
    /// What a window is, and what is replayed beside it.
    pub cut: Cut,
}

impl Plan {
    /// The plan that measures about `rate` of the windows of a stream, two a stratum.
    pub(crate) fn new(rate: f64, cut: Cut, seed: u64) -> Self {
        Self { strata: Strata { length: 2.0 / rate, seed }, draws: 0..2, cut }
    }

    /// How many points of what was a stratum at first are to be measured next for intervals of `target`, when `points`
    /// so far gave `share`; `None` where that would take more than `most`. Intervals shrink with the root of the number
    /// of points, and a quarter more is taken, since the width of an interval is itself known from a sample only. For
    /// the same reason no more than twice as many are: a first width may be far too large. With fewer points than
    /// [`TELLING`], as many are as lack. Widths of the first points
    /// shrink faster, to half with twice as many where the root says 0.7 (staircase, `Published`, `small`: 4.5 % of L2
    /// bytes with 48 windows, 2.2 % with 94). Twice as many as `most` may seem to be needed then.
    pub(crate) fn next_draws(&self, points: usize, share: f64, target: f64, most: usize) -> Option<usize> {
        let (now, twice) = (self.draws.end, 2 * self.draws.end);
        let needed = |share: f64| (1.25 * now as f64 * (share / target).powi(2)).ceil() as usize;
        let enough =
            if points < TELLING { (now * TELLING).div_ceil(points.max(1)) } else { needed(share).max(now + 1) };
        let believed = if points < 2 * TELLING { 2 * most } else { most };
        (enough <= believed && enough.min(twice) <= most).then_some(enough.min(twice))
    }
}
