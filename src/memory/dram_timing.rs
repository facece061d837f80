//! A DRAM's spec: organisation, timing parameters, and where an address lies.

use serde::{Deserialize, Serialize};

use crate::quantity::LineAddr;
use crate::ranged::{PowerOfTwo, Within};

/// A field of the address mapping; fields are listed from the least significant bit of the line's number on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Field {
    /// So many bits of the channel.
    Channel(u32),
    /// So many bits of the bank.
    Bank(u32),
    /// So many bits of the line's place in its row.
    Column(u32),
    /// All bits above: the row. It is the last field.
    Row,
}

/// A DRAM. The defaults are one LPDDR4-3200 channel of 16 bits (JESD209-4: BL16, 8 banks, 2 KiB pages; the timing of the usual
/// 1600 MHz bin rounded to clocks).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DramSpec {
    /// The clock of the timing parameters.
    pub clock_mhz: Within<1, 20_000>,
    /// Independent channels.
    pub channels: PowerOfTwo<1, 64>,
    /// Banks a channel.
    pub banks: PowerOfTwo<1, 64>,
    /// Bytes of a row of a bank.
    pub row_bytes: PowerOfTwo<32, 65_536>,
    /// Bytes of a burst: bus width times burst length.
    pub burst_bytes: PowerOfTwo<8, 256>,
    /// Clocks that a burst occupies the data bus.
    pub burst_clocks: Within<1, 64>,
    /// Requests that a channel holds.
    pub queue: Within<1, 1024>,
    /// Timing.
    pub timing: TimingSpec,
    /// Where an address lies.
    pub mapping: Vec<Field>,
}

/// Timing parameters in clocks of the DRAM, by their usual names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TimingSpec {
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
    /// Activate to activate, same bank.
    pub rc: Within<1, 2000>,
    /// Activate to activate, any banks.
    pub rrd: Within<1, 1000>,
    /// Read to precharge.
    pub rtp: Within<1, 1000>,
    /// End of write data to precharge.
    pub wr: Within<1, 1000>,
    /// End of write data to read.
    pub wtr: Within<1, 1000>,
    /// Refresh to refresh.
    pub refi: Within<100, 1_000_000>,
    /// Refresh to activate.
    pub rfc: Within<1, 10_000>,
}

impl TimingSpec {
    const DEFAULT: Self = Self {
        cl: Within::literal(28),
        cwl: Within::literal(14),
        rcd: Within::literal(29),
        rp: Within::literal(34),
        ras: Within::literal(68),
        rc: Within::literal(102),
        rrd: Within::literal(16),
        rtp: Within::literal(12),
        wr: Within::literal(29),
        wtr: Within::literal(16),
        refi: Within::literal(6248),
        rfc: Within::literal(288),
    };
}

impl Default for TimingSpec {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Default for DramSpec {
    fn default() -> Self {
        Self {
            clock_mhz: const { Within::literal(1600) },
            channels: const { PowerOfTwo::literal(1) },
            banks: const { PowerOfTwo::literal(8) },
            row_bytes: const { PowerOfTwo::literal(2048) },
            burst_bytes: const { PowerOfTwo::literal(32) },
            burst_clocks: const { Within::literal(8) },
            queue: const { Within::literal(32) },
            timing: TimingSpec::DEFAULT,
            mapping: vec![Field::Column(1), Field::Bank(3), Field::Column(4), Field::Row],
        }
    }
}

/// Where a line lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The channel.
    pub channel: usize,
    /// The bank of the channel.
    pub bank: usize,
    /// The row of the bank.
    pub row: u64,
}

impl DramSpec {
    /// Checks what single fields cannot; `line` is the line size in bytes, `machine_mhz` the machine's clock.
    pub fn check(&self, line: u64, machine_mhz: u64) -> Result<(), String> {
        let burst = self.burst_bytes.get();
        if burst > line {
            return Err(format!("`dram.burst_bytes` is {burst}: up to the line size, {line}, is allowed"));
        }
        if self.row_bytes.get() < line {
            return Err(format!("`dram.row_bytes` is {}: at least the line size, {line}, is allowed", self.row_bytes));
        }
        let TimingSpec { ras, rp, rc, refi, .. } = self.timing;
        if rc.get() < ras.get() + rp.get() {
            return Err(format!("`dram.timing.rc` is {rc}: at least ras + rp = {} is allowed", ras.get() + rp.get()));
        }
        let cycles = self.timing(machine_mhz, line);
        if cycles.refi <= 2 * cycles.around_refresh() {
            return Err(format!(
                "`dram.timing.refi` is {refi}: more than {} cycles of the machine are allowed, twice what a refresh and the first access after it can take",
                2 * cycles.around_refresh()
            ));
        }
        self.check_mapping(line)
    }

    fn check_mapping(&self, line: u64) -> Result<(), String> {
        let (mut channel, mut bank, mut column) = (0, 0, 0);
        for (index, &field) in self.mapping.iter().enumerate() {
            let sum = match field {
                Field::Channel(bits) => (&mut channel, bits),
                Field::Bank(bits) => (&mut bank, bits),
                Field::Column(bits) => (&mut column, bits),
                Field::Row if index + 1 == self.mapping.len() => continue,
                Field::Row => {
                    return Err("`dram.mapping` has `Row` before its end: it is allowed as the last field only".into());
                }
            };
            *sum.0 = u32::checked_add(*sum.0, sum.1).ok_or("`dram.mapping` has too many bits")?;
        }
        if self.mapping.last() != Some(&Field::Row) {
            return Err("`dram.mapping` does not end with `Row`: it must".into());
        }
        let needs = [
            ("Channel", channel, self.channels.get()),
            ("Bank", bank, self.banks.get()),
            ("Column", column, self.row_bytes.get() / line),
        ];
        for (name, bits, count) in needs {
            if bits != count.trailing_zeros() {
                return Err(format!(
                    "`dram.mapping` has {bits} bit(s) of `{name}`: {} is allowed, for {count} of them (columns count lines of a row)",
                    count.trailing_zeros()
                ));
            }
        }
        Ok(())
    }

    /// Where `line` lies.
    pub fn place(&self, line: LineAddr) -> Place {
        let mut rest = line.0;
        let (mut channel, mut channel_bits, mut bank, mut bank_bits) = (0, 0, 0, 0);
        for &field in &self.mapping {
            let mut take = |bits: u32| {
                let low = rest & ((1 << bits) - 1);
                rest >>= bits;
                low
            };
            match field {
                Field::Channel(bits) => {
                    channel |= take(bits) << channel_bits;
                    channel_bits += bits;
                }
                Field::Bank(bits) => {
                    bank |= take(bits) << bank_bits;
                    bank_bits += bits;
                }
                Field::Column(bits) => {
                    take(bits);
                }
                Field::Row => {}
            }
        }
        Place { channel: channel as usize, bank: bank as usize, row: rest }
    }

    /// Peak bandwidth in bytes a cycle of a machine clocked at `machine_mhz`.
    pub fn peak_bytes_per_cycle(&self, machine_mhz: u64) -> f64 {
        let per_dram_clock = (self.channels.get() * self.burst_bytes.get()) as f64 / self.burst_clocks.get() as f64;
        per_dram_clock * self.clock_mhz.get() as f64 / machine_mhz as f64
    }

    /// The timing in cycles of a machine clocked at `machine_mhz`, for lines of `line` bytes.
    pub fn timing(&self, machine_mhz: u64, line: u64) -> Timing {
        let dram_mhz = self.clock_mhz.get();
        let cycles = |clocks: u64| (clocks * machine_mhz).div_ceil(dram_mhz);
        let TimingSpec { cl, cwl, rcd, rp, ras, rc, rrd, rtp, wr, wtr, refi, rfc } = self.timing;
        Timing {
            cl: cycles(cl.get()),
            cwl: cycles(cwl.get()),
            rcd: cycles(rcd.get()),
            rp: cycles(rp.get()),
            ras: cycles(ras.get()),
            rc: cycles(rc.get()),
            rrd: cycles(rrd.get()),
            rtp: cycles(rtp.get()),
            wr: cycles(wr.get()),
            wtr: cycles(wtr.get()),
            refi: cycles(refi.get()),
            rfc: cycles(rfc.get()),
            parts: dram_mhz,
            line_parts: line / self.burst_bytes.get() * self.burst_clocks.get() * machine_mhz,
        }
    }
}

/// Timing parameters in machine cycles, each rounded up; names as in [`TimingSpec`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Timing {
    pub cl: u64,
    pub cwl: u64,
    pub rcd: u64,
    pub rp: u64,
    pub ras: u64,
    pub rc: u64,
    pub rrd: u64,
    pub rtp: u64,
    pub wr: u64,
    pub wtr: u64,
    pub refi: u64,
    pub rfc: u64,
    /// Parts that a machine cycle has, so that bus times are whole numbers: the DRAM's clock in MHz.
    pub parts: u64,
    /// Parts that a line occupies the data bus.
    pub line_parts: u64,
}

impl Timing {
    /// Cycles that closing all rows, a refresh and the next column command take at most. Without more time between
    /// refreshes nothing would be served.
    fn around_refresh(&self) -> u64 {
        let close = self.rtp + self.cwl + self.line_parts.div_ceil(self.parts) + self.wr + self.rc;
        close + self.rfc + self.rrd + self.rcd + self.wtr + self.line_parts.div_ceil(self.parts)
    }
}
