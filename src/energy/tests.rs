//! Laws of energy.

use super::*;
use crate::memory::dram::currents::DramEnergy;
use crate::quantity::{Bytes, Cycle};
use crate::stats::DramCounts;

fn counted() -> MachineStats {
    let counts = CacheCounts { accesses: 1000, misses: 100, write_backs: 10, ..CacheCounts::default() };
    let cache = |classes: [TrafficClass; 2]| classes.map(|class| (class, CacheStats { counts, l1: None })).into();
    MachineStats {
        cycles: Cycle(50_000),
        clock_mhz: 500.0,
        rays: 2_000,
        caches: [("l2".into(), cache([TrafficClass::Node, TrafficClass::ModeWord]))].into(),
        bytes: [("dram".into(), [(TrafficClass::Node, Bytes(6_400)), (TrafficClass::ModeWord, Bytes(6_400))].into())]
            .into(),
        operations: [("traversal".into(), 40_000), ("shadow_cache".into(), 600)].into(),
        dram: DramCounts { reads: 150, writes: 50, activates: 80, refreshes: 25, ..DramCounts::default() },
        ..MachineStats::default()
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

#[test]
fn energy_is_counts_times_constants() {
    let machine = MachineSpec::default();
    let energy = of(&machine, Structure::Bvh2, &counted()).unwrap();
    let spec = machine.energy;
    assert!(near(energy.by["traversal"], 40_000.0 * spec.bvh2_node.typical * PICO));
    assert!(near(energy.by["shadow_cache"], 600.0 * spec.shadow_cache.typical * PICO));
    assert!(near(energy.by["dispatcher"], 2_000.0 * spec.dispatcher.typical * PICO));
    let (_, l2) = machine.l2.caches()[0].clone();
    let access = spec.cache.access(l2.bytes.get() / l2.banks.get(), l2.ways.get(), machine.line_bytes.get());
    assert!(near(energy.by["l2"], 2.0 * 1110.0 * access.typical * PICO));
    assert!(near(energy.classes[&TrafficClass::Node], energy.classes[&TrafficClass::ModeWord]));
    let leaks = leakage(&machine).typical * 1e-3 * 50_000.0 / 500e6;
    assert!(near(energy.by["leakage"], leaks));
    assert!(near(energy.by.values().sum(), energy.joules));
}

#[test]
fn energy_grows_with_every_count_and_with_time() {
    let machine = MachineSpec::default();
    let joules = |stats: &MachineStats| of(&machine, Structure::Bvh2, stats).unwrap().joules;
    let base = counted();
    let mut more = base.clone();
    more.add(&base);
    assert!(near(joules(&more), 2.0 * joules(&base)), "energy adds up over frames");
    for dram in [
        DramCounts { activates: 81, ..base.dram },
        DramCounts { reads: 151, ..base.dram },
        DramCounts { writes: 51, ..base.dram },
        DramCounts { refreshes: 26, ..base.dram },
    ] {
        assert!(joules(&MachineStats { dram, ..base.clone() }) > joules(&base));
    }
    assert!(joules(&MachineStats { cycles: Cycle(50_001), ..base.clone() }) > joules(&base));
}

#[test]
fn nothing_is_told_where_the_dram_says_nothing() {
    let mut machine = MachineSpec::default();
    machine.dram.part.energy = None;
    assert_eq!(of(&machine, Structure::Bvh2, &counted()), None);
    machine.dram.part.energy = Some(DramEnergy::PerBit { pj: Spread::new(11.0, 14.0, 17.0) });
    let energy = of(&machine, Structure::Bvh2, &counted()).unwrap();
    assert!(near(energy.by["dram_transfer"], 200.0 * 64.0 * 8.0 * 14.0 * PICO));
}
