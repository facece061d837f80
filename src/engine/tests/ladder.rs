//! The rungs below the engines: what they must share with them on any machine, and how far they are off on a recorded stream.

use std::path::Path;

use super::random::{machines, streams};
use super::synthetic::header;
use super::*;
use crate::engine::sampling::estimate::{Population, Total, Window, estimate};
use crate::machine::shadow_cache::{FrameEnd, Place};
use crate::memory::tags::Contents;
use crate::ron_file;
use crate::stats::Accuracy;
use crate::stream::StreamReader;

use super::agreement::check_many;

fn on(machine: &MachineSpec, header: &Header, fidelity: &str, stream: &[Item]) -> MachineStats {
    let fidelity = fidelity.parse().unwrap();
    run(machine, fidelity, header, items(stream.to_vec())).unwrap_or_else(|error| panic!("{fidelity}: {error}"))
}

fn quickstart() -> (Header, Vec<Item>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/quickstart.rays");
    let reader = StreamReader::open(&file).unwrap();
    let header = reader.header().clone();
    (header, reader.collect::<Result<_, _>>().unwrap())
}

fn shipped(name: &str) -> MachineSpec {
    ron_file::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("configs/machines/{name}.ron"))).unwrap()
}

/// What does not hang on time: rays, operations, accesses, bytes asked for. The run itself checks counts, conservation and bounds.
#[test]
fn rungs_without_cycles_do_the_same_work_on_any_machine() {
    check_many(200, (machines(), streams()), |(mut machine, stream)| {
        let unit = &mut machine.shadow_cache;
        (unit.place, unit.register, unit.frame_end) = (Place::Own, num(0), FrameEnd::List);
        if unit.cache.contents == Contents::Ideal {
            unit.writes = WritePolicy::Back;
        }
        let [profile, functional, event] =
            ["Profile", "Functional", "Event"].map(|rung| on(&machine, &header(), rung, &stream));
        let work = |stats: &MachineStats| {
            let busy: Vec<_> = stats.units.values().map(|causes| causes[&Cause::Busy]).collect();
            let l1s = stats.caches.iter().filter(|(name, _)| name.starts_with("l1"));
            let accesses: Vec<_> = l1s.flat_map(|(_, classes)| classes.values().map(|it| it.accesses)).collect();
            let asked: Vec<_> = stats.bytes.iter().filter(|(name, _)| name.starts_with("l1")).collect();
            format!("{:?}", (stats.rays, &busy[1..], accesses, asked))
        };
        if [&profile, &functional].iter().all(|stats| work(stats) == work(&event)) {
            Ok(())
        } else {
            Err(format!("Profile {}\nFunctional {}\nEvent {}", work(&profile), work(&functional), work(&event)))
        }
    });
}

#[test]
fn rungs_without_cycles_are_close_on_the_recorded_stream() {
    let (header, stream) = quickstart();
    for name in ["small", "desktop"] {
        let machine = shipped(name);
        let event = on(&machine, &header, "Event", &stream);
        // On `small` the DRAM's bus is busy for six tenths of the time here: that is where the profile rung is weakest.
        for (rung, most) in [("Profile", 0.1), ("Functional", 0.03)] {
            let found = on(&machine, &header, rung, &stream);
            assert_eq!(found.accuracy, Accuracy::Bounded);
            let apart = |a: u64, b: u64| (a as f64 / b as f64 - 1.0).abs();
            assert!(apart(found.cycles.0, event.cycles.0) < most, "{rung}, {name}: {} {}", found.cycles, event.cycles);
            for level in ["l2", "dram"] {
                let [ours, theirs] = [&found, &event].map(|stats| stats.moved(level).0);
                assert!(apart(ours, theirs) < 0.03, "{rung}, {name}, {level}: {ours} {theirs}");
            }
        }
    }
}

#[test]
fn a_sample_of_everything_is_everything() {
    let (header, stream) = quickstart();
    let machine = shipped("small");
    for engine in ["Functional", "Event"] {
        let whole = on(&machine, &header, engine, &stream);
        let sampled = on(&machine, &header, &format!("Sampled(engine: {engine}, rate: 1.0)"), &stream);
        assert_eq!(sampled.accuracy, Accuracy::Estimated { cycles: 0.0, l2_bytes: 0.0, dram_bytes: 0.0, rate: 1.0 });
        // The last write-backs come after the last window.
        assert!(whole.cycles.0 - sampled.cycles.0 < 500, "{} {}", whole.cycles, sampled.cycles);
        assert_eq!((sampled.rays, &sampled.bytes["l1_traversal"]), (whole.rays, &whole.bytes["l1_traversal"]));
        assert_eq!(sampled.caches["l1_traversal"], whole.caches["l1_traversal"]);
    }
}

/// A sample of everything, whatever the shadow-cache units do otherwise than recorded.
#[test]
fn any_machine_can_be_sampled() {
    check_many(100, (machines(), streams()), |(machine, stream)| {
        let whole = on(&machine, &header(), "Event", &stream);
        let sampled = on(&machine, &header(), "Sampled(engine: Event, rate: 1.0)", &stream);
        let work = |stats: &MachineStats| {
            let accesses =
                |name| stats.caches[name].iter().map(|(class, it)| (*class, it.accesses)).collect::<Vec<_>>();
            (stats.rays, accesses("l1_traversal"), accesses("l1_shadow_cache"))
        };
        if work(&whole) == work(&sampled) {
            Ok(())
        } else {
            Err(format!("whole {:?}\nsampled {:?}", work(&whole), work(&sampled)))
        }
    });
}

#[test]
fn auto_is_as_close_as_was_asked_and_says_what_it_took() {
    let (header, stream) = quickstart();
    let open = |frame: usize| {
        let begins = |(_, item): &(usize, &Item)| matches!(item, Item::Frame(_));
        let first = stream.iter().enumerate().filter(begins).nth(frame).map_or(stream.len(), |(at, _)| at);
        Ok::<_, std::convert::Infallible>(stream[first..].iter().cloned().map(Ok))
    };
    for name in ["small", "desktop"] {
        let machine = shipped(name);
        let event = on(&machine, &header, "Event", &stream);
        for (target, least_taken) in [("0.000001", "Event"), ("0.05", "")] {
            let auto = format!("Auto(error: {target})").parse().unwrap();
            let found = run_passes(&machine, auto, &header, open).unwrap();
            let needs = found.needs.as_ref().unwrap();
            let taken = needs.models.last().unwrap();
            println!("{name}: {needs:#?}");
            assert!(taken.passes && taken.model.contains(least_taken), "{taken:?}");
            let apart = |a: u64, b: u64| (a as f64 / b as f64 - 1.0).abs();
            let limit: f64 = target.parse().unwrap();
            assert!(
                apart(found.cycles.0, event.cycles.0) <= limit,
                "{name}, {target}: {} {}",
                found.cycles,
                event.cycles
            );
            assert!(apart(found.moved("dram").0, event.moved("dram").0) <= limit, "{name}, {target}");
        }
        // A stream that can be read once is refused.
        let auto = Fidelity::Auto { error: Share::new(0.02).unwrap() };
        assert!(matches!(run(&machine, auto, &header, items(stream.clone())), Err(RunError::Passes)));
    }
}

/// All windows of the recorded stream on `small`, in strata of 20.
fn census() -> (Population, Vec<Window>) {
    let (header, stream) = quickstart();
    let mut machine = shipped("small");
    // The stream is short: a small pool makes for many windows.
    machine.dispatcher.rays = num(16);
    let plan = Plan { stratum: 2, draws: 0..2, pixels: 16, seed: 0 };
    let (findings, _) = sampled(Sampled::Event, &machine, &header, plan, items(stream)).unwrap();
    let windows = findings.measured;
    let mut population = Population::default();
    for (at, window) in windows.iter().enumerate() {
        population.strata.resize(at / STRATUM + 1, 0);
        population.strata[at / STRATUM] += 1;
        population.add(&window.known);
    }
    (population, windows)
}

const STRATUM: usize = 20;

/// The windows that a pass and those before it measure.
fn drawn(windows: &[Window], draws: usize, seed: u64) -> Vec<Window> {
    let plan = Plan { stratum: STRATUM, draws: 0..draws, pixels: 0, seed };
    let measured = |at: usize| plan.measures(at / STRATUM)[at % STRATUM];
    let sample = windows.iter().enumerate().filter(|&(at, _)| measured(at));
    sample.map(|(at, window)| Window { stratum: at / STRATUM, ..window.clone() }).collect()
}

fn truth(windows: &[Window], name: &str) -> f64 {
    windows.iter().map(|window| window.measured.get(name).copied().unwrap_or(0.0)).sum()
}

/// The truth lies within the 95 % intervals in 93 to 97 % of 1000 samples of windows that were all measured.
#[test]
fn intervals_cover_the_truth_as_often_as_they_say() {
    let (population, windows) = census();
    assert!(windows.len() > 200, "{}", windows.len());
    let names = ["cycles", "dram.reads", "=bytes.l2", "caches.l1_traversal.node.misses"];
    let mut covered = names.map(|_| 0);
    let mut widths = names.map(|_| 0.0);
    for seed in 0..1000 {
        let found = estimate(&population, &drawn(&windows, 2, seed));
        for (at, name) in names.into_iter().enumerate() {
            let Total { total, half_width } = found[name];
            covered[at] += u32::from((total - truth(&windows, name)).abs() <= half_width.unwrap());
            widths[at] += half_width.unwrap() / truth(&windows, name) / 1000.0;
        }
    }
    println!("{names:?}: {covered:?} of 1000, mean half widths {widths:.3?}");
    for (name, covered) in names.into_iter().zip(covered) {
        assert!((930..=970).contains(&covered), "{name}: {covered} of 1000");
    }
}

/// The same where sampling goes on until the interval is within a target: windows double from look to look, and whoever stops does so
/// since the interval came out narrow, which it may have done by chance.
#[test]
fn intervals_cover_the_truth_when_sampling_stops_at_a_target() {
    let (population, windows) = census();
    let truth = truth(&windows, "cycles");
    for target in [0.02, 0.03, 0.05, 0.1] {
        let (mut covered, mut stopped) = (0, 0);
        for seed in 0..500 {
            let found = |draws| estimate(&population, &drawn(&windows, draws, seed))["cycles"];
            let first = [2, 4, 8].into_iter().map(found).find(|found| found.share().unwrap() <= target);
            if let Some(Total { total, half_width }) = first {
                stopped += 1;
                covered += u32::from((total - truth).abs() <= half_width.unwrap());
            }
        }
        println!("target {target}: {covered} of {stopped} that stopped");
        assert!(f64::from(covered) >= 0.93 * f64::from(stopped), "target {target}: {covered} of {stopped}");
    }
}
