//! The spec of a whole machine: composes the specs of its parts and checks them together.

use serde::{Deserialize, Serialize};

use super::dispatcher::DispatcherSpec;
use super::intersection::IntersectionSpec;
use super::shadow_cache::ShadowCacheSpec;
use super::traversal::TraversalSpec;
use crate::memory::bank::L2Spec;
use crate::memory::dram_timing::DramSpec;
use crate::ranged::{PowerOfTwo, Within};

/// A machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MachineSpec {
    /// The machine's name in reports.
    pub name: String,
    /// The clock of all units and caches.
    pub clock_mhz: Within<1, 10_000>,
    /// Bytes of a line, in all caches.
    pub line_bytes: PowerOfTwo<32, 128>,
    /// The dispatcher.
    pub dispatcher: DispatcherSpec,
    /// The traversal units.
    pub traversal: TraversalSpec,
    /// The intersection units.
    pub intersection: IntersectionSpec,
    /// The shadow-cache unit.
    pub shadow_cache: ShadowCacheSpec,
    /// The L2.
    pub l2: L2Spec,
    /// The DRAM.
    pub dram: DramSpec,
}

impl Default for MachineSpec {
    fn default() -> Self {
        Self {
            name: "default".into(),
            clock_mhz: const { Within::literal(500) },
            line_bytes: const { PowerOfTwo::literal(64) },
            dispatcher: DispatcherSpec::default(),
            traversal: TraversalSpec::default(),
            intersection: IntersectionSpec::default(),
            shadow_cache: ShadowCacheSpec::default(),
            l2: L2Spec::DEFAULT,
            dram: DramSpec::default(),
        }
    }
}

/// What is wrong with a machine's spec.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpecError {
    /// The text is no spec.
    #[error(transparent)]
    Syntax(#[from] ron::error::SpannedError),
    /// Fields do not fit each other.
    #[error("{0}")]
    Mismatch(String),
}

impl MachineSpec {
    /// Reads a machine from RON, and checks it.
    pub fn from_ron(text: &str) -> Result<Self, SpecError> {
        let spec: Self = ron::from_str(text)?;
        spec.check()?;
        Ok(spec)
    }

    /// Checks what single fields cannot.
    pub fn check(&self) -> Result<(), SpecError> {
        let line = self.line_bytes.get();
        self.traversal
            .cache
            .check("traversal.cache", line)
            .and_then(|()| self.intersection.cache.check("intersection.cache", line))
            .and_then(|()| self.shadow_cache.cache.check("shadow_cache.cache", line))
            .and_then(|()| self.l2.check(line))
            .and_then(|()| self.dram.check(line))
            .map_err(SpecError::Mismatch)
    }
}
