//! The sample's axis, on which windows lie one after another, each of length 1. It does not depend on what rays do: one
//! seed draws the same windows for every policy's stream, on every machine with the same cut.

use super::strata::{Point, Strata};

/// The windows so far.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    strata: Strata,
    /// Points with draws below `most` are wanted.
    most: usize,
    /// Points beyond the current window, of strata that have begun, and the number of such strata.
    points: Vec<Point>,
    begun: usize,
    windows: usize,
}

impl Axis {
    /// An axis without windows; points with draws below `most` are wanted.
    pub(crate) fn new(strata: Strata, most: usize) -> Self {
        Self { strata, most, points: Vec::new(), begun: 0, windows: 0 }
    }

    /// The points that lie in the next window.
    pub(crate) fn next(&mut self) -> Vec<Point> {
        self.windows += 1;
        let end = self.windows as f64;
        while self.begun as f64 * self.strata.length < end {
            self.points.extend(self.strata.points(self.begun, self.most));
            self.begun += 1;
        }
        self.points.extract_if(.., |point| point.place < end).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_lies_in_the_window_of_its_place() {
        let mut axis = Axis::new(Strata { length: 10.0, seed: 7 }, 3);
        let mut points = Vec::new();
        for window in 0..20_000 {
            let found = axis.next();
            assert!(found.iter().all(|point| point.place as usize == window));
            points.extend(found.into_iter().map(|point| point.place));
        }
        let all = points.len();
        points.sort_by(f64::total_cmp);
        points.dedup();
        assert_eq!(points.len(), all);
        // The rate is 3 points in 10 windows.
        assert!((all as f64 / 6_000.0 - 1.0).abs() < 0.02, "{all}");
    }
}
