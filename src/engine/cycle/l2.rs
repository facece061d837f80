//! A bank of the L2.

use std::collections::VecDeque;

use super::cache::{Cache, LineAccess, Lookup};
use super::request::{DramRequest, Request};
use super::wires::Wires;
use crate::memory::bank::BankedSpec;
use crate::memory::dram::spec::DramSpec;
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{CacheCounts, TrafficClass};

pub(super) struct Bank {
    index: usize,
    spec: BankedSpec,
    dram: DramSpec,
    line: u64,
    /// Target of a waiting access: the L1 that gets the line, `None` for a write.
    cache: Cache<Option<usize>>,
    answers: VecDeque<(u64, usize, LineAddr)>,
    out: VecDeque<Request>,
    pub moved: [Bytes; TrafficClass::ALL.len()],
    pub reads: [u64; TrafficClass::ALL.len()],
    pub missed: [u64; TrafficClass::ALL.len()],
}

impl Bank {
    pub(super) fn new(spec: &BankedSpec, dram: &DramSpec, index: usize, line: u64) -> Self {
        Self {
            index,
            spec: *spec,
            dram: dram.clone(),
            line,
            cache: Cache::new(spec.bank_tags(line), spec.no_allocate, spec.mshrs.size(), spec.targets.size()),
            answers: VecDeque::new(),
            out: VecDeque::new(),
            moved: Default::default(),
            reads: Default::default(),
            missed: Default::default(),
        }
    }

    fn out_has_room(&self) -> bool {
        self.out.len() < self.spec.queue.size()
    }

    pub(super) fn tick(&mut self, now: u64, wires: &mut Wires) {
        while let Some(&(at, to, line)) = self.answers.front()
            && at <= now
        {
            self.answers.pop_front();
            wires.to_l1[to].put(now, line);
        }
        self.fill(now, wires);
        self.access(now, wires);
        self.send(now, wires);
    }

    fn fill(&mut self, now: u64, wires: &mut Wires) {
        let Some(&line) = wires.from_dram[self.index].first(now) else { return };
        let Some(filled) = self.cache.fill(line, self.out_has_room()) else { return };
        wires.from_dram[self.index].take(now);
        if let Some(victim) = filled.dirty_victim {
            let bytes = Bytes(self.line);
            self.out.push_back(Request {
                line: victim.line,
                class: victim.class,
                write: true,
                bytes,
                from: self.index,
            });
        }
        for reader in filled.waited.into_iter().flatten() {
            self.answers.push_back((now + self.spec.latency.get(), reader, line));
        }
    }

    fn access(&mut self, now: u64, wires: &mut Wires) {
        let Some(&Request { line, class, write, bytes, from }) = wires.to_bank[self.index].first(now) else { return };
        let asked = LineAccess { line, class, write, dirties: write, needs_data: !write };
        let met = self.cache.access(asked, self.out_has_room(), (!write).then_some(from));
        match met {
            Lookup::Stop => return,
            Lookup::Hit if write => {}
            Lookup::Hit => self.answers.push_back((now + self.spec.latency.get(), from, line)),
            Lookup::MshrHit => {}
            Lookup::Miss | Lookup::WriteAround => {
                let (bytes, write) = (Bytes(self.line), met == Lookup::WriteAround);
                self.out.push_back(Request { line, class, write, bytes, from: self.index });
            }
        }
        wires.to_bank[self.index].take(now);
        self.moved[class as usize] += bytes;
        if !write {
            self.reads[class as usize] += 1;
            self.missed[class as usize] += u64::from(met == Lookup::Miss);
        }
    }

    fn send(&mut self, now: u64, wires: &mut Wires) {
        let Some(&request) = self.out.front() else { return };
        let place = self.dram.place(request.line);
        let channel = &mut wires.to_channel[place.channel];
        if channel.has_room() {
            channel.put(now, DramRequest { request, place, activated: false, precharged: false, bursts_done: 0 });
            self.out.pop_front();
        }
    }

    pub(super) fn drop_from(&mut self, first: LineAddr) {
        self.cache.drop_from(first);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.answers.is_empty() && self.out.is_empty() && self.cache.on_their_way() == 0
    }

    /// Misses under way.
    pub(super) fn misses_under_way(&self) -> usize {
        self.cache.on_their_way()
    }

    pub(super) fn counts(&self) -> &[CacheCounts; TrafficClass::ALL.len()] {
        &self.cache.counts
    }

    pub(super) fn queues(&self, wires: &Wires) -> String {
        format!(
            "requests {}/{}, misses under way {}, fills {}, answers {}, out {}",
            wires.to_bank[self.index].len(),
            self.spec.queue,
            self.cache.on_their_way(),
            wires.from_dram[self.index].len(),
            self.answers.len(),
            self.out.len()
        )
    }
}
