//! The L1s on a ray's path other than the traversal unit's: those of its list unit and its intersection unit.

use super::requests::{Requester, Requests};
use crate::machine::kinds::Kind;
use crate::machine::layout::Layout;
use crate::memory::cache::Access;
use crate::memory::timeless::TimelessCache;
use crate::quantity::TriangleSlot;
use crate::stats::TrafficClass;
use crate::stream::{Step, Stop};

pub(super) const KINDS: usize = Kind::ALL.len();

/// The index of the ray's unit of each kind.
pub(super) type Units = [u16; KINDS];

/// The units of a ray, and the requests of their L1s.
pub(super) struct Others<'a> {
    pub layout: &'a Layout,
    pub lists: &'a mut [TimelessCache],
    pub intersection: &'a mut [TimelessCache],
    pub units: Units,
    /// All steps of a path are first counted as visits of the traversal unit.
    pub operations: &'a mut [u64; KINDS],
    pub keeps_triangles: bool,
    pub core: u16,
    pub requests: &'a mut Requests,
}

impl Others<'_> {
    /// A path step that is no node visit.
    #[inline]
    pub(super) fn step(&mut self, word: u32) {
        self.operations[Kind::Traversal as usize] -= 1;
        match Step::unpack(word).expect("packed steps are valid") {
            Step::Triangle { slot, stop } => self.test(slot, stop),
            Step::List(entry) => {
                self.operations[Kind::List as usize] += 1;
                let l1 = &mut self.lists[usize::from(self.units[Kind::List as usize])];
                let requester = reader(Kind::List, self.core, TrafficClass::List);
                self.requests.access_all(l1, requester, self.layout.lines(&self.layout.list_entry(entry)));
            }
            Step::Node(_) | Step::Read { .. } | Step::Write { .. } | Step::Update { .. } => {
                unreachable!("who cuts the stream has checked its chunks")
            }
        }
    }

    /// A triangle test, up to its stop.
    #[inline]
    pub(super) fn test(&mut self, slot: TriangleSlot, stop: Stop) {
        let Self { layout, requests, .. } = self;
        let kind = Kind::Intersection;
        self.operations[kind as usize] += if stop == Stop::Plane { 1 } else { 2 };
        let l1 = &mut self.intersection[usize::from(self.units[kind as usize])];
        let requester = reader(kind, self.core, TrafficClass::Triangle);
        if self.keeps_triangles {
            // `test_lines` has each line once: reading a line again changes nothing.
            requests.access_all(l1, requester, layout.test_lines(slot, stop));
            return;
        }
        requests.access_all(l1, requester, layout.lines(&layout.plane(slot)));
        if stop != Stop::Plane {
            requests.access_all(l1, requester, layout.lines(&layout.edges(slot)));
        }
    }
}

/// A unit of a core that reads.
pub(super) fn reader(kind: Kind, core: u16, class: TrafficClass) -> Requester {
    Requester { kind, core, class, access: Access::Read }
}
