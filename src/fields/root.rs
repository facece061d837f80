//! Kinds of config files, and the schemas of their types.

use schemars::{JsonSchema, SchemaGenerator};
use serde_json::Value;

use crate::experiment::spec::ExperimentSpec;
use crate::experiment::sweep::SweepSpec;
use crate::machine::MachineSpec;
use crate::memory::dram::part::DramPart;
use crate::scene::spec::SceneSpec;

/// A kind of config file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Root {
    /// A scene, policies and machines.
    Experiment,
    /// A machine.
    Machine,
    /// A scene.
    Scene,
    /// A sweep.
    Sweep,
    /// A part of DRAM.
    Dram,
}

impl Root {
    /// All kinds.
    pub(crate) const ALL: [Self; 5] = [Self::Experiment, Self::Machine, Self::Scene, Self::Sweep, Self::Dram];

    /// The first word of the paths of its fields.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Experiment => "experiment",
            Self::Machine => "machine",
            Self::Scene => "scene",
            Self::Sweep => "sweep",
            Self::Dram => "dram",
        }
    }

    /// The kind in a sentence.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Experiment => "an experiment file",
            Self::Machine => "a machine file",
            Self::Scene => "a scene file",
            Self::Sweep => "a sweep file",
            Self::Dram => "a file of a DRAM part",
        }
    }

    /// The name that a `#![type]` line gives to the type of such files.
    pub(crate) fn type_name(self) -> &'static str {
        match self {
            Self::Experiment => "Experiment",
            Self::Machine => "Machine",
            Self::Scene => "Scene",
            Self::Sweep => "Sweep",
            Self::Dram => "DramPart",
        }
    }

    /// The JSON schema of its type, with the schemas of all types that it names.
    pub(crate) fn schema(self) -> Value {
        match self {
            Self::Experiment => schema::<ExperimentSpec>(),
            Self::Machine => schema::<MachineSpec>(),
            Self::Scene => schema::<SceneSpec>(),
            Self::Sweep => schema::<SweepSpec>(),
            Self::Dram => schema::<DramPart>(),
        }
    }
}

fn schema<T: JsonSchema>() -> Value {
    SchemaGenerator::default().into_root_schema_for::<T>().to_value()
}
