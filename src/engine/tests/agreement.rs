//! `Event` and `Cycle` give the same numbers.

use std::path::Path;
use std::sync::Mutex;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestError, TestRng, TestRunner};

use super::random::{lights, machines, streams, sweeps};
use super::recorded::shipped;
use super::synthetic::{header, header_of};
use super::*;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::machine::writes::WritePolicy;
use crate::memory::dram::command::ChannelLog;
use crate::memory::dram::legality::violations;
use crate::memory::tags::Contents;
use crate::ron_file;
use crate::stream::StreamReader;

fn counted(
    engine: &mut dyn Engine,
    machine: &MachineSpec,
    stream: &[Item],
) -> Result<(Tally, Vec<ChannelLog>), String> {
    engine.logs().into_iter().for_each(ChannelLog::keep);
    let tally = replay(engine, machine, &mut items(stream.to_vec()), None).map_err(|error| error.to_string())?;
    Ok((tally, engine.logs().into_iter().map(|log| log.clone()).collect()))
}

/// The counts of both engines, or the first difference or violation.
pub(crate) fn agree(
    machine: &MachineSpec,
    header: &Header,
    stream: &[Item],
) -> Result<(Tally, Vec<ChannelLog>), String> {
    let event = counted(&mut Event::new(machine, header), machine, stream)?;
    let cycle = counted(&mut Cycle::new(machine, header), machine, stream)?;
    for (channel, (event, cycle)) in event.1.iter().zip(&cycle.1).enumerate() {
        if let Some(at) = event.commands().iter().zip(cycle.commands()).position(|(event, cycle)| event != cycle) {
            let (event, cycle) = (event.commands()[at], cycle.commands()[at]);
            return Err(format!("channel {channel}, command {at}: Event gives {event:?}, Cycle {cycle:?}"));
        }
    }
    if event != cycle {
        return Err(format!("Event counts {:#?}\nCycle {:#?}", event.0, cycle.0));
    }
    let mut bound = Bound::new(machine, header, false);
    stream.iter().for_each(|item| bound.add(item));
    check::bounds(&event.0.stats(machine), &bound.bounds(&[]))?;
    let end = machine.dram.clocks(machine.clock_mhz.get()).first(cycle.0.cycles) - 1;
    for (channel, log) in cycle.1.iter().enumerate() {
        let found = violations(&machine.dram, machine.line_bytes.get(), log.commands(), end);
        if let Some(first) = found.first() {
            return Err(format!("channel {channel}: {first:?} in {:#?}", log.commands()));
        }
    }
    Ok(event)
}

/// Stack in bytes for a test of random machines: without optimisation, the generators need more than a thread's default
/// stack.
const STACK: usize = 64 << 20;

/// Whether the long suite runs.
pub(crate) fn is_long() -> bool {
    std::env::var_os("UMBRASIM_LONG").is_some()
}

/// Checks `test` on `cases` values, the same in every run. With the environment variable `UMBRASIM_LONG`: on 20 times
/// as many values, different in every run. Failures give a short message.
pub(crate) fn check_many<S: Strategy>(
    cases: u32,
    strategy: impl Fn() -> S + Sync,
    test: impl Fn(S::Value) -> Result<(), String> + Sync,
) {
    let long = is_long();
    let cases = if long { 20 * cases } else { cases };
    let check = || {
        let config = Config { cases, failure_persistence: None, ..Config::default() };
        let mut runner = if long {
            TestRunner::new(config)
        } else {
            TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
        };
        match runner.run(&strategy(), |value| test(value).map_err(TestCaseError::fail)) {
            Ok(()) => {}
            Err(TestError::Fail(why, value)) => panic!("{why}\nfor {value:#?}"),
            Err(TestError::Abort(why)) => panic!("{why}"),
        }
    };
    std::thread::scope(|scope| {
        let checked = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, check).unwrap().join();
        if let Err(panic) = checked {
            std::panic::resume_unwind(panic);
        }
    });
}

#[test]
fn engines_agree_on_any_machine_and_stream() {
    let all = Mutex::new(Vec::new());
    check_many(
        600,
        || (machines(), lights(), streams()),
        |(machine, lights, stream)| {
            let (tally, _) = agree(&machine, &header_of(lights), &stream)?;
            all.lock().unwrap().push(tally);
            Ok(())
        },
    );
    // The random cases must reach every count; otherwise their agreement says little.
    let all = all.into_inner().unwrap();
    for cause in Cause::ALL {
        for kind in Kind::ALL {
            let has = |tally: &&Tally| tally.units[kind as usize].iter().any(|unit| unit.causes[cause as usize] > 0);
            let reached = all.iter().filter(has).count();
            // An intersection unit waits for a division unit only if all rays hit at once: another test covers it.
            let rare = (kind, cause) == (Kind::Intersection, Cause::Blocked);
            let never = cause == Cause::Intake && kind != Kind::ShadowCache;
            assert!(if never { reached == 0 } else { reached > 4 || rare }, "{kind:?}: {cause:?}");
        }
        let never = cause == Cause::Intake;
        assert!(all.iter().any(|tally| tally.dispatcher[cause as usize] > 0) != never, "{cause:?}");
    }
    let reached = |what: &str, count: fn(&Tally) -> u64| {
        let reached = all.iter().filter(|tally| count(tally) > 0).count();
        assert!(reached > 20, "{what}: in {reached} cases only");
    };
    reached("refreshes", |tally| tally.commands().refreshes);
    reached("reads of a flat DRAM", |tally| {
        tally.channels.iter().map(|it| it.counts).filter(|it| it.row_hits + it.row_misses == 0).map(|it| it.reads).sum()
    });
    reached("row hits", |tally| tally.commands().row_hits);
    reached("row conflicts", |tally| tally.commands().row_conflicts);
    reached("writes", |tally| tally.commands().writes);
    reached("MSHR hits of the L2", |tally| tally.banks.iter().flat_map(|bank| bank.cache).map(|it| it.mshr_hits).sum());
    reached("writes past the L2", |tally| {
        tally.banks.iter().flat_map(|bank| bank.cache).map(|it| it.passed_writes).sum()
    });
    reached("bank conflicts", |tally| {
        tally.units.iter().flatten().flat_map(|unit| unit.l1).map(|it| it.bank_conflicts).sum()
    });
    reached("merged reads", |tally| tally.stores.merged_reads);
    reached("merged writes", |tally| tally.stores.merged_writes);
    reached("reads that a first touch raises", |tally| tally.stores.raised_reads);
    reached("writes left to first touches", |tally| tally.stores.deferred_writes);
    reached("writes that a sweep covers", |tally| tally.stores.covered_writes);
    reached("updates dropped at rays", |tally| tally.stores.dropped_writes);
    reached("reads of learned bits at a frame's end", |tally| tally.stores.added_reads);
    reached("updates gathered", |tally| tally.stores.gathered_writes);
    reached("rays that the host answers", |tally| tally.stores.answered_rays);
    for class in [TrafficClass::Ray, TrafficClass::FrameBuffer, TrafficClass::Texture, TrafficClass::Build] {
        let moves = |tally: &&Tally| tally.channels.iter().any(|channel| channel.moved[class as usize].0 > 0);
        assert!(all.iter().filter(moves).count() > 20, "{class:?}");
    }
    reached("reads past the L1", |tally| {
        tally.units[Kind::ShadowCache as usize].iter().flat_map(|unit| unit.bypassed).map(|past| past.count).sum()
    });
    reached("words by way of intersection units", |tally| {
        tally.units[Kind::Intersection as usize]
            .iter()
            .map(|unit| unit.cache[TrafficClass::ModeWord as usize].accesses)
            .sum()
    });
    for class in [TrafficClass::ModeWord, TrafficClass::PixelCounter, TrafficClass::OccluderId] {
        let l1 = |tally: &&Tally| {
            tally.units[Kind::ShadowCache as usize].iter().any(|unit| unit.cache[class as usize].write_backs > 0)
        };
        let l2 = |tally: &&Tally| tally.banks.iter().any(|bank| bank.cache[class as usize].write_backs > 0);
        assert!(all.iter().filter(l1).count() > 4 && all.iter().filter(l2).count() > 4, "{class:?}");
    }
}

fn first_l2(machine: &MachineSpec) -> BankedSpec {
    *machine.l2.caches()[0].1
}

/// Stores under pressure. A fill that waits for a place for its dirty victim continues when a hit makes another line
/// the next victim.
#[test]
fn engines_agree_where_fills_wait() {
    check_many(
        300,
        || (machines(), sweeps()),
        |(mut machine, stream)| {
            let line = machine.line_bytes.get();
            let cache = &mut machine.shadow_cache.cache;
            (cache.bytes, cache.ways, cache.queue, cache.mshrs) = (size(2 * line), num(2), num(1), num(4));
            (cache.latency, cache.targets, cache.contents) = (num(20), num(4), Contents::Tags);
            machine.shadow_cache = ShadowCacheSpec { cache: machine.shadow_cache.cache, ..ShadowCacheSpec::default() };
            machine.shadow_cache.contexts = num(6);
            let small = BankedSpec {
                contents: Contents::Tags,
                bytes: size(2 * line),
                ways: num(2),
                queue: num(1),
                banks: pow(1),
                ..first_l2(&machine)
            };
            machine.l2 = L2Spec::Unified(small);
            machine.dram.queue = num(1);
            agree(&machine, &header(), &stream).map(drop)
        },
    );
}

/// Units whose hits `Event` computes ahead: one access and one operation per cycle. Few or many lines; fast or slow
/// hits.
#[test]
fn engines_agree_where_hits_are_foreseen() {
    check_many(
        200,
        || (machines(), 0..4u32, 1..4u64, streams()),
        |(mut machine, more, latency, stream)| {
            let caches = [&mut machine.traversal.cache, &mut machine.list.cache, &mut machine.intersection.cache];
            for cache in caches {
                (cache.ports, cache.banks, cache.latency) = (num(1), None, num(latency));
                cache.bytes = size(cache.bytes.get() << (2 * more));
            }
            machine.traversal.interval = num(1);
            machine.list.interval = num(1);
            machine.intersection.interval = num(1);
            machine.shadow_cache.writes = WritePolicy::Back;
            agree(&machine, &header(), &stream).map(drop)
        },
    );
}

/// As above with rays that share paths, so that many wait for a line. The line goes to all at once or one by one.
#[test]
fn engines_agree_where_rays_share_lines() {
    let caches = (1..4u64, 1..9u64, 1..6u64, any::<bool>(), 0..4u32);
    check_many(
        150,
        || (caches.clone(), 0..u64::MAX),
        |((latency, mshrs, targets, one_by_one, more), seed)| {
            let mut machine = shipped("tni_engine");
            (machine.traversal.count, machine.intersection.count, machine.list.count) = (num(2), num(1), num(1));
            let caches = [&mut machine.traversal.cache, &mut machine.list.cache, &mut machine.intersection.cache];
            for cache in caches {
                (cache.latency, cache.mshrs, cache.targets) = (num(latency), num(mshrs), num(targets));
                cache.release = if one_by_one { Release::OneByOne } else { Release::Together };
                cache.bytes = size(1024 << more);
            }
            agree(&machine, &header(), &one_frame(&bvh_like(seed, 128, 9, 1))).map(drop)
        },
    );
}

/// The header of a scene without lists.
pub(super) fn without_lists() -> Header {
    Header { static_list_entries: 0, ..header() }
}

/// Machines whose units work far ahead of each other, on streams without lists: rays return late. Lines go to all
/// waiting rays at once or one by one; queues to the L2 are short or long.
pub(super) fn far_ahead() -> impl Strategy<Value = (MachineSpec, Vec<Item>)> {
    let units = (1..4u64, 1..9u64, 1..6u64, any::<bool>(), 0..4u32, 1..5u64);
    let latencies = (1..40u64, 1..40u64, 1..40u64, 1..12u64);
    (units, latencies, 0..3u32, 0..u64::MAX).prop_map(
        |((hits, mshrs, targets, one_by_one, more, queue), (answers, tests, dispatch, nodes), line, seed)| {
            let mut machine = with_line(shipped("tni_engine"), 32 << line);
            (machine.traversal.count, machine.intersection.count, machine.list.count) = (num(3), num(2), num(1));
            let caches = [&mut machine.traversal.cache, &mut machine.intersection.cache];
            for cache in caches {
                (cache.latency, cache.mshrs, cache.targets) = (num(hits), num(mshrs), num(targets));
                cache.release = if one_by_one { Release::OneByOne } else { Release::Together };
                (cache.bytes, cache.queue) = (size(1024 << more), num(queue));
            }
            let l2 = BankedSpec { latency: num(answers), queue: num(1 + queue), banks: pow(2), ..BankedSpec::DEFAULT };
            machine.l2 = L2Spec::Unified(l2);
            (machine.intersection.latency, machine.division.latency) = (num(tests), num(tests));
            (machine.dispatcher.latency, machine.traversal.latency) = (num(dispatch), num(nodes));
            (machine, one_frame(&bvh_like(seed, 96, 9, 1)))
        },
    )
}

#[test]
fn engines_agree_where_units_work_ahead() {
    check_many(400, far_ahead, |(machine, stream)| agree(&machine, &without_lists(), &stream).map(drop));
}

/// The recorded quick start on the shipped machines.
#[test]
fn engines_agree_on_the_shipped_machines_and_a_recorded_stream() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let reader = StreamReader::open(&root.join("traces/quickstart.rays")).unwrap();
    let recorded = reader.header().clone();
    let stream: Vec<Item> = reader.collect::<Result<_, _>>().unwrap();
    for machine in std::fs::read_dir(root.join("configs/machines")).unwrap() {
        let machine: MachineSpec = ron_file::read(&machine.unwrap().path()).unwrap_or_else(|error| panic!("{error}"));
        agree(&machine, &recorded, &stream).unwrap_or_else(|why| panic!("{}: {why}", machine.name));
    }
}

/// The result does not change when all parts act in all cycles.
#[test]
fn waking_more_often_changes_nothing() {
    check_many(
        50,
        || (machines(), streams()),
        |(machine, stream)| {
            let mut engine = Event::new(&machine, &header());
            let lazy = counted(&mut engine, &machine, &stream)?;
            let mut engine = Event::new(&machine, &header());
            engine.eager = true;
            let eager = counted(&mut engine, &machine, &stream)?;
            if lazy == eager { Ok(()) } else { Err("the eager run differs".into()) }
        },
    );
}
