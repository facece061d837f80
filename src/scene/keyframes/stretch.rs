//! Keys, and the stretches of curve between them.

/// How the spline passes a key; all zero is a Catmull-Rom spline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tcb {
    /// 1 stops at the key.
    pub tension: f64,
    /// Other than 0 makes a corner.
    pub continuity: f64,
    /// Above 0 follows the stretch before the key, below 0 the one after it.
    pub bias: f64,
}

/// A value at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Key<V> {
    /// The time in seconds.
    pub time: f64,
    /// The value.
    pub value: V,
    /// How the spline passes it.
    pub tcb: Tcb,
}

/// Why keys make no track.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum TrackError {
    /// The first and the last key only give tangents.
    #[error("{0} keys: at least 4 are needed")]
    TooFew(usize),
    /// A number is not finite, or the keys before and after a key are at one time.
    #[error("key {0} gives no finite tangents: finite numbers, and other times before and after a key are allowed")]
    NotFinite(usize),
}

/// The reachable stretches between keys, in order of their end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stretches<C> {
    start: f64,
    end: f64,
    pub(super) list: Vec<Stretch<C>>,
}

/// The curve between two keys.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stretch<C> {
    start: f64,
    end: f64,
    pub(super) curve: C,
}

/// Where a time lies on a track.
pub(super) enum Place<'a, C> {
    Before,
    After,
    /// On a curve, with its parameter of 0..1.
    On(&'a C, f64),
}

impl<C> Stretches<C> {
    /// Fits a curve to each reachable stretch; `fit` gets the number of the key before the stretch's start, and the
    /// tangents' weights.
    pub(super) fn new<V>(
        keys: &[Key<V>],
        mut fit: impl FnMut(usize, Weights) -> Option<C>,
    ) -> Result<Self, TrackError> {
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

    /// Where `time` lies.
    pub(super) fn at(&self, time: f64) -> Place<'_, C> {
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

/// Weights of the differences before, along and after a stretch in its tangents.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    pub(super) out_before: f64,
    pub(super) out_along: f64,
    pub(super) in_along: f64,
    pub(super) in_after: f64,
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
