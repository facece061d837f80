//! An axis of shares that includes 0; both ends are round shares.

use super::canvas::tick_step;

/// The least span of an axis, and the number of ticks that its step allows.
const LEAST: f64 = 0.01;
const MOST: u32 = 4;

/// The axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ticks {
    low: f64,
    high: f64,
    step: f64,
}

impl Ticks {
    /// An axis for these shares; no share lies beyond the first or the last tick.
    pub(crate) fn around(shares: impl Iterator<Item = f64>) -> Self {
        let (low, high) = shares.fold((0.0, 0.0), |(low, high): (f64, f64), it| (low.min(it), high.max(it)));
        let step = tick_step((high - low).max(LEAST), MOST);
        let low = (low / step).floor() * step;
        Self { low, high: ((high / step).ceil() * step).max(low + step), step }
    }

    /// The ticks' shares.
    pub(crate) fn shares(self) -> impl Iterator<Item = f64> {
        let ticks = ((self.high - self.low) / self.step).round() as i32;
        (0..=ticks).map(move |tick| self.low + f64::from(tick) * self.step)
    }

    /// The position of a share on the axis: 0 is the first tick, 1 the last.
    pub(crate) fn place(self, share: f64) -> f64 {
        (share - self.low) / (self.high - self.low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An axis of small changes in one direction includes 0, and no tick lies outside the axis.
    #[test]
    fn all_ticks_and_shares_lie_on_the_axis() {
        for (all, ticks) in
            [(vec![-0.0016, -0.0005], 2), (vec![], 2), (vec![0.0], 2), (vec![0.007], 3), (vec![-0.03, 0.41], 5)]
        {
            let axis = Ticks::around(all.iter().copied());
            assert_eq!(axis.shares().count(), ticks, "{all:?} {axis:?}");
            for share in axis.shares().chain(all.iter().copied()).chain([0.0]) {
                assert!((-1e-9..=1.0 + 1e-9).contains(&axis.place(share)), "{share} of {all:?}: {axis:?}");
            }
            let (first, last) = (axis.shares().next().unwrap(), axis.shares().last().unwrap());
            assert!(axis.place(first).abs() < 1e-9 && (axis.place(last) - 1.0).abs() < 1e-9, "{axis:?}");
        }
    }
}
