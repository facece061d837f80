//! The L2 and the DRAM: banks with real tags that take one access per cycle.

use super::dram::Dram;
use super::slots::Slots;
use super::timed_cache::{Lookup, TimedCache};
use super::watch::Watch;
use crate::engine::tally::{BankTally, ChannelTally};
use crate::machine::MachineSpec;
use crate::memory::bank::{BankedSpec, Served};
use crate::memory::cache::Access;
use crate::memory::l2::Home;
use crate::memory::tags::Victim;
use crate::memory::timeless::TimelessCache;
use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;

/// A bank of the L2.
#[derive(Clone, Debug)]
struct Bank {
    level: TimedCache,
    latency: u64,
    accesses: Slots,
    /// Until when the head of the bank's queue, and all behind it, wait for an MSHR or target.
    stalled_until: u64,
    served: Served,
}

/// Result of an access: the bank, the cycle in which it has the line, and whether it missed.
struct Accessed {
    bank: usize,
    ready: u64,
    missed: bool,
}

/// The memory below the L1s.
#[derive(Clone, Debug)]
pub(super) struct Memory<W> {
    /// Receives every access.
    pub watch: W,
    /// Banks of all cores, and the number of banks per core.
    banks: Vec<Bank>,
    of_core: usize,
    homes: [Home; TrafficClass::ALL.len()],
    dram: Dram,
}

impl<W: Watch> Memory<W> {
    /// The empty memory of `machine`.
    pub(super) fn new(machine: &MachineSpec, watch: W) -> Self {
        let line = machine.line_bytes.get();
        let bank = |spec: &BankedSpec| Bank {
            level: TimedCache::new(spec.bank_tags(line), spec.no_allocate, spec.mshrs.get(), spec.targets.get(), 0),
            latency: spec.latency.get(),
            accesses: Slots::new(1),
            stalled_until: 0,
            served: Served::default(),
        };
        let l2 = machine.l2.caches();
        Self {
            watch,
            banks: (0..machine.cores.size())
                .flat_map(|_| l2.iter().flat_map(|(_, spec)| (0..spec.banks.get()).map(|_| bank(spec))))
                .collect(),
            of_core: machine.l2.banks() as usize,
            homes: machine.l2.homes(),
            dram: Dram::new(&machine.dram, machine.clock_mhz.get(), line),
        }
    }

    /// A unit of core `core` reads `bytes` bytes of a line in cycle `at`; `attributed` says whether its miss counts
    /// among the attributed ones. Returns the cycle in which they come.
    pub(super) fn read(
        &mut self,
        core: usize,
        (line, bytes): (LineAddr, Bytes),
        class: TrafficClass,
        attributed: bool,
        at: u64,
    ) -> u64 {
        let Accessed { bank, ready, missed } = self.access(core, line, class, false, at);
        let bank = &mut self.banks[bank];
        bank.served.read(class, bytes, missed, attributed);
        ready + bank.latency + 1
    }

    /// An L1 sends `bytes` of a line down in cycle `at`.
    pub(super) fn write(&mut self, core: usize, line: LineAddr, class: TrafficClass, bytes: Bytes, at: u64) {
        let Accessed { bank, .. } = self.access(core, line, class, true, at);
        self.banks[bank].served.write(class, bytes);
    }

    fn access(&mut self, core: usize, line: LineAddr, class: TrafficClass, write: bool, at: u64) -> Accessed {
        let index = core * self.of_core + self.homes[class as usize].bank(line);
        self.watch.l2(core, line, class);
        let Self { banks, dram, .. } = self;
        let bank = &mut banks[index];
        let asked = bank.accesses.take(bank.stalled_until.max(at + 1));
        let access = if write { Access::Write } else { Access::Read };
        let mut gone = |victim: Victim, at| {
            dram.request(victim.line, victim.class, true, at);
        };
        let (at, found) = bank.level.access(line, class, access, !write, asked, &mut gone);
        if at > asked {
            bank.stalled_until = at;
        }
        let ready = match found {
            Lookup::Hit => at,
            Lookup::MshrHit(ready) => ready.max(at),
            Lookup::Miss => {
                let ready = dram.request(line, class, false, at) + 1;
                bank.level.schedule_fill(line, class, access, ready);
                ready
            }
            Lookup::WriteAround => {
                dram.request(line, class, true, at);
                at
            }
        };
        Accessed { bank: index, ready, missed: found == Lookup::Miss }
    }

    /// Requests a line that bypasses all caches in cycle `at`; returns the cycle in which its data has passed.
    pub(super) fn ask_dram(&mut self, line: LineAddr, class: TrafficClass, write: bool, at: u64) -> u64 {
        self.dram.request(line, class, write, at)
    }

    /// Loads the contents of `banks` into the L2s.
    pub(super) fn hold(&mut self, banks: &[TimelessCache]) {
        self.banks.iter_mut().zip(banks).for_each(|(bank, cache)| bank.level.hold(cache.tags()));
    }

    /// Fills all lines that come up to cycle `at`.
    pub(super) fn settle(&mut self, at: u64) {
        let Self { banks, dram, .. } = self;
        for bank in banks {
            bank.level.arrive(at, &mut |victim, at| {
                dram.request(victim.line, victim.class, true, at);
            });
        }
    }

    /// The cycle in which all pending work ends.
    pub(super) fn settled_at(&self) -> u64 {
        let banks = self.banks.iter().map(|bank| bank.level.settled_at().max(bank.accesses.end()));
        banks.max().unwrap_or(0).max(self.dram.settled_at())
    }

    /// A frame begins in cycle `at`: drops lines from `first` on.
    pub(super) fn drop_from(&mut self, first: LineAddr, at: u64) {
        self.settle(at);
        self.watch.drop_from(first);
        self.banks.iter_mut().for_each(|bank| bank.level.drop_from(first));
    }

    /// The banks' counts.
    pub(super) fn banks(&self) -> Vec<BankTally> {
        let tally = |bank: &Bank| BankTally { cache: *bank.level.counts(), served: bank.served.clone() };
        self.banks.iter().map(tally).collect()
    }

    /// The channels' counts in a run of `cycles`.
    pub(super) fn channels(&self, cycles: u64) -> Vec<ChannelTally> {
        self.dram.tally(cycles)
    }
}
