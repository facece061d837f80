//! Reports for tests, with invented numbers.

use std::collections::BTreeMap;

use glam::Vec3;

use crate::named::Named;
use crate::quantity::{Bytes, Cycle, Resolution};
use crate::report::file_names::FileNamed;
use crate::report::run::pictures::{self, Image, PictureInfo, PictureKind};
use crate::report::run::{
    FrameResult, LightWrong, MachineRun, MachineSummary, OverTime, PolicySummary, Psnr, RunFiles, SCHEMA, SceneSummary,
    Span, Summary,
};
use crate::report::space::{self, SpaceSummary};
use crate::report::split::Split;
use crate::report::sweep::{Change, Own, SweepPoint, SweepSummary};
use crate::stats::{
    Accuracy, Bounds, CacheCounts, CacheStats, Cause, Choice, DramCounts, Energy, FrameReuse, L1Counts, LatencyCounts,
    Limit, MachineStats, QueueCounts, Residual, Residuals, ReuseCurve, ReuseLevel, TrafficClass, Why,
};
use crate::stream::Totals;
use crate::validate::PixelVerdict;

const SIZE: Resolution = Resolution { width: 96, height: 72 };

/// The counts of a policy that saves `share` in a frame.
pub(crate) fn frame(number: u32, share: f64, wrong: u64) -> FrameResult {
    let left = |work: f64| (work * (1.0 - share)) as u64;
    let tests = if share == 0.0 { 0 } else { 53_000 };
    FrameResult {
        frame: number,
        totals: Totals {
            primary_rays: 262_144,
            shadow_rays: 1_260_000,
            shadow_rays_skipped: if share == 0.0 { 0 } else { 21_000 },
            shadow_rays_dynamic_only: (1_260_000.0 * share) as u64,
            node_visits: 9_000_000,
            triangle_tests: 2_000_000,
            shadow_node_visits: left(30_000_000.0),
            shadow_triangle_tests: left(3_000_000.0),
            policy_triangle_tests: tests,
            policy_reads: tests * 5,
            policy_writes: tests * 2,
            ..Totals::default()
        },
        occlusion_tests: tests,
        false_dark: Some(wrong / 3),
        false_lit: Some(wrong - wrong / 3),
        compared_rays: Some(9_000),
        numeric_differences: Some(7),
        psnr: Some(if wrong == 0 { Psnr::Identical } else { Psnr::Decibel(48.0 - wrong as f64 / 100.0) }),
    }
}

/// Misses that fall with the size of a cache.
fn reuse() -> FrameReuse {
    let curve = |knee: f64| {
        let misses = ReuseCurve::sizes().map(|size| 9_000.0 / (1.0 + size as f64 / knee)).collect();
        ReuseCurve { accesses: 90_000, sampled: 9_000.0, first_touches: 12.0, misses, misses_in_sets: 700.0 }
    };
    let level = |name: &str, bytes, classes: &[(TrafficClass, f64)]| ReuseLevel {
        name: name.into(),
        caches: 2,
        bytes,
        ways: 4,
        classes: classes.iter().map(|&(class, knee)| (class, curve(knee))).collect(),
    };
    let levels = vec![
        level("l1_traversal", 8192, &[(TrafficClass::Node, 2000.0)]),
        level("l1_intersection", 8192, &[(TrafficClass::Triangle, 4000.0)]),
        level("l2", 65536, &[(TrafficClass::Node, 20_000.0), (TrafficClass::Triangle, 30_000.0)]),
    ];
    FrameReuse { policy: "published".into(), frame: 1, levels }
}

fn machine(share: f64, words: u64) -> MachineRun {
    let scaled = |number: f64| (number * (1.0 - share)) as u64;
    let classes = |node: f64, triangle: f64, words: u64| {
        let all = [
            (TrafficClass::Node, scaled(node)),
            (TrafficClass::Triangle, scaled(triangle)),
            (TrafficClass::ModeWord, words),
            (TrafficClass::PixelCounter, words / 2),
        ];
        all.map(|(class, bytes)| (class, Bytes(bytes))).into_iter().collect::<BTreeMap<_, _>>()
    };
    let l2 = |hits: u64| {
        let misses = 980_000 - hits;
        let counts =
            CacheCounts { accesses: 1_000_000, hits, mshr_hits: 20_000, misses, passed_writes: 0, write_backs: 0 };
        CacheStats { counts, l1: None }
    };
    let l1 = |hits: u64| CacheStats { l1: Some(L1Counts::default()), ..l2(hits) };
    let cycles = scaled(812_000_000.0);
    let unit = |count: u64, busy: f64| {
        let whole = cycles * count;
        let of = |part: f64| (whole as f64 * part) as u64;
        let (busy, pipeline, memory, blocked) = (of(busy), of(0.1), of(0.25), of(0.05));
        BTreeMap::from([
            (Cause::Busy, busy),
            (Cause::Pipeline, pipeline),
            (Cause::Memory, memory),
            (Cause::Blocked, blocked),
            (Cause::Intake, 0),
            (Cause::Starved, whole - busy - pipeline - memory - blocked),
        ])
    };
    let joules = cycles as f64 * 2e-10;
    let mut stats = MachineStats {
        cycles: Cycle(cycles),
        clock_mhz: 500.0,
        rays: 75_000_000,
        bytes: BTreeMap::from([
            ("l1_traversal".into(), classes(120e9, 0.0, 0)),
            ("l1_intersection".into(), classes(0.0, 14e9, words * 40)),
            ("l2".into(), classes(9e9, 3e9, words * 4)),
            ("dram".into(), classes(0.9e9, 0.4e9, words)),
        ]),
        caches: BTreeMap::from([
            ("l1_traversal".into(), BTreeMap::from([(TrafficClass::Node, l1(953_000))])),
            (
                "l1_intersection".into(),
                BTreeMap::from([(TrafficClass::Triangle, l1(830_000)), (TrafficClass::ModeWord, l1(912_000))]),
            ),
            ("l2".into(), BTreeMap::from([(TrafficClass::Node, l2(901_000)), (TrafficClass::Triangle, l2(702_000))])),
        ]),
        units: BTreeMap::from([
            ("traversal".into(), unit(4, 0.52)),
            ("intersection".into(), unit(1, 0.31)),
            ("shadow_cache".into(), unit(1, 0.04)),
        ]),
        unit_counts: BTreeMap::from([("traversal".into(), 4), ("intersection".into(), 1), ("shadow_cache".into(), 1)]),
        operations: BTreeMap::from([("traversal".into(), 1_875_000_000)]),
        queues: BTreeMap::from([("l2".into(), QueueCounts { entries: scaled(1e8), waited: scaled(4e8) })]),
        latency: BTreeMap::from([(
            "shadow".into(),
            LatencyCounts { rays: 50_000_000, cycles: scaled(2e10), unloaded: scaled(1e10), most: 9_000 },
        )]),
        dram: DramCounts {
            reads: 20_000_000,
            writes: 300_000,
            row_hits: scaled(14e6),
            row_misses: scaled(1e6),
            row_conflicts: scaled(5e6),
            refreshes: 1_000,
            activates: scaled(6e6),
        },
        dram_organization:
            "1 channel of LPDDR4-3200, Open pages, line bits from the lowest: Column(1) Bank(3) Column(4) Row".into(),
        dram_peak_bytes_per_cycle: Some(12.8),
        accuracy: Accuracy::Estimated { cycles: 0.01, l2_bytes: 0.015, dram_bytes: 0.02, rate: 0.05 },
        frames: Vec::new(),
        energy: Some(Energy {
            joules,
            low: 0.5 * joules,
            high: 3.0 * joules,
            by: BTreeMap::from([("traversal".into(), 0.4 * joules), ("dram_read".into(), 0.6 * joules)]),
            classes: BTreeMap::from([(TrafficClass::Node, 0.5 * joules)]),
        }),
        half_widths: BTreeMap::from([("bytes.dram.node".into(), 9e6)]),
        // Each run has windows of its own.
        residuals: Some(Residuals {
            window_pixels: 512,
            seed: (joules * 1e6) as u64,
            freedom: [8.0; 3],
            points: vec![Residual { place: 0.5, stratum: 0, weight: 2.0, errors: [0.01; 3] }],
            change: None,
        }),
        choice: Some(Choice { target: 0.02, windows: 24, of: 480, cost: 0.25, why: Why::Sampled }),
        bounds: Some(Bounds::default()),
        oracle: Some(Limit::default()),
    };
    stats.frames = vec![stats.as_frame(0, true, 1_500_000), stats.as_frame(16, false, 1_500_000)];
    MachineRun::from(stats)
}

/// A report like that of a run, with frame numbers `frames`.
pub(crate) fn sample(frames: &[u32]) -> RunFiles {
    let (summary, config, images) = parts(frames);
    let over_time = over_time(&summary);
    RunFiles { over_time, ..RunFiles::new(summary, config, &images).unwrap() }
}

/// Ten spans of frame 16 for every machine of `summary`; the busy cycles grow from span to span.
pub(crate) fn over_time(summary: &Summary) -> OverTime {
    let span = |run: &MachineRun, at: u64| {
        let whole = Span::new(16, 0, &run.stats);
        let mut units = whole.units;
        units.values_mut().for_each(|causes| *causes.entry(Cause::Busy).or_default() *= at + 1);
        Span { begin: at * 1000, cycles: 1000, dram_bytes: 1000 * at, units, ..whole }
    };
    let of = |(name, machine): (&str, &MachineSummary)| {
        let runs = machine.policies.iter();
        let spans =
            runs.map(|(policy, run)| ((name.to_owned(), policy.to_owned()), (0..10).map(|at| span(run, at)).collect()));
        spans.collect::<Vec<_>>()
    };
    summary.machines.iter().flat_map(of).collect()
}

/// The parts of a run's report: numbers, the experiment as run, and pictures.
pub(crate) fn parts(frames: &[u32]) -> (Summary, String, Vec<(PictureInfo, Image)>) {
    let wave = |number: u32| 0.19 + 0.3 * (f64::from(number) / 90.0).sin() * (f64::from(number) / 700.0);
    let results = |of: &dyn Fn(u32) -> FrameResult| frames.iter().map(|&number| of(number)).collect::<Vec<_>>();
    let off = results(&|number| frame(number, 0.0, 0));
    let published = results(&|number| frame(number, wave(number), u64::from(number % 23) * 40));
    let exact = results(&|number| frame(number, wave(number) * 0.6 + 0.02, 0));
    let lights = (0..3).map(|light| LightWrong { light, false_dark: 120, false_lit: 250 }).collect();
    let policies = [
        ("off", PolicySummary::new(&off, Vec::new(), Some(&off))),
        ("published", PolicySummary::new(&published, lights, Some(&off))),
        ("last_occluder", PolicySummary::new(&exact, Vec::new(), Some(&off))),
    ];
    let runs = |gain: f64| -> Named<MachineRun> {
        [
            ("off", machine(0.0, 0)),
            ("published", machine(gain, 12_000_000)),
            ("last_occluder", machine(gain * 0.6, 18_000_000)),
        ]
        .into_iter()
        .collect()
    };
    let summary = |gain: f64| {
        let policies = runs(gain);
        let measured = |policy: &str| policies.get(policy).map(|run| &run.stats);
        let split = ["published", "last_occluder"].into_iter().filter_map(|policy| {
            let free = machine(gain * 1.1, 0).stats;
            Some((policy, Split::new([measured("off")?, &free, measured(policy)?], &published[0].totals)))
        });
        MachineSummary {
            fidelity: "Sampled(engine: Event, rate: 0.05)".into(),
            frames: frames.iter().copied().filter(|&frame| frame > 0).collect(),
            warmup: vec![0],
            split: split.collect(),
            reuse: Some(reuse()),
            policies: policies.clone(),
        }
    };
    let machines = [("small", summary(0.11)), ("desktop", summary(0.04))];
    let colors: Vec<Vec3> = (0..SIZE.pixels()).map(|pixel| Vec3::splat(pixel as f32 / SIZE.pixels() as f32)).collect();
    let render = pictures::render(SIZE, &colors);
    let classes: Vec<PixelVerdict> = (0..SIZE.pixels())
        .map(|pixel| match pixel % 1800 {
            777 => PixelVerdict::FalseDark,
            1111 => PixelVerdict::FalseLit,
            1500 => PixelVerdict::FalseDark,
            300 => PixelVerdict::Numeric,
            _ => PixelVerdict::Same,
        })
        .collect();
    let words: Vec<Option<u32>> = (0..SIZE.pixels() as u32).map(|pixel| (pixel > 500).then_some(pixel / 400)).collect();
    let shown = frames[0];
    let difference = pictures::difference(&render, &classes);
    let summary = Summary {
        schema: SCHEMA,
        experiment: "kitchen <sample>".into(),
        scene: SceneSummary { name: "kitchen".into(), triangles_static: 101_001, triangles_dynamic: 9_400, lights: 6 },
        frames: frames.to_vec(),
        resolution: SIZE,
        baseline: Some("off".into()),
        policies: policies.into_iter().collect(),
        machines: machines.into_iter().collect(),
        pictures: Vec::new(),
        provenance: [("umbrasim", "0.1.0"), ("input hash", "0123456789abcdef")]
            .map(|(name, value)| (name, value.to_owned()))
            .into_iter()
            .collect(),
        changed: vec!["machines.small.clock_mhz".into()],
        made: [("command line", "umbrasim run kitchen".to_owned())].into_iter().collect(),
        wall_seconds: [("trace", 12.5), ("replay small", 3.25)].into_iter().collect(),
        simulated_rays_per_wall_second: [("trace", 5.1e6), ("replay small", 20e6)].into_iter().collect(),
    };
    let config = "Experiment(\n    scene: Aff(\"kitchen.aff\"), // <a comment>\n)\n".into();
    let shown_policy = FileNamed { name: "published", file: "published".into() };
    let images = vec![
        (PictureInfo::new(PictureKind::Render, Some(&shown_policy), shown), render.clone()),
        (PictureInfo::new(PictureKind::Reference, None, shown), render),
        (PictureInfo::new(PictureKind::Difference { light: None }, Some(&shown_policy), shown), difference),
        (
            PictureInfo::new(PictureKind::Words { light: 0 }, Some(&shown_policy), shown),
            pictures::words(SIZE, &words, 0),
        ),
    ];
    (summary, config, images)
}

/// A sweep of two points.
pub(crate) fn sweep() -> SweepSummary {
    let (off, free, real) = (machine(0.0, 0).stats, machine(0.12, 0).stats, machine(0.1, 12_000_000).stats);
    let totals = frame(0, 0.2, 0).totals;
    let change = Change { field: "shadow_cache.place".into(), value: "L2".into() };
    let point = |changes: Vec<Change>| {
        let own = (!changes.is_empty()).then_some(&free);
        SweepPoint::new("small", "published", changes, [&off, &free, &real], &totals, own)
    };
    SweepSummary {
        experiment: "kitchen <sample>".into(),
        scene: "kitchen".into(),
        fidelity: Some("Event".into()),
        frames: vec![0, 16],
        warmup: vec![0],
        resolution: SIZE,
        own: vec![Own { machine: "small".into(), field: "shadow_cache.place".into(), value: "Own".into() }],
        points: vec![point(Vec::new()), point(vec![change])],
    }
}

/// A space of one machine under a policy: one design replayed, one predicted.
pub(crate) fn space() -> SpaceSummary {
    let change = |value: &str| vec![Change { field: "l2.bytes".into(), value: value.into() }];
    let design = |value: &str, replayed: bool| space::Design {
        machine: "small".into(),
        policy: "published".into(),
        changes: change(value),
        replayed,
        front: replayed,
        wrong_pixels: 3,
        cycles: 12_000.0,
        dram_bytes: 64_000.0,
        joules: Some(1e-4),
        half_widths: if replayed { BTreeMap::new() } else { [("cycles".to_owned(), 120.0)].into() },
        foreseen: if replayed {
            [("cycles".to_owned(), [11_900.0, 11_500.0, 12_300.0])].into()
        } else {
            BTreeMap::new()
        },
    };
    let errors = space::Errors::new(vec![(0.01, true), (0.04, false)]);
    SpaceSummary {
        experiment: "kitchen <sample>".into(),
        scene: "kitchen".into(),
        fidelity: "Event".into(),
        frames: vec![0, 16],
        resolution: SIZE,
        size: space::Size { combinations: 2.0, machines: 2, replays: 1, budget: 1, passes: 1, ..Default::default() },
        policies: vec![space::PolicyPixels { policy: "published".into(), pixels: 8000, wrong_pixels: 3 }],
        designs: vec![design("65536", true), design("131072", false)],
        sensitivities: vec![space::Sensitivity {
            machine: "small".into(),
            policy: "published".into(),
            field: "l2.bytes".into(),
            figure: "cycles".into(),
            least: ("131072".into(), -0.02),
            most: ("65536".into(), 0.03),
            share: 0.9,
        }],
        accuracy: [("cycles".to_owned(), space::Accuracy { foreseen: errors, left_out: errors })].into(),
    }
}
