//! The points of a sample on its axis: two in each stratum. A larger sample halves strata; halves keep their points.
//! Residuals of neighbouring windows are correlated (kitchen, `Hybrid()`, `tni_engine`: 0.7, four windows apart 0.2).
//! So two points in each of many short strata give smaller errors than many points in each of a few long ones.

use crate::random::{mix, unit};

/// Strata of equal length on an axis, and the rule for halving them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Strata {
    /// Length of a stratum before halving.
    pub length: f64,
    /// Seed of the hash, with a stratum's level and number, for points and the order of halving.
    pub seed: u64,
}

/// A point of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// Position on the axis.
    pub place: f64,
    /// The point is measured if the number of points for each initial stratum is larger than `draw`.
    pub draw: usize,
}

/// A stratum or a part of one: how often it was halved, and its number among all parts of that level.
#[derive(Clone, Copy, Debug)]
struct Part {
    level: u32,
    number: usize,
}

/// Hash input for the order of halving; 0 and 1 are for a part's own two points.
const HALVING: u64 = 2;

impl Strata {
    /// Points of stratum `number` with draws below `most`.
    pub(crate) fn points(&self, number: usize, most: usize) -> Vec<Point> {
        let part = Part { level: 0, number };
        let own = [0, 1].map(|draw| Point { place: self.own(part, draw), draw: draw as usize });
        let mut points = Vec::from(own);
        self.halve(part, own.map(|point| point.place), most, &mut points);
        points.retain(|point| point.draw < most);
        points
    }

    /// Ends of the strata, each with two points with draws below `draws`, on an axis of length `axis`.
    pub(crate) fn ends(&self, draws: usize, axis: f64) -> Vec<f64> {
        let mut ends = Vec::new();
        for number in (0..).take_while(|&number| number as f64 * self.length < axis) {
            self.end(Part { level: 0, number }, draws, &mut ends);
        }
        // The last stratum may extend beyond the axis.
        let whole = ends.partition_point(|&end| end < axis);
        ends.truncate(whole);
        ends.extend((axis > 0.0).then_some(axis));
        ends
    }

    fn end(&self, part: Part, draws: usize, ends: &mut Vec<f64>) {
        if self.halved(part) <= draws {
            part.halves().into_iter().for_each(|half| self.end(half, draws, ends));
        } else {
            ends.push(self.begin(Part { number: part.number + 1, ..part }));
        }
    }

    /// Adds the points of the halves of `part`: each half keeps those of `points` in it, and adds its own to make two.
    fn halve(&self, part: Part, points: [f64; 2], most: usize, all: &mut Vec<Point>) {
        let draws = self.halved(part);
        if draws > most {
            return;
        }
        let middle = self.begin(part.halves()[1]);
        for (half, is_second) in part.halves().into_iter().zip([false, true]) {
            let kept = points.into_iter().filter(|&place| (place >= middle) == is_second);
            let mut two = kept.chain([0, 1].map(|own| self.own(half, own)));
            let two = [two.next(), two.next()].map(|place| place.expect("it has two of its own"));
            let new = two.into_iter().filter(|place| !points.contains(place));
            all.extend(new.map(|place| Point { place, draw: draws - 1 }));
            self.halve(half, two, most, all);
        }
    }

    /// `part` is halved once the points for each initial stratum reach this number. It is drawn between one and two
    /// times the number of points that all parts of this level have.
    fn halved(&self, part: Part) -> usize {
        let all = (2u64 << part.level) as f64;
        (all * (1.0 + self.drawn(part, HALVING))) as usize + 1
    }

    /// One of a part's own two points.
    fn own(&self, part: Part, which: u64) -> f64 {
        self.begin(part) + self.drawn(part, which) * self.length / (1u64 << part.level) as f64
    }

    fn begin(&self, Part { level, number }: Part) -> f64 {
        number as f64 * self.length / (1u64 << level) as f64
    }

    /// A number from 0 to 1, 1 excluded.
    fn drawn(&self, Part { level, number }: Part, which: u64) -> f64 {
        unit(mix(self.seed ^ mix(((number as u64) << 8) + (u64::from(level) << 2) + which)))
    }
}

impl Part {
    fn halves(self) -> [Self; 2] {
        [0, 1].map(|half| Self { level: self.level + 1, number: 2 * self.number + half })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRATA: Strata = Strata { length: 10.0, seed: 3 };

    /// Places of all points below `draws` of `count` strata.
    fn places(draws: usize, count: usize) -> Vec<f64> {
        let points = (0..count).flat_map(|number| STRATA.points(number, draws));
        points.map(|point| point.place).collect()
    }

    #[test]
    fn each_stratum_has_two_points_however_many_there_are() {
        for draws in [2, 3, 4, 7, 8, 40] {
            let ends = STRATA.ends(draws, 1000.0);
            let mut counts = vec![0; ends.len()];
            places(draws, 100).iter().for_each(|place| counts[ends.partition_point(|end| end <= place)] += 1);
            assert!(counts.iter().all(|&count| count == 2), "{draws}: {counts:?}");
            // The expected number of strata, but for chance in the order of halving.
            assert!((counts.len() as f64 / (100 * draws / 2) as f64 - 1.0).abs() < 0.1, "{draws}: {}", counts.len());
        }
    }

    #[test]
    fn whoever_wants_more_keeps_what_was_drawn() {
        for draws in 2..40 {
            let (some, more) = (places(draws, 20), places(draws + 1, 20));
            assert!(some.iter().all(|place| more.contains(place)), "{draws}");
        }
    }

    /// Every place is equally likely, whether a point was kept or is its stratum's own.
    #[test]
    fn points_are_even() {
        for draws in [2, 3, 11] {
            let places = places(draws, 200_000);
            let mut tenths = [0.0; 10];
            places.iter().for_each(|place| tenths[(place % 10.0) as usize] += 10.0 / places.len() as f64);
            assert!(tenths.iter().all(|tenth| (tenth - 1.0).abs() < 0.02), "{draws}: {tenths:?}");
        }
    }

    #[test]
    fn the_last_stratum_ends_with_the_axis() {
        assert_eq!(STRATA.ends(2, 25.0), [10.0, 20.0, 25.0]);
        assert_eq!(STRATA.ends(2, 20.0), [10.0, 20.0]);
        assert_eq!(STRATA.ends(4, 12.0), [5.0, 10.0, 12.0]);
        assert!(STRATA.ends(2, 0.0).is_empty());
    }
}
