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

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        MachineSpec::from_ron(text).unwrap_err().to_string()
    }

    #[test]
    fn the_shipped_machines_are_valid_and_come_back_from_ron() {
        for text in
            [include_str!("../../configs/machines/small.ron"), include_str!("../../configs/machines/desktop.ron")]
        {
            let machine = MachineSpec::from_ron(text).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(MachineSpec::from_ron(&ron::to_string(&machine).unwrap()), Ok(machine));
        }
        assert_eq!(MachineSpec::from_ron("()"), Ok(MachineSpec::default()));
    }

    #[test]
    fn errors_name_the_field_and_what_is_allowed() {
        let cases = [
            ("(clock: 5)", "clock_mhz"),
            ("(traversal: (count: 0))", "0 is not allowed here: a whole number from 1 to 1024 is"),
            ("(line_bytes: 48)", "48 is not allowed here: a power of two from 32 to 128 is"),
            ("(traversal: (cache: (bytes: 8000)))", "`traversal.cache.bytes` is 8000"),
            ("(l2: (bytes: 393216))", "1024 times a power of two is allowed"),
            ("(shadow_cache: (cache: (bytes: 12288, ways: 3, replacement: TreePlru)))", "a power of two is allowed"),
            ("(dram: (channels: 2))", "`dram.mapping` has 0 bit(s) of `Channel`: 1 is allowed"),
            ("(dram: (mapping: [Row, Column(4)]))", "`Row` before its end"),
            ("(dram: (mapping: [Column(5), Bank(3)]))", "does not end with `Row`"),
            ("(dram: (burst_bytes: 128))", "up to the line size, 64, is allowed"),
            ("(dram: (timing: (rc: 50)))", "at least ras + rp = 102 is allowed"),
            ("(dram: (timing: (refi: 500)))", "is allowed"),
        ];
        for (text, expected) in cases {
            let error = error(text);
            assert!(error.contains(expected), "{text}: {error}");
        }
        assert!(error("(\n  traversal: (\n    latncy: 3))").starts_with("3:"), "an error of syntax has its line");
    }
}
