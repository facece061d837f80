//! Key-frame paths of cameras and objects, as RON gives them.
//!
//! A cubic of Catmull-Rom type runs between the keys. It meets every key exactly, and its slope at a key is the slope
//! of the line from the previous to the next key (Catmull and Rom 1974, with uneven distances of keys in time). Before
//! the first key and after the last, nothing moves.

use std::ops::{Add, Mul, Sub};

use glam::{DAffine3, DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use super::camera::Camera;
use super::fields;
use super::limits::{self, check_reach};

/// A quantity given at increasing key frames.
#[derive(Clone, Debug)]
pub(crate) struct Track<T> {
    keys: Vec<(u32, T)>,
}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Track<T> {
    /// A track through `keys`; the error says which key is wrong. At least one key, frames strictly increasing.
    pub(crate) fn new(keys: Vec<(u32, T)>) -> Result<Self, String> {
        check_frames(keys.iter().map(|key| key.0))?;
        Ok(Self { keys })
    }

    /// The value at `frame`.
    pub(crate) fn at(&self, frame: u32) -> T {
        let after = self.keys.partition_point(|key| key.0 <= frame);
        if after == 0 || after == self.keys.len() {
            return self.keys[after.saturating_sub(1)].1;
        }
        let ((start, from), (end, to)) = (self.keys[after - 1], self.keys[after]);
        let length = f64::from(end - start);
        let u = f64::from(frame - start) / length;
        let (leave, arrive) = (self.slope(after - 1) * length, self.slope(after) * length);
        let chord = to - from;
        from + (leave + (chord * 3.0 - leave * 2.0 - arrive + (leave + arrive - chord * 2.0) * u) * u) * u
    }

    /// The change per frame at a key.
    fn slope(&self, key: usize) -> T {
        let (before, after) = (self.keys[key.saturating_sub(1)], self.keys[(key + 1).min(self.keys.len() - 1)]);
        (after.1 - before.1) * f64::from(after.0 - before.0).recip()
    }
}

/// Checks that there is a key and that frames increase.
fn check_frames(frames: impl Iterator<Item = u32> + Clone) -> Result<(), String> {
    if frames.clone().next().is_none() {
        return Err("no key frame is given: at least one is needed".into());
    }
    match frames.clone().zip(frames.skip(1)).find(|(frame, next)| next <= frame) {
        Some((frame, next)) => {
            Err(format!("the key at frame {next} follows that at frame {frame}: frames must increase"))
        }
        None => Ok(()),
    }
}

/// The field of view of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum FieldOfView {
    /// The angle from the bottom to the top of the picture, in degrees.
    Vertical(
        #[serde(deserialize_with = "fields::angle_of_view")]
        #[schemars(extend("unit" = "degrees", "exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
        f64,
    ),
    /// The angle from the left to the right of a picture with the given aspect ratio. A picture with another aspect
    /// ratio keeps the vertical angle, since pixels are square.
    Horizontal {
        /// The angle in degrees.
        #[schemars(extend("unit" = "degrees", "exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
        #[serde(deserialize_with = "fields::angle_of_view")]
        degrees: f64,
        /// Aspect ratio: the picture's width divided by its height.
        #[schemars(range(min = limits::LENGTH.low, max = limits::LENGTH.high))]
        #[serde(deserialize_with = "fields::positive")]
        aspect: f64,
    },
}

impl FieldOfView {
    /// The vertical field of view in radians.
    pub fn vertical(self) -> f64 {
        match self {
            Self::Vertical(degrees) => degrees.to_radians(),
            Self::Horizontal { degrees, aspect } => 2.0 * ((0.5 * degrees.to_radians()).tan() / aspect).atan(),
        }
    }
}

/// Where the camera looks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum Look {
    /// At a point.
    At(
        #[serde(deserialize_with = "fields::coordinate")] f64,
        #[serde(deserialize_with = "fields::coordinate")] f64,
        #[serde(deserialize_with = "fields::coordinate")] f64,
    ),
    /// Along a direction; the length of the vector has no effect.
    Along(
        #[serde(deserialize_with = "fields::coordinate")] f64,
        #[serde(deserialize_with = "fields::coordinate")] f64,
        #[serde(deserialize_with = "fields::coordinate")] f64,
    ),
}

impl Look {
    /// The point looked at from `eye`; one unit away if a direction is given.
    fn target(self, eye: DVec3) -> DVec3 {
        match self {
            Self::At(x, y, z) => DVec3::new(x, y, z),
            Self::Along(x, y, z) => eye + DVec3::new(x, y, z).normalize_or_zero(),
        }
    }
}

/// A key frame of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// The number of the frame.
    pub frame: u32,
    /// Position of the camera.
    #[serde(deserialize_with = "fields::point")]
    #[schemars(with = "[f64; 3]")]
    pub eye: DVec3,
    /// Where the camera looks.
    pub look: Look,
}

/// A camera that stands still or moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum CameraPath {
    /// The same in every frame.
    Still {
        /// Position of the camera.
        #[serde(deserialize_with = "fields::point")]
        #[schemars(with = "[f64; 3]")]
        eye: DVec3,
        /// Where the camera looks.
        look: Look,
    },
    /// Motion through key frames: at least one, in ascending order of frames.
    Keys(#[serde(deserialize_with = "camera_keys")] Vec<CameraKey>),
}

fn camera_keys<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<CameraKey>, D::Error> {
    let keys = Vec::<CameraKey>::deserialize(from)?;
    check_frames(keys.iter().map(|key| key.frame)).map_err(D::Error::custom)?;
    Ok(keys)
}

/// A camera of a config file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraSpec {
    /// The field of view.
    pub fov: FieldOfView,
    /// The direction that is upwards in the picture.
    #[serde(default = "y_axis", deserialize_with = "fields::nonzero")]
    #[schemars(with = "[f64; 3]")]
    pub up: DVec3,
    /// Position and direction of the camera, fixed or by key frames.
    pub path: CameraPath,
}

fn y_axis() -> DVec3 {
    DVec3::Y
}

/// The cameras of an animation.
#[derive(Clone, Debug)]
pub(crate) struct CameraTrack {
    eye: Track<DVec3>,
    target: Track<DVec3>,
    up: DVec3,
    fov: f64,
}

impl CameraTrack {
    /// The track of `spec` over `frame_count` frames; the error names a frame at which the camera looks nowhere, or
    /// along its upward vector.
    pub(crate) fn new(spec: &CameraSpec, frame_count: u32) -> Result<Self, String> {
        let keys = match &spec.path {
            CameraPath::Still { eye, look } => vec![CameraKey { frame: 0, eye: *eye, look: *look }],
            CameraPath::Keys(keys) => keys.clone(),
        };
        let track = Self {
            eye: Track::new(keys.iter().map(|key| (key.frame, key.eye)).collect())?,
            target: Track::new(keys.iter().map(|key| (key.frame, key.look.target(key.eye))).collect())?,
            up: spec.up,
            fov: spec.fov.vertical(),
        };
        for frame in 0..frame_count {
            let camera = track.at(frame);
            if !camera.up.is_finite() {
                return Err(format!("at frame {frame} the camera looks nowhere, or straight along its upward vector"));
            }
            // The curve between two keys can overshoot them.
            check_reach(camera.eye).map_err(|what| format!("at frame {frame} the camera: {what}"))?;
        }
        Ok(track)
    }

    /// The camera at `frame`.
    pub(crate) fn at(&self, frame: u32) -> Camera {
        let eye = self.eye.at(frame);
        Camera::perspective(eye, self.target.at(frame) - eye, self.up, self.fov)
    }
}

/// A key frame of a moving object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseKey {
    /// The number of the frame.
    pub frame: u32,
    /// Position of the object's origin.
    #[serde(deserialize_with = "fields::point")]
    #[schemars(with = "[f64; 3]")]
    pub position: DVec3,
    /// Rotation about the vertical axis (+Y), in degrees. The number itself is interpolated, so keys of 0 and 360 give
    /// a full turn.
    #[serde(default, deserialize_with = "fields::coordinate")]
    pub rotation: f64,
    /// Scale factor of the shape. The curve between two keys can overshoot their values.
    #[schemars(range(min = limits::LENGTH.low, max = limits::LENGTH.high))]
    #[serde(default = "unscaled", deserialize_with = "fields::positive")]
    pub scale: f64,
}

fn unscaled() -> f64 {
    1.0
}

/// Reads the keys of a moving object: at least one, in the order of their frames.
pub(crate) fn pose_keys<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<PoseKey>, D::Error> {
    let keys = Vec::<PoseKey>::deserialize(from)?;
    check_frames(keys.iter().map(|key| key.frame)).map_err(D::Error::custom)?;
    Ok(keys)
}

/// Where a moving object is.
#[derive(Clone, Debug)]
pub(crate) struct PoseTrack {
    position: Track<DVec3>,
    rotation: Track<f64>,
    scale: Track<f64>,
}

impl PoseTrack {
    /// The track through `keys`; the error says which key is wrong.
    pub(crate) fn new(keys: &[PoseKey]) -> Result<Self, String> {
        Ok(Self {
            position: Track::new(keys.iter().map(|key| (key.frame, key.position)).collect())?,
            rotation: Track::new(keys.iter().map(|key| (key.frame, key.rotation.to_radians())).collect())?,
            scale: Track::new(keys.iter().map(|key| (key.frame, key.scale)).collect())?,
        })
    }

    /// Where the object's origin is at `frame`, and its scale.
    pub(crate) fn place(&self, frame: u32) -> (DVec3, f64) {
        (self.position.at(frame), self.scale.at(frame))
    }

    /// From the object's own space to the world at `frame`.
    pub(crate) fn at(&self, frame: u32) -> DAffine3 {
        let (position, scale) = self.place(frame);
        let turned = DQuat::from_rotation_y(self.rotation.at(frame));
        DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turned, position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_track_meets_its_keys_and_is_still_outside_them() {
        let keys = vec![(3, 1.0), (5, 4.0), (12, -2.0), (13, 0.1)];
        let track = Track::new(keys.clone()).unwrap();
        for (frame, value) in keys {
            assert_eq!(track.at(frame), value);
        }
        assert_eq!(track.at(0), 1.0);
        assert_eq!(track.at(99), 0.1);
    }

    #[test]
    fn a_straight_even_track_stays_straight() {
        let track = Track::new(vec![(0, 0.0), (10, 10.0), (30, 30.0), (31, 31.0)]).unwrap();
        for frame in 0..=31 {
            assert!((track.at(frame) - f64::from(frame)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_speed_does_not_jump_at_a_key() {
        // Frames are whole, so the keys lie far apart and the speeds on both sides are differences of one frame.
        let track = Track::new(vec![(0, 0.0), (100_000, 3.0), (250_000, -1.0), (400_000, 2.0)]).unwrap();
        for key in [100_000, 250_000] {
            let (before, after) = (track.at(key) - track.at(key - 1), track.at(key + 1) - track.at(key));
            assert!((before - after).abs() < 1e-3 * before.abs(), "{before} {after}");
        }
    }

    #[test]
    fn bad_keys_are_refused_while_the_text_is_read() {
        let parse = |keys: &str| ron::from_str::<CameraPath>(&format!("Keys([{keys}])")).map_err(|e| e.to_string());
        assert!(parse("(frame: 0, eye: (0, 0, 0), look: At(0, 0, 1))").is_ok());
        assert!(parse("").unwrap_err().contains("at least one is needed"));
        let twice = "(frame: 4, eye: (0, 0, 0), look: At(0, 0, 1)), (frame: 4, eye: (0, 0, 0), look: At(0, 0, 1))";
        assert!(parse(twice).unwrap_err().contains("frames must increase"));
        assert!(parse("(frame: 0, eye: (0, NaN, 0), look: At(0, 0, 1))").unwrap_err().contains("-1e9 to 1e9"));
        assert!(parse("(frame: 0, eye: (0, 0, 0), look: Along(0, inf, 1))").unwrap_err().contains("-1e9 to 1e9"));
        assert!(ron::from_str::<FieldOfView>("Vertical(180)").is_err());
    }

    #[test]
    fn a_camera_that_looks_nowhere_is_refused() {
        let spec = |look| CameraSpec {
            fov: FieldOfView::Vertical(40.0),
            up: DVec3::Y,
            path: CameraPath::Still { eye: DVec3::ONE, look },
        };
        assert!(CameraTrack::new(&spec(Look::At(1.0, 1.0, 1.0)), 1).is_err());
        assert!(CameraTrack::new(&spec(Look::Along(0.0, -1.0, 0.0)), 1).is_err());
        assert!(CameraTrack::new(&spec(Look::Along(0.0, -1.0, 0.1)), 1).is_ok());
    }

    #[test]
    fn a_horizontal_angle_of_view_becomes_the_vertical_one() {
        assert!((FieldOfView::Horizontal { degrees: 70.0, aspect: 1.0 }.vertical().to_degrees() - 70.0).abs() < 1e-12);
        let wide = FieldOfView::Horizontal { degrees: 90.0, aspect: 2.0 }.vertical();
        assert!(((0.5 * wide).tan() - 0.5).abs() < 1e-12);
    }
}
