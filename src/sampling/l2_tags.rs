//! The tags of the L2s, without time: they receive the requests of the L1s' tags ([`super::requests`]).

use std::sync::Arc;

use super::covariates::Covariates;
use super::requests::Request;
use crate::engine::tally::PerClass;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::memory::bank::BankedSpec;
use crate::memory::cache::Access;
use crate::memory::l2::Home;
use crate::memory::timeless::TimelessCache;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;
use crate::stream::Header;

/// The tags of all L2s. Equal tags stay equal under equal requests.
#[derive(Debug, PartialEq)]
pub(super) struct L2Tags {
    /// Banks, core by core.
    banks: Vec<TimelessCache>,
    of_core: usize,
    homes: [Home; TrafficClass::ALL.len()],
    dynamic_part: LineAddr,
}

/// The effect of a list of requests.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    /// Lines of each class moved between L2 and DRAM.
    pub dram: PerClass<u64>,
    /// Requests to the busiest bank.
    pub bank: u64,
}

impl Moved {
    /// Adds these counts to the covariates of the same requests.
    pub(super) fn added_to(self, mut covariates: Covariates) -> Covariates {
        covariates.dram.iter_mut().zip(self.dram).for_each(|(covariates, lines)| *covariates += lines);
        covariates.bank = self.bank;
        covariates
    }
}

impl L2Tags {
    /// Empty caches.
    pub(super) fn new(header: &Header, machine: &MachineSpec) -> Self {
        let line = machine.line_bytes.get();
        let caches = || machine.l2.caches().into_iter();
        let bank = |it: &BankedSpec| TimelessCache::new(it.bank_tags(line), it.no_allocate);
        let of_core = || caches().flat_map(|(_, it)| vec![bank(it); it.banks.size()]);
        let banks: Vec<TimelessCache> = (0..machine.cores.size()).flat_map(|_| of_core()).collect();
        let (homes, dynamic_part) = (machine.l2.homes(), Layout::new(header, machine).dynamic_part());
        Self { of_core: banks.len() / machine.cores.size(), banks, homes, dynamic_part }
    }

    /// The contents of the banks.
    pub(super) fn snapshot(&self) -> Arc<Vec<TimelessCache>> {
        Arc::new(self.banks.clone())
    }

    /// Begins a frame: drops the lines of the dynamic part.
    pub(super) fn begin_frame(&mut self) {
        self.banks.iter_mut().for_each(|bank| bank.drop_from(self.dynamic_part));
    }

    /// Performs `requests`.
    pub(super) fn pass(&mut self, requests: &[Request]) -> Moved {
        let (mut dram, mut asked) = (PerClass::<u64>::default(), vec![0; self.banks.len()]);
        for &Request { line, core, class, write } in requests {
            let bank = usize::from(core) * self.of_core + self.homes[class as usize].bank(line);
            asked[bank] += 1;
            let access = if write { Access::Write } else { Access::Read };
            let (hit, victim) = self.banks[bank].pass(line, class, access);
            dram[class as usize] += u64::from(!hit);
            if let Some(victim) = victim {
                dram[victim.class as usize] += 1;
            }
        }
        Moved { dram, bank: asked.into_iter().max().unwrap_or_default() }
    }
}
