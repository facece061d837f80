//! The energy of a DRAM's commands and of its background: from data-sheet currents or from a published energy per bit.
//!
//! The formulas are those of Micron's technical note TN-40-07 ("Calculating Memory Power for DDR4 SDRAM", 2017), as
//! implemented in `configuration.cc` of DRAMsim3. `docs/model/energy.md` explains them.

use super::currents::{Currents, DramEnergy};
use super::part::Timing;
use super::spec::{DramSpec, Model, Page};
use crate::spread::Spread;
use crate::stats::DramCounts;

/// Energies of one channel in pJ, per command and per clock.
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
    /// Checks that all currents are finite, and that no command takes less than the background.
    ///
    /// # Errors
    /// Says which field is wrong, and what is allowed.
    pub(super) fn check(&self, timing: &Timing) -> Result<(), String> {
        let Self { volt, idd0, idd2n, idd3n, idd4r, idd4w, idd5, .. } = *self;
        let [rc, ras, rp] = [timing.rc.get(), timing.ras.get(), timing.rp.get()].map(|clocks| clocks as f64);
        // An activate and its precharge take idd0 for rc clocks; banks are open for ras of them.
        let least_idd0 = (idd3n * ras + idd2n * rp) / rc;
        for (name, value, least) in [
            ("volt", volt, 0.0),
            ("idd2n", idd2n, 0.0),
            ("idd3n", idd3n, idd2n),
            ("idd0", idd0, least_idd0),
            ("idd4r", idd4r, idd3n),
            ("idd4w", idd4w, idd3n),
            ("idd5", idd5, idd3n),
        ] {
            if !value.is_finite() || value < least {
                return Err(format!("`energy.{name}` is {value}: a number of at least {least} is allowed"));
            }
        }
        Ok(())
    }

    /// Energy per command and per clock at `clock_mhz` from the data sheet's currents.
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

/// The counted work of a DRAM and its duration.
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
    /// Energy of `work` in pJ, per component. `None` if the part has no energy data, or if the model is flat and the
    /// data are currents: a flat DRAM counts no commands.
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
                // The time with open banks is not counted: it is nearly all of the time with open pages, hardly any
                // with closed pages.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::dram::part::DramPart;

    #[test]
    fn wrong_currents_are_named() {
        let part = DramPart::default();
        let Some(DramEnergy::Currents(good)) = part.energy else { panic!("the default part has currents") };
        assert_eq!(good.check(&part.timing), Ok(()));
        for (wrong, name) in [
            (Currents { volt: f64::NAN, ..good }, "volt"),
            (Currents { volt: -1.0, ..good }, "volt"),
            (Currents { idd3n: good.idd2n / 2.0, ..good }, "idd3n"),
            (Currents { idd0: good.idd3n / 2.0, ..good }, "idd0"),
            (Currents { idd4r: good.idd3n / 2.0, ..good }, "idd4r"),
            (Currents { idd4w: f64::INFINITY, ..good }, "idd4w"),
            (Currents { idd5: 0.0, ..good }, "idd5"),
        ] {
            let error = wrong.check(&part.timing).unwrap_err();
            assert!(error.starts_with(&format!("`energy.{name}` is ")), "{error}");
        }
    }
}
