//! A cache of the L2, shared by all L1s, and its banks.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::allocation::NoAllocate;
use super::cache::{Access, Cache, Fill, Lookup, check_geometry};
use super::dram::Dram;
use super::mshr::MshrFile;
use super::queue::{Load, Queue};
use super::replacement::Policy;
use super::ring::Ring;
use super::tags::{Contents, TagArray};
use super::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::ranged::{PowerOfTwo, Size, Within};
use crate::stats::TrafficClass;

/// A banked L2 cache.
///
/// Source: the T&I engine's traversal L2 (Nah et al. 2011, section 5: 128 KB, 2 ways, 8 banks, 20 cycles); MSHRs and
/// queues are assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BankedSpec {
    /// What the cache holds.
    pub contents: Contents,
    /// Size in bytes, all banks together.
    pub bytes: Size<32, 0x1_0000_0000>,
    /// Lines per set.
    pub ways: Within<1, 64>,
    /// Number of banks.
    pub banks: PowerOfTwo<1, 256>,
    /// Which line of a full set is evicted.
    pub replacement: Policy,
    /// Accesses that do not allocate a line: they bypass the L2, to and from the DRAM.
    pub no_allocate: NoAllocate,
    /// Cycles from a hit or a fill to the answer.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 1000>,
    /// MSHRs per bank.
    pub mshrs: Within<1, 1024>,
    /// Accesses that can wait in one MSHR.
    pub targets: Within<1, 1024>,
    /// Places of each bank's request queue, and of its out queue to the DRAM.
    pub queue: Within<1, 1024>,
}

impl BankedSpec {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        contents: Contents::Tags,
        bytes: Size::literal(128 << 10),
        ways: Within::literal(2),
        banks: PowerOfTwo::literal(8),
        replacement: Policy::Lru,
        no_allocate: NoAllocate::NONE,
        latency: Within::literal(20),
        mshrs: Within::literal(8),
        targets: Within::literal(4),
        queue: Within::literal(8),
    };

    /// Checks what single fields cannot: `field` names the spec in errors, `line` is the line size in bytes.
    pub fn check(&self, field: &str, line: u64) -> Result<(), String> {
        let Self { contents, bytes, ways, banks, replacement, .. } = self;
        match contents {
            Contents::Tags => check_geometry(field, bytes.get(), ways.get(), banks.get(), line, *replacement),
            Contents::Ideal => Ok(()),
        }
    }

    /// The empty tags of a bank.
    pub fn bank_tags(&self, line: u64) -> TagArray {
        let Self { ways, banks, replacement, .. } = self;
        let sets = || self.bytes.get() / (line * ways.get() * banks.get());
        match self.contents {
            Contents::Tags => TagArray::new(sets() as usize, ways.size(), banks.get().ilog2(), *replacement),
            Contents::Ideal => TagArray::ideal(),
        }
    }

    /// An empty bank with the number `part` in the machine.
    pub(super) fn bank(&self, part: PartId, line: u64) -> Bank {
        let registers = MshrFile::new(self.mshrs.size(), self.targets.size());
        Bank {
            part,
            cache: Cache::new(self.bank_tags(line), self.no_allocate, registers),
            requests: Queue::new(self.queue.size()),
            fills: Ring::new(),
            out: Ring::new(),
            out_places: self.queue.size(),
            latency: self.latency.get(),
            line: Bytes(line),
            served: Served::default(),
            waiting: Vec::new(),
        }
    }
}

impl Default for BankedSpec {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What a bank served to L1s, per class in the order of [`TrafficClass::ALL`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// Bytes moved between L1s and the bank.
    pub moved: [Bytes; TrafficClass::ALL.len()],
    /// Reads.
    pub reads: [u64; TrafficClass::ALL.len()],
    /// Reads that missed.
    pub missed: [u64; TrafficClass::ALL.len()],
    /// Attributed misses among `missed`; only engines that replay samples use them.
    pub attributed: [u64; TrafficClass::ALL.len()],
}

impl Served {
    /// Counts a read of `bytes` bytes; `attributed` says whether its miss is attributed.
    pub fn read(&mut self, class: TrafficClass, bytes: Bytes, missed: bool, attributed: bool) {
        let class = class as usize;
        self.moved[class] += bytes;
        self.reads[class] += 1;
        self.missed[class] += u64::from(missed);
        self.attributed[class] += u64::from(missed && attributed);
    }

    /// Counts a write of `bytes` bytes.
    pub fn write(&mut self, class: TrafficClass, bytes: Bytes) {
        self.moved[class as usize] += bytes;
    }
}

/// A bank of the L2.
#[derive(Clone, Debug)]
pub struct Bank {
    part: PartId,
    cache: Cache,
    requests: Queue<Request>,
    /// Lines from the DRAM, each with the cycle from which it is available.
    fills: Ring<(u64, LineAddr)>,
    out: Ring<Request>,
    out_places: usize,
    latency: u64,
    line: Bytes,
    served: Served,
    waiting: Vec<u32>,
}

impl Bank {
    /// Load of the request queue.
    pub fn load(&self) -> Load {
        self.requests.load()
    }

    /// Loads the contents of `tags`.
    pub fn hold(&mut self, tags: &TagArray) {
        self.cache.hold(tags);
    }

    /// Puts a request into the queue in cycle `now`. Without a place, it returns false and wakes the requester later.
    pub fn put(&mut self, request: Request, now: u64, wake: &mut impl Wake) -> bool {
        if !self.requests.has_room(now) {
            self.requests.wait_for_room(request.from, now, wake);
            return false;
        }
        self.requests.put(request, now + 1);
        wake.wake(self.part, now + 1);
        true
    }

    /// A line from the DRAM is available from cycle `at` on.
    pub fn deliver(&mut self, line: LineAddr, at: u64) {
        self.fills.push_back((at, line));
    }

    /// Simulates cycle `now`. `answer(l1, line, at)` sends a line to an L1, available from cycle `at` on.
    pub fn tick(
        &mut self,
        now: u64,
        dram: &mut Dram,
        wake: &mut impl Wake,
        mut answer: impl FnMut(PartId, LineAddr, u64),
    ) {
        let there_at = now + self.latency + 1;
        let mut answer = |to: PartId, line, wake: &mut _| {
            answer(to, line, there_at);
            Wake::wake(wake, to, there_at);
        };
        let filled = self.fill(now, wake, &mut answer);
        let accessed = self.access(now, wake, &mut answer);
        let sent = self.send(now, dram, wake);
        // A fill frees an MSHR; a sent request frees a place. An access can change which line is the next victim, to a
        // clean one. Each of these can unblock a stalled part.
        let stalled_may_go_on =
            (filled || sent) && !self.requests.is_empty() || (sent || accessed) && !self.fills.is_empty();
        let more = sent && !self.out.is_empty() || accessed && !self.requests.is_empty();
        if more || stalled_may_go_on || filled && !self.fills.is_empty() {
            return wake.wake(self.part, now + 1);
        }
        let stamps = [self.fills.front().map(|fill| fill.0), self.requests.next_at()];
        if let Some(at) = stamps.into_iter().flatten().filter(|&at| at > now).min() {
            wake.wake(self.part, at);
        }
    }

    fn fill<W: Wake>(&mut self, now: u64, wake: &mut W, answer: &mut impl FnMut(PartId, LineAddr, &mut W)) -> bool {
        let Some(&(_, line)) = self.fills.front().filter(|&&(at, _)| at <= now) else { return false };
        self.waiting.clear();
        let Fill::Done { victim } = self.cache.fill(line, self.out.len() < self.out_places, &mut self.waiting) else {
            return false;
        };
        self.fills.drop_front();
        if let Some(victim) = victim {
            self.push_out(victim.line, victim.class, true);
        }
        self.waiting.iter().for_each(|&reader| answer(PartId(reader), line, wake));
        true
    }

    fn access<W: Wake>(&mut self, now: u64, wake: &mut W, answer: &mut impl FnMut(PartId, LineAddr, &mut W)) -> bool {
        let Some(request) = self.requests.first(now) else { return false };
        let Request { line, class, write, bytes, from, attributed } = request;
        let (access, reader) = if write { (Access::Write, None) } else { (Access::Read, Some(from.0)) };
        let lookup = self.cache.access(line, class, access, reader, self.out.len() < self.out_places);
        match lookup {
            Lookup::Stalled => return false,
            Lookup::Hit if !write => answer(from, line, wake),
            Lookup::Hit | Lookup::Merged => {}
            Lookup::Miss => self.push_out(line, class, false),
            Lookup::WriteAround => self.push_out(line, class, true),
        }
        self.requests.take(now, wake);
        if write {
            self.served.write(class, bytes);
        } else {
            self.served.read(class, bytes, lookup == Lookup::Miss, attributed);
        }
        true
    }

    fn push_out(&mut self, line: LineAddr, class: TrafficClass, write: bool) {
        self.out.push_back(Request { line, class, write, bytes: self.line, from: self.part, attributed: false });
    }

    fn send(&mut self, now: u64, dram: &mut Dram, wake: &mut impl Wake) -> bool {
        let Some(&request) = self.out.front() else { return false };
        let sent = dram.put(request, now, wake);
        if sent {
            self.out.drop_front();
        }
        sent
    }

    /// Drops all lines from `first` on.
    pub fn drop_from(&mut self, first: LineAddr) {
        self.cache.drop_from(first);
    }

    /// Whether no work is pending.
    pub fn is_idle(&self) -> bool {
        self.requests.is_empty() && self.fills.is_empty() && self.out.is_empty() && self.cache.misses_under_way() == 0
    }

    /// Tags, MSHRs and counts.
    pub fn cache(&self) -> &Cache {
        &self.cache
    }

    /// Requests in the queue.
    pub fn waiting(&self) -> usize {
        self.requests.len()
    }

    /// Counts of the requests served to L1s.
    pub fn served(&self) -> &Served {
        &self.served
    }

    /// The state of the queues, for the report of a deadlock.
    pub fn queues(&self) -> String {
        format!(
            "requests {}/{}, misses under way {}, fills {}, out {}/{}",
            self.requests.len(),
            self.requests.capacity(),
            self.cache.misses_under_way(),
            self.fills.len(),
            self.out.len(),
            self.out_places
        )
    }
}
