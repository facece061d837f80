//! Samples: properties that hold for any machine and stream, errors of windows by themselves, and coverage of
//! intervals.

mod auto;
mod beside;
mod coverage;
mod tags;
mod together;
mod traffic;

use super::findings::Findings;
use super::pass::{Member, Pass, Sampler};
use super::plan::{Cut, Lengths, Plan};
use super::strata::Strata;
use crate::engine::tests::agreement::check_many;
use crate::engine::tests::frames::numbered;
use crate::engine::tests::random::{machines, streams};
use crate::engine::tests::recorded::{on, quickstart, shipped};
use crate::engine::tests::synthetic::{Numbers, SyntheticRay, bvh_like, frame, header, nodes};
use crate::engine::tests::{items, num};
use crate::engine::{Level, Sampled};
use crate::machine::MachineSpec;
use crate::quantity::Resolution;
use crate::ranged::Size;
use crate::replay::{Fidelity, Replay};
use crate::stats::{Accuracy, MachineStats};
use crate::stream::{Decision, FrameInfo, Header, Item};

/// A pass for one machine.
fn pass(sampler: &Sampler<'_>, machine: &MachineSpec, plan: &Plan, keep: usize, stream: &[Item]) -> Pass {
    let member = [Member { machine, plan: plan.clone() }];
    sampler.pass(&member, keep, &mut items(stream.to_vec())).unwrap().remove(0).unwrap()
}

#[test]
fn a_sample_of_everything_is_everything() {
    let (header, stream) = quickstart();
    let machine = shipped("small");
    let all = Accuracy::Estimated { cycles: 0.0, l2_bytes: 0.0, dram_bytes: 0.0, rate: 1.0 };
    // The windows of a sample by `Profile` do not tell how far that is from `Event`.
    for (engine, accuracy) in [("Profile", Accuracy::Unknown), ("Event", all)] {
        let whole = on(&machine, &header, engine, &stream);
        let sampled = on(&machine, &header, &format!("Sampled(engine: {engine}, rate: 1.0)"), &stream);
        assert_eq!(sampled.accuracy, accuracy);
        assert!(accuracy != Accuracy::Unknown || sampled.half_widths.is_empty() && sampled.residuals.is_none());
        assert_eq!(MachineStats { accuracy: whole.accuracy, ..sampled }, whole);
    }
}

/// On any machine, each window can be replayed by itself, and performs its rays' requests (every replay checks this).
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
            let sampler = Sampler::new(Sampled::Event, &header);
            let member = [Member { machine: &machine, plan: plan.clone() }];
            let pass = sampler.pass(&member, 0, &mut items(stream)).and_then(|mut passes| passes.remove(0));
            let pass = pass.map_err(|error| error.to_string())?;
            let sampled = Findings::of(&sampler, &machine, &plan.cut, pass).estimate(&machine, 2);
            if whole.rays == sampled.rays { Ok(()) } else { Err(format!("{} rays, {}", whole.rays, sampled.rays)) }
        },
    );
}

/// The order in which threads complete windows varies.
#[test]
fn a_sample_does_not_depend_on_the_number_of_threads() {
    let (header, stream) = quickstart();
    let machine = shipped("small");
    let by = |threads| {
        let cut = Cut { pixels: 32, before: 2, own: 2, behind: 1 };
        let mut plan = Plan::new(0.25, cut, 5);
        let sampler = Sampler { threads, ..Sampler::new(Sampled::Event, &header) };
        let mut pass = pass(&sampler, &machine, &plan, 4, &stream);
        let mut cached = std::mem::take(&mut pass.cached);
        let mut findings = Findings::of(&sampler, &machine, &cut, pass);
        plan.draws = 2..3;
        let jobs = cached.take(&plan.draws).unwrap().into_iter().map(|job| (0, job));
        let member = [Member { machine: &machine, plan: plan.clone() }];
        findings.add(sampler.replay(&member, jobs.collect()).remove(0).unwrap());
        // Kept jobs give the same results as another pass.
        let again = self::pass(&sampler, &machine, &plan, 4, &stream);
        let first = self::pass(&sampler, &machine, &Plan { draws: 0..2, ..plan }, 4, &stream);
        let mut passed = Findings::of(&sampler, &machine, &cut, first);
        passed.add(again.found);
        assert!(passed == findings);
        findings
    };
    let one = by(1);
    assert!(one.measured.len() > 20, "{}", one.measured.len());
    assert!(by(3) == one && by(8) == one);
}

/// A sample that is too small is refused, so that no figure of it is shown anywhere.
#[test]
fn a_sample_of_few_windows_is_refused() {
    let (header, stream) = quickstart();
    let fidelity = "Sampled(engine: Event, rate: 0.1)".parse().unwrap();
    let (machine, small) = (shipped("desktop"), shipped("small"));
    let replay = Replay::new(&machine, &header).unwrap().fidelity::<Fidelity>(fidelity);
    let error = replay.run(&stream).unwrap_err().to_string();
    assert_eq!(
        error,
        "a sample of 0.1 of the stream's 4 windows of 4096 pixels is too small to tell anything: take Auto or Event"
    );
    let replay = Replay::new(&small, &header).unwrap().fidelity::<Fidelity>(fidelity);
    let error = replay.run(&stream).unwrap_err().to_string();
    assert!(error.ends_with("take a `rate` of 0.445 or more, Auto, or Event"), "{error}");
}

/// All lines are fetched at the beginning, since the caches hold everything. Most windows move none; the tags know the
/// lines of the others.
#[test]
fn a_sample_knows_what_its_windows_do_not_move() {
    let (header, stream) = quickstart();
    let mut machine = shipped("small");
    machine.l2 = shipped("desktop").l2;
    let moved = |rung| on(&machine, &header, rung, &stream).moved("dram").0;
    let (whole, sampled) = (moved("Event"), moved("Sampled(engine: Event, rate: 0.6)"));
    assert!((sampled as f64 / whole as f64 - 1.0).abs() < 0.01, "{sampled} {whole}");
}

/// Pieces grow with the pool, lead-ins with the room for rays.
#[test]
fn windows_are_as_long_as_a_machine_asks_for() {
    let cuts = ["small", "desktop", "tni_engine"].map(|name| Cut::new(&shipped(name)));
    let cut = |pixels, before, own| Cut { pixels, before, own, behind: 1 };
    assert_eq!(cuts, [cut(128, 6, 4), cut(1024, 5, 4), cut(1920, 5, 4)]);
}

/// The width determines how many points are added, at most to double; none if the final number would be too large.
#[test]
fn a_sample_goes_on_by_no_more_than_double() {
    let cut = Cut { pixels: 16, before: 1, own: 2, behind: 1 };
    let plan = Plan { draws: 0..8, ..Plan::new(0.1, cut, 0) };
    let next = |points, share, most| plan.next_draws(points, share, 0.02, most);
    assert_eq!(next(12, 0.3, 100), Some(16), "the width tells little yet");
    assert_eq!(next(44, 0.3, 100), Some(9), "four points lack");
    assert_eq!(next(48, 0.0201, 100), Some(11));
    assert_eq!(next(48, 0.06, 100), Some(16), "not 90");
    assert_eq!(next(48, 0.06, 89), Some(16), "widths of few points shrink faster");
    assert_eq!((next(48, 0.06, 44), next(48, 0.03, 15)), (None, None));
    assert_eq!(next(96, 0.06, 89), None);
    assert_eq!(next(48, 0.001, 100), Some(9), "another figure may be the wider one");
}

/// The needs of the most demanding machine suffice for all.
#[test]
fn a_common_cut_is_as_long_as_the_longest() {
    let [small, desktop] = ["small", "desktop"].map(|name| Lengths::new(&shipped(name)));
    let cut = |all: &[Lengths]| Cut::common(all.iter().copied());
    assert_eq!(cut(&[small]), Some(Cut::new(&shipped("small"))));
    assert_eq!(cut(&[small, desktop]), cut(&[desktop]));
    assert_eq!(cut(&[small, desktop]), cut(&[desktop, small]));
    let mut few_entries = shipped("small");
    few_entries.dispatcher.rays = num(48);
    let least = Cut { pixels: 48, before: 16, own: 11, behind: 1 };
    assert_eq!(cut(&[Lengths::new(&few_entries)]), Some(least), "768 and 512 pixels at least");
    assert_eq!(Cut::common([]), None);
}

/// All windows together cost about as much as the whole stream: rays in flight at their ends are neither lost nor
/// counted twice.
#[test]
fn windows_by_themselves_add_up() {
    let (header, stream) = quickstart();
    // Windows keep their length, however large an L1 is.
    let mut large_l1 = shipped("small");
    large_l1.traversal.cache.bytes = Size::new(65536).unwrap();
    let machines = [("small", shipped("small")), ("desktop", shipped("desktop")), ("a large L1", large_l1)];
    for (name, machine) in machines {
        for engine in [Sampled::Event, Sampled::Profile] {
            let whole = on(&machine, &header, &Level::from(engine).to_string(), &stream);
            // Enough points that all but the smallest windows have some.
            let plan = Plan { draws: 0..200, ..Plan::new(1.0, Cut::new(&machine), 0) };
            let sampler = Sampler::new(engine, &header);
            let found = Findings::of(&sampler, &machine, &plan.cut, pass(&sampler, &machine, &plan, 0, &stream));
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

/// Pixels of a row, and nodes of a tree, in [`wide_picture`].
const WIDTH: u32 = 1024;
const TREE: u32 = 1 << 17;

/// A wide picture whose rays walk quadtrees of nodes, down to cells of 8 pixels or more. Neighbouring pixels share
/// nodes, in their row and in the rows around it. Paths differ in length, so that no unit keeps to its columns of the
/// picture.
fn wide_picture(rows: u32) -> (Header, Vec<Item>) {
    let mut numbers = Numbers(7);
    let walk = |tree: u32, (x, y): (u32, u32), finest: u32| {
        let row = |level: u32| tree * TREE + (1 << 16 >> level) + (y >> level) * (WIDTH >> level);
        nodes((finest..=8).rev().map(|level| row(level) + (x >> level)))
    };
    let mut rays = Vec::new();
    for (x, y) in (0..rows).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
        let mut path = walk(0, (x, y), 3);
        for _ in 0..numbers.below(4) {
            let finest = 3 + numbers.below(6);
            path.extend(walk(0, ((x + numbers.below(32)) % WIDTH, (y + numbers.below(8)) % rows), finest));
        }
        rays.push(SyntheticRay::primary(path));
        for distance in 1..1 + numbers.below(3) {
            let there = ((x + numbers.below(16)) % WIDTH, (y + numbers.below(4)) % rows);
            let path = walk(1, there, 3 + numbers.below(3));
            rays.push(SyntheticRay::shadow(distance, Decision::Trace, path));
        }
    }
    let header = Header { static_nodes: 2 * TREE, resolution: Resolution { width: WIDTH, height: rows }, ..header() };
    (header, frame(FrameInfo::default(), &rays, &[], 4096))
}

/// A lead-in replaces what the tags left in the L1s. Wide pictures need the longest: their neighbours share most lines.
/// Two pieces, which fill pool and FIFOs, are too few.
#[test]
fn windows_of_wide_pictures_add_up() {
    let (header, stream) = wide_picture(128);
    let machine = shipped("desktop");
    let whole = on(&machine, &header, "Event", &stream);
    let l2_off_by = |before: usize| {
        let cut = Cut { before, ..Cut::new(&machine) };
        let plan = Plan { draws: 0..200, ..Plan::new(1.0, cut, 0) };
        let sampler = Sampler::new(Sampled::Event, &header);
        let found = Findings::of(&sampler, &machine, &plan.cut, pass(&sampler, &machine, &plan, 0, &stream));
        let sampled = found.estimate(&machine, 200);
        sampled.moved_l2().0 as f64 / whole.moved_l2().0 as f64 - 1.0
    };
    let [own, two] = [Cut::new(&machine).before, 2].map(l2_off_by);
    println!("L2 bytes: {own:.4}, and {two:.4} behind two pieces");
    assert!(own.abs() < 0.015, "{own}");
    assert!(two < -0.03, "two pieces do as well: {two}");
}

#[test]
fn a_sample_leaves_warm_up_frames_out() {
    let machine = MachineSpec::default();
    let rays = bvh_like(3, 8192, 9, 1);
    let frames = [0, 1].map(|number| frame(FrameInfo { number, ..FrameInfo::default() }, &rays, &[], 1024));
    let (header, stream) = numbered(&frames.concat(), 1);
    let header = Header { resolution: Resolution { width: 128, height: 64 }, ..header };
    let truth = on(&machine, &header, "Event", &stream);
    let estimate = on(&machine, &header, "Sampled(engine: Event, rate: 0.5)", &stream);
    assert_eq!(estimate.rays, truth.rays);
    let error = estimate.cycles.0 as f64 / truth.cycles.0 as f64 - 1.0;
    assert!(error.abs() < 0.1, "{error}");
    assert!(estimate.frames.is_empty());
}
