//! Estimates against replays: what is known exactly, and how far the rest is off.

use super::pass::{Demand, demand};
use crate::engine::items::Source;
use crate::engine::tests::recorded::{on, quickstart, shipped};
use crate::machine::MachineSpec;
use crate::ranged::{Size, Within};
use crate::stream::{Header, Item};

fn known(machine: &MachineSpec, header: &Header, stream: &[Item]) -> Demand {
    let source: &dyn Source = &stream.to_vec();
    demand(machine, header, source).unwrap()
}

/// `machine` with L1s of so many times the bytes.
fn grown(machine: &MachineSpec, times: u64) -> MachineSpec {
    let mut grown = machine.clone();
    grown.traversal.cache.bytes = Size::new(times * grown.traversal.cache.bytes.get()).unwrap();
    grown.intersection.cache.bytes = Size::new(times * grown.intersection.cache.bytes.get()).unwrap();
    grown
}

fn close(found: f64, is: f64, tolerance: f64, what: &str) {
    assert!((found / is - 1.0).abs() < tolerance, "{what}: {found} for {is}");
}

/// The machine of the pass was measured: an estimate of it gives back what was counted.
#[test]
fn bytes_of_the_machine_of_the_pass_are_those_counted() {
    let (header, stream) = quickstart();
    for name in ["small", "desktop", "mobile"] {
        let machine = shipped(name);
        let profile = on(&machine, &header, "Profile", &stream);
        let estimate = known(&machine, &header, &stream).estimate(&machine);
        close(estimate.dram_bytes, profile.moved("dram").0 as f64, 1e-3, name);
    }
}

/// What a change of the machine does to the cycles; DRAM bytes are within 3 % (L1s: 2.1). The estimate itself is low,
/// 0.49 to 0.76 of `Event`'s: waiting for each other is left out of it.
#[test]
fn what_a_change_does_is_told_within_a_seventh() {
    let (header, stream) = quickstart();
    let base = shipped("small");
    let known = known(&base, &header, &stream);
    let mut units = base.clone();
    units.traversal.count = Within::new(2 * base.traversal.count.get()).unwrap();
    let mut pool = base.clone();
    pool.dispatcher.rays = Within::new(base.dispatcher.rays.get() / 2).unwrap();
    let [was, lines] = [known.estimate(&base).cycles, on(&base, &header, "Event", &stream).cycles.0 as f64];
    for (machine, what) in [(grown(&base, 4), "L1s"), (units, "units"), (pool, "pool")] {
        let event = on(&machine, &header, "Event", &stream);
        let estimate = known.estimate(&machine);
        close(estimate.cycles / was, event.cycles.0 as f64 / lines, 1.0 / 7.0, what);
        close(estimate.dram_bytes, event.moved("dram").0 as f64, 0.03, what);
    }
}

/// LRU caches of one set hold what smaller ones hold (Mattson et al. 1970), and so do their estimates.
#[test]
fn larger_caches_never_move_more() {
    let (header, stream) = quickstart();
    let base = shipped("small");
    let known = known(&base, &header, &stream);
    let bytes: Vec<f64> = [1, 2, 4, 8, 16]
        .map(|times| known.estimate(&grown(&base, times)).resources)
        .into_iter()
        .map(|resources| resources[resources.len() - 3])
        .collect();
    assert!(bytes.is_sorted_by(|smaller, larger| larger <= smaller), "asked of the L2: {bytes:?}");
    assert!(bytes[4] < 0.9 * bytes[0], "L1s of 16 times the bytes save a tenth: {bytes:?}");
}
