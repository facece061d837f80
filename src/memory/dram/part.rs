//! DRAM parts: organisation and timing from data sheets; `configs/dram` has a file per part.

use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::currents::{Currents, DramEnergy};
use crate::ranged::{PowerOfTwo, PowerOfTwoSize, Within};
use crate::spread::Spread;

/// One channel of a DRAM part. A part's file must give all values, since defaults of another part would be wrong.
/// Values that contradict each other are refused while the file is read, so that the error names the line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, remote = "Self")]
pub struct DramPart {
    /// The part's name in reports.
    pub name: String,
    /// The clock of commands and of all timing parameters.
    #[schemars(extend("unit" = "MHz"))]
    pub clock_mhz: Within<1, 20_000>,
    /// Number of bank groups; 1 for a part without bank groups.
    pub bank_groups: PowerOfTwo<1, 16>,
    /// Number of banks, all groups together.
    pub banks: PowerOfTwo<1, 64>,
    /// Size of a bank's row in bytes.
    pub row_bytes: PowerOfTwoSize<32, 65_536>,
    /// Bytes of a burst: bus width times burst length.
    pub burst_bytes: PowerOfTwoSize<8, 256>,
    /// Clocks for which a burst occupies the data bus.
    #[schemars(extend("unit" = "clocks of the DRAM"))]
    pub burst_clocks: Within<1, 1000>,
    /// Timing parameters.
    pub timing: Timing,
    /// Energy of commands and background. Without it, reports give no energy of the machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<DramEnergy>,
}

impl<'de> Deserialize<'de> for DramPart {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let part = Self::deserialize(from)?;
        part.check_values().map_err(D::Error::custom)?;
        Ok(part)
    }
}

impl Serialize for DramPart {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, to)
    }
}

/// Timing parameters in clocks of the DRAM, under their usual names. `_s` holds between banks of different groups, `_l`
/// between banks of one group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("unit" = "clocks of the DRAM"))]
pub struct Timing {
    /// Read command to data.
    pub cl: Within<1, 1000>,
    /// Write command to data.
    pub cwl: Within<1, 1000>,
    /// Activate to column command.
    pub rcd: Within<1, 1000>,
    /// Precharge to activate.
    pub rp: Within<1, 1000>,
    /// Activate to precharge.
    pub ras: Within<1, 1000>,
    /// Activate to activate of the same bank.
    pub rc: Within<1, 2000>,
    /// Column command to column command, different bank groups.
    pub ccd_s: Within<1, 1000>,
    /// Column command to column command, same bank group.
    pub ccd_l: Within<1, 1000>,
    /// Activate to activate, different bank groups.
    pub rrd_s: Within<1, 1000>,
    /// Activate to activate, same bank group.
    pub rrd_l: Within<1, 1000>,
    /// Four-activate window: any window of this length has at most four activates.
    pub faw: Within<1, 1000>,
    /// Read to precharge.
    pub rtp: Within<1, 1000>,
    /// End of write data to precharge.
    pub wr: Within<1, 1000>,
    /// End of write data to read, different bank groups.
    pub wtr_s: Within<1, 1000>,
    /// End of write data to read, same bank group.
    pub wtr_l: Within<1, 1000>,
    /// End of read data to start of write data: the bus turnaround.
    pub turn: Within<0, 1000>,
    /// Refresh to refresh.
    pub refi: Within<100, 1_000_000>,
    /// Refresh to activate.
    pub rfc: Within<1, 10_000>,
}

/// The currents of `configs/dram/lpddr4_3200.ron`.
const LPDDR4: Currents = Currents {
    volt: 1.2,
    devices: 1,
    idd0: 80.0,
    idd2n: 34.0,
    idd3n: 47.0,
    idd4r: 243.0,
    idd4w: 228.0,
    idd5: 280.0,
    factor: Spread::new(0.6, 1.0, 1.2),
    io_pj_per_bit: Spread::new(0.4, 1.0, 2.0),
};

/// One LPDDR4-3200 channel of 16 bits, as in `configs/dram/lpddr4_3200.ron`.
impl Default for DramPart {
    fn default() -> Self {
        Self {
            name: "LPDDR4-3200".into(),
            clock_mhz: const { Within::literal(1600) },
            bank_groups: const { PowerOfTwo::literal(1) },
            banks: const { PowerOfTwo::literal(8) },
            row_bytes: const { PowerOfTwoSize::literal(2048) },
            burst_bytes: const { PowerOfTwoSize::literal(32) },
            burst_clocks: const { Within::literal(8) },
            timing: const {
                Timing {
                    cl: Within::literal(28),
                    cwl: Within::literal(14),
                    rcd: Within::literal(29),
                    rp: Within::literal(34),
                    ras: Within::literal(68),
                    rc: Within::literal(102),
                    ccd_s: Within::literal(8),
                    ccd_l: Within::literal(8),
                    rrd_s: Within::literal(16),
                    rrd_l: Within::literal(16),
                    faw: Within::literal(64),
                    rtp: Within::literal(12),
                    wr: Within::literal(29),
                    wtr_s: Within::literal(16),
                    wtr_l: Within::literal(16),
                    turn: Within::literal(4),
                    refi: Within::literal(6248),
                    rfc: Within::literal(288),
                }
            },
            energy: Some(DramEnergy::Currents(LPDDR4)),
        }
    }
}

impl DramPart {
    /// The group of bank `bank`: each group is a run of consecutive banks.
    pub fn group(&self, bank: usize) -> usize {
        bank / (self.banks.size() / self.bank_groups.size())
    }

    /// Bursts in a line of `line` bytes.
    pub fn bursts(&self, line: u64) -> u64 {
        line / self.burst_bytes.get()
    }

    /// Checks what single fields cannot; `line` is the line size in bytes.
    pub(super) fn check(&self, line: u64) -> Result<(), String> {
        let (burst, row) = (self.burst_bytes, self.row_bytes);
        if burst.get() > line {
            return Err(format!("`burst_bytes` is {burst}: up to the line size, {line}, is allowed"));
        }
        if row.get() < line {
            return Err(format!("`row_bytes` is {row}: at least the line size, {line}, is allowed"));
        }
        self.check_values()
    }

    /// Checks that the values do not contradict each other.
    fn check_values(&self) -> Result<(), String> {
        let groups = self.bank_groups.get();
        if self.banks.get() < groups {
            return Err(format!("`banks` is {}: at least one a group, {groups}, is allowed", self.banks));
        }
        let Timing { ras, rp, rc, refi, ccd_s, ccd_l, rrd_s, rrd_l, wtr_s, wtr_l, .. } = self.timing;
        if rc.get() < ras.get() + rp.get() {
            return Err(format!("`timing.rc` is {rc}: at least ras + rp = {} is allowed", ras.get() + rp.get()));
        }
        if ccd_s.get() < self.burst_clocks.get() {
            let burst = self.burst_clocks;
            return Err(format!("`timing.ccd_s` is {ccd_s}: at least `burst_clocks`, {burst}, is allowed"));
        }
        for (name, short, long) in [("ccd", ccd_s, ccd_l), ("rrd", rrd_s, rrd_l), ("wtr", wtr_s, wtr_l)] {
            if short > long {
                return Err(format!("`timing.{name}_s` is {short}: up to {name}_l = {long} is allowed"));
            }
            if groups == 1 && short != long {
                return Err(format!(
                    "`timing.{name}_s` is {short}: without groups, {name}_l = {long} alone is allowed"
                ));
            }
        }
        let least = 2 * self.timing.around_refresh(self.burst_clocks.get());
        if refi.get() <= least {
            return Err(format!(
                "`timing.refi` is {refi}: more than {least} is allowed, twice what a refresh and the first access \
                 after it can take"
            ));
        }
        match &self.energy {
            Some(DramEnergy::Currents(currents)) => currents.check(&self.timing),
            Some(DramEnergy::PerBit { .. }) | None => Ok(()),
        }
    }
}

impl Timing {
    /// Upper bound in clocks for closing all rows, a refresh and the next column command, with bursts of `burst`
    /// clocks. A shorter refresh interval would leave no time to serve requests.
    pub fn around_refresh(&self, burst: u64) -> u64 {
        let close = self.ras.get().max(self.rtp.get()).max(self.cwl.get() + burst + self.wr.get());
        let refresh = self.rp.get().max(self.rc.get()) + self.rfc.get();
        let activate = self.rrd_l.get().max(self.faw.get()) + self.rcd.get();
        let column = self.ccd_l.get() + burst + self.wtr_l.get() + self.turn.get();
        close + refresh + activate + column
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::ron_file;

    #[test]
    fn the_shipped_parts_are_valid() {
        let parts = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/dram");
        let mut names = Vec::new();
        for file in std::fs::read_dir(parts).unwrap() {
            let part: DramPart = ron_file::read(&file.unwrap().path()).unwrap_or_else(|error| panic!("{error}"));
            // Lines of 32 B suit all parts except those with bursts of 64 B.
            part.check(32.max(part.burst_bytes.get())).unwrap_or_else(|error| panic!("{}: {error}", part.name));
            names.push(part.name);
        }
        names.sort();
        let expected = ["DDR4-3200", "GDDR3-2000", "GDDR5-8000", "GDDR6-14", "LPDDR4-3200", "LPDDR5-6400"];
        assert_eq!(names, expected);
        let default: DramPart = ron_file::read(&Path::new(parts).join("lpddr4_3200.ron")).unwrap();
        assert_eq!(default, DramPart::default());
    }
}
