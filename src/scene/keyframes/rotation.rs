//! Splines of rotations: `squad` between the logarithms of unit quaternions.

use glam::{DMat3, DQuat, DVec3};

use super::stretch::{Key, Place, Stretches, TrackError};

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
