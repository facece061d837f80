//! The spec of a DRAM: its part, number of channels, scheduling and address mapping.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::mapping::{Field, Mapping, Place};
use super::part::DramPart;
use crate::quantity::LineAddr;
use crate::ranged::{PowerOfTwo, Size, Within};
use crate::ron_file;

/// Whether a row stays open after a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Page {
    /// The row stays open until its bank is needed for another row or a refresh.
    #[default]
    Open,
    /// The request's last column command closes the row (auto-precharge).
    Closed,
}

/// How a DRAM is modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Model {
    /// Banks with open rows and refresh, with the timing of the part.
    #[default]
    Banks,
    /// A fixed latency and a data bus, for bounds. Part, page policy and mapping have no effect; line `l` is in channel
    /// `l` modulo the number of channels.
    Flat {
        /// Cycles of the machine from the end of a line's transfer to its arrival.
        #[schemars(extend("unit" = "cycles"))]
        latency: Within<1, 100_000>,
        /// Bytes that a channel's data bus moves per cycle of the machine. Without it, transfers take no time.
        #[serde(default)]
        bytes_per_cycle: Option<Size<1, 65_536>>,
    },
}

/// A DRAM. The default is one channel of the default part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DramSpec {
    /// The model of the DRAM.
    pub model: Model,
    /// The DRAM part: the path of its file (relative to the file that names it), the name of a shipped part, or its
    /// values.
    #[serde(deserialize_with = "part")]
    #[schemars(extend("or_file" = true))]
    pub part: DramPart,
    /// Number of independent channels.
    pub channels: PowerOfTwo<1, 64>,
    /// Places of each channel's request queue.
    pub queue: Within<1, 1024>,
    /// Whether a row stays open after a request.
    pub page: Page,
    /// The address mapping: which bits of a line number select channel, bank, column and row.
    pub mapping: Mapping,
}

fn part<'de, D: Deserializer<'de>>(from: D) -> Result<DramPart, D::Error> {
    ron_file::values_or_file(from, ron_file::Kind::Dram)
}

impl Default for DramSpec {
    fn default() -> Self {
        Self {
            model: Model::Banks,
            part: DramPart::default(),
            channels: const { PowerOfTwo::literal(1) },
            queue: const { Within::literal(32) },
            page: Page::Open,
            mapping: Mapping(vec![Field::Column(1), Field::Bank(3), Field::Column(4), Field::Row]),
        }
    }
}

/// The format in reports: `1 channel of LPDDR4-3200, Open pages, line bits from the lowest: Column(1) Bank(3) Column(4)
/// Row`, or `2 flat channels, latency 50, 16 bytes a cycle each`.
impl fmt::Display for DramSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model, part, channels, page, mapping, .. } = self;
        let plural = if channels.get() > 1 { "s" } else { "" };
        if let Model::Flat { latency, bytes_per_cycle } = model {
            write!(f, "{channels} flat channel{plural}, latency {latency}")?;
            return match bytes_per_cycle {
                Some(bytes) => write!(f, ", {bytes} bytes a cycle each"),
                None => Ok(()),
            };
        }
        write!(f, "{channels} channel{plural} of {}, {page:?} pages, line bits from the lowest: {mapping}", part.name)
    }
}

impl DramSpec {
    /// Checks what single fields cannot; `line` is the line size in bytes.
    ///
    /// # Errors
    /// Fields that contradict each other, or lines that the part cannot move.
    pub fn check(&self, line: u64) -> Result<(), String> {
        if self.model != Model::Banks {
            return Ok(());
        }
        self.part.check(line).map_err(|what| format!("the DRAM part {}: {what}", self.part.name))?;
        self.mapping.check(self.channels.get(), &self.part, line)
    }

    /// The place of `line`.
    pub fn place(&self, line: LineAddr) -> Place {
        match self.model {
            Model::Banks => self.mapping.place(&self.part, line),
            Model::Flat { .. } => Place { channel: (line.0 % self.channels.get()) as usize, ..Place::default() },
        }
    }

    /// The relation of the DRAM's clock to a machine clock of `machine_mhz`.
    pub fn clocks(&self, machine_mhz: u64) -> Clocks {
        Clocks { dram_mhz: self.part.clock_mhz.get(), machine_mhz }
    }

    /// Peak bandwidth of a channel as a fraction: bytes, and cycles of a machine clocked at `machine_mhz`. `None`:
    /// unlimited.
    pub fn channel_peak(&self, machine_mhz: u64) -> Option<(u64, u64)> {
        let DramPart { burst_bytes, burst_clocks, clock_mhz, .. } = self.part;
        match self.model {
            Model::Banks => Some((burst_bytes.get() * clock_mhz.get(), burst_clocks.get() * machine_mhz)),
            Model::Flat { bytes_per_cycle, .. } => bytes_per_cycle.map(|bytes| (bytes.get(), 1)),
        }
    }

    /// Peak bandwidth of all channels in bytes per cycle of a machine clocked at `machine_mhz`; `None`: unlimited.
    pub fn peak_bytes_per_cycle(&self, machine_mhz: u64) -> Option<f64> {
        let peak = self.channel_peak(machine_mhz);
        peak.map(|(bytes, cycles)| (self.channels.get() * bytes) as f64 / cycles as f64)
    }
}

/// The DRAM's clock and the machine's: clock `k` begins `k` periods of the DRAM after cycle 0 begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    dram_mhz: u64,
    machine_mhz: u64,
}

impl Clocks {
    /// The cycle in which clock `clock` begins.
    pub fn cycle(&self, clock: u64) -> u64 {
        clock * self.machine_mhz / self.dram_mhz
    }

    /// The first cycle that does not begin before clock `clock`.
    pub fn cycle_after(&self, clock: u64) -> u64 {
        (clock * self.machine_mhz).div_ceil(self.dram_mhz)
    }

    /// The first clock that begins in cycle `cycle` or later.
    pub fn first(&self, cycle: u64) -> u64 {
        (cycle * self.dram_mhz).div_ceil(self.machine_mhz)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn clocks_and_cycles_fit(dram_mhz in 1..3000u64, machine_mhz in 1..3000u64, cycle in 0..100_000u64) {
            let clocks = Clocks { dram_mhz, machine_mhz };
            let first = clocks.first(cycle);
            prop_assert!(clocks.cycle(first) >= cycle);
            prop_assert!(first == 0 || clocks.cycle(first - 1) < cycle);
            let after = clocks.cycle_after(first) - clocks.cycle(first);
            prop_assert_eq!(after, u64::from(!(first * machine_mhz).is_multiple_of(dram_mhz)));
        }
    }
}
