//! Reuse distances, counted in bins, and the misses of caches that are read from them.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Binomial, DiscreteCDF};

/// Distances below this have a bin each; above, an octave has so many.
const FINE: u64 = 32;
const AN_OCTAVE: u32 = 8;

/// Accesses by the number of other lines touched since the same line was touched.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Distances {
    /// First touches.
    first: u64,
    bins: Vec<u64>,
}

impl Distances {
    /// Counts an access; one without a distance is a first touch.
    pub(super) fn count(&mut self, distance: Option<u64>) {
        let Some(distance) = distance else {
            self.first += 1;
            return;
        };
        let bin = bin(distance);
        if bin >= self.bins.len() {
            self.bins.resize(bin + 1, 0);
        }
        self.bins[bin] += 1;
    }

    /// Expected misses of an LRU cache with so many sets and ways, if lines fall into sets at random (Smith 1978).
    pub(super) fn misses(&self, sets: u64, ways: u64) -> f64 {
        let missed = self.bins.iter().enumerate().filter(|(_, count)| **count > 0);
        self.first as f64 + missed.map(|(bin, &count)| count as f64 * lost(middle(bin), sets, ways)).sum::<f64>()
    }
}

/// The bin of a distance.
fn bin(distance: u64) -> usize {
    if distance < FINE {
        return distance as usize;
    }
    let octave = distance.ilog2();
    let within = ((distance - (1 << octave)) * u64::from(AN_OCTAVE)) >> octave;
    FINE as usize + ((octave - FINE.ilog2()) * AN_OCTAVE) as usize + within as usize
}

/// A distance in the middle of a bin.
fn middle(bin: usize) -> u64 {
    let Some(above) = bin.checked_sub(FINE as usize) else { return bin as u64 };
    let (octave, within) = (above as u32 / AN_OCTAVE + FINE.ilog2(), above as u32 % AN_OCTAVE);
    let width = 1u64 << octave;
    width + (width * u64::from(within) + width / 2) / u64::from(AN_OCTAVE)
}

/// The probability that at least `ways` of so many other lines fell into a line's own of `sets` sets.
fn lost(distance: u64, sets: u64, ways: u64) -> f64 {
    if distance < ways {
        return 0.0;
    }
    if sets <= 1 {
        return 1.0;
    }
    // The law's parameters are a probability and a number, so there is one.
    Binomial::new(1.0 / sets as f64, distance).map_or(1.0, |fell| fell.sf(ways - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bin_holds_its_middle() {
        for distance in (0..5000).chain([1 << 20, (1 << 31) + 12345]) {
            let middle = middle(bin(distance));
            assert_eq!(bin(middle), bin(distance), "{distance}");
            assert!(middle.abs_diff(distance) * 8 <= distance.max(FINE), "{distance} {middle}");
        }
    }

    #[test]
    fn misses_are_those_of_the_distances() {
        let mut distances = Distances::default();
        distances.count(None);
        [0, 3, 4, 100].into_iter().for_each(|distance| distances.count(Some(distance)));
        assert_eq!([1, 4, 5, 128].map(|ways| distances.misses(1, ways)), [4.0, 3.0, 2.0, 1.0]);
        // Of 3, 4 and 100 other lines, one falls into the line's own of two sets.
        let [three, four] = [1.0 - 0.125, 1.0 - 0.0625];
        assert!((distances.misses(2, 1) - (1.0 + three + four + 1.0)).abs() < 1e-9);
    }
}
