//! Who is told of every access, in the order of the profile rung.

use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// Is told of accesses. Nobody is `()`.
pub(crate) trait Watch {
    /// Entry `home` of the pool makes the accesses to L1s that follow: for a ray, or for a step of a frame's end.
    fn entry(&mut self, home: usize, frame_ends: bool) {
        let _ = (home, frame_ends);
    }

    /// Unit `unit` of all accesses its L1.
    fn l1(&mut self, unit: usize, line: LineAddr, class: TrafficClass);

    /// An L1 of core `core` asks its L2 for a line, or sends one down.
    fn l2(&mut self, core: usize, line: LineAddr, class: TrafficClass);

    /// A frame begins: lines from `first` on go.
    fn drop_from(&mut self, first: LineAddr);
}

impl Watch for () {
    fn l1(&mut self, _: usize, _: LineAddr, _: TrafficClass) {}

    fn l2(&mut self, _: usize, _: LineAddr, _: TrafficClass) {}

    fn drop_from(&mut self, _: LineAddr) {}
}
