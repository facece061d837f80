//! Keyframe tracks: Kochanek-Bartels (tension, continuity, bias) splines of positions here, of rotations in
//! [`RotationTrack`], both at once in [`Motion`].
//!
//! Source: Kochanek and Bartels, "Interpolating splines with local tension, continuity, and bias control", SIGGRAPH
//! 1984, with its correction for keys at unequal times; rotations use the same weights on the logarithms of unit
//! quaternions, between which Shoemake's `squad` (1987) runs. The first and the last key only give tangents: a track
//! runs from its second to its last but one key and stands still outside. Times need not rise: of the stretches
//! between neighbouring keys, the first that ends after the time asked for counts, so that keys at one time make a
//! jump and a key that goes back in time is passed over, as in the BART scenes.

mod motion;
mod rotation;
#[cfg(test)]
mod tests;

use glam::DVec3;

pub use self::motion::{Motion, VisibilityTrack};
pub use self::rotation::RotationTrack;

/// How the spline passes a key; all zero is a Catmull-Rom spline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tcb {
    /// 1 stops at the key.
    pub tension: f64,
    /// Other than 0 makes a corner.
    pub continuity: f64,
    /// Above 0 follows the stretch before the key, below 0 the one after it.
    pub bias: f64,
}

/// A value at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key<V> {
    /// The time in seconds.
    pub time: f64,
    /// The value.
    pub value: V,
    /// How the spline passes it.
    pub tcb: Tcb,
}

/// Why keys make no track.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrackError {
    /// The first and the last key only give tangents.
    #[error("{0} keys: at least 4 are needed")]
    TooFew(usize),
    /// A number is infinite or no number, or two keys around a third are at one time.
    #[error("key {0} gives no finite tangents: finite numbers, and other times before and after a key are allowed")]
    NotFinite(usize),
}

/// The stretches between keys that can be reached, in order of their end.
#[derive(Clone, Debug, PartialEq)]
struct Stretches<C> {
    start: f64,
    end: f64,
    list: Vec<Stretch<C>>,
}

#[derive(Clone, Debug, PartialEq)]
struct Stretch<C> {
    start: f64,
    end: f64,
    curve: C,
}

enum Place<'a, C> {
    Before,
    After,
    /// On a curve, with its parameter of 0..1.
    On(&'a C, f64),
}

impl<C> Stretches<C> {
    /// Fits a curve to each reachable stretch; `fit` sees the number of the key before the stretch's start, and the
    /// tangents' weights.
    fn new<V>(keys: &[Key<V>], mut fit: impl FnMut(usize, Weights) -> Option<C>) -> Result<Self, TrackError> {
        let [_, first, .., last, _] = keys else { return Err(TrackError::TooFew(keys.len())) };
        if let Some(bad) = keys.iter().position(|key| !key.time.is_finite()) {
            return Err(TrackError::NotFinite(bad));
        }
        let mut list: Vec<Stretch<C>> = Vec::new();
        let mut reached = first.time;
        for (index, four) in keys.array_windows().enumerate() {
            let weights = Weights::new(four);
            let curve = fit(index, weights);
            let (start, end) = (four[1].time, four[2].time);
            if end > reached {
                list.push(Stretch { start, end, curve: curve.ok_or(TrackError::NotFinite(index + 1))? });
                reached = end;
            }
        }
        Ok(Self { start: first.time, end: last.time, list })
    }

    fn at(&self, time: f64) -> Place<'_, C> {
        if time <= self.start {
            return Place::Before;
        }
        match self.list.get(self.list.partition_point(|stretch| stretch.end <= time)) {
            Some(stretch) if time < self.end => {
                Place::On(&stretch.curve, (time - stretch.start) / (stretch.end - stretch.start))
            }
            _ => Place::After,
        }
    }
}

/// Shares of the differences before, along and after a stretch in its tangents.
#[derive(Clone, Copy, Debug)]
struct Weights {
    out_before: f64,
    out_along: f64,
    in_along: f64,
    in_after: f64,
}

impl Weights {
    fn new<V>([before, from, to, after]: &[Key<V>; 4]) -> Self {
        let length = to.time - from.time;
        let out = length / (to.time - before.time) * (1.0 - from.tcb.tension);
        let into = length / (after.time - from.time) * (1.0 - to.tcb.tension);
        Self {
            out_before: out * (1.0 + from.tcb.continuity) * (1.0 + from.tcb.bias),
            out_along: out * (1.0 - from.tcb.continuity) * (1.0 - from.tcb.bias),
            in_along: into * (1.0 - to.tcb.continuity) * (1.0 + to.tcb.bias),
            in_after: into * (1.0 + to.tcb.continuity) * (1.0 - to.tcb.bias),
        }
    }
}

/// A spline of positions or of scales.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorTrack {
    first: DVec3,
    last: DVec3,
    /// Coefficients of 1, u, u^2, u^3.
    cubics: Stretches<[DVec3; 4]>,
}

impl VectorTrack {
    /// The spline through `keys`, at least 4.
    pub fn new(keys: &[Key<DVec3>]) -> Result<Self, TrackError> {
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
    pub fn at(&self, time: f64) -> DVec3 {
        match self.cubics.at(time) {
            Place::Before => self.first,
            Place::After => self.last,
            Place::On([a, b, c, d], u) => *a + u * (*b + u * (*c + u * *d)),
        }
    }

    /// Bounds on the value's components, without their sign, over all times. They hold, but are not tight.
    pub fn bound(&self) -> DVec3 {
        let ends = self.first.abs().max(self.last.abs());
        let sums = self.cubics.list.iter().map(|stretch| stretch.curve.iter().map(|c| c.abs()).sum());
        sums.fold(ends, DVec3::max)
    }
}
