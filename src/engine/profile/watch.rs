//! Receives every access, in the order of the profile level.

use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// A receiver of accesses; `()` ignores them.
pub(crate) trait Watch {
    /// The following L1 accesses are for pool entry `home`, or with `frame_ends` for an end-of-frame step.
    fn entry(&mut self, home: usize, frame_ends: bool) {
        let _ = (home, frame_ends);
    }

    /// Unit `unit`, numbered across all units, accesses its L1.
    fn l1(&mut self, unit: usize, line: LineAddr, class: TrafficClass);

    /// An L1 of core `core` requests a line from its L2, or sends one down.
    fn l2(&mut self, core: usize, line: LineAddr, class: TrafficClass);

    /// A frame begins: lines from `first` on are dropped.
    fn drop_from(&mut self, first: LineAddr);
}

impl Watch for () {
    fn l1(&mut self, _: usize, _: LineAddr, _: TrafficClass) {}

    fn l2(&mut self, _: usize, _: LineAddr, _: TrafficClass) {}

    fn drop_from(&mut self, _: LineAddr) {}
}
