//! Where the points of a sample lie on its axis: two in each stratum. When more are wanted, strata are cut in halves,
//! which keep the points that they have: what is left over of neighbouring windows is much alike (kitchen, `Hybrid()`,
//! `tni_engine`: correlation 0.7, four windows apart 0.2), so that two points in each of many short strata tell more
//! than many points in each of a few long ones.

use crate::random::{mix, unit};

/// The axis in strata of equal length, and how they are halved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Strata {
    /// How long they are as long as none is halved.
    pub length: f64,
    /// Points and the order of halving come from a hash of this, a stratum's level and its number.
    pub seed: u64,
}

/// A point of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// Where on the axis.
    pub place: f64,
    /// It is measured if more points than so many are, for each stratum that is not halved.
    pub draw: usize,
}

/// A stratum, or one of its parts: so many times halved, and its number among all that are.
#[derive(Clone, Copy, Debug)]
struct Part {
    level: u32,
    number: usize,
}

/// What a hash is for, beside the two points that a part may have of its own.
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

    /// Where strata end, of which each has two points with draws below `draws`, on an axis of so much.
    pub(crate) fn ends(&self, draws: usize, axis: f64) -> Vec<f64> {
        let mut ends = Vec::new();
        for number in (0..).take_while(|&number| number as f64 * self.length < axis) {
            self.end(Part { level: 0, number }, draws, &mut ends);
        }
        // The last one may end beyond the axis.
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

    /// The halves keep the two points of `part`, and get as many as they lack.
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

    /// With so many points a stratum, `part` is in halves: after so many times as many as all of its level have, drawn
    /// between one and two.
    fn halved(&self, part: Part) -> usize {
        let all = (2u64 << part.level) as f64;
        (all * (1.0 + self.drawn(part, HALVING))) as usize + 1
    }

    /// One of two points of a part itself.
    fn own(&self, part: Part, which: u64) -> f64 {
        self.begin(part) + self.drawn(part, which) * self.length / (1u64 << part.level) as f64
    }

    fn begin(&self, Part { level, number }: Part) -> f64 {
        number as f64 * self.length / (1u64 << level) as f64
    }

    /// A number from 0 to 1, 1 left out.
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
            // As many as were asked for, but for the chance of which are halved.
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

    /// Whether a point was kept or is its stratum's own: each place is as likely as any other.
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
