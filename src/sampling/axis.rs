//! Where windows lie on the axis of the sample: large ones are measured more often, with less weight (Hansen and
//! Hurwitz 1943), since what is not known of a window without replaying it is more of what is known.

use super::known::{Columns, MOVED, OPERATIONS};
use super::strata::{Point, Strata};

/// What all windows have, so that those without work are measured too; operations and lines of the L2 are 1 each, on
/// average. It is small: what windows without work cost differs little.
const LEAST: f64 = 0.1;

/// Windows up to now.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    strata: Strata,
    /// Points with draws below it are of interest.
    most: usize,
    /// Those that lie further on, of strata that have begun, and how many have.
    points: Vec<Point>,
    begun: usize,
    /// Sums, and of how many windows.
    operations: f64,
    lines: f64,
    windows: usize,
    end: f64,
}

impl Axis {
    /// No window yet; points with draws below `most` are of interest.
    pub(crate) fn new(strata: Strata, most: usize) -> Self {
        Self { strata, most, points: Vec::new(), begun: 0, operations: 0.0, lines: 0.0, windows: 0, end: 0.0 }
    }

    /// How long the next window is, and the points that lie in it. Its length is known before any point of it is looked
    /// at, so that each point of the axis is as likely as any other.
    pub(crate) fn next(&mut self, known: &Columns) -> (f64, Vec<Point>) {
        let (operations, lines) = (known[OPERATIONS], known[MOVED]);
        self.windows += 1;
        self.operations += operations;
        self.lines += lines;
        let of_mean = |value: f64, sum: f64| if sum > 0.0 { value * self.windows as f64 / sum } else { 1.0 };
        let parts = LEAST + of_mean(operations, self.operations) + of_mean(lines, self.lines);
        let size = parts / (LEAST + 2.0);
        self.end += size;
        let end = self.end;
        while self.begun as f64 * self.strata.length < end {
            self.points.extend(self.strata.points(self.begun, self.most));
            self.begun += 1;
        }
        (size, self.points.extract_if(.., |point| point.place < end).collect())
    }

    /// Where it ends.
    pub(crate) fn end(&self) -> f64 {
        self.end
    }

    /// Windows up to now.
    pub(crate) fn windows(&self) -> usize {
        self.windows
    }
}

#[cfg(test)]
mod tests {
    use super::super::known::COLUMNS;
    use super::*;

    fn known(operations: u32, lines: u32) -> Columns {
        let mut known = [0.0; COLUMNS];
        (known[OPERATIONS], known[MOVED]) = (operations.into(), lines.into());
        known
    }

    #[test]
    fn every_point_lies_in_one_window_and_large_windows_have_more() {
        let mut axis = Axis::new(Strata { length: 10.0, seed: 7 }, 3);
        let (mut points, mut large) = (Vec::new(), 0);
        for window in 0..20_000 {
            let is_large = window % 4 == 0;
            let (_, found) = axis.next(&if is_large { known(500, 90) } else { known(100, 10) });
            large += if is_large { found.len() } else { 0 };
            points.extend(found.into_iter().map(|point| point.place));
        }
        let all = points.len();
        points.sort_by(f64::total_cmp);
        points.dedup();
        assert_eq!(points.len(), all);
        // Windows are of length 1 on average, of ten of which three are points.
        assert!((axis.end() / 20_000.0 - 1.0).abs() < 1e-3);
        assert!((all as f64 / 6_000.0 - 1.0).abs() < 0.02, "{all}");
        // Of 4 windows one has 500 of 800 operations and 90 of 120 lines.
        let share = (0.1 / 4.0 + 500.0 / 800.0 + 90.0 / 120.0) / 2.1;
        assert!((large as f64 / all as f64 - share).abs() < 0.02, "{large} of {all}");
    }

    #[test]
    fn windows_of_nothing_are_windows() {
        let mut axis = Axis::new(Strata { length: 2.0, seed: 0 }, 2);
        let hits: usize = (0..100).map(|_| axis.next(&known(0, 0)).1.len()).sum();
        assert_eq!((hits, axis.windows(), axis.end()), (100, 100, 100.0));
    }
}
