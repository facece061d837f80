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

/// What a unit accesses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// The line.
    pub line: LineAddr,
    /// What it is for.
    pub class: TrafficClass,
    /// How it is accessed.
    pub access: Access,
}

/// Whose L1 it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asker {
    /// The unit's kind.
    pub kind: Kind,
    /// Its core.
    pub core: u16,
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
    /// An L1 is accessed. What it has not, or does not keep, is asked for.
    #[inline(always)]
    pub(super) fn access(&mut self, l1: &mut TimelessCache, asker: Asker, wanted: Wanted) {
        let (hit, victim) = l1.pass(wanted.line, wanted.class, wanted.access);
        if !hit || wanted.access == Access::WriteThrough {
            self.go_on(asker, wanted, hit, victim);
        }
    }

    fn go_on(&mut self, asker: Asker, wanted: Wanted, hit: bool, victim: Option<Victim>) {
        let Wanted { line, class, access } = wanted;
        if let Some(Victim { line, class, .. }) = victim {
            self.add(Request { line, core: asker.core, class, write: true });
        }
        if !hit {
            self.known.missed[asker.kind as usize] += 1;
            self.add(Request { line, core: asker.core, class, write: false });
        }
        if access == Access::WriteThrough {
            self.add(Request { line, core: asker.core, class, write: true });
        }
    }

    /// The L2 is asked.
    pub(super) fn add(&mut self, request: Request) {
        self.known.moved[request.class as usize] += 1;
        self.list.push(request);
    }
}
