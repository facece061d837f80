//! Checks of the numbers in a scene's RON: a value that is not allowed is refused while the file is read.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Deserializer, de::Error};

use super::limits::{self, COORDINATE, LENGTH, Range, SHARE, STRENGTH};

/// A place.
pub(super) fn point<'de, D: Deserializer<'de>>(from: D) -> Result<DVec3, D::Error> {
    let point = vector(from)?;
    limits::check_reach(point).map_err(D::Error::custom)
}

/// A vector of any length.
pub(super) fn vector<'de, D: Deserializer<'de>>(from: D) -> Result<DVec3, D::Error> {
    COORDINATE.check_vector("a coordinate", DVec3::deserialize(from)?).map_err(D::Error::custom)
}

/// A vector of nonzero length.
pub(super) fn nonzero<'de, D: Deserializer<'de>>(from: D) -> Result<DVec3, D::Error> {
    let vector = vector(from)?;
    LENGTH.check("a vector's length", vector.length()).map_err(D::Error::custom)?;
    Ok(vector)
}

/// The three lengths of a size.
pub(super) fn size<'de, D: Deserializer<'de>>(from: D) -> Result<DVec3, D::Error> {
    LENGTH.check_vector("a size", DVec3::deserialize(from)?).map_err(D::Error::custom)
}

/// The colour of a light; above 1 is allowed, for strong ones.
pub(super) fn color<'de, D: Deserializer<'de>>(from: D) -> Result<Vec3, D::Error> {
    color_within(STRENGTH, from)
}

/// The colour of a surface, which may be left out.
pub(super) fn optional_surface<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Vec3>, D::Error> {
    #[derive(Deserialize)]
    #[serde(transparent)]
    struct Surface(#[serde(deserialize_with = "surface")] Vec3);
    Ok(Option::<Surface>::deserialize(from)?.map(|color| color.0))
}

fn surface<'de, D: Deserializer<'de>>(from: D) -> Result<Vec3, D::Error> {
    color_within(SHARE, from)
}

fn color_within<'de, D: Deserializer<'de>>(range: Range, from: D) -> Result<Vec3, D::Error> {
    range.check_color("a colour", DVec3::deserialize(from)?).map_err(D::Error::custom)
}

/// A coordinate, an angle, or a factor of one of them.
pub(super) fn coordinate<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    COORDINATE.check("a number", f64::deserialize(from)?).map_err(D::Error::custom)
}

/// A length, or a factor of lengths.
pub(super) fn positive<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    LENGTH.check("a length", f64::deserialize(from)?).map_err(D::Error::custom)
}

/// An angle of view in degrees, between 0 and 180.
pub(super) fn angle_of_view<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let degrees = f64::deserialize(from)?;
    if degrees > 0.0 && degrees < 180.0 {
        Ok(degrees)
    } else {
        Err(D::Error::custom(format!("an angle of view of {degrees} degrees is not allowed: between 0 and 180 is")))
    }
}
