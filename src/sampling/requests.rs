//! Requests of L1s to the L2s, and the covariates that follow from them.

use super::covariates::Covariates;
use crate::machine::kinds::Kind;
use crate::memory::cache::Access;
use crate::memory::tags::Victim;
use crate::memory::timeless::TimelessCache;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// A request of an L1 to the L2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    /// The line.
    pub line: LineAddr,
    /// The core.
    pub core: u16,
    /// The class of its traffic.
    pub class: TrafficClass,
    /// Whether it is a write.
    pub write: bool,
}

/// The accessing unit, and the kind of access.
#[derive(Clone, Copy, Debug)]
pub(super) struct Requester {
    /// The unit's kind.
    pub kind: Kind,
    /// The unit's core.
    pub core: u16,
    /// The class of the traffic.
    pub class: TrafficClass,
    /// The kind of access.
    pub access: Access,
}

/// Requests in order, with the covariates of the accesses behind them.
#[derive(Clone, Debug, Default)]
pub(super) struct Requests {
    /// The requests.
    pub list: Vec<Request>,
    /// The covariates, without those of the L2.
    pub covariates: Covariates,
}

impl Requests {
    /// Accesses a line of an L1. Returns whether the L2 is asked: at a miss, or for a write-through.
    #[inline(always)]
    pub(super) fn access(&mut self, l1: &mut TimelessCache, requester: Requester, line: LineAddr) -> bool {
        let (hit, victim) = l1.pass(line, requester.class, requester.access);
        let asks = !hit || requester.access == Access::WriteThrough;
        if asks {
            self.go_on(requester, line, hit, victim);
        }
        asks
    }

    /// Accesses `lines` consecutive lines. Returns whether the L2 is asked for any.
    #[inline]
    pub(super) fn access_all(
        &mut self,
        l1: &mut TimelessCache,
        requester: Requester,
        (first, lines): (LineAddr, u64),
    ) -> bool {
        let mut asks = false;
        for place in 0..lines {
            asks |= self.access(l1, requester, LineAddr(first.0 + place));
        }
        asks
    }

    fn go_on(&mut self, requester: Requester, line: LineAddr, hit: bool, victim: Option<Victim>) {
        let Requester { kind, core, class, access } = requester;
        if let Some(Victim { line, class, .. }) = victim {
            self.add(Request { line, core, class, write: true });
        }
        if !hit {
            self.covariates.missed[kind as usize] += 1;
            self.add(Request { line, core, class, write: false });
        }
        if access == Access::WriteThrough {
            self.add(Request { line, core, class, write: true });
        }
    }

    /// Adds a request to the L2.
    pub(super) fn add(&mut self, request: Request) {
        self.covariates.moved[request.class as usize] += 1;
        self.list.push(request);
    }
}
