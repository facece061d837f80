//! Variants of a machine whose replays separate what culling saves from what its mode words cost.

use crate::machine::MachineSpec;
use crate::machine::shadow_cache::{Place, ShadowCacheSpec};

/// The machine for a stream without culling: nothing reaches its shadow-cache units, so they have default values.
pub(super) fn without_unit(spec: &MachineSpec) -> MachineSpec {
    MachineSpec { shadow_cache: ShadowCacheSpec::default(), ..spec.clone() }
}

/// The machine with free words. The units, their pipelines and their contexts stay, since occlusion tests and
/// decisions need them. Fields that say how words are stored and accessed get default values: they have no effect on
/// free words.
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

/// The role in which a machine is replayed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// The machine as its spec describes it.
    AsItIs,
    /// With free words.
    FreeWords,
    /// Without culling and without shadow-cache units: the baseline of the split.
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

    /// The role of the baseline for a machine in this role, under the same policy.
    pub(super) fn of_baseline(self) -> Self {
        match self {
            Self::AsItIs | Self::FreeWords => Self::AsItIs,
            Self::WithoutUnit => Self::WithoutUnit,
        }
    }

    /// Whether the field at `path` has an effect in this role.
    pub(super) fn has_field(self, path: &str) -> bool {
        self != Self::WithoutUnit || !path.starts_with("shadow_cache.")
    }

    /// The role's name in lists and reports.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::AsItIs => "as it is",
            Self::FreeWords => "free words",
            Self::WithoutUnit => "no unit",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::set;

    /// Operations, contexts and caches of the units are no cost of words.
    #[test]
    fn free_words_leave_the_units_as_they_are() {
        let mut machine = MachineSpec::default();
        for (field, value) in [("count", 4), ("latency", 5), ("interval", 6), ("contexts", 7), ("width", 3)] {
            machine = set::field(&machine, &format!("shadow_cache.{field}"), &value.to_string()).unwrap();
        }
        machine = set::field(&machine, "shadow_cache.cache.bytes", "65536").unwrap();
        let unit = ShadowCacheSpec { place: Place::Free, ..machine.shadow_cache };
        assert_eq!(with_free_words(&machine).shadow_cache, unit);
    }
}
