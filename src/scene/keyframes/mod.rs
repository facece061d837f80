//! Keyframe tracks: Kochanek-Bartels (tension, continuity, bias) splines of positions in [`VectorTrack`], of rotations
//! in [`RotationTrack`], both together in [`Motion`].
//!
//! Source: Kochanek and Bartels, "Interpolating splines with local tension, continuity, and bias control", SIGGRAPH
//! 1984, with its correction for keys at unequal times. Rotations use the same weights on the logarithms of unit
//! quaternions, between which Shoemake's `squad` (1987) runs. The first and the last key only give tangents: a track
//! runs from its second to its last but one key and is constant outside. Times need not ascend. Of the stretches
//! between neighbouring keys, the first that ends after the given time counts. So keys at one time make a jump, and a
//! key that goes back in time is skipped, as in the BART scenes.

mod motion;
mod rotation;
mod stretch;
#[cfg(test)]
mod tests;
mod vector;

pub(crate) use self::motion::{Motion, VisibilityTrack};
pub(crate) use self::rotation::RotationTrack;
pub(crate) use self::stretch::{Key, Tcb, TrackError};
pub(crate) use self::vector::VectorTrack;
