//! The motion of an object: position, rotation, scale and visibility.

use glam::{DAffine3, DMat3, DVec3};

use super::rotation::RotationTrack;
use super::vector::VectorTrack;

/// A switch that is on before its first key.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct VisibilityTrack {
    /// Times in seconds, each with the state from then on.
    pub keys: Vec<(f64, bool)>,
}

impl VisibilityTrack {
    /// Whether the switch is on at `time` seconds.
    pub(crate) fn at(&self, time: f64) -> bool {
        let next = self.keys.iter().position(|&(start, _)| time < start).unwrap_or(self.keys.len());
        next.checked_sub(1).is_none_or(|index| self.keys[index].1)
    }
}

/// The motion of an object: scale first, then rotation, then translation; a property that is `None` does not change.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Motion {
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
    pub(crate) fn transform(&self, time: f64) -> DAffine3 {
        let rotation = self.rotation.as_ref().map_or(DMat3::IDENTITY, |track| track.at(time));
        let scale = self.scale.as_ref().map_or(DVec3::ONE, |track| track.at(time));
        let translation = self.translation.as_ref().map_or(DVec3::ZERO, |track| track.at(time));
        DAffine3 { matrix3: rotation * DMat3::from_diagonal(scale), translation }
    }

    /// Whether the object is there at `time` seconds.
    pub(crate) fn visible(&self, time: f64) -> bool {
        self.visibility.as_ref().is_none_or(|track| track.at(time))
    }

    /// An upper bound, over all times, of the distance from the origin of points that are within `radius` before the
    /// motion.
    pub(crate) fn reach(&self, radius: f64) -> f64 {
        let scale = self.scale.as_ref().map_or(1.0, |track| track.bound().max_element());
        let translation = self.translation.as_ref().map_or(0.0, |track| track.bound().length());
        radius * scale + translation
    }
}
