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
mod stretch;
#[cfg(test)]
mod tests;
mod vector;

pub use self::motion::{Motion, VisibilityTrack};
pub use self::rotation::RotationTrack;
pub use self::stretch::{Key, Tcb, TrackError};
pub use self::vector::VectorTrack;
