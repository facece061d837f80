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

/// An experiment: a scene, traced with several policies and replayed on several machines. Paths are relative to the
/// folder of the file that names them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExperimentSpec {
    /// The name of the report's folder. Letters, digits, `-` and `_` are allowed.
    #[serde(deserialize_with = "name")]
    pub name: String,
    /// The file of the scene.
    pub scene: PathBuf,
    /// The frames to trace.
    pub frames: FrameRange,
    /// The size of the pictures in pixels.
    pub resolution: Resolution,
    /// How the tracer turns frames into ray streams.
    #[serde(default)]
    pub tracer: TracerSpec,
    /// The culling policies by name. One of them must be `Off`, the baseline.
    #[serde(deserialize_with = "with_off")]
    pub policies: Named<PolicySpec>,
    /// The files of the machines.
    #[serde(default)]
    pub machines: Vec<PathBuf>,
    /// The fidelity level of the replays.
    #[serde(default)]
    pub fidelity: Fidelity,
    /// Whether each machine is also replayed with free words, and without culling and shadow-cache units. These extra
    /// replays separate what culling saves from what mode words cost. Fidelity levels that cannot replay such machines
    /// skip them.
    #[serde(default = "yes")]
    pub split: bool,
    /// Which of the traced frames the machines measure.
    #[serde(default = "all")]
    pub replay: FrameChoice,
    /// Number of warm-up frames for caches and mode words. Machines replay this many frames before each measured frame,
    /// and do not measure the first ones of the experiment. Default: 1 if a policy learns and a frame remains to
    /// measure, else 0.
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
