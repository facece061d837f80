//! What a DRAM's commands and its time cost in energy: by the currents of its data sheet, or by a published figure a bit.
//!
//! The formulas are those of Micron's technical note TN-40-07 ("Calculating Memory Power for DDR4 SDRAM", 2017), as
//! DRAMsim3 has them in `configuration.cc`. `docs/model/energy.md` says them in words.

use serde::{Deserialize, Serialize};

use super::part::Timing;
use super::spec::{DramSpec, Model, Page};
use crate::spread::Spread;
use crate::stats::DramCounts;

/// How the energy of a part is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DramEnergy {
    /// By currents: energy a command and background power.
    Currents(Currents),
    /// By a figure for all that a bit costs between the cells and the pins of the other side, background included.
    PerBit {
        /// Picojoules a bit.
        pj: Spread,
    },
}

/// The currents of one device, in mA, and what else makes energy of them. Idle power-down is not modelled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Currents {
    /// Supply voltage in V.
    pub volt: f64,
    /// Devices that make up a channel.
    pub devices: u32,
    /// Activate and precharge of one bank, again and again.
    pub idd0: f64,
    /// All banks precharged.
    pub idd2n: f64,
    /// A bank open.
    pub idd3n: f64,
    /// Reads one after another.
    pub idd4r: f64,
    /// Writes one after another.
    pub idd4w: f64,
    /// Refreshes one after another.
    pub idd5: f64,
    /// Factors on all currents: data sheets give maxima, and those of vendors differ.
    pub factor: Spread,
    /// Picojoules a bit for drivers and termination, which these currents leave out.
    pub io_pj_per_bit: Spread,
}

/// A file holds finite values.
impl Eq for Currents {}

/// Energies of one channel in pJ: of a command, and of a clock that passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandEnergy {
    /// An activate and its precharge.
    pub activate: f64,
    /// A burst read, without drivers and termination.
    pub read: f64,
    /// A burst written.
    pub write: f64,
    /// A refresh.
    pub refresh: f64,
    /// A clock with a bank open.
    pub active_clock: f64,
    /// A clock with all banks precharged.
    pub precharged_clock: f64,
}

impl Currents {
    /// What commands and clocks of `clock_mhz` cost with the data sheet's currents.
    pub fn commands(&self, timing: &Timing, burst_clocks: u64, clock_mhz: u64) -> CommandEnergy {
        // V x mA x ns are pJ.
        let clock = self.volt * f64::from(self.devices) * 1000.0 / clock_mhz as f64;
        let [rc, ras, rp, rfc] =
            [timing.rc.get(), timing.ras.get(), timing.rp.get(), timing.rfc.get()].map(|clocks| clocks as f64);
        let burst = burst_clocks as f64;
        CommandEnergy {
            activate: clock * (self.idd0 * rc - (self.idd3n * ras + self.idd2n * rp)),
            read: clock * (self.idd4r - self.idd3n) * burst,
            write: clock * (self.idd4w - self.idd3n) * burst,
            refresh: clock * (self.idd5 - self.idd3n) * rfc,
            active_clock: clock * self.idd3n,
            precharged_clock: clock * self.idd2n,
        }
    }
}

/// What a DRAM did in a time.
#[derive(Clone, Copy, Debug)]
pub struct DramWork {
    /// Commands of all channels.
    pub counts: DramCounts,
    /// Bytes of a line.
    pub line_bytes: u64,
    /// The time in seconds.
    pub seconds: f64,
}

impl DramSpec {
    /// Picojoules that the DRAM used for `work`, by part; `None` where the part says nothing of its energy, or where a flat
    /// DRAM has no commands that currents could be applied to.
    pub fn energy(&self, work: &DramWork) -> Option<Vec<(&'static str, Spread)>> {
        let DramCounts { reads, writes, activates, refreshes, .. } = work.counts;
        let [reads, writes, activates, refreshes] = [reads, writes, activates, refreshes].map(|count| count as f64);
        let bits = (reads + writes) * work.line_bytes as f64 * 8.0;
        let part = &self.part;
        match part.energy? {
            DramEnergy::PerBit { pj } => Some(vec![("dram_transfer", pj * bits)]),
            DramEnergy::Currents(_) if self.model != Model::Banks => None,
            DramEnergy::Currents(currents) => {
                let clock_mhz = part.clock_mhz.get();
                let command = currents.commands(&part.timing, part.burst_clocks.get(), clock_mhz);
                let bursts = part.bursts(work.line_bytes) as f64;
                let clocks = work.seconds * clock_mhz as f64 * 1e6 * self.channels.get() as f64;
                let [closed, open] = [command.precharged_clock, command.active_clock];
                // How long banks are open is not counted: with open pages nearly always, with closed ones hardly.
                let typical = if self.page == Page::Open { open } else { closed };
                let Spread { low, typical: factor, high } = currents.factor;
                let background = Spread::new(closed * low, typical * factor, open * high);
                Some(vec![
                    ("dram_activate", currents.factor * (command.activate * activates)),
                    ("dram_read", currents.factor * (command.read * reads * bursts)),
                    ("dram_write", currents.factor * (command.write * writes * bursts)),
                    ("dram_refresh", currents.factor * (command.refresh * refreshes)),
                    ("dram_background", background * clocks),
                    ("dram_io", currents.io_pj_per_bit * bits),
                ])
            }
        }
    }
}
