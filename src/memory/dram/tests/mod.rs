mod channel;
mod legality;
mod stream;

use super::part::Timing;
use super::spec::DramSpec;
use crate::memory::{PartId, Wake};
use crate::ranged::Within;

/// A no-op scheduler: these tests act in every cycle.
struct Awake;

impl Wake for Awake {
    fn wake(&mut self, _: PartId, _: u64) {}
}

/// All timing parameters except tREFI.
const NAMES: [&str; 17] = [
    "cl", "cwl", "rcd", "rp", "ras", "rc", "ccd_s", "ccd_l", "rrd_s", "rrd_l", "faw", "rtp", "wr", "wtr_s", "wtr_l",
    "turn", "rfc",
];

fn num<const LO: u64, const HI: u64>(value: u64) -> Within<LO, HI> {
    Within::new(value).unwrap()
}

fn set(timing: &mut Timing, name: &str, clocks: u64) {
    match name {
        "cl" => timing.cl = num(clocks),
        "cwl" => timing.cwl = num(clocks),
        "rcd" => timing.rcd = num(clocks),
        "rp" => timing.rp = num(clocks),
        "ras" => timing.ras = num(clocks),
        "rc" => timing.rc = num(clocks),
        "ccd_s" => timing.ccd_s = num(clocks),
        "ccd_l" => timing.ccd_l = num(clocks),
        "rrd_s" => timing.rrd_s = num(clocks),
        "rrd_l" => timing.rrd_l = num(clocks),
        "faw" => timing.faw = num(clocks),
        "rtp" => timing.rtp = num(clocks),
        "wr" => timing.wr = num(clocks),
        "wtr_s" => timing.wtr_s = num(clocks),
        "wtr_l" => timing.wtr_l = num(clocks),
        "turn" => timing.turn = num(clocks),
        "refi" => timing.refi = num(clocks),
        "rfc" => timing.rfc = num(clocks),
        other => panic!("{other}"),
    }
}

/// The default DRAM with changed timing parameters.
fn with(changes: &[(&str, u64)]) -> DramSpec {
    let mut spec = DramSpec::default();
    changes.iter().for_each(|(name, clocks)| set(&mut spec.part.timing, name, *clocks));
    spec
}
