//! An experiment as its RON file says it.

use std::fmt;
use std::path::{Path, PathBuf};

use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use super::frames::{FrameChoice, FrameRange};
use super::ron_file::{self, ConfigError};
use crate::culling::PolicySpec;
use crate::quantity::Resolution;
use crate::tracer::TracerSpec;

/// An experiment: a scene, traced for several policies, replayed on several machines. Paths are relative to the folder of
/// the file that names them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExperimentSpec {
    /// The name of the report's folder: letters, digits, `-` and `_`.
    #[serde(deserialize_with = "name")]
    pub name: String,
    /// The scene's file.
    pub scene: PathBuf,
    /// The frames to trace.
    pub frames: FrameRange,
    /// The picture's size.
    pub resolution: Resolution,
    /// How frames become rays.
    #[serde(default)]
    pub tracer: TracerSpec,
    /// The culling policies by name; one of them is `Off`, which the others are measured against.
    pub policies: Policies,
    /// The machines' files.
    #[serde(default)]
    pub machines: Vec<PathBuf>,
    /// Which of the traced frames the machines replay.
    #[serde(default = "all")]
    pub replay: FrameChoice,
    /// Which of the traced frames are compared with the reference renderer.
    #[serde(default = "all")]
    pub validate: FrameChoice,
}

fn all() -> FrameChoice {
    FrameChoice::All
}

fn name<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let name = String::deserialize(from)?;
    let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
    if !name.is_empty() && name.len() <= 64 && name.chars().all(allowed) {
        Ok(name)
    } else {
        Err(D::Error::custom(format!("the name `{name}`: 1 to 64 letters, digits, `-` and `_` are allowed")))
    }
}

impl ExperimentSpec {
    /// Reads an experiment's file.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        ron_file::read(path)
    }
}

/// Culling policies by name, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Policies {
    named: Vec<(String, PolicySpec)>,
    off: usize,
}

impl Policies {
    /// Names and policies.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (&str, &PolicySpec)> {
        self.named.iter().map(|(name, policy)| (name.as_str(), policy))
    }

    /// The number of policies.
    pub fn len(&self) -> usize {
        self.named.len()
    }

    /// Never: there is always `Off`.
    pub fn is_empty(&self) -> bool {
        self.named.is_empty()
    }

    /// Which one is `Off`.
    pub fn off(&self) -> usize {
        self.off
    }
}

impl Serialize for Policies {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.iter())
    }
}

impl<'de> Deserialize<'de> for Policies {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Ordered;

        impl<'de> Visitor<'de> for Ordered {
            type Value = Policies;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("policies by name, such as {\"Off\": Off, \"Published\": Published()}")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Policies, A::Error> {
                let mut named: Vec<(String, PolicySpec)> = Vec::new();
                while let Some((name, policy)) = map.next_entry::<String, PolicySpec>()? {
                    if named.iter().any(|(other, _)| *other == name) {
                        return Err(A::Error::custom(format!("two policies have the name `{name}`")));
                    }
                    named.push((name, policy));
                }
                let off = named.iter().position(|(_, policy)| *policy == PolicySpec::Off);
                let off = off.ok_or_else(|| {
                    A::Error::custom("no policy is `Off`, which the others are measured against: add \"Off\": Off")
                })?;
                Ok(Policies { named, off })
            }
        }

        from.deserialize_map(Ordered)
    }
}
