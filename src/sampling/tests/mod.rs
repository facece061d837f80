//! Samples: what any machine and stream must give, how far windows by themselves are off, and how often intervals hold.

mod traffic;

use super::auto::auto;
use super::axis::Axis;
use super::estimate::{Population, Total, Window, estimate};
use super::figures::{Figure, MemoryLevel};
use super::findings::{Findings, TELLING};
use super::known::{Columns, Span};
use super::pass::Sampler;
use super::plan::{Cut, Plan};
use super::strata::Strata;
use crate::engine::tests::agreement::check_many;
use crate::engine::tests::frames::numbered;
use crate::engine::tests::random::{machines, streams};
use crate::engine::tests::recorded::{on, quickstart, shipped};
use crate::engine::tests::synthetic::{bvh_like, frame, header};
use crate::engine::tests::{items, num};
use crate::engine::{Level, Sampled};
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::replay::{Fidelity, Replay};
use crate::stats::{Accuracy, CacheCounts, MachineStats, TrafficClass};
use crate::stream::FrameInfo;

#[test]
fn a_sample_of_everything_is_everything() {
    let (header, stream) = quickstart();
    let machine = shipped("small");
    for engine in ["Profile", "Event"] {
        let whole = on(&machine, &header, engine, &stream);
        let sampled = on(&machine, &header, &format!("Sampled(engine: {engine}, rate: 1.0)"), &stream);
        assert_eq!(sampled.accuracy, Accuracy::Estimated { cycles: 0.0, l2_bytes: 0.0, dram_bytes: 0.0, rate: 1.0 });
        assert_eq!(MachineStats { accuracy: whole.accuracy, ..sampled }, whole);
    }
}

/// Whatever the machine: each window can be replayed by itself, and does what its rays ask for (which every replay
/// checks).
#[test]
fn any_machine_can_be_sampled() {
    check_many(
        100,
        || (machines(), streams()),
        |(machine, stream)| {
            let whole = on(&machine, &header(), "Event", &stream);
            let cut = Cut { pixels: 1, before: 2, own: 2, behind: 1 };
            let plan = Plan { strata: Strata { length: 2.0, seed: 0 }, draws: 0..2, cut };
            let header = header();
            let sampler = Sampler::new(Sampled::Event, &machine, &header);
            let pass = sampler.pass(&plan, 0, &mut items(stream)).map_err(|error| error.to_string())?;
            let sampled = Findings::of(&sampler, pass).map_err(|error| error.to_string())?.estimate(&machine, 2);
            if whole.rays == sampled.rays { Ok(()) } else { Err(format!("{} rays, {}", whole.rays, sampled.rays)) }
        },
    );
}

/// Who replays what, and in which order windows are done, is chance.
#[test]
fn a_sample_does_not_depend_on_the_number_of_threads() {
    let (header, stream) = quickstart();
    let machine = shipped("small");
    let by = |threads| {
        let cut = Cut { pixels: 32, before: 2, own: 2, behind: 1 };
        let mut plan = Plan { cut, ..Plan::new(0.25, &machine, 5) };
        let sampler = Sampler { threads, ..Sampler::new(Sampled::Event, &machine, &header) };
        let mut pass = sampler.pass(&plan, 4, &mut items(stream.clone())).unwrap();
        let mut kept = std::mem::take(&mut pass.kept);
        let mut findings = Findings::of(&sampler, pass).unwrap();
        plan.draws = 2..3;
        findings.add(sampler.replay(kept.take(&plan.draws).unwrap()).unwrap());
        // What was kept is what another pass would measure.
        let again = sampler.pass(&plan, 4, &mut items(stream.clone())).unwrap();
        let mut passed =
            Findings::of(&sampler, sampler.pass(&Plan { draws: 0..2, ..plan }, 4, &mut items(stream.clone())).unwrap())
                .unwrap();
        passed.add(again.found);
        assert!(passed == findings);
        findings
    };
    let one = by(1);
    assert!(one.measured.len() > 20, "{}", one.measured.len());
    assert!(by(3) == one && by(8) == one);
}

/// A sample of nothing is refused, not taken for a stream in which nothing happens.
#[test]
fn a_sample_without_windows_is_refused() {
    let (header, stream) = quickstart();
    let fidelity = "Sampled(engine: Event, rate: 0.0001)".parse().unwrap();
    let machine = shipped("desktop");
    let replay = Replay::new(&machine, &header).unwrap().fidelity::<Fidelity>(fidelity);
    let error = replay.run(&stream).unwrap_err().to_string();
    assert_eq!(
        error,
        "none of the stream's 4 windows of 8192 pixels is in the sample of 0.0001 of them: a higher `rate` is needed"
    );
}

/// All lines are fetched at the beginning, where caches hold everything: most windows move none, and the tags know
/// those of the others.
#[test]
fn a_sample_knows_what_its_windows_do_not_move() {
    let (header, stream) = quickstart();
    let machine = shipped("desktop");
    let moved = |rung| on(&machine, &header, rung, &stream).moved("dram").0;
    let (whole, sampled) = (moved("Event"), moved("Sampled(engine: Event, rate: 0.3)"));
    assert!((sampled as f64 / whole as f64 - 1.0).abs() < 0.01, "{sampled} {whole}");
}

/// The longer the more lines an L1 has, behind the more pixels the more rays there is room for.
#[test]
fn windows_are_as_long_as_a_machine_asks_for() {
    let cuts = ["small", "desktop", "tni_engine"].map(|name| Cut::new(&shipped(name)));
    let cut = |pixels, before, own| Cut { pixels, before, own, behind: 1 };
    assert_eq!(cuts, [cut(128, 8, 4), cut(1024, 2, 8), cut(1920, 3, 4)]);
}

/// As many points more as the width asks for, but no more than double; none where that would be too many in the end.
#[test]
fn a_sample_goes_on_by_no_more_than_double() {
    let plan = Plan { draws: 0..8, ..PLAN };
    let next = |share, most| plan.next_draws(share, 0.02, most);
    assert_eq!(next(None, 100), Some(16), "nothing is known of the width");
    assert_eq!(next(Some(0.0201), 100), Some(11));
    assert_eq!(next(Some(0.06), 100), Some(16), "not 90");
    assert_eq!(next(Some(0.06), 89), None);
    assert_eq!(next(Some(0.001), 100), Some(9), "another figure may be the wider one");
}

/// All windows together take about what the whole stream does: what is in flight at their ends is not lost, and not
/// counted twice.
#[test]
fn windows_by_themselves_add_up() {
    let (header, stream) = quickstart();
    for name in ["small", "desktop"] {
        let machine = shipped(name);
        for engine in [Sampled::Event, Sampled::Profile] {
            let whole = on(&machine, &header, &Level::from(engine).to_string(), &stream);
            // So many points that all but the smallest windows have some.
            let plan = Plan { draws: 0..200, ..Plan::new(1.0, &machine, 0) };
            let sampler = Sampler::new(engine, &machine, &header);
            let found = Findings::of(&sampler, sampler.pass(&plan, 0, &mut items(stream.clone())).unwrap()).unwrap();
            let sampled = found.estimate(&machine, 200);
            let off = |sampled: u64, whole: u64| sampled as f64 / whole as f64 - 1.0;
            let moved = |stats: &MachineStats, level| stats.moved(level).0;
            let all = [
                off(sampled.cycles.0, whole.cycles.0),
                off(moved(&sampled, "l2"), moved(&whole, "l2")),
                off(moved(&sampled, "dram"), moved(&whole, "dram")),
                off(moved(&sampled, "l1_traversal"), moved(&whole, "l1_traversal")),
            ];
            println!("{name}, {engine:?}: {all:.4?} of cycles, L2 bytes, DRAM bytes, L1 bytes");
            assert_eq!(sampled.rays, whole.rays);
            assert!(all.iter().all(|off| off.abs() < 0.02), "{name}, {engine:?}: {all:?}");
        }
    }
}

#[test]
fn auto_is_as_close_as_was_asked_and_says_what_it_took() {
    let (header, stream) = quickstart();
    for name in ["small", "desktop"] {
        let machine = shipped(name);
        let event = on(&machine, &header, "Event", &stream);
        for (target, least_taken) in [("0.000001", "Event"), ("0.05", "")] {
            let found = auto(&machine, target.parse().unwrap(), &header, &stream).unwrap();
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
    }
}

/// All windows of the recorded stream on `small`.
struct Census {
    windows: Vec<Window>,
    /// What is known of them, by span.
    known: [Columns; Span::ALL.len()],
}

fn census() -> Census {
    let (header, stream) = quickstart();
    let mut machine = shipped("small");
    // The stream is short: a small pool makes for many windows.
    machine.dispatcher.rays = num(16);
    let plan = Plan { strata: Strata { length: 2.0, seed: 0 }, draws: 0..1000, cut: CUT };
    let sampler = Sampler::new(Sampled::Event, &machine, &header);
    let mut windows = Findings::of(&sampler, sampler.pass(&plan, 0, &mut items(stream)).unwrap()).unwrap().measured;
    let mut sums = Span::ALL.map(|_| Population::default());
    for window in &mut windows {
        // Groups overlap: here each counts as it is.
        window.operations = window.span(Span::Group).known[0];
        sums.iter_mut().zip(&window.spans).for_each(|(sum, part)| sum.add(&part.known));
    }
    Census { windows, known: sums.map(|sum| sum.known) }
}

impl Census {
    /// The windows with points that a pass and those before it measure, and where the axis ends.
    fn drawn(&self, draws: usize, seed: u64) -> (Vec<Window>, f64) {
        let mut axis = Axis::new(Strata { seed, ..PLAN.strata }, draws);
        let mut drawn = Vec::new();
        for window in &self.windows {
            let (size, hits) = axis.next(&window.span(Span::Own).known);
            if !hits.is_empty() {
                drawn.push(Window { size, hits, ..window.clone() });
            }
        }
        (drawn, axis.end())
    }

    /// The estimate of a figure from these windows, and the truth.
    fn found(&self, (figure, span): &(Figure, Span), draws: usize, seed: u64) -> (Total, f64) {
        let (drawn, axis) = self.drawn(draws, seed);
        let (strata, windows) = (Strata { seed, ..PLAN.strata }, self.windows.len());
        let population = Population { strata, axis, windows, known: self.known[*span as usize] };
        let total = estimate(&population, &drawn, draws, 64)[figure];
        (total, self.windows.iter().map(|window| window.span(*span).figures[figure]).sum())
    }
}

const CUT: Cut = Cut { pixels: 16, before: 1, own: 2, behind: 1 };
const PLAN: Plan = Plan { strata: Strata { length: 20.0, seed: 0 }, draws: 0..2, cut: CUT };

/// The truth lies within the 95 % intervals in 93 to 97 % of 1000 samples of windows that were all measured.
#[test]
fn intervals_cover_the_truth_as_often_as_they_say() {
    let census = census();
    assert!(census.windows.len() > 200, "{}", census.windows.len());
    let names = [
        (Figure::Cycles, Span::Inside),
        (Figure::DramBytes, Span::Own),
        (Figure::L2Bytes, Span::Own),
        (
            Figure::Cache(MemoryLevel::L1(Kind::Traversal), TrafficClass::Node, CacheCounts::place("misses")),
            Span::Inside,
        ),
    ];
    let mut covered = [0; 4];
    let mut widths = [0.0; 4];
    for seed in 0..1000 {
        for (at, name) in names.iter().enumerate() {
            let (Total { total, half_width }, truth) = census.found(name, 2, seed);
            covered[at] += u32::from((total - truth).abs() <= half_width.unwrap());
            widths[at] += half_width.unwrap() / truth / 1000.0;
        }
    }
    println!("{names:?}: {covered:?} of 1000, mean half widths {widths:.3?}");
    for ((name, _), covered) in names.into_iter().zip(covered) {
        assert!((930..=970).contains(&covered), "{name:?}: {covered} of 1000");
    }
}

/// The same where sampling goes on until the interval is within a target: windows at most double from look to look, and
/// whoever stops does so since the interval came out narrow, which it may have done by chance.
#[test]
fn intervals_cover_the_truth_when_sampling_stops_at_a_target() {
    let census = census();
    for target in [0.02, 0.03, 0.05, 0.1] {
        let (mut covered, mut stopped) = (0, 0);
        for seed in 0..500 {
            // As sampling to a target goes on: at most half of all windows, then everything is replayed.
            let mut draws = 2;
            let first = loop {
                let found = census.found(&(Figure::Cycles, Span::Inside), draws, seed);
                let share = found.0.share().unwrap();
                let tells = census.drawn(draws, seed).0.len() >= TELLING;
                if share <= target && tells {
                    break Some(found);
                }
                let plan = Plan { draws: 0..draws, ..PLAN };
                let Some(next) = plan.next_draws(tells.then_some(share), target, (PLAN.strata.length / 2.0) as usize)
                else {
                    break None;
                };
                draws = next;
            };
            if let Some((Total { total, half_width }, truth)) = first {
                stopped += 1;
                covered += u32::from((total - truth).abs() <= half_width.unwrap());
            }
        }
        println!("target {target}: {covered} of {stopped} that stopped");
        assert!(f64::from(covered) >= 0.93 * f64::from(stopped), "target {target}: {covered} of {stopped}");
    }
}

#[test]
fn a_sample_leaves_warm_up_frames_out() {
    let machine = MachineSpec::default();
    let rays = bvh_like(3, 4096, 9, 1);
    let frames = [0, 1].map(|number| frame(FrameInfo { number, ..FrameInfo::default() }, &rays, &[], 1024));
    let (header, stream) = numbered(&frames.concat(), 1);
    let truth = on(&machine, &header, "Event", &stream);
    let estimate = on(&machine, &header, "Sampled(engine: Event, rate: 0.5)", &stream);
    assert_eq!(estimate.rays, truth.rays);
    let error = estimate.cycles.0 as f64 / truth.cycles.0 as f64 - 1.0;
    assert!(error.abs() < 0.1, "{error}");
    assert!(estimate.frames.is_empty());
}
