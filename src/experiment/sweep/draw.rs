//! Draws combinations of values, spread evenly by a Sobol sequence.

use rustc_hash::FxHashSet;

/// The most points of the sequence that are drawn: the limit of the crate's direction numbers.
const DRAWN: u32 = 1 << 16;
/// The most fields, each a dimension of the sequence.
pub(super) const MAX_FIELDS: usize = 200;

/// Draws combinations of value indices, each once, by the Sobol sequence of Joe and Kuo 2008 with the scrambling of
/// Burley 2020. After the sequence come the combinations that it missed, if there are at most [`DRAWN`] in all.
pub(super) struct Draw {
    /// Number of values of each field.
    sizes: Vec<usize>,
    all: u128,
    seen: FxHashSet<Vec<usize>>,
    drawn: u32,
    counted: u128,
}

impl Draw {
    /// Combinations of fields with the given numbers of values.
    pub(super) fn new(sizes: Vec<usize>) -> Self {
        let all = sizes.iter().fold(1u128, |all, &size| all.saturating_mul(size as u128));
        Self { sizes, all, seen: FxHashSet::default(), drawn: 0, counted: 0 }
    }

    /// The number of all combinations.
    pub(super) fn all(&self) -> u128 {
        self.all
    }

    /// Point `index` of the Sobol sequence, as a combination.
    fn sampled(&self, index: u32) -> Vec<usize> {
        let place = |(dimension, &size): (usize, &usize)| {
            let at = f64::from(sobol_burley::sample(index, dimension as u32, 0));
            ((at * size as f64) as usize).min(size - 1)
        };
        self.sizes.iter().enumerate().map(place).collect()
    }

    /// Combination `number` of all; the first field's value changes fastest.
    fn numbered(&self, mut number: u128) -> Vec<usize> {
        let place = |&size: &usize| {
            let place = (number % size as u128) as usize;
            number /= size as u128;
            place
        };
        self.sizes.iter().map(place).collect()
    }
}

impl Iterator for Draw {
    type Item = Vec<usize>;

    fn next(&mut self) -> Option<Vec<usize>> {
        while (self.seen.len() as u128) < self.all {
            let next = if self.drawn < DRAWN {
                self.drawn += 1;
                self.sampled(self.drawn - 1)
            } else if self.all <= u128::from(DRAWN) {
                self.counted += 1;
                self.numbered(self.counted - 1)
            } else {
                return None;
            };
            if self.seen.insert(next.clone()) {
                return Some(next);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_combinations_come_once() {
        let mut all: Vec<_> = Draw::new(vec![3, 1, 7, 5]).collect();
        assert_eq!(all.len(), 105);
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 105);
        assert_eq!(Draw::new(Vec::new()).count(), 1, "no field has one combination");
    }

    #[test]
    fn the_first_ones_are_spread_evenly() {
        let first: Vec<_> = Draw::new(vec![8, 8, 100]).take(64).collect();
        for field in 0..2 {
            for value in 0..8 {
                let times = first.iter().filter(|places| places[field] == value).count();
                assert!((6..=10).contains(&times), "value {value} of field {field} comes {times} times");
            }
        }
    }
}
