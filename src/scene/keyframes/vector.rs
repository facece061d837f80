//! Splines of positions and of scales.

use glam::DVec3;

use super::stretch::{Key, Place, Stretches, TrackError};

/// A spline of positions or of scales.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VectorTrack {
    first: DVec3,
    last: DVec3,
    /// Coefficients of 1, u, u^2, u^3.
    pub(super) cubics: Stretches<[DVec3; 4]>,
}

impl VectorTrack {
    /// The spline through `keys`, at least 4.
    pub(crate) fn new(keys: &[Key<DVec3>]) -> Result<Self, TrackError> {
        let cubics = Stretches::new(keys, |index, weights| {
            let [p0, p1, p2, p3] = [0, 1, 2, 3].map(|offset| keys[index + offset].value);
            let along = p2 - p1;
            let out = weights.out_before * (p1 - p0) + weights.out_along * along;
            let into = weights.in_along * along + weights.in_after * (p3 - p2);
            let cubic = [p1, out, 3.0 * along - 2.0 * out - into, -2.0 * along + out + into];
            cubic.iter().all(|c| c.is_finite()).then_some(cubic)
        })?;
        let [first, last] = [keys[1].value, keys[keys.len() - 2].value];
        if first.is_finite() && last.is_finite() {
            Ok(Self { first, last, cubics })
        } else {
            Err(TrackError::NotFinite(1))
        }
    }

    /// The value at `time` seconds.
    pub(crate) fn at(&self, time: f64) -> DVec3 {
        match self.cubics.at(time) {
            Place::Before => self.first,
            Place::After => self.last,
            Place::On([a, b, c, d], u) => *a + u * (*b + u * (*c + u * *d)),
        }
    }

    /// Upper bounds, not tight, of the absolute values of the components over all times.
    pub(crate) fn bound(&self) -> DVec3 {
        let ends = self.first.abs().max(self.last.abs());
        let sums = self.cubics.list.iter().map(|stretch| stretch.curve.iter().map(|c| c.abs()).sum());
        sums.fold(ends, DVec3::max)
    }
}
