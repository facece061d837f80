//! The machines whose replays, beside that of a machine as it is, tell what culling saves from what its words cost.

use crate::machine::MachineSpec;
use crate::machine::shadow_cache::{Place, ShadowCacheSpec};

/// The machine as a stream without culling sees it: nothing reaches its shadow-cache units.
pub(super) fn without_unit(spec: &MachineSpec) -> MachineSpec {
    MachineSpec { shadow_cache: ShadowCacheSpec::default(), ..spec.clone() }
}

/// The machine with words that cost nothing. The units, their pipelines and their contexts stay: occlusion tests and
/// decisions still need them. What says how words are kept and accessed has no effect on free ones.
pub(super) fn with_free_words(spec: &MachineSpec) -> MachineSpec {
    let of_words = ShadowCacheSpec::default();
    let unit = ShadowCacheSpec {
        place: Place::Free,
        silent: of_words.silent,
        gather: of_words.gather,
        latched: of_words.latched,
        layout: of_words.layout,
        writes: of_words.writes,
        register: of_words.register,
        frame_end: of_words.frame_end,
        ..spec.shadow_cache
    };
    MachineSpec { shadow_cache: unit, ..spec.clone() }
}

/// What a machine is replayed for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// It is measured as it is.
    AsItIs,
    /// With words that cost nothing.
    FreeWords,
    /// Without culling and without a unit for it: what the others are split against.
    WithoutUnit,
}

impl Role {
    /// The machine in this role.
    pub(crate) fn machine(self, spec: &MachineSpec) -> MachineSpec {
        match self {
            Self::AsItIs => spec.clone(),
            Self::FreeWords => with_free_words(spec),
            Self::WithoutUnit => without_unit(spec),
        }
    }

    /// The role of what a machine in this role is measured beside, under the same policy.
    pub(super) fn of_baseline(self) -> Self {
        match self {
            Self::AsItIs | Self::FreeWords => Self::AsItIs,
            Self::WithoutUnit => Self::WithoutUnit,
        }
    }

    /// Whether a field of the machine is there in this role.
    pub(super) fn has_field(self, path: &str) -> bool {
        self != Self::WithoutUnit || !path.starts_with("shadow_cache.")
    }

    /// What stands behind a policy's name, for stages of a run.
    pub(crate) fn suffix(self) -> &'static str {
        match self {
            Self::AsItIs => "",
            Self::FreeWords => ", words free",
            Self::WithoutUnit => ", no unit",
        }
    }
}
