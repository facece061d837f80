//! What L1s ask the L2s for, and what is known by that.

use super::known::Known;
use crate::machine::kinds::Kind;
use crate::memory::cache::Access;
use crate::memory::tags::Victim;
use crate::memory::timeless::TimelessCache;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// What an L1 asks the L2 for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    /// The line.
    pub line: LineAddr,
    /// The core.
    pub core: u16,
    /// What it is for.
    pub class: TrafficClass,
    /// Whether it is written.
    pub write: bool,
}

/// Whose L1 is accessed, and what for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asker {
    /// The unit's kind.
    pub kind: Kind,
    /// Its core.
    pub core: u16,
    /// What it is for.
    pub class: TrafficClass,
    /// How lines are accessed.
    pub access: Access,
}

/// Requests in order, and what is known of what made them.
#[derive(Clone, Debug, Default)]
pub(super) struct Requests {
    /// The requests.
    pub list: Vec<Request>,
    /// What is known; of the L2 nothing yet.
    pub known: Known,
}

impl Requests {
    /// An L1 is accessed. What it has not, or does not keep, is asked for: whether anything is.
    #[inline(always)]
    pub(super) fn access(&mut self, l1: &mut TimelessCache, asker: Asker, line: LineAddr) -> bool {
        let (hit, victim) = l1.pass(line, asker.class, asker.access);
        let asks = !hit || asker.access == Access::WriteThrough;
        if asks {
            self.go_on(asker, line, hit, victim);
        }
        asks
    }

    /// Lines one behind the other are accessed: whether any is asked for.
    #[inline]
    pub(super) fn access_all(&mut self, l1: &mut TimelessCache, asker: Asker, (first, lines): (LineAddr, u64)) -> bool {
        let mut asks = false;
        for place in 0..lines {
            asks |= self.access(l1, asker, LineAddr(first.0 + place));
        }
        asks
    }

    fn go_on(&mut self, asker: Asker, line: LineAddr, hit: bool, victim: Option<Victim>) {
        let Asker { kind, core, class, access } = asker;
        if let Some(Victim { line, class, .. }) = victim {
            self.add(Request { line, core, class, write: true });
        }
        if !hit {
            self.known.missed[kind as usize] += 1;
            self.add(Request { line, core, class, write: false });
        }
        if access == Access::WriteThrough {
            self.add(Request { line, core, class, write: true });
        }
    }

    /// The L2 is asked.
    pub(super) fn add(&mut self, request: Request) {
        self.known.moved[request.class as usize] += 1;
        self.list.push(request);
    }
}
