//! Kinds of config files, and the schemas of their types.

use schemars::{JsonSchema, SchemaGenerator};
use serde_json::Value;

use crate::experiment::identities::IdentitiesSpec;
use crate::experiment::paper::PaperSpec;
use crate::experiment::pareto::ParetoSpec;
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
    /// Fidelity levels side by side.
    Pareto,
    /// Rays of one kind beside published rows.
    Identities,
    /// Readings of the paper beside its table.
    PaperTable,
    /// A part of DRAM.
    Dram,
}

impl Root {
    /// All kinds.
    pub(crate) const ALL: [Self; 8] = [
        Self::Experiment,
        Self::Machine,
        Self::Scene,
        Self::Sweep,
        Self::Dram,
        Self::Pareto,
        Self::Identities,
        Self::PaperTable,
    ];

    /// The first part of its fields' paths.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Experiment => "experiment",
            Self::Machine => "machine",
            Self::Scene => "scene",
            Self::Sweep => "sweep",
            Self::Pareto => "pareto",
            Self::Identities => "identities",
            Self::PaperTable => "paper_table",
            Self::Dram => "dram",
        }
    }

    /// The kind in a word or two.
    pub(crate) fn short(self) -> &'static str {
        match self {
            Self::PaperTable => "paper table",
            Self::Dram => "DRAM part",
            _ => self.name(),
        }
    }

    /// The kind in a sentence.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Experiment => "an experiment file",
            Self::Machine => "a machine file",
            Self::Scene => "a scene file",
            Self::Sweep => "a sweep file",
            Self::Pareto => "a comparison of fidelity levels",
            Self::Identities => "a table of rays of one kind",
            Self::PaperTable => "a table of readings of the paper",
            Self::Dram => "a file of a DRAM part",
        }
    }

    /// The type's name in a `#![type]` line.
    pub(crate) fn type_name(self) -> &'static str {
        match self {
            Self::Experiment => "Experiment",
            Self::Machine => "Machine",
            Self::Scene => "Scene",
            Self::Sweep => "Sweep",
            Self::Pareto => "Pareto",
            Self::Identities => "Identities",
            Self::PaperTable => "PaperTable",
            Self::Dram => "DramPart",
        }
    }

    /// The JSON schema of its type, with the schemas of all types that it refers to.
    pub(crate) fn schema(self) -> Value {
        match self {
            Self::Experiment => schema::<ExperimentSpec>(),
            Self::Machine => schema::<MachineSpec>(),
            Self::Scene => schema::<SceneSpec>(),
            Self::Sweep => schema::<SweepSpec>(),
            Self::Pareto => schema::<ParetoSpec>(),
            Self::Identities => schema::<IdentitiesSpec>(),
            Self::PaperTable => schema::<PaperSpec>(),
            Self::Dram => schema::<DramPart>(),
        }
    }
}

fn schema<T: JsonSchema>() -> Value {
    SchemaGenerator::default().into_root_schema_for::<T>().to_value()
}
