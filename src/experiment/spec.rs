//! The spec of an experiment, read from a RON file.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize};

use super::frames::{FrameChoice, FrameRange};
use crate::culling::PolicySpec;
use crate::named::Named;
use crate::quantity::Resolution;
use crate::replay::Fidelity;
use crate::ron_file::{self, ConfigError};
use crate::tracer::TracerSpec;

/// An experiment: a scene, traced for several policies, replayed on several machines. Paths are relative to the folder
/// of the file that names them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    #[serde(deserialize_with = "with_off")]
    pub policies: Named<PolicySpec>,
    /// The machines' files.
    #[serde(default)]
    pub machines: Vec<PathBuf>,
    /// How the machines are replayed.
    #[serde(default)]
    pub fidelity: Fidelity,
    /// Whether each machine also replays with words that cost nothing, and without culling and its unit, to tell what
    /// was saved from what was paid. Rungs that do not know such machines leave it out.
    #[serde(default = "yes")]
    pub split: bool,
    /// Which of the traced frames the machines measure.
    #[serde(default = "all")]
    pub replay: FrameChoice,
    /// Frames that warm caches and words up: the machines replay so many before each measured frame, and leave the
    /// first so many of the experiment out. By default 1 where a policy learns and another frame is left to measure, 0
    /// otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warmup: Option<u32>,
    /// Which of the traced frames are compared with the reference renderer.
    #[serde(default = "all")]
    pub validate: FrameChoice,
}

fn yes() -> bool {
    true
}

fn all() -> FrameChoice {
    FrameChoice::All
}

fn name<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let name = String::deserialize(from)?;
    check_name(&name).map_err(D::Error::custom)?;
    Ok(name)
}

/// Checks the name of an experiment, which is also that of its report's folder. The error says what is allowed.
pub(crate) fn check_name(name: &str) -> Result<(), String> {
    let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
    if !name.is_empty() && name.len() <= 64 && name.chars().all(allowed) {
        Ok(())
    } else {
        Err(format!("the name `{name}`: 1 to 64 letters, digits, `-` and `_` are allowed"))
    }
}

impl ExperimentSpec {
    /// Reads an experiment's file.
    ///
    /// # Errors
    /// The file cannot be read, or is not an experiment's.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        ron_file::read(path)
    }
}

/// Reads policies; refuses them if none is `Off`.
fn with_off<'de, D: Deserializer<'de>>(from: D) -> Result<Named<PolicySpec>, D::Error> {
    let policies = Named::<PolicySpec>::deserialize(from)?;
    if policies.iter().any(|(_, policy)| *policy == PolicySpec::Off) {
        Ok(policies)
    } else {
        Err(D::Error::custom("no policy is `Off`, which the others are measured against: add \"Off\": Off"))
    }
}
