//! Ranges of the numbers in a scene, the same for every format and for configs. All bounds except 1e-9 and 0.001 are
//! exact in `f32`: rounding to `f32` keeps a value within them.

use glam::{DVec3, Vec3};

/// The largest distance from the origin: squares of areas still fit in `f32`.
pub(super) const MAX_REACH: f64 = 1e9;
/// The largest number of triangles of a scene; the BART scenes have up to 111,000.
pub(super) const MAX_TRIANGLES: usize = 1 << 24;

/// The largest width and height of a picture, in pixels.
pub(super) const MAX_SIDE: u32 = 1 << 15;

/// Numbers from `low` to `high`, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    /// The smallest.
    pub low: f64,
    /// The largest.
    pub high: f64,
}

/// A coordinate, an angle in degrees, a factor of a coordinate.
pub(super) const COORDINATE: Range = Range { low: -MAX_REACH, high: MAX_REACH };
/// The size of something: smaller than this, areas come close to the smallest `f32`.
pub(super) const LENGTH: Range = Range { low: 1e-9, high: MAX_REACH };
/// A share of light that a surface reflects or lets through.
pub(super) const SHARE: Range = Range { low: 0.0, high: 1.0 };
/// The strength of a light in red, green or blue.
pub(super) const STRENGTH: Range = Range { low: 0.0, high: 1e9 };
/// A Phong exponent. The MTL specification has 0 to 1000; exporters write more.
pub(super) const SHININESS: Range = Range { low: 0.0, high: 1e9 };
/// An index of refraction, with the range of the MTL specification.
pub(super) const REFRACTION: Range = Range { low: 0.001, high: 10.0 };

impl Range {
    /// `value`, if it is within the range; `what` begins the message if it is not.
    pub(super) fn check(self, what: &str, value: f64) -> Result<f64, String> {
        if (self.low..=self.high).contains(&value) {
            Ok(value)
        } else {
            Err(format!("{what} of {value} is not allowed: a number {self} is"))
        }
    }

    /// `value`, if each of its numbers is within the range.
    pub(super) fn check_vector(self, what: &str, value: DVec3) -> Result<DVec3, String> {
        value.to_array().into_iter().try_for_each(|number| self.check(what, number).map(|_| ()))?;
        Ok(value)
    }

    /// A colour of three numbers within the range.
    pub(super) fn check_color(self, what: &str, value: DVec3) -> Result<Vec3, String> {
        self.check_vector(what, value).map(|color| color.as_vec3())
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let number = |value: f64| {
            if value == 0.0 || (1e-4..1e6).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
        };
        write!(f, "from {} to {}", number(self.low), number(self.high))
    }
}

/// `point`, if it is not too far from the origin.
pub(super) fn check_reach(point: DVec3) -> Result<DVec3, String> {
    if point.length() <= MAX_REACH {
        Ok(point)
    } else {
        Err(format!("a point is at {point}: at most {MAX_REACH:e} from the origin is allowed"))
    }
}

/// An error if a scene has more than [`MAX_TRIANGLES`].
pub(super) fn check_count(triangles: usize) -> Result<(), String> {
    if triangles <= MAX_TRIANGLES {
        Ok(())
    } else {
        Err(format!("too many triangles: at most {MAX_TRIANGLES} are allowed"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_told_and_included() {
        assert_eq!(COORDINATE.check("x", 1e9), Ok(1e9));
        assert_eq!(
            COORDINATE.check("x", f64::NAN).unwrap_err(),
            "x of NaN is not allowed: a number from -1e9 to 1e9 is"
        );
        assert_eq!(
            REFRACTION.check("`Ni`", 0.0).unwrap_err(),
            "`Ni` of 0 is not allowed: a number from 0.001 to 10 is"
        );
        assert!(SHARE.check_color("`Kd`", DVec3::new(0.0, 1.0, 1.01)).is_err());
        assert!(check_reach(DVec3::splat(6e8)).unwrap_err().contains("at most 1e9"));
    }
}
