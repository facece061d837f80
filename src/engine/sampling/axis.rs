//! Where windows lie on the axis of the sample: large ones are measured more often, with less weight (Hansen and Hurwitz 1943), since what is not known of
//! a window without replaying it is more of what is known.

use super::known::{Columns, MOVED, OPERATIONS};
use super::plan::Plan;

/// What all windows have, so that those without work are measured too; operations and lines of the L2 are 1 each, on average. It is small: what
/// windows without work cost differs little.
const LEAST: f64 = 0.1;

/// A point of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hit {
    /// Its stratum.
    pub stratum: usize,
    /// Which of the stratum's points it is.
    pub draw: usize,
}

/// Windows up to now.
#[derive(Clone, Debug)]
pub struct Axis {
    plan: Plan,
    /// Points of a stratum that are of interest.
    most: usize,
    /// Sums, and of how many windows.
    operations: f64,
    lines: f64,
    windows: usize,
    end: f64,
}

impl Axis {
    /// No window yet; of each stratum the first `most` points are of interest.
    pub fn new(plan: Plan, most: usize) -> Self {
        Self { plan, most, operations: 0.0, lines: 0.0, windows: 0, end: 0.0 }
    }

    /// How long the next window is, and the points that lie in it. Its length is known before any point of it is looked at, so that each point of the
    /// axis is as likely as any other.
    pub fn next(&mut self, known: &Columns) -> (f64, Vec<Hit>) {
        let (operations, lines) = (known[OPERATIONS], known[MOVED]);
        self.windows += 1;
        self.operations += operations;
        self.lines += lines;
        let of_mean = |value: f64, sum: f64| if sum > 0.0 { value * self.windows as f64 / sum } else { 1.0 };
        let parts = LEAST + of_mean(operations, self.operations) + of_mean(lines, self.lines);
        let size = parts / (LEAST + 2.0);
        let (begin, end) = (self.end, self.end + size);
        self.end = end;
        let length = self.plan.stratum;
        let strata = (begin / length) as usize..=(end / length) as usize;
        let points = strata.flat_map(|stratum| (0..self.most).map(move |draw| Hit { stratum, draw }));
        let place = |hit: &Hit| (hit.stratum as f64 + self.plan.point(hit.stratum, hit.draw)) * length;
        (size, points.filter(|hit| (begin..end).contains(&place(hit))).collect())
    }

    /// Lengths of all strata.
    pub fn strata(&self) -> Vec<f64> {
        let length = self.plan.stratum;
        let whole = (self.end / length) as usize;
        let rest = self.end - whole as f64 * length;
        std::iter::repeat_n(length, whole).chain((rest > 0.0).then_some(rest)).collect()
    }

    /// Windows up to now.
    pub fn windows(&self) -> usize {
        self.windows
    }
}

#[cfg(test)]
mod tests {
    use super::super::known::COLUMNS;
    use super::super::plan::Cut;
    use super::*;

    fn known(operations: u32, lines: u32) -> Columns {
        let mut known = [0.0; COLUMNS];
        (known[OPERATIONS], known[MOVED]) = (operations.into(), lines.into());
        known
    }

    #[test]
    fn every_point_lies_in_one_window_and_large_windows_have_more() {
        let cut = Cut { pixels: 1, before: 1, own: 1, behind: 1 };
        let mut axis = Axis::new(Plan { stratum: 10.0, draws: 0..2, cut, seed: 7 }, 3);
        let (mut hits, mut large) = (Vec::new(), 0);
        for window in 0..20_000 {
            let is_large = window % 4 == 0;
            let (_, found) = axis.next(&if is_large { known(500, 90) } else { known(100, 10) });
            large += if is_large { found.len() } else { 0 };
            hits.extend(found.into_iter().map(|hit| (hit.stratum, hit.draw)));
        }
        let strata = axis.strata();
        let all = hits.len();
        hits.sort();
        hits.dedup();
        assert_eq!(hits.len(), all);
        assert!((3 * (strata.len() - 1)..=3 * strata.len()).contains(&all), "{all}, {}", strata.len());
        assert!((strata.iter().sum::<f64>() / 20_000.0 - 1.0).abs() < 1e-3);
        // Of 4 windows one has 500 of 800 operations and 90 of 120 lines.
        let share = (0.1 / 4.0 + 500.0 / 800.0 + 90.0 / 120.0) / 2.1;
        assert!((large as f64 / all as f64 - share).abs() < 0.02, "{large} of {all}");
    }

    #[test]
    fn windows_of_nothing_are_windows() {
        let cut = Cut { pixels: 1, before: 1, own: 1, behind: 1 };
        let mut axis = Axis::new(Plan { stratum: 2.0, draws: 0..2, cut, seed: 0 }, 2);
        let hits: usize = (0..100).map(|_| axis.next(&known(0, 0)).1.len()).sum();
        assert_eq!((hits, axis.windows(), axis.strata().len()), (100, 100, 50));
    }
}
