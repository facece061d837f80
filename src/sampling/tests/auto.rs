//! `Auto`: a sample where that pays, `Event` on everything where it does not.

use super::super::auto::auto;
use super::*;
use crate::stats::{Choice, Why};

fn alone(machine: &MachineSpec, cut: Cut, target: &str) -> MachineStats {
    let (header, stream) = quickstart();
    let mut verdicts = auto(&[machine], None, cut, target.parse().unwrap(), &header, &stream).unwrap();
    verdicts.remove(0).unwrap().stats(machine, &header, &stream).unwrap()
}

fn on_quickstart(machine: &MachineSpec, target: &str) -> (MachineStats, MachineStats) {
    let (header, stream) = quickstart();
    let found = alone(machine, Cut::new(machine), target);
    (found, on(machine, &header, "Event", &stream))
}

/// 4 windows of `desktop` and 18 of `small` are too few to sample: the result is that of `Event`, and `choice` says so.
#[test]
fn a_short_stream_is_replayed_whole() {
    for (name, target, of) in [("desktop", "0.05", 4), ("small", "0.01", 18)] {
        let (found, event) = on_quickstart(&shipped(name), target);
        let Choice { windows, cost, why, .. } = found.choice.unwrap();
        assert_eq!((windows, cost, why), (0, 1.0, Why::Short), "{name}");
        assert_eq!(found.choice.unwrap().of, of, "{name}");
        assert_eq!(MachineStats { choice: None, ..found }, event, "{name}");
    }
}

/// Windows are few and small here, and the target is wide: a sample takes less time, and its errors are within it.
#[test]
fn a_sample_is_as_close_as_was_asked_and_says_what_it_took() {
    let (header, stream) = quickstart();
    let mut machine = shipped("small");
    machine.dispatcher.rays = num(16);
    let cut = Cut { pixels: 16, before: 2, own: 2, behind: 1 };
    let found = alone(&machine, cut, "0.1");
    let event = on(&machine, &header, "Event", &stream);
    let choice = found.choice.unwrap();
    println!("{choice:?} {:?}", found.accuracy);
    assert_eq!(choice.why, Why::Sampled);
    assert!(choice.cost < 1.0 && choice.windows < choice.of / 2, "{choice:?}");
    assert!(found.accuracy.widest().is_some_and(|widest| widest <= 0.1), "{:?}", found.accuracy);
    let apart = |a: u64, b: u64| (a as f64 / b as f64 - 1.0).abs();
    assert!(apart(found.cycles.0, event.cycles.0) <= 0.1, "{} {}", found.cycles, event.cycles);
    assert!(apart(found.moved("dram").0, event.moved("dram").0) <= 0.1);
    assert_eq!(found.residuals.unwrap().windows(), choice.windows);
}
