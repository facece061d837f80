//! The host's own traffic in samples: its lines are known for all windows, and building is replayed.

use crate::engine::tests::num;
use crate::engine::tests::recorded::{on, quickstart, shipped};
use crate::machine::traffic::{Build, RayBuffer, TrafficSpec};
use crate::ranged::Size;
use crate::stats::{MachineStats, TrafficClass};

#[test]
fn a_sample_knows_what_the_host_moves() {
    let (header, stream) = quickstart();
    let mut machine = shipped("small");
    machine.traffic = TrafficSpec {
        rays: RayBuffer::Dram,
        pixel_bytes: Size::literal(4),
        texture_bytes: Size::literal(16),
        build: Build::Written,
        build_rate: num(1),
        ..machine.traffic
    };
    let [whole, sampled] =
        ["Event", "Sampled(engine: Event, rate: 0.5)"].map(|rung| on(&machine, &header, rung, &stream));
    let of = |stats: &MachineStats, class| stats.bytes["dram"].get(&class).map_or(0, |bytes| bytes.0);
    assert_eq!(of(&sampled, TrafficClass::Build), of(&whole, TrafficClass::Build));
    assert!(of(&whole, TrafficClass::Build) > 0);
    for class in [TrafficClass::Ray, TrafficClass::FrameBuffer, TrafficClass::Texture] {
        let (whole, sampled) = (of(&whole, class) as f64, of(&sampled, class) as f64);
        assert!(whole > 0.0 && (sampled / whole - 1.0).abs() < 0.001, "{class:?}: {sampled} {whole}");
    }
    let cycles = sampled.cycles.0 as f64 / whole.cycles.0 as f64;
    assert!((cycles - 1.0).abs() < 0.05, "{cycles}");
}
