//! Checks of the numbers in a scene's RON: a value that is not allowed is refused while the file is read.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Deserializer, de::Error};

/// A point or vector of finite numbers.
pub fn point<'de, D: Deserializer<'de>>(from: D) -> Result<DVec3, D::Error> {
    let point = DVec3::deserialize(from)?;
    if point.is_finite() {
        Ok(point)
    } else {
        Err(D::Error::custom(format!("{point} is not allowed here: three finite numbers are")))
    }
}

/// A vector that has a length.
pub fn nonzero<'de, D: Deserializer<'de>>(from: D) -> Result<DVec3, D::Error> {
    let vector = point(from)?;
    if vector.length() > 0.0 {
        Ok(vector)
    } else {
        Err(D::Error::custom("a vector of length zero is not allowed here"))
    }
}

/// A size of three positive numbers.
pub fn size<'de, D: Deserializer<'de>>(from: D) -> Result<DVec3, D::Error> {
    let size = point(from)?;
    if size.min_element() > 0.0 {
        Ok(size)
    } else {
        Err(D::Error::custom(format!("a size of {size} is not allowed: three positive numbers are")))
    }
}

/// A colour of three finite numbers that are not negative; above 1 is allowed, for strong lights.
pub fn color<'de, D: Deserializer<'de>>(from: D) -> Result<Vec3, D::Error> {
    let color = Vec3::deserialize(from)?;
    if color.is_finite() && color.min_element() >= 0.0 {
        Ok(color)
    } else {
        Err(D::Error::custom(format!("a colour of {color} is not allowed: three numbers of at least 0 are")))
    }
}

/// A colour that may be left out.
pub fn optional_color<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Vec3>, D::Error> {
    #[derive(Deserialize)]
    #[serde(transparent)]
    struct Color(#[serde(deserialize_with = "color")] Vec3);
    Ok(Option::<Color>::deserialize(from)?.map(|color| color.0))
}

/// A finite number.
pub fn finite<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let number = f64::deserialize(from)?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(D::Error::custom(format!("{number} is not allowed here: a finite number is")))
    }
}

/// A positive number.
pub fn positive<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let number = finite(from)?;
    if number > 0.0 {
        Ok(number)
    } else {
        Err(D::Error::custom(format!("{number} is not allowed here: a number above 0 is")))
    }
}

/// An angle of view in degrees, between 0 and 180.
pub fn angle_of_view<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let degrees = f64::deserialize(from)?;
    if degrees > 0.0 && degrees < 180.0 {
        Ok(degrees)
    } else {
        Err(D::Error::custom(format!("an angle of view of {degrees} degrees is not allowed: between 0 and 180 is")))
    }
}
