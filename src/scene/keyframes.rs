//! Keyframe tracks: Kochanek-Bartels (tension, continuity, bias) splines of positions and of rotations.
//!
//! Source: Kochanek and Bartels, "Interpolating splines with local tension, continuity, and bias control", SIGGRAPH
//! 1984, with its correction for keys at unequal times; rotations use the same weights on the logarithms of unit
//! quaternions, between which Shoemake's `squad` (1987) runs. The first and the last key only give tangents: a track
//! runs from its second to its last but one key and stands still outside. Times need not rise: of the stretches
//! between neighbouring keys, the first that ends after the time asked for counts, so that keys at one time make a
//! jump and a key that goes back in time is passed over, as in the BART scenes.

use glam::{DAffine3, DMat3, DQuat, DVec3};

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

/// A spline of rotations.
#[derive(Clone, Debug, PartialEq)]
pub struct RotationTrack {
    first: DQuat,
    last: DQuat,
    curves: Stretches<Squad>,
}

#[derive(Clone, Debug, PartialEq)]
struct Squad {
    from: DQuat,
    to: DQuat,
    from_control: DQuat,
    to_control: DQuat,
}

/// Below this sine an angle counts as 0, or as half a turn.
const SMALL_SINE: f64 = 1e-6;

impl RotationTrack {
    /// The spline through `keys`, at least 4. Their quaternions should be of unit length; small deviations (the BART
    /// robot has axes of length 0.97 to 1.08) bend the spline a little, and every value stays a rotation.
    pub fn new(keys: &[Key<DQuat>]) -> Result<Self, TrackError> {
        let mut turned: Vec<DQuat> = keys.iter().map(|key| key.value).collect();
        let curves = Stretches::new(keys, |index, weights| {
            if turned[index + 1].dot(turned[index + 2]) < 0.0 {
                // Take the shorter way; the next stretch starts from the same quaternion.
                turned[index + 2] = -turned[index + 2];
            }
            let [q0, q1, q2, q3] = [0, 1, 2, 3].map(|offset| turned[index + offset]);
            let along = log(q1.conjugate() * q2);
            let out = weights.out_before * log(q0.conjugate() * q1) + weights.out_along * along;
            let into = weights.in_along * along + weights.in_after * log(q2.conjugate() * q3);
            let squad = Squad {
                from: q1,
                to: q2,
                from_control: q1 * exp((out - along) / 2.0),
                to_control: q2 * exp((along - into) / 2.0),
            };
            [q1, q2, squad.from_control, squad.to_control].iter().all(|q| q.is_finite()).then_some(squad)
        })?;
        let [first, last] = [keys[1].value, keys[keys.len() - 2].value];
        if first.is_finite() && last.is_finite() {
            Ok(Self { first, last, curves })
        } else {
            Err(TrackError::NotFinite(1))
        }
    }

    /// The rotation matrix at `time` seconds.
    pub fn at(&self, time: f64) -> DMat3 {
        let q = match self.curves.at(time) {
            Place::Before => self.first,
            Place::After => self.last,
            Place::On(squad, u) => slerp(
                2.0 * u * (1.0 - u),
                slerp(u, squad.from, squad.to),
                slerp(u, squad.from_control, squad.to_control),
            ),
        };
        // Through angle and axis, so that a quaternion that is not of unit length still gives a rotation.
        let axis = q.xyz().normalize_or_zero();
        if axis == DVec3::ZERO { DMat3::IDENTITY } else { DMat3::from_axis_angle(axis, 2.0 * angle(q.w)) }
    }
}

/// The angle whose cosine is `cosine`, which rounding or an axis that is too long can put beyond 1.
fn angle(cosine: f64) -> f64 {
    cosine.clamp(-1.0, 1.0).acos()
}

/// The logarithm of a unit quaternion, a vector.
fn log(q: DQuat) -> DVec3 {
    let angle = angle(q.w);
    let sine = angle.sin();
    if sine < SMALL_SINE { q.xyz() } else { q.xyz() * (angle / sine) }
}

/// The inverse of [`log`].
fn exp(v: DVec3) -> DQuat {
    let angle = v.length();
    let (sine, cosine) = angle.sin_cos();
    let part = if sine.abs() < SMALL_SINE { v } else { v * (sine / angle) };
    DQuat::from_xyzw(part.x, part.y, part.z, cosine)
}

/// Spherical interpolation along the arc from `p` to `q` as they are: neither is negated for the shorter way.
fn slerp(u: f64, p: DQuat, q: DQuat) -> DQuat {
    let angle = angle(p.dot(q));
    let sine = angle.sin();
    if sine < SMALL_SINE { p } else { p * (((1.0 - u) * angle).sin() / sine) + q * ((u * angle).sin() / sine) }
}

/// A switch that is on before its first key.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisibilityTrack {
    /// Times and what holds from then on.
    pub keys: Vec<(f64, bool)>,
}

impl VisibilityTrack {
    /// Whether the switch is on at `time` seconds.
    pub fn at(&self, time: f64) -> bool {
        let next = self.keys.iter().position(|&(start, _)| time < start).unwrap_or(self.keys.len());
        next.checked_sub(1).is_none_or(|index| self.keys[index].1)
    }
}

/// The motion of an object: scale first, then rotation, then translation; what is `None` stands still.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Where it is.
    pub translation: Option<VectorTrack>,
    /// How it is turned.
    pub rotation: Option<RotationTrack>,
    /// How large it is.
    pub scale: Option<VectorTrack>,
    /// Whether it is there at all.
    pub visibility: Option<VisibilityTrack>,
}

impl Motion {
    /// The transform at `time` seconds.
    pub fn transform(&self, time: f64) -> DAffine3 {
        let rotation = self.rotation.as_ref().map_or(DMat3::IDENTITY, |track| track.at(time));
        let scale = self.scale.as_ref().map_or(DVec3::ONE, |track| track.at(time));
        let translation = self.translation.as_ref().map_or(DVec3::ZERO, |track| track.at(time));
        DAffine3 { matrix3: rotation * DMat3::from_diagonal(scale), translation }
    }

    /// Whether the object is there at `time` seconds.
    pub fn visible(&self, time: f64) -> bool {
        self.visibility.as_ref().is_none_or(|track| track.at(time))
    }

    /// A bound, over all times, on the distance from the origin of points that are within `radius` before the motion.
    pub fn reach(&self, radius: f64) -> f64 {
        let scale = self.scale.as_ref().map_or(1.0, |track| track.bound().max_element());
        let translation = self.translation.as_ref().map_or(0.0, |track| track.bound().length());
        radius * scale + translation
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use proptest::prelude::*;

    use super::*;

    fn key<V>(time: f64, value: V) -> Key<V> {
        Key { time, value, tcb: Tcb::default() }
    }

    fn near(a: DVec3, b: DVec3) {
        assert!(a.distance(b) < 1e-12, "{a} is not {b}");
    }

    #[test]
    fn uniform_motion_along_a_line_stays_uniform_at_unequal_times() {
        let line = |time: f64| DVec3::new(1.0 - time, 2.0 * time, 3.0);
        let track = VectorTrack::new(&[-1.0, 0.0, 0.5, 3.0, 3.5, 7.0].map(|time| key(time, line(time)))).unwrap();
        for step in 0..=35 {
            let time = f64::from(step) * 0.1;
            near(track.at(time), line(time));
        }
        near(track.at(-0.5), line(0.0));
        near(track.at(9.0), line(3.5));
    }

    #[test]
    fn tension_of_one_stops_at_keys() {
        // Tangents vanish: the cubic is smoothstep, 3u^2 - 2u^3.
        let tcb = Tcb { tension: 1.0, ..Tcb::default() };
        let keys = [0.0, 1.0, 2.0, 3.0].map(|time| Key { time, value: DVec3::X * time, tcb });
        let track = VectorTrack::new(&keys).unwrap();
        for u in [0.0, 0.25, 0.5, 0.75, 1.0] {
            near(track.at(1.0 + u), DVec3::X * (1.0 + u * u * (3.0 - 2.0 * u)));
        }
    }

    #[test]
    fn continuity_and_bias_weigh_the_neighbours() {
        // Values 0, 0, 1, 1: along = 1 and the other differences 0, so the tangents are the weights of `along`:
        // out = (1-C)(1-B)/2, in = (1-C)(1+B)/2, and P(1/2) = 1/2 + (out - in)/8 = 1/2 - (1-C)B/8.
        for (continuity, bias) in [(0.0, 0.5), (0.5, 1.0), (-1.0, -0.5), (1.0, 0.3)] {
            let tcb = Tcb { tension: 0.0, continuity, bias };
            let keys = [0.0, 0.0, 1.0, 1.0].iter().enumerate();
            let keys: Vec<_> = keys.map(|(time, &x)| Key { time: time as f64, value: DVec3::X * x, tcb }).collect();
            let track = VectorTrack::new(&keys).unwrap();
            near(track.at(1.5), DVec3::X * (0.5 - (1.0 - continuity) * bias / 8.0));
        }
        // The weights of the neighbours: only the difference before, or only the one after, is not 0.
        let tcb = Tcb { tension: 0.5, continuity: 0.5, bias: 0.25 };
        let at = |values: [f64; 4]| {
            let mut time = -1.0;
            let keys = values.map(|x| {
                time += 1.0;
                Key { time, value: DVec3::X * x, tcb }
            });
            VectorTrack::new(&keys).unwrap().at(1.5).x
        };
        // P(1/2) = out/8 with out = (1-T)(1+C)(1+B)/2, and -in/8 with in = (1-T)(1+C)(1-B)/2.
        assert!((at([-1.0, 0.0, 0.0, 0.0]) - 0.5 * 1.5 * 1.25 / 16.0).abs() < 1e-15);
        assert!((at([0.0, 0.0, 0.0, 1.0]) + 0.5 * 1.5 * 0.75 / 16.0).abs() < 1e-15);
    }

    #[test]
    fn keys_at_one_time_make_a_jump() {
        let times = [0.0, 1.0, 2.0, 2.0, 3.0, 4.0];
        let track = VectorTrack::new(&times.map(|t| key(t, DVec3::ZERO))).unwrap();
        near(track.at(2.0), DVec3::ZERO);
        let mut keys: Vec<_> = times.map(|t| key(t, DVec3::ZERO)).into();
        for (index, key) in keys.iter_mut().enumerate() {
            key.value = DVec3::X * if index < 3 { 0.0 } else { 5.0 };
        }
        let track = VectorTrack::new(&keys).unwrap();
        near(track.at(2.0), DVec3::X * 5.0);
        assert!(track.at(2.0 - 1e-9).x.abs() < 1e-6);
        // Doubled times at both ends, as in most tracks of the BART robot.
        let keys = [0.0, 0.0, 1.0, 2.0, 2.0].map(|t| key(t, DVec3::X * t));
        near(VectorTrack::new(&keys).unwrap().at(1.0), DVec3::X);
        // All at one time.
        let keys = [1.0; 4].map(|t| key(t, DVec3::X));
        near(VectorTrack::new(&keys).unwrap().at(1.0), DVec3::X);
    }

    #[test]
    fn a_key_that_goes_back_in_time_is_passed_over() {
        // As `gun_rot1` of the BART robot: 48 is followed by 42.
        let times = [30.0, 34.0, 40.0, 48.0, 42.0, 50.0, 51.0];
        let mut index = 0.0;
        let track = VectorTrack::new(&times.map(|time| {
            index += 1.0;
            key(time, DVec3::X * index)
        }))
        .unwrap();
        near(track.at(40.0), DVec3::X * 3.0);
        // At 48 the stretch 42..50 takes over, three quarters of the way through.
        let Place::On(_, u) = track.cubics.at(48.0) else { panic!("48 is inside") };
        assert_eq!(u, 0.75);
        let Place::On(_, u) = track.cubics.at(44.0) else { panic!("44 is inside") };
        assert_eq!(u, 0.5);
    }

    #[test]
    fn bad_keys_are_refused() {
        assert_eq!(VectorTrack::new(&[key(0.0, DVec3::X); 3]), Err(TrackError::TooFew(3)));
        assert_eq!(RotationTrack::new(&[]), Err(TrackError::TooFew(0)));
        let times = |times: [f64; 4]| VectorTrack::new(&times.map(|t| key(t, DVec3::X * t)));
        assert_eq!(times([0.0, 1.0, f64::NAN, 3.0]), Err(TrackError::NotFinite(2)));
        // The keys around the second are at one time: its tangent is infinite.
        assert_eq!(times([2.0, 1.0, 2.0, 3.0]), Err(TrackError::NotFinite(1)));
        let mut keys = [0.0, 1.0, 2.0, 3.0].map(|t| key(t, DVec3::X));
        keys[3].value.y = f64::INFINITY;
        assert_eq!(VectorTrack::new(&keys), Err(TrackError::NotFinite(1)));
    }

    fn close(a: DMat3, b: DMat3) {
        assert!(a.abs_diff_eq(b, 1e-9), "{a} is not {b}");
    }

    #[test]
    fn uniform_rotation_about_an_axis_stays_uniform_at_unequal_times() {
        let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let times = [-1.0, 0.0, 0.5, 1.5, 2.5, 3.0];
        let track = RotationTrack::new(&times.map(|t| key(t, DQuat::from_axis_angle(axis, t)))).unwrap();
        for step in 0..=25 {
            let time = f64::from(step) * 0.1;
            close(track.at(time), DMat3::from_axis_angle(axis, time));
        }
        close(track.at(-7.0), DMat3::IDENTITY);
        close(track.at(7.0), DMat3::from_axis_angle(axis, 2.5));
    }

    #[test]
    fn rotations_take_the_shorter_way() {
        // Half angles 160 and -160 degrees: the quaternions are on opposite sides, the rotations 80 degrees apart.
        let turn = |degrees: f64| DQuat::from_axis_angle(DVec3::Z, degrees.to_radians());
        let track = RotationTrack::new(&[240.0, 320.0, -320.0, -240.0].map(|d| {
            let time = [240.0, 320.0, -320.0, -240.0].iter().position(|x| *x == d).unwrap_or(0);
            key(time as f64, turn(d))
        }))
        .unwrap();
        close(track.at(1.5), DMat3::IDENTITY);
    }

    #[test]
    fn quaternions_that_are_too_long_stay_rotations() {
        // The longest axis of the BART robot is 1.077 units; |w| passes 1 in between.
        let keys = [0.0, 1.0, 2.0, 3.0].map(|t| {
            let half: f64 = (10.0 - t) * 1e-3;
            let v = DVec3::Y * 1.077 * half.sin();
            key(t, DQuat::from_xyzw(v.x, v.y, v.z, 1.00007 * half.cos()))
        });
        let track = RotationTrack::new(&keys).unwrap();
        for step in 0..=20 {
            let m = track.at(1.0 + 0.05 * f64::from(step));
            assert!((m * m.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        }
        // No axis: no rotation.
        let track = RotationTrack::new(&[0.0, 1.0, 2.0, 3.0].map(|t| key(t, DQuat::from_xyzw(0.0, 0.0, 0.0, 0.5))));
        assert_eq!(track.unwrap().at(1.5), DMat3::IDENTITY);
    }

    #[test]
    fn a_motion_scales_then_rotates_then_translates() {
        let hold = |value| VectorTrack::new(&[0.0, 1.0, 2.0, 3.0].map(|t| key(t, value))).ok();
        let quarter = DQuat::from_axis_angle(DVec3::Z, FRAC_PI_2);
        let mut motion = Motion {
            translation: hold(DVec3::new(10.0, 0.0, 0.0)),
            rotation: RotationTrack::new(&[0.0, 1.0, 2.0, 3.0].map(|t| key(t, quarter))).ok(),
            scale: hold(DVec3::new(2.0, 3.0, 4.0)),
            visibility: None,
        };
        near(motion.transform(1.5).transform_point3(DVec3::new(1.0, 1.0, 1.0)), DVec3::new(7.0, 2.0, 4.0));
        assert!((motion.reach(1.0) - 14.0).abs() < 1e-12);
        assert!(motion.visible(0.0));
        motion.visibility = Some(VisibilityTrack { keys: vec![(0.5, false), (2.0, true)] });
        let seen = [0.4, 0.5, 1.9, 2.0, 99.0].map(|time| motion.visible(time));
        assert_eq!(seen, [true, false, false, true, true]);
        assert_eq!(Motion::default().transform(PI), DAffine3::IDENTITY);
    }

    proptest! {
        #[test]
        fn tracks_pass_their_keys_and_keep_their_bounds(
            steps in prop::collection::vec((0.01..2.0f64, -9.0..9.0f64, -9.0..9.0f64, -1.0..1.0f64), 4..9),
        ) {
            let mut time = 0.0;
            let keys: Vec<_> = steps.iter().map(|&(step, x, y, t)| {
                time += step;
                Key { time, value: DVec3::new(x, y, x * y), tcb: Tcb { tension: t, continuity: -t, bias: t * t } }
            }).collect();
            let track = VectorTrack::new(&keys).unwrap();
            for key in &keys[1..keys.len() - 1] {
                prop_assert!(track.at(key.time).distance(key.value) < 1e-9);
            }
            for step in 0..100 {
                let value = track.at(time * f64::from(step) / 100.0);
                prop_assert!(value.abs().cmple(track.bound() + 1e-9).all());
            }
            let turns: Vec<_> = keys.iter().map(|k| Key {
                time: k.time, value: DQuat::from_rotation_y(k.value.x) * DQuat::from_rotation_x(k.value.y), tcb: k.tcb,
            }).collect();
            let track = RotationTrack::new(&turns).unwrap();
            for key in &turns[1..turns.len() - 1] {
                prop_assert!(track.at(key.time).abs_diff_eq(DMat3::from_quat(key.value), 1e-5));
            }
        }

        #[test]
        fn any_numbers_give_finite_values_or_an_error(
            numbers in prop::collection::vec((-3i32..3, any::<f64>(), any::<f64>(), any::<f64>()), 0..8), at in any::<f64>(),
        ) {
            let keys: Vec<_> = numbers.iter().map(|&(time, x, y, tension)| Key {
                time: f64::from(time), value: DVec3::new(x, y, 0.0), tcb: Tcb { tension, ..Tcb::default() },
            }).collect();
            let turns: Vec<_> = keys.iter().map(|k| Key {
                time: k.time, value: DQuat::from_xyzw(k.value.x, k.value.y, 0.0, 1.0), tcb: k.tcb,
            }).collect();
            for time in [at, -1.5, 0.0, 0.5, f64::NAN] {
                if let Ok(track) = RotationTrack::new(&turns) {
                    prop_assert!(track.at(time).is_finite());
                }
                let _ = VectorTrack::new(&keys).map(|track| track.at(time));
            }
        }
    }
}
