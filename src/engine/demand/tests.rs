//! Estimates compared with replays: exact quantities, and the error of the others.

use super::estimate::Estimate;
use super::pass::estimates;
use crate::engine::items::Source;
use crate::engine::tests::recorded::{on, quickstart, shipped};
use crate::machine::MachineSpec;
use crate::memory::l2::L2Spec;
use crate::ranged::{Size, Within};
use crate::stream::{Header, Item};

fn known<const N: usize>(
    reference: &MachineSpec,
    machines: &[MachineSpec; N],
    header: &Header,
    stream: &[Item],
) -> [Estimate; N] {
    let source: &dyn Source = &stream.to_vec();
    estimates(reference, header, source, machines).unwrap().try_into().unwrap()
}

/// `machine` with L1s of `times` times the bytes.
fn grown(machine: &MachineSpec, times: u64) -> MachineSpec {
    let mut grown = machine.clone();
    grown.traversal.cache.bytes = Size::new(times * grown.traversal.cache.bytes.get()).unwrap();
    grown.intersection.cache.bytes = Size::new(times * grown.intersection.cache.bytes.get()).unwrap();
    grown
}

fn close(found: f64, is: f64, tolerance: f64, what: &str) {
    assert!((found / is - 1.0).abs() < tolerance, "{what}: {found} for {is}");
}

/// The pass measures its own machine: the estimate of it returns the counted bytes.
#[test]
fn bytes_of_the_machine_of_the_pass_are_those_counted() {
    let (header, stream) = quickstart();
    for name in ["small", "desktop", "mobile"] {
        let machine = shipped(name);
        let profile = on(&machine, &header, "Profile", &stream);
        let [estimate] = known(&machine, std::array::from_ref(&machine), &header, &stream);
        close(estimate.dram_bytes, profile.moved("dram").0 as f64, 1e-3, name);
    }
}

/// The effect of a change on the cycles; DRAM bytes are within 3 %. The estimate itself is low, 0.49 to 0.76 of
/// `Event`'s cycles: it omits waiting between resources.
#[test]
fn what_a_change_does_is_told_within_a_seventh() {
    let (header, stream) = quickstart();
    let base = shipped("small");
    let mut units = base.clone();
    units.traversal.count = Within::new(2 * base.traversal.count.get()).unwrap();
    let mut pool = base.clone();
    pool.dispatcher.rays = Within::new(base.dispatcher.rays.get() / 2).unwrap();
    let machines = [base.clone(), grown(&base, 4), units, pool];
    let [was, estimates @ ..] = known(&base, &machines, &header, &stream);
    let lines = on(&base, &header, "Event", &stream).cycles.0 as f64;
    for ((machine, estimate), what) in machines[1..].iter().zip(&estimates).zip(["L1s", "units", "pool"]) {
        let event = on(machine, &header, "Event", &stream);
        close(estimate.cycles / was.cycles, event.cycles.0 as f64 / lines, 1.0 / 7.0, what);
        close(estimate.dram_bytes, event.moved("dram").0 as f64, 0.03, what);
    }
}

/// A small L2 sees only the misses of the L1s. L1s as large as the L2 leave it other lines to hold. Without that
/// effect, the estimate of this L2's misses is 1.7 times the actual number.
#[test]
fn an_l2_below_large_l1s_is_told_within_a_tenth() {
    let (header, stream) = quickstart();
    let base = shipped("small");
    let mut small = grown(&base, 2);
    let L2Spec::Unified(l2) = &mut small.l2 else { panic!("`small` has one L2") };
    l2.bytes = Size::new(32768).unwrap();
    let [estimate] = known(&base, std::array::from_ref(&small), &header, &stream);
    let event = on(&small, &header, "Event", &stream);
    close(estimate.dram_bytes, event.moved("dram").0 as f64, 0.1, "DRAM bytes");
}

/// Machines that share a pass get the same estimates as alone.
#[test]
fn machines_share_a_pass() {
    let (header, stream) = quickstart();
    let base = shipped("small");
    let machines = [grown(&base, 2), base.clone(), grown(&base, 4)];
    let together = known(&base, &machines, &header, &stream);
    for (machine, estimate) in machines.iter().zip(&together) {
        let [alone] = known(&base, std::array::from_ref(machine), &header, &stream);
        assert_eq!(alone, *estimate);
    }
}

/// Larger caches miss less.
#[test]
fn larger_caches_miss_less() {
    let (header, stream) = quickstart();
    let base = shipped("small");
    let machines = [1, 2, 4, 8, 16].map(|times| grown(&base, times));
    // The last four resources: requests to the L2, its misses, the bus, and end-of-frame updates.
    let asked = known(&base, &machines, &header, &stream).map(|it| it.resources[it.resources.len() - 4]);
    assert!(asked.is_sorted_by(|smaller, larger| larger <= smaller), "asked of the L2: {asked:?}");
    assert!(asked[4] < 0.9 * asked[0], "L1s of 16 times the bytes save a tenth: {asked:?}");
}
