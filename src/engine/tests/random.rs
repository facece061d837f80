//! Random small machines and random streams.

use proptest::prelude::*;

use super::synthetic::{STATIC, SyntheticRay, frame, triangle};
use super::{num, pow, pow_size, size};
use crate::machine::MachineSpec;
use crate::machine::shadow_cache::{FrameEnd, Place, ShadowCacheSpec};
use crate::machine::stores::StoreLayout;
use crate::machine::traffic::{Build, RayBuffer, TrafficSpec};
use crate::machine::word_traffic::{Decide, LatchedCopy, SilentUpdates};
use crate::machine::writes::WritePolicy;
use crate::memory::allocation::{Classes, NoAllocate};
use crate::memory::bank::BankedSpec;
use crate::memory::cache::{CacheSpec, Release};
use crate::memory::dram::mapping::{Field, Mapping};
use crate::memory::dram::part::DramPart;
use crate::memory::dram::spec::{DramSpec, Model, Page};
use crate::memory::l2::{HomeSpec, L2Spec};
use crate::memory::replacement::Policy;
use crate::memory::tags::Contents;
use crate::quantity::{ListId, NodeId};
use crate::stats::TrafficClass;
use crate::stream::{Decision, Effect, FrameInfo, Item, RayKind, Step, Stop, Store};

/// A latency: mostly small, sometimes 1, sometimes `most`.
fn latency(most: u64) -> impl Strategy<Value = u64> {
    prop_oneof![2 => Just(1), 6 => 1..10u64.min(most), 2 => 1..=60u64.min(most), 1 => Just(most)]
}

fn replacement() -> impl Strategy<Value = Policy> {
    prop_oneof![
        Just(Policy::Lru),
        Just(Policy::Fifo),
        Just(Policy::TreePlru),
        (0..9u64).prop_map(|seed| Policy::Random { seed })
    ]
}

fn contents() -> impl Strategy<Value = Contents> {
    prop_oneof![5 => Just(Contents::Tags), 1 => Just(Contents::Ideal)]
}

fn classes() -> impl Strategy<Value = Classes> {
    let some = prop::sample::subsequence(TrafficClass::ALL.to_vec(), 0..=TrafficClass::ALL.len());
    prop_oneof![3 => Just(Vec::new()), 2 => some].prop_map(Classes::from)
}

fn cache(line: u64) -> impl Strategy<Value = CacheSpec> {
    let release = prop_oneof![Just(Release::Together), Just(Release::OneByOne)];
    let shape = (contents(), 0..3u32, 0..4u32, replacement(), latency(200), release, classes(), classes());
    let ports = (1..4u64, prop::option::of((0..3u32).prop_map(|bits| pow(1 << bits))));
    (shape, ports, 1..4u64, 1..4u64, 1..4u64).prop_map(
        move |((contents, ways, sets, replacement, latency, release, reads, writes), ports, mshrs, targets, queue)| {
            CacheSpec {
                no_allocate: NoAllocate { reads, writes },
                contents,
                bytes: size((line << ways) << sets),
                ways: num(1 << ways),
                replacement,
                latency: num(latency),
                ports: num(ports.0),
                banks: ports.1,
                mshrs: num(mshrs),
                targets: num(targets),
                release,
                queue: num(queue),
            }
        },
    )
}

fn banked(line: u64) -> impl Strategy<Value = BankedSpec> {
    (cache(line), 0..3u32, latency(300)).prop_map(|(cache, banks, latency)| BankedSpec {
        contents: cache.contents,
        no_allocate: cache.no_allocate,
        bytes: size(cache.bytes.get() << banks),
        ways: cache.ways,
        banks: pow(1 << banks),
        replacement: cache.replacement,
        latency: num(latency),
        mshrs: cache.mshrs,
        targets: cache.targets,
        queue: cache.queue,
    })
}

/// One cache for all classes, or three caches with a random split that every layout of words allows.
fn l2(line: u64) -> impl Strategy<Value = L2Spec> {
    let shares = prop::collection::vec(0..3usize, TrafficClass::ALL.len());
    let banked = banked(line).boxed();
    let split = (banked.clone(), banked.clone(), banked.clone(), shares).prop_map(|(a, b, c, shares)| {
        let home = |(index, cache): (usize, BankedSpec)| {
            // Classes that may share lines are in the same cache.
            let share = |class| match class {
                TrafficClass::ModeWord | TrafficClass::PixelCounter => shares[TrafficClass::Triangle as usize],
                other => shares[other as usize],
            };
            let classes =
                TrafficClass::ALL.into_iter().filter(|&class| share(class) == index && !class.goes_past_caches());
            (format!("c{index}"), HomeSpec { classes: classes.collect(), cache })
        };
        L2Spec::Split([a, b, c].into_iter().enumerate().map(home).collect())
    });
    prop_oneof![2 => banked.prop_map(L2Spec::Unified), 1 => split]
}

fn model() -> impl Strategy<Value = Model> {
    let flat = (latency(300), prop::option::of(prop_oneof![1..9u64, 1..400u64]))
        .prop_map(|(latency, bytes)| Model::Flat { latency: num(latency), bytes_per_cycle: bytes.map(size) });
    prop_oneof![4 => Just(Model::Banks), 1 => flat]
}

fn dram(line: u64) -> impl Strategy<Value = DramSpec> {
    let shape = (0..3u32, 0..3u32, 0..3u32, 0..6u32, 0..3u32, 1..6u64, 0..3u32);
    let wait = || prop_oneof![3 => 1..30u64, 1 => 1..300u64];
    let waits = prop::collection::vec(wait(), 16);
    let clocks = (prop_oneof![Just(1600u64), 100..4000u64], 1..9u64);
    (model(), shape, waits, clocks, any::<bool>()).prop_map(
        move |(model, shape, waits, (clock_mhz, burst_clocks), closed)| {
            let (channels, groups, banks, columns, low, queue, burst) = shape;
            let low = low.min(columns);
            let mut part = DramPart {
                clock_mhz: num(clock_mhz),
                bank_groups: pow(1 << groups),
                banks: pow(1 << (groups + banks)),
                row_bytes: pow_size(line << columns),
                burst_bytes: pow_size(line >> burst),
                burst_clocks: num(burst_clocks),
                ..DramPart::default()
            };
            let timing = &mut part.timing;
            (timing.cl, timing.cwl, timing.rcd) = (num(waits[0]), num(waits[1]), num(waits[2]));
            (timing.rp, timing.ras, timing.rtp, timing.wr) =
                (num(waits[3]), num(waits[4]), num(waits[6]), num(waits[7]));
            timing.rc = num(waits[3] + waits[4] + waits[9] / 4);
            timing.rfc = num(waits[10]);
            (timing.faw, timing.turn) = (num(waits[11]), num(waits[12] - 1));
            // Times can be longer within a group than between groups, if there are groups.
            let longer = |wait: u64| if groups > 0 { wait / 4 } else { 0 };
            let ccd = burst_clocks + waits[13] / 16;
            (timing.ccd_s, timing.ccd_l) = (num(ccd), num(ccd + longer(waits[14])));
            (timing.rrd_s, timing.rrd_l) = (num(waits[5]), num(waits[5] + longer(waits[15])));
            (timing.wtr_s, timing.wtr_l) = (num(waits[8]), num(waits[8] + longer(waits[15])));
            let mapping = vec![
                Field::Column(low),
                Field::BankGroup(groups / 2),
                Field::Channel(channels),
                Field::Column(columns - low),
                Field::BankGroup(groups - groups / 2),
                Field::Bank(banks),
                Field::Row,
            ];
            DramSpec {
                model,
                part,
                channels: pow(1 << channels),
                queue: num(queue),
                page: if closed { Page::Closed } else { Page::Open },
                mapping: Mapping(mapping),
            }
        },
    )
}

/// Options of shadow-cache units for words, without their cache.
fn words() -> impl Strategy<Value = ShadowCacheSpec> {
    let place =
        prop_oneof![3 => Just(Place::Own), 2 => Just(Place::Triangle), 2 => Just(Place::L2), 1 => Just(Place::Free)];
    let layout = prop_oneof![
        Just(StoreLayout::Dense),
        Just(StoreLayout::Packed),
        Just(StoreLayout::Beside),
        Just(StoreLayout::Record),
        Just(StoreLayout::Tagged)
    ];
    let frame_end = prop_oneof![1 => Just(FrameEnd::List), 3 => Just(FrameEnd::Sweep), 3 => Just(FrameEnd::Epoch)];
    let register = prop_oneof![2 => Just(0), 2 => 1..4u64, 1 => Just(64)];
    let writes = prop_oneof![
        2 => Just(WritePolicy::Back),
        1 => Just(WritePolicy::Through),
        1 => classes().prop_map(WritePolicy::ThroughFor)
    ];
    let silent = prop_oneof![Just(SilentUpdates::Sent), Just(SilentUpdates::Latched), Just(SilentUpdates::Live)];
    let decide = prop_oneof![Just(Decide::Unit), Just(Decide::Hit)];
    let latched = prop_oneof![Just(LatchedCopy::Free), Just(LatchedCopy::Wide), Just(LatchedCopy::Buffers)];
    let gather = prop_oneof![Just(0), 1..3u64, Just(100)];
    let taking = (1..4u64, prop_oneof![3 => 1..5u64, 1 => 5..20u64], 1..5u64);
    (taking, place, layout, writes, register, frame_end, (silent, decide, gather, latched)).prop_map(
        |((count, contexts, width), place, layout, writes, register, frame_end, (silent, decide, gather, latched))| {
            ShadowCacheSpec {
                count: num(count),
                contexts: num(contexts),
                width: num(width),
                silent,
                decide,
                gather: num(gather),
                latched,
                place,
                layout,
                writes,
                register: num(register),
                frame_end,
                ..ShadowCacheSpec::default()
            }
        },
    )
}

/// The host's own traffic, off in half of the cases.
fn traffic() -> impl Strategy<Value = TrafficSpec> {
    let rays = prop_oneof![Just(RayBuffer::Free), Just(RayBuffer::OnChip), Just(RayBuffer::Dram)];
    let bytes = || prop_oneof![Just(0), 1..40u64, 1..400u64];
    let build = (prop_oneof![Just(Build::Free), Just(Build::Written)], prop_oneof![2 => Just(0), 1 => 10..1000u64]);
    let on = (rays, bytes(), bytes(), bytes(), bytes(), build, prop_oneof![1..4u64, 1..60u64]).prop_map(
        |(rays, ray, hit, pixel, texture, (build, build_rate), queue)| TrafficSpec {
            rays,
            ray_bytes: size(ray.max(1)),
            hit_bytes: size(hit.max(1)),
            pixel_bytes: size(pixel),
            texture_bytes: size(texture),
            build,
            build_rate: num(build_rate),
            queue: num(queue),
        },
    );
    prop_oneof![Just(TrafficSpec::default()), on]
}

/// Number of lights: modes that fill a nibble, a byte, a word, and more, with room for the frame's number.
pub(crate) fn lights() -> impl Strategy<Value = u32> {
    prop_oneof![Just(1), Just(2), Just(6), Just(8), Just(9), Just(14), Just(20), Just(40)]
}

/// A machine for lines of `line` bytes.
fn machine(line: u64) -> impl Strategy<Value = MachineSpec> {
    let counts = (1..4u64, 1..6u64, 1..5u64, 1..5u64, 1..4u64, 1..20u64, 1..7u64);
    let latencies = (latency(300), latency(300), latency(300), latency(300), latency(300), latency(2000));
    // Boxed: the combined strategies would overflow the stack.
    let cache = || cache(line).boxed();
    let caches = (cache(), cache(), cache(), cache(), l2(line).boxed());
    let intervals = prop::collection::vec(prop_oneof![3 => Just(1), 1 => 1..40u64], 5);
    let cores = prop_oneof![2 => Just(1), 1 => 2..4u64];
    let more = (1..4u64, 1..5u64, 1..4u64, 1..4u64, 1..4u64, cores, 1..6u64, 1..4u64);
    let rest = (50..4000u64, words(), 1..4000u64, (intervals, more, latency(300)), traffic());
    (counts, latencies, caches, dram(line).boxed(), rest).prop_map(
        move |(counts, latencies, caches, dram, (clock, words, refi, (intervals, more, list_latency), traffic))| {
            let mut machine =
                MachineSpec { clock_mhz: num(clock), line_bytes: pow_size(line), dram, ..MachineSpec::default() };
            // An interval of refreshes slightly above the shortest that is allowed.
            let mut interval = 100;
            machine.dram.part.timing.refi = num(interval);
            while machine.dram.check(line).is_err() {
                interval *= 2;
                machine.dram.part.timing.refi = num(interval);
            }
            machine.dram.part.timing.refi = num(interval + refi);
            machine.traversal.count = num(counts.0);
            machine.traversal.rays = num(counts.1);
            machine.intersection.count = num(counts.2);
            machine.intersection.tests = num(counts.3);
            machine.intersection.queue = num(counts.4);
            machine.dispatcher.rays = num(counts.5);
            machine.dispatcher.per_cycle = num(counts.6);
            (machine.shadow_cache, machine.traffic) = (words, traffic);
            machine.dispatcher.latency = num(latencies.0);
            machine.traversal.latency = num(latencies.1);
            machine.intersection.latency = num(latencies.2);
            machine.division.latency = num(latencies.3);
            machine.list.latency = num(list_latency);
            (machine.list.count, machine.list.lists, machine.list.queue) = (num(more.0), num(more.1), num(more.2));
            (machine.division.count, machine.division.queue) = (num(more.3), num(more.4));
            machine.cores = num(more.5);
            (machine.dispatcher.in_fifo, machine.dispatcher.out_fifo) = (num(more.6), num(more.7));
            machine.shadow_cache.latency = num(latencies.4);
            machine.dispatcher.shading_cycles = num(latencies.5);
            machine.traversal.cache = caches.0;
            machine.intersection.cache = caches.1;
            machine.shadow_cache.cache = caches.2;
            machine.list.cache = caches.3;
            machine.l2 = caches.4;
            // At most the latency.
            let interval = |unit: usize, latency: u64| num(intervals[unit].min(latency));
            machine.traversal.interval = interval(0, latencies.1);
            machine.list.interval = interval(1, list_latency);
            machine.intersection.interval = interval(2, latencies.2);
            machine.division.interval = interval(3, latencies.3);
            machine.shadow_cache.interval = interval(4, latencies.4);
            if machine.shadow_cache.layout == StoreLayout::Record {
                machine.cores = num(1);
            }
            if machine.check().is_err() {
                // An ideal cache allows no write-through.
                machine.shadow_cache.writes = WritePolicy::Back;
            }
            machine
        },
    )
}

/// Any machine.
pub(crate) fn machines() -> impl Strategy<Value = MachineSpec> {
    prop_oneof![machine(32), machine(64), machine(128)]
}

/// Any stream for a scene of [`super::synthetic::header`].
pub(crate) fn streams() -> impl Strategy<Value = Vec<Item>> {
    let stores = [Store::ModeWord, Store::PixelCounter, Store::OccluderId];
    let store = (0..3usize, prop_oneof![2 => 0..STATIC, 2 => 0..64u32, 3 => 0..3u32], 0..3u8).prop_map(
        move |(store, index, kind)| match kind {
            0 => Step::Read { store: stores[store], index },
            1 => Step::Write { store: stores[store], index },
            _ => Step::Update { store: stores[store], index },
        },
    );
    let traversal = (0..8u8, 0..40u32, 0..3usize).prop_map(|(kind, index, stop)| match kind {
        0..4 => Step::Node(NodeId(index * index)),
        4 => Step::Node(NodeId(STATIC + index)),
        5 => Step::List(ListId(index)),
        _ => triangle(index * 50, [Stop::Plane, Stop::Edges, Stop::Hit][stop]),
    });
    let traversal = traversal.boxed();
    let path = prop::collection::vec(traversal.clone(), 0..12);
    let step = prop_oneof![2 => store, 1 => traversal];
    // An update of a mode word has a random effect.
    let effect = prop_oneof![Just(Effect::Changes), Just(Effect::Repeats), Just(Effect::Silent)];
    let packed = (step.clone(), effect).prop_map(|(step, effect)| match step {
        Step::Update { store: Store::ModeWord, index } => Step::pack_word_update(index, effect),
        step => step.pack(),
    });
    let end = prop::collection::vec(step, 0..6);
    let policy = prop::collection::vec(packed, 0..6);
    let ray = (0..5u8, path, policy);
    let group = prop::collection::vec(ray, 1..6).prop_map(|rays| {
        rays.into_iter()
            .enumerate()
            .map(|(index, (kind, path, policy))| {
                let parent = 1 + (kind as u32 * 7 % index.max(1) as u32);
                let ray = match (index, kind) {
                    (0, _) => SyntheticRay::primary(path),
                    (_, 0) => SyntheticRay::shadow(parent, Decision::Skip, Vec::new()),
                    (_, 1) => SyntheticRay::shadow(parent, Decision::DynamicOnly, path),
                    (_, 2 | 3) => SyntheticRay::shadow(parent, Decision::Trace, path),
                    _ => SyntheticRay { kind: RayKind::Reflection, parent, ..SyntheticRay::primary(path) },
                };
                SyntheticRay { policy, ..ray }
            })
            .collect::<Vec<_>>()
    });
    let frames = (prop::collection::vec(prop_oneof![3 => group, 1 => fans()], 0..12), end, 1..9usize).prop_map(
        |(groups, end, chunk)| {
            let info =
                FrameInfo { dynamic_nodes: 40, dynamic_slots: 40, dynamic_list_entries: 40, ..FrameInfo::default() };
            frame(info, &groups.concat(), &end, chunk)
        },
    );
    prop::collection::vec(frames, 1..3).prop_map(|frames| frames.concat())
}

/// A hit with several traced shadow rays that update few words.
fn fans() -> impl Strategy<Value = Vec<SyntheticRay>> {
    let update = (0..3u32, any::<bool>()).prop_map(|(index, silent)| {
        Step::pack_word_update(index, if silent { Effect::Silent } else { Effect::Changes })
    });
    let shadow = (0..30u32, prop::collection::vec(update, 0..3));
    prop::collection::vec(shadow, 2..6).prop_map(|shadows| {
        let hit = SyntheticRay::primary(vec![Step::Node(NodeId(0))]);
        let shadow = |((node, policy), parent)| {
            let path = vec![Step::Node(NodeId(node))];
            SyntheticRay { policy, ..SyntheticRay::shadow(parent, Decision::Trace, path) }
        };
        [hit].into_iter().chain(shadows.into_iter().zip(1..).map(shadow)).collect()
    })
}

/// Streams with only an end-of-frame update, on stores of a few lines.
pub(crate) fn sweeps() -> impl Strategy<Value = Vec<Item>> {
    let step = (0..96u32, 0..10u8).prop_map(|(index, kind)| match kind {
        0..7 => Step::Read { store: Store::ModeWord, index },
        _ => Step::Write { store: Store::ModeWord, index },
    });
    prop::collection::vec(step, 200..400).prop_map(|end| frame(FrameInfo::default(), &[], &end, 1))
}
