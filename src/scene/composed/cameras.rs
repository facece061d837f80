//! The camera: as a config gives it, or one of a file by name.

use std::fmt;

use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::scene::camera::Camera;
use crate::scene::model::FileCamera;
use crate::scene::path::{CameraSpec, CameraTrack};

/// A camera.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum CameraChoice {
    /// A camera of a glTF file, by the name of its node.
    Named(String),
    /// A camera of the config.
    Given(CameraSpec),
}

/// The camera at a frame.
pub(super) type CameraAt = Box<dyn Fn(u32) -> Camera + Send + Sync>;

impl CameraChoice {
    /// The camera over `frame_count` frames, `frame_rate` of them a second. The error says what is wrong with it.
    pub(super) fn track(&self, files: Vec<FileCamera>, frame_count: u32, frame_rate: f64) -> Result<CameraAt, String> {
        match self {
            Self::Given(spec) => {
                let track = CameraTrack::new(spec, frame_count)?;
                Ok(Box::new(move |frame| track.at(frame)))
            }
            Self::Named(name) => {
                let names: Vec<_> = files.iter().map(|camera| format!("{:?}", camera.name)).collect();
                let Some(camera) = files.into_iter().find(|camera| camera.name == *name) else {
                    let known = if names.is_empty() { "the files have none".into() } else { names.join(", ") };
                    return Err(format!("no camera is named {name:?}: {known}"));
                };
                let at = move |frame: u32| camera.at(f64::from(frame) / frame_rate);
                match (0..frame_count).find(|frame| !at(*frame).up.is_finite()) {
                    Some(frame) => Err(format!("at frame {frame} the camera {name:?} has no direction")),
                    None => Ok(Box::new(at)),
                }
            }
        }
    }
}

impl<'de> Deserialize<'de> for CameraChoice {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Choice;

        impl<'de> Visitor<'de> for Choice {
            type Value = CameraChoice;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a file's camera, or a camera in brackets")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Self::Value, E> {
                Ok(CameraChoice::Named(name.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, values: A) -> Result<Self::Value, A::Error> {
                CameraSpec::deserialize(MapAccessDeserializer::new(values)).map(CameraChoice::Given)
            }
        }

        from.deserialize_any(Choice)
    }
}
